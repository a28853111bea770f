"""Contacts by complementarity: which stay closed, which stick, and the forces or impulses of all together.

Of n contacts with the Delassus matrix W (2n, 2n), accelerations of gaps and slips by unit forces, and their
accelerations w (2n,) without contact forces, unilateral contact and Coulomb's law ask of a = w + W lambda

    0 <= lambda_n _|_ a_n >= 0
    |lambda_tau| <= mu lambda_n,    lambda_tau = -mu lambda_n sign(a_tau) where a_tau is not 0

of contacts at rest (Loetstedt, SIAM J. Appl. Math. 42, 1982; Pfeiffer and Glocker, Multibody Dynamics with
Unilateral Contacts, 1996).  Over a time step the same is asked of velocities and impulses, for which a solution
always exists (Stewart and Trinkle, Int. J. Numer. Meth. Eng. 39, 1996).  Contacts may be pinned: one that slides
has lambda_tau = ratio lambda_n whatever a_tau is, one on a compliant stop a known lambda_n whatever a_n is.

The states of the step before are tried first, if there are any, and revised where they are violated: that nearly
always ends after one or two linear solves.  What does not is solved by Lemke's method, as a linear complementarity
problem with lambda_tau = b - c and the speed s of slip

    0 <= b _|_ s + a_tau >= 0,    0 <= c _|_ s - a_tau >= 0,    0 <= s _|_ mu lambda_n - b - c >= 0

In this form the matrix of contacts at rest is copositive, so that the method finds their forces (Stewart and
Trinkle 1996).  With pinned contacts and much friction there may be several solutions or none, and a ray of Lemke's
method does not say which: of a few contacts all states are tried.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import Outcome, RunEnded
from oblique_impact.kernels.dense import eliminate
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array

#: states of a contact; a closed one that is pinned to a ratio slides forwards
BACKWARDS, OPEN, FORWARDS, STUCK = -1, 0, 1, 2
_MOST_REVISIONS = 12
_ROUNDING = 1e-11  # of the largest rate, of the friction cone: in the revision of states
_PIVOT = 1e-11  # of the largest entry of a column: a smaller one is rounding
_TIE = 1e-13  # of the largest entry of the vector: ratios that differ by less are equal
_MOST_PIVOTS = 50  # per unknown; random problems need about one
_MOST_TRIED = 4  # contacts of which all states are tried, up to 4^n of them
#: of the terms of an acceleration or of the largest force: what is rounding, and what tells two motions apart
_ROUNDED, _APART = 1e-9, 1e-6
_EDGE = 1.0 - 1e-9  # of a friction cone
_DETERMINED = 1e-12  # a determinant of rows of length 1, of which a smaller one is rounding
#: unknowns of a contact in Lemke's method: lambda_n, b, c, s
_NORMAL, _FORTH, _BACK, _SPEED = range(4)


class ContactProblem(NamedTuple):
    """The problem of the first m of at most n contacts, and its solution.

    Rates are accelerations with forces (m/s^2, N) or velocities with impulses (m/s, N s); 2 k is along the normal
    of contact k, 2 k + 1 along its tangent.
    """

    states: NDArray[np.int64]  # (n,) those to begin with, then those of the solution
    friction: Array  # (n,) coefficient mu of each that may stick
    ratios: Array  # (n,) lambda_tau / lambda_n of one that is pinned to it; NaN: it may stick and slip
    pushes: Array  # (n,) known lambda_n, of compliant stops; NaN: rigid
    delassus: Array  # (2 n, 2 n) rates by unit forces
    rates: Array  # (2 n,) without contact forces
    forces: Array  # (2 n,)
    matrix: Array  # (2 n, 2 n + 1) equations of the unknown forces with their right side
    unknowns: NDArray[np.int64]  # (4 n,)
    table: Array  # of Lemke's method
    basis: NDArray[np.int64]

    @classmethod
    def new(cls, n: int, rubs: bool = True) -> ContactProblem:
        """Allocate the arrays of n rigid contacts, pinned to no friction unless they rub.

        Pages are taken as they are used.
        """
        rows = 4 * n if rubs else n
        return cls(
            np.zeros(n, dtype=np.int64),
            np.zeros(n),
            np.full(n, np.nan if rubs else 0.0),
            np.full(n, np.nan),
            np.zeros((2 * n, 2 * n)),
            np.zeros(2 * n),
            np.zeros(2 * n),
            np.zeros((2 * n, 2 * n + 1)),
            np.zeros(4 * n, dtype=np.int64),
            np.zeros((rows, 2 * rows + 2)),
            np.zeros(rows, dtype=np.int64),
        )


@jitable
def solve_contacts(p: ContactProblem, m: int, guessed: bool) -> bool:
    """Solve for the forces of m contacts, from their states if these are `guessed`; False if none are found."""
    for _ in range(_MOST_REVISIONS if guessed else 0):
        if not _solve_states(p, m):
            break
        if not _revise_states(p, m):
            return True
    return _solve_by_pivots(p, m)


@jitable
def _solve_states(p: ContactProblem, m: int) -> bool:
    """Solve for the forces that the states ask for; False if they are not determined."""
    size = 0
    for k in range(m):
        _take_known(p, k)
        if p.states[k] != OPEN and np.isnan(p.pushes[k]):
            p.unknowns[size] = 2 * k
            size += 1
        if p.states[k] == STUCK:
            p.unknowns[size] = 2 * k + 1
            size += 1
    for r in range(size):
        row = p.unknowns[r]
        for c in range(size):
            column = p.unknowns[c]
            entry = p.delassus[row, column]
            if column % 2 == 0:
                entry += _ratio(p, column // 2) * p.delassus[row, column + 1]
            p.matrix[r, c] = entry
        p.matrix[r, size] = -_rate(p, m, row)
    if not eliminate(p.matrix, size):
        return False
    for r in range(size):
        row, value = p.unknowns[r], p.matrix[r, size]
        p.forces[row] = value
        if row % 2 == 0:
            p.forces[row + 1] = _ratio(p, row // 2) * value
    return True


@jitable
def _take_known(p: ContactProblem, k: int) -> None:
    """Begin with the forces of contact k that are known, in its state."""
    p.forces[2 * k] = 0.0 if np.isnan(p.pushes[k]) else p.pushes[k]
    p.forces[2 * k + 1] = _ratio(p, k) * p.forces[2 * k]


@jitable
def _ratio(p: ContactProblem, k: int) -> float:
    """lambda_tau over lambda_n of a contact as far as its state says it; 0 where it sticks or is open."""
    if not np.isnan(p.ratios[k]):
        return float(p.ratios[k])
    return float(-p.states[k] * p.friction[k]) if p.states[k] != STUCK else 0.0


@jitable
def _rate(p: ContactProblem, m: int, row: int) -> float:
    """Rate with the forces."""
    total = p.rates[row]
    for k in range(2 * m):
        total += p.delassus[row, k] * p.forces[k]
    return float(total)


@jitable
def _revise_states(p: ContactProblem, m: int) -> bool:
    """Change the states of all contacts that their forces and rates contradict; whether there are any."""
    largest, changed = 0.0, False
    for k in range(2 * m):
        largest = max(largest, abs(p.rates[k]))
    small = _ROUNDING * largest
    for k in range(m):
        normal, tangential, before = p.forces[2 * k], p.forces[2 * k + 1], p.states[k]
        rigid, rests = np.isnan(p.pushes[k]), np.isnan(p.ratios[k])
        least, cone = small / p.delassus[2 * k, 2 * k], p.friction[k] * normal
        if before == OPEN:
            if _rate(p, m, 2 * k) < -small:
                p.states[k] = STUCK if rests else FORWARDS
        elif rigid and not normal >= -least:
            p.states[k] = OPEN
        elif rigid and abs(_rate(p, m, 2 * k)) > 1e3 * small:
            return True  # the equations are singular: what they gave solves nothing
        elif before == STUCK:
            if abs(tangential) > cone + _ROUNDING * abs(cone) + least:
                p.states[k] = BACKWARDS if tangential > 0.0 else FORWARDS
        elif rests and before * _rate(p, m, 2 * k + 1) < -small:
            p.states[k] = STUCK
        changed = changed or p.states[k] != before
    return changed


@jitable
def _solve_by_pivots(p: ContactProblem, m: int) -> bool:
    """Solve by Lemke's method, see the top of this file; False where it ends in a ray."""
    n, least, table = 0, 0.0, p.table
    for kind in range(4):
        for k in range(m):
            if np.isnan(p.pushes[k] if kind == _NORMAL else p.ratios[k]):
                p.unknowns[n] = kind * m + k
                n += 1
    for k in range(m):
        p.states[k] = STUCK if np.isnan(p.ratios[k]) else FORWARDS
        _take_known(p, k)
    for r in range(n):
        kind, k = p.unknowns[r] // m, p.unknowns[r] % m
        row, sign = 2 * k + min(kind, 1), -1.0 if kind == _BACK else 1.0
        p.basis[r] = r
        for c in range(2 * n + 2):
            table[r, c] = 0.0
        table[r, r], table[r, 2 * n] = 1.0, -1.0
        known = p.friction[k] * p.forces[2 * k] if kind == _SPEED else sign * _rate(p, m, row)
        table[r, 2 * n + 1], least = known, min(least, known)
        for c in range(n):
            other, j = p.unknowns[c] // m, p.unknowns[c] % m
            entry = 0.0
            if kind != _SPEED and other == _NORMAL:
                entry = p.delassus[row, 2 * j] + _ratio(p, j) * p.delassus[row, 2 * j + 1]
            elif kind != _SPEED and other != _SPEED:
                entry = p.delassus[row, 2 * j + 1] if other == _FORTH else -p.delassus[row, 2 * j + 1]
            elif j == k and kind == _SPEED and other != _SPEED:
                entry = p.friction[k] if other == _NORMAL else -1.0
            elif j == k and kind != _NORMAL and other != kind:
                entry = sign
            table[r, n + c] = -sign * entry
    if least < 0.0 and not _exchange_rows(table, p.basis, n):
        return False
    for r in range(n):
        table[r, 2 * n] = 0.0  # where the artificial variable was: values of the unknowns
    for r in range(n):
        if n <= p.basis[r] < 2 * n:
            table[p.basis[r] - n, 2 * n] = max(table[r, 2 * n + 1], 0.0)
    for c in range(n):  # first all normal forces, last the speeds
        kind, k, value = p.unknowns[c] // m, p.unknowns[c] % m, table[c, 2 * n]
        if kind == _NORMAL:
            p.forces[2 * k], p.forces[2 * k + 1] = value, _ratio(p, k) * value
            if value == 0.0:
                p.states[k] = OPEN
        elif kind != _SPEED and p.states[k] != OPEN:  # whose friction is rounding
            p.forces[2 * k + 1] += value if kind == _FORTH else -value
        # at a speed that is not rounding friction is at the edge of its cone
        elif p.states[k] == STUCK and value > 0.0 and _is_at_edge(p, k):
            along = -p.forces[2 * k + 1]
            if along == 0.0:  # no friction holds it
                along = _rate(p, m, 2 * k + 1)
            p.states[k] = FORWARDS if along >= 0.0 else BACKWARDS
    return True


