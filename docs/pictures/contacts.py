"""Pictures of the theory of the contact: states, stops, what modes leave out, the nodal model."""

from __future__ import annotations

from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from oblique_impact import History, Scenario, simulate
from oblique_impact.beam.operators import build_operators
from oblique_impact.beam.residual_flexibility import residual_flexibility as flexibility_left_out
from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.marching.alpha_state import coefficients
from oblique_impact.renders import draw_contact_map
from oblique_impact.renders.style import PAGE, figure_style

from .paper import GREY, INK, SERIES, STATES, Array, arrow, label, new_figure, plain
from .sketch import moments, run

#: where the states stand, and the events between them: from, to, bend, name and its place
_PLACES = {State.FREE: (0.0, 0.0), State.SLIP: (5.6, 1.35), State.STICK: (5.6, -1.35)}
_ARROWS = (
    ((0.64, 0.08), (4.96, 1.43), -0.16, "impact", (2.3, 1.36)),
    ((4.96, 1.27), (0.64, -0.08), 0.0, "release", (3.15, 0.42)),
    ((0.64, 0.08), (4.96, -1.27), 0.0, "impact", (3.15, -0.42)),
    ((4.96, -1.43), (0.64, -0.08), -0.16, "release", (2.3, -1.36)),
    ((5.82, 1.05), (5.82, -1.05), -0.28, "stick\n" r"$|\lambda_\tau| \leq \mu_s \lambda_n$", (6.95, 0.0)),
    ((5.38, -1.05), (5.38, 1.05), -0.28, "slip\n" r"$|\lambda_\tau| = \mu_s \lambda_n$", (4.45, 0.0)),
    ((-0.62, 0.12), (-0.62, -0.12), 2.4, "rebound", (-1.0, 0.45)),
    ((6.22, 1.47), (6.22, 1.23), -2.4, "reversal", (6.6, 1.8)),
)


def algorithm() -> Figure:
    """The states and what leads from one to another, and the states of a run that sticks."""
    with figure_style(PAGE):
        figure = new_figure(3.0)
        left, right = figure.subplots(1, 2, width_ratios=(1.5, 1.0))
        _draw_states(left)
        history = simulate(Scenario.builtin("sticking"))
        for state in State:
            there = np.where(history["state"].values == state, 1e3 * history["gap"].values, np.nan)
            right.plot(1e3 * history["time"].values, there, color=STATES[state], lw=1.8, label=state.name)
        for event in history.events[:12]:
            if event.kind in (EventKind.IMPACT, EventKind.RELEASE):
                right.plot(1e3 * event.time, 0.0, "o", ms=3.5, color=INK, zorder=5)
        right.set(
            xlabel="time (ms)",
            ylabel="gap (mm)",
            xlim=(548.0, 566.0),
            xticks=range(550, 566, 5),
            ylim=(-0.35, 4.0),
        )
        right.legend(loc="upper right")
    return figure


def _draw_states(axes: Axes) -> None:
    for state, place in _PLACES.items():
        box = {"boxstyle": "round,pad=0.5", "facecolor": "none", "edgecolor": STATES[state], "linewidth": 1.6}
        label(axes, place, state.name, fontweight="bold", color=STATES[state], bbox=box)
    for start, end, bend, text, place in _ARROWS:
        arrow(axes, start, end, bend=bend)
        label(axes, place, text, fontsize=8.5)
    axes.set(xlim=(-1.5, 7.6), ylim=(-1.8, 2.1))
    plain(axes)


@cache
def stop(stiffness: str) -> History:
    """Run the paper's beam onto an elastic stop, to the end of the first macro-collision."""
    return simulate(
        Scenario.builtin("paper").replace(
            contact__normal="spring",
            contact__stiffness=float(stiffness),
            contact__friction="frictionless",
            discretization__frame="mean-axis",
            discretization__modes=24,
            solver__output_interval=1e-5,
            end_time=0.332,
        )
    )


def elastic_stop() -> Figure:
    """The force on three stops, and the impulse of a rigid one against the law of the touch-down."""
    with figure_style(PAGE):
        figure = new_figure(3.0)
        left, right = figure.subplots(1, 2)
        for number, stiffness in enumerate(("1e7", "1e6", "1e5")):
            history = stop(stiffness)
            power = int(np.log10(float(stiffness)))
            time, force = 1e3 * history["time"].values, history["lambda_n"].values
            left.plot(time, force, color=SERIES[(1, 0, 2)[number]], lw=1.1, label=f"$10^{power}$ N/m")
        left.set(xlabel="time (ms)", ylabel=r"$\lambda_n$ (N)", xlim=(316.5, 331.0), ylim=(0.0, 2500.0))
        left.legend(title="stiffness", loc="upper right", ncols=3, columnspacing=1.0)
        _draw_touch_down(right)
    return figure


