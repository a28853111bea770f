"""The paper's figures 2 to 16 from our runs, three models overlaid, one style.

Every figure has the fixed-step runs (the algorithm as printed) above and the event-located ones below.
What vibrates faster than the picture can show is drawn as a band, as in films.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from oblique_impact.contact.state import State
from oblique_impact.renders.envelope import drawn
from oblique_impact.renders.style import SERIES, STATE_COLOURS
from oblique_impact.validation.report.figures import new_figure, to_svg
from oblique_impact.validation.reproduction.cases import SCHEMES
from oblique_impact.validation.reproduction.measures import Trio, sampled
from oblique_impact.validation.reproduction.runs import Run

#: inches; half of an A4 page within its margins, so that the print is as large as drawn
HALF, WHOLE = 3.55, 7.1

#: colour and line of each model, in the order of `Trio`
MODEL_LINES: tuple[dict[str, Any], ...] = (
    {"color": SERIES[0], "linestyle": "-", "linewidth": 1.8, "zorder": 2, "label": "hybrid"},
    {"color": SERIES[5], "linestyle": (0, (1, 1)), "linewidth": 1.2, "zorder": 3, "label": "frictionless"},
    {"color": SERIES[4], "linestyle": (0, (4, 2)), "linewidth": 1.1, "zorder": 4, "label": "modified Coulomb"},
)
#: line of what the paper says
PAPER_LINE: dict[str, Any] = {"color": "black", "linestyle": ":", "linewidth": 0.9, "zorder": 1}
#: marks of the hybrid model's events
REVERSAL_MARK: dict[str, Any] = {
    "linestyle": "none",
    "marker": "v",
    "color": "black",
    "markersize": 4.5,
    "zorder": 6,
    "label": "slip reverses",
}
STICK_MARK: dict[str, Any] = {
    **REVERSAL_MARK,
    "marker": "o",
    "color": STATE_COLOURS[State.STICK],
    "label": "judged stick",
}

#: s, windows of enlargements: about the second macro-collision, and all that follows the first
LATER, AFTER = (0.64, 0.76), (0.3, 1.0)
#: pixels that are told apart along the axes: what swings faster than they show is drawn as a band
_PIXELS = 450.0, 200.0


@dataclass(frozen=True)
class Plot:
    """One of the paper's figures: number, variable, title, axis label, and how our unit follows from SI.

    `collision` picks a macro-collision as the window of time, `span` one in s; `marks` are the instants (s) that
    the paper names.
    """

    number: str
    variable: str
    title: str
    label: str
    unit: str
    scale: float = 1.0
    collision: int = 0
    marks: tuple[float, ...] = ()
    span: tuple[float, float] | None = None

    @property
    def name(self) -> str:
        """File name without suffix."""
        return f"fig{self.number.zfill(2 if self.number.isdigit() else 3)}"


#: the paper's figures, in its order; those with a letter are enlargements and the same in other axes
PLOTS = (
    Plot("2", "lambda_tau", "Tangential friction force", r"$\lambda_\tau$", "N"),
    Plot("2a", "lambda_tau", "Friction force, 1st collision", r"$\lambda_\tau$", "N", collision=1),
    Plot("3", "lambda_n", "Normal impact force", r"$\lambda_n$", "N"),
    Plot("3a", "lambda_n", "Normal force, 1st collision", r"$\lambda_n$", "N", collision=1),
    Plot("4", "energy", "Total mechanical energy", "$T + V$", "J"),
    Plot("5", "kinetic", "Kinetic energy", "$T$", "J"),
    Plot("6", "gravity", "Gravitational potential energy", "$V_G$", "J"),
    Plot("7", "elastic", "Elastic potential energy", "$V_E$", "J"),
    Plot("5a", "kinetic", "Kinetic energy, enlarged", "$T$", "J", span=LATER),
    Plot("7a", "elastic", "Elastic energy, enlarged", "$V_E$", "J", span=LATER),
    Plot("8", "theta", "Rotation angle of joint O", r"$\theta$", "rad"),
    Plot("9", "theta_dot", "Rotation angular velocity", r"$\dot\theta$", "rad/s"),
    Plot("9a", "theta_dot", "Angular velocity, 1st collision", r"$\dot\theta$", "rad/s", collision=1),
    Plot("10", "tip_x", "Impact point along inertial X", "$X_P$", "m"),
    Plot("11", "tip_vx", "Velocity along inertial X", r"$\dot X_P$", "m/s"),
    Plot("12", "tip_y", "Impact point along inertial Y", "$Y_P$", "m"),
    Plot("13", "tip_vy", "Velocity along inertial Y", r"$\dot Y_P$", "m/s"),
    Plot("10f", "shortening", "As Fig. 10, floating frame", "$u_x(x_F)$", "mm", 1e3),
    Plot("11f", "shortening_rate", "As Fig. 11, floating frame", r"$\dot u_x(x_F)$", "m/s"),
    Plot("12f", "deflection", "As Fig. 12, floating frame", "$u_y(x_F)$", "mm", 1e3),
    Plot("13f", "deflection_rate", "As Fig. 13, floating frame", r"$\dot u_y(x_F)$", "m/s"),
    Plot("14", "slip", "Impact point along O₁X₁", r"$Z_\tau$", "m"),
    Plot("14a", "slip", "As Fig. 14, after the 1st collision", r"$Z_\tau$", "mm", 1e3, span=AFTER),
    Plot("15", "slip", "As Fig. 14, 1st macro-collision", r"$Z_\tau$", "mm", 1e3, 1, (0.325,)),
    Plot("16", "slip", "As Fig. 14, 2nd macro-collision", r"$Z_\tau$", "mm", 1e3, 2, (0.699,)),
)


def window(trios: dict[str, Trio], plot: Plot) -> tuple[float, float]:
    """Return the window of time (s) of a figure, the same for both schemes."""
    runs = [run for trio in trios.values() for run in trio]
    if plot.span:
        return plot.span
    if not plot.collision:
        return 0.0, max(run.end_time for run in runs)
    macros = [macro for run in runs for macro in run.macros[plot.collision - 1 : plot.collision]]
    start = min(*(macro.start for macro in macros), *plot.marks)
    end = max(*(macro.end for macro in macros), *plot.marks)
    margin = 0.06 * (end - start)
    return start - margin, end + margin


def draw(plot: Plot, trios: dict[str, Trio]) -> str:
    """Return one of the paper's figures as SVG text."""
    start, end = window(trios, plot)
    with new_figure(HALF, 4.1) as figure:
        axes = figure.subplots(2, 1, sharex=True, sharey=plot.variable != "lambda_tau")
        for part, letter, scheme in zip(axes, "ab", trios, strict=False):
            _draw_models(part, plot, trios[scheme], start, end)
            part.set_title(f"({letter}) {SCHEMES[scheme]}", fontsize=8.5, fontweight="normal")
            part.set_ylabel(f"{plot.label} ({plot.unit})")
        in_milliseconds = plot.collision > 0
        axes[1].set_xlabel("time (ms)" if in_milliseconds else "time (s)")
        factor = 1e3 if in_milliseconds else 1.0
        axes[1].set_xlim(factor * start, factor * end)
        _head(figure, plot)
        return to_svg(figure)


