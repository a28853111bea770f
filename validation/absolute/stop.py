"""The elastic stop: a straight, inclined slope that pushes one node, with Coulomb's friction.

In absolute coordinates gap and slip are the components of the node's place: nothing of the beam's shape enters.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from oblique_impact.scenario.scenario import Scenario
from validation.absolute.beam import NODE
from validation.absolute.sections import Array
from validation.absolute.step import PointForces, Stage


class Place(NamedTuple):
    """Where the contact point is: gap and slip (m), and their rates (m/s)."""

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
    stiffness: float  # N/m
    damping: float  # s/m

    @classmethod
    def of(cls, scenario: Scenario, node: int) -> Slope:
        """Read slope and spring of a scenario."""
        s = scenario
        return cls(node, s.slope.angle, s.slope.offsets, s.contact.stiffness, s.contact.damping)

    @cached_property
    def normal(self) -> Array:
        """Unit vector (2,) away from the slope."""
        return np.array([-np.sin(self.angle), np.cos(self.angle)])

    @cached_property
    def tangent(self) -> Array:
        """Unit vector (2,) up the slope."""
        return np.array([np.cos(self.angle), np.sin(self.angle)])

    def place(self, stage: Stage) -> Place:
        """Return where the contact point is, and how it moves."""
        at = slice(NODE * self.node, NODE * self.node + 2)
        r, v, (height, along) = stage.q[at], stage.v[at], self.offsets
        n, t = self.normal, self.tangent
        return Place(float(n @ r) - height, float(t @ r) - along, float(n @ v), float(t @ v))

    def force(self, place: Place) -> float:
        """Return the normal force (N) at an instant: k d (1 + damping d') at the depth d, never pulling."""
        # at a release, the gap is zero but for rounding
        return self.stiffness * max(0.0, -place.gap) * max(0.0, 1.0 - self.damping * place.gap_rate)

    def energy(self, place: Place) -> float:
        """Energy (J) in the spring at an instant of contact."""
        return 0.5 * self.stiffness * place.gap**2


@dataclass(frozen=True)
class Contact:
    """The closed contact within a step: spring, and friction against the slip, or none because the point sticks.

    The mean force of the spring over a step is that at its mean depth: its work is the change of its energy.
    """

    slope: Slope
    friction: float = 0.0  # lambda_tau/lambda_n, against the slip
    sticks: bool = False

    @property
    def node(self) -> int:
        """The node that is in contact."""
        return self.slope.node

    @property
    def fixed(self) -> Array | None:
        """Direction in which a sticking point does not move."""
        return self.slope.tangent if self.sticks else None

    def normal_force(self, gap0: float, gap1: float, length: float) -> tuple[float, float]:
        """Mean normal force (N) of a step, and its derivative by the gap at its end (N/m)."""
        k, c = self.slope.stiffness, self.slope.damping
        depth, factor = -0.5 * (gap0 + gap1), 1.0 - c * (gap1 - gap0) / length
        if factor <= 0.0:
            return 0.0, 0.0
        return k * depth * factor, -0.5 * k * factor - k * depth * c / length

    def forces(self, r0: Array, r1: Array, length: float) -> PointForces:
        """Return the mean forces on the node within a step."""
        n, height = self.slope.normal, self.slope.offsets[0]
        force, rate = self.normal_force(float(n @ r0) - height, float(n @ r1) - height, length)
        direction = n + self.friction * self.slope.tangent
        return PointForces(force * direction, rate * np.outer(direction, n))
