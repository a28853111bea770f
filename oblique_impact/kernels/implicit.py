"""What an implicit scheme asks of a system besides its evaluation.

    residual           Q - M q'', with the contact rows if asked for
    approach           kinematics of the contact alone
    mass_product       M x
    factor_effective   factor of S = M + c_v C + c_q K, the constant part of the linearized step
    solve_effective    S^-1 of the residual and of the contact rows

C and K need not be exact derivatives: the scheme iterates on the residual.  Defaults are dense; a banded
system (:mod:`oblique_impact.beam.nodal_frame`) brings compiled overloads.
"""

from __future__ import annotations

from typing import Any

from numba.extending import overload

from oblique_impact.kernels.dense import factor, is_dense, solve
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.system import (
    EFFECTIVE,
    FORCES,
    INCREMENT,
    MASS,
    NORMAL_RESPONSE,
    NORMAL_ROW,
    RESIDUAL,
    TANGENT_RESPONSE,
    TANGENT_ROW,
    Array,
    Work,
    add_tangent,
    evaluate,
)


@jitable
def mass_product_dense(system: Any, work: Work, x: Array, row: int) -> None:
    """M x of an evaluated system into a row of the vectors."""
    n = x.shape[0]
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += work.matrices[MASS, i, j] * x[j]
        work.vectors[row, i] = total


@jitable
def residual_dense(system: Any, t: float, q: Array, qd: Array, qdd: Array, contact: bool, work: Work) -> None:
    """Evaluate the system and put Q - M q'' into its residual; without `contact` the rows are not needed."""
    evaluate(system, t, q, qd, work)
    mass_product_dense(system, work, qdd, RESIDUAL)
    for i in range(q.shape[0]):
        work.vectors[RESIDUAL, i] = work.vectors[FORCES, i] - work.vectors[RESIDUAL, i]


@jitable
def approach_dense(system: Any, t: float, q: Array, qd: Array, work: Work) -> None:
    """Gap, slip, their rates and the contact rows at (q, q')."""
    evaluate(system, t, q, qd, work)


@jitable
def factor_effective_dense(
    system: Any, t: float, q: Array, velocity: float, position: float, work: Work, slot: int, stale: bool
) -> bool:
    """Factor M + velocity C + position K of an evaluated system in a slot; False if not positive definite.

    A dense mass matrix moves with q, so it is factored anew whether the step has changed (`stale`) or not.
    """
    n, place = q.shape[0], EFFECTIVE + slot
    for i in range(n):
        for j in range(n):
            work.matrices[place, i, j] = work.matrices[MASS, i, j]
    add_tangent(system, t, q, velocity, position, work, place)
    return factor(work.matrices, place, place)


@jitable
def solve_effective_dense(system: Any, work: Work, slot: int, contact: bool) -> None:
    """S^-1 of the residual into INCREMENT and, with `contact`, of the contact rows into their responses."""
    place = EFFECTIVE + slot
    solve(work.matrices, work.vectors, RESIDUAL, INCREMENT, place)
    if contact:
        solve(work.matrices, work.vectors, NORMAL_ROW, NORMAL_RESPONSE, place)
        solve(work.matrices, work.vectors, TANGENT_ROW, TANGENT_RESPONSE, place)


def residual(system: Any, t: float, q: Array, qd: Array, qdd: Array, contact: bool, work: Work) -> None:
    """Evaluate and take the residual: see :func:`residual_dense`."""
    residual_dense(system, t, q, qd, qdd, contact, work)


def approach(system: Any, t: float, q: Array, qd: Array, work: Work) -> None:
    """Evaluate the contact: see :func:`approach_dense`."""
    approach_dense(system, t, q, qd, work)


def mass_product(system: Any, work: Work, x: Array, row: int) -> None:
    """Multiply by the mass matrix: see :func:`mass_product_dense`."""
    mass_product_dense(system, work, x, row)


def factor_effective(
    system: Any, t: float, q: Array, velocity: float, position: float, work: Work, slot: int, stale: bool
) -> bool:
    """Factor the effective matrix: see :func:`factor_effective_dense`."""
    return bool(factor_effective_dense(system, t, q, velocity, position, work, slot, stale))


def solve_effective(system: Any, work: Work, slot: int, contact: bool) -> None:
    """Solve with the effective matrix: see :func:`solve_effective_dense`."""
    solve_effective_dense(system, work, slot, contact)


@overload(residual, strict=False)
def _compiled_residual(system: Any, t: Any, q: Any, qd: Any, qdd: Any, contact: Any, work: Any) -> Any:
    return residual_dense if is_dense(system) else None


@overload(approach, strict=False)
def _compiled_approach(system: Any, t: Any, q: Any, qd: Any, work: Any) -> Any:
    return approach_dense if is_dense(system) else None


@overload(mass_product, strict=False)
def _compiled_mass_product(system: Any, work: Any, x: Any, row: Any) -> Any:
    return mass_product_dense if is_dense(system) else None


@overload(factor_effective, strict=False)
def _compiled_factor(
    system: Any, t: Any, q: Any, velocity: Any, position: Any, work: Any, slot: Any, stale: Any
) -> Any:
    return factor_effective_dense if is_dense(system) else None


@overload(solve_effective, strict=False)
def _compiled_solve(system: Any, work: Any, slot: Any, contact: Any) -> Any:
    return solve_effective_dense if is_dense(system) else None
