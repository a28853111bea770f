"""Charts of force and energy over the film of a run: in films with a cursor that moves, and in pages.

Their time axis is that of the film, so that contacts, around which time is stretched, have a width; its
labels are physical times.  What swings faster than pixels can show is drawn as a band.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from oblique_impact.renders.envelope import drawn
from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.layout import Box
from oblique_impact.renders.sheet import Sheet
from oblique_impact.renders.story import Story
from oblique_impact.renders.timeline import TimeMap, contact_spans

Array = NDArray[np.float64]

_FAINT = 0.3  # strength of the future
_LABEL, _AXIS = 9.5, 10.5  # points, where text has 10
_BAND, _EDGE = 0.13, 0.45  # strength of a band and of its edges over that of its line
_STEPS = [1, 2, 2.5, 5, 10]  # between labels of an axis, times a power of ten
#: from which value on, size, name
_PREFIXES = (
    *((1e10, 1e9, "G"), (1e7, 1e6, "M"), (1e4, 1e3, "k"), (0.1, 1.0, "")),
    *((1e-4, 1e-3, "m"), (1e-99, 1e-6, "µ")),
)


@dataclass(frozen=True)
class Curve:
    """A curve of a chart: times (s) and values, (samples,)."""

    time: Array
    values: Array
    colour: str
    label: str
    dash: Literal["-", "--"] = "-"


def draw_curves(
    axes: Axes,
    curves: Sequence[Curve],
    story: Story,
    course: TimeMap,
    size: tuple[float, float],
    ticks: tuple[int, int],
    width: float,
) -> str:
    """Draw curves of one unit, and the contacts of the first run of a story, over the film time of `course`.

    The axes, of some `size` (pixels), get pixels from their left end; lines have some `width` (points), and there
    are at most so many `ticks` along both axes.  Returns the prefix of the unit, as `unit_for`.
    """
    first, last = course.times[[0, -1]]
    per_second = size[0] / (course.duration or 1.0)
    axes.set_xlim(0.0, size[0])
    for span in contact_spans(story.histories[0]):
        if span[1] >= first and span[0] <= last:
            start, end = course.film_at(span) * per_second
            axes.axvspan(start, end, color=story.style.colours.line, alpha=0.6, linewidth=0)
    shown = [(curve, (curve.time >= first) & (curve.time <= last)) for curve in curves]
    unit, prefix = unit_for([curve.values[inside] for curve, inside in shown])
    for curve, inside in shown:
        if not inside.any():
            continue
        y = curve.values[inside] / unit
        line = drawn(course.film_at(curve.time[inside]) * per_second, y, float(np.ptp(y)) / size[1])
        for band in line.bands:
            axes.fill_between(band.x, band.low, band.high, color=curve.colour, alpha=_BAND, linewidth=0.0)
            # edges, so that bands over each other can be told apart
            for edge in (band.low, band.high):
                axes.plot(band.x, edge, color=curve.colour, alpha=_EDGE, linewidth=0.5 * width)
        axes.plot(line.x, line.y, linestyle=curve.dash, color=curve.colour, linewidth=width)
    mark_times(axes, course, size[0], ticks[0])
    axes.yaxis.set_major_locator(MaxNLocator(ticks[1], steps=_STEPS))
    return prefix


def unit_for(values: Sequence[Array] | Sequence[list[float]]) -> tuple[float, str]:
    """Return the unit in which values, in SI units, read well: its size and its prefix, from µ to G."""
    sizes = np.abs(np.concatenate(values))
    largest = float(sizes[np.isfinite(sizes)].max(initial=0.0))
    return next(((unit, name) for least, unit, name in _PREFIXES if largest >= least), (1.0, ""))


def mark_times(axes: Axes, course: TimeMap, width: float, most: int) -> None:
    """Write at most so many times below axes over film time, of some width (pixels)."""
    times, labels = round_times(course, most)
    axes.set_xticks(course.film_at(times) * width / (course.duration or 1.0), labels)


def time_label(course: TimeMap) -> str:
    """Return the label of an axis of film time."""
    return "time (s), stretched around contacts" if np.ptp(course.rates) > 0.0 else "time (s)"


class Chart:
    """A chart in a box (pixels) of a sheet, drawn once; over it a cursor moves.

    Its horizontal axis is the film time of `course`, the vertical one has a `label` with its unit.
    """

    def __init__(
        self, sheet: Sheet, curves: Sequence[Curve], label: str, box: Box, course: TimeMap, story: Story
    ) -> None:
        self._course, self._box, theme = course, box, sheet.theme
        small, large = sheet.pixels(_LABEL), sheet.pixels(_AXIS)
        x0, x1 = box[0] + 4.3 * small + 1.6 * large, box[0] + box[2] - 2.8 * small
        y0, y1 = box[1] + 2.0 * small, box[1] + box[3] - 1.65 * (small + large)
        self._left, self._width, self._background = x0, x1 - x0, to_rgb(theme.background)
        self._inside = slice(round(y0), round(y1)), slice(round(x0) + 1, round(x1) + 1)
        axes = sheet.add_axes(x0, y0, x1 - x0, y1 - y0)
        ticks = int((x1 - x0) / (5.5 * small)), int(np.clip((y1 - y0) / (1.9 * small), 2, 7))
        size, thin = (x1 - x0, y1 - y0), sheet.thin
        prefix = draw_curves(axes, curves, story, course, size, ticks, 1.4 * thin)
        axes.tick_params(colors=theme.dim, labelsize=sheet.points(_LABEL), length=4.0 * thin)
        for spine in axes.spines.values():
            spine.set_color(theme.dim)
        if len(label) * 0.6 * large > box[3] and label.count(" ") > 1:
            label = label.split(" ", 1)[1]
        axes.set_ylabel(label.replace("(", f"({prefix}", 1), fontsize=sheet.points(_AXIS))
        axes.yaxis.set_label_coords((1.35 * large - (x0 - box[0])) / (x1 - x0), 0.5)
        axes.set_xlabel(time_label(course), fontsize=sheet.points(_AXIS))
        if len(curves) > 1:
            axes.legend(
                [Line2D([], [], linestyle=c.dash, color=c.colour, lw=2.7 * thin) for c in curves],
                [curve.label for curve in curves],
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
        self._cursor = sheet.rule((x0, y0), (x0, y1), color=theme.ink)
        sheet.move(self._cursor)

    def veil(self, picture: NDArray[np.uint8]) -> None:
        """Make the chart faint, as the future is, in a picture of the sheet (rows, columns, 4)."""
        inside, background = picture[self._inside][..., :3], 255.0 * np.array(self._background)
        inside[...] = background + _FAINT * (inside - background)

    def past(self, time: float) -> tuple[slice, slice]:
        """Return rows and columns of the sheet with what is not later than a physical time (s)."""
        left, top, _, height = self._box
        return slice(top, top + height), slice(left, round(self._x_of(time)))

    def cursor_to(self, time: float) -> None:
        """Move the cursor to a physical time (s)."""
        self._cursor.set_xdata([self._x_of(time)] * 2)

    def _x_of(self, time: float) -> float:
        """Return pixels from the left of the sheet at a physical time (s)."""
        return self._left + float(self._course.film_at(time)) * self._width / self._course.duration


def round_times(course: TimeMap, most: int) -> tuple[Array, list[str]]:
    """Return at most so many times (s) for the labels of an axis of film time, and their labels.

    They are spread evenly in film time and rounded as much as leaves them apart from each other.
    """
    first, last = course.times[[0, -1]]
    if np.ptp(course.rates) == 0.0:
        ticks = MaxNLocator(max(most - 1, 1), steps=_STEPS).tick_values(first, last)
        ticks = ticks[(ticks >= first) & (ticks <= last)]
        return ticks, [f"{tick:g}" for tick in ticks]
    even = np.linspace(0.0, course.duration, max(most, 2))
    for decimals in range(-3, 8):
        times = np.unique(np.round(course.time_at(even), decimals))
        times = times[(times >= first) & (times <= last)]
        apart = np.append(True, np.diff(course.film_at(times)) > 0.8 * even[1])
        if np.count_nonzero(apart) >= 0.7 * even.size:
            break
    return times[apart], [f"{time:.{max(decimals, 0)}f}" for time in times[apart]]


# Curves -------------------------------------------------------------------------------------------------------


def first_chart(story: Story) -> tuple[str, str, list[Curve]]:
    """Return title, unit and curves of what moves the beam: contact forces, or its deflection without contact."""
    if any(geometry.scenario.contact.enabled and geometry.peak_force > 0.0 for geometry in story.geometries):
        return "normal force" if len(story.geometries) > 1 else "contact force", "N", force_curves(story)
    deflections = [geometry.values("deflection") for geometry in story.geometries]
    if len(deflections) > 1:
        return "deflection", "m", _one_for_each_run(story, deflections)
    colour = story.style.colours.energies[1]
    return "deflection", "m", [Curve(story.geometries[0].times, deflections[0], colour, "of the tip")]


def force_curves(story: Story) -> list[Curve]:
    """Return the normal force of each history; with one history the tangential force too.

    Of several contacts it is the sum.
    """
    theme, histories = story.style.colours, story.histories
    normal = [np.nan_to_num(history["lambda_n"].values) for history in histories]
    if len(histories) > 1:
        return _one_for_each_run(story, normal)
    time, tangential = histories[0]["time"].values, np.nan_to_num(histories[0]["lambda_tau"].values)
    of_all = ", of all contacts" if story.geometries[0].anywhere else ""
    return [
        Curve(time, normal[0], theme.arrow, f"normal{of_all}"),
        Curve(time, tangential, theme.arrow, f"tangential{of_all}", "--"),
    ]


def energy_chart(story: Story) -> tuple[str, str, list[Curve]]:
    """Return title, unit and curves: kinetic, elastic, gravity, stop and total energy of one history.

    Of several they are the totals.  Where gravity's energy, counted from the root, keeps farther from zero in the
    first history than it moves, they are changes since the start: the weight of a strip that stands or hangs
    would hide them.
    """
    theme, kinds = story.style.colours, ("kinetic", "elastic", "gravity")
    parts = [
        [*(geometry.values(f"energy_{kind}") for kind in kinds), _contact_energy(geometry)]
        for geometry in story.geometries
    ]
    title, gravity = "energy", parts[0][2]
    if np.ptp(gravity) < np.abs(gravity).min():
        title, parts = "energy change", [[values - values[0] for values in part] for part in parts]
    totals = [np.sum(part, axis=0) for part in parts]
    if len(totals) > 1:
        return title, "J", _one_for_each_run(story, totals)
    rows = zip(parts[0], (*theme.energies, theme.series[1]), (*kinds, "stop"), strict=True)
    time = story.geometries[0].times
    curves = [Curve(time, values, colour, label) for values, colour, label in rows]
    shown = curves if parts[0][3].any() else curves[:3]
    return title, "J", [*shown, Curve(time, totals[0], theme.ink, "total")]


def _contact_energy(geometry: BeamGeometry) -> Array:
    """Return what stops and contact flexibilities hold (J), (samples,); 0 where an older file does not say."""
    known = "energy_contact" in geometry.history
    return geometry.values("energy_contact") if known else np.zeros(geometry.times.size)


def _one_for_each_run(story: Story, values: Sequence[Array]) -> list[Curve]:
    rows = zip(story.histories, values, story.style.colours.series, story.names, strict=False)
    return [Curve(history["time"].values, found, colour, name) for history, found, colour, name in rows]
