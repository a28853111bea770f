"""The elastic stop: a straight, inclined slope that pushes one node, with Coulomb's friction.

In absolute coordinates gap and slip are the components of the node's place, or of a place in its section,
r + i e exp(i phi): nothing of the beam's shape enters.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from oblique_impact.contact.stops import ElasticStop
from oblique_impact.fem_beam.exact.beam import NODE, Stage, divided_difference
from oblique_impact.fem_beam.exact.sections import Array
from oblique_impact.scenario.scenario import Scenario


class Place(NamedTuple):
    """Kinematics of the contact point: gap and slip (m), and their rates (m/s)."""

    gap: float
    slip: float
    gap_rate: float
    slip_rate: float


@dataclass(frozen=True)
class Slope:
    """Line and spring of the stop, and the node that meets it.

    The unit vectors are those of the scenario's definition: the free side of the slope is on its left.
    """

    node: int
    angle: float  # rad
    offsets: tuple[float, float]  # m, see `SlopeSection.offsets`
    law: ElasticStop
    fibre: float = 0.0  # e (m), place of the contact point in the section, across the beam
    extent: tuple[float, ...] = ()  # m along the slope: its ends

    @classmethod
    def of(cls, scenario: Scenario, node: int) -> Slope:
        """Read slope and spring of a scenario."""
        s, law = scenario, ElasticStop(scenario.contact.stiffness, scenario.contact.damping)
        return cls(node, s.slope.angle, s.slope.offsets, law, s.contact_fibre, s.slope.extent)

    @cached_property
    def normal(self) -> Array:
        """Unit vector (2,) away from the slope."""
        return np.array([-np.sin(self.angle), np.cos(self.angle)])

    @cached_property
    def tangent(self) -> Array:
        """Unit vector (2,) up the slope."""
        return np.array([np.cos(self.angle), np.sin(self.angle)])

    def place(self, stage: Stage) -> Place:
        """Return gap, slip and their rates at a state."""
        at, (height, along) = slice(NODE * self.node, NODE * (self.node + 1)), self.offsets
        q, v = stage.q[at], stage.v[at]
        r, (n, t) = self.point(q), (self.rows(u, q) for u in (self.normal, self.tangent))
        return Place(float(self.normal @ r) - height, float(self.tangent @ r) - along, float(n @ v), float(t @ v))

    def point(self, q: Array) -> Array:
        """Place (2,) of the contact point, of the node's unknowns (3,)."""
        return np.asarray(q[:2] + self.fibre * np.array([-np.sin(q[2]), np.cos(q[2])]))

    def rows(self, u: Array, q: Array) -> Array:
        """Return the derivatives (3,) of the contact point's component along a vector u (2,)."""
        return np.append(u, -self.fibre * float(u @ [np.cos(q[2]), np.sin(q[2])]))

    def mean_rows(self, u: Array, q0: Array, q1: Array) -> tuple[Array, float]:
        """Return the mean rows over a step and the rate of the last; times q1 - q0 they give the displacement."""
        quotient, rate = divided_difference(q0[2], q1[2])
        along = self.fibre * (u[0] - 1j * u[1]) * 1j
        return np.append(u, float(np.real(along * quotient))), float(np.real(along * rate))

    def is_beyond(self, place: Place) -> bool:
        """Whether a place is beyond the ends of the slope."""
        return bool(self.extent) and not self.extent[0] <= place.slip <= self.extent[1]

    def inside(self, place: Place) -> float:
        """Return a length (m) that is positive between the ends of the slope, and falls through zero at each."""
        first, last = self.extent
        return (place.slip - first) * (last - place.slip) / (last - first)

    def force(self, place: Place) -> float:
        """Return the normal force (N) at an instant: k d (1 + damping d') at the depth d, never pulling."""
        # at a release, the gap is zero but for rounding
        return self.law.stiffness * max(0.0, -place.gap) * max(0.0, 1.0 - self.law.damping * place.gap_rate)


@dataclass(frozen=True)
class Contact:
    """The closed contact within a step: spring, and friction against the slip, or none because the point sticks.

    The mean force of the spring over a step is that at its mean depth: its work is the change of its energy.
    """

    slope: Slope
    friction: float = 0.0  # lambda_tau/lambda_n, against the slip
    sticks: bool = False

    def normal_force(self, gap0: float, gap1: float, length: float) -> tuple[float, float]:
        """Mean normal force (N) of a step, and its derivative by the gap at its end (N/m)."""
        k, c = self.slope.law.stiffness, self.slope.law.damping
        depth, factor = -0.5 * (gap0 + gap1), 1.0 - c * (gap1 - gap0) / length
        if factor <= 0.0:
            return 0.0, 0.0
        return k * depth * factor, -0.5 * k * factor - k * depth * c / length

    def forces(self, q0: Array, q1: Array, length: float) -> tuple[Array, Array]:
        """Return the mean forces (3,) on the node within a step (N, N, N m), and their derivatives by q1."""
        slope, n = self.slope, self.slope.normal
        gap0, gap1 = (float(n @ slope.point(q)) - slope.offsets[0] for q in (q0, q1))
        force, rate = self.normal_force(gap0, gap1, length)
        direction, turning = slope.mean_rows(n + self.friction * slope.tangent, q0, q1)
        tangent = rate * np.outer(direction, slope.rows(n, q1))
        tangent[2, 2] += force * turning
        return force * direction, tangent