def touch_down_law(history: History, time: Array) -> Array:
    """Return the impulse (N s) on a continuous beam at times (s) after the touch-down: eq. (short-time)."""
    scenario = Scenario.from_toml(history.scenario_toml)
    beam, first = scenario.beam, history.events[0]
    mass = beam.density * beam.area
    impedance = (beam.youngs_modulus * beam.second_moment) ** 0.25 * mass**0.75 / np.sqrt(2.0)
    beta = float(history.at(first.time, "left")["theta"]) - scenario.slope.angle
    speed = -first.normal_velocity
    return np.asarray(2.0 * impedance * speed * np.sqrt(time / np.pi) / np.cos(beta) ** 2)


@cache
def rigid(elements: int) -> History:
    """Run the full nodal model onto a rigid stop for two milliseconds of contact."""
    return simulate(
        Scenario.builtin("elastic-stop").adapted(
            contact__normal="rigid",
            discretization__elements=elements,
            solver__scheme="time-stepping",
            solver__contact_step=5e-7,
            end_time=0.3193,
        )
    )


def _draw_touch_down(axes: Axes) -> None:
    history = rigid(64)
    ends = [0.0, *(contact.end - history.events[0].time for contact in history.contacts)]
    applied = np.cumsum([0.0, *(contact.normal_impulse for contact in history.contacts)])
    time = np.linspace(0.0, 2e-3, 200)
    axes.plot(1e3 * np.array(ends), applied, color=SERIES[0], label="rigid stop, 64 elements")
    axes.plot(
        1e3 * time,
        touch_down_law(history, time),
        color=GREY,
        ls=(0, (4, 2)),
        label=r"$2 Z v_0 \sqrt{t/\pi}/\cos^2\beta$",
    )
    axes.set(xlabel="time after the touch-down (ms)", ylabel=r"$\int \lambda_n\, \mathrm{d}t$ (N s)")
    axes.set(xlim=(0.0, 2.0), ylim=(0.0, None))
    axes.legend(loc="lower right")


def residual_flexibility() -> Figure:
    """The static stiffness of what is left out, and the second collision with and without it."""
    counts = [4, 6, 8, 12, 16, 24]
    base = Scenario.builtin("paper").replace(
        contact__normal="spring", contact__friction="frictionless", discretization__frame="mean-axis", end_time=0.9
    )
    starts: dict[bool, list[float]] = {True: [], False: []}
    for known in starts:
        for count in counts:
            case = base.replace(discretization__modes=count, contact__residual_flexibility=known)
            starts[known].append(simulate(case).macro_collisions[1]["start"])
    limit = 0.865327  # s, of the page
    with figure_style(PAGE):
        figure = new_figure(2.9)
        left, right = figure.subplots(1, 2)
        modes = np.unique(np.geomspace(2, 64, 16).astype(int))
        clamped = {"mean-axis": False, "tangent": True}
        for (frame, fixed), colour in zip(clamped.items(), SERIES, strict=False):
            rest = [
                1.0
                / flexibility_left_out(
                    build_operators(base.replace(discretization__modes=int(n), discretization__frame=frame)), fixed
                )[0, 0]
                for n in modes
            ]
            left.loglog(modes, rest, "o-", ms=3.5, color=colour, label=frame)
        cube = modes[6:] ** 3.0
        left.loglog(modes[6:], 0.35 * rest[6] * cube / cube[0], color=GREY, ls=(0, (4, 2)), label="$N^3$")
        left.axhline(1e6, color=GREY, lw=0.8, ls=":")
        label(left, (64, 1e6), "stop", (0.0, 6.0), ha="right", fontsize=8.5, color=GREY)
        left.set(xlabel="modes $N$ (1)", ylabel="$1/g_r$ (N/m)")
        left.legend(loc="upper left")
        for known, name, colour in ((False, "without", SERIES[3]), (True, "with residual flexibility", SERIES[0])):
            errors = np.abs(np.array(starts[known]) - limit)
            right.loglog(counts, errors, "o-", ms=4.0, color=colour, label=name)
        right.set(xlabel="modes $N$ (1)", ylabel="second collision: error (s)")
        right.set_xticks(counts, [str(n) for n in counts])
        left.set_xticks([2, 4, 8, 16, 32, 64], ["2", "4", "8", "16", "32", "64"])
        for axes in (left, right):
            axes.minorticks_off()
        right.legend(loc="lower left")
    return figure


@cache
def slap() -> History:
    """Run the case of that name from a little above the table, with the speed of its fall; finely sampled."""
    start, gravity = 0.1, Scenario.builtin("slap").gravity
    speed = np.sqrt(3.0 * gravity * (np.sin(np.pi / 4.0) - np.sin(start)))  # of a rigid bar
    return simulate(
        Scenario.builtin("slap").replace(
            initial__angle=start,
            initial__angular_velocity=-float(speed),
            solver__output_interval=1e-5,
            end_time=0.045,
        )
    )


