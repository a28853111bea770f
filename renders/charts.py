"""Charts of force and energy that move with a film: past solid, future faint, a cursor between.

Their time axis is that of the film, so that contacts, around which time is stretched, have a width; its
labels are physical times.  What swings faster than pixels can show is drawn as a band.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from oblique_impact.renders.envelope import drawn
from oblique_impact.renders.layout import Box
from oblique_impact.renders.sheet import Sheet
from oblique_impact.renders.story import Story
from oblique_impact.renders.timeline import TimeMap

Array = NDArray[np.float64]

_FAINT = 0.22  # strength of the future
_LABEL, _AXIS = 9.5, 10.5  # points, where text has 10
_BAND, _EDGE = 0.13, 0.45  # strength of a band and of its edges over that of its line
_PREFIXES = ((1e10, 1e9, "G"), (1e7, 1e6, "M"), (1e4, 1e3, "k"))  # from which value on, size, name


@dataclass(frozen=True)
class Curve:
    """A curve of a chart: times (s) and values, (samples,)."""

    time: Array
    values: Array
    colour: str
    label: str
    dash: Literal["-", "--"] = "-"


class Chart:
    """A chart in a box (pixels) of a sheet, whose curves are faint until `brighten` is called.

    Its horizontal axis is the film time of `course`, the vertical one has a `label` with its unit.  The contacts
    of the first run of the `story` are shaded.  Large numbers have a prefix to their unit.
    """

    def __init__(
        self, sheet: Sheet, curves: Sequence[Curve], label: str, box: Box, course: TimeMap, story: Story
    ) -> None:
        self._sheet, self._course, self._box = sheet, course, box
        small, large = sheet.pixels(_LABEL), sheet.pixels(_AXIS)
        x0, x1 = box[0] + 4.3 * small + 1.6 * large, box[0] + box[2] - 2.8 * small
        y0, y1 = box[1] + 2.0 * small, box[1] + box[3] - 1.65 * (small + large)
        self._left, self._width, self._height = x0, x1 - x0, y1 - y0
        self._lines: list[tuple[Any, float]] = []
        self._axes = axes = sheet.add_axes(x0, y0, self._width, self._height)
        axes.set_xlim(0.0, self._width)
        first, last = course.times[[0, -1]]
        for contact in story.histories[0].contacts:
            if contact.end >= first and contact.start <= last:
                ends = self._pixels(np.array([contact.start, contact.end]))
                axes.axvspan(*ends, color=sheet.theme.line, alpha=0.6, linewidth=0)
        shown = [(curve, (curve.time >= first) & (curve.time <= last)) for curve in curves]
        values = np.concatenate([np.abs(curve.values[inside]) for curve, inside in shown])
        largest = float(values[np.isfinite(values)].max(initial=0.0))
        size, prefix = next(((size, name) for least, size, name in _PREFIXES if largest >= least), (1.0, ""))
        for curve, inside in shown:
            if inside.any():
                self._draw_curve(curve, self._pixels(curve.time[inside]), curve.values[inside] / size)
        self._add_labels(curves, label.replace("(", f"({prefix}", 1))
        self._cursor = sheet.rule((x0, y0), (x0, y1), color=sheet.theme.ink)
        sheet.move(self._cursor)

    def _pixels(self, time: Array | float) -> Array:
        """Return pixels from the left end of the axis at physical times (s)."""
        return self._course.film_at(time) * self._width / self._course.duration

    def _draw_curve(self, curve: Curve, x: Array, y: Array) -> None:
        axes, width = self._axes, 1.4 * self._sheet.thin
        shown = drawn(x, y, float(np.ptp(y)) / self._height)
        for band in shown.bands:
            area = axes.fill_between(band.x, band.low, band.high, color=curve.colour, linewidth=0.0)
            self._lines.append((area, _BAND))
            # edges, so that bands over each other can be told apart
            for edge in (band.low, band.high):
                self._lines.append((*axes.plot(band.x, edge, color=curve.colour, linewidth=0.5 * width), _EDGE))
        line = axes.plot(shown.x, shown.y, linestyle=curve.dash, color=curve.colour, linewidth=width)
        self._lines.append((*line, 1.0))
        self._set_strength(_FAINT)

    def _add_labels(self, curves: Sequence[Curve], label: str) -> None:
        axes, sheet, theme = self._axes, self._sheet, self._sheet.theme
        ticks, labels = round_times(self._course, int(self._width / (5.5 * sheet.pixels(_LABEL))))
        axes.set_xticks(self._pixels(ticks), labels)
        lines = int(np.clip(self._height / (1.9 * sheet.pixels(_LABEL)), 2, 7))
        axes.yaxis.set_major_locator(MaxNLocator(lines, steps=[1, 2, 2.5, 5, 10]))
        axes.tick_params(colors=theme.dim, labelsize=sheet.points(_LABEL), length=4.0 * sheet.thin)
        for spine in axes.spines.values():
            spine.set_color(theme.dim)
        axes.set_ylabel(label, fontsize=sheet.points(_AXIS))
        left = self._left - self._box[0]
        axes.yaxis.set_label_coords((1.35 * sheet.pixels(_AXIS) - left) / self._width, 0.5)
        stretched = ", stretched around contacts" if np.ptp(self._course.rates) > 0.0 else ""
        axes.set_xlabel(f"time (s){stretched}", fontsize=sheet.points(_AXIS))
        if len(curves) > 1:
            handles = [
                Line2D([], [], linestyle=c.dash, color=c.colour, lw=2.7 * sheet.thin, label=c.label)
                for c in curves
            ]
            axes.legend(
                handles=handles,
                loc="lower left",
                bbox_to_anchor=(0.0, 1.0),
                ncols=len(curves),
                fontsize=sheet.points(_LABEL),
                handlelength=1.2,
                handletextpad=0.5,
                columnspacing=0.9,
                borderpad=0.1,
                borderaxespad=0.2,
            )

    def _set_strength(self, part: float) -> None:
        for artist, strength in self._lines:
            artist.set_alpha(part * strength)

    def brighten(self) -> None:
        """Show the curves as they are in the past."""
        self._set_strength(1.0)

    def past(self, time: float) -> tuple[slice, slice]:
        """Return rows and columns of the sheet with what is not later than a physical time (s)."""
        left, top, _, height = self._box
        return slice(top, top + height), slice(left, round(self._left + float(self._pixels(time))))

    def cursor_to(self, time: float) -> None:
        """Move the cursor to a physical time (s)."""
        x = self._left + float(self._pixels(time))
        self._cursor.set_xdata([x, x])


def round_times(course: TimeMap, most: int) -> tuple[Array, list[str]]:
    """Return at most so many times (s) for the labels of an axis of film time, and their labels.

    They are spread evenly in film time and rounded as much as leaves them apart from each other.
    """
    even = np.linspace(0.0, course.duration, max(most, 2))
    for decimals in range(-3, 8):
        times = np.unique(np.round(course.time_at(even), decimals))
        times = times[(times >= course.times[0]) & (times <= course.times[-1])]
        places = course.film_at(times)
        apart = np.append(True, np.diff(places) > 0.8 * even[1])
        if np.count_nonzero(apart) >= 0.7 * even.size:
            break
    return times[apart], [f"{time:.{max(decimals, 0)}f}" for time in times[apart]]


def force_curves(story: Story) -> list[Curve]:
    """Return the normal force of each history; with one history the tangential force too."""
    theme, histories = story.style.colours, story.histories
    normal = [np.nan_to_num(history["lambda_n"].values) for history in histories]
    if len(histories) > 1:
        return _one_for_each_run(story, normal)
    time, tangential = histories[0]["time"].values, np.nan_to_num(histories[0]["lambda_tau"].values)
    return [
        Curve(time, normal[0], theme.arrow, "normal"),
        Curve(time, tangential, theme.arrow, "tangential", "--"),
    ]


def energy_curves(story: Story) -> list[Curve]:
    """Return kinetic, elastic, gravity and total energy of one history; the totals of several."""
    theme, kinds = story.style.colours, ("kinetic", "elastic", "gravity")
    parts = [[history[f"energy_{kind}"].values for kind in kinds] for history in story.histories]
    totals = [np.sum(part, axis=0) for part in parts]
    if len(totals) > 1:
        return _one_for_each_run(story, totals)
    time = story.histories[0]["time"].values
    rows = zip([*parts[0], totals[0]], (*theme.energies, theme.ink), (*kinds, "total"), strict=True)
    return [Curve(time, values, colour, label) for values, colour, label in rows]


def _one_for_each_run(story: Story, values: Sequence[Array]) -> list[Curve]:
    rows = zip(story.histories, values, story.style.colours.series, story.names, strict=False)
    return [Curve(history["time"].values, found, colour, name) for history, found, colour, name in rows]
