"""The small protocol behind the hybrid algorithm: mass matrix, forces, contact rows.

Everything the contact states and the marching schemes know about a mechanical system passes through
:func:`evaluate`, which fills a :class:`Work` with

    M(t, q) q'' = Q(t, q, q') + D_n^T lambda_n + D_tau^T lambda_tau,
    Z_n'' = D_n q'' + z_n,   Z_tau'' = D_tau q'' + z_tau

A system of a user's own subclasses :class:`MechanicalSystem` and is marched in plain Python; the beam
(:mod:`oblique_impact.beam.floating_frame`) brings a compiled overload of the same function.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Work.matrices: mass matrix, its factor, the factors of an implicit scheme's effective matrices for its two
# regular steps and for an odd one
MASS, CHOLESKY, EFFECTIVE = range(3)
EFFECTIVE_SLOTS = 3
MATRICES = EFFECTIVE + EFFECTIVE_SLOTS
# Work.vectors: forces Q, contact rows D_n and D_tau, acceleration without contact force, M^-1 D_n^T and
# M^-1 D_tau^T, acceleration, the mass row of a prescribed coordinate, those of the system's own
FORCES, NORMAL_ROW, TANGENT_ROW, FREE_ACCELERATION, NORMAL_RESPONSE, TANGENT_RESPONSE = range(6)
ACCELERATION, DRIVEN_ROW, OWN_A, OWN_B, OWN_C = range(6, 11)
# ... of an implicit scheme: residual Q + D^T lambda - M q'', its response, two products with the mass matrix
RESIDUAL, INCREMENT, PRODUCT_A, PRODUCT_B = range(11, 15)
VECTORS = 15
# Work.scalars: kinematics of the contact, powers
GAP, SLIP, GAP_RATE, SLIP_RATE, GAP_BIAS, SLIP_BIAS, DAMPING_POWER, DRIVEN_FORCE = range(8)
# ... Delassus entries D_n M^-1 D_n^T, D_n M^-1 D_tau^T, D_tau M^-1 D_tau^T and the accelerations of gap and
# slip without contact force
A_NN, A_NT, A_TT, GAP_ACCELERATION, SLIP_ACCELERATION = range(8, 13)
# ... contact forces lambda_n and lambda_tau
LAMBDA_N, LAMBDA_T = range(13, 15)
# ... guards of the contact state, each positive while it persists
FIRST_GUARD, GUARDS = 15, 4
SCALARS = FIRST_GUARD + GUARDS


class Work(NamedTuple):
    """Scratch of one system with d degrees of freedom, filled by `evaluate` and the contact solver.

    Three arrays, with the names above for their entries: compiled code hands them on cheaply.
    """

    matrices: Array  # (5, d, d); banded systems store (slots, d, 4)
    vectors: Array  # (15, d)
    scalars: Array  # (19,)


def new_work(size: int) -> Work:
    """Allocate the scratch arrays for `size` degrees of freedom."""
    return Work(np.zeros((MATRICES, size, size)), np.zeros((VECTORS, size)), np.zeros(SCALARS))


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


class MechanicalSystem(ABC):
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

    def supplied_power(self, t: float, q: Array, qd: Array, work: Work) -> float:
        """Power (W) that actuators inside Q put into the system; `work.vectors[ACCELERATION]` is set."""
        return 0.0

    def stiffness_matrix(self, t: float, q: Array) -> Array:
        """Return -dQ/dq (d, d), or the part of it that an implicit scheme should know; zero if not given."""
        return np.zeros((self.size, self.size))

    def damping_matrix(self, t: float, q: Array) -> Array:
        """Return -dQ/dq' (d, d), or the part of it that an implicit scheme should know; zero if not given."""
        return np.zeros((self.size, self.size))

    def evaluate(self, t: float, q: Array, qd: Array, work: Work) -> None:
        """Fill `work`; what the marching source calls."""
        rows = self.contact(t, q, qd)
        work.matrices[MASS] = self.mass_matrix(t, q)
        work.vectors[FORCES] = self.forces(t, q, qd)
        work.vectors[NORMAL_ROW] = rows.normal
        work.vectors[TANGENT_ROW] = rows.tangential
        work.scalars[GAP : SLIP_RATE + 1] = rows.gap, rows.slip, rows.gap_rate, rows.slip_rate
        work.scalars[GAP_BIAS], work.scalars[SLIP_BIAS] = rows.gap_bias, rows.slip_bias
        work.scalars[DAMPING_POWER] = self.damping_power(t, q, qd)


def evaluate(system: Any, t: float, q: Array, qd: Array, work: Work) -> None:
    """Fill `work` for `system` at (t, q, q'); compiled systems overload this function."""
    system.evaluate(t, q, qd, work)


def supplied_power(system: Any, t: float, q: Array, qd: Array, work: Work) -> float:
    """Power (W) of drives and hub torques at an instant whose acceleration is in `work`."""
    return float(system.supplied_power(t, q, qd, work))


def add_tangent(system: Any, t: float, q: Array, velocity: float, position: float, work: Work, slot: int) -> None:
    """Add velocity * damping matrix + position * stiffness matrix to a slot of the matrices."""
    work.matrices[slot] += velocity * system.damping_matrix(t, q) + position * system.stiffness_matrix(t, q)


def damping_power(system: Any, t: float, q: Array, qd: Array, work: Work) -> float:
    """Power (W) that damping forces take out at velocities other than the evaluated ones."""
    return float(system.damping_power(t, q, qd))
