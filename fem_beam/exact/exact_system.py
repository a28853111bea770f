"""The beam of a scenario as a mechanical system: its load, its root, and the places where it touches."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.beam.base_motion import BaseMotion, drive_angle
from oblique_impact.beam.beam import contact_places
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.point_forces import forces_of
from oblique_impact.beam.shaking import Shaking, base_acceleration, shaking_of
from oblique_impact.contact.state import Candidate, Contacts
from oblique_impact.fem_beam.exact.elastic_sections import ElasticSections
from oblique_impact.fem_beam.exact.exact_beam import ExactBeam
from oblique_impact.fem_beam.exact.point_loads import COLUMNS, PlacedForces
from oblique_impact.fem_beam.exact.root import (
    ANGLE_AFTER,
    ANGLE_BEFORE,
    ARM,
    ROOT_DAMPING,
    ROOT_NUMBERS,
    ROOT_STIFFNESS,
)
from oblique_impact.fem_beam.exact.step_forces import FIELDS, NODE, BeamData
from oblique_impact.fem_beam.exact.stop import TOUCHING, node_on_side, place_of, point_on_beam
from oblique_impact.fem_beam.mesh import mesh_of
from oblique_impact.kernels.band_rows import new_rows
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.laws import Law
from oblique_impact.kernels.workspace import (
    FREE_ACCELERATION,
    SUPPLY,
    VECTORS,
    Array,
    Evaluation,
    Workspace,
    record_of,
)
from oblique_impact.scenario.scenario import Scenario

#: what is one number of the beam with its root
EXACT_NUMBERS = np.dtype(
    [
        # prescribed unknowns, the first ones: 2 of a root that turns, 3 of a rigid clamp, 0 of a free beam
        ("held", np.int64),
        ("driven", np.int64),  # whether the root's angle is prescribed
        ("torque", float),  # on a hub (N m)
        ("kelvin_voigt", float),  # s
        ("hub_radius", float),  # m
        ("root_stiffness", float),  # N m/rad, between a hub and the ground or a drive and the first section
        ("root_damping", float),  # N m s/rad
        ("angle", float),  # rad, of the root at the start
        ("spin_rate", float),  # rad/s, at the end of the spin-up of a driven root
        ("spin_up_time", float),  # s
    ],
    align=True,
)


# `MeanStep.times`
LENGTH, MIDDLE = range(2)


class MeanStep(NamedTuple):
    """The step that has begun."""

    q: Array  # (d,) at its start
    begun: Array  # (elements, 2, 8) state at Gauss points there
    ended: Array  # and at its end, as far as iterations have come
    load: Array  # (d,) mean forces from outside
    forces: Array  # (k, 7) those at places of the beam, see the module `point_loads`
    root: Array  # (5,) see the module `root`
    moved: Array  # (3,) displacements of the unknowns of a driven root, m, and its turn
    move: Array  # (d,) displacements, as far as iterations have come
    pull: Array  # (2,) N, what acts on the first node then
    rows: Array  # (d + 8, 17) derivatives of the forces by the end, and their factors
    times: Array  # (2,) s, its length and its middle

    @classmethod
    def new(cls, elements: int, forces: int) -> MeanStep:
        """Allocate it for a beam with so many forces at places of it."""
        d, fields = NODE * (2 * elements + 1), (elements, 2, FIELDS)
        return cls(
            q=np.zeros(d),
            begun=np.zeros(fields),
            ended=np.zeros(fields),
            load=np.zeros(d),
            forces=np.zeros((forces, COLUMNS)),
            root=np.zeros(ROOT_NUMBERS),
            moved=np.zeros(NODE),
            move=np.zeros(d),
            pull=np.zeros(2),
            rows=new_rows(d),
            times=np.ones(2),
        )


class _ExactData(NamedTuple):
    """The beam with its root and its places of contact, constant during a run."""

    numbers: Any  # a record of `EXACT_NUMBERS`
    beam: BeamData
    touchings: Any  # (n,) records of `TOUCHING`
    load: Array  # (d,) weight, and the torque on a hub
    carried: Array  # (d,) inertia force at unit acceleration of the base
    jumps: Array  # (k,) s, at which the root's motion is not smooth
    drive: Law | None  # angle (rad) of a driven root over time, in the place of a spin-up
    shaking: Shaking | None  # of the base; None if it stands still
    forces: PlacedForces | None  # on the beam
    step: MeanStep  # of time-stepping with rigid obstacles


@jitable
def load_at(model: ExactModel, t: float, load: Array) -> None:
    """Put the forces from outside at an instant (s) into `load` (d,)."""
    acceleration = _base_acceleration(model.shaking, t)
    for j in range(load.shape[0]):
        load[j] = model.load[j] + acceleration * model.carried[j]


@jitable
def _base_acceleration(shaking: Shaking | None, t: float) -> float:
    """Acceleration (m/s^2) of the base; the compiler drops one of the two branches."""
    return 0.0 if shaking is None else base_acceleration(shaking, t)


@jitable
def hold_at(model: ExactModel, t: float, held: Array) -> None:
    """Put the values of the prescribed unknowns at an instant (s) into `held` (3,)."""
    numbers = model.numbers
    if numbers.driven:
        angle = _root_angle(model, t)
        held[0], held[1], held[2] = numbers.hub_radius * np.cos(angle), numbers.hub_radius * np.sin(angle), angle


@jitable
def take_root(model: ExactModel, t: float, length: float, root: Array) -> None:
    """Put the numbers of a root that yields, or turns on a radius, in a step (s) from t into `root` (5,)."""
    numbers = model.numbers
    root[ARM] = 0.0 if numbers.driven else numbers.hub_radius
    root[ROOT_STIFFNESS], root[ROOT_DAMPING] = numbers.root_stiffness, numbers.root_damping
    root[ANGLE_BEFORE], root[ANGLE_AFTER] = _root_angle(model, t), _root_angle(model, t + length)


@jitable
def _root_angle(model: ExactModel, t: float) -> float:
    """Prescribed angle (rad) of a driven root, that at which its spring leaves a hub alone."""
    numbers = model.numbers
    if not numbers.driven:
        return float(numbers.angle)
    return float(numbers.angle + drive_angle(model.drive, numbers.spin_rate, numbers.spin_up_time, t))


@jitable
def drive_forces(model: ExactModel, t: float, forces: Array) -> None:
    """Put the torque on a hub and the forces of the shaking at t (s) into `forces` (d,)."""
    acceleration = _base_acceleration(model.shaking, t)
    for j in range(forces.shape[0]):
        forces[j] = acceleration * model.carried[j]
    forces[2] += model.numbers.torque


@jitable
def _evaluate(model: ExactModel, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
    """Set what the protocol has at an instant to zero: steps have powers of their own."""
    w.vectors[SUPPLY, :] = 0.0
    return Evaluation(0.0, 0.0, 0.0)


@jitable
def _solve_mass(model: ExactModel, rank_one: float, w: Workspace, contacts: Contacts, closed: bool) -> bool:
    """Leave accelerations at zero: without rotary inertia the mass matrix is singular."""
    w.vectors[FREE_ACCELERATION, :] = 0.0
    return True


@inlined
def _take_state(model: ExactModel, t: float, q: Array, qd: Array, w: Workspace) -> None:
    """Do nothing: each place is evaluated from the coordinates."""


@jitable
def _touch(
    model: ExactModel, i: int, t: float, q: Array, qd: Array, w: Workspace, c: Candidate, rows: Array
) -> None:
    """Kinematics of one place."""
    place = place_of(model.beam, model.touchings[i], q, qd)
    c.gap, c.slip, c.gap_rate, c.slip_rate = place.gap, place.slip, place.gap_rate, place.slip_rate


@jitable
def _measure(model: ExactModel, t: float, q: Array, qd: Array, w: Workspace, contacts: Contacts) -> None:
    """Gap, slip and rates of all places."""
    for i in range(len(contacts.each)):
        c, place = contacts.each[i], place_of(model.beam, model.touchings[i], q, qd)
        c.gap, c.slip, c.gap_rate, c.slip_rate = place.gap, place.slip, place.gap_rate, place.slip_rate


class ExactModel(_ExactData):
    """The exact beam as a :class:`~oblique_impact.kernels.system.System`.

    A run asks it for the kinematics of contacts.  There are no accelerations at an instant: the scheme decides on
    stick by its steps.
    """

    __slots__ = ()
    described = "the exact beam"

    evaluate = _evaluate
    solve_mass = _solve_mass
    take_state = _take_state
    touch = _touch
    measure = _measure

    def new_workspace(self) -> Workspace:
        """Allocate vectors; steps have matrices of their own."""
        return Workspace(np.zeros((0, 0, 0)), np.zeros((VECTORS, NODE * self.beam.x.size)))

    def definiteness(self, rank_one: float, w: Workspace) -> float:
        """Return 1: the mass matrix is constant."""
        return 1.0


def beam_of(scenario: Scenario, sections: ElasticSections | None = None) -> ExactBeam:
    """Discretize the beam of a scenario: nodes as those of its finite elements; `sections` replace its own."""
    own = Sections.from_scenario(scenario)
    ends = mesh_of(scenario, own).p[0]
    elastic = sections or ElasticSections.of(scenario)
    return ExactBeam(ends, elastic, own.masses, own.hub_inertia, own.hub_radius)


def model_of(scenario: Scenario, beam: ExactBeam, motion: BaseMotion) -> ExactModel:
    """Return the model of a scenario with its beam and the motion of a driven root."""
    root, shaking, load, carried = (
        scenario.root,
        shaking_of(scenario),
        beam.weight(scenario.gravity),
        0.0 * beam.scale,
    )
    torque = root.torque if root.kind == "hub" else 0.0
    load[2] += torque
    if shaking is not None:
        carried = -(beam.M @ np.tile([shaking.cosine, shaking.sine, 0.0], beam.x.size))
    driven = root.kind == "driven"
    held = NODE if driven and root.stiffness == 0.0 else 0 if root.is_free else NODE - 1
    numbers = {
        "held": held,
        "driven": driven,
        "torque": torque,
        "kelvin_voigt": scenario.beam.kelvin_voigt,
        "hub_radius": beam.radius,
        "root_stiffness": root.stiffness,
        "root_damping": root.damping,
        "angle": scenario.initial.angle,
        # of the built-in motions
        "spin_rate": getattr(motion, "spin_rate", 0.0),
        "spin_up_time": getattr(motion, "spin_up_time", 0.0),
    }
    return ExactModel(
        record_of(EXACT_NUMBERS, numbers),
        beam.data,
        touchings_of(scenario, beam),
        load,
        np.asarray(carried),
        np.array(motion.breakpoints if driven else (), dtype=float),
        motion.drive_angle if driven else None,
        shaking,
        placed_forces(scenario, beam),
        MeanStep.new(len(beam.points), len(scenario.acting_forces)),
    )


def placed_forces(scenario: Scenario, beam: ExactBeam) -> PlacedForces | None:
    """Return the forces of a scenario with the nodes that carry them; None if there are none."""
    each = forces_of(scenario)
    if each is None:
        return None
    first, shapes = zip(*(beam.row_at(float(x)) for x in each.places), strict=True)
    return PlacedForces(each, np.array(first), np.array(shapes))


def touchings_of(scenario: Scenario, beam: ExactBeam) -> Any:
    """Return the records of the places of contact (n,)."""
    found, places = [], contact_places(scenario)
    for place in places:
        at = [float(x) for x in place.numbers]
        if place.on_side:
            node = int(np.argmin(np.abs(beam.x - at[0])))
            outer = int(np.cos(scenario.initial.angle - at[1]) > 0.0)
            found.append(node_on_side(node, at[1], at[2], at[3], at[4], outer))
        else:
            found.append(point_on_beam(at[0], at[1], place.radius, at[3], at[4]))
    # the tip on a side hands over to the side's outer corner, and back; the free end of a root to the inner one
    for i, side in enumerate(places):
        if side.on_side and side.extent and found[i].node in (0, beam.x.size - 1):
            corners = [j for j, at in enumerate(places) if not at.on_side and at.obstacle == side.obstacle]
            if corners:
                corner = corners[int(found[i].outer == (found[i].node > 0))]
                found[i].heir, found[corner].heir = corner, i
    return np.array(found, dtype=TOUCHING).view(np.recarray)


def hand_over_of(touchings: Any) -> dict[int, int]:
    """Contacts by those that they take over from at an end of a side."""
    return {i: int(place.heir) for i, place in enumerate(touchings) if place.heir >= 0}
