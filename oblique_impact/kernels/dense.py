"""Dense linear algebra of small systems, and the part of the protocol that follows from it."""

from __future__ import annotations

from typing import Any

import numpy as np

from oblique_impact.kernels.contacts import ContactArrays
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import (
    EFFECTIVE,
    FACTOR,
    FORCES,
    FREE_ACCELERATION,
    INCREMENT,
    MASS,
    RESIDUAL,
    Array,
    Evaluation,
    Workspace,
)


@jitable
def factor(matrix: Array, lower: Array) -> bool:
    """Cholesky factor of a matrix (d, d), which may be `lower` itself; False if it is not positive definite."""
    n = matrix.shape[0]
    for j in range(n):
        pivot = matrix[j, j]
        for k in range(j):
            pivot -= lower[j, k] * lower[j, k]
        if not pivot > 0.0:
            return False
        root = np.sqrt(pivot)
        lower[j, j] = root
        for i in range(j + 1, n):
            entry = matrix[i, j]
            for k in range(j):
                entry -= lower[i, k] * lower[j, k]
            lower[i, j] = entry / root
    return True


@jitable
def solve(lower: Array, right: Array, x: Array) -> None:
    """Solve A x = right (d,) with the Cholesky factor of A."""
    n = right.shape[0]
    for i in range(n):
        entry = right[i]
        for k in range(i):
            entry -= lower[i, k] * x[k]
        x[i] = entry / lower[i, i]
    for i in range(n - 1, -1, -1):
        entry = x[i]
        for k in range(i + 1, n):
            entry -= lower[k, i] * x[k]
        x[i] = entry / lower[i, i]


@jitable
def eliminate(matrix: Array, m: int, sides: int = 1) -> bool:
    """Solve the first m equations by Gauss's elimination, into column m and as many more as there are right sides.

    False if they are singular.
    """
    for k in range(m):
        pivot = k
        for r in range(k + 1, m):
            if abs(matrix[r, k]) > abs(matrix[pivot, k]):
                pivot = r
        if matrix[pivot, k] == 0.0:
            return False
        for column in range(k, m + sides):
            matrix[k, column], matrix[pivot, column] = matrix[pivot, column], matrix[k, column]
        for r in range(k + 1, m):
            factor = matrix[r, k] / matrix[k, k]
            for column in range(k + 1, m + sides):
                matrix[r, column] -= factor * matrix[k, column]
    for side in range(m, m + sides):
        for k in range(m - 1, -1, -1):
            for column in range(k + 1, m):
                matrix[k, side] -= matrix[k, column] * matrix[column, side]
            matrix[k, side] /= matrix[k, k]
    return True


@jitable
def multiply(matrix: Array, x: Array, product: Array) -> None:
    """Matrix (n, n) times x (n,) into `product` (n,)."""
    for i in range(x.shape[0]):
        total = 0.0
        for j in range(x.shape[0]):
            total += matrix[i, j] * x[j]
        product[i] = total


@jitable
def solve_dense(lower: Array, right: Array, x: Array, contacts: ContactArrays, closed: bool) -> None:
    """Solve for a vector (d,) and, with `closed`, for the rows of the closed contacts."""
    solve(lower, right, x)
    if closed:
        rows = contacts.rows
        for i in range(len(contacts.each)):
            if contacts.each[i].state != 0:
                solve(lower, rows[0, i, 0], rows[1, i, 0])
                solve(lower, rows[0, i, 1], rows[1, i, 1])


class DenseAlgebra:
    """The protocol of :class:`~oblique_impact.kernels.system.System` for a dense mass matrix."""

    def solve_mass(self: Any, rank_one: float, w: Workspace, contacts: ContactArrays, closed: bool) -> bool:  # noqa: D102
        if not factor(w.matrices[MASS], w.matrices[FACTOR]):
            return False
        v = w.vectors
        solve_dense(w.matrices[FACTOR], v[FORCES], v[FREE_ACCELERATION], contacts, closed)
        return True

    def begin_step(self: Any, t: float, h: float, q: Array, w: Workspace) -> None:
        """Do nothing: forces are those at an instant."""

    def end_step(self: Any, h: float, q: Array, qd: Array, end: Array) -> None:
        """Do nothing: the mid-point rule holds for all coordinates."""

    def take_residual(self: Any, t: float, q: Array, qd: Array, qdd: Array, w: Workspace) -> Evaluation:  # noqa: D102
        e: Evaluation = self.evaluate(t, q, qd, w)
        forces, residual = w.vectors[FORCES], w.vectors[RESIDUAL]
        multiply(w.matrices[MASS], qdd, residual)
        for i in range(q.shape[0]):
            residual[i] = forces[i] - residual[i]
        return e

    def approach(self: Any, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:  # noqa: D102
        e: Evaluation = self.evaluate(t, q, qd, w)
        return e

    def mass_product(self: Any, rank_one: float, w: Workspace, x: Array, product: Array) -> None:  # noqa: D102
        multiply(w.matrices[MASS], x, product)

    def factor_effective(  # noqa: D102
        self: Any, t: float, q: Array, velocity: float, position: float, w: Workspace, slot: int, stale: bool
    ) -> bool:
        # a dense mass matrix moves with q, so it is factored anew whether the step has changed or not
        effective, mass = w.matrices[EFFECTIVE + slot], w.matrices[MASS]
        for i in range(q.shape[0]):
            for j in range(q.shape[0]):
                effective[i, j] = mass[i, j]
        self.add_tangent(t, q, velocity, position, effective)
        return factor(effective, effective)

    def solve_effective(  # noqa: D102
        self: Any, rank_one: float, w: Workspace, slot: int, contacts: ContactArrays, closed: bool
    ) -> None:
        v = w.vectors
        solve_dense(w.matrices[EFFECTIVE + slot], v[RESIDUAL], v[INCREMENT], contacts, closed)

    def solve_rows(  # noqa: D102
        self: Any, rank_one: float, w: Workspace, slot: int, sides: int, rows: Array, responses: Array
    ) -> None:
        for k in range(rows.shape[0]):
            for side in range(sides):
                solve(w.matrices[EFFECTIVE + slot], rows[k, side], responses[k, side])

    def definiteness(self: Any, rank_one: float, w: Workspace) -> float:
        """Smallest eigenvalue of the evaluated mass matrix, 0 if it is not finite."""
        mass = w.matrices[MASS]
        return float(np.linalg.eigvalsh(mass)[0]) if np.all(np.isfinite(mass)) else 0.0
