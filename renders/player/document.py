"""From a story to the file: style, scripts and data in one page that needs nothing besides itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from oblique_impact.renders.files import save_whole
from oblique_impact.renders.metadata import made_by
from oblique_impact.renders.player.payload import payload
from oblique_impact.renders.story import Story

FRAMES = 1500  # about, besides the samples at events

#: scripts of the page in the order in which they build on each other: what is drawn, and what the reader does
DRAWING = ("format", "run", "results", "canvas", "view", "beam", "scene", "inset", "envelope", "charts")
ACTING = ("show", "status", "lists", "strip", "zoom", "embed", "controls")


def write_player(story: Story, out: Path) -> Path:
    """Write the page of the first run of `story` to the file `out`, whole or not at all; returns the file.

    The style of the story gives the theme and the deformation factor with which the page opens; the page has
    switches; a name of the story is for its title.  Raises InputError with one line if the file cannot be written.
    """
    content = payload(story, FRAMES)
    loader = PackageLoader("oblique_impact.renders.player", "page")
    environment = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True)

    def source(name: str) -> Markup:
        return Markup(loader.get_source(environment, name)[0])

    page = environment.get_template("player.html.j2").render(
        made_by=made_by(story.histories),
        theme=story.style.theme,
        facts=content.facts,
        style=source("player.css"),
        script=Markup("\n").join(source(f"{name}.js") for name in (*DRAWING, *ACTING)),
        facts_json=_embedded(content.facts),
        arrays_json=_embedded(content.arrays),
    )
    return save_whole(out, lambda part: part.write_text(page, encoding="utf-8"))


def _embedded(value: Any) -> Markup:
    """JSON that cannot end the element it stands in."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c"))
