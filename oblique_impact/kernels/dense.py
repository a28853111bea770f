"""Dense linear algebra of small systems on their packed work arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba.core import types
from numba.extending import overload

from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.system import (
    CHOLESKY,
    FORCES,
    FREE_ACCELERATION,
    MASS,
    NORMAL_RESPONSE,
    NORMAL_ROW,
    TANGENT_RESPONSE,
    TANGENT_ROW,
    Array,
    Work,
)


@jitable
def factor(matrices: Array, source: int = MASS, target: int = CHOLESKY) -> bool:
    """Cholesky factor of matrices[source] into matrices[target]; False if it is not positive definite.

    Source and target may be the same.
    """
    n = matrices.shape[1]
    for j in range(n):
        pivot = matrices[source, j, j]
        for k in range(j):
            pivot -= matrices[target, j, k] * matrices[target, j, k]
        if not pivot > 0.0:
            return False
        root = np.sqrt(pivot)
        matrices[target, j, j] = root
        for i in range(j + 1, n):
            entry = matrices[source, i, j]
            for k in range(j):
                entry -= matrices[target, i, k] * matrices[target, j, k]
            matrices[target, i, j] = entry / root
    return True


@jitable
def solve(matrices: Array, vectors: Array, right: int, x: int, slot: int = CHOLESKY) -> None:
    """Solve A x = right for two rows of `vectors` with the factor of A in matrices[slot]."""
    n = matrices.shape[1]
    for i in range(n):
        entry = vectors[right, i]
        for k in range(i):
            entry -= matrices[slot, i, k] * vectors[x, k]
        vectors[x, i] = entry / matrices[slot, i, i]
    for i in range(n - 1, -1, -1):
        entry = vectors[x, i]
        for k in range(i + 1, n):
            entry -= matrices[slot, k, i] * vectors[x, k]
        vectors[x, i] = entry / matrices[slot, i, i]


@jitable
def row_dot(vectors: Array, a: int, b: int) -> float:
    """Scalar product of two rows of `vectors`."""
    total = 0.0
    for i in range(vectors.shape[1]):
        total += vectors[a, i] * vectors[b, i]
    return total


def is_dense(system: Any) -> bool:
    """Whether a compiled system keeps dense matrices (numba type; banded ones have a field `bands`)."""
    return isinstance(system, types.NamedTuple) and "bands" not in system.fields


@jitable
def solve_mass_dense(system: Any, work: Work, contact: bool) -> bool:
    """Acceleration without contact force and, with `contact`, M^-1 D_n^T and M^-1 D_tau^T of an evaluated system.

    False if the mass matrix is not positive definite.
    """
    matrices, v = work.matrices, work.vectors
    if not factor(matrices):
        return False
    solve(matrices, v, FORCES, FREE_ACCELERATION)
    if contact:
        solve(matrices, v, NORMAL_ROW, NORMAL_RESPONSE)
        solve(matrices, v, TANGENT_ROW, TANGENT_RESPONSE)
    return True


def solve_mass(system: Any, work: Work, contact: bool) -> bool:
    """Solve with the mass matrix of an evaluated system: see :func:`solve_mass_dense`."""
    return bool(solve_mass_dense(system, work, contact))


@overload(solve_mass, strict=False)
def _compiled_solve_mass(system: Any, work: Any, contact: Any) -> Any:
    return solve_mass_dense if is_dense(system) else None
