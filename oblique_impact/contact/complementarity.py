"""Several contacts at once, by complementarity: which stay closed, which stick, and how impulses are shared.

In a plane Coulomb's law with stick is a linear complementarity problem (Loetstedt, SIAM J. Appl. Math. 42, 1982;
Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts, 1996), which Lemke's method solves exactly.
With much friction there may be several solutions or none, and a ray of Lemke's method does not say which: of a
few contacts all states are tried.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array

_PIVOT = 1e-11  # of the largest entry of a column: a smaller one is rounding
_TIE = 1e-13  # of the largest entry of the vector: ratios that differ by less are equal
_MOST_PIVOTS = 50  # per unknown; random problems need about one
_MOST_TRIED = 4  # contacts of which all states are tried, up to 4^n of them
#: of the terms of an acceleration or of the largest force: what is rounding, and what tells two motions apart
_ROUNDED, _APART = 1e-9, 1e-6
_DETERMINED = 1e-12  # a determinant of rows of length 1, of which a smaller one is rounding


class NoSolutionError(Exception):
    """Lemke's method ended in a ray: for matrices of contacts, the problem has no solution."""


def lemke(matrix: Array, vector: Array) -> Array:
    """Return z >= 0 with w = M z + q >= 0 and z.w = 0, shape (n,), for `matrix` M (n, n) and `vector` q (n,).

    Lemke's complementary pivoting with the lexicographic choice of rows, which cannot cycle (Cottle, Pang, Stone,
    The Linear Complementarity Problem, 1992, Secs. 4.4 and 4.9).  Raises NoSolutionError where it ends in a ray.
    """
    n = len(vector)
    if n == 0 or np.min(vector) >= 0.0:
        return np.zeros(n)
    table = np.hstack([np.eye(n), -matrix, -np.ones((n, 1)), vector[:, None]])
    basis = np.arange(n)
    if not exchange_rows(table, basis, n):
        raise NoSolutionError
    z = np.zeros(2 * n)
    z[basis] = table[:, -1]
    return np.maximum(z[n:], 0.0)


@jitable
def exchange_rows(table: Array, basis: NDArray[np.int64], n: int) -> bool:
    """Carry :func:`lemke` out on its first n rows [1, -M, -1, q]; False where it ends in a ray.

    Columns 0..n-1 are w, n..2n-1 are z, 2n is the artificial variable; `basis` (n,), at first 0..n-1, are then the
    variables of the rows, whose values are in the last column.
    """
    covering, last, row, scale = 2 * n, 2 * n + 1, 0, 0.0
    for r in range(n):
        scale = max(scale, abs(table[r, last]))
        if table[r, last] <= table[row, last]:
            row = r
    entering = covering
    for _ in range(_MOST_PIVOTS * n):
        pivot = table[row, entering]
        for c in range(last + 1):
            table[row, c] /= pivot
        for r in range(n):
            factor = table[r, entering]
            if r != row and factor != 0.0:
                for c in range(last + 1):
                    table[r, c] -= factor * table[row, c]
        leaving = basis[row]
        basis[row] = entering
        if leaving == covering:
            return True
        entering = leaving + n if leaving < n else leaving - n
        row = _leaving_row(table, basis, n, entering, _TIE * scale)
        if row < 0:
            return False
    return False


@jitable
def _leaving_row(table: Array, basis: NDArray[np.int64], n: int, entering: int, tie: float) -> int:
    """Row whose variable leaves the basis, -1 if there is none; the artificial one leaves as soon as it can.

    Columns 0..n-1 are those of the inverse of the basis: rows in their lexicographic order have no ties.
    """
    largest, least, row = 0.0, np.inf, -1
    for r in range(n):
        largest = max(largest, abs(table[r, entering]))
    smallest = _PIVOT * largest
    for r in range(n):
        if table[r, entering] > smallest:
            least = min(least, table[r, 2 * n + 1] / table[r, entering])
    for r in range(n):
        if not table[r, entering] > smallest or table[r, 2 * n + 1] / table[r, entering] > least + tie:
            continue
        if basis[r] == 2 * n:
            return r
        c = 0 if row >= 0 else n
        while c < n and table[r, c] / table[r, entering] == table[row, c] / table[row, entering]:
            c += 1
        if row < 0 or (c < n and table[r, c] / table[r, entering] < table[row, c] / table[row, entering]):
            row = r
    return row


class Closed(NamedTuple):
    """A closed contact whose forces are wanted."""

    slip: int  # direction of slip; 0: at rest, so that it may stick
    ratio: float  # lambda_tau / lambda_n, while it slides
    static: float  # coefficient of friction at rest
    push: float | None  # N, the normal force of a compliant stop; None of a rigid one