@jitable
def _is_at_edge(p: ContactProblem, k: int) -> bool:
    """Whether friction is at the edge of its cone; inside of it a speed of slip is rounding."""
    return bool(abs(p.forces[2 * k + 1]) >= _EDGE * p.friction[k] * p.forces[2 * k])


@jitable
def _exchange_rows(table: Array, basis: NDArray[np.int64], n: int) -> bool:
    """Find z >= 0 with w = M z + q >= 0 and z.w = 0 by pivots in the first n rows [1, -M, -1, q]; False in a ray.

    Lemke's complementary pivoting with the lexicographic choice of rows, which cannot cycle (Cottle, Pang, Stone,
    The Linear Complementarity Problem, 1992, Secs. 4.4 and 4.9).  Columns 0..n-1 are w, n..2n-1 are z, 2n is the
    artificial variable; `basis` (n,), at first 0..n-1, are then the variables of the rows, whose values are in the
    last column.
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
            break
    for r in range(n):
        if basis[r] == covering:  # of redundant contacts it may be zero already
            return bool(row < 0 and table[r, last] <= _TIE * scale)
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
    """Solve for the forces of closed contacts, at rest or sliding, see the top of this file.

    Of several solutions of up to four contacts that with the fewest closed ones is taken.

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
    n = len(candidates)
    p = ContactProblem.new(n)
    p.delassus[:], p.rates[:] = delassus.reshape(2 * n, 2 * n), free.ravel()
    p.friction[:] = [c.static for c in candidates]
    p.ratios[:] = [c.ratio if c.slip else np.nan for c in candidates]
    p.pushes[:] = [np.nan if c.push is None else c.push for c in candidates]
    solutions = [_solution_of(p, p.states, p.forces)] if solve_contacts(p, n, False) else []
    if n <= _MOST_TRIED:
        solutions += _by_trying(p, bool(solutions))
    if not solutions:
        raise RunEnded(Outcome.PAINLEVE)
    fewest = min(solutions, key=lambda solution: np.count_nonzero(solution.forces[:, 0]))
    return fewest._replace(several=any(_differ(delassus, fewest, other) for other in solutions))


