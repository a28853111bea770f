"""The mass matrix, forces and contact rows that are marched, against Lagrange's equations of the energies.

The energies are written out here from the operators of the discretization; derivatives are exact: the kinetic
energy is quadratic in the velocities, and everything is differentiated by complex steps (Squire and Trapp 1998).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from oblique_impact.beam.beam import Beam, FullBeam
from oblique_impact.beam.operators import BeamOperators, build_operators, cumulative, discretization
from oblique_impact.contact.forces import touched
from oblique_impact.contact.state import Candidate, Contacts
from oblique_impact.kernels.workspace import FREE_ACCELERATION, SUPPLY
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.checks.registry import ROUNDING, Measurement, checks_of, within
from oblique_impact.validation.runs import Array

check = checks_of("equations", "Equations of motion against Lagrange's")

Energy = Callable[[Any, Any], Any]
_STEP = 1e-30
_CASES = {
    "tangent": ("discretization.modes=3",),
    "mean-axis": ("discretization.frame=mean-axis", "discretization.modes=4"),
    "finite-elements": ("discretization.method=fem", "discretization.elements=6", "discretization.modes=3"),
}


def lagrange(lagrangian: Energy, q: Array, qd: Array) -> tuple[Array, Array]:
    """Mass matrix and generalized forces, M q'' = Q, of a Lagrangian that is quadratic in the velocities."""
    unit = np.eye(q.size)

    def momentum(at: Any, rate: Any) -> Any:
        return np.array([0.5 * (lagrangian(at, rate + e) - lagrangian(at, rate - e)) for e in unit])

    mass = np.array([momentum(q, e) for e in unit])
    slope = np.array([np.imag(lagrangian(q + 1j * _STEP * e, qd)) / _STEP for e in unit])
    return mass, slope - np.imag(momentum(q + 1j * _STEP * qd, qd)) / _STEP


def _potential(o: Any, gravity: float, theta: Any, B: Any) -> Any:
    height = np.sin(theta) * (o.Sm - 0.5 * B @ (o.D @ B)) + np.cos(theta) * (o.P @ B)
    return 0.5 * B @ (o.K @ B) + gravity * height


def first_order_lagrangian(o: Any, gravity: float) -> Energy:
    """Kinetic energy to second order in the elastic coordinates, less the potential (theory Sec. 3)."""
    hub = o.sections.hub_inertia

    def lagrangian(q: Any, qd: Any) -> Any:
        B, Bd, spin = q[1:], qd[1:], qd[0]
        turning = o.J + B @ (o.M1 @ B) - B @ (o.C @ B)
        kinetic = 0.5 * turning * spin**2 + spin * (o.S @ Bd) + 0.5 * Bd @ (o.M1 @ Bd)
        kinetic = kinetic + 0.5 * hub * (spin + o.root_slope @ Bd) ** 2
        return kinetic - _potential(o, gravity, q[0], B)

    return lagrangian


def full_lagrangian(o: BeamOperators, gravity: float) -> Energy:
    """Kinetic energy with nothing dropped, by quadrature."""
    table, mass = o.stations.quadrature, o.sections.mass / o.sections.length

    def lagrangian(q: Any, qd: Any) -> Any:
        B, Bd, spin = q[1:], qd[1:], qd[0]
        slope, slope_rate = table.slopes @ B, table.slopes @ Bd
        x, y = table.points - 0.5 * cumulative(table, slope**2), table.values @ B
        a = -cumulative(table, slope * slope_rate) - spin * y
        b = table.values @ Bd + spin * x
        return 0.5 * mass * table.weights @ (a * a + b * b) - _potential(o, gravity, q[0], B)

    return lagrangian


def _state(size: int, length_scale: Array) -> tuple[Array, Array]:
    """A state with deflections of centimetres and velocities of m/s, the same every time."""
    rng = np.random.default_rng(20160923)
    q, qd = rng.uniform(-1.0, 1.0, size), rng.uniform(-1.0, 1.0, size)
    q[1:] *= 0.02 * length_scale
    qd[1:] *= 2.0 * length_scale
    qd[0] = -3.0
    return q, qd


def _relative(computed: Array, exact: Array) -> float:
    return float(np.abs(computed - exact).max() / np.abs(exact).max())


_LAGRANGE = "Lagrange's equations of the energies of theory Sec. 3, differentiated by complex steps"


@check("Mass matrix and forces of the floating frame at a bent, fast state.", seconds=0.5)
def floating_frame() -> Iterator[Measurement]:
    """Both kinetic orders, both frames, both discretizations."""
    for name, overrides in _CASES.items():
        for kinetics in ("first-order", "full"):
            scenario = Scenario.builtin("paper", [*overrides, f"discretization.kinetics={kinetics}"])
            o = build_operators(scenario)
            q, qd = _state(o.size + 1, 1.0 / np.arange(1.0, o.size + 1) ** 2)
            model = Beam(scenario, o).model
            work = model.new_workspace()
            model.evaluate(0.0, q, qd, work)
            energy = (full_lagrangian if kinetics == "full" else first_order_lagrangian)(o, scenario.gravity)
            mass, force = lagrange(energy, q, qd)
            compared = (("mass matrix", work.mass, mass), ("forces", work.forces, force))
            for what, marched, exact in compared:
                quantity = f"{what}, {kinetics}, {name}: relative distance"
                distance, tail = _relative(marched, exact), f"{what.split()[0]}-{kinetics}-{name}"
                yield Measurement(quantity, distance, 0.0, "1", ROUNDING, _LAGRANGE, tail)


#: roots of the full nodal model: those that are free to turn, and one that is turned
_FREE = {"pin": (), "hub": ("root.kind=hub", "root.inertia=0.1", "root.hub_radius=0.2", "initial.angle=0.3")}
_DRIVEN = (
    "root.kind=driven",
    "root.profile=spin-up",
    "root.spin_rate=5",
    "root.spin_up_time=0.1",
    "root.hub_radius=0.2",
)


class _Nodal:
    """A full nodal model of five elements in a bent, fast state, and what Lagrange's equations say of it."""

    time = 0.03  # s

    def __init__(self, root: tuple[str, ...]) -> None:
        keys = ("method=fem", "modes=0", "elements=5")
        nodal = [*(f"discretization.{key}" for key in keys), "contact.enabled=false", *root]
        scenario = Scenario.builtin("paper", nodal)
        self.beam = FullBeam(scenario, discretization("fem").build_nodal(scenario))
        o, size = self.beam.operators, self.beam.size
        frame = np.array([self.beam.split(e)[0] for e in np.eye(size)])  # theta = frame . W
        inner = first_order_lagrangian(o, scenario.gravity)

        def lagrangian(W: Any, Wd: Any) -> Any:
            theta, spin = frame @ W, frame @ Wd
            return inner(np.append(theta, W - o.rigid * theta), np.append(spin, Wd - o.rigid * spin))

        rng = np.random.default_rng(20160923)
        W = 0.4 * o.rigid + 0.01 * rng.uniform(-1.0, 1.0, size)
        self.Wd = -3.0 * o.rigid + rng.uniform(-1.0, 1.0, size)
        self.work = self.beam.model.new_workspace()
        self.evaluated = self.beam.model.evaluate(self.time, W, self.Wd, self.work)
        self.mass, self.force = lagrange(lagrangian, W, self.Wd)


