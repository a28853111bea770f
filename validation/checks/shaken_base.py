"""A shaken base: transfer function of a clamped beam, a pendulum, Lagrange's equations, balances, one impact."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.operators import BeamOperators, build_operators, cumulative
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.checks.lagrange import Energy, lagrange
from oblique_impact.validation.checks.registry import ROUNDING, Measurement, checks_of, within
from oblique_impact.validation.runs import FEM, FRICTIONLESS, MEAN_AXIS, NEAR, NODAL, SPRING, Array, run, unit_beam

check = checks_of("base", "A shaken base")

_DAMPING = 0.05  # Kelvin-Voigt; of the first mode 9 % of critical
_MODES = 10
_SETTLED = 70.0  # the first mode has decayed by 4e-10
_PER_PERIOD = 40  # samples


def tip_response(w: float) -> complex:
    """Deflection of the tip of a clamped unit beam over the acceleration of its base, exp(i w t), exactly.

    Seen from outside v'''' E I (1 + i w eta) = m w^2 v with the base's motion at the root and a free end:
    v(L)/v(0) = (cosh z + cos z)/(1 + cosh z cos z), z^4 = w^2/(1 + i w eta).
    """
    z = (w * w / (1.0 + 1j * w * _DAMPING)) ** 0.25
    return complex(-((np.cosh(z) + np.cos(z)) / (1.0 + np.cosh(z) * np.cos(z)) - 1.0) / w**2)


def _steady_tip(w: float, steps: int = 0, **shapes: Any) -> complex:
    """Deflection of the tip in steady state over the acceleration of the base, from a start at rest.

    By so many implicit steps from sample to sample, if their number is given.
    """
    period = 2.0 * math.pi / w
    end = math.ceil(_SETTLED / period) * period
    implicit = {"solver__scheme": "generalized-alpha", "solver__rho_infinity": 1.0}
    scenario = unit_beam({"kind": "driven"}, **shapes).replace(
        **(implicit | {"solver__free_step": period / _PER_PERIOD / steps} if steps else {}),
        gravity=0.0,
        end_time=end,
        beam__kelvin_voigt=_DAMPING,
        initial__angle=0.0,
        base__acceleration=0.1,
        base__frequency=w / (2.0 * math.pi),
        solver__output_interval=period / _PER_PERIOD,
    )
    history = simulate(scenario)
    last = slice(-_PER_PERIOD - 1, -1)
    time, tip = history["time"].values[last], history["uy"].values[last, -1]
    # of a whole period, in which sines and cosines are orthogonal: the acceleration is 0.1 Im exp(i w t)
    return complex(2.0 / _PER_PERIOD * np.sum(tip * np.exp(-1j * w * time)) * 1j / 0.1)


@check("A clamped, damped beam on a base that is shaken across it, in steady state.", seconds=2.0)
def transfer_function() -> Iterator[Measurement]:
    """Amplitude and phase of the tip below, near and above the first frequency, by reduced elements near it."""
    text = "exact: the Kelvin-Voigt Euler-Bernoulli beam with a complex stiffness"
    for method, w in (("modal", 2.0), ("modal", 3.4), ("modal", 6.0), ("fem", 3.4)):
        exact, found = tip_response(w), _steady_tip(w, method=method, modes=_MODES)
        # what ten modes leave is of the size of the next one's static deflection, 1/beta^5
        label, name = f"of the tip at w = {w:g}, {_MODES} modes of {method}", f"{method}-{w:g}"
        yield from _against(found, exact, label, name, 1e-6, text)
    exact = tip_response(3.4)
    coarse, fine = (_steady_tip(3.4, steps, method="fem", modes=0, elements=32) for steps in (4, 8))
    order = math.log2(abs(coarse - exact) / abs(fine - exact))
    label = "of the tip at w = 3.4, 32 elements in all nodes"
    extrapolated = (4.0 * fine - coarse) / 3.0
    yield from _against(extrapolated, exact, f"{label}, extrapolated", "nodes-3.4", 1e-6, text)
    yield Measurement(f"order over the step, {label}", order, 2.0, "1", 0.01, "implicit mid-point rule", "order")


def _against(
    found: complex, exact: complex, label: str, name: str, allowed: float, text: str
) -> Iterator[Measurement]:
    """Compare amplitude and phase."""
    yield within(f"amplitude {label}", abs(found), abs(exact), "m/(m/s²)", allowed, text, name)
    phases = float(np.angle(found)), float(np.angle(exact))
    yield Measurement(f"phase {label}", *phases, "rad", allowed, text, f"phase-{name}")


def _on_moving_root(o: BeamOperators, gravity: float, direction: float, full: bool) -> Energy:
    """Kinetic less potential energy in the inertial frame, in [theta, B] and the way of the root, by quadrature.

    First-order kinetics keep what is of second order in the elastic coordinates: the squares of the motion in the
    frame, and the momentum with the shortening.
    """
    table, mass = o.stations.quadrature, o.sections.mass / o.sections.length

    def lagrangian(q: Any, qd: Any) -> Any:
        (theta, B), (spin, Bd) = (q[0], q[1:-1]), (qd[0], qd[1:-1])
        slope, slope_rate = table.slopes @ B, table.slopes @ Bd
        ux, ux_rate = -0.5 * cumulative(table, slope**2), -cumulative(table, slope * slope_rate)
        x, y, y_rate = table.points, table.values @ B, table.values @ Bd
        a, b = ux_rate - spin * y, y_rate + spin * (x + ux)
        along, across = np.cos(direction - theta), np.sin(direction - theta)
        squares = (
            a * a + b * b if full else spin**2 * (y * y + x * x + 2.0 * x * ux) + y_rate**2 + 2 * spin * x * y_rate
        )
        both = squares + 2.0 * qd[-1] * (along * a + across * b) + qd[-1] ** 2
        height = q[-1] * np.sin(direction) + np.sin(theta) * (x + ux) + np.cos(theta) * y
        return mass * table.weights @ (0.5 * both - gravity * height) - 0.5 * B @ (o.K @ B)

    return lagrangian


@check("Forces on a shaken base against Lagrange's equations of a beam whose root moves.", seconds=0.5)
def moving_root() -> Iterator[Measurement]:
    """The way of the root is one more coordinate, whose acceleration is given."""
    text = "Lagrange's equations in the inertial frame, differentiated by complex steps"
    acceleration, direction, t = 37.0, 0.8, 0.031
    for frame, kinetics in product(("tangent", "mean-axis"), ("first-order", "full")):
        scenario = Scenario.builtin("paper").replace(
            discretization__frame=frame,
            discretization__kinetics=kinetics,
            discretization__modes=3,
            beam__youngs_modulus=1e6,  # so soft that elastic forces do not hide the others
            base__acceleration=acceleration,
            base__frequency=7.0,
            base__sweep_rate=20.0,
            base__direction=direction,
        )
        o = build_operators(scenario)
        rng = np.random.default_rng(7)
        q, qd = rng.uniform(-1.0, 1.0, (2, o.size + 2))
        q[1:-1] *= 0.02
        mass, force = lagrange(_on_moving_root(o, scenario.gravity, direction, kinetics == "full"), q, qd)
        model = Beam(scenario, o).model
        work = model.new_workspace()
        found = model.evaluate(t, q[:-1], qd[:-1], work)
        a = acceleration * np.sin(2.0 * np.pi * (7.0 * t + 0.5 * 20.0 * t * t))
        exact = (force - a * mass[-1])[:-1]
        distance = float(np.abs(work.forces - exact).max() / np.abs(exact).max())
        label, name = f"{frame} frame, {kinetics}", f"{frame}-{kinetics}"
        yield Measurement(f"forces, {label}: relative distance", distance, 0.0, "1", ROUNDING, text, name)
        power, supplied = -a * float(mass[-1, :-1] @ qd[:-1]), found.supplied_power
        yield within(f"power of the base, {label}", supplied, power, "W", ROUNDING, text, f"power-{name}")


#: upside down on a pin that is shaken along the vertical, so fast that a rod would stand (Kapitza)
_SHAKE, _FREQUENCY, _START = 9e3, 60.0, 1.4
_END = 0.3


def _pendulum() -> float:
    """Angle of a rod of 1 m at the end: theta'' = -3/2 (g + a(t)) cos theta."""

    def rates(t: float, y: Array) -> tuple[float, float]:
        felt = 9.8 + _SHAKE * math.sin(2.0 * math.pi * _FREQUENCY * t)
        return y[1], -1.5 * felt * math.cos(y[0])

    found = solve_ivp(rates, (0.0, _END), (_START, 0.0), method="DOP853", rtol=1e-13, atol=1e-13)
    return float(found.y[0, -1])


def _stiff_rod(modulus: float) -> float:
    scenario = Scenario.builtin("paper").replace(
        end_time=_END,
        beam__youngs_modulus=modulus,
        initial__angle=_START,
        contact__enabled=False,
        discretization__frame="mean-axis",
        discretization__modes=1,
        base__acceleration=_SHAKE,
        base__frequency=_FREQUENCY,
    )
    return float(simulate(scenario)["theta"][-1])


@check("A stiff beam, upside down on a pin that is shaken along the vertical, is a pendulum.", seconds=1.0)
def pendulum() -> Measurement:
    """Bending changes the angle in proportion to the flexibility; two moduli are extrapolated to a rigid beam."""
    angle = (10.0 * _stiff_rod(1e16) - _stiff_rod(1e15)) / 9.0
    text = "theta'' = -3/2 (g + a(t)) cos theta, integrated by SciPy's DOP853 to 1e-13"
    return Measurement(f"angle after {_END} s", angle, _pendulum(), "rad", 1e-10, text)


#: the paper's beam strikes an elastic stop and is pressed against it by the base
_STRUCK = (*NEAR, "end_time=0.02", SPRING, FRICTIONLESS, "contact.stiffness=1e5", "beam.kelvin_voigt=1e-5")
_SHAKEN = ("base.acceleration=200", "base.frequency=40", "base.direction=1.9")
_PRESSED = (*_STRUCK, *_SHAKEN)
_EIGHT = (MEAN_AXIS, "discretization.modes=8")
_FINE = ("solver.free_step=2e-6", "solver.contact_step=2e-6")
_ALPHA = ("solver.scheme=generalized-alpha", "solver.rho_infinity=1", *_FINE)
_EXACT = (
    "discretization.method=absolute",
    "discretization.elements=16",
    "solver.free_step=1e-5",
    "solver.contact_step=1e-5",
)
#: keys, unaccounted energy (J): the event scheme holds its tolerance, implicit steps sample powers to second
#: order of their length, fixed ones the contact force
_RUNS: dict[str, tuple[tuple[str, ...], float]] = {
    "modes": (_EIGHT, 2e-12),
    "elements": ((FEM, *_EIGHT), 2e-12),
    "full-kinetics": ((*_EIGHT, "discretization.kinetics=full"), 2e-12),
    "fixed-step": ((*_EIGHT, "solver.scheme=fixed-step", *_FINE), 8e-9),
    "generalized-alpha": ((*_EIGHT, *_ALPHA), 3e-7),
    "all-nodes": ((*NODAL, *_ALPHA), 3e-7),
    "exact-beam": (_EXACT, 2e-12),
}


#: the same beam slaps onto a table
_SLAP = ("initial.angle=0", "initial.angular_velocity=-3", "end_time=0.03", *_SHAKEN)
_FOUR = (MEAN_AXIS, "discretization.modes=4")
_RIGID: dict[str, tuple[tuple[str, ...], float]] = {
    "time-stepping, modes": (_FOUR, 1.5e-7),
    "time-stepping, all nodes": (("discretization.elements=32", "contact.grid=32"), 1.5e-7),
    "several contacts, events": ((*_FOUR, "contact.grid=4", "solver.scheme=event"), 4e-12),
}


@check("The energy ledger closes on a shaken base, in every discretization and scheme.", seconds=4.0)
def ledger() -> Iterator[Measurement]:
    """Energy that no entry explains, of 3 J that the base supplies."""
    text = "conservation of energy: initial + supplied - lost = final"
    runs = [("paper", _PRESSED, _RUNS), ("slap", _SLAP, _RIGID)]
    for case, common, variants in runs:
        for name, (keys, tolerance) in variants.items():
            left = run(case, *common, *keys).summary["energy"]["unaccounted"]
            tail = name.replace(", ", "-").replace(" ", "-")
            yield Measurement(f"unaccounted energy, {name}", left, 0.0, "J", tolerance, text, tail)


@check(
    "One contact on a shaken base: schemes, discretizations and the exact beam against each other.", seconds=4.0
)
def one_contact() -> Iterator[Measurement]:
    """End of the contact and its impulse; without the shaking two contacts take its place, with 1.05 N s each."""
    reference = run("paper", *_PRESSED, *_EIGHT).contacts[0]
    full = run("paper", *_PRESSED, *_RUNS["full-kinetics"][0]).contacts[0]
    # fixed steps end a contact at the end of one; elements are reduced to as many modes, all nodes are not
    accuracies = {"elements": (2e-8, 1e-6), "fixed-step": (2e-6, 1e-6), "generalized-alpha": (1e-8, 1e-6)}
    accuracies |= {"all-nodes": (2e-7, 2e-5), "exact-beam": (6e-6, 2e-3)}
    for name, (of_time, of_impulse) in accuracies.items():
        # first-order kinetics are off by 5e-4 here
        exact = name == "exact-beam"
        against, what = (full, "modes, full kinetics") if exact else (reference, "modes, event scheme")
        (found,) = run("paper", *_PRESSED, *_RUNS[name][0]).contacts
        yield Measurement(f"end of the contact, {name}", found.end, against.end, "s", of_time, what, name)
        impulses = found.normal_impulse, against.normal_impulse
        yield Measurement(f"impulse, {name}", *impulses, "N s", of_impulse, what, f"impulse-{name}")


@check("A clamped strip that strikes a stop on a shaken base: modes, elements and the exact beam.", seconds=4.0)
def strip() -> Iterator[Measurement]:
    """The built-in case `shaken`: when its first five contacts begin; it starts at rest."""
    steps = ("solver.free_step=1e-4", "solver.contact_step=1e-4", "discretization.elements=6")
    # mesh and steps of the exact beam take 1e-5 s each, six modes 4e-6 s
    others = {"fem": ((FEM,), 1e-7), "exact": (("discretization.method=absolute", *steps), 3e-5)}
    reference, text = run("shaken", "end_time=0.3").contacts, "six assumed modes, event scheme"
    for name, (keys, tolerance) in others.items():
        found = run("shaken", "end_time=0.3", *keys).contacts
        for number, (contact, other) in enumerate(zip(found, reference, strict=True), start=1):
            quantity, starts = f"start of contact {number}, {name}", (contact.start, other.start)
            yield Measurement(quantity, *starts, "s", tolerance, text, f"{name}-{number}")
