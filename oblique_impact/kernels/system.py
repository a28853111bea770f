"""The protocol of mechanical systems that contact states and schemes rest on.

    M(t, q) q'' = Q(t, q, q') + D_n^T lambda_n + D_tau^T lambda_tau,
    Z_n'' = D_n q'' + z_n,   Z_tau'' = D_tau q'' + z_tau

`System`            the methods that kernels call; packed systems (named tuples) bring compiled ones
`MechanicalSystem`  the contract for a small user-defined system, which runs interpreted through the same source
`Workspace`         the arrays that these methods fill
`Evaluation`        the numbers that come back
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from oblique_impact.kernels.contacts import CandidateFields as Candidate
from oblique_impact.kernels.contacts import ContactArrays as Contacts
from oblique_impact.kernels.dense import DenseAlgebra
from oblique_impact.kernels.jit import compiled_protocol
from oblique_impact.kernels.workspace import FORCES, MASS, SUPPLY, Array, Evaluation, Workspace, new_workspace

__all__ = ["ContactRows", "MechanicalSystem", "System"]


@compiled_protocol
class System(Protocol):
    """Methods that kernels call.

    Dense systems take all but `evaluate` from :class:`~oblique_impact.kernels.dense.DenseAlgebra`.
    """

    def evaluate(self, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
        """Fill mass matrix and forces at (t, q, q')."""

    def solve_mass(self, rank_one: float, w: Workspace, contacts: Contacts, closed: bool) -> bool:
        """Acceleration without contact force and, with `closed`, M^-1 D^T of the closed contacts.

        False if the mass matrix is not positive definite.
        """

    def begin_step(self, t: float, h: float, q: Array, w: Workspace) -> None:
        """Begin an implicit step of the length h (s) from t and q, of which residuals may hold means."""

    def end_step(self, h: float, q: Array, qd: Array, end: Array) -> None:
        """Correct the coordinates at the end of such a step from q, that mean velocities q' lead to in it."""

    def take_residual(self, t: float, q: Array, qd: Array, qdd: Array, w: Workspace) -> Evaluation:
        """Evaluate and fill the residual Q - M q''."""

    def approach(self, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
        """Supplied power alone."""

    def mass_product(self, rank_one: float, w: Workspace, x: Array, product: Array) -> None:
        """M x of the evaluated system into `product`."""

    def factor_effective(
        self, t: float, q: Array, velocity: float, position: float, w: Workspace, slot: int, stale: bool
    ) -> bool:
        """Factor S = M + velocity C + position K, the constant part of a linearized implicit step, in a slot.

        With `stale` False nothing but the state has changed since.  C and K need not be exact derivatives.
        False if S is not positive definite.
        """

    def solve_effective(self, rank_one: float, w: Workspace, slot: int, contacts: Contacts, closed: bool) -> None:
        """S^-1 of the residual into the increment and, with `closed`, of the rows of the closed contacts."""

    def damping_at(self, t: float, q: Array, qd: Array, w: Workspace) -> float:
        """Power (W) that damping forces take out at the velocities q'."""

    def add_tangent(self, t: float, q: Array, velocity: float, position: float, target: Array) -> None:
        """Add velocity * damping matrix + position * stiffness matrix to `target` (d, d); dense systems."""

    def take_state(self, t: float, q: Array, qd: Array, w: Workspace) -> None:
        """Take what `touch` has in common at all places in a state."""

    def touch(self, i: int, t: float, q: Array, qd: Array, w: Workspace, c: Candidate, rows: Array) -> None:
        """Gap, slip, their rates and biases of candidate i in the state that was taken, and its rows (2, d).

        A body that yields without mass is asked for a third one, that of the shift of the candidate.
        """

    def measure(self, t: float, q: Array, qd: Array, w: Workspace, contacts: Contacts) -> None:
        """Take the state; gap, slip and gap rate of every candidate."""

    def solve_rows(
        self, rank_one: float, w: Workspace, slot: int, sides: int, rows: Array, responses: Array
    ) -> None:
        """S^-1 of the first `sides` of the rows (places, 2 or 3, d), normals first, into `responses`."""

    def set_massless(self, mean: Array, v: Array) -> None:
        """Set the part of the velocities v (d,) that has no inertia to that of `mean` (d,), which may change."""


class NormalModes(NamedTuple):
    """Modes of the linear part of a system with d degrees of freedom, z'' + damping z' + stiffness z = f."""

    shapes: Array  # (d, d) q = shapes z
    projection: Array  # (d, d) z = projection q
    stiffness: Array  # (d,) squares of circular frequencies (1/s^2)
    damping: Array  # (d,) 1/s

    @property
    def eigenvalues(self) -> NDArray[np.complex128]:
        """Eigenvalue of each mode (1/s): of its pair the one with the larger absolute value."""
        root = np.sqrt((0.25 * self.damping * self.damping - self.stiffness).astype(complex))
        return np.asarray(-0.5 * self.damping - root)


class ContactRows(NamedTuple):
    """Kinematics of one contact at an instant (SI units)."""

    gap: float
    slip: float
    gap_rate: float
    slip_rate: float
    normal: Array  # (d,) D_n
    tangential: Array  # (d,) D_tau
    gap_bias: float = 0.0  # z_n
    slip_bias: float = 0.0  # z_tau


class MechanicalSystem(DenseAlgebra, System, ABC):
    """A system with `size` degrees of freedom and one unilateral contact with friction."""

    size: int

    @abstractmethod
    def mass_matrix(self, t: float, q: Array) -> Array:
        """Return M(t, q), shape (d, d), symmetric positive definite."""

    @abstractmethod
    def forces(self, t: float, q: Array, qd: Array) -> Array:
        """Return the generalized forces Q without contact, shape (d,)."""

    @abstractmethod
    def contact(self, t: float, q: Array, qd: Array) -> ContactRows:
        """Return gap, slip, their rates and the contact rows."""

    @abstractmethod
    def energy(self, t: float, q: Array, qd: Array) -> tuple[float, float, float]:
        """Return kinetic, elastic and gravity energy (J)."""

    def damping_power(self, t: float, q: Array, qd: Array) -> float:
        """Power (W) that damping forces inside Q take out of the system."""
        return 0.0

    def supplied_power(self, t: float, q: Array, qd: Array, qdd: Array) -> float:
        """Power (W) that actuators inside Q put into the system; an affine function of q''."""
        return 0.0

    def stiffness_matrix(self, t: float, q: Array) -> Array:
        """Return -dQ/dq (d, d), or the part of it that an implicit scheme should know; zero if not given."""
        return np.zeros((self.size, self.size))

    def damping_matrix(self, t: float, q: Array) -> Array:
        """Return -dQ/dq' (d, d), or the part of it that an implicit scheme should know; zero if not given."""
        return np.zeros((self.size, self.size))

    def new_workspace(self) -> Workspace:
        """Allocate the arrays of a run."""
        return new_workspace(self.size)

    def evaluate(self, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
        """Put what the methods above return into the arrays and the numbers of the protocol."""
        v = w.vectors
        w.matrices[MASS, :, :] = self.mass_matrix(t, q)
        v[FORCES] = self.forces(t, q, qd)
        supplied = float(self.supplied_power(t, q, qd, np.zeros(self.size)))
        for i, unit in enumerate(np.eye(self.size)):
            v[SUPPLY, i] = self.supplied_power(t, q, qd, unit) - supplied
        return Evaluation(float(self.damping_power(t, q, qd)), supplied, 0.0)

    def take_state(self, t: float, q: Array, qd: Array, w: Workspace) -> None:
        """Do nothing: the contact is evaluated from the coordinates."""

    def touch(self, i: int, t: float, q: Array, qd: Array, w: Workspace, c: Candidate, rows: Array) -> None:  # noqa: D102
        found = self.contact(t, q, qd)
        c.gap, c.slip, c.gap_rate, c.slip_rate = map(float, found[:4])
        rows[0], rows[1] = found.normal, found.tangential
        c.gap_bias, c.slip_bias = float(found.gap_bias), float(found.slip_bias)

    def set_massless(self, mean: Array, v: Array) -> None:
        """Do nothing: all coordinates have inertia."""

    def measure(self, t: float, q: Array, qd: Array, w: Workspace, contacts: Contacts) -> None:  # noqa: D102
        self.touch(0, t, q, qd, w, contacts.each[0], contacts.rows[0, 0])

    def damping_at(self, t: float, q: Array, qd: Array, w: Workspace) -> float:  # noqa: D102
        return float(self.damping_power(t, q, qd))

    def add_tangent(  # noqa: D102
        self, t: float, q: Array, velocity: float, position: float, target: Array
    ) -> None:
        target += velocity * self.damping_matrix(t, q) + position * self.stiffness_matrix(t, q)
