"""Figures as SVG text, the same from run to run: no dates, no random identifiers."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from oblique_impact.renders.style import figure_style
from oblique_impact.validation.report.document import Picture

#: widths (inches): legible at half a page's width, and at the whole width
HALF, FULL = 5.6, 9.2

_PIXELS_PER_INCH = 115


@contextmanager
def new_figure(width: float = FULL, height: float = 3.4) -> Iterator[Figure]:
    """Make a figure in the project's style; plot and call `to_svg` inside of the block."""
    with figure_style():
        yield Figure(figsize=(width, height), layout="constrained")


@dataclass
class Drawn(Picture):
    """A picture and its figure, for those who draw into it."""

    figure: Any = None


@contextmanager
def picture(
    caption: str, width: float = FULL, height: float = 3.4, alternative: str = "", half: bool = False
) -> Iterator[Drawn]:
    """Make a picture: draw on its `figure` in the block; behind the block it is a block of a report."""
    with new_figure(width, height) as figure:
        drawn = Drawn("", caption, alternative or caption, half, figure=figure)
        yield drawn
        drawn.svg = to_svg(figure)


def to_svg(figure: Figure) -> str:
    """Return the figure as an <svg> element that scales with the page."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    # the size in points gives way to the page's, up to a size at which all figures have the same letters
    opening = re.sub(r' (?:width|height)="[^"]*"', "", text[: text.index(">")])
    limit = round(_PIXELS_PER_INCH * figure.get_size_inches()[0])
    return f'{opening} style="max-width: {limit}px"{text[text.index(">") :]}'
