"""Particles and rods with one frictional contact, for closed-form checks of the contact states."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.state import DIRECTION, RESPONSE, Candidate
from oblique_impact.contact.transitions import EventKind
from oblique_impact.history.events import Event
from oblique_impact.history.history import History
from oblique_impact.kernels.contacts import ContactArrays
from oblique_impact.kernels.system import ContactRows, MechanicalSystem
from oblique_impact.kernels.workspace import EFFECTIVE, FORCES, FREE_ACCELERATION, INCREMENT, RESIDUAL, Workspace

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Particle(MechanicalSystem):
    """A point mass on or above a plane, q = [along, above]: incline, spring, moving belt, ball.

    `along` and `above` are the components of gravity (m/s^2); the spring acts along the plane; the plane
    itself moves with `belt_speed`.
    """

    above: float
    along: float = 0.0
    mass: float = 1.0
    stiffness: float = 0.0
    belt_speed: float = 0.0
    size = 2

    def mass_matrix(self, t: float, q: Array) -> Array:
        return self.mass * np.eye(2)

    def forces(self, t: float, q: Array, qd: Array) -> Array:
        return np.array([self.mass * self.along - self.stiffness * q[0], self.mass * self.above])

    def contact(self, t: float, q: Array, qd: Array) -> ContactRows:
        along, normal = np.array([1.0, 0.0]), np.array([0.0, 1.0])
        return ContactRows(q[1], q[0] - self.belt_speed * t, qd[1], qd[0] - self.belt_speed, normal, along)

    def energy(self, t: float, q: Array, qd: Array) -> tuple[float, float, float]:
        weight = -self.mass * (self.along * q[0] + self.above * q[1])
        return 0.5 * self.mass * float(qd @ qd), 0.5 * self.stiffness * q[0] ** 2, weight


@dataclass(frozen=True)
class FreeRod(MechanicalSystem):
    """A free uniform rod of half-length l above the ground, q = [x, y, angle] of its centre.

    Its end at (x - l cos, y - l sin) can touch the ground y = 0.
    """

    mass: float = 1.0
    half_length: float = 1.0
    gravity: float = 0.0
    size = 3

    @property
    def inertia(self) -> float:
        return self.mass * self.half_length**2 / 3.0

    def at(self, angle: float, height: float = 0.0) -> Array:
        """Coordinates with the end at `height` above the ground."""
        return np.array([0.0, height + self.half_length * np.sin(angle), angle])

    def moving(self, angle: float, end_velocity: tuple[float, float], spin: float = 0.0) -> Array:
        """Velocities that give the end these components along and off the ground."""
        arm_x, arm_y = -self.half_length * np.cos(angle), -self.half_length * np.sin(angle)
        return np.array([end_velocity[0] + spin * arm_y, end_velocity[1] - spin * arm_x, spin])

    def mass_matrix(self, t: float, q: Array) -> Array:
        return np.diag([self.mass, self.mass, self.inertia])

    def forces(self, t: float, q: Array, qd: Array) -> Array:
        return np.array([0.0, -self.mass * self.gravity, 0.0])

    def contact(self, t: float, q: Array, qd: Array) -> ContactRows:
        arm_x, arm_y = -self.half_length * np.cos(q[2]), -self.half_length * np.sin(q[2])
        normal, tangential = np.array([0.0, 1.0, arm_x]), np.array([1.0, 0.0, -arm_y])
        centripetal = -(qd[2] ** 2) * np.array([arm_x, arm_y])
        return ContactRows(
            gap=q[1] + arm_y,
            slip=q[0] + arm_x,
            gap_rate=float(normal @ qd),
            slip_rate=float(tangential @ qd),
            normal=normal,
            tangential=tangential,
            gap_bias=centripetal[1],
            slip_bias=centripetal[0],
        )

    def energy(self, t: float, q: Array, qd: Array) -> tuple[float, float, float]:
        kinetic = 0.5 * float(qd @ self.mass_matrix(t, q) @ qd)
        return kinetic, 0.0, self.mass * self.gravity * q[1]

    def instant(self, q: Array, qd: Array) -> Candidate:
        """Return the contact problem at (q, q'), written out by hand."""
        rows, inverse = self.contact(0.0, q, qd), np.linalg.inv(self.mass_matrix(0.0, q))
        free = inverse @ self.forces(0.0, q, qd)
        return Candidate(
            gap=rows.gap,
            slip=rows.slip,
            gap_rate=rows.gap_rate,
            slip_rate=rows.slip_rate,
            a_nn=float(rows.normal @ inverse @ rows.normal),
            a_nt=float(rows.normal @ inverse @ rows.tangential),
            a_tt=float(rows.tangential @ inverse @ rows.tangential),
            gap_acceleration=float(rows.normal @ free + rows.gap_bias),
            slip_acceleration=float(rows.tangential @ free + rows.slip_bias),
        )


@dataclass(frozen=True)
class PinnedBar(MechanicalSystem):
    """A rigid uniform bar, q = [angle], pinned at the origin, above a slope through (`offset`, 0)."""

    mass: float
    length: float
    gravity: float
    slope: float
    offset: float
    size = 1

    @property
    def inertia(self) -> float:
        return self.mass * self.length**2 / 3.0

    def mass_matrix(self, t: float, q: Array) -> Array:
        return np.array([[self.inertia]])

    def forces(self, t: float, q: Array, qd: Array) -> Array:
        return np.array([-0.5 * self.mass * self.gravity * self.length * np.cos(q[0])])

    def contact(self, t: float, q: Array, qd: Array) -> ContactRows:
        sine, cosine = self.length * np.sin(q[0] - self.slope), self.length * np.cos(q[0] - self.slope)
        gap = sine + self.offset * np.sin(self.slope)
        slip = cosine - self.offset * np.cos(self.slope)
        normal, tangential = np.array([cosine]), np.array([-sine])
        square = qd[0] ** 2
        return ContactRows(
            gap, slip, cosine * qd[0], -sine * qd[0], normal, tangential, -sine * square, -cosine * square
        )

    def energy(self, t: float, q: Array, qd: Array) -> tuple[float, float, float]:
        height = 0.5 * self.length * np.sin(q[0])
        return 0.5 * self.inertia * qd[0] ** 2, 0.0, self.mass * self.gravity * height


class ElasticRod(MechanicalSystem):
    """A straight elastic rod that moves along its axis onto a rigid wall at x = 0, in `elements` linear elements.

    q holds the positions (m) of its nodes from the second on.  The first, which meets the wall, has no inertia:
    its share of the mass is the second's, and the element behind it is the spring `end_stiffness` (N/m) of an
    :class:`~oblique_impact.contact.stops.ElasticStop` between the two.  A wave runs through the rod at
    `wave_speed` (m/s); while the end is held at the speed v, the wall pushes with `impedance` v (N).
    """

    def __init__(self, elements: int, length: float, axial_stiffness: float, mass_per_length: float) -> None:
        self.size, self.length = elements, length
        self.wave_speed = float(np.sqrt(axial_stiffness / mass_per_length))
        self.impedance = axial_stiffness / self.wave_speed
        self.mass = mass_per_length * length
        element = length / elements
        self.end_stiffness = axial_stiffness / element
        self.gravity = 0.0
        self._rest = element * np.arange(1, elements + 1)  # of the nodes, with the end at the wall
        self._masses = np.full(elements, mass_per_length * element)
        self._masses[0] += 0.5 * mass_per_length * element
        self._masses[-1] *= 0.5
        inside = 2.0 * np.eye(elements) - np.eye(elements, k=1) - np.eye(elements, k=-1)
        inside[0, 0] = inside[-1, -1] = 1.0
        self._stiffness = self.end_stiffness * inside

    def at(self, height: float) -> Array:
        """Coordinates of the undeformed rod with its end at a height (m) above the wall."""
        return np.asarray(self._rest + height)

    def mass_matrix(self, t: float, q: Array) -> Array:
        return np.diag(self._masses)

    def forces(self, t: float, q: Array, qd: Array) -> Array:
        return np.asarray(-self._stiffness @ (q - self._rest) - self.gravity * self._masses)

    def stiffness_matrix(self, t: float, q: Array) -> Array:
        return self._stiffness

    def contact(self, t: float, q: Array, qd: Array) -> ContactRows:
        normal = np.eye(1, self.size)[0]
        return ContactRows(q[0] - self._rest[0], 0.0, qd[0], 0.0, normal, np.zeros(self.size))

    def energy(self, t: float, q: Array, qd: Array) -> tuple[float, float, float]:
        u, weight = q - self._rest, self.gravity * float(self._masses @ q)
        return 0.5 * float(self._masses @ qd**2), 0.5 * float(u @ self._stiffness @ u), weight

    # the mass matrix is diagonal; what follows in place of the interpreted loops of a dense one

    def solve_mass(self, rank_one: float, w: Workspace, contacts: ContactArrays, closed: bool) -> bool:
        w.vectors[FREE_ACCELERATION] = w.vectors[FORCES] / self._masses
        contacts.rows[RESPONSE] = contacts.rows[DIRECTION] / self._masses
        return True

    def factor_effective(
        self, t: float, q: Array, velocity: float, position: float, w: Workspace, slot: int, stale: bool
    ) -> bool:
        if stale:
            w.matrices[EFFECTIVE + slot] = np.linalg.inv(np.diag(self._masses) + position * self._stiffness)
        return True

    def solve_effective(
        self, rank_one: float, w: Workspace, slot: int, contacts: ContactArrays, closed: bool
    ) -> None:
        inverse = w.matrices[EFFECTIVE + slot]
        w.vectors[INCREMENT] = inverse @ w.vectors[RESIDUAL]
        contacts.rows[RESPONSE] = contacts.rows[DIRECTION] @ inverse


def events_of(history: History, kind: EventKind) -> list[Event]:
    """Return the events of one kind, in order of time."""
    return [event for event in history.events if event.kind is kind]


def samples_at(history: History, time: float) -> tuple[Array, Array]:
    """(q, q') of the last sample at `time`: the right-hand values of a jump."""
    now = history.at(time)
    return now["q"].values, now["qd"].values
