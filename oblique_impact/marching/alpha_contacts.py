"""Several elastic contacts in a step of generalized-alpha.

The forces of all closed contacts follow in every iteration from one system of equations, two for each: the law of
its stop, and friction or, where it sticks, a slip velocity of zero.  The equations of one contact are in
:mod:`~oblique_impact.marching.alpha_step`.
"""

from __future__ import annotations

from typing import Any

from oblique_impact.contact.forces import (
    NO_STICKING_SOLUTION,
    OK,
    axial_force,
    drift_of,
    friction_ratio,
    stop_force,
    stop_tangent,
)
from oblique_impact.contact.several import (
    instant_at,
    phase_of,
    push_at_end,
    shared_flexibility,
    touch_contacts,
)
from oblique_impact.contact.state import (
    A_NN,
    A_NT,
    A_TT,
    COMPLIANCE,
    FREE,
    NORMAL_FORCE,
    SLIDING,
    SLIP_RATE,
    STATE,
    STICKING,
    TANGENTIAL_FORCE,
    ContactArrays,
    Instant,
    Phase,
)
from oblique_impact.kernels.dense import eliminate
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array, Evaluation, Workspace, copy, dot
from oblique_impact.marching.alpha_state import StepLength


@jitable
def touch_all(
    arrays: ContactArrays,
    system: Any,
    phase: Phase,
    t: float,
    q: Array,
    qd: Array,
    w: Workspace,
    e: Evaluation,
) -> Instant:
    """Kinematics of all contacts; returns the smallest distance in flight and the sum of the normal forces."""
    least, fastest = touch_contacts(arrays, system, phase, t, q, qd, w)
    normal = 0.0
    for i in range(arrays.rows.shape[0]):
        normal += arrays.instants[i, NORMAL_FORCE]
    powers = e.damping_power, e.supplied_power
    return Instant(least, 0.0, fastest, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, normal, 0.0, powers[0], powers[1])


@jitable
def add_forces(arrays: ContactArrays, phase: Phase, residual: Array) -> None:
    """Add the contact forces, and those at the ends of beddings, to the residual."""
    for i in range(arrays.rows.shape[0]):
        if arrays.rows[i, STATE] != FREE:
            normal, tangential = arrays.instants[i, NORMAL_FORCE], arrays.instants[i, TANGENTIAL_FORCE]
            tangential += push_at_end(arrays, phase, i)
            for k in range(residual.shape[0]):
                residual[k] += normal * arrays.directions[i, 0, k] + tangential * arrays.directions[i, 1, k]


@jitable
def solve_coupled(
    arrays: ContactArrays, system: Any, phase: Phase, rank_one: float, slot: int, step: StepLength, w: Workspace
) -> int:
    """Solve for the increment of an iteration with the forces of all closed contacts; returns the status."""
    v, closed = w.vectors, 0
    for i in range(arrays.rows.shape[0]):
        if arrays.rows[i, STATE] == FREE:
            continue
        copy(arrays.directions[i, 0], v.normal_row)
        copy(arrays.directions[i, 1], v.tangential_row)
        system.solve_effective(rank_one, w, slot, True)
        copy(v.normal_response, arrays.responses[i, 0])
        copy(v.tangential_response, arrays.responses[i, 1])
        c = arrays.instants[i]
        c[A_NN] = dot(v.normal_row, v.normal_response)
        c[A_NT] = dot(v.normal_row, v.tangential_response)
        c[A_TT] = dot(v.tangential_row, v.tangential_response)
        arrays.unknowns[2 * closed, 0], arrays.unknowns[2 * closed + 1, 0] = i, i
        closed += 1
    if closed == 0:
        system.solve_effective(rank_one, w, slot, False)
        return OK
    for k in range(closed):
        _take_equations(arrays, phase, k, closed, v.increment, step)
    if not eliminate(arrays.matrix, 2 * closed):
        return NO_STICKING_SOLUTION
    for k in range(2 * closed):
        i, which, more = int(arrays.unknowns[k, 0]), k % 2, arrays.matrix[k, 2 * closed]
        arrays.instants[i, NORMAL_FORCE + which] += more
        for j in range(v.increment.shape[0]):
            v.increment[j] += more * arrays.responses[i, which, j]
            v.residual[j] += more * arrays.directions[i, which, j]
    return OK


