"""Campbell diagram: natural frequencies of the spinning beam over its spin rate."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from oblique_impact.beam.operators import discretization
from oblique_impact.renders.files import save_figure
from oblique_impact.renders.style import GREY, SERIES, figure_style
from oblique_impact.scenario.scenario import Scenario

Array = NDArray[np.float64]

_POINTS = 41


class Spectrum(Protocol):
    """Frequencies (rad/s) at a spin rate (rad/s)."""

    def flapwise(self, spin_rate: float, count: int) -> Array:
        """Out of the plane of rotation."""

    def chordwise(self, spin_rate: float, count: int) -> Array:
        """In the plane of rotation."""


def campbell_diagram(
    beam: Scenario | Spectrum, speeds: Sequence[float], count: int, out: str | os.PathLike[str]
) -> Path:
    """Draw the Campbell diagram of a beam, from rest to the largest of `speeds`.

    Parameters
    ----------
    beam : Scenario or Spectrum
        A scenario, or what gives frequencies (rad/s) at a spin rate (rad/s).
    speeds : sequence of float
        Spin rates (rad/s) that are marked.
    count : int
        Flapwise and chordwise frequencies per speed.
    out : path
        A picture file, or a folder that gets ``campbell.png``.

    Returns
    -------
    Path
        The picture.

    Raises
    ------
    InputError
        If it cannot be written.

    Examples
    --------
    >>> from oblique_impact import Scenario
    >>> from renders import campbell_diagram
    >>> campbell_diagram(Scenario.builtin("spin-up"), [0.0, 6.0], 3, "campbell.png")  # doctest: +SKIP
    """
    if isinstance(beam, Scenario):
        beam = discretization(beam.discretization.method).spectrum(beam)
    assert not isinstance(beam, Scenario)
    top = max(abs(speed) for speed in speeds) or 1.0
    rates = np.linspace(0.0, top, _POINTS)
    with figure_style():
        figure = Figure(figsize=(6.4, 4.6), layout="constrained")
        axes = figure.subplots()
        for name, found, colour, dash in (
            ("flapwise", beam.flapwise, SERIES[0], "-"),
            ("chordwise", beam.chordwise, SERIES[1], "--"),
        ):
            table = np.array([found(rate, count) for rate in rates])
            elastic = np.where(table > 0.0, table, np.nan)  # a free root's rigid mode has no place on a log axis
            lines = axes.semilogy(rates, elastic, color=colour, linestyle=dash)
            lines[0].set_label(name)
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
        return save_figure(figure, Path(out), "campbell.png")
