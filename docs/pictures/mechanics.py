"""Pictures of the theory of the motion: shapes and shortening, orders of kinetics, frames, gap and slip."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oblique_impact import History, Scenario, natural_frequencies, simulate
from oblique_impact.beam.operators import build_operators
from oblique_impact.contact.state import State
from oblique_impact.modal.eigenfunctions import Eigenfunctions, Family
from oblique_impact.renders.style import PAGE, figure_style

from .paper import (
    FREE,
    GREY,
    INK,
    SERIES,
    SLIP,
    Array,
    angle,
    arrow,
    draw_pin,
    draw_point,
    draw_slope,
    frame,
    label,
    line,
    new_figure,
    plain,
    shade_contacts,
)
from .sketch import Sketch, moments, run


@cache
def paper(*changes: str) -> History:
    """Run the paper's case to the end of its first macro-collision."""
    return simulate(Scenario.builtin("paper", ["end_time=0.335", "solver.output_interval=1e-5", *changes]))


def kinematics() -> Figure:
    """A bent beam in its frame with both displacements; the shapes of both families."""
    now = run().at(moments(run())[0])
    x = np.asarray(now["station"])
    # magnified, and the shortening with the square, as the formula has it
    factor = 2.5
    ux, uy = factor**2 * np.asarray(now["ux"]), factor * np.asarray(now["uy"])
    with figure_style(PAGE):
        figure = new_figure(2.9)
        left, middle, right = figure.subplots(1, 3, width_ratios=(1.7, 1.0, 1.0))
        _draw_displacement(left, x, ux, uy)
        families: tuple[tuple[Axes, Family, str], ...] = (
            (middle, "clamped-free", "tangent frame"),
            (right, "hinged-free", "mean-axis frame"),
        )
        for axes, family, title in families:
            places = np.linspace(0.0, 1.0, 121)
            shapes = Eigenfunctions(family, 3, 1.0).derivative(places, 0)
            for number, colour in enumerate(SERIES[:3]):
                axes.plot(places, shapes[:, number], color=colour, label=f"{number + 1}")
            axes.set(title=title, xlabel="$x/L$ (1)", ylim=(-2.9, 2.2))
        middle.set(ylabel=r"shape $\phi_i$ (1)")
        right.legend(title="mode", loc="lower center", ncols=3, columnspacing=0.9, handlelength=1.2)
    return figure


def _draw_displacement(axes: Axes, x: Array, ux: Array, uy: Array) -> None:
    for end, name in (((1.12, 0.0), "$x$"), ((0.0, 0.36), "$y$")):
        arrow(axes, (0.0, 0.0), end, GREY, width=0.9)
        label(axes, end, name, (0.0, 8.0), color=GREY)
    axes.plot(x, 0.0 * x, color=SERIES[0], lw=3.0, alpha=0.25, solid_capstyle="round")
    axes.plot(x + ux, uy, color=SERIES[0], lw=3.4, solid_capstyle="round")
    for part in np.linspace(0.25, 1.0, 4):
        i = int(np.argmin(np.abs(x - part * x[-1])))
        line(axes, (x[i], 0.0), (x[i] + ux[i], uy[i]), ls=(0, (3, 2)))
    tip = np.array([x[-1] + ux[-1], uy[-1]])
    arrow(axes, (tip[0], 0.0), tip, INK)
    label(axes, (tip[0], 0.55 * tip[1]), "$u_y$", (-10.0, 2.0))
    # the shortening, below the axis
    below = -0.05
    for place in (tip[0], x[-1]):
        line(axes, (place, 0.0), (place, 1.6 * below))
    arrow(axes, (x[-1] + 0.09, below), (x[-1], below), INK, width=0.9)
    arrow(axes, (tip[0] - 0.09, below), (tip[0], below), INK, width=0.9)
    label(axes, (0.5 * (tip[0] + x[-1]), below), "$u_x < 0$", (0.0, -14.0))
    draw_pin(axes, 0.05)
    axes.set(xlim=(-0.1, 1.2), ylim=(-0.22, 0.45))
    plain(axes)


def motion() -> Figure:
    """Deflection of a beam that spins up, by the orders of its kinetic energy."""
    with figure_style(PAGE):
        figure = new_figure(2.9)
        left, right = figure.subplots(1, 2)
        cases = (("zeroth-order", 1), ("first-order", 0), ("full", 2))
        for kinetics, number in cases:
            history = simulate(
                Scenario.builtin("spin-up", ["discretization.modes=4", f"discretization.kinetics={kinetics}"])
            )
            style = {"color": SERIES[number], "label": kinetics, "ls": (0, (4, 2)) if number == 2 else "-"}
            time, tip = history["time"].values, history["deflection"].values
            seen = np.maximum.accumulate(np.abs(tip)) < 5.0
            left.plot(time[seen], tip[seen], **style)
        left.set(
            title="spin-up to 6 rad/s", xlabel="time (s)", ylabel="deflection of the tip (m)", ylim=(-2.0, 0.5)
        )
        left.legend(loc="lower right", title="kinetics")
        _draw_frequencies(right)
    return figure


def _draw_frequencies(axes: Axes) -> None:
    """Draw the first chordwise frequency of the spinning beam, with foreshortening (C) and without it."""
    scenario = Scenario.builtin("spin-up", ["discretization.modes=4"])
    operators, rates = build_operators(scenario), np.linspace(0.0, 6.0, 61)
    first = operators.natural_frequencies()[0]
    chordwise = natural_frequencies(scenario, rates.tolist(), 1).chordwise[:, 0]
    softened = np.sqrt(np.maximum(first**2 - rates**2, 0.0))
    axes.plot(rates, softened, color=SERIES[1], label=r"without $C$: $\sqrt{\omega_1^2 - \Omega^2}$")
    axes.plot(rates, chordwise, color=SERIES[0], label="with $C$")
    axes.set(
        title="first frequency in the plane", xlabel="spin rate $\\Omega$ (rad/s)", ylabel="frequency (rad/s)"
    )
    axes.set(xlim=(0.0, 6.0), ylim=(0.0, None))
    axes.legend(loc="lower left")


