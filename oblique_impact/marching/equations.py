"""The differential equations of one phase, with the quantities that are integrated along.

The state vector of d degrees of freedom is y = [q (d), q' (d), quadratures (3), those of each contact (5)]; a
scheme may put its own behind.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from oblique_impact.contact.forces import accelerate, lambda_n
from oblique_impact.contact.state import DIRECTION, FREE, Candidate, Contacts
from oblique_impact.kernels.jit import by_reference, inlined, jitable
from oblique_impact.kernels.workspace import ACCELERATION, Array, Workspace, dot

# integrals over time of a run: losses (J) by the system's own damping, by the constraints' stabilization and the
# scheme itself; energy (J) supplied by drives, moving boundaries and a shaken base
DAMPING_LOSS, STABILIZATION_LOSS, SUPPLIED = range(3)
QUADRATURES = 3
# and of each contact, behind them: impulses (N s) of its finite forces; losses (J) by friction, and by the damping
# of a compliant stop and where the beam slides off it; its travel (m) while it is closed
NORMAL_IMPULSE, TANGENTIAL_IMPULSE, FRICTION_LOSS, STOP_LOSS, TRAVEL = range(5)
OF_A_CONTACT = 5


def of_all_contacts(quadratures: Array, which: int) -> Array:
    """Return the sums over all contacts of one of their integrals, of quadratures (..., 3 + 5 n)."""
    return np.asarray(quadratures[..., QUADRATURES + which :: OF_A_CONTACT].sum(axis=-1))


@jitable
def boundary_power(c: Candidate, qd: Array, normal_row: Array, tangential_row: Array) -> float:
    """Power (W) of moving or driven boundaries: that of the contact force beyond the rates of gap and slip."""
    closing, sliding = dot(normal_row, qd), dot(tangential_row, qd)
    constrained = c.normal_force * (closing - c.gap_rate) + c.tangential_force * (sliding - c.slip_rate)
    return constrained + c.boundary_power


@jitable
def contact_losses(c: Candidate) -> tuple[float, float]:
    """Power (W) that the stabilization of a constraint and the damping of a stop take out."""
    if c.compliant:
        # what the stop does not give back: all but the work of its force at rest
        return 0.0, (c.normal_force - c.rest_force) * -c.gap_rate
    return -c.normal_force * c.gap_rate, 0.0


@inlined
def rates_into(contacts: Contacts, damping: float, supplied: float, qd: Array, rates: Array) -> None:
    """Put the rates of the quadratures into `rates`: of contacts, and the powers (W) of damping and drives."""
    each, rows = contacts.each, contacts.rows
    for k in range(rates.shape[0]):
        rates[k] = 0.0
    rates[DAMPING_LOSS], rates[SUPPLIED] = damping, supplied
    for i in range(len(each)):
        c, own = each[i], QUADRATURES + OF_A_CONTACT * i
        if c.state == FREE:
            continue
        stabilization, stop = contact_losses(c)
        rates[STABILIZATION_LOSS] += stabilization
        rates[SUPPLIED] += boundary_power(c, qd, rows[DIRECTION, i, 0], rows[DIRECTION, i, 1])
        rates[own + NORMAL_IMPULSE], rates[own + TANGENTIAL_IMPULSE] = lambda_n(c), c.tangential_force
        rates[own + FRICTION_LOSS], rates[own + STOP_LOSS] = -c.tangential_force * c.slip_rate, stop
        rates[own + TRAVEL] = c.slip_rate


@inlined
def take_travel(contacts: Contacts, y: Array, d: int) -> None:
    """Take the travel of the contacts from the state vector of d degrees of freedom."""
    for i in range(len(contacts.each)):
        contacts.each[i].travel = y[2 * d + QUADRATURES + OF_A_CONTACT * i + TRAVEL]


@jitable
def derivative(system: Any, contacts: Contacts, t: float, y: Array, w: Workspace, dy: Array) -> int:
    """Time derivative of y into `dy`, with the contacts in their states; returns the status."""
    d, y, dy = w.vectors.shape[1], by_reference(y), by_reference(dy)
    q, qd = y[:d], y[d : 2 * d]
    take_travel(contacts, y, d)
    status, damping, supplied = accelerate(system, contacts, t, q, qd, w)
    if status != 0:
        return status
    acceleration = w.vectors[ACCELERATION]
    for i in range(d):
        dy[i] = qd[i]
        dy[d + i] = acceleration[i]
    rates_into(
        contacts, damping, supplied, qd, dy[2 * d : 2 * d + QUADRATURES + OF_A_CONTACT * len(contacts.each)]
    )
    return status
