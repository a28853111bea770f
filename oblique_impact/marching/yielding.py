"""What yields behind the contact rows in a step of time-stepping: stops, modes left out, the axis.

Over a step of length h, with mean forces f = P/h on the rows (gap and slip of each contact), the body is displaced
by C s + F f with its residual flexibility C and axial flexibility F.  With the viscosity eta of the body its
forces s obey s + eta s' = f,

    a s1 + (1 - a) s0 = f,    a = max(1/2 + eta/h, 1)

the mid-point rule where the step resolves the relaxation, and else s1 = f.  Of the work f.(C (s1 - s0)) of a step
s.C s/2 is held, eta/h (s1 - s0).C (s1 - s0) is the damping's and the rest the scheme's.

An elastic stop is compressed by d, what is left of a negative gap.  With linear damping c and a stiffness k that
is higher by Hunt and Crossley's damping at the closing rate before the step, its mean force is

    f = k (b d1 + (1 - b) d0) + c (d1 - d0)/h,    0 <= f _|_ g1 + d1 >= 0

with b = 1/2, the mid-point rule, where the step resolves the vibration on the stop, h^2 W/(1/k + C) < 1 with the
inverse mass W behind it: then s of the body has a = 1/2 + eta/h as well.  Else b = 1.  The stop holds k d^2/2;
what else it takes is its damping's, or the scheme's where it has none.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.compliance import Compliance, across, across_by_shift, along, locate
from oblique_impact.contact.elastic import share_of
from oblique_impact.contact.state import Candidate, Contacts
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array

_NOTHING = 1e-30  # N: what has relaxed to less is zero, so that no step computes with subnormal numbers
_NONE = 1e300  # m/N, of a stop that is not there, or opens faster than its damping lets it follow
_RESOLVED = 1.0  # h^2 W/(1/k + C) of a vibration that a step resolves


class Yielding(NamedTuple):
    """Compliances behind the rows of n contacts in a step, with forces and displacements; 2 i is the gap of i."""

    body: Compliance | None
    elastic: bool  # whether the stops are
    viscosity: float  # s
    # of the stops in this step
    softness: Array  # (n,) m/N, d1 by f
    stiffness: Array  # (n,) N/m, at rest
    offset: Array  # (n,) m, -d1 at f = 0
    stored: Array  # (n,) J, at its start
    compressed: Array  # (n,) m, d0, then d1
    resolved: Array  # (1,) 1 as long as steps have resolved all vibrations on stops, else 0
    # of the body
    relaxed: Array  # (2 n,) N, s0
    after: Array  # (2 n,) N, s1
    applied: Array  # (2 n,) N, f of the step before
    displaced: Array  # (2 n,) m, at its start
    turned: Array  # (2 n,) m, over the step as C and F change with the places
    moved: Array  # (2 n,) m, over the step in all
    held: Array  # (1,) J, at its start

    @classmethod
    def new(cls, n: int, body: Compliance | None, elastic: bool) -> Yielding:
        """Return what yields behind n contacts, at rest."""
        softness, stiffness, offset, stored, compressed = np.zeros((5, n))
        rows = np.zeros((6, 2 * n))
        return cls(
            body,
            elastic,
            body.viscosity if body else 0.0,
            softness,
            stiffness,
            offset,
            stored,
            compressed,
            np.array([1.0 if elastic else 0.0]),
            rows[0],
            rows[1],
            rows[2],
            rows[3],
            rows[4],
            rows[5],
            np.zeros(1),
        )


@inlined
def weight_of_end(y: Yielding, h: float) -> float:
    """Return a, the weight of the end of a step of length h (s)."""
    return 0.5 + y.viscosity / h if y.resolved[0] != 0.0 else max(0.5 + y.viscosity / h, 1.0)


@jitable
def begin_yielding(y: Yielding, h: float, gaps: Array, contacts: Contacts) -> None:
    """Take stops and places of all contacts, which have been measured in the middle of a step, for all of it."""
    each = contacts.each
    _place(y.body, y, contacts)
    for i in range(len(each) if y.elastic else 0):
        c, d0 = each[i], 0.0
        if gaps[i] < np.inf:
            d0 = max(0.0, 0.5 * h * c.gap_rate - gaps[i] - y.displaced[2 * i])
        share = share_of(c.slip, c.first, c.last, c.cell)[0] if c.cell != 0.0 else 1.0
        y.stiffness[i], y.compressed[i] = c.stiffness * share, d0
        stiffness, damped = _stiffness(c, y.stiffness[i], _own(y.body, i)), c.linear_damping / h
        end = 0.5 if y.resolved[0] != 0.0 else 1.0
        whole = stiffness * end + damped
        y.softness[i] = 1.0 / whole if whole > 0.0 else _NONE
        y.offset[i] = -(stiffness * (1.0 - end) - damped) * d0 / whole if whole > 0.0 else 0.0


@jitable
def _stiffness(c: Candidate, stiffness: float, behind: float) -> float:
    """Stiffness (N/m) of a stop with its damping at the closing rate, of which the body takes its part at rest."""
    if not stiffness > 0.0:
        return 0.0
    own = 1.0 / stiffness
    return max(0.0, stiffness * (1.0 - c.damping * c.gap_rate * own / (own + behind)))


@jitable
def look_at_vibration(y: Yielding, h: float, i: int, inverse_mass: float) -> None:
    """Take note if a step does not resolve the vibration of contact i, with the inverse mass (1/kg) behind it."""
    if y.stiffness[i] > 0.0:
        compliance = 1.0 / y.stiffness[i] + _own(y.body, i)
        if h * h * inverse_mass > _RESOLVED * compliance:
            y.resolved[0] = 0.0


@jitable
def _own(body: Compliance | None, i: int) -> float:
    """Compliance (m/N) of the body at contact i, along its normal; the compiler drops this of none."""
    return 0.0 if body is None else across(body, i, 0, i, 0)


@jitable
def _place(body: Compliance | None, y: Yielding, contacts: Contacts) -> None:
    """Take places and directions of all contacts and what the forces of the last step displace there."""
    if body is None:
        return
    n = len(contacts.each)
    for i in range(n):
        locate(body, i, contacts.each[i].shift)
    _displace(body, y.relaxed, y.applied, y.turned)
    for k in range(2 * n):
        y.turned[k] -= y.displaced[k]


@jitable
def _displace(body: Compliance, relaxed: Array, applied: Array, displaced: Array) -> None:
    """Displacements (2 n,) of the rows (m) by forces (2 n,) on the residual and on the axial flexibility (N)."""
    for k in range(displaced.shape[0]):
        displaced[k] = 0.0
    n = displaced.shape[0] // 2
    for j in range(n):
        for b in range(2):
            if relaxed[2 * j + b] == 0.0 and applied[2 * j + b] == 0.0:
                continue
            for i in range(n):
                displaced[2 * i] += across(body, i, 0, j, b) * relaxed[2 * j + b]
                displaced[2 * i + 1] += across(body, i, 1, j, b) * relaxed[2 * j + b]
                if b == 1:
                    displaced[2 * i + 1] += along(body, i, j) * applied[2 * j + b]


@jitable
def yielding_between(y: Yielding, h: float, i: int, a: int, j: int, b: int) -> float:
    """Return gap (a = 0) or slip (1) of i at the end of a step by a unit impulse on gap or slip of j (m/N s)."""
    moved = _by_body(y.body, y, h, i, a, j, b)
    if a == 0 and b == 0 and i == j:
        moved += y.softness[i]
    return moved / h


@jitable
def _by_body(body: Compliance | None, y: Yielding, h: float, i: int, a: int, j: int, b: int) -> float:
    """Displacement of the rows by a mean unit force (m/N); the compiler drops this of a rigid body."""
    if body is None:
        return 0.0
    found = across(body, i, a, j, b) / weight_of_end(y, h)
    return found + along(body, i, j) if a == 1 and b == 1 else found


@inlined
def yielded(y: Yielding, i: int, a: int, force: float) -> float:
    """Return what yields (m) at the gap (a = 0) or slip (1) of contact i up to the end of a step.

    That is what a mean normal force (N) compresses, and the body's part as the present impulses push it.
    """
    if a == 1:
        return float(y.moved[2 * i + 1])
    softened = y.softness[i] * force if force != 0.0 else 0.0
    return float(y.displaced[2 * i] + y.moved[2 * i] + y.offset[i] + softened)


@jitable
def push_body(y: Yielding, h: float, impulses: Array, closed: NDArray[np.int64], m: int) -> None:
    """Take the displacements over a step with the impulses (2 m,), N s, of the m `closed` contacts."""
    _push_body(y.body, y, h, impulses, closed, m)


@jitable
def _push_body(
    body: Compliance | None, y: Yielding, h: float, impulses: Array, closed: NDArray[np.int64], m: int
) -> None:
    if body is None:
        return
    a, n = weight_of_end(y, h), y.relaxed.shape[0]
    for k in range(n):
        y.after[k], y.moved[k] = (a - 1.0) / a * y.relaxed[k], y.turned[k]
    for k in range(2 * m):
        row = 2 * closed[k // 2] + k % 2
        y.after[row] += impulses[k] / (a * h)
    for j in range(n):
        change, pulled = y.after[j] - y.relaxed[j], -y.applied[j]
        for k in range(2 * m):
            if 2 * closed[k // 2] + k % 2 == j:
                pulled += impulses[k] / h
        if change == 0.0 and pulled == 0.0:
            continue
        for i in range(n):
            y.moved[i] += across(body, i // 2, i % 2, j // 2, j % 2) * change
            if i % 2 == 1 and j % 2 == 1:
                y.moved[i] += along(body, i // 2, j // 2) * pulled


@jitable
def shift_forces(
    y: Yielding, h: float, impulses: Array, closed: NDArray[np.int64], m: int, contacts: Contacts
) -> None:
    """Take the forces on shifts and slips of the `closed` contacts by the change of compliances."""
    for k in range(m):
        c = contacts.each[closed[k]]
        c.shift_force, c.end_force = 0.0, 0.0
        if y.elastic and c.cell != 0.0:
            compressed = y.compressed[closed[k]]
            fading = share_of(c.slip, c.first, c.last, c.cell)[1]
            c.end_force = -0.5 * c.stiffness * fading * compressed * compressed
    _shift_forces(y.body, h, impulses, closed, m, contacts)


@jitable
def _shift_forces(
    body: Compliance | None, h: float, impulses: Array, closed: NDArray[np.int64], m: int, contacts: Contacts
) -> None:
    if body is None:
        return
    for k in range(2 * m):
        i, total = closed[k // 2], 0.0
        for j in range(2 * m if impulses[k] != 0.0 else 0):
            total += impulses[j] * across_by_shift(body, i, k % 2, closed[j // 2], j % 2)
        contacts.each[i].shift_force += impulses[k] * total / (h * h)


@jitable
def compress(y: Yielding, i: int, gap: float) -> float:
    """Take the gap (m) that is left to a stop at the end of a step; returns the energy (J) that it gains."""
    before = y.stored[i]
    y.compressed[i] = max(0.0, -gap)
    y.stored[i] = 0.5 * y.stiffness[i] * y.compressed[i] * y.compressed[i]
    return float(y.stored[i] - before)


@jitable
def end_yielding(y: Yielding, h: float, impulses: Array, closed: NDArray[np.int64], m: int) -> tuple[float, float]:
    """Begin the next step; returns the energies (J) that the body's damping and the scheme took in this one."""
    return _end_yielding(y.body, y, h, impulses, closed, m)


