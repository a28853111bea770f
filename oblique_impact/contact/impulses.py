"""Impulses of several rigid contacts over a time step, by complementarity on the velocities at its end.

With the velocities u of the gaps and s of the slips that the step would end with, the matrix W of velocities by
unit impulses and Coulomb's law

    0 <= P_n _|_ u + W P >= 0,    |P_tau| <= mu P_n,    P_tau = -mu P_n sign(s) where a contact slips

The states of the step before are tried first and revised where they are violated, which nearly always ends after
one or two linear solves; what does not is solved by Lemke's method (Stewart and Trinkle, Int. J. Numer. Meth. Eng.
39, 1996), for which at the level of velocities a solution always exists.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.complementarity import exchange_rows
from oblique_impact.kernels.dense import eliminate
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array

#: states of a contact in a step; without friction a closed one slips forwards
BACKWARDS, OPEN, FORWARDS, STUCK = -1, 0, 1, 2
_MOST_REVISIONS = 12
_ROUNDING = 1e-11  # of the largest velocity, of the friction cone


class ImpulseProblem(NamedTuple):
    """The problem of the first m of at most n contacts, and its solution."""

    states: NDArray[np.int64]  # (n,) those to begin with, then those of the solution
    friction: Array  # (n,) coefficient of each
    delassus: (
        Array  # (2 n, 2 n) m/s by unit impulses; 2 k is along the normal of contact k, 2 k + 1 along its tangent
    )
    rates: Array  # (2 n,) m/s, without impulses: u and s
    impulses: Array  # (2 n,) N s
    matrix: Array  # (2 n, 2 n + 1) equations of the unknown impulses with their right side
    unknowns: NDArray[np.int64]  # (2 n,)
    table: Array  # of Lemke's method
    basis: NDArray[np.int64]

    @classmethod
    def new(cls, n: int, rubs: bool) -> ImpulseProblem:
        """Allocate the arrays of n contacts, with friction if they rub; pages are taken as they are used."""
        rows = 4 * n if rubs else n
        return cls(
            np.zeros(n, dtype=np.int64),
            np.zeros(n),
            np.zeros((2 * n, 2 * n)),
            np.zeros(2 * n),
            np.zeros(2 * n),
            np.zeros((2 * n, 2 * n + 1)),
            np.zeros(2 * n, dtype=np.int64),
            np.zeros((rows, 2 * rows + 2)),
            np.zeros(rows, dtype=np.int64),
        )


@jitable
def solve_impulses(p: ImpulseProblem, m: int, rubs: bool) -> bool:
    """Solve for the impulses of m contacts; False if there is no solution."""
    for _ in range(_MOST_REVISIONS):
        if not _solve_states(p, m):
            break
        if not _revise_states(p, m, rubs):
            return True
    return _solve_by_pivots(p, m, rubs)


@jitable
def _solve_states(p: ImpulseProblem, m: int) -> bool:
    """Solve for the impulses that the states ask for; False if they are not determined."""
    size = 0
    for k in range(m):
        p.impulses[2 * k], p.impulses[2 * k + 1] = 0.0, 0.0
        if p.states[k] != OPEN:
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
            if column % 2 == 0 and p.states[column // 2] != STUCK:
                entry += _ratio(p, column // 2) * p.delassus[row, column + 1]
            p.matrix[r, c] = entry
        p.matrix[r, size] = -p.rates[row]
    if not eliminate(p.matrix, size):
        return False
    for r in range(size):
        row, value = p.unknowns[r], p.matrix[r, size]
        p.impulses[row] = value
        if row % 2 == 0 and p.states[row // 2] != STUCK:
            p.impulses[row + 1] = _ratio(p, row // 2) * value
    return True


@jitable
def _ratio(p: ImpulseProblem, k: int) -> float:
    """P_tau over P_n of a contact that slips."""
    return float(-p.states[k] * p.friction[k])


@jitable
def _velocity(p: ImpulseProblem, m: int, row: int) -> float:
    """Velocity (m/s) with the impulses."""
    total = p.rates[row]
    for k in range(2 * m):
        total += p.delassus[row, k] * p.impulses[k]
    return float(total)


@jitable
def _revise_states(p: ImpulseProblem, m: int, rubs: bool) -> bool:
    """Change the states of all contacts that their impulses and velocities contradict; whether there are any."""
    largest, changed = 0.0, False
    for k in range(2 * m if rubs else m):
        largest = max(largest, abs(p.rates[k if rubs else 2 * k]))
    small = _ROUNDING * largest
    for k in range(m):
        normal, tangential, before = p.impulses[2 * k], p.impulses[2 * k + 1], p.states[k]
        least, cone = small / p.delassus[2 * k, 2 * k], p.friction[k] * normal
        if before == OPEN:
            if _velocity(p, m, 2 * k) < -small:
                p.states[k] = FORWARDS
                if rubs:
                    p.states[k] = STUCK
        elif not normal >= -least:
            p.states[k] = OPEN
        elif abs(_velocity(p, m, 2 * k)) > 1e3 * small:
            return True  # the equations are singular: what they gave solves nothing
        elif before == STUCK:
            if abs(tangential) > cone + _ROUNDING * abs(cone) + least:
                p.states[k] = BACKWARDS if tangential > 0.0 else FORWARDS
        elif rubs and before * _velocity(p, m, 2 * k + 1) < -small:
            p.states[k] = STUCK
        changed = changed or p.states[k] != before
    return changed


@jitable
def _solve_by_pivots(p: ImpulseProblem, m: int, rubs: bool) -> bool:
    """Solve by Lemke's method, see `oblique_impact.contact.complementarity.contact_forces`.

    The unknowns are m normal impulses P and, with friction, P_tau = b - c with b and c, and the slip velocity s.
    """
    n, table = 4 * m if rubs else m, p.table
    one, least = n, 0.0
    for r in range(n):
        p.basis[r] = r
        for c in range(2 * n + 2):
            table[r, c] = 0.0
        table[r, r], table[r, 2 * n] = 1.0, -1.0
    for k in range(m):
        for j in range(m):
            table[k, one + j] = -p.delassus[2 * k, 2 * j]
            if rubs:
                across, turned = p.delassus[2 * k, 2 * j + 1], p.delassus[2 * k + 1, 2 * j]
                along = p.delassus[2 * k + 1, 2 * j + 1]
                table[k, one + m + j], table[k, one + 2 * m + j] = -across, across
                table[m + k, one + j], table[2 * m + k, one + j] = -turned, turned
                table[m + k, one + m + j], table[m + k, one + 2 * m + j] = -along, along
                table[2 * m + k, one + m + j], table[2 * m + k, one + 2 * m + j] = along, -along
        table[k, 2 * n + 1] = p.rates[2 * k]
        least = min(least, p.rates[2 * k])
        if rubs:
            table[m + k, one + 3 * m + k] = table[2 * m + k, one + 3 * m + k] = -1.0
            table[3 * m + k, one + k] = -p.friction[k]
            table[3 * m + k, one + m + k] = table[3 * m + k, one + 2 * m + k] = 1.0
            table[m + k, 2 * n + 1], table[2 * m + k, 2 * n + 1] = p.rates[2 * k + 1], -p.rates[2 * k + 1]
            least = min(least, -abs(p.rates[2 * k + 1]))
    for k in range(m):
        p.impulses[2 * k], p.impulses[2 * k + 1], p.states[k] = 0.0, 0.0, OPEN
    if least >= 0.0:
        return True
    if not exchange_rows(table, p.basis, n):
        return False
    for r in range(n):
        which = p.basis[r] - n
        if 0 <= which < 3 * m and table[r, 2 * n + 1] > 0.0:
            k, value = which % m, table[r, 2 * n + 1]
            if which < m:
                p.impulses[2 * k], p.states[k] = value, STUCK if rubs else FORWARDS
            else:
                p.impulses[2 * k + 1] += value if which < 2 * m else -value
    for r in range(n):
        which = p.basis[r] - n
        if rubs and which >= 3 * m and table[r, 2 * n + 1] > 0.0 and p.states[which - 3 * m] != OPEN:
            k = which - 3 * m
            p.states[k] = BACKWARDS if p.impulses[2 * k + 1] > 0.0 else FORWARDS
    return True
