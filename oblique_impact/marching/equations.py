"""The differential equations of one phase, with the quantities that are integrated along.

The state vector of d degrees of freedom is y = [q (d), q' (d), quadratures (7)]; a scheme may put its own behind.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import conjugate, end_push, stop_force
from oblique_impact.contact.several import instant_at, phase_of, solve_contacts
from oblique_impact.contact.state import FREE, ContactArrays, Instant, Phase
from oblique_impact.kernels.jit import by_reference, jitable, kernel
from oblique_impact.kernels.workspace import Array, Workspace, dot


class Quadratures(NamedTuple):
    """Integrals over time of a run, or their rates."""

    normal_impulse: float  # N s, of the finite contact force
    tangential_impulse: float
    friction_loss: float  # J
    damping_loss: float  # J, by the system's own damping
    stabilization_loss: float  # J, by the constraint's stabilization and the scheme itself
    stop_loss: float  # J, by the damping of a compliant stop, and where the beam slides off it
    supplied: float  # J, by drives, moving boundaries and a shaken base


NORMAL_IMPULSE, TANGENTIAL_IMPULSE, FRICTION_LOSS, DAMPING_LOSS, STABILIZATION_LOSS, STOP_LOSS, SUPPLIED = range(7)
QUADRATURES = 7


#: of each of several contacts, behind the quadratures of the run: impulses (N s), losses by friction and stop (J),
#: and its travel (m) while it is closed
OF_A_CONTACT, TRAVEL = 5, 4


@jitable
def boundary_power(phase: Phase, c: Instant, qd: Array, normal_row: Array, tangential_row: Array) -> float:
    """Power (W) of moving or driven boundaries: that of the contact force beyond the rates of gap and slip."""
    closing, sliding = dot(normal_row, qd), dot(tangential_row, qd)
    taken = conjugate(phase, c) * c.gap_rate + c.tangential_force * c.slip_rate
    pushed = end_push(phase.stop, c.gap) * (sliding - c.slip_rate)
    return c.normal_force * closing + c.tangential_force * sliding - taken + pushed


@jitable
def quadrature_rates(phase: Phase, c: Instant, qd: Array, w: Workspace) -> Quadratures:
    """Rates of the quadratures at an instant with its forces."""
    v, boundary = w.vectors, 0.0
    if phase.state != FREE:
        boundary = boundary_power(phase, c, qd, v.normal_row, v.tangential_row)
    stabilization, stop = contact_losses(phase, c)
    return Quadratures(
        c.normal_force,
        c.tangential_force,
        -c.tangential_force * c.slip_rate,
        c.damping_power,
        stabilization,
        stop,
        c.supplied_power + boundary,
    )


@jitable
def contact_losses(phase: Phase, c: Instant) -> tuple[float, float]:
    """Power (W) that the stabilization of a constraint and the damping of a stop take out."""
    if phase.stop.compliant:
        # what the stop does not give back: all but the work of its force at rest
        at_rest = stop_force(phase.stop, phase.residual, c.gap, 0.0)
        return 0.0, (conjugate(phase, c) - at_rest) * -c.gap_rate
    return -c.normal_force * c.gap_rate, 0.0


@jitable
def rates_into(
    arrays: ContactArrays | None, phase: Phase, c: Instant, qd: Array, w: Workspace, rates: Array
) -> None:
    """Put the rates of the quadratures into `rates`; the compiler drops one of the two branches."""
    if arrays is None:
        found = quadrature_rates(phase, c, qd, w)
        for i in range(QUADRATURES):
            rates[i] = found[i]
    else:
        _rates_of_each(arrays, phase, c, qd, rates)


@jitable
def _rates_of_each(arrays: ContactArrays, phase: Phase, c: Instant, qd: Array, rates: Array) -> None:
    for k in range(rates.shape[0]):
        rates[k] = 0.0
    rates[DAMPING_LOSS], rates[SUPPLIED] = c.damping_power, c.supplied_power
    for i in range(arrays.rows.shape[0]):
        p = phase_of(phase, arrays, i)
        if p.state == FREE:
            continue
        at, own = instant_at(arrays, i), QUADRATURES + OF_A_CONTACT * i
        friction = -at.tangential_force * at.slip_rate
        stabilization, stop = contact_losses(p, at)
        rates[NORMAL_IMPULSE] += at.normal_force
        rates[TANGENTIAL_IMPULSE] += at.tangential_force
        rates[FRICTION_LOSS] += friction
        rates[STABILIZATION_LOSS] += stabilization
        rates[STOP_LOSS] += stop
        rates[SUPPLIED] += boundary_power(p, at, qd, arrays.directions[i, 0], arrays.directions[i, 1])
        rates[own], rates[own + 1] = at.normal_force, at.tangential_force
        rates[own + 2], rates[own + 3] = friction, stop
        rates[own + TRAVEL] = at.slip_rate


@jitable
def take_travel(arrays: ContactArrays | None, y: Array, d: int) -> None:
    """Take the travel of several contacts from the state vector of d degrees of freedom."""
    if arrays is not None:
        for i in range(arrays.travel.shape[0]):
            arrays.travel[i] = y[2 * d + QUADRATURES + OF_A_CONTACT * i + TRAVEL]


@jitable
def derivative(system: Any, phase: Phase, t: float, y: Array, w: Workspace, dy: Array) -> tuple[int, Instant]:
    """Time derivative of y in `phase` into `dy`; returns the status and the solution of the contact problem."""
    d = w.vectors.forces.shape[0]
    q, qd = y[:d], y[d : 2 * d]
    take_travel(phase.arrays, y, d)
    status, c = solve_contacts(phase.arrays, system, phase, t, q, qd, w)
    if status != 0:
        return status, c
    acceleration = w.vectors.acceleration
    for i in range(d):
        dy[i] = qd[i]
        dy[d + i] = acceleration[i]
    rates_into(phase.arrays, phase, c, qd, w, dy[2 * d :])
    return status, c


@kernel("the equations")
def _derivative_into(
    system: Any, phase: Phase, t: float, y: Array, w: Workspace, dy: Array, instant: Array
) -> int:
    system, phase, w = by_reference(system), by_reference(phase), by_reference(w)
    status, c = derivative(system, phase, t, y, w, dy)
    for i in range(instant.shape[0]):
        instant[i] = c[i]
    return status


def take_derivative(system: Any, phase: Phase, t: float, y: Array, w: Workspace, dy: Array) -> tuple[int, Instant]:
    """Call :func:`derivative` from Python."""
    found = np.empty(len(Instant._fields))
    status = _derivative_into(system, phase, t, y, w, dy, found)
    return status, Instant(*found.tolist())
