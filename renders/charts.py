"""Panels over the time of the film of a run: in films with a cursor that moves, and in pages.

Their time axis is that of the film, so that contacts, around which time is stretched, have a width; its
labels are physical times.  What swings faster than pixels can show is drawn as a band.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from oblique_impact.renders.geometry import Array
from oblique_impact.renders.layout import Box
from oblique_impact.renders.panels import BAND, BAND_WORDS, Clock, Curves, draw_curves
from oblique_impact.renders.sheet import Sheet
from oblique_impact.renders.story import Story
from oblique_impact.renders.timeline import TimeMap, contact_spans

_FAINT = 0.3  # strength of the future
_LABEL, _AXIS = 9.5, 10.5  # points, where text has 10
_STEPS = [1, 2, 2.5, 5, 10]  # between labels of an axis, times a power of ten


def film_clock(course: TimeMap, width: float) -> Clock:
    """Return the clock of a film on axes of some width (pixels): its places are pixels from their left end."""
    first, last = course.times[[0, -1]].tolist()
    per_second = width / (course.duration or 1.0)
    label = "time (s), stretched around contacts" if np.ptp(course.rates) > 0.0 else "time (s)"
    return Clock(first, last, lambda times: course.film_at(times) * per_second, label)


def draw_over_film(
    axes: Axes,
    panel: Curves,
    story: Story,
    course: TimeMap,
    size: tuple[float, float],
    ticks: tuple[int, int],
    width: float,
) -> bool:
    """Draw curves, and the contacts of the first run of a story, over the film time of `course`; whether as bands.

    The axes, of some `size` (pixels), get pixels from their left end; lines have some `width` (points), and there
    are at most so many `ticks` along both axes.
    """
    spans, shade = contact_spans(story.histories[0]), story.style.colours.line
    has_bands = draw_curves(axes, panel, film_clock(course, size[0]), spans, shade, size, width)
    mark_times(axes, course, size[0], ticks[0])
    axes.yaxis.set_major_locator(MaxNLocator(ticks[1], steps=_STEPS))
    return has_bands


def mark_times(axes: Axes, course: TimeMap, width: float, most: int) -> None:
    """Write at most so many times below axes over film time, of some width (pixels)."""
    times, labels = round_times(course, most)
    axes.set_xticks(course.film_at(times) * width / (course.duration or 1.0), labels)


class Chart:
    """A chart in a box (pixels) of a sheet, drawn once; over it a cursor moves.

    Its horizontal axis is the film time of `course`.
    """

    def __init__(self, sheet: Sheet, panel: Curves, box: Box, course: TimeMap, story: Story) -> None:
        self._course, self._box, theme = course, box, sheet.theme
        small, large = sheet.pixels(_LABEL), sheet.pixels(_AXIS)
        x0, x1 = box[0] + 4.3 * small + 1.6 * large, box[0] + box[2] - 2.8 * small
        y0, y1 = box[1] + 2.0 * small, box[1] + box[3] - 1.65 * (small + large)
        self._left, self._width, self._background = x0, x1 - x0, to_rgb(theme.background)
        self._inside = slice(round(y0), round(y1)), slice(round(x0) + 1, round(x1) + 1)
        axes = sheet.add_axes(x0, y0, x1 - x0, y1 - y0)
        ticks = int((x1 - x0) / (5.5 * small)), int(np.clip((y1 - y0) / (1.9 * small), 2, 7))
        size, thin = (x1 - x0, y1 - y0), sheet.thin
        has_bands = draw_over_film(axes, panel, story, course, size, ticks, 1.4 * thin)
        axes.tick_params(colors=theme.dim, labelsize=sheet.points(_LABEL), length=4.0 * thin)
        for spine in axes.spines.values():
            spine.set_color(theme.dim)
        label = axes.get_ylabel()
        if len(label) * 0.6 * large > box[3] and label.count(" ") > 1:
            label = label.split(" ", 1)[1]
        axes.set_ylabel(label, fontsize=sheet.points(_AXIS))
        axes.yaxis.set_label_coords((1.35 * large - (x0 - box[0])) / (x1 - x0), 0.5)
        axes.set_xlabel(axes.get_xlabel(), fontsize=sheet.points(_AXIS))
        curves = panel.curves if len(panel.curves) > 1 else []
        handles: list[Any] = [Line2D([], [], linestyle=c.dash, color=c.colour, lw=2.7 * thin) for c in curves]
        labels = [curve.label for curve in curves]
        if has_bands and len(curves) <= 2:  # beside more there is no room
            handles.append(Patch(color=panel.curves[0].colour if not curves else theme.dim, alpha=2.0 * BAND))
            labels.append(BAND_WORDS)
        if handles:
            axes.legend(
                handles,
                labels,
                loc="lower left",
                bbox_to_anchor=(0.0, 1.0),
                ncols=len(handles),
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
