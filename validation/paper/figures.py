"""The paper's figures 2 to 16 from our runs: three friction models overlaid, one scheme above the other."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oblique_impact.contact.state import State
from oblique_impact.history.history import History
from oblique_impact.renders import panels
from oblique_impact.renders.style import STATE_COLOURS
from oblique_impact.renders.timeline import contact_spans
from oblique_impact.validation.paper.measures import (
    REVERSAL,
    SCHEMES,
    STICK,
    Models,
    Span,
    collisions,
    reversals,
    sticks,
)
from oblique_impact.validation.report import Picture, picture

#: inches; half of an A4 page within its margins, so that the print is as large as drawn
WIDTH, HEIGHT = 3.55, 4.1

#: what the models are called, in the order of `Models`
MODEL_NAMES = ("hybrid", "frictionless", "modified Coulomb")
#: the instant that the paper names, and the hybrid model's events
PAPER_LINE: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 0.9, "zorder": 1, "label": "paper"}
_MARK: dict[str, Any] = {"linestyle": "none", "markersize": 4.5, "zorder": 6}
REVERSAL_MARK: dict[str, Any] = {**_MARK, "marker": "v", "color": "black", "label": "slip reverses"}
STICK_MARK: dict[str, Any] = {**_MARK, "marker": "o", "color": STATE_COLOURS[State.STICK], "label": "judged stick"}

#: s, the instants that the paper names, by macro-collision
NAMED = {1: REVERSAL, 2: STICK}
#: size of the axes, about
_PIXELS = 450.0, 200.0


@dataclass(frozen=True)
class Plot:
    """One of the paper's figures: number, variable, title, axis label.

    With a macro-collision (1 or 2) it shows that alone, in ms and mm, with its events and what the paper names.
    """

    number: int
    variable: str
    title: str
    label: str
    collision: int = 0
    note: str = ""

    @property
    def unit(self) -> tuple[float, str]:
        """Size and prefix of the unit of its values, the same in both panels."""
        return (1e-3, "m") if self.collision else (1.0, "")


_NO_IMPACTS = "Impulses of the impacts are not part of a force: they are in the table of runs."
_INERTIAL = (
    "Inertial axes through O: the paper calls (X_F, Y_F) the position of P in the inertial system and gives O₁ in "
    "it, although its Sec. 2 names the floating axes OXY."
)
PLOTS = (
    Plot(2, "lambda_tau", "Tangential friction force", r"friction force $\lambda_\tau$", note=_NO_IMPACTS),
    Plot(3, "lambda_n", "Normal impact force", r"normal force $\lambda_n$", note=_NO_IMPACTS),
    Plot(4, "energy", "Total mechanical energy", "energy $T + V$"),
    Plot(5, "energy_kinetic", "Kinetic energy", "energy $T$"),
    Plot(6, "energy_gravity", "Gravitational potential energy", "energy $V_G$"),
    Plot(7, "energy_elastic", "Elastic potential energy", "energy $V_E$"),
    Plot(8, "theta", "Rotation angle of joint O", r"angle $\theta$"),
    Plot(9, "theta_dot", "Rotation angular velocity", r"velocity $\dot\theta$"),
    Plot(10, "tip_x", "Impact point along inertial X", "place $X_P$", note=_INERTIAL),
    Plot(11, "tip_vx", "Velocity along inertial X", r"velocity $\dot X_P$"),
    Plot(12, "tip_y", "Impact point along inertial Y", "place $Y_P$"),
    Plot(13, "tip_vy", "Velocity along inertial Y", r"velocity $\dot Y_P$"),
    Plot(14, "slip", "Impact point along O₁X₁", r"place $Z_\tau$"),
    Plot(15, "slip", "As Fig. 14, 1st macro-collision", r"place $Z_\tau$", collision=1),
    Plot(16, "slip", "As Fig. 14, 2nd macro-collision", r"place $Z_\tau$", collision=2),
)


def draw(plot: Plot, schemes: Mapping[str, Models]) -> Picture:
    """Draw one of the paper's figures."""
    caption, name = f"{plot.title}; contact of the hybrid model shaded. {plot.note}".strip(), f"Fig. {plot.number}"
    alternative = f"{plot.title} of the three models over time, fixed-step above, event-located below"
    with picture(caption, WIDTH, HEIGHT, alternative, half=True, name=name) as result:
        draw_on(result.figure, plot, schemes)
    return result


def draw_on(figure: Figure, plot: Plot, schemes: Mapping[str, Models]) -> None:
    """Draw one of the paper's figures on a figure of matplotlib's."""
    clock = panels.clock(*window(plot, schemes))
    # forces act for milliseconds: of a band that narrow only the outline would show
    pixels = None if plot.variable.startswith("lambda") else _PIXELS
    # the friction of the fixed-step runs would hide that of the others
    axes = figure.subplots(2, 1, sharex=True, sharey=plot.variable != "lambda_tau")
    for part, letter, (scheme, models) in zip(axes, "ab", schemes.items(), strict=True):
        curves = panels.variable(panels.Runs(models, MODEL_NAMES), plot.variable, plot.label)
        spans = contact_spans(models.hybrid)
        panels.draw_curves(part, curves, clock, spans, pixels=pixels, width=1.2, unit=plot.unit)
        if plot.collision:
            part.axvline(float(clock.at(np.array(NAMED[plot.collision]))), **PAPER_LINE)
            _mark_events(part, plot, models.hybrid, clock)
        part.set_title(f"({letter}) {SCHEMES[scheme]}", fontsize=8.5, fontweight="normal")
    axes[0].set_xlabel("")
    figure.suptitle(f"Fig. {plot.number}  {plot.title}", fontsize=9, fontweight="bold", x=0.01, ha="left")
    named = {line.get_label(): line for part in axes for line in part.lines}
    handles = [line for name, line in named.items() if not name.startswith("_")]
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


def _mark_events(axes: Axes, plot: Plot, run: History, clock: panels.Clock) -> None:
    """Mark the hybrid model's reversals and sticks."""
    for span in collisions(run)[plot.collision - 1 : plot.collision]:
        begun = [stay.start for stay in sticks(run, span)]
        for times, mark in ((reversals(run, span), REVERSAL_MARK), (begun, STICK_MARK)):
            if times:
                places = [float(run.at(time)[plot.variable]) / plot.unit[0] for time in times]
                axes.plot(clock.at(np.array(times)), places, **mark)
