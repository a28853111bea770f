"""Picture of mode shapes about an equilibrium: the deflection along the beam, with the contacts that hold it."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from oblique_impact.renders.picture_files import save_figure
from oblique_impact.renders.style import GREY, SERIES, figure_style

if TYPE_CHECKING:
    from oblique_impact.vibration import VibrationModes

#: shapes that are drawn at most, and the height (inches) of each
_DRAWN, _HEIGHT = 8, 1.2


def draw_mode_shapes(found: VibrationModes, out: str | os.PathLike[str]) -> Path:
    """Draw the first shapes, one below the other, with frequency and damping ratio; returns the file.

    Triangles stand where contacts are closed.

    Parameters
    ----------
    found : VibrationModes
        Modes, see :func:`~oblique_impact.vibration.frequencies_at_rest`.
    out : path
        A picture file, or a folder that gets ``mode-shapes.png``.

    Raises
    ------
    InputError
        If it cannot be written.

    Examples
    --------
    >>> from oblique_impact import Scenario, frequencies_at_rest
    >>> from oblique_impact.renders import draw_mode_shapes
    >>> draw_mode_shapes(frequencies_at_rest(Scenario.builtin("elastic-stop")), "shapes.png")  # doctest: +SKIP
    """
    count = min(_DRAWN, found.frequencies.size)
    with figure_style():
        figure = Figure(figsize=(6.4, 0.8 + _HEIGHT * count), layout="constrained")
        rows = figure.subplots(count, sharex=True, squeeze=False)[:, 0]
        for k, axes in enumerate(rows):
            hertz, ratio = found.frequencies[k] / (2.0 * math.pi), found.damping[k]
            axes.axhline(0.0, color=GREY, linewidth=0.8)
            axes.plot(found.stations, found.shapes[k], color=SERIES[0])
            places = [place for _, place in found.closed]
            axes.plot(places, [0.0] * len(places), "^", color=SERIES[1], markersize=7.0)
            axes.set(
                title=f"mode {k + 1}: {hertz:.5g} Hz, damping ratio {ratio:.3g}", ylim=(-1.15, 1.15), yticks=[]
            )
        rows[-1].set(xlabel="along the beam (m)")
        return save_figure(figure, Path(out), "mode-shapes.png")