class ContactSolution(NamedTuple):
    """Forces and accelerations of n contacts, each (n, 2): normal and tangential."""

    forces: Array  # N
    accelerations: Array  # m/s^2, of gap and slip
    several: bool = False  # whether there are other solutions, with other accelerations


def contact_forces(delassus: Array, free: Array, candidates: Sequence[Closed]) -> ContactSolution:
    """Solve for the forces of closed contacts, at rest or sliding.

    With 0 <= lambda_n, 0 <= gap'', their product 0, a contact that slides has lambda_tau = ratio lambda_n.  One at
    rest has lambda_tau = b - c with b, c >= 0, and

        0 <= b _|_ s + slip'' >= 0,   0 <= c _|_ s - slip'' >= 0,   0 <= s _|_ mu lambda_n - b - c >= 0

    In this form the matrix of contacts at rest is copositive, so that Lemke's method finds their forces
    (Stewart and Trinkle, Int. J. Numer. Meth. Eng. 39, 1996).  Of several solutions of up to four contacts that
    with the fewest closed ones is taken.

    Parameters
    ----------
    delassus : ndarray, shape (n, 2, n, 2)
        Accelerations of gap and slip of each contact (m/s^2) by a unit force, normal or tangential, of each.
    free : ndarray, shape (n, 2)
        Accelerations of gap and slip without contact forces (m/s^2).
    candidates : sequence of Closed
        The n contacts.

    Raises
    ------
    RunEnded
        With the outcome Painleve, if no forces exist, or of more than four contacts if none are found.
    """
    found = _by_pivots(delassus, free, candidates)
    if len(candidates) <= _MOST_TRIED:
        cases = _Cases(delassus, free, candidates)
        solutions = [] if found is None else [found]
        if found is None or not cases.are_coherent:
            solutions += cases.solutions()
        if solutions:
            fewest = min(solutions, key=lambda solution: np.count_nonzero(solution.forces[:, 0]))
            return fewest._replace(several=any(_differ(delassus, fewest, other) for other in solutions))
    if found is None:
        raise RunEnded(Outcome.PAINLEVE)
    return found


def _differ(delassus: Array, one: ContactSolution, other: ContactSolution) -> bool:
    """Whether two solutions are different motions; redundant contacts may share their forces in several ways."""
    forces = np.abs(one.forces) + np.abs(other.forces)
    size = np.abs(one.accelerations) + np.abs(other.accelerations) + np.tensordot(np.abs(delassus), forces, axes=2)
    return bool(np.any(np.abs(one.accelerations - other.accelerations) > _APART * size))


class _Cases:
    """The linear equations of all states that n contacts may have, the arguments as of :func:`contact_forces`."""

    def __init__(self, delassus: Array, free: Array, candidates: Sequence[Closed]) -> None:
        n = len(candidates)
        self._delassus, self._free, self._candidates = delassus.reshape(2 * n, 2 * n), free, candidates
        self._rigid = np.array([c.push is None for c in candidates])
        # open or closed, and lambda_tau / lambda_n; NaN: it sticks
        choices = [
            [(0.0, 0.0)] * (c.push is None)
            + [(1.0, ratio) for ratio in ([c.ratio] if c.slip else [np.nan, c.static, -c.static])]
            for c in candidates
        ]
        states = np.array(list(product(*choices)))  # (cases, n, 2)
        self._closed, self._ratios = states[:, :, 0] > 0.0, states[:, :, 1]
        self._sticks = np.isnan(self._ratios)
        unit, rows = np.eye(2 * n).reshape(n, 2, -1), delassus.reshape(n, 2, -1)
        ratios = np.where(self._sticks, 0.0, self._ratios)[:, :, None]
        normal = np.where((self._closed & self._rigid)[:, :, None], rows[:, 0], unit[:, 0])
        tangential = np.where(self._sticks[:, :, None], rows[:, 1], unit[:, 1] - ratios * unit[:, 0])
        self._equations = np.stack([normal, tangential], axis=2).reshape(-1, 2 * n, 2 * n)
        sizes = np.prod(np.linalg.norm(self._equations, axis=2), axis=1)
        # a row of zeros, of a direction that nothing moves in, leaves a state undetermined
        self._determinants = np.linalg.det(self._equations) / np.where(sizes > 0.0, sizes, 1.0)

    @property
    def are_coherent(self) -> bool:
        """Whether there is one solution for any free accelerations: all determinants have one sign.

        Forces and accelerations are a normal map of a polyhedral set (Robinson, Math. Oper. Res. 17, 1992).
        """
        return bool(np.all(self._determinants > -_DETERMINED))

    def solutions(self) -> Iterator[ContactSolution]:
        """Yield the solutions whose states determine the forces."""
        n, chosen = len(self._candidates), np.abs(self._determinants) > _DETERMINED
        closed, ratios, sticks = self._closed[chosen], self._ratios[chosen], self._sticks[chosen]
        pushes = np.array([c.push or 0.0 for c in self._candidates])
        static = np.array([c.static for c in self._candidates])
        resting = np.array([c.slip == 0 for c in self._candidates])
        normal = np.where(closed & self._rigid, -self._free[:, 0], pushes)
        right = np.stack([normal, np.where(sticks, -self._free[:, 1], 0.0)], axis=2).reshape(-1, 2 * n, 1)
        forces = np.linalg.solve(self._equations[chosen], right)[:, :, 0]
        found = self._free + (forces @ self._delassus.T).reshape(-1, n, 2)
        terms = np.abs(self._free) + (np.abs(forces) @ np.abs(self._delassus).T).reshape(-1, n, 2)
        small = _ROUNDED * np.max(np.abs(forces), axis=1)[:, None]
        forces = forces.reshape(-1, n, 2)
        pulls = self._rigid & (forces[:, :, 0] < -small)
        sinks = self._rigid & (found[:, :, 0] < -_ROUNDED * terms[:, :, 0])
        leaves = sticks & (np.abs(forces[:, :, 1]) > static * forces[:, :, 0] + small)
        along = resting & (found[:, :, 1] * np.sign(np.nan_to_num(ratios)) > _ROUNDED * terms[:, :, 1])
        for case in np.flatnonzero(~np.any(pulls | sinks | leaves | along, axis=1)):
            holds = ~self._rigid | (closed[case] & (forces[case, :, 0] > small[case]))
            # what a state says is 0 is that exactly
            found[case, closed[case] & self._rigid, 0] = found[case, sticks[case], 1] = 0.0
            yield ContactSolution(forces[case] * holds[:, None], found[case])