@jitable
def _take_equations(
    arrays: ContactArrays, phase: Phase, k: int, closed: int, increment: Array, step: StepLength
) -> None:
    """Put the two equations of the closed contact number k for the changes of all forces into the matrix."""
    matrix, last, velocity = arrays.matrix, 2 * closed, step.velocity
    i = int(arrays.unknowns[2 * k, 0])
    p, c = phase_of(phase, arrays, i), instant_at(arrays, i)
    over_depth, over_rate = stop_tangent(p.stop, p.residual, c.gap, c.gap_rate)
    stiff, ratio, viscous = over_depth * step.position + over_rate * velocity, 0.0, velocity
    if p.state == SLIDING:
        ratio = friction_ratio(p, c.slip_rate)
        viscous = -p.friction.slope * c.normal_force * velocity
    axial = p.state == STICKING and p.stick.compliance != 0.0
    if axial:
        viscous = 0.5 * step.h * velocity / p.stick.compliance
    for column in range(last):
        j, which = int(arrays.unknowns[column, 0]), column % 2
        matrix[2 * k, column] = stiff * dot(arrays.directions[i, 0], arrays.responses[j, which])
        matrix[2 * k + 1, column] = viscous * dot(arrays.directions[i, 1], arrays.responses[j, which])
        if axial and which == 1:
            matrix[2 * k + 1, column] += _shared_part(arrays, i, j)
    normal, tangential = dot(arrays.directions[i, 0], increment), dot(arrays.directions[i, 1], increment)
    force = stop_force(p.stop, p.residual, c.gap, c.gap_rate)
    matrix[2 * k, 2 * k] += 1.0
    matrix[2 * k, last] = force - c.normal_force - stiff * normal
    if p.state == SLIDING:
        matrix[2 * k + 1, 2 * k] -= ratio
        matrix[2 * k + 1, 2 * k + 1] += 1.0
        matrix[2 * k + 1, last] = ratio * c.normal_force - c.tangential_force - viscous * tangential
    elif axial:
        # the travel at the end of the step by the trapezoidal rule; its start is in `travel`
        held = axial_force(p.stick, arrays.travel[i] + 0.5 * step.h * c.slip_rate)
        for j in range(arrays.rows.shape[0]):
            held -= _shared_part(arrays, i, j) * arrays.instants[j, TANGENTIAL_FORCE]
        matrix[2 * k + 1, last] = held - viscous * tangential
    else:
        matrix[2 * k + 1, last] = -c.slip_rate - velocity * tangential


@jitable
def _shared_part(arrays: ContactArrays, i: int, j: int) -> float:
    """Axial flexibility between two contacts over that of the first."""
    return float(shared_flexibility(arrays.rows[i], arrays.rows[j]) / arrays.rows[i, COMPLIANCE])


@jitable
def project_sticking(arrays: ContactArrays, system: Any, phase: Phase, t: float, w: Workspace, y: Array) -> float:
    """Move q, then q', so that contacts that stick keep their slip, along the responses of the step; work (J)."""
    d, forces, done = w.vectors.forces.shape[0], w.vectors.forces, 0.0
    sticking = 0
    for i in range(arrays.rows.shape[0]):
        if arrays.rows[i, STATE] == STICKING and arrays.rows[i, COMPLIANCE] == 0.0:
            arrays.unknowns[sticking, 0] = i
            sticking += 1
    if sticking == 0:
        return 0.0
    for level in range(2):
        if level == 1:
            touch_contacts(arrays, system, phase, t, y[:d], y[d : 2 * d], w)
        for k in range(sticking):
            i = int(arrays.unknowns[k, 0])
            for column in range(sticking):
                other = int(arrays.unknowns[column, 0])
                arrays.matrix[k, column] = dot(arrays.directions[i, 1], arrays.responses[other, 1])
            drift = drift_of(phase_of(phase, arrays, i).stick, instant_at(arrays, i))
            arrays.matrix[k, sticking] = -(drift if level == 0 else arrays.instants[i, SLIP_RATE])
        if not eliminate(arrays.matrix, sticking):
            return done
        for k in range(sticking):
            i = int(arrays.unknowns[k, 0])
            for j in range(d):
                move = arrays.matrix[k, sticking] * arrays.responses[i, 1, j]
                y[level * d + j] += move
                done += (1.0 - level) * forces[j] * move
    return done
