"""Beams on elastic stops: closed form, converged finite elements, and a published test."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from oblique_impact.contact.stops import ElasticStop
from oblique_impact.history.history import History
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.simulation import simulate_system
from oblique_impact.validation.checks.plots import published_impact_figure
from oblique_impact.validation.checks.registry import ROUNDING, Evidence, Measurement, checks_of, within
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import column, run
from oblique_impact.validation.small_systems import Particle

check = checks_of("springs", "Impact on springs")
published = checks_of("published-impact", "Published impact test")

# the references are linear: at a thousandth of their speed rotations lie below their digits
SCALE, SPEED = 1e-3, 3.77
_METHODS = {
    "modal": ("discretization.method=modal", "discretization.modes=40"),
    "fem": ("discretization.method=fem", "discretization.elements=64", "discretization.modes=40"),
}


def strike(stiffness: float, end_time: float, *discretization: str) -> History:
    """Run the straight beam that turns onto a spring, which its end touches at t = 0."""
    return run(
        "paper",
        "gravity=0.0",
        "initial.angle=0.0",
        f"initial.angular_velocity={-SPEED * SCALE}",
        "slope.angle=0.0",
        "slope.origin=[0.0, 0.0]",
        "contact.normal=spring",
        f"contact.stiffness={stiffness}",
        "contact.friction=frictionless",
        "discretization.frame=mean-axis",
        "solver.output_interval=1e-6",
        f"end_time={end_time}",
        *discretization,
    )


@check("A hinged beam turns onto a spring of 10⁵ and 10⁶ N/m: the first contact.", seconds=2.0)
def first_contact() -> Iterator[Measurement]:
    """Peak, end, impulse and rotation after; the stiffer spring on both discretizations."""
    text = source("5f")
    # the end is located: forty modes with their residual flexibility hardly err, 64 elements by h⁴
    for key, name, of_end in (("1e5", "modal", 2.5e-7), ("1e6", "modal", 1.2e-8), ("1e6", "fem", 3e-6)):
        peak, end, impulse, rotation = VALUES["5f"][key]
        history = strike(float(key), 1.05 * end, *_METHODS[name])
        release = next(e for e in history.events if e.kind.value == "release")
        contact = column(history, "time") <= release.time
        force = column(history, "lambda_n")[contact] / SCALE
        computed = float(np.trapezoid(force, column(history, "time")[contact]))
        turn = SPEED - computed / (0.86874 / 3.0)  # angular momentum about the pin
        where, tail = f"k = {key} N/m, {name}", f"{name}-{key}"
        # samples are 1 us apart
        yield within(f"peak force, {where}", force.max(), peak, "N", 3e-5, text, f"peak-{tail}")
        yield within(f"end of contact, {where}", release.time, end, "s", of_end, text, f"end-{tail}")
        yield within(f"impulse, {where}", computed, impulse, "N s", 4e-5, text, f"impulse-{tail}")
        yield Measurement(f"rotation after, {where}", turn, rotation, "rad/s", 1.5e-4, text, f"turn-{tail}")


@check("The peak of the force before reflections return, on springs of 10⁶ and 10⁷ N/m.", seconds=1.5)
def peak_law() -> Iterator[Measurement]:
    """Mittag-Leffler law of the end of a semi-infinite beam."""
    text = source("5e")
    bending, mass = 68.952e9 * 7.85e-9, 2766.7 * 3.14e-4
    Z = bending**0.25 * mass**0.75 / np.sqrt(2.0)
    for stiffness, allowed in ((1e6, 1.5e-6), (1e7, 3e-5)):  # the stiffer spring asks for higher modes
        at = VALUES["5e"]["x_peak"] * (Z / stiffness) ** (2 / 3)
        exact = VALUES["5e"]["f_peak"] * SPEED * Z ** (2 / 3) * stiffness ** (1 / 3)
        history = strike(stiffness, 2.0 * at, "discretization.method=modal", "discretization.modes=60")
        top = int(np.argmax(column(history, "lambda_n")))
        peak, time = float(column(history, "lambda_n")[top]) / SCALE, column(history, "time")[top]
        spring = f"{stiffness:.0e}"
        yield within(f"peak force, k = {spring} N/m, 60 modes", peak, exact, "N", allowed, text, f"peak-{spring}")
        # the force is flat there
        yield within(f"its time, k = {spring} N/m", time, at, "s", 1.5e-2, text, f"time-{spring}")


@check("A mass bounces on a spring for half a period.")
def mass_on_spring() -> list[Measurement]:
    """Duration, peak and impulse in closed form."""
    mass, stiffness, speed, height = 2.0, 5e3, 3.0, 0.3
    ball, start = Particle(above=0.0, mass=mass), (np.array([0.0, height]), np.array([0.0, -speed]))
    history = simulate_system(ball, *start, 0.5, contact_law=ElasticStop(stiffness), output_interval=1e-3)
    impact, release = history.events
    collision = history.summary["macro_collisions"][0]
    text = "closed form: height/v, v, pi sqrt(m/k), v sqrt(k m), 2 m v"
    duration, peak = np.pi * np.sqrt(mass / stiffness), speed * np.sqrt(stiffness * mass)
    return [
        Measurement("time of the impact", impact.time, height / speed, "s", ROUNDING, text, "time"),
        Measurement("speed of the release", release.normal_velocity, speed, "m/s", 6e-12, text, "speed"),
        Measurement("duration of contact", release.time - impact.time, duration, "s", 5e-13, text, "duration"),
        within("peak force", collision["peak_force"], peak, "N", 8e-8, text, "peak"),
        within("impulse", collision["normal_impulse"], 2.0 * mass * speed, "N s", 1e-12, text, "impulse"),
    ]


def sdnl32_run(method: str) -> History:
    """Run a 14 mm square beam that turns at 3.8 rad/s onto a spring of 18000 N/m; 1 % modal damping."""
    side, mesh = 0.014, {"elements": 20} if method == "fem" else {}
    return simulate(
        Scenario.from_dict(
            {
                "end_time": 0.013,
                "gravity": 0.0,
                "beam": {
                    "length": 0.783,
                    "area": side**2,
                    "second_moment": side**4 / 12.0,
                    "density": 2400.0,
                    "youngs_modulus": 6.7e10,
                    "modal_damping_ratio": 0.01,
                },
                "initial": {"angle": 0.0, "angular_velocity": -3.8},
                "slope": {"origin": [0.0, 0.0], "angle": 0.0},
                "contact": {"normal": "spring", "stiffness": 18000.0, "friction": "frictionless"},
                "discretization": {"method": method, "frame": "mean-axis", "modes": 10} | mesh,
                "solver": {"output_interval": 1e-5},
            }
        )
    )


@published(
    "VPCS SDNL32: a beam turns onto a spring; displacement of its tip at twelve published times.", seconds=1.0
)
def sdnl32() -> Evidence:
    """Twelve times on both discretizations; the published digits allow 0.05 mm."""
    times, exact = np.arange(1.0, 13.0) * 1e-3, np.array(VALUES["8-SDNL32"])
    found, runs = [], {method: sdnl32_run(method) for method in ("modal", "fem")}
    for method, history in runs.items():
        for k, tip in enumerate(np.interp(times, column(history, "time"), column(history, "tip_y"))):
            quantity, name = f"tip displacement at {k + 1} ms, {method}", f"{method}-{k + 1}"
            found.append(Measurement(quantity, tip, exact[k], "m", 5e-5, source("8-SDNL32"), name))
    return Evidence(found, [published_impact_figure(runs, times, exact)])
