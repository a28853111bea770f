"""Charts of force and energy that move with a film: past solid, future faint, a cursor between.

Their time axis is that of the film, so that contacts, around which time is stretched, have a width; its
labels are physical times.  What swings faster than pixels can show is drawn as a band.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from oblique_impact.renders.envelope import drawn
from oblique_impact.renders.layout import Box
from oblique_impact.renders.sheet import Sheet
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import Dash
from oblique_impact.renders.timeline import Timeline, TimeMap

Array = NDArray[np.float64]

_FAINT = 0.22  # strength of the future
_DIGIT = 0.64  # width of a digit over the size of its font
_LABEL, _AXIS = 9.5, 10.5  # points, where text has 10
_BAND, _EDGE = 0.13, 0.45  # strength of a band and of its edges over that of its line
_PLACES = 7  # decimals of a label at most
_PREFIXES = ((1e10, 1e9, "G"), (1e7, 1e6, "M"), (1e4, 1e3, "k"))  # from which value on, size, name
_MULTIPLES = 200_000  # of a step in the whole run: more are not tried


@dataclass(frozen=True)
class Curve:
    """One curve of a chart."""

    time: Array
    values: Array
    colour: str
    label: str
    dash: Dash = "-"


class Chart:
    """A chart in a box (pixels) of a sheet, whose curves are faint until `brighten` is called.

    Its horizontal axis is the film time of `timeline`, the vertical one has a `label` with its unit.  The contacts
    of the first run of the `story` are shaded.  Large numbers have a prefix to their unit.
    """

    def __init__(
        self, sheet: Sheet, curves: Sequence[Curve], label: str, box: Box, timeline: Timeline, story: Story
    ) -> None:
        self._sheet, self._course, self._box = sheet, timeline.course, box
        curves, label = in_short_numbers(curves, label, timeline.course)
        small, large = sheet.pixels(_LABEL), sheet.pixels(_AXIS)
        x0, x1 = box[0] + 4.3 * small + 1.6 * large, box[0] + box[2] - 2.8 * small
        y0, y1 = box[1] + 2.0 * small, box[1] + box[3] - 1.65 * (small + large)
        self._left, self._width = x0, x1 - x0
        (width, height), self._lines = sheet.size, list[tuple[Any, float]]()
        axes = sheet.figure.add_axes((x0 / width, 1.0 - y1 / height, (x1 - x0) / width, (y1 - y0) / height))
        axes.set_xlim(0.0, self._width)
        first, last = self._course.times[[0, -1]]
        for contact in story.histories[0].contacts:
            if contact.end >= first and contact.start <= last:
                ends = self._pixels(np.array([contact.start, contact.end]))
                axes.axvspan(*ends, color=sheet.theme.line, alpha=0.6, linewidth=0)
        for curve in curves:
            self._draw_curve(axes, curve, y1 - y0)
        self._dress(axes, curves, label, y1 - y0)
        self._cursor = sheet.rule((x0, y0), (x0, y1), color=sheet.theme.ink)
        sheet.move(self._cursor)

    def _pixels(self, time: Array | float) -> Array:
        """Pixels from the left end of the axis at physical times (s)."""
        return self._course.film_at(time) * self._width / self._course.duration

    def _draw_curve(self, axes: Any, curve: Curve, height: float) -> None:
        inside = (curve.time >= self._course.times[0]) & (curve.time <= self._course.times[-1])
        values = curve.values[inside]
        if values.size == 0:
            return
        shown = drawn(self._pixels(curve.time[inside]), values, float(np.ptp(values)) / height)
        width = 1.4 * self._sheet.thin
        for band in shown.bands:
            area = axes.fill_between(band.x, band.low, band.high, color=curve.colour, linewidth=0.0)
            self._lines.append((area, _BAND))
            # edges, so that bands over each other can be told apart
            for edge in (band.low, band.high):
                lines = axes.plot(band.x, edge, color=curve.colour, linewidth=0.5 * width)
                self._lines += [(line, _EDGE) for line in lines]
        lines = axes.plot(shown.x, shown.y, linestyle=curve.dash, color=curve.colour, linewidth=width)
        self._lines += [(line, 1.0) for line in lines]
        for artist, strength in self._lines:
            artist.set_alpha(_FAINT * strength)

    def _dress(self, axes: Any, curves: Sequence[Curve], label: str, height: float) -> None:
        sheet, theme = self._sheet, self._sheet.theme
        digit = _DIGIT * sheet.pixels(_LABEL)
        ticks, labels = round_times(self._course, self._width, lambda text: digit * len(text))
        axes.set_xticks(self._pixels(ticks), labels)
        lines = int(np.clip(height / (1.9 * sheet.pixels(_LABEL)), 2, 7))
        axes.yaxis.set_major_locator(MaxNLocator(lines, steps=[1, 2, 2.5, 5, 10]))
        axes.tick_params(colors=theme.dim, labelsize=sheet.points(_LABEL), length=4.0 * sheet.thin)
        for spine in axes.spines.values():
            spine.set_color(theme.dim)
        left = self._left - self._box[0]
        axes.set_ylabel(label, fontsize=sheet.points(_AXIS))
        axes.yaxis.set_label_coords((1.35 * sheet.pixels(_AXIS) - left) / self._width, 0.5)
        stretched = ", stretched around contacts" if np.ptp(self._course.rates) > 0.0 else ""
        axes.set_xlabel(f"time (s){stretched}", fontsize=sheet.points(_AXIS))
        named = [curve for curve in curves if curve.label]
        if len(named) > 1:
            axes.legend(
                handles=[
                    Line2D([], [], linestyle=c.dash, color=c.colour, lw=2.7 * sheet.thin, label=c.label)
                    for c in named
                ],
                loc="lower left",
                bbox_to_anchor=(0.0, 1.0),
                ncols=len(named),
                fontsize=sheet.points(_LABEL),
                handlelength=1.2,
                handletextpad=0.5,
                columnspacing=0.9,
                borderpad=0.1,
                borderaxespad=0.2,
            )

    def brighten(self) -> None:
        """Show the curves as they are in the past."""
        for artist, strength in self._lines:
            artist.set_alpha(strength)

    def past(self, time: float) -> tuple[slice, slice]:
        """Return rows and columns of the sheet with what is not later than a physical time (s)."""
        left, top, _, height = self._box
        return slice(top, top + height), slice(left, round(self._left + float(self._pixels(time))))

    def cursor_to(self, time: float) -> None:
        """Move the cursor to a physical time (s)."""
        x = self._left + float(self._pixels(time))
        self._cursor.set_xdata([x, x])


def in_short_numbers(curves: Sequence[Curve], label: str, course: TimeMap) -> tuple[list[Curve], str]:
    """Return curves and their label, "force (N)", in thousands, "force (kN)", or more where they become large."""
    first, last = course.times[[0, -1]]
    shown = [np.abs(curve.values[(curve.time >= first) & (curve.time <= last)]) for curve in curves]
    largest = max((float(values[np.isfinite(values)].max(initial=0.0)) for values in shown), default=0.0)
    size, prefix = next(((size, name) for least, size, name in _PREFIXES if largest >= least), (1.0, ""))
    if size == 1.0:
        return list(curves), label
    return [replace(curve, values=curve.values / size) for curve in curves], label.replace("(", f"({prefix}", 1)


def round_times(course: TimeMap, width: float, length: Callable[[str], float]) -> tuple[Array, list[str]]:
    """Choose round physical times for the labels of an axis of film time, all with the same decimals.

    Parameters
    ----------
    course : TimeMap
        Of the whole axis.
    width : float
        Length of the axis in pixels.
    length : callable
        Length of a label in pixels.

    On an even axis they are the multiples of one step, on a stretched one multiples of 5 and 1 in decades:
    coarse ones first, finer ones where there is still room for them, as long as an empty stretch is left that is
    longer than three labels.
    """
    first, last = course.times[[0, -1]].tolist()
    decade = math.floor(math.log10(max(last - first, 1e-300)))
    powers = range(decade, min(decade - 1, -_PLACES - 1), -1)
    even = not np.ptp(course.rates) > 0.0
    steps = [(m * 10.0**p, max(0, -p)) for p in powers for m in ((5.0, 2.0, 1.0) if even else (5.0, 1.0))]
    chosen, places = np.empty(0), 0
    for n, (finest, decimals) in enumerate(steps, start=1):
        if chosen.size and (last - first) / finest > _MULTIPLES:
            break
        room = 1.35 * max(length(f"{t:.{decimals}f}") for t in (first, last))
        found = np.empty(0)
        for step, _ in steps[n - 1 : n] if even else steps[:n]:
            found = _add_multiples(found, step, course, width / course.duration, room)
        crowded = even and found.size > 1 and np.diff(found).max() > 1.5 * finest
        if chosen.size > 1 and (crowded or found.size < 2):
            break
        chosen, places = found, decimals
        at = np.concatenate([[0.0], course.film_at(chosen) * width / course.duration, [width]])
        if chosen.size > 1 and not even and np.diff(at).max() < 3.0 * room:
            break
    return chosen, [f"{t:.{places}f}" for t in chosen]


def _add_multiples(chosen: Array, step: float, course: TimeMap, scale: float, room: float) -> Array:
    """Add multiples of a step to ascending times, `room` pixels apart; `scale` is in pixels per second of film."""
    first, last = course.times[[0, -1]]
    times = step * np.arange(math.ceil(first / step - 1e-9), math.floor(last / step + 1e-9) + 1)
    times = np.clip(times, first, last)
    at, taken = course.film_at(times) * scale, course.film_at(chosen) * scale
    free = np.all(np.abs(at[:, None] - taken) >= room, axis=1)
    for time, place in zip(times[free], at[free], strict=True):
        if np.all(np.abs(taken - place) >= room):
            taken, chosen = np.append(taken, place), np.append(chosen, time)
    return np.sort(chosen)


def force_curves(story: Story) -> list[Curve]:
    """Return the normal force of each history; with one history the tangential force too."""
    theme, times = story.style.colours, [history["time"].values for history in story.histories]
    forces = [[np.nan_to_num(h[name].values) for name in ("lambda_n", "lambda_tau")] for h in story.histories]
    if len(times) == 1:
        (normal, tangential) = forces[0]
        return [
            Curve(times[0], normal, theme.arrow, "normal"),
            Curve(times[0], tangential, theme.arrow, "tangential", "--"),
        ]
    rows = zip(times, forces, theme.series, story.names, theme.dashes, strict=False)
    return [Curve(time, normal, colour, name, dash) for time, (normal, _), colour, name, dash in rows]


def energy_curves(story: Story) -> list[Curve]:
    """Return kinetic, elastic, gravity and total energy of one history; the totals of several."""
    theme, kinds = story.style.colours, ("kinetic", "elastic", "gravity")
    parts = [[history[f"energy_{kind}"].values for kind in kinds] for history in story.histories]
    totals = [np.sum(part, axis=0) for part in parts]
    times = [history["time"].values for history in story.histories]
    if len(times) == 1:
        looks = zip((*theme.energies, theme.ink), (*theme.dashes[1:4], theme.dashes[0]), strict=True)
        rows = zip(parts[0] + totals, (*kinds, "total"), looks, strict=True)
        return [Curve(times[0], values, colour, label, dash) for values, label, (colour, dash) in rows]
    several = zip(times, totals, theme.series, story.names, theme.dashes, strict=False)
    return [Curve(time, total, colour, name, dash) for time, total, colour, name, dash in several]
