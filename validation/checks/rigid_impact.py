"""The rigid stop: exact impulse law of the continuous beam, effective masses, and the paper's case in SciPy."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.integrate import cumulative_trapezoid

from oblique_impact.history.sample_times import first_sample, last_sample
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.checks.plots import impulse_law_figure
from oblique_impact.validation.checks.registry import ROUNDING, Evidence, Measurement, checks_of, within
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import FEM, FRICTIONLESS, MEAN_AXIS, Array, column, event_times, run

check = checks_of("rigid-impact", "Rigid impact against the exact impulse law")

BENDING, MASS, LENGTH, SPEED = 541.27, 0.86874, 1.0, 3.77
WAVE = float(np.sqrt(BENDING / MASS))  # c (m²/s)
#: a hinged beam that turns as a rigid one and meets a stop with its tip at t = 0
TURNING = (
    f"beam.density={MASS / 3.14e-4}",
    f"beam.youngs_modulus={BENDING / 7.85e-9}",
    "gravity=0.0",
    "slope.origin=[0.0, 0.0]",
    "slope.angle=0.0",
    "initial.angle=0.0",
    f"initial.angular_velocity={-SPEED}",
    FRICTIONLESS,
)


#: of a mass at the tip (kg) and of gravity (m/s²): their product, 10 kN, presses the tip onto the stop, more than
#: the beam ever pulls; gravity's effect on the beam itself is 1e-5 of the impulse
HEAVY, LIGHT = 1e6, 0.01


def _all_modes(elements: int) -> tuple[str, ...]:
    """Keys of a mesh with all of its modes: as many coordinates as the nodes have."""
    return FEM, MEAN_AXIS, f"discretization.elements={elements}", f"discretization.modes={2 * elements}"


def held_tip(elements: int, end_time: float) -> tuple[Array, Array]:
    """Times (s) and impulse (N s) of a beam whose tip is held from t = 0 on, by the weight of a mass on it.

    A tip that does not move feels no inertia: what the mass adds to the impulse is its momentum and its weight.
    """
    overrides = [
        *_all_modes(elements),
        *TURNING,
        f"solver.output_interval={0.4 * (LENGTH / elements) ** 2 / WAVE}",
        f"end_time={end_time}",
        f"beam.tip_mass={HEAVY}",
        f"gravity={LIGHT}",
    ]
    history = simulate(Scenario.builtin("paper", overrides))
    (contact,) = history.contacts
    times, force = column(history, "time"), column(history, "lambda_n") - HEAVY * LIGHT
    total = contact.normal_impulse - HEAVY * (SPEED + LIGHT * (contact.end - contact.start))
    so_far = cumulative_trapezoid(force, times, initial=0.0)
    return times, total - (so_far[-1] - so_far)


def exact_impulse(t: float) -> float:
    """J(t) = (2 m L v0/pi²) sum (1 - cos n² w1 t)/n², w1 = pi² c/L² (N s)."""
    n = np.arange(1, 40_001)
    terms = (1.0 - np.cos(n**2 * np.pi**2 * WAVE / LENGTH**2 * t)) / n**2
    return float(2.0 * MASS * LENGTH * SPEED / np.pi**2 * terms.sum())


@check("A hinged beam whose tip is held from t = 0 on: impulse after 1 and 2 ms, by full meshes.", seconds=6.0)
def impulse_law() -> Evidence:
    """All modes of a mesh; it is a low-pass filter of the exact force, which is a distribution."""
    found, curves = [], {}
    for elements, allowed in ((16, 0.05), (32, 0.02), (50, 0.01)):
        for t, exact in VALUES["5b"].items():
            times, impulse = held_tip(elements, t)
            curves[f"{elements} elements"] = times, impulse
            quantity, computed = f"impulse at {1e3 * t:g} ms, {elements} elements", float(impulse[-1])
            name = f"{elements}-{1e3 * t:g}ms"
            found.append(within(quantity, computed, exact, "N s", allowed, source("5b"), name))
    series = np.linspace(1e-5, 2e-3, 120)
    exact_curve = series, np.array([exact_impulse(float(t)) for t in series])
    return Evidence(found, [impulse_law_figure(curves, exact_curve)])


@check("The first impulse on a mesh is the tip's effective mass times its speed.", seconds=0.5)
def tip_mass() -> Iterator[Measurement]:
    """Impulse 0.0722100668 m h v0 and energy half of that times v0."""
    text = source("5c")
    for elements in (16, 32, 50):
        keys = (*_all_modes(elements), *TURNING, "end_time=1e-9")
        event = simulate(Scenario.builtin("paper", [*keys])).events[0]
        exact = VALUES["5c"]["tip"] * MASS * LENGTH / elements
        mass, quantity = event.normal_impulse / SPEED, f"first impulse over v0, {elements} elements"
        yield within(quantity, mass, exact, "kg", 5e-12, text, f"impulse-{elements}")
        mass, quantity = 2.0 * event.energy_loss / SPEED**2, f"energy lost over v0²/2, {elements} elements"
        yield within(quantity, mass, exact, "kg", 5e-12, text, f"energy-{elements}")


_END = "end_time=0.331"  # of the first macro-collision
_METHODS = {"modal": (), "fem": ("discretization.method=fem", "discretization.elements=64")}
#: of event times (s) and of an impulse (relative): the references have 12 and 10 decimals and are of the same two
#: modes, 64 elements differ by h⁴
_ALLOWED = {"modal": (5e-12, 7e-10), "fem": (2e-9, 1e-7)}


@check("The paper's case with two clamped modes: event times of the first macro-collision.", seconds=1.0)
def scipy_events() -> Iterator[Measurement]:
    """Largest distance from SciPy alone, with and without friction, on both discretizations."""
    for friction in ("frictionless", "hybrid"):
        exact, text = np.array(VALUES[f"two-modes-{friction}"]), source(f"two-modes-{friction}")
        for name, overrides in _METHODS.items():
            times = event_times(run("paper", f"contact.friction={friction}", *overrides, _END))[: exact.size]
            k, allowed = int(np.argmax(np.abs(times - exact))), _ALLOWED[name][0]
            quantity = f"time of event {k + 1}, {friction}, {name}"
            yield Measurement(quantity, times[k], exact[k], "s", allowed, text, f"{friction}-{name}")


@check("The same case: the first impulse.", seconds=0.5)
def scipy_impulse() -> Iterator[Measurement]:
    """Both discretizations."""
    exact, text = VALUES["two-modes-impulse"], source("two-modes-impulse")
    for name, keys in _METHODS.items():
        impulse = run("paper", FRICTIONLESS, *keys, _END).events[0].normal_impulse
        yield within(f"first impulse, {name}", impulse, exact, "N s", _ALLOWED[name][1], text, name)


@check("Rigid stop and 4 to 8 mean-axis modes: impulse of the first macro-collision and energy left.", seconds=1.5)
def scipy_modes() -> Iterator[Measurement]:
    """The two programs find their events on their own; impacts magnify a difference by about 30 each."""
    text = source("rigid-stop-modes")
    common = (FRICTIONLESS, MEAN_AXIS, "end_time=0.34")
    for modes in (4, 6, 8):
        summary = run("paper", *common, f"discretization.modes={modes}").summary
        impulse, left = summary["macro_collisions"][0]["normal_impulse"], summary["energy"]["final"]
        exact, energy = VALUES["rigid-stop-modes"][modes]
        yield Measurement(f"impulse, {modes} modes", impulse, exact, "N s", 1.2e-9, text, f"impulse-{modes}")
        yield Measurement(f"energy left, {modes} modes", left, energy, "J", 4e-9, text, f"energy-{modes}")


@check(
    "The impulse at the onset is -(1 + e) Z'/(D M⁻¹ Dᵀ): the gap rate after it is -e times that before.",
    seconds=1.0,
)
def restitution() -> Iterator[Measurement]:
    """Right and left gap rates of the first event, e = 0 and 0.7."""
    text = "Newton's law of restitution"
    for e in (0.0, 0.7):
        history = run("paper", f"contact.restitution={e}", "end_time=0.32")
        time, rate, impact = column(history, "time"), column(history, "gap_rate"), history.events[0].time
        ratio = -float(rate[last_sample(time, impact)] / rate[first_sample(time, impact)])
        yield Measurement(f"gap rate after over before, e = {e}", ratio, e, "1", ROUNDING, text, f"e{e:g}")
