"""Contacts that the ordinary rules leave undecided, each by its name.

Grazing             a gap that closes without speed: there is nothing that an impulse could take
Accumulated bounces  infinitely many in a finite time (Zeno), too short to resolve: contact stays closed
Alternating impacts  of several contacts, each opened by the impact of another: all close
Parallel rows       the tangential row of a contact adds nothing to the normal one: no force holds its slip
Redundant constraints  of several contacts: their forces are not determined
Painleve            the force of a sliding contact grows without bound
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from oblique_impact.contact.forces import friction_ratio
from oblique_impact.contact.state import Candidate, Tolerances
from oblique_impact.errors import Outcome
from oblique_impact.kernels.workspace import Array

#: of the time scale: impacts that alternate between contacts in quicker succession have accumulated, and close
#: all.  Each comes after about a fifth of the time before, so that the rest of them takes less than this
ALTERNATING = 1e-7
#: of the largest, an eigenvalue of the scaled Delassus matrix that is rounding: as the pivots of the constraints
_REDUNDANT = 1e-11
#: squared sine between the contact rows (in the metric of the inverse mass matrix) below which they count as
#: parallel: a stick force of such rows would be larger than any friction cone, and known to no digit
_PARALLEL = 1e-11
#: a tangential row whose square is below 1e-11 times this part of the normal one's is rounding (1e-24 of 1,024
#: elements that lie along the slope)
_NO_ROW = 1e-9


def grazes(c: Candidate, tolerances: Tolerances) -> bool:
    """Whether a gap closes without speed, or opens again a thousandth of its tolerance below 0 or before.

    A point that moves along the slope at the bottom of its circle has no lever arm that an impulse could use.
    """
    depth = 2e-3 * tolerances.gap * c.gap_acceleration
    return c.gap_rate >= -tolerances.velocity or c.gap_rate**2 <= depth


def bounces_accumulate(after: Candidate, tolerances: Tolerances, located: bool) -> bool:
    """Whether the bounces after an impact accumulate at once: a Zeno sequence too short to resolve.

    With a gap acceleration -a the bounces rise by v^2 / (2 a), e^2 as high each time.  One that does not rise
    above the slope, below which a scheme that does not locate impacts has found it, is no bounce either.
    """
    if after.gap_acceleration >= 0.0:
        return False
    flight = 2.0 * after.gap_rate / -after.gap_acceleration
    height = 0.25 * flight * after.gap_rate
    lowest = 4.0 * tolerances.gap if located else max(4.0 * tolerances.gap, -after.gap)
    return height < lowest or flight < tolerances.flight


def close_all(normal: Array, rates: Array) -> Array:
    """Return impulses (n,), N s, that close all contacts whose impacts alternate, whatever is left of their rates.

    `normal` (n, n) is the Delassus matrix (1/kg) of the normals, `rates` (n,) are the gap rates before (m/s).
    """
    return np.asarray(np.linalg.solve(normal, -rates))


def rows_are_parallel(c: Candidate) -> bool:
    """Whether the tangential row of a rigid contact adds nothing to the normal one, but for rounding."""
    determinant = c.a_nn * c.a_tt - c.a_nt * c.a_nt
    return not c.compliant and determinant <= _PARALLEL * c.a_nn * (c.a_tt + _NO_ROW * c.a_nn)


def turning_rate(c: Candidate, later: float) -> float:
    """Slip velocity (m/s) a little `later`, or slip acceleration (m/s^2) where that is not known; for its sign.

    The rows of a straight beam at rest are parallel.  No tangential force can hold such a contact, nor move it:
    its slip turns as the motion along the slope dictates, whatever the friction.  Its tip has no acceleration
    along the slope but for rounding: it slips as the beam shortens by bending, with the third power of time.
    """
    if c.compliant:
        return c.slip_rate or later
    return later or c.slip_acceleration - c.a_nt * c.gap_acceleration / c.a_nn


def is_redundant(delassus: Array) -> bool:
    """Whether a symmetric Delassus matrix is singular but for rounding, its rows scaled to each other."""
    scale = np.sqrt(np.maximum(np.diag(delassus), 0.0))
    if np.min(scale) <= 0.0:
        return True
    values = np.linalg.eigvalsh(delassus / np.outer(scale, scale))
    return bool(values[0] <= _REDUNDANT * values[-1])


def unbounded_forces(group: Sequence[Candidate], normal: Array) -> Outcome:
    """Name why the forces of sliding contacts grow without bound: friction, or redundant constraints.

    `normal` (n, n) is the Delassus matrix of their normals.
    """
    rubs = any(friction_ratio(c) != 0.0 for c in group)
    return Outcome.PAINLEVE if rubs and not is_redundant(normal) else Outcome.REDUNDANT_CONSTRAINTS
