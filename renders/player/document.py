"""From a story to the file: style, scripts and data in one page that needs nothing besides itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from oblique_impact.errors import InputError
from renders.files import save_whole
from renders.metadata import made_by
from renders.player.payload import payload
from renders.story import Story

MAX_STEPS = 20_000
DEFAULT_TITLE = "Oblique impact of a flexible beam on a slope"

#: scripts of the page in the order in which they build on each other
SCRIPTS = ("format", "run", "canvas", "beam", "scene", "inset", "envelope", "charts", "controls")


def write_player(story: Story, out: Path, *, steps: int = 1800, title: str = DEFAULT_TITLE) -> Path:
    """Write the page of the first run of `story` to the file `out`, whole or not at all; returns the file.

    Parameters
    ----------
    story : Story
        Its style gives the theme and the deformation factor with which the page opens; the page has switches.
    out : Path
        An HTML file; its folder is created.
    steps : int
        About the number of frames besides the samples at events, from 2 to `MAX_STEPS`.
    title : str
        Heading of the page.

    Raises
    ------
    InputError
        With one line, if an argument is not allowed or the file cannot be written.
    """
    if not 2 <= steps <= MAX_STEPS:
        raise InputError(f"steps = {steps}: should be from 2 to {MAX_STEPS}")
    content = payload(story, steps)
    loader = PackageLoader("renders.player", "page")
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)

    def source(name: str) -> Markup:
        return Markup(loader.get_source(environment, name)[0])

    page = environment.get_template("player.html.j2").render(
        title=title,
        made_by=made_by(story.histories),
        theme=story.style.theme,
        facts=content.facts,
        style=source("player.css"),
        script=Markup("\n").join(source(f"{name}.js") for name in SCRIPTS),
        facts_json=_embedded(content.facts),
        arrays_json=_embedded(content.arrays),
    )
    return save_whole(out, lambda part: part.write_text(page, encoding="utf-8"))


def _embedded(value: Any) -> Markup:
    """JSON that cannot end the element it stands in."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c"))
