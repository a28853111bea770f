"""The beam of a scenario as a mechanical system: its load, its root, and the places where it touches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from oblique_impact.beam.base_motion import BaseMotion
from oblique_impact.beam.beam import contact_places
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.shaking import Shaking, base_acceleration, shaking_of
from oblique_impact.contact.state import Candidate, Contacts
from oblique_impact.contact.stops import elastic_stop
from oblique_impact.fem_beam.exact.elastic_sections import Array, ElasticSections
from oblique_impact.fem_beam.exact.exact_beam import ExactBeam, Stage
from oblique_impact.fem_beam.exact.stop import NodeOnSide, PointOnBeam, Touching
from oblique_impact.fem_beam.mesh import mesh_of
from oblique_impact.kernels.workspace import VECTORS, Evaluation, Workspace
from oblique_impact.scenario.scenario import Scenario


def beam_of(scenario: Scenario, sections: ElasticSections | None = None) -> ExactBeam:
    """Discretize the beam of a scenario: nodes as those of its finite elements; `sections` replace its own."""
    own = Sections.from_scenario(scenario)
    ends = mesh_of(scenario, own).p[0]
    elastic = sections or ElasticSections.of(scenario)
    return ExactBeam(ends, elastic, float(own.outer_mass(own.length)), own.hub_inertia, own.hub_radius)


def touchings_of(scenario: Scenario, beam: ExactBeam) -> list[Touching]:
    """Return the contacts of these places."""
    found, c = list[Touching](), scenario.contact
    for place in contact_places(scenario):
        law = elastic_stop(place.stiffness, c.damping, place.extent, place.cell, c.linear_damping)
        common, at = (beam, place.obstacle, law, place.extent), [float(x) for x in place.numbers]
        if place.on_side:
            node = int(np.argmin(np.abs(beam.x - at[0])))
            outer = int(np.cos(scenario.initial.angle - at[1]) > 0.0)
            found.append(NodeOnSide(*common, node, at[1], (at[2], at[3]), at[4], outer))
        else:
            found.append(PointOnBeam(*common, complex(at[0], at[1]), place.radius, at[3], at[4]))
    return found


@dataclass(frozen=True)
class ExactSystem:
    """The beam with its places of contact, a :class:`~oblique_impact.kernels.system.System` in plain Python.

    A run asks it for the kinematics of contacts.  There are no accelerations at an instant: without rotary inertia
    the mass matrix is singular, and the scheme decides on stick by its steps.
    """

    scenario: Scenario
    beam: ExactBeam
    motion: BaseMotion  # of a driven root
    touchings: Sequence[Touching]

    @property
    def is_hub(self) -> bool:
        """Whether the root turns with a hub."""
        return self.scenario.root.kind == "hub"

    @cached_property
    def load(self) -> Array:
        """Forces (3 n,) from outside: the weight, and the torque on a hub."""
        load = self.beam.weight(self.scenario.gravity)
        if self.is_hub:
            load[2] += self.scenario.root.torque
        return load

    @cached_property
    def shaking(self) -> Shaking | None:
        """How the base is shaken; None if it stands still."""
        return shaking_of(self.scenario)

    def load_at(self, t: float) -> Array:
        """Return the forces (3 n,) from outside at an instant (s), with the inertia force on a shaken base."""
        return self.load if self.shaking is None else self.load + self.inertia_force(self.shaking, t)

    def inertia_force(self, shaking: Shaking, t: float) -> Array:
        """Return the inertia force (3 n,) at an instant (s) on a shaken base."""
        direction = np.tile([shaking.cosine, shaking.sine, 0.0], self.beam.x.size)
        return np.asarray(-base_acceleration(shaking, t) * (self.beam.M @ direction))

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times (s) at which the root's motion is not smooth."""
        return self.motion.breakpoints if self.scenario.root.kind == "driven" else ()

    def held(self, t: float) -> Array:
        """Values of the prescribed unknowns at an instant (s), (2,) or (3,)."""
        if self.scenario.root.kind != "driven":
            return np.zeros(2)
        angle = self.scenario.initial.angle + self.motion.at(t).angle
        return np.array([self.beam.radius * np.cos(angle), self.beam.radius * np.sin(angle), angle])

    @cached_property
    def hand_over(self) -> dict[int, int]:
        """Contacts by those that they take over from at an end of a side: the tip on it, its outer corner."""
        found: dict[int, int] = {}
        for i, side in enumerate(self.touchings):
            if isinstance(side, NodeOnSide) and side.extent and side.node == self.beam.x.size - 1:
                points = ((j, at) for j, at in enumerate(self.touchings) if isinstance(at, PointOnBeam))
                corners = [j for j, at in points if at.obstacle == side.obstacle]
                found |= {i: corners[side.outer], corners[side.outer]: i} if corners else {}
        return found

    def new_workspace(self) -> Workspace:
        """Allocate vectors; steps have matrices of their own."""
        return Workspace(np.zeros((0, 0, 0)), np.zeros((VECTORS, self.beam.size)))

    def evaluate(self, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
        """Return zeros: steps have powers of their own."""
        return Evaluation(0.0, 0.0, 0.0)

    def solve_mass(self, rank_one: float, w: Workspace, contacts: Contacts, closed: bool) -> bool:
        """Leave accelerations at zero."""
        return True

    def take_state(self, t: float, q: Array, qd: Array, w: Workspace) -> None:
        """Do nothing: each place is evaluated from the coordinates."""

    def touch(self, i: int, t: float, q: Array, qd: Array, w: Workspace, c: Candidate, rows: Array) -> None:
        """Kinematics of one place; 0 of a beam without places."""
        if self.touchings:
            c.gap, c.slip, c.gap_rate, c.slip_rate = map(float, self.touchings[i].place(Stage(q, qd))[:4])

    def definiteness(self, rank_one: float, w: Workspace) -> float:
        """Return 1: the mass matrix is constant."""
        return 1.0
