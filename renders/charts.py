"""Charts of force and energy that move with a film: past solid, future faint, a cursor between.

Their time axis is that of the film, so that contacts, around which time is stretched, have a width; its
labels are physical times.  Both versions are drawn once; a frame is cut together from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from oblique_impact.history import History
from renders.style import figure_style
from renders.themes import Theme
from renders.timeline import Timeline, contact_windows

Array = NDArray[np.float64]

_DPI = 100
_FAINT = 0.22
_MOST_TICKS = 7


@dataclass(frozen=True)
class Curve:
    """One curve of a chart."""

    time: Array
    values: Array
    colour: str
    label: str
    dash: str = "-"


class Chart:
    """A chart as two pictures, one for the past and one for the future.

    Parameters
    ----------
    curves : sequence of Curve
        What is drawn.
    label : str
        Of the vertical axis, with its unit.
    size : tuple of int
        Pixels.
    timeline : Timeline
        Its film time is the horizontal axis.
    windows : list of tuple
        Contacts (s), shaded.
    theme : Theme
        Colours.
    scale : float
        Size of letters, 1 for a film of 1280 x 720.
    """

    def __init__(
        self,
        curves: Sequence[Curve],
        label: str,
        size: tuple[int, int],
        timeline: Timeline,
        windows: list[tuple[float, float]],
        theme: Theme,
        scale: float = 1.0,
    ) -> None:
        self.theme, self.timeline = theme, timeline
        self._past, self._span = self._draw(curves, label, size, windows, scale, 1.0)
        self._future, _ = self._draw(curves, label, size, windows, scale, _FAINT)

    def _draw(
        self,
        curves: Sequence[Curve],
        label: str,
        size: tuple[int, int],
        windows: list[tuple[float, float]],
        scale: float,
        strength: float,
    ) -> tuple[Image.Image, tuple[float, float, float, float]]:
        theme, timeline = self.theme, self.timeline
        with figure_style():
            figure = Figure(figsize=(size[0] / _DPI, size[1] / _DPI), dpi=_DPI, facecolor=theme.background)
            canvas = FigureCanvasAgg(figure)
            axes = figure.add_axes(_frame(size, scale))
            axes.set_facecolor(theme.background)
            first, last = timeline.times[0], timeline.times[-1]
            for start, end in windows:
                if end >= first and start <= last:
                    axes.axvspan(
                        *timeline.film_time(np.array([start, end])), color=theme.line, alpha=0.6, linewidth=0
                    )
            for curve in curves:
                inside = (curve.time >= first) & (curve.time <= last)
                axes.plot(
                    timeline.film_time(curve.time[inside]),
                    curve.values[inside],
                    curve.dash,
                    color=curve.colour,
                    linewidth=1.4 * scale,
                    alpha=strength,
                )
            self._dress(axes, curves, label, scale)
            cast(Any, canvas).draw()
            box = axes.get_window_extent()
        picture = Image.fromarray(np.asarray(cast(Any, canvas).buffer_rgba())[..., :3].copy())
        return picture, (box.x0, box.x1, size[1] - box.y1, size[1] - box.y0)

    def _dress(self, axes: Any, curves: Sequence[Curve], label: str, scale: float) -> None:
        theme, timeline = self.theme, self.timeline
        axes.set_xlim(0.0, timeline.film_time(timeline.times[-1]))
        ticks = _ticks(timeline)
        axes.set_xticks(timeline.film_time(ticks), [f"{t:.4g}" for t in ticks])
        axes.tick_params(colors=theme.dim, labelsize=9 * scale, length=3 * scale)
        for spine in axes.spines.values():
            spine.set_color(theme.dim)
        axes.grid(color=theme.line)
        axes.set_ylabel(label, color=theme.ink, fontsize=10 * scale)
        axes.set_xlabel("time (s), stretched around contacts", color=theme.ink, fontsize=10 * scale)
        handles = [
            axes.plot([], [], c.dash, color=c.colour, linewidth=2 * scale, label=c.label)[0]
            for c in curves
            if c.label
        ]
        if len(handles) > 1:
            axes.legend(
                handles=handles,
                loc="lower left",
                bbox_to_anchor=(-0.01, 0.98),
                ncols=len(handles),
                fontsize=9 * scale,
                labelcolor=theme.ink,
                handlelength=1.2,
                columnspacing=1.0,
                borderpad=0.1,
            )

    def at(self, film_time: float) -> Image.Image:
        """Return the picture with its cursor at a film time (s)."""
        left, right, top, bottom = self._span
        whole = float(self.timeline.film_time(self.timeline.times[-1])) or 1.0
        x = left + (right - left) * min(max(film_time / whole, 0.0), 1.0)
        picture = self._future.copy()
        picture.paste(self._past.crop((0, 0, round(x), picture.height)), (0, 0))
        ImageDraw.Draw(picture).line([(round(x), top), (round(x), bottom)], fill=self.theme.ink, width=1)
        return picture


def _frame(size: tuple[int, int], scale: float) -> tuple[float, float, float, float]:
    """Place of the axes in a chart, in parts of it: room for labels of a fixed size."""
    left, bottom, right, top = 66 * scale, 44 * scale, 16 * scale, 26 * scale
    return left / size[0], bottom / size[1], 1.0 - (left + right) / size[0], 1.0 - (bottom + top) / size[1]


def _ticks(timeline: Timeline) -> Array:
    """Physical times at about equal distances of film time."""
    wanted = np.interp(
        np.linspace(0.0, timeline.duration, _MOST_TICKS), timeline.film_time(timeline.times), timeline.times
    )
    span = timeline.times[-1] - timeline.times[0]
    digits = max(0, int(np.ceil(-np.log10(max(span, 1e-12)))) + 3)
    rounded = np.unique(np.round(wanted, digits))
    return np.asarray(rounded[(rounded >= timeline.times[0]) & (rounded <= timeline.times[-1])])


def force_curves(histories: Sequence[History], names: Sequence[str], theme: Theme) -> list[Curve]:
    """Return the normal force of each history; with one history the tangential force too."""
    found = []
    for history, name, colour in zip(histories, names, theme.series, strict=False):
        alone = len(histories) == 1
        time = history["time"].values
        found.append(
            Curve(
                time,
                np.nan_to_num(history["lambda_n"].values),
                theme.arrow if alone else colour,
                "normal" if alone else name,
            )
        )
        if alone:
            found.append(Curve(time, np.nan_to_num(history["lambda_tau"].values), theme.arrow, "tangential", "--"))
    return found


def energy_curves(histories: Sequence[History], names: Sequence[str], theme: Theme) -> list[Curve]:
    """Return kinetic, elastic, gravity and total energy of one history; the totals of several."""
    kinds = ("kinetic", "elastic", "gravity")
    found = []
    for history, name, colour in zip(histories, names, theme.series, strict=False):
        time = history["time"].values
        parts = [history[f"energy_{kind}"].values for kind in kinds]
        if len(histories) == 1:
            found += [Curve(time, p, c, kind) for p, c, kind in zip(parts, theme.energies, kinds, strict=True)]
            found.append(Curve(time, np.sum(parts, axis=0), theme.ink, "total"))
        else:
            found.append(Curve(time, np.sum(parts, axis=0), colour, name))
    return found


def all_windows(histories: Sequence[History]) -> list[tuple[float, float]]:
    """Return the contacts of the first history, which are shaded."""
    return contact_windows(histories[0])
