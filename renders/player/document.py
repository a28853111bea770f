"""The page of a run: markup, style, scripts and data in one file that needs nothing besides itself."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import save_whole
from oblique_impact.history.history import History
from oblique_impact.renders.charts import time_label
from oblique_impact.renders.files import made_by, warnings_of
from oblique_impact.renders.player.charts import variables
from oblique_impact.renders.player.content import SPEEDS, content_of
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import DARK, LIGHT
from oblique_impact.renders.title import model_words

#: scripts of the page, which build on each other in this order
SCRIPTS = ("run", "scene", "controls")
_LOADER = PackageLoader("oblique_impact.renders.player", "page")
_PAGE = Environment(loader=_LOADER, autoescape=True, undefined=StrictUndefined, trim_blocks=True)


def write_player(story: Story, out: Path) -> Path:
    """Write the page of the first run of `story` to the file `out`, whole or not at all; returns the file.

    The style of the story gives the theme and the deformation factor with which the page opens; the page has
    switches; a name of the story is for its title.

    Raises InputError for several runs, the theme of print, or a file that cannot be written.
    """
    if len(story.geometries) > 1:
        raise InputError(f"HISTORY: {len(story.geometries)} given: a page shows one")
    if story.style.theme == "print":
        raise InputError("--theme print: of a page should be one of light, dark, auto")
    content, history = content_of(story), story.histories[0]
    facts, arrays = content.packed()
    page = _PAGE.get_template("player.html.j2").render(
        content=content,
        made_by=made_by(story.histories),
        style=story.style,
        themes={"light": variables(LIGHT), "dark": variables(DARK)},
        title=story.heading,
        model=model_words(story.geometries[0].scenario),
        outcome=_why_it_stopped(history),
        warnings=warnings_of([history]),
        all_events=len(history.events),
        speeds=SPEEDS,
        factor=f"{story.factor:g}",
        time_label=time_label(story.time_map),
        at_tip=content.facts["touch"] == len(content.facts["stations"]) - 1,
        anywhere=story.geometries[0].anywhere,
        scripts=Markup("\n").join(Markup(_source(f"{name}.js")) for name in SCRIPTS),
        css=Markup(_source("player.css")),
        data=Markup(facts.replace("<", "\\u003c")),  # so that it cannot end the element it stands in
        arrays=arrays,
    )
    return save_whole(out, lambda part: part.write_text(page, encoding="utf-8"))


def _source(name: str) -> str:
    """Return a file of the page as it is."""
    return _LOADER.get_source(_PAGE, name)[0]


def _why_it_stopped(history: History) -> str:
    """Return what ended a run before its end time, with its numbers where they are known; nothing of others."""
    if history.outcome is Outcome.COMPLETED:
        return ""
    return str(history.summary.get("message") or history.outcome.sentence)
