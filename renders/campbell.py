"""Campbell diagram: natural frequencies of the spinning beam over its spin rate."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oblique_impact.beam.frequencies import natural_frequencies
from oblique_impact.errors import InputError
from oblique_impact.renders.picture_files import save_figure
from oblique_impact.renders.style import GREY, SERIES, figure_style
from oblique_impact.scenario.scenario import Scenario

_POINTS = 41
_LINES = 1, 2  # multiples of the spin rate
_SHOWN = 2  # flapwise frequencies, or as many as these multiples cross


def campbell_diagram(scenario: Scenario, speeds: Sequence[float], count: int, out: str | os.PathLike[str]) -> Path:
    """Draw the Campbell diagram of the beam of a scenario, from rest to the largest of `speeds`; returns the file.

    Its axes are linear, up to the second frequency or as far as twice the spin rate reaches.

    Parameters
    ----------
    scenario : Scenario
        Its root decides, as in :func:`~oblique_impact.beam.frequencies.natural_frequencies`.
    speeds : sequence of float
        Spin rates (rad/s), which have a dot on each curve.
    count : int
        Flapwise and chordwise frequencies per speed.
    out : path
        A picture file, or a folder that gets ``campbell.png``.

    Raises
    ------
    InputError
        If all speeds are 0, or it cannot be written.

    Examples
    --------
    >>> from oblique_impact import Scenario
    >>> from oblique_impact.renders import campbell_diagram
    >>> campbell_diagram(Scenario.builtin("spin-up"), [0.0, 6.0], 3, "campbell.png")  # doctest: +SKIP
    """
    marked = sorted({abs(speed) for speed in speeds})
    top = marked[-1]
    if top == 0.0:
        raise InputError(
            "speeds: a Campbell diagram goes from rest to the largest of them; give one above 0 rad/s"
        )
    rates = np.union1d(np.linspace(0.0, top, _POINTS), marked)
    found, places = natural_frequencies(scenario, rates.tolist(), count), np.searchsorted(rates, marked).tolist()
    with figure_style():
        figure = Figure(figsize=(6.4, 4.6), layout="constrained")
        axes = figure.subplots()
        for name, table, dash, colour in (
            ("flapwise", found.flapwise, "-", SERIES[0]),
            ("chordwise", found.chordwise, "--", SERIES[1]),
        ):
            lines = axes.plot(rates, table, "o", color=colour, linestyle=dash, markevery=places, markersize=4.0)
            lines[0].set_label(name)
        # what the multiples of the spin rate cross: higher frequencies would press it into the lowest part
        shown = max(_LINES[-1] * top, float(found.flapwise[-1, min(_SHOWN, count) - 1]))
        for order in _LINES:
            axes.plot(rates, order * rates, color=GREY, linewidth=0.9, linestyle=":")
            axes.annotate(f" {order}P", (top, order * top), color=GREY, va="center", annotation_clip=False)
        title = "Campbell diagram (1P, 2P: once and twice per revolution)"
        axes.set(xlabel="spin rate (rad/s)", ylabel="natural frequency (rad/s)", title=title)
        axes.set(xlim=(0.0, top), ylim=(0.0, 1.08 * shown))
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=2)
        return save_figure(figure, Path(out), "campbell.png")
