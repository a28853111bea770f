"""One style for every figure: sizes, colours, fonts."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl

FREE_COLOUR, SLIP_COLOUR, STICK_COLOUR = "#1f4fd1", "#d9580d", "#1b8a3c"
STATE_COLOURS = (FREE_COLOUR, SLIP_COLOUR, STICK_COLOUR)
SERIES = ("#22577a", "#e07a1f", "#5b8e3b", "#8a4f9e", "#b03a48", "#6c757d")
GREY = "#6c757d"

_SETTINGS: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e6e8eb",
    "grid.linewidth": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.4,
    "figure.dpi": 100,
    "savefig.dpi": 160,
    "savefig.facecolor": "white",
    "svg.hashsalt": "oblique-impact",
}


@contextmanager
def figure_style() -> Iterator[None]:
    """Apply the style inside a block; leaves matplotlib's settings as they were."""
    with mpl.rc_context(_SETTINGS):
        yield