@check(
    "The full nodal model in total coordinates W = x theta + B: mass and forces, gauge terms included.",
    seconds=0.5,
)
def nodal() -> Iterator[Measurement]:
    """Five elements on a pin, in the mean-axis frame, and on a hub with a radius, in the tangent frame."""
    for name, root in _FREE.items():
        found = _Nodal(root)
        columns = np.empty_like(found.mass)
        for k, e in enumerate(np.eye(found.beam.size)):
            found.beam.model.mass_product(found.evaluated.rank_one, found.work, e, columns[:, k])
        of_mass, of_forces = _relative(columns, found.mass), _relative(found.work.forces, found.force)
        tail = "" if name == "pin" else f"-{name}"
        quantity, bound = f"mass, {name}: relative distance", 5.0 * ROUNDING
        yield Measurement(quantity, of_mass, 0.0, "1", bound, _LAGRANGE, f"mass{tail}")
        yield Measurement(
            f"forces, {name}: relative distance", of_forces, 0.0, "1", ROUNDING, _LAGRANGE, f"forces{tail}"
        )


@check(
    "The full nodal model on a root that is turned: balance of forces, and the power of the drive.", seconds=0.5
)
def driven_nodal() -> Iterator[Measurement]:
    """Five elements at a radius; the first coordinate is the angle that is prescribed."""
    found = _Nodal(_DRIVEN)
    contacts = Contacts.new([Candidate()], found.beam.size, packed=True)
    found.beam.model.solve_mass(found.evaluated.rank_one, found.work, contacts, False)
    acceleration = found.work.vectors[FREE_ACCELERATION].copy()
    turn = found.beam.motion.at(found.time).acceleration
    yield within("acceleration of the root", acceleration[0], turn, "rad/s²", ROUNDING, "prescribed", "root")
    of_inertia = found.mass @ acceleration
    # differences of energies give each entry of M to rounding of the largest, and large accelerations cancel
    rounding = float(ROUNDING * np.abs(found.mass).max() * np.abs(acceleration).sum())
    distance, quantity = float(np.abs(of_inertia - found.force)[1:].max()), "M W'' less the forces: largest"
    yield Measurement(quantity, distance, 0.0, "N, N m", rounding, _LAGRANGE, "balance")
    power = float((of_inertia[0] - found.force[0]) * found.Wd[0])
    supplied = found.evaluated.supplied_power + float(found.work.vectors[SUPPLY] @ acceleration)
    allowed = rounding * abs(float(found.Wd[0]))
    yield Measurement("power of the drive", supplied, power, "W", allowed, _LAGRANGE, "power")


