"""From a history to the file: style, scripts and data in one page that needs nothing besides itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, write_text
from oblique_impact.history.history import History
from oblique_impact.scenario.messages import one_of
from renders.metadata import made_by
from renders.player.payload import payload

THEMES = ("light", "dark", "auto")
MAX_STEPS = 20_000
DEFAULT_TITLE = "Oblique impact of a flexible beam on a slope"

#: in the order in which they build on each other
SCRIPTS = (
    "format.js",
    "run.js",
    "canvas.js",
    "beam.js",
    "scene.js",
    "inset.js",
    "envelope.js",
    "charts.js",
    "controls.js",
)


def write_player(
    history: History,
    out: Path,
    *,
    factor: float | None = None,
    steps: int = 1800,
    theme: str = "light",
    title: str | None = None,
) -> Path:
    """Write the page of `history` to the file `out`, whole or not at all; returns the file.

    Parameters
    ----------
    history : History
        Of a beam.
    out : Path
        An HTML file; its folder is created.
    factor : float, optional
        Deformation factor with which the page opens; chosen from the run if None.
    steps : int
        About the number of frames besides the samples at events, from 2 to `MAX_STEPS`.
    theme : str
        ``light``, ``dark``, or ``auto``: as the reader's system is set.  The page has a switch.
    title : str, optional
        Heading of the page.

    Raises
    ------
    InputError
        With one line, if an argument is not allowed, the history is not one of a beam, or the file cannot
        be written.
    """
    page = player_page(history, factor=factor, steps=steps, theme=theme, title=title)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_text(out, page)
    except OSError as error:
        raise cannot_write(out, error) from None
    return out


def player_page(history: History, *, factor: float | None, steps: int, theme: str, title: str | None) -> str:
    """Return the page as text; see `write_player`."""
    if theme not in THEMES:
        raise InputError(f"theme = {theme!r}: {one_of(theme, THEMES)}")
    if not 2 <= steps <= MAX_STEPS:
        raise InputError(f"steps = {steps}: should be from 2 to {MAX_STEPS}")
    content = payload(history, factor, steps)
    environment = Environment(
        loader=PackageLoader("renders.player", "page"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template("player.html.j2").render(
        title=title or DEFAULT_TITLE,
        made_by=made_by([history]),
        theme=theme,
        facts=content.facts,
        style=_source(environment, "player.css"),
        script=Markup("\n").join(_source(environment, name) for name in SCRIPTS),
        facts_json=_embedded(content.facts),
        arrays_json=_embedded(content.arrays),
    )


def _source(environment: Environment, name: str) -> Markup:
    """Return a style sheet or a script of the package as it stands."""
    loader = environment.loader
    assert loader is not None
    return Markup(loader.get_source(environment, name)[0])


def _embedded(value: Any) -> Markup:
    """JSON that cannot end the element it stands in."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c"))