def plastic_impulses(delassus: Array, rates: Array) -> Array:
    """Return the normal impulses P (n,), N s, of a plastic impact without friction.

    P >= 0, v + W P >= 0, their product 0 (Moreau 1988): `delassus` W (n, n) is that of the normals, `rates` v (n,)
    the gap rates before (m/s).  Raises RunEnded if there are none.
    """
    p = ContactProblem.new(len(rates), rubs=False)
    p.delassus[::2, ::2], p.rates[::2] = delassus, rates
    if not solve_contacts(p, len(rates), False):
        raise RunEnded(Outcome.REDUNDANT_CONSTRAINTS)
    return p.forces[::2]


def _solution_of(p: ContactProblem, states: NDArray[np.int64], forces: Array) -> ContactSolution:
    """Return forces (2n,) with their motion; what a state says is 0 is that exactly, the rest only to rounding."""
    found = (p.rates + p.delassus @ forces).reshape(-1, 2)
    found[(states != OPEN) & np.isnan(p.pushes), 0] = found[states == STUCK, 1] = 0.0
    slips = np.isnan(p.ratios) & (np.abs(states) == 1)
    found[slips, 1] = states[slips] * np.abs(found[slips, 1])
    return ContactSolution(forces.reshape(-1, 2).copy(), found)