def _place(o: BeamOperators, scenario: Scenario, q: Any) -> tuple[Any, Any]:
    """Gap and slip of the beam's end from the integral of its slope."""
    table, slope = o.stations.quadrature, scenario.slope
    along = table.slopes @ q[1:]
    x, y = o.sections.length - 0.5 * table.weights @ along**2, o.contact_shape @ q[1:]
    px, py = x * np.cos(q[0]) - y * np.sin(q[0]), x * np.sin(q[0]) + y * np.cos(q[0])
    s, c = np.sin(slope.angle), np.cos(slope.angle)
    dx, dy = px - slope.origin[0], py - slope.origin[1]
    return dy * c - dx * s, dx * c + dy * s


@check("Gap and slip, their gradients and their accelerations at a bent, fast state.", seconds=0.3)
def contact_rows() -> Iterator[Measurement]:
    """Positions by geometry, rows by complex steps, biases by differences of the rates along the motion."""
    text = "geometry of the bent centreline; gradient by complex steps, bias by central differences"
    for name, overrides in _CASES.items():
        scenario = Scenario.builtin("paper", list(overrides))
        o = build_operators(scenario)
        q, qd = _state(o.size + 1, 1.0 / np.arange(1.0, o.size + 1) ** 2)
        model = Beam(scenario, o).model
        work = model.new_workspace()
        e, normal, tangential = touched(model, 0, 0.0, q, qd, work)
        unit, h = np.eye(q.size), 1e-4

        def rate(at: Array, k: int, o: BeamOperators = o, s: Scenario = scenario, qd: Array = qd) -> float:
            return float(np.imag(_place(o, s, at + 1j * _STEP * qd)[k]) / _STEP)

        rows = (
            ("gap", e.gap, normal, e.gap_rate, e.gap_bias),
            ("slip", e.slip, tangential, e.slip_rate, e.slip_bias),
        )
        for k, (kind, position, computed, speed, bias) in enumerate(rows):
            gradient = np.array([np.imag(_place(o, scenario, q + 1j * _STEP * u)[k]) / _STEP for u in unit])
            bent = (rate(q + h * qd, k) - rate(q - h * qd, k)) / (2.0 * h)
            distance = abs(position - _place(o, scenario, q)[k])
            distance += abs(speed - rate(q, k))
            quantity, tail = f"{kind} and its rate, {name}", f"{kind}-{name}"
            yield Measurement(quantity, distance, 0.0, "m, m/s", ROUNDING, text, tail)
            quantity, tail = f"gradient of the {kind}, {name}: relative distance", f"{kind}-gradient-{name}"
            yield Measurement(quantity, _relative(computed, gradient), 0.0, "1", ROUNDING, text, tail)
            # differences over 1e-4 s of motion err by h² times the third derivative
            quantity, tail = f"acceleration bias of the {kind}, {name}", f"{kind}-bias-{name}"
            allowed = 3e-7 * max(1.0, abs(bent))
            yield Measurement(quantity, bias, bent, "m/s²", allowed, text, tail)
