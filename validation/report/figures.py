"""Figures as SVG text, the same from run to run: no dates, no random identifiers."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager

from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from oblique_impact.renders.style import figure_style

#: widths (inches): legible at half a page's width, and at the whole width
HALF, FULL = 5.6, 9.2

_PIXELS_PER_INCH = 115


@contextmanager
def new_figure(width: float = FULL, height: float = 3.4) -> Iterator[Figure]:
    """Make a figure in the project's style; plot and call `to_svg` inside of the block."""
    with figure_style():
        yield Figure(figsize=(width, height), layout="constrained")


def to_svg(figure: Figure) -> str:
    """Return the figure as an <svg> element that scales with the page."""
    _lay_out(figure)
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    # the size in points gives way to the page's, up to a size at which all figures have the same letters
    opening = re.sub(r' (?:width|height)="[^"]*"', "", text[: text.index(">")])
    limit = round(_PIXELS_PER_INCH * figure.get_size_inches()[0])
    return f'{opening} style="max-width: {limit}px"{text[text.index(">") :]}'


def _lay_out(figure: Figure) -> None:
    """Place everything, once and for all: savefig would draw all of the figure for that, to draw it again."""
    engine, dpi = figure.get_layout_engine(), figure.dpi
    if engine is not None:
        FigureCanvasSVG(figure)
        figure.dpi = 72.0  # of SVG, in which letters are measured
        engine.execute(figure)
        figure.dpi = dpi
        figure.set_layout_engine(None)
