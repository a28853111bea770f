"""Charts of force and energy that move with a film: past solid, future faint, a cursor between.

Their time axis is that of the film, so that contacts, around which time is stretched, have a width; its
labels are physical times.  What swings faster than pixels can show is drawn as a band.  Both versions are drawn
once; a frame is cut together from them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from oblique_impact.renders.envelope import drawn
from oblique_impact.renders.letters import Letters
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import Dash, figure_style
from oblique_impact.renders.timeline import Timeline, TimeMap

Array = NDArray[np.float64]

_DPI = 100
_FAINT = 0.22
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
    """A chart as two pictures, one for the past and one for the future, of some size (pixels).

    Its horizontal axis is the film time of `timeline`, the vertical one has a `label` with its unit.  The `story`
    has the colours; the contacts of its first run are shaded.  Large numbers have a prefix to their unit.
    """

    def __init__(
        self,
        curves: Sequence[Curve],
        label: str,
        size: tuple[int, int],
        timeline: Timeline,
        story: Story,
        letters: Letters,
    ) -> None:
        self._theme, self._course, self._letters = story.style.colours, timeline.course, letters
        curves, label = in_short_numbers(curves, label, timeline.course)
        self._spans = [(c.start, c.end) for c in story.histories[0].contacts]
        self._past, self._box = self._draw(curves, label, size, 1.0)
        self._future, _ = self._draw(curves, label, size, _FAINT)

    def _draw(
        self, curves: Sequence[Curve], label: str, size: tuple[int, int], strength: float
    ) -> tuple[Image.Image, tuple[float, float, float, float]]:
        """Return the picture and where its axes are: left, right, top, bottom (pixels)."""
        first, last = self._course.times[[0, -1]]
        with figure_style():
            figure = Figure(figsize=(size[0] / _DPI, size[1] / _DPI), dpi=_DPI, facecolor=self._theme.background)
            canvas = FigureCanvasAgg(figure)
            axes = figure.add_axes(_frame(size, self._letters))
            axes.set_facecolor(self._theme.background)
            box = axes.get_window_extent()
            axes.set_xlim(0.0, box.width)
            for start, end in self._spans:
                if end >= first and start <= last:
                    ends = self._pixels(np.array([start, end]), box.width)
                    axes.axvspan(*ends, color=self._theme.line, alpha=0.6, linewidth=0)
            for curve in curves:
                self._draw_curve(axes, curve, (box.width, box.height), strength)
            self._dress(axes, curves, label)
            cast(Any, canvas).draw()
        picture = Image.fromarray(np.asarray(cast(Any, canvas).buffer_rgba())[..., :3].copy())
        return picture, (box.x0, box.x1, size[1] - box.y1, size[1] - box.y0)

    def _pixels(self, time: Array, width: float) -> Array:
        """Pixels from the left end of the axis at physical times (s)."""
        return self._course.film_at(time) * width / self._course.duration

    def _draw_curve(self, axes: Any, curve: Curve, size: tuple[float, float], strength: float) -> None:
        inside = (curve.time >= self._course.times[0]) & (curve.time <= self._course.times[-1])
        values = curve.values[inside]
        if values.size == 0:
            return
        shown = drawn(self._pixels(curve.time[inside], size[0]), values, float(np.ptp(values)) / size[1])
        width = 1.4 * max(self._letters.scale, 0.7)
        for band in shown.bands:
            axes.fill_between(
                band.x, band.low, band.high, color=curve.colour, alpha=_BAND * strength, linewidth=0.0
            )
            # edges, so that bands over each other can be told apart
            for edge in (band.low, band.high):
                axes.plot(band.x, edge, color=curve.colour, linewidth=0.5 * width, alpha=_EDGE * strength)
        axes.plot(shown.x, shown.y, linestyle=curve.dash, color=curve.colour, linewidth=width, alpha=strength)

    def _dress(self, axes: Any, curves: Sequence[Curve], label: str) -> None:
        theme, letters = self._theme, self._letters
        box = axes.get_window_extent()
        small, large = (letters.size(n) * 72.0 / _DPI for n in (_LABEL, _AXIS))
        ticks, labels = round_times(self._course, box.width, letters.font(_LABEL).getlength)
        axes.set_xticks(self._pixels(ticks, box.width), labels)
        lines = int(np.clip(box.height / (1.9 * letters.size(_LABEL)), 2, 7))
        axes.yaxis.set_major_locator(MaxNLocator(lines, steps=[1, 2, 2.5, 5, 10]))
        axes.tick_params(colors=theme.dim, labelsize=small, length=3 * letters.scale)
        for spine in axes.spines.values():
            spine.set_color(theme.dim)
        axes.grid(color=theme.line)
        axes.set_ylabel(letters.fitting([label], box.height * 1.2, _AXIS), color=theme.ink, fontsize=large)
        axes.yaxis.set_label_coords((1.35 * letters.size(_AXIS) - box.x0) / box.width, 0.5)
        stretched = ["time (s), stretched around contacts"] if np.ptp(self._course.rates) > 0.0 else []
        below = letters.fitting([*stretched, "time (s)"], box.width, _AXIS)
        axes.set_xlabel(below, color=theme.ink, fontsize=large)
        self._add_legend(axes, [curve for curve in curves if curve.label])

    def _add_legend(self, axes: Any, curves: Sequence[Curve]) -> None:
        """Names of several curves above the axes; to the left of them if there is no room otherwise."""
        if len(curves) < 2:
            return
        size = self._letters.size(_LABEL)
        # a line 1.2, gaps 0.5 and 0.9 times as long as letters are high
        length = sum(self._letters.font(_LABEL).getlength(curve.label) + 2.6 * size for curve in curves)
        box, whole = axes.get_window_extent(), axes.figure.bbox.width
        start = min(0.0, (whole - box.x0 - length) / box.width)
        axes.legend(
            handles=[axes.plot([], [], linestyle=c.dash, color=c.colour, lw=2, label=c.label)[0] for c in curves],
            loc="lower left",
            bbox_to_anchor=(start, 1.0),
            ncols=len(curves),
            fontsize=size * 72.0 / _DPI,
            labelcolor=self._theme.ink,
            handlelength=1.2,
            handletextpad=0.5,
            columnspacing=0.9,
            borderpad=0.1,
            borderaxespad=0.2,
        )

    def at(self, time: float) -> Image.Image:
        """Return the picture with its cursor at a physical time (s)."""
        left, right, top, bottom = self._box
        x = left + float(self._pixels(np.array(time), right - left))
        picture = self._future.copy()
        picture.paste(self._past.crop((0, 0, round(x), picture.height)), (0, 0))
        ImageDraw.Draw(picture).line([(round(x), top), (round(x), bottom)], fill=self._theme.ink, width=1)
        return picture


def in_short_numbers(curves: Sequence[Curve], label: str, course: TimeMap) -> tuple[list[Curve], str]:
    """Return curves and their label, "force (N)", in thousands, "force (kN)", or more where they become large."""
    first, last = course.times[[0, -1]]
    shown = [np.abs(curve.values[(curve.time >= first) & (curve.time <= last)]) for curve in curves]
    largest = max((float(values[np.isfinite(values)].max(initial=0.0)) for values in shown), default=0.0)
    size, prefix = next(((size, name) for least, size, name in _PREFIXES if largest >= least), (1.0, ""))
    if size == 1.0:
        return list(curves), label
    return [replace(curve, values=curve.values / size) for curve in curves], label.replace("(", f"({prefix}", 1)


def _frame(size: tuple[int, int], letters: Letters) -> tuple[float, float, float, float]:
    """Place of the axes in a chart, in parts of it: room for the labels."""
    small, large = letters.size(_LABEL), letters.size(_AXIS)
    left, bottom, right, top = 4.3 * small + 1.6 * large, 1.65 * (small + large), 2.8 * small, 2.0 * small
    return left / size[0], bottom / size[1], 1.0 - (left + right) / size[0], 1.0 - (bottom + top) / size[1]


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