def _head(figure: Figure, plot: Plot) -> None:
    figure.suptitle(f"Fig. {plot.number}  {plot.title}", fontsize=9, fontweight="bold", x=0.01, ha="left")
    handles = [Line2D([], [], **line) for line in MODEL_LINES]
    if plot.marks:
        handles += [Line2D([], [], **mark) for mark in (REVERSAL_MARK, STICK_MARK)]
        handles.append(Line2D([], [], **PAPER_LINE, label="paper"))
    figure.legend(
        handles=handles,
        loc="outside lower center",
        ncols=3,
        fontsize=8,
        columnspacing=0.9,
        handlelength=1.9,
    )


def _draw_models(axes: Axes, plot: Plot, trio: Trio, start: float, end: float) -> None:
    factor = 1e3 if plot.collision else 1.0
    for run, line in zip(trio, MODEL_LINES, strict=True):
        inside = run.inside(start, end)
        times, values = run["time"][inside], plot.scale * run[plot.variable][inside]
        per_pixel = (end - start) / _PIXELS[0]
        shown = drawn((times - start) / per_pixel, values, float(np.ptp(values)) / _PIXELS[1])
        for band in shown.bands:
            x = factor * (start + per_pixel * band.x)
            axes.fill_between(x, band.low, band.high, alpha=0.12, color=line["color"], linewidth=0.0)
            for bound in (band.low, band.high):
                axes.plot(x, bound, **{**line, "linewidth": 0.5 * line["linewidth"]})
        axes.plot(factor * (start + per_pixel * shown.x), shown.y, **line)
    for mark in plot.marks:
        axes.axvline(factor * mark, **PAPER_LINE)
    if plot.marks:
        _mark_events(axes, plot, trio.hybrid, factor)


def _mark_events(axes: Axes, plot: Plot, run: Run, factor: float) -> None:
    """Mark the hybrid model's reversals and sticks."""
    for macro in run.macros[plot.collision - 1 : plot.collision]:
        sticks = [stick.start for stick in run.sticks_in(macro)]
        for times, mark in ((run.reversals_in(macro), REVERSAL_MARK), (sticks, STICK_MARK)):
            if times:
                places = [plot.scale * run.at("slip", time) for time in times]
                axes.plot(factor * np.array(times), places, **mark)


def summary(plot: Plot, trios: dict[str, Trio]) -> list[dict[str, Any]]:
    """Return what a figure shows in numbers (SI units): extremes and some values of each curve."""
    start, end = window(trios, plot)
    rows = []
    for scheme, trio in trios.items():
        for model, run in zip(trio._fields, trio, strict=True):
            inside = run.inside(start, end)
            times, values = run["time"][inside], run[plot.variable][inside]
            least, most = int(np.argmin(values)), int(np.argmax(values))
            rows.append(
                {
                    "figure": plot.number,
                    "variable": plot.variable,
                    "unit": plot.unit if plot.scale == 1.0 else "m",
                    "scheme": scheme,
                    "model": model,
                    "start": float(start),
                    "end": float(end),
                    "minimum": float(values[least]),
                    "minimum_time": float(times[least]),
                    "maximum": float(values[most]),
                    "maximum_time": float(times[most]),
                    "mean": float(sampled((run,), plot.variable, start, end).mean()),
                    "last": float(values[-1]),
                    "samples": int(values.size),
                }
            )
    return rows
