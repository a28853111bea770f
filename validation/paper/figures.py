"""The paper's figures 2 to 16 from our runs: three friction models overlaid, one scheme above the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from oblique_impact.contact.state import State
from oblique_impact.history.history import History
from oblique_impact.renders.bands import drawn
from oblique_impact.renders.style import SERIES, STATE_COLOURS
from oblique_impact.validation.paper.measures import (
    REVERSAL,
    SCHEMES,
    STICK,
    Models,
    Span,
    collisions,
    reversals,
    sticks,
    within,
)
from oblique_impact.validation.report import Picture, picture

#: inches; half of an A4 page within its margins, so that the print is as large as drawn
WIDTH, HEIGHT = 3.55, 4.1

#: colour and line of each model, in the order of `Models`
MODEL_LINES: tuple[dict[str, Any], ...] = (
    {"color": SERIES[0], "linestyle": "-", "linewidth": 1.8, "zorder": 2, "label": "hybrid"},
    {"color": SERIES[5], "linestyle": (0, (1, 1)), "linewidth": 1.2, "zorder": 3, "label": "frictionless"},
    {"color": SERIES[4], "linestyle": (0, (4, 2)), "linewidth": 1.1, "zorder": 4, "label": "modified Coulomb"},
)
#: the instant that the paper names, and the hybrid model's events
PAPER_LINE: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 0.9, "zorder": 1, "label": "paper"}
_MARK: dict[str, Any] = {"linestyle": "none", "markersize": 4.5, "zorder": 6}
REVERSAL_MARK: dict[str, Any] = {**_MARK, "marker": "v", "color": "black", "label": "slip reverses"}
STICK_MARK: dict[str, Any] = {**_MARK, "marker": "o", "color": STATE_COLOURS[State.STICK], "label": "judged stick"}

#: s, the instants that the paper names, by macro-collision
NAMED = {1: REVERSAL, 2: STICK}
#: pixels along the axes: what swings faster than they show is drawn as the range of its values with their mean
_PIXELS = 450.0, 200.0


@dataclass(frozen=True)
class Plot:
    """One of the paper's figures: number, variable, title, axis label, unit.

    With a macro-collision (1 or 2) it shows that alone, in ms and mm, with its events and what the paper names.
    """

    number: int
    variable: str
    title: str
    label: str
    unit: str
    collision: int = 0
    note: str = ""

    @property
    def factor(self) -> float:
        """Factor from SI to the units drawn."""
        return 1e3 if self.collision else 1.0


_NO_IMPACTS = "Impulses of the impacts are not part of a force: they are in the table of runs."
_INERTIAL = (
    "Inertial axes through O: the paper calls (X_F, Y_F) the position of P in the inertial system and gives O₁ in "
    "it, although its Sec. 2 names the floating axes OXY."
)
PLOTS = (
    Plot(2, "lambda_tau", "Tangential friction force", r"friction force $\lambda_\tau$", "N", note=_NO_IMPACTS),
    Plot(3, "lambda_n", "Normal impact force", r"normal force $\lambda_n$", "N", note=_NO_IMPACTS),
    Plot(4, "energy", "Total mechanical energy", "energy $T + V$", "J"),
    Plot(5, "energy_kinetic", "Kinetic energy", "energy $T$", "J"),
    Plot(6, "energy_gravity", "Gravitational potential energy", "energy $V_G$", "J"),
    Plot(7, "energy_elastic", "Elastic potential energy", "energy $V_E$", "J"),
    Plot(8, "theta", "Rotation angle of joint O", r"angle $\theta$", "rad"),
    Plot(9, "theta_dot", "Rotation angular velocity", r"velocity $\dot\theta$", "rad/s"),
    Plot(10, "tip_x", "Impact point along inertial X", "place $X_P$", "m", note=_INERTIAL),
    Plot(11, "tip_vx", "Velocity along inertial X", r"velocity $\dot X_P$", "m/s"),
    Plot(12, "tip_y", "Impact point along inertial Y", "place $Y_P$", "m"),
    Plot(13, "tip_vy", "Velocity along inertial Y", r"velocity $\dot Y_P$", "m/s"),
    Plot(14, "slip", "Impact point along O₁X₁", r"place $Z_\tau$", "m"),
    Plot(15, "slip", "As Fig. 14, 1st macro-collision", r"place $Z_\tau$", "mm", collision=1),
    Plot(16, "slip", "As Fig. 14, 2nd macro-collision", r"place $Z_\tau$", "mm", collision=2),
)


def draw(plot: Plot, schemes: Mapping[str, Models]) -> Picture:
    """Draw one of the paper's figures."""
    caption, name = f"{plot.title}. {plot.note}".strip(), f"Fig. {plot.number}"
    alternative = f"{plot.title} of the three models over time, fixed-step above, event-located below"
    with picture(caption, WIDTH, HEIGHT, alternative, half=True, name=name) as result:
        draw_on(result.figure, plot, schemes)
    return result


