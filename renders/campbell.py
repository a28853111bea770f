"""Campbell diagram: natural frequencies of the spinning beam over its spin rate."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oblique_impact.beam.frequencies import natural_frequencies
from oblique_impact.renders.files import save_figure
from oblique_impact.renders.style import GREY, SERIES, figure_style
from oblique_impact.scenario.scenario import Scenario

_POINTS = 41


def campbell_diagram(scenario: Scenario, speeds: Sequence[float], count: int, out: str | os.PathLike[str]) -> Path:
    """Draw the Campbell diagram of the beam of a scenario, from rest to the largest of `speeds`; returns the file.

    Parameters
    ----------
    scenario : Scenario
        Its root decides, as in :func:`~oblique_impact.beam.frequencies.natural_frequencies`.
    speeds : sequence of float
        Spin rates (rad/s) that are marked.
    count : int
        Flapwise and chordwise frequencies per speed.
    out : path
        A picture file, or a folder that gets ``campbell.png``.

    Raises
    ------
    InputError
        If it cannot be written.

    Examples
    --------
    >>> from oblique_impact import Scenario
    >>> from oblique_impact.renders import campbell_diagram
    >>> campbell_diagram(Scenario.builtin("spin-up"), [0.0, 6.0], 3, "campbell.png")  # doctest: +SKIP
    """
    marked = sorted({abs(speed) for speed in speeds})
    top = marked[-1] or 1.0
    rates = np.linspace(0.0, top, _POINTS)
    found = natural_frequencies(scenario, rates.tolist(), count)
    with figure_style():
        figure = Figure(figsize=(6.4, 4.6), layout="constrained")
        axes = figure.subplots()
        for name, table, dash, colour in (
            ("flapwise", found.flapwise, "-", SERIES[0]),
            ("chordwise", found.chordwise, "--", SERIES[1]),
        ):
            elastic = np.where(table > 0.0, table, np.nan)  # a free root's rigid mode has no place on a log axis
            lines = axes.semilogy(rates, elastic, color=colour, linestyle=dash)
            lines[0].set_label(name)
        axes.semilogy(rates[1:], rates[1:], color=GREY, linewidth=0.9, linestyle=":", label="once per revolution")
        for speed in marked:
            axes.axvline(speed, color=GREY, linewidth=0.5)
        title = "Campbell diagram"
        axes.set(xlabel="spin rate (rad/s)", ylabel="natural frequency (rad/s)", title=title, xlim=(0.0, top))
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3)
        return save_figure(figure, Path(out), "campbell.png")