def frames() -> Figure:
    """Both frames on one bent beam, and the velocity of each through a collision."""
    tangent = paper("contact.friction=frictionless")
    mean = paper("contact.friction=frictionless", "discretization.frame=mean-axis", "discretization.modes=4")
    with figure_style(PAGE):
        figure = new_figure(2.9)
        left, right = figure.subplots(1, 2)
        _draw_frames(left)
        for history, name, colour in (
            (tangent, "tangent, 2 modes", SERIES[1]),
            (mean, "mean-axis, 4 modes", SERIES[0]),
        ):
            right.plot(1e3 * history["time"].values, history["theta_dot"].values, color=colour, label=name)
        right.set(
            xlabel="time (ms)", ylabel=r"$\dot\theta$ (rad/s)", xlim=(314.0, 335.0), xticks=range(315, 336, 5)
        )
        right.legend(loc="lower right")
    return figure


def _draw_frames(axes: Axes) -> None:
    history = simulate(
        Scenario.builtin("paper").replace(
            beam__youngs_modulus=5e9,
            slope__angle=0.2,
            end_time=0.6,
            discretization__frame="mean-axis",
            discretization__kinetics="full",
            discretization__modes=4,
        )
    )
    now = history.at(moments(history)[0])
    x, uy = np.asarray(now["station"]), 4.0 * np.asarray(now["uy"])
    slope = (uy[1] - uy[0]) / (x[1] - x[0])
    axes.plot(x, uy, color=SERIES[0], lw=3.4, solid_capstyle="round")
    for turn, name, colour in ((0.0, "mean axis", INK), (float(np.arctan(slope)), "tangent", SERIES[1])):
        unit = np.array([np.cos(turn), np.sin(turn)])
        arrow(axes, (0.0, 0.0), 1.12 * unit, colour, width=1.0)
        label(axes, 1.12 * unit, name, (0.0, -9.0), ha="right", color=colour)
    draw_pin(axes, 0.05)
    axes.set(xlim=(-0.1, 1.2), ylim=(1.12 * slope - 0.12, 0.36))
    plain(axes)


def contact() -> Figure:
    """The contact point over the slope; gap and slip rate through the first macro-collision."""
    history = paper()
    with figure_style(PAGE):
        figure = new_figure(3.3)
        grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.5))
        _draw_point(figure.add_subplot(grid[:, 0]))
        upper = figure.add_subplot(grid[0, 1])
        lower = figure.add_subplot(grid[1, 1], sharex=upper)
        time = 1e3 * history["time"].values
        for axes in (upper, lower):
            shade_contacts(axes, history, 1e3)
        upper.plot(time, 1e3 * history["gap"].values, color=FREE)
        upper.set(ylabel="gap $Z_n$ (mm)", ylim=(-0.2, 3.0))
        upper.tick_params(labelbottom=False)
        for other, name, style in (
            (history, "with $H_F$", {"color": SLIP}),
            (paper("contact.shortening=false"), "without", {"color": SERIES[3], "ls": (0, (3, 1.5))}),
        ):
            closed = other["state"].values != State.FREE
            rate = np.where(closed, other["slip_rate"].values, np.nan)
            lower.plot(1e3 * other["time"].values, rate, label=name, **style)
        lower.axhline(0.0, color=GREY, lw=0.6)
        lower.set(
            xlabel="time (ms)", ylabel=r"slip rate $\dot{Z}_\tau$ (m/s)", xlim=(316.0, 332.0), ylim=(-0.45, 0.75)
        )
        lower.legend(loc="upper left", ncols=2)
    return figure


def _draw_point(axes: Axes) -> None:
    seen = Sketch.of(run(), moments(run())[0])
    origin, tangent, normal = np.zeros(2), seen.tangent, seen.normal
    tip = 0.12 * tangent + 0.15 * normal
    draw_slope(axes, origin, tangent, (-0.2, 0.3), 0.06)
    x = np.array([np.cos(seen.theta), np.sin(seen.theta)])
    # the beam's last part, shifted to the contact point
    axis = seen.axis - seen.tip + tip
    axes.plot(*axis.T, color=SERIES[0], lw=4.0, solid_capstyle="round", clip_on=True)
    line(axes, tip, tip + 0.19 * x, ls=(0, (4, 2)))
    line(axes, tip, tip + 0.19 * tangent)
    label(axes, tip + 0.19 * x, "$x$", (-3.0, 7.0), color=GREY)
    angle(axes, tip, 0.14, seen.alpha, seen.theta, r"$\beta$", shift=(23.0, 4.0))
    foot = (tip @ tangent) * tangent
    arrow(axes, foot, tip, FREE, both=True)
    label(axes, 0.5 * (foot + tip), "$Z_n$", (11.0, 0.0), color=FREE)
    draw_point(axes, tip)
    label(axes, tip, "$P$", (-4.0, 11.0))
    frame(axes, 0.19 * tangent + 0.012 * normal, seen.alpha, 0.07, (r"$\tau$", "$n$"))
    axes.set(xlim=(-0.21, 0.32), ylim=(-0.11, 0.3))
    plain(axes)
