"""Figures as SVG text, the same from run to run: no dates, no random identifiers."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager

from matplotlib.figure import Figure

from renders.style import figure_style

#: half a page of an A4 column, and the whole width (inches)
HALF, FULL = 4.6, 9.2


@contextmanager
def new_figure(width: float = FULL, height: float = 3.4) -> Iterator[Figure]:
    """Make a figure in the project's style; plot and call `to_svg` inside of the block."""
    with figure_style():
        yield Figure(figsize=(width, height), layout="constrained")


def to_svg(figure: Figure) -> str:
    """Return the figure as an <svg> element that scales with the page."""
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
    text = buffer.getvalue()
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    # the size in points gives way to the page's; the view box keeps the proportions
    return re.sub(r'(<svg[^>]*?) width="[^"]*"| height="[^"]*pt"', lambda m: m.group(1) or "", text, count=2)
