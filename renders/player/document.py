"""The page of a run: markup, style, scripts and data in one file that needs nothing besides itself."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import save_whole
from oblique_impact.history.history import History
from oblique_impact.renders.charts import film_clock
from oblique_impact.renders.picture_files import made_by, warnings_of
from oblique_impact.renders.player.content import SPEEDS, content_of
from oblique_impact.renders.player.page_charts import variables
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import DARK, LIGHT
from oblique_impact.renders.title import model_words

#: scripts of the page, which build on each other in this order
SCRIPTS = ("run", "scene", "controls")
_LOADER = PackageLoader("oblique_impact.renders.player", "page")
_PAGE = Environment(loader=_LOADER, autoescape=True, undefined=StrictUndefined, trim_blocks=True)


def write_player(story: Story, out: Path) -> Path:
    """Write the page of the runs of `story` to the file `out`, whole or not at all; returns the file.

    The style of the story gives the theme and the deformation factor with which the page opens; the page has
    switches; names of the story are for its title.  Several runs are side by side, at one time, in pictures of one
    scale.

    Raises InputError for the theme of print, or a file that cannot be written.
    """
    if story.style.theme == "print":
        raise InputError("--theme print: of a page should be one of light, dark, auto")
    contents, history = [content_of(story, n) for n in range(len(story.geometries))], story.histories[0]
    content, several = contents[0], len(contents) > 1
    for name in content.facts["factors"]:  # of one scale
        bounds = np.array([one.facts["factors"][name]["bounds"] for one in contents])
        (left, _, low, _), (_, right, _, high) = bounds.min(axis=0).tolist(), bounds.max(axis=0).tolist()
        for one in contents:
            one.facts["factors"][name]["bounds"] = [left, right, low, high]
    names = story.names if several else ("",)
    page = _PAGE.get_template("player.html.j2").render(
        content=content,
        made_by=made_by(story.histories),
        style=story.style,
        themes={"light": variables(LIGHT), "dark": variables(DARK)},
        title=story.heading if story.title else ": ".join([" and ".join(names), *story.beam[1:2]]),
        several=several,
        runs=[
            {
                "name": name,
                "model": model_words(one.scenario, one.clamped),
                "outcome": _why_it_stopped(one.history),
            }
            for name, one in zip(names, story.geometries, strict=True)
        ],
        warnings=warnings_of(story.histories),
        all_events=len(history.events),
        speeds=SPEEDS,
        factor=f"{story.factor:g}",
        time_label=film_clock(story.time_map, 1.0).label,
        at_tip=content.facts["touch"] == len(content.facts["stations"]) - 1,
        at_point=story.geometries[0].at_point,
        scripts=Markup("\n").join(Markup(_source(f"{name}.js")) for name in SCRIPTS),
        css=Markup(_source("player.css")),
        # so that nothing can end the element it stands in
        data=[
            (Markup(facts.replace("<", "\\u003c")), arrays) for facts, arrays in (one.packed() for one in contents)
        ],
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