@jitable
def _end_yielding(
    body: Compliance | None, y: Yielding, h: float, impulses: Array, closed: NDArray[np.int64], m: int
) -> tuple[float, float]:
    if body is None:
        return 0.0, 0.0
    n, given, held, change = y.relaxed.shape[0], 0.0, 0.0, 0.0
    for k in range(n):
        y.applied[k] = 0.0
    for k in range(2 * m):
        row = 2 * closed[k // 2] + k % 2
        y.applied[row] = impulses[k] / h
        given += y.applied[row] * y.moved[row]
    for j in range(n):
        more = y.after[j] - y.relaxed[j]
        for i in range(n if more != 0.0 else 0):
            change += (y.after[i] - y.relaxed[i]) * across(body, i // 2, i % 2, j // 2, j % 2) * more
    for k in range(n):
        y.relaxed[k] = y.after[k] if abs(y.after[k]) > _NOTHING else 0.0
    _displace(body, y.relaxed, y.applied, y.displaced)
    for k in range(n):
        # the residual flexibility holds s.C s/2, the axis f.F f/2
        held += 0.5 * y.relaxed[k] * y.displaced[k]
    for i in range(n // 2):
        lag = y.applied[2 * i + 1] - y.relaxed[2 * i + 1]
        for j in range(n // 2 if lag != 0.0 else 0):
            held += 0.5 * lag * along(body, i, j) * y.applied[2 * j + 1]
    gained = held - y.held[0]
    y.held[0] = held
    damping = y.viscosity / h * change
    return damping, given - damping - gained
