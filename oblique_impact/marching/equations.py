"""The differential equations of one phase, with the quantities that are integrated along.

The state vector of d degrees of freedom is y = [q (d), q' (d), quadratures (7)].
"""

from __future__ import annotations

from typing import Any

from oblique_impact.contact.forces import FREE, Phase, accelerate, stop_force
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.system import (
    ACCELERATION,
    DAMPING_POWER,
    GAP,
    GAP_RATE,
    LAMBDA_N,
    LAMBDA_T,
    NORMAL_ROW,
    SLIP_RATE,
    TANGENT_ROW,
    Array,
    Work,
    supplied_power,
)

# Quadratures: impulses of the contact force (N s), energy lost to friction, damping of the system, constraint
# stabilization and damping of the stop, energy supplied by drives (J)
NORMAL_IMPULSE, TANGENTIAL_IMPULSE, FRICTION_LOSS, DAMPING_LOSS, STABILIZATION_LOSS, STOP_LOSS, SUPPLIED = range(7)
QUADRATURES = 7


@jitable
def copy(source: Array, target: Array) -> None:
    """Copy one vector (an assignment of slices compiles to far more code)."""
    for i in range(source.shape[0]):
        target[i] = source[i]


@jitable
def quadrature_rates(system: Any, phase: Phase, t: float, q: Array, qd: Array, work: Work, rates: Array) -> None:
    """Rates of the quadratures at an evaluated instant whose forces and acceleration are in `work`."""
    v, k = work.vectors, work.scalars
    normal, tangential = k[LAMBDA_N], k[LAMBDA_T]
    boundary = 0.0
    if phase.state != FREE:
        # What moving or driven boundaries add: contact power on the coordinates beyond that of gap and slip
        closing, sliding = 0.0, 0.0
        for i in range(q.shape[0]):
            closing += v[NORMAL_ROW, i] * qd[i]
            sliding += v[TANGENT_ROW, i] * qd[i]
        boundary = normal * (closing - k[GAP_RATE]) + tangential * (sliding - k[SLIP_RATE])
    rates[NORMAL_IMPULSE] = normal
    rates[TANGENTIAL_IMPULSE] = tangential
    rates[FRICTION_LOSS] = -tangential * k[SLIP_RATE]
    rates[DAMPING_LOSS] = k[DAMPING_POWER]
    rates[STABILIZATION_LOSS], rates[STOP_LOSS] = 0.0, 0.0
    if phase.spring > 0.0:
        # what the stop does not give back: all but the work of its force at rest
        rates[STOP_LOSS] = (normal - stop_force(phase, k[GAP], 0.0)) * -k[GAP_RATE]
    else:
        rates[STABILIZATION_LOSS] = -normal * k[GAP_RATE]
    rates[SUPPLIED] = supplied_power(system, t, q, qd, work) + boundary


@jitable
def derivative(system: Any, phase: Phase, t: float, y: Array, work: Work, dy: Array) -> int:
    """Time derivative of y in `phase` into `dy`; returns the status of the contact problem."""
    d = work.vectors.shape[1]
    q, qd = y[:d], y[d : 2 * d]
    status = accelerate(system, phase, t, q, qd, work)
    if status != 0:
        return status
    for i in range(d):
        dy[i] = qd[i]
        dy[d + i] = work.vectors[ACCELERATION, i]
    quadrature_rates(system, phase, t, q, qd, work, dy[2 * d :])
    return status