def draw_on(figure: Figure, plot: Plot, schemes: Mapping[str, Models]) -> None:
    """Draw one of the paper's figures on a figure of matplotlib's."""
    start, end = window(plot, schemes)
    # the friction of the fixed-step runs would hide that of the others
    axes = figure.subplots(2, 1, sharex=True, sharey=plot.variable != "lambda_tau")
    for part, letter, (scheme, models) in zip(axes, "ab", schemes.items(), strict=True):
        for run, line in zip(models, MODEL_LINES, strict=True):
            _draw_curve(part, plot, run, line, (start, end))
        if plot.collision:
            part.axvline(plot.factor * NAMED[plot.collision], **PAPER_LINE)
            _mark_events(part, plot, models.hybrid)
        part.set_title(f"({letter}) {SCHEMES[scheme]}", fontsize=8.5, fontweight="normal")
        part.set_ylabel(f"{plot.label} ({plot.unit})")
    unit = "ms" if plot.collision else "s"
    axes[1].set(xlabel=f"time ({unit})", xlim=(plot.factor * start, plot.factor * end))
    figure.suptitle(f"Fig. {plot.number}  {plot.title}", fontsize=9, fontweight="bold", x=0.01, ha="left")
    shown = [*MODEL_LINES, *((REVERSAL_MARK, STICK_MARK, PAPER_LINE) if plot.collision else ())]
    handles = [Line2D([], [], **line) for line in shown]
    where: dict[str, Any] = {"loc": "outside lower center", "ncols": 3, "columnspacing": 0.9}
    figure.legend(handles=handles, **where, fontsize=8, handlelength=1.9)


def window(plot: Plot, schemes: Mapping[str, Models]) -> Span:
    """Return the window of time (s) of a figure, the same for both schemes."""
    runs = [run for models in schemes.values() for run in models]
    if not plot.collision:
        return 0.0, max(run.end_time for run in runs)
    found = [
        time for run in runs for span in collisions(run)[plot.collision - 1 : plot.collision] for time in span
    ] + [NAMED[plot.collision]]
    start, end = min(found), max(found)
    margin = 0.06 * (end - start)
    return start - margin, end + margin


def _draw_curve(axes: Axes, plot: Plot, run: History, line: dict[str, Any], window: Span) -> None:
    start, end = window
    times, course = (within(run, name, start, end) for name in ("time", plot.variable))
    course = plot.factor * course
    if plot.variable.startswith("lambda"):
        # forces act for milliseconds: of a band that narrow only the outline would show
        axes.plot(plot.factor * times, course, **line)
        return
    per_pixel = (end - start) / _PIXELS[0]
    shown = drawn((times - start) / per_pixel, course, float(np.ptp(course)) / _PIXELS[1])
    for band in shown.bands:
        x = plot.factor * (start + per_pixel * band.x)
        axes.fill_between(x, band.low, band.high, alpha=0.12, color=line["color"], linewidth=0.0)
        for bound in (band.low, band.high):
            axes.plot(x, bound, **{**line, "linewidth": 0.5 * line["linewidth"], "label": "_"})
    axes.plot(plot.factor * (start + per_pixel * shown.x), shown.y, **line)


def _mark_events(axes: Axes, plot: Plot, run: History) -> None:
    """Mark the hybrid model's reversals and sticks."""
    for span in collisions(run)[plot.collision - 1 : plot.collision]:
        begun = [stay.start for stay in sticks(run, span)]
        for times, mark in ((reversals(run, span), REVERSAL_MARK), (begun, STICK_MARK)):
            if times:
                places = [plot.factor * float(run.at(time)[plot.variable]) for time in times]
                axes.plot(plot.factor * np.array(times), places, **mark)
