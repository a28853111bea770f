"""The differential equations of one phase, with the quantities that are integrated along.

The state vector of d degrees of freedom is y = [q (d), q' (d), quadratures (7)]; a scheme may put its own behind.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import accelerate, conjugate, stop_force
from oblique_impact.contact.state import FREE, Instant, Phase
from oblique_impact.kernels.jit import by_reference, jitable, kernel
from oblique_impact.kernels.workspace import Array, Workspace, dot


class Quadratures(NamedTuple):
    """Integrals over time of a run, or their rates."""

    normal_impulse: float  # N s, of the finite contact force
    tangential_impulse: float
    friction_loss: float  # J
    damping_loss: float  # J, by the system's own damping
    stabilization_loss: float  # J, by the constraint's stabilization and the scheme itself
    stop_loss: float  # J, by the damping of a compliant stop
    supplied: float  # J, by drives and moving boundaries


NORMAL_IMPULSE, TANGENTIAL_IMPULSE, FRICTION_LOSS, DAMPING_LOSS, STABILIZATION_LOSS, STOP_LOSS, SUPPLIED = range(7)
QUADRATURES = 7


@jitable
def boundary_power(phase: Phase, c: Instant, qd: Array, w: Workspace) -> float:
    """Power (W) of moving or driven boundaries: that of the contact force beyond the rates of gap and slip."""
    v = w.vectors
    closing, sliding = dot(v.normal_row, qd), dot(v.tangential_row, qd)
    taken = conjugate(phase, c) * c.gap_rate + c.tangential_force * c.slip_rate
    return c.normal_force * closing + c.tangential_force * sliding - taken


@jitable
def quadrature_rates(phase: Phase, c: Instant, qd: Array, w: Workspace) -> Quadratures:
    """Rates of the quadratures at an instant with its forces."""
    boundary = boundary_power(phase, c, qd, w) if phase.state != FREE else 0.0
    stabilization, stop = -c.normal_force * c.gap_rate, 0.0
    if phase.stop.compliant:
        # what the stop does not give back: all but the work of its force at rest
        stabilization, stop = (
            0.0,
            (conjugate(phase, c) - stop_force(phase.stop, phase.residual, c.gap, 0.0)) * -c.gap_rate,
        )
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
def derivative(system: Any, phase: Phase, t: float, y: Array, w: Workspace, dy: Array) -> tuple[int, Instant]:
    """Time derivative of y in `phase` into `dy`; returns the status and the solution of the contact problem."""
    d = w.vectors.forces.shape[0]
    q, qd = y[:d], y[d : 2 * d]
    status, c = accelerate(system, phase, t, q, qd, w)
    if status != 0:
        return status, c
    acceleration = w.vectors.acceleration
    for i in range(d):
        dy[i] = qd[i]
        dy[d + i] = acceleration[i]
    rates = quadrature_rates(phase, c, qd, w)
    for i in range(QUADRATURES):
        dy[2 * d + i] = rates[i]
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
