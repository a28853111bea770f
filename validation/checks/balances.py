"""Balances: energy, impulse, and angular momentum about the pin, from histories alone."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise, product

import numpy as np
from scipy.interpolate import CubicSpline

from oblique_impact.beam.operators import BeamOperators, build_operators, cumulative
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import pieces
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.checks.registry import ROUNDING, Measurement, checks_of, within
from oblique_impact.validation.runs import NEAR, NEAR_FINE, NODAL, Array, column, run

check = checks_of("balances", "Balances: energy, impulse, angular momentum")


_LEDGERS: dict[str, tuple[str, ...]] = {
    "hybrid": (),
    "frictionless": ("contact.friction=frictionless",),
    "modified-coulomb": ("contact.friction=modified-coulomb",),
    "restitution": ("contact.restitution=0.7",),
    "kelvin-voigt": ("beam.kelvin_voigt=1e-5",),
    "mass-proportional": ("beam.mass_proportional=2.0",),
    "modal-damping": ("beam.modal_damping_ratio=0.02",),
    "full": ("discretization.kinetics=full",),
    "mean-axis": ("discretization.frame=mean-axis", "discretization.modes=6"),
    "finite-elements": ("discretization.method=fem",),
    "hub": ("root.kind=hub", "root.inertia=0.1", "root.torque=-2.0", "root.hub_radius=0.1", "initial.angle=0.23"),
    "stick": (
        "discretization.frame=mean-axis",
        "discretization.modes=3",
        "contact.mu_static=8",
        "contact.mu_kinetic=6",
    ),
    "driven": ("root.kind=driven", "root.profile=constant-speed", "root.spin_rate=-3.786"),
    "spring": ("contact.normal=spring", "contact.stiffness=1e5", "contact.damping=0.2"),
}
#: how many of these cases have a rigid stop, friction, and damping
_LOSING = {"impact": 13, "friction": 13, "damping": 4}
_SHORT = (*NEAR, "end_time=0.1")  # the first macro-collision and flight after it
_LAW = "conservation of energy: initial + supplied - lost = final"


def _lossy(overrides: tuple[str, ...]) -> History:
    """Run a case of `_LEDGERS` from close above the slope; a driven root has its own speed."""
    driven = "root.kind=driven" in overrides
    start = [key for key in _SHORT if not (driven and key.startswith("initial.angular_velocity"))]
    return run("paper", *start, *overrides)


@check("The energy ledger closes through impacts, friction, damping and torque (event scheme).", seconds=1.5)
def ledger() -> Iterator[Measurement]:
    """Energy that no entry explains, for each kind of loss."""
    for name, overrides in _LEDGERS.items():
        left = _lossy(overrides).summary["energy"]["unaccounted"]
        yield Measurement(f"unaccounted energy, {name}", left, 0.0, "J", 4e-10, _LAW, name)


@check("What is lost has a sign: impacts, friction and damping only take.", seconds=1.5)
def losses() -> Iterator[Measurement]:
    """Smallest loss of all cases, and the largest of each kind so that nothing is checked in vain."""
    summaries = [_lossy(overrides).summary["energy"] for overrides in _LEDGERS.values()]
    given = (
        "what the 14 cases are given: all but the spring have a rigid stop with restitution below 1, all "
        "but the frictionless one have friction, four have damping"
    )
    for kind, losing in _LOSING.items():
        values = [summary[f"lost_{kind}"] for summary in summaries]
        least, sign = min(float(min(values)), 0.0), f"sign-{kind}"
        yield Measurement(f"most negative loss by {kind}", least, 0.0, "J", ROUNDING, "second law", sign)
        # so that no sign is checked in vain
        cases = float(sum(value > 1e-4 for value in values))
        quantity = f"cases that lose more than 0.1 mJ by {kind}"
        yield Measurement(quantity, cases, float(losing), "1", 0.0, given, f"there-{kind}")


@check("Free flight conserves the energy: both frames, first-order and full kinetics, both discretizations.", 2.0)
def free_flight() -> Iterator[Measurement]:
    """Largest change over the largest kinetic energy in 0.2 s at 20 rad/s."""
    text = "conservation of energy"
    flight = ("contact.enabled=false", "initial.angular_velocity=-20.0", "end_time=0.2")
    for choice in product(("first-order", "full"), ("tangent", "mean-axis"), ("modal", "fem")):
        pairs = zip(("kinetics", "frame", "method", "modes"), (*choice, 3), strict=True)
        history = run("paper", *flight, *(f"discretization.{key}={value}" for key, value in pairs))
        total = history.total_energy.values
        change = float(np.abs(total - total[0]).max() / column(history, "energy_kinetic").max())
        quantity = f"relative change, {', '.join(choice)}"
        yield Measurement(quantity, change, 0.0, "1", 2.5e-13, text, "-".join(choice))


@check(
    "The implicit scheme's ledger closes at second order in its step, and its dissipation has its own entry.", 3.0
)
def implicit_ledger() -> list[Measurement]:
    """Unaccounted energy of the nodal beam on an elastic stop at 1/2 and 1/4 of the built-in steps."""
    energies = []
    for part in (2.0, 0.25):
        steps = (f"solver.free_step={2e-5 * part}", f"solver.contact_step={4e-6 * part}")
        energies.append(run("elastic-stop", *steps).summary["energy"])
    left = [abs(energy["unaccounted"]) for energy in energies]
    order, work = float(np.log(left[0] / left[1]) / np.log(8.0)), "trapezoidal work of nonlinear forces"
    gained = min(energies[0]["lost_scheme"], 0.0)
    text = "generalized-alpha with rho_infinity = 0.9 < 1 dissipates (Chung, Hulbert, J. Appl. Mech. 60, 1993)"
    return [
        Measurement("unaccounted energy at a quarter of the steps", left[1], 0.0, "J", 1e-8, _LAW, "quarter"),
        # the largest step does not resolve all vibrations
        Measurement("observed order over a factor of eight", order, 2.0, "1", 0.15, work, "order"),
        Measurement("negative part of the scheme's loss", gained, 0.0, "J", ROUNDING, text, "sign"),
    ]


#: models of a beam in all its nodes whose base or drive does work, and steps (s)
_WORK = {
    "held, shaken": ("root.kind=driven", "base.acceleration=30", "base.frequency=11", "initial.angle=0.4"),
    "spun up at a radius": (
        *("root.kind=driven", "root.profile=spin-up", "root.spin_rate=-3", "root.spin_up_time=0.1"),
        *("root.hub_radius=0.1", "initial.angle=0.4"),
    ),
    "hub with a torque": ("root.kind=hub", "root.inertia=0.1", "root.torque=-2", "root.hub_radius=0.1"),
}
_WORK_STEPS = (4e-5, 4e-6)


@check(
    "The work of base, drive and torque on all nodes closes the ledger of implicit steps, at order 2.", seconds=4.0
)
def implicit_work() -> Iterator[Measurement]:
    """Energy that no entry explains, over the energy at the end, after 0.1 s, and its order."""
    for name, keys in _WORK.items():
        left = []
        for step in _WORK_STEPS:
            energy = run(
                "paper",
                *(*keys, "end_time=0.1", "contact.enabled=false", "beam.kelvin_voigt=1e-4"),
                *("discretization.method=fem", "discretization.modes=0", "discretization.elements=8"),
                *("solver.scheme=generalized-alpha", f"solver.free_step={step}"),
            ).summary["energy"]
            left.append(abs(energy["unaccounted"]) / energy["final"])
        tail = name.split()[0].strip(",")
        yield Measurement(f"unaccounted energy, {name}", left[1], 0.0, "1", 1e-8, _LAW, tail)
        order, work = float(np.log10(left[0] / left[1])), "trapezoidal work"
        # the longer step does not resolve all vibrations
        yield Measurement(f"observed order, {name}", order, 2.0, "1", 0.15, work, f"order-{tail}")


@check("Momentum: the normal impulses of the summary are the integral of the force plus the impacts.", seconds=1.5)
def impulse() -> Iterator[Measurement]:
    """First macro-collision from samples 10 µs apart."""
    text = "impulse = integral of the force; cubic splines through the samples"
    for friction in ("frictionless", "hybrid"):
        history = run("paper", f"contact.friction={friction}", *NEAR_FINE)
        collected = history.summary["macro_collisions"][0]["normal_impulse"]
        time, force = column(history, "time"), np.nan_to_num(column(history, "lambda_n"))
        total = float(sum(_integral(time[piece], force[piece]) for piece in pieces(time) if piece.size >= 4))
        total += sum(event.normal_impulse for event in history.events if event.kind.impulsive)
        yield within(f"normal impulse, {friction}", collected, total, "N s", 6e-10, text, friction)


def _integral(time: Array, values: Array) -> float:
    """Integral over a smooth piece, by a cubic spline."""
    return float(CubicSpline(time, values).integrate(time[0], time[-1]))


def full_momentum(o: BeamOperators, q: Array, qd: Array) -> Array:
    """Angular momentum about the pin, int m (r x v) dx, of the foreshortened beam with nothing dropped."""
    table, mass = o.stations.quadrature, o.sections.mass / o.sections.length
    B, Bd, spin = q[:, 1:].T, qd[:, 1:].T, qd[:, 0]
    slope, slope_rate = table.slopes @ B, table.slopes @ Bd
    x = table.points[:, None] - 0.5 * cumulative(table, slope**2)
    y = table.values @ B
    axial = -cumulative(table, slope * slope_rate) - spin * y
    transverse = table.values @ Bd + spin * x
    return np.asarray(mass * table.weights @ (x * transverse - y * axial))


def _weight_torque(o: BeamOperators, q: Array, gravity: float) -> Array:
    """Moment of the weight about the pin, to second order in the deflection."""
    theta, B = q[:, 0], q[:, 1:]
    lever = np.cos(theta) * (o.Sm - 0.5 * np.einsum("si,ij,sj->s", B, o.D, B)) - np.sin(theta) * (B @ o.P)
    return np.asarray(-gravity * lever)


def momentum_defects(history: History) -> Array:
    """Change of the angular momentum about the pin less the moments of weight and contact, by pieces (N m s)."""
    scenario = Scenario.from_toml(history.scenario_toml)
    o, slope = build_operators(scenario), scenario.slope
    time, q, qd = column(history, "time"), column(history, "q"), column(history, "qd")
    momentum = full_momentum(o, q, qd)
    s, c = np.sin(slope.angle), np.cos(slope.angle)
    x, y = column(history, "tip_x"), column(history, "tip_y")
    arm_n, arm_t = x * c + y * s, x * s - y * c  # moments of unit forces along the normal (-s, c) and (c, s)
    force = arm_n * np.nan_to_num(column(history, "lambda_n"))
    force += arm_t * np.nan_to_num(column(history, "lambda_tau"))
    torque = force + _weight_torque(o, q, scenario.gravity)
    found = []
    for piece in pieces(time):
        if piece.size >= 4:
            done = _integral(time[piece], torque[piece])
            found.append(momentum[piece[-1]] - momentum[piece[0]] - done)
    impacts = {event.time: event for event in history.events if event.kind.impulsive}
    for left, right in pairwise(pieces(time)):
        event = impacts.get(float(time[left[-1]]))
        if event:
            moment = arm_n[right[0]] * event.normal_impulse + arm_t[right[0]] * event.tangential_impulse
            found.append(momentum[right[0]] - momentum[left[-1]] - moment)
    return np.array(found)


@check(
    "Full kinetics: angular momentum about the pin changes by the moments of weight and contact alone.",
    seconds=1.0,
)
def angular_momentum() -> Iterator[Measurement]:
    """Largest defect of a phase or an impact, through a macro-collision."""
    text = "Euler's second law about the pin, int m (r x v) dx by quadrature"
    for frame in ("tangent", "mean-axis"):
        history = run("paper", *NEAR_FINE, "discretization.kinetics=full", f"discretization.frame={frame}")
        worst = float(np.abs(momentum_defects(history)).max())
        yield Measurement(f"largest defect, full, {frame}", worst, 0.0, "N m s", 1.5e-10, text, f"full-{frame}")


@check(
    "The pin is free: in full kinetics the moment there, by equilibrium of the whole beam, is zero.", seconds=1.5
)
def pin_moment() -> Iterator[Measurement]:
    """Largest moment at the pin and at the free end over the largest in the beam, in flight and contact."""
    text = "a frictionless pin and a free end carry no moment"
    for frame, method in product(("tangent", "mean-axis"), ("modal", "fem")):
        shapes = ("kinetics=full", f"frame={frame}", f"method={method}", "modes=3")
        history = run("paper", *_SHORT, *(f"discretization.{key}" for key in shapes))
        moment = history.section_forces()["moment"].values
        ratio = float(np.nanmax(np.abs(moment[:, [0, -1]])) / np.nanmax(np.abs(moment)))
        quantity = f"moment at the ends over the largest, {frame}, {method}"
        yield Measurement(quantity, ratio, 0.0, "1", 3e-12, text, f"{frame}-{method}")


@check("Without gravity the implicit scheme at rho_infinity = 1 conserves the energy of a full mesh.", seconds=1.0)
def implicit_flight() -> Measurement:
    """Relative change over 0.3 s."""
    history = run(
        "paper",
        *NODAL,
        "discretization.elements=8",
        "solver.rho_infinity=1.0",
        "contact.enabled=false",
        "gravity=0.0",
        "initial.angular_velocity=-5.0",
        "end_time=0.3",
        "solver.free_step=1e-4",
    )
    total = history.total_energy.values
    change = float(np.abs(total - total[0]).max() / total[0])
    return Measurement("relative change of the energy", change, 0.0, "1", ROUNDING, "conservation of energy")