def contact_map() -> Figure:
    """Where the beam that slaps onto a table touches it."""
    with figure_style(PAGE):
        figure = new_figure(2.7, 6.0)
        _draw_contact_map(figure.subplots())
    return figure


def _draw_contact_map(axes: Axes) -> None:
    scale = draw_contact_map(axes, slap(), PAGE)
    bar = axes.figure.colorbar(scale, ax=axes, label="normal force (N)", ticks=MaxNLocator(4), pad=0.02)
    bar.outline.set_visible(False)
    axes.set(xlabel="time (ms)", ylabel="place along the beam (m)")


def time_stepping() -> Figure:
    """The distance of the beam from the table at four instants of the slap, and where it touches over time."""
    history = slap()
    closed = history["contact_state"].values != State.FREE
    start, end = (history.macro_collisions[0][name] for name in ("start", "end"))
    times = history["time"].values
    with figure_style(PAGE):
        figure = new_figure(2.9)
        left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.25))
        _draw_contact_map(right)
        for part, colour in zip((0.06, 0.19, 0.27, 0.53), SERIES, strict=False):
            # the sample near by with the most places closed
            near = np.flatnonzero(np.abs(times - start - part * (end - start)) < 2e-4)
            k = near[closed[near].sum(axis=1).argmax()]
            place, gap = history["contact_place"].values[k], 1e3 * history["contact_gap"].values[k]
            left.plot(place, gap, color=colour, label=f"{1e3 * times[k]:.2f} ms")
            left.plot(place[closed[k]], gap[closed[k]], "o", ms=3.5, color=colour)
            right.axvline(1e3 * times[k], color=colour, lw=1.0, ls=(0, (4, 2)), zorder=0.5)
        left.set(xlabel="place along the beam (m)", ylabel="gap (mm)", xlim=(0.3, 1.02), ylim=(-0.2, 6.0))
        left.legend()
    return figure


def nodal() -> Figure:
    """Draw the coordinates that W couples, and the spectral radius of generalized-alpha over the step."""
    with figure_style(PAGE):
        figure = new_figure(2.9)
        left, right = figure.subplots(1, 2)
        _draw_coordinates(left)
        steps = np.geomspace(1e-2, 1e4, 400)
        for rho, colour in zip((1.0, 0.8, 0.5, 0.0), SERIES, strict=False):
            radius = [spectral_radius(rho, float(step)) for step in steps]
            right.semilogx(steps, radius, color=colour, label=f"{rho:g}")
        right.set(
            xlabel=r"step $\times$ frequency, $\omega h$ (1)", ylabel="left after a step (1)", ylim=(-0.03, 1.06)
        )
        right.legend(title=r"$\rho_\infty$", loc="lower left")
    return figure


def spectral_radius(rho: float, step: float) -> float:
    """Return what a step of generalized-alpha leaves of a vibration of frequency 1: eq. (alpha-step)."""
    c = coefficients(rho, 0.0)
    # unknown are q1, v1 and a1, known q0, v0 and a0; the acceleration is -q
    new = np.array(
        [
            [1.0, 0.0, -(step**2) * c.beta],
            [0.0, 1.0, -step * c.gamma],
            [1.0 - c.alpha_f, 0.0, 1.0 - c.alpha_m],
        ]
    )
    old = np.array(
        [
            [1.0, step, step**2 * (0.5 - c.beta)],
            [0.0, 1.0, step * (1.0 - c.gamma)],
            [-c.alpha_f, 0.0, -c.alpha_m],
        ]
    )
    return float(np.max(np.abs(np.linalg.eigvals(np.linalg.solve(new, old)))))


def _draw_coordinates(axes: Axes) -> None:
    now = run().at(moments(run())[0])
    x, uy = np.asarray(now["station"]), np.asarray(now["uy"])
    # the mean axis of this shape: theta and B of the total coordinates, relative to the tangent at the root
    weight = np.gradient(x) * x
    mean = float(weight @ uy / (weight @ x))
    turned = float(now["theta"]) - 0.2
    total = (turned + mean) * x + (uy - mean * x)
    axes.plot(x, total, color=SERIES[0], lw=2.4, label="$W$")
    axes.plot(x, (turned + mean) * x, color=GREY, ls=(0, (5, 2)), label=r"$\mathbf{x}\,\theta$")
    axes.fill_between(x, (turned + mean) * x, total, color=SERIES[1], alpha=0.35, lw=0.0, label="$B$")
    axes.plot(x[::4], total[::4], "o", ms=3.5, color=SERIES[0])
    axes.set(xlabel="$x$ (m)", ylabel="transverse displacement (m)", xlim=(0.0, 1.02))
    axes.legend(loc="upper left")
