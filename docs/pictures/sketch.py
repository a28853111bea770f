"""The sketch of beam, pin, angles, slope and signs: a soft beam of the paper's size, in true scale, from a run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oblique_impact import History, Scenario, simulate
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
)


@cache
def run() -> History:
    """Run a beam so soft that its bending is seen without magnification."""
    return simulate(
        Scenario.builtin("paper").replace(
            beam__youngs_modulus=5e9, slope__angle=0.2, discretization__kinetics="full", end_time=0.6
        )
    )


@dataclass(frozen=True)
class Sketch:
    """What is drawn at a time of a run, in the inertial frame (m, rad, N, m/s)."""

    axis: Array  # (stations, 2)
    theta: float
    alpha: float
    origin: Array  # of the slope
    tangent: Array
    normal: Array
    tip: Array  # the contact point
    along: Array  # the point of the frame's x-axis below the contact point
    foot: Array  # of the perpendicular on the slope
    force: tuple[float, float]  # lambda_n, lambda_tau
    slip_rate: float

    @classmethod
    def of(cls, history: History, time: float) -> Sketch:
        """Take a sketch from a run."""
        scenario, now = Scenario.from_toml(history.scenario_toml), history.at(time)
        theta, alpha = float(now["theta"]), scenario.slope.angle
        origin = np.array(scenario.slope.origin)
        tangent, x = (np.array([np.cos(a), np.sin(a)]) for a in (alpha, theta))
        tip = np.array([float(now["tip_x"]), float(now["tip_y"])])
        return cls(
            axis=history.beam_at(time),
            theta=theta,
            alpha=alpha,
            origin=origin,
            tangent=tangent,
            normal=np.array([-tangent[1], tangent[0]]),
            tip=tip,
            along=(tip @ x) * x,
            foot=origin + ((tip - origin) @ tangent) * tangent,
            force=(float(now["lambda_n"]), float(now["lambda_tau"])),
            slip_rate=float(now["slip_rate"]),
        )


def moments(history: History) -> tuple[float, float]:
    """Return the times (s) of the sketches: bent far upwards in flight, pressed most in the first contact."""
    time, deflection = history["time"].values, history["deflection"].values
    contact = history.contacts[0]
    pressed = (time >= contact.start) & (time <= contact.end)
    return (
        float(time[np.argmax(np.where(history["gap"].values > 0.1, deflection, -np.inf))]),
        float(time[np.argmax(np.where(pressed, history["lambda_n"].values, -np.inf))]),
    )


def sketch() -> Figure:
    """Draw both moments side by side."""
    flight, contact = (Sketch.of(run(), time) for time in moments(run()))
    with figure_style(PAGE):
        figure = new_figure(3.0)
        left, right = figure.subplots(1, 2, width_ratios=(1.9, 1.0))
        draw_flight(left, flight)
        draw_contact(right, contact)
    return figure


def draw_flight(axes: Axes, seen: Sketch) -> None:
    """Draw angles, coordinates and the gap."""
    zero, x = np.zeros(2), np.array([np.cos(seen.theta), np.sin(seen.theta)])
    draw_slope(axes, seen.origin, seen.tangent, (-0.06, 0.9), 0.075)
    line(axes, zero, (0.42, 0.0))
    line(axes, zero, 1.07 * x, lw=0.9, ls=(0, (5, 2)))
    frame(axes, zero, seen.theta, 0.26, ("", "$y$"))
    label(axes, 1.07 * x, "$x$", (6.0, 2.0), color=GREY, fontsize=9.5)
    axes.plot(*seen.axis.T, color=SERIES[0], lw=4.0, solid_capstyle="round", zorder=4, label="beam")
    draw_pin(axes)
    label(axes, zero, "$O$", (-11.0, 5.0))
    angle(axes, zero, 0.34, 0.0, seen.theta, r"$\theta$")
    line(axes, seen.origin, seen.origin + np.array([0.24, 0.0]))
    angle(axes, seen.origin, 0.2, 0.0, seen.alpha, r"$\alpha$", shift=(9.0, 0.0))
    draw_point(axes, seen.origin)
    label(axes, seen.origin, "$O_1$", (-3.0, -11.0))
    # the deflection of the contact point from the frame's axis
    arrow(axes, seen.along, seen.tip, name="deflection")
    label(axes, 0.5 * (seen.along + seen.tip), "$u_y > 0$", (7.0, 2.0), ha="left")
    draw_point(axes, seen.tip)
    label(axes, seen.tip, "$P$", (-3.0, 10.0))
    # gap and place along the slope
    aside = 0.18 * seen.tangent
    for end in (seen.foot, seen.tip):
        line(axes, end, end + 1.1 * aside)
    arrow(axes, seen.foot + aside, seen.tip + aside, FREE, both=True, name="gap")
    label(axes, 0.5 * (seen.tip + seen.foot) + aside, "$Z_n > 0$", (22.0, 3.0), color=FREE)
    shift = -0.033 * seen.normal
    arrow(axes, seen.origin + shift, seen.foot + shift, SLIP, both=True, name="slip")
    label(axes, 0.62 * seen.foot + 0.38 * seen.origin + shift, r"$Z_\tau$", (4.0, -9.0), color=SLIP)
    down = np.array([0.62, 0.52])
    arrow(axes, down, down - [0.0, 0.11], GREY, name="gravity")
    label(axes, down - [0.0, 0.055], "$g$", (-8.0, 0.0), color=GREY)
    axes.set(xlim=(-0.1, 1.3), ylim=(-0.12, 0.53))
    plain(axes)


def draw_contact(axes: Axes, seen: Sketch) -> None:
    """Draw the contact point, both directions, the forces on the beam and the velocity of slip."""
    reach = 0.17
    draw_slope(axes, seen.foot, seen.tangent, (-reach, 0.72 * reach), 0.065)
    axes.plot(*seen.axis.T, color=SERIES[0], lw=6.0, solid_capstyle="round", zorder=4)
    frame(
        axes, seen.foot - 0.85 * reach * seen.tangent + 0.055 * seen.normal, seen.alpha, 0.055, (r"$\tau$", "$n$")
    )
    largest = max(map(abs, seen.force))
    for value, direction, name, shift in (
        (seen.force[0], seen.normal, r"$\lambda_n \geq 0$", (4.0, 9.0)),
        (seen.force[1], seen.tangent, r"$\lambda_\tau$", (8.0, -9.0)),
    ):
        end = seen.tip + 0.115 * value / largest * direction
        arrow(axes, seen.tip, end, SLIP, width=1.8, name=name)
        label(axes, end, name, shift, color=SLIP)
    side = np.sign(seen.slip_rate) * seen.tangent
    under = seen.foot - 0.032 * seen.normal
    arrow(axes, under, under + 0.07 * side, INK, name="slip rate")
    sign = "<" if seen.slip_rate < 0.0 else ">"
    label(axes, under + 0.035 * side, rf"$\dot{{Z}}_\tau {sign} 0$", (0.0, -12.0))
    draw_point(axes, seen.tip)
    label(axes, seen.tip, "$P$", (-11.0, 11.0))
    axes.set(xlim=seen.foot[0] + reach * np.array([-1.08, 0.85]), ylim=seen.foot[1] + np.array([-0.12, 0.15]))
    plain(axes)