def _differ(delassus: Array, one: ContactSolution, other: ContactSolution) -> bool:
    """Whether two solutions are different motions; redundant contacts may share their forces in several ways."""
    forces = np.abs(one.forces) + np.abs(other.forces)
    size = np.abs(one.accelerations) + np.abs(other.accelerations) + np.tensordot(np.abs(delassus), forces, axes=2)
    return bool(np.any(np.abs(one.accelerations - other.accelerations) > _APART * size))


def _by_trying(p: ContactProblem, found: bool) -> Iterator[ContactSolution]:
    """Yield the solutions of all states that determine the forces, none if one is `found` and the only one.

    There is one solution for any free accelerations if all determinants have one sign: forces and accelerations
    are a normal map of a polyhedral set (Robinson, Math. Oper. Res. 17, 1992).
    """
    n, rigid, rests = len(p.states), np.isnan(p.pushes), np.isnan(p.ratios)
    choices = [
        [OPEN] * bool(opens) + ([STUCK, BACKWARDS, FORWARDS] if sticks else [FORWARDS])
        for opens, sticks in zip(rigid, rests, strict=True)
    ]
    states = np.array(list(product(*choices)))  # (cases, n)
    closed, sticks = states != OPEN, states == STUCK
    ratios = np.where(closed, np.where(rests, -states * p.friction, p.ratios), 0.0)[:, :, None]
    unit, rows = np.eye(2 * n).reshape(n, 2, -1), p.delassus.reshape(n, 2, -1)
    normal = np.where((closed & rigid)[:, :, None], rows[:, 0], unit[:, 0])
    tangential = np.where(sticks[:, :, None], rows[:, 1], unit[:, 1] - ratios * unit[:, 0])
    equations = np.stack([normal, tangential], axis=2).reshape(-1, 2 * n, 2 * n)
    sizes = np.prod(np.linalg.norm(equations, axis=2), axis=1)
    # a row of zeros, of a direction that nothing moves in, leaves a state undetermined
    determinants = np.linalg.det(equations) / np.where(sizes > 0.0, sizes, 1.0)
    if found and np.all(determinants > -_DETERMINED):
        return
    chosen = np.abs(determinants) > _DETERMINED
    states, closed, sticks, free = states[chosen], closed[chosen], sticks[chosen], p.rates.reshape(n, 2)
    pushes = np.where(rigid, np.where(closed, -free[:, 0], 0.0), p.pushes)
    right = np.stack([pushes, np.where(sticks, -free[:, 1], 0.0)], axis=2).reshape(-1, 2 * n, 1)
    forces = np.linalg.solve(equations[chosen], right)[:, :, 0]
    rates = free + (forces @ p.delassus.T).reshape(-1, n, 2)
    terms = _ROUNDED * (np.abs(free) + (np.abs(forces) @ np.abs(p.delassus).T).reshape(-1, n, 2))
    small, forces = _ROUNDED * np.max(np.abs(forces), axis=1)[:, None], forces.reshape(-1, n, 2)
    pulls = rigid & (forces[:, :, 0] < -small)
    sinks = rigid & (rates[:, :, 0] < -terms[:, :, 0])
    leaves = sticks & (np.abs(forces[:, :, 1]) > p.friction * forces[:, :, 0] + small)
    against = rests & ~sticks & (rates[:, :, 1] * states < -terms[:, :, 1])
    for case in np.flatnonzero(~np.any(pulls | sinks | leaves | against, axis=1)):
        holds = ~rigid | (closed[case] & (forces[case, :, 0] > small[case]))
        yield _solution_of(p, states[case], (forces[case] * holds[:, None]).ravel())