def _by_pivots(delassus: Array, free: Array, candidates: Sequence[Closed]) -> ContactSolution | None:
    """Return the solution by Lemke's method, None where it ends in a ray."""
    n = len(candidates)
    normal = [i for i, c in enumerate(candidates) if c.push is None]
    resting = [i for i, c in enumerate(candidates) if c.slip == 0]
    k, m = len(normal), len(resting)
    # forces = known + shares z, z = (lambda_n of the rigid contacts; b, c and s of those at rest)
    known, shares = np.zeros((n, 2)), np.zeros((n, 2, k + 3 * m))
    for i, c in enumerate(candidates):
        known[i, 0] = c.push or 0.0
    for column, i in enumerate(normal):
        shares[i, 0, column] = 1.0
    for i, c in enumerate(candidates):
        if c.slip != 0:
            known[i, 1], shares[i, 1] = c.ratio * known[i, 0], c.ratio * shares[i, 0]
    for column, i in enumerate(resting, start=k):
        shares[i, 1, column], shares[i, 1, column + m] = 1.0, -1.0
    by_z, by_known = np.tensordot(delassus, shares, axes=2), free + np.tensordot(delassus, known, axes=2)
    matrix, vector = np.zeros((k + 3 * m, k + 3 * m)), np.zeros(k + 3 * m)
    for row, i in enumerate(normal):
        matrix[row], vector[row] = by_z[i, 0], by_known[i, 0]
    for b, i in enumerate(resting, start=k):
        back, slack, static = b + m, b + 2 * m, candidates[i].static  # of c and s
        matrix[b], vector[b] = by_z[i, 1], by_known[i, 1]
        matrix[back], vector[back] = -by_z[i, 1], -by_known[i, 1]
        matrix[[b, back], slack] += 1.0
        matrix[slack], vector[slack] = static * shares[i, 0], static * known[i, 0]
        matrix[slack, [b, back]] -= 1.0
    try:
        z = lemke(matrix, vector)
    except NoSolutionError:
        return None
    forces = known + shares @ z
    found = free + np.tensordot(delassus, forces, axes=2)
    # what is not in the basis is 0 exactly, what is computed from it only to rounding
    for row, i in enumerate(normal):
        if z[row] > 0.0:
            found[i, 0] = 0.0
    for b, i in enumerate(resting, start=k):
        if z[b] > 0.0 and z[b + m] > 0.0:  # it sticks: both say that s is 0
            found[i, 1] = 0.0
        elif z[b] > 0.0 or z[b + m] > 0.0 or z[b + 2 * m] == 0.0:  # |slip''| <= s
            found[i, 1] = z[b + 2 * m] * (1.0 if z[b + m] > z[b] else -1.0)
    return ContactSolution(forces, found)


def plastic_impulses(delassus: Array, rates: Array) -> Array:
    """Return the normal impulses P (n,), N s, of a plastic impact without friction.

    P >= 0, v + W P >= 0, their product 0 (Moreau 1988): `delassus` W (n, n) is that of the normals, `rates` v (n,)
    the gap rates before (m/s).
    """
    return lemke(delassus, rates)
