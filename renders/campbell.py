"""Campbell diagram: natural frequencies of the spinning beam over its spin rate."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from renders.files import save_figure
from renders.style import GREY, SERIES, figure_style

Array = NDArray[np.float64]

_POINTS = 41


class Spectrum(Protocol):
    """Frequencies (rad/s) at a spin rate (rad/s)."""

    def flapwise(self, spin_rate: float, count: int) -> Array:
        """Out of the plane of rotation."""

    def chordwise(self, spin_rate: float, count: int) -> Array:
        """In the plane of rotation."""


def campbell_diagram(beam: Spectrum, speeds: list[float], count: int, out: Path) -> Path:
    """Draw `count` flapwise and chordwise frequencies from rest to the largest of `speeds`.

    `out` is a picture file, or a folder that gets ``campbell.png``.  The given speeds are marked.
    """
    top = max(abs(speed) for speed in speeds) or 1.0
    rates = np.linspace(0.0, top, _POINTS)
    flapwise = np.array([beam.flapwise(rate, count) for rate in rates])
    chordwise = np.array([beam.chordwise(rate, count) for rate in rates])
    with figure_style():
        figure = Figure(figsize=(6.4, 4.6), layout="constrained")
        axes = figure.subplots()
        for table, colour, dash, name in (
            (flapwise, SERIES[0], "-", "flapwise"),
            (chordwise, SERIES[1], "--", "chordwise"),
        ):
            elastic = np.where(table > 0.0, table, np.nan)  # a hinged beam's rigid mode has no place on a log axis
            axes.semilogy(rates, elastic, color=colour, linestyle=dash)
            axes.plot([], [], color=colour, linestyle=dash, label=name)
        axes.semilogy(rates[1:], rates[1:], color=GREY, linewidth=0.9, linestyle=":", label="once per revolution")
        for speed in sorted({abs(speed) for speed in speeds}):
            axes.axvline(speed, color=GREY, linewidth=0.5)
        axes.set(
            xlabel="spin rate (rad/s)",
            ylabel="natural frequency (rad/s)",
            title="Campbell diagram",
            xlim=(0.0, top),
        )
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3)
        return save_figure(figure, out, "campbell.png")
