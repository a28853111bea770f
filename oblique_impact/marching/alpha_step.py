"""One step of generalized-alpha, with the contact forces from the Schur complement of the effective matrix.

Each iteration solves with the constant effective matrix.  A rigid contact is held on the velocity, Z' = 0 (index
2), which keeps the forces well conditioned in the shortest of steps, and then projected onto Z = 0
(:mod:`~oblique_impact.marching.alpha_balance`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from oblique_impact.contact.forces import (
    MASS_NOT_POSITIVE,
    NO_SLIDING_SOLUTION,
    NO_STICKING_SOLUTION,
    OK,
    axial_force,
    can_slide,
    conjugate,
    friction_ratio,
    moved,
    stop_force,
    stop_tangent,
    with_forces,
)
from oblique_impact.contact.several import contact_at, contact_count, contact_phase, keep_forces
from oblique_impact.contact.state import FREE, NO_CONTACT, SLIDING, STICKING, ContactArrays, Instant, Phase
from oblique_impact.kernels.jit import by_reference, jitable
from oblique_impact.kernels.workspace import Array, Workspace, dot
from oblique_impact.marching.advance import FAILED_ITERATION, UNBOUNDED
from oblique_impact.marching.alpha_contacts import add_forces, solve_coupled, touch_all
from oblique_impact.marching.alpha_state import (
    Attempt,
    StepLength,
    algorithm_state,
    begin_travel,
    is_backward_euler,
    step_length,
)

NOT_CONVERGED = -FAILED_ITERATION

# effective matrices of the step in flight, of the step in and near contact, of a step of another length
FLIGHT_STEP, CONTACT_STEP, CUT_STEP = 0, 1, 2

_MOST_ITERATIONS = 60  # a few are usual: a step that needs more is given up
_CLOSED = 10.0  # tolerances of velocity: the error of the velocity in a contact that counts as zero
#: a contraction is measured anew only now and then: until then it is taken to be 5 % worse with every step
_FADING = 1.05
#: iterations have stalled if a residual stays above this part of the one before; corrections of up to so many
#: tolerances are then taken for rounding
_STALLED, _ROUNDING = 0.25, 1e4
_ALIKE = 2.0  # residuals by rounding differ by less than this factor from step to step
#: a residual that in so many iterations has not fallen below this part of its least is rounding, and so may be a
#: larger correction: some 2e4 tolerances of 4,096 elements, growing as the square of their number.  It takes more
#: iterations to tell, because one that converges slowly looks the same at first.
_FLAT, _FLAT_ITERATIONS, _FLAT_ROUNDING = 0.7, 3, 1e6


class StepSolution(NamedTuple):
    """Result of a step of the scheme besides the new state vector."""

    status: int  # OK, the reason why there is no solution, or NOT_CONVERGED
    end: Instant  # the contact at its end, with its forces
    rank_one: float  # of the mass matrix at its end, see `Evaluation`


@jitable
def _responding(phase: Phase, c: Instant, w: Workspace) -> Instant:
    """Return the contact of an iteration with the Delassus entries of the effective matrix."""
    v, tilt = w.vectors, phase.residual.tilt
    a_nn, a_nt = dot(v.normal_row, v.normal_response), dot(v.normal_row, v.tangential_response)
    a_tt = dot(v.tangential_row, v.tangential_response)
    return Instant(
        c.gap,
        c.slip,
        c.gap_rate,
        c.slip_rate,
        a_nn,
        a_nt + tilt * a_nn,
        a_tt + tilt * (2.0 * a_nt + tilt * a_nn),
        0.0,
        0.0,
        c.normal_force,
        c.tangential_force,
        c.damping_power,
        c.supplied_power,
    )


@jitable
def _contact_defect(phase: Phase, c: Instant, velocity: float) -> float:
    """Return the residual (m/s) of the contact laws at the forces and the motion."""
    normal, tangential, push = abs(c.gap_rate), abs(c.slip_rate), conjugate(phase, c)
    if phase.stop.compliant:
        normal = abs(stop_force(phase.stop, phase.residual, c.gap, c.gap_rate) - push) * c.a_nn * velocity
    if phase.state != STICKING:
        wanted = friction_ratio(phase, c.slip_rate) * push
        tangential = abs(wanted - c.tangential_force) * c.a_tt * velocity
    elif phase.stick.compliance != 0.0:
        tangential = 0.0  # its law is linear: it holds as soon as the motion is known
    return float(max(normal, tangential))


@jitable
def _contact_step(phase: Phase, c: Instant, w: Workspace, step: StepLength) -> tuple[int, Instant]:
    """Newton step of the two contact forces in an iteration, also into increment and residual; its status."""
    v, velocity, push = w.vectors, step.velocity, conjugate(phase, c)
    normal_row, tangential_row, residual, increment = v.normal_row, v.tangential_row, v.residual, v.increment
    normal_response, tangential_response = v.normal_response, v.tangential_response
    normal = dot(normal_row, increment)
    tangential = dot(tangential_row, increment) + phase.residual.tilt * normal
    # n1 dn + n2 dt = n3,  t1 dn + t2 dt = t3, with dn of the force conjugate to the gap
    if phase.stop.compliant:
        over_depth, over_rate = stop_tangent(phase.stop, phase.residual, c.gap, c.gap_rate)
        stiff = over_depth * step.position + over_rate * velocity
        force = stop_force(phase.stop, phase.residual, c.gap, c.gap_rate)
        n1, n2 = 1.0 + stiff * c.a_nn, stiff * c.a_nt
        n3 = force - push - stiff * normal
    else:
        n1, n2 = velocity * c.a_nn, velocity * c.a_nt
        n3 = -c.gap_rate - velocity * normal
    if phase.state == SLIDING:
        ratio = friction_ratio(phase, c.slip_rate)
        if phase.stop.compliant and not can_slide(phase, c.slip_rate):
            return NO_SLIDING_SOLUTION, c
        if not phase.stop.compliant and not c.a_nn + ratio * c.a_nt > 0.0:
            return NO_SLIDING_SOLUTION, c
        tilt = 1.0 + phase.residual.tilt * ratio
        viscous = phase.friction.slope * tilt * tilt * push * velocity
        t1, t2 = -ratio - viscous * c.a_nt, 1.0 - viscous * c.a_tt
        t3 = ratio * push - c.tangential_force + viscous * tangential
    elif phase.stick.compliance != 0.0:
        stiff = step.position / phase.stick.compliance
        t1, t2 = stiff * c.a_nt, 1.0 + stiff * c.a_tt
        t3 = axial_force(phase.stick, c.slip) - c.tangential_force - stiff * tangential
    else:
        t1, t2, t3 = velocity * c.a_nt, velocity * c.a_tt, -c.slip_rate - velocity * tangential
    determinant = n1 * t2 - n2 * t1
    if determinant == 0.0:
        return NO_STICKING_SOLUTION, c
    dt = (n1 * t3 - n3 * t1) / determinant
    dn = (n3 * t2 - n2 * t3) / determinant + phase.residual.tilt * dt
    for i in range(v.forces.shape[0]):
        increment[i] += dn * normal_response[i] + dt * tangential_response[i]
        residual[i] += dn * normal_row[i] + dt * tangential_row[i]
    return OK, with_forces(c, c.normal_force + dn, c.tangential_force + dt, c.supplied_power)


@jitable
def _predict(a: Attempt, h: float, unchanged: float) -> None:
    """Position and velocity for an acceleration q'' that is this part of the one before."""
    c, y, y_new, d = a.c, a.y, a.scratch.y_new, a.scratch.work.vectors.forces.shape[0]
    arrays = a.phase.arrays
    before, after = algorithm_state(arrays, y, d), algorithm_state(arrays, y_new, d)
    for i in range(d):
        kept, a0 = unchanged * before.acceleration[i], before.algorithmic[i]
        a1 = ((1.0 - c.alpha_f) * kept + c.alpha_f * kept - c.alpha_m * a0) / (1.0 - c.alpha_m)
        y_new[i] = y[i] + h * y[d + i] + h * h * ((0.5 - c.beta) * a0 + c.beta * a1)
        y_new[d + i] = y[d + i] + h * ((1.0 - c.gamma) * a0 + c.gamma * a1)
        after.acceleration[i] = kept


# what an iteration asks of one contact or of several; the compiler drops one of the two branches


@jitable
def _take_residual(
    arrays: ContactArrays | None, a: Attempt, t: float, end: Instant, q: Array, qd: Array, qdd: Array
) -> tuple[float, Instant]:
    """Take the residual without contact forces and the rows of closed contacts; forces stay those of `end`."""
    system, phase, w = a.system, a.phase, a.scratch.work
    if arrays is None:
        e = system.take_residual(t, q, qd, qdd, phase.state != FREE, w)
        supplied, tilt = e.supplied_power, phase.residual.tilt
        return e.rank_one, moved(end, e, end.normal_force, end.tangential_force, supplied, tilt)
    e = system.take_residual(t, q, qd, qdd, False, w)
    return e.rank_one, touch_all(arrays, system, phase, t, q, qd, w, e)


@jitable
def _approach(arrays: ContactArrays | None, a: Attempt, t: float, end: Instant, q: Array, qd: Array) -> Instant:
    """Contact at (q, q'), forces as in `end`."""
    system, phase, w = a.system, a.phase, a.scratch.work
    e = system.approach(t, q, qd, phase.state != FREE, w)
    if arrays is None:
        supplied, tilt = e.supplied_power, phase.residual.tilt
        return moved(end, e, end.normal_force, end.tangential_force, supplied, tilt)
    return touch_all(arrays, system, phase, t, q, qd, w, e)


@jitable
def _add_contacts(arrays: ContactArrays | None, phase: Phase, c: Instant, w: Workspace) -> float:
    """Add the contact forces to the residual; its norm."""
    v = w.vectors
    normal_row, tangential_row, residual = v.normal_row, v.tangential_row, v.residual
    if arrays is not None:
        add_forces(arrays, phase, residual)
    elif phase.state != FREE:
        for i in range(v.forces.shape[0]):
            residual[i] += c.normal_force * normal_row[i] + c.tangential_force * tangential_row[i]
    return float(np.sqrt(dot(residual, residual)))


@jitable
def _largest_defect(arrays: ContactArrays | None, phase: Phase, c: Instant, velocity: float) -> float:
    """Return the largest residual (m/s) of the contact laws."""
    if phase.state == FREE:
        return 0.0
    largest = 0.0
    for i in range(contact_count(arrays)):
        own = by_reference(contact_phase(arrays, phase, i))
        if own.state != FREE:
            largest = max(largest, _contact_defect(own, contact_at(arrays, c, i), velocity))
    return largest


@jitable
def _solve_effective(
    arrays: ContactArrays | None, a: Attempt, end: Instant, rank_one: float, slot: int, step: StepLength
) -> tuple[int, Instant]:
    """Solve for the increment of an iteration with the contact forces; status and contact with its forces."""
    phase, w = a.phase, a.scratch.work
    if arrays is not None:
        return solve_coupled(arrays, a.system, phase, rank_one, slot, step, w), end
    contact = phase.state != FREE
    a.system.solve_effective(rank_one, w, slot, contact)
    if not contact:
        return OK, end
    return _contact_step(phase, _responding(phase, end, w), w, step)


@jitable
def take_step(a: Attempt, h: float, slot: int) -> StepSolution:
    """One step of length h into the scratch, with the effective matrix of a slot.

    After an impact on a damped fine mesh acceleration and force are singular, and iterations that start from them
    may diverge; a step of backward Euler does not depend on them.
    """
    stale = slot == CUT_STEP or a.iterations.stale[slot]
    solution = _iterate(a, h, slot, stale, 1.0)
    if solution.status != OK and is_backward_euler(a.c):
        solution = _iterate(a, h, slot, stale, 0.0)
    if solution.status == OK:
        a.iterations.stale[slot] = False
    return solution


@jitable
def _iterate(a: Attempt, h: float, slot: int, stale: bool, unchanged: float) -> StepSolution:
    """Iterate to the end of a step, from this part of the acceleration and the forces at its start."""
    system, phase, t, s, w, iterations = a.system, a.phase, a.t, a.scratch, a.scratch.work, a.iterations
    d, y_new, v, tolerance = w.vectors.forces.shape[0], s.y_new, w.vectors, a.c.tolerance
    residual, increment, arrays = v.residual, v.increment, phase.arrays
    step = step_length(a.c, h)
    begin_travel(arrays, a.y, d, h)
    q, qd, qdd = y_new[:d], y_new[d : 2 * d], algorithm_state(arrays, y_new, d).acceleration
    _predict(a, h, unchanged)
    forces, end = algorithm_state(arrays, a.y, d).forces, NO_CONTACT
    for i in range(contact_count(arrays)):
        if contact_phase(arrays, phase, i).state != FREE:
            end = keep_forces(arrays, end, i, unchanged * forces[2 * i], unchanged * forces[2 * i + 1])
    iterations.contraction[slot] = -1.0 if stale else _FADING * iterations.contraction[slot]
    iterations.rounded[slot] = 0.0 if stale else iterations.rounded[slot] / _FADING
    closed = _CLOSED * s.tolerances.velocity
    change, before, rank_one = np.inf, 0.0, 0.0
    least, flat = np.inf, 0
    for iteration in range(_MOST_ITERATIONS):
        rank_one, end = _take_residual(arrays, a, t + h, end, q, qd, qdd)
        left = _add_contacts(arrays, phase, end, w)
        if iteration == 0:
            if not system.factor_effective(t + h, q, step.velocity, step.position, w, slot, stale):
                return StepSolution(MASS_NOT_POSITIVE, end, rank_one)
        else:
            # the next change is about the last one times the ratio of the residuals
            iterations.contraction[slot] = left / before if before > 0.0 else -1.0
            accurate = change * left <= tolerance * before
            flat = flat + 1 if left > _FLAT * least else 0
            least = min(least, left)
            if not accurate and left > _STALLED * before:
                # the residual K q of a fine mesh is rounded: it falls no further
                rounding = _FLAT_ROUNDING if flat >= _FLAT_ITERATIONS else _ROUNDING
                accurate = change <= rounding * tolerance
                iterations.rounded[slot] = _ALIKE * left if accurate else 0.0
            if accurate and _largest_defect(arrays, phase, end, step.velocity) <= closed:
                if phase.state == FREE and phase.surface.enabled:
                    end = _approach(arrays, a, t + h, end, q, qd)
                return StepSolution(OK, end, rank_one)
            if not left < UNBOUNDED:
                return StepSolution(NOT_CONVERGED, end, rank_one)
        status, end = _solve_effective(arrays, a, end, rank_one, slot, step)
        if status != OK:
            return StepSolution(status, end, rank_one)
        before = left
        change = step.velocity * np.sqrt(abs(dot(increment, residual)))
        for i in range(d):
            more = increment[i]
            qdd[i] += more
            q[i] += step.position * more
            qd[i] += step.velocity * more
        fallen = left <= iterations.rounded[slot] and change <= _ROUNDING * tolerance
        if fallen or 0.0 < change * iterations.contraction[slot] <= tolerance:
            # known well enough from the last steps; what is known fades, and is measured anew before long
            end = _approach(arrays, a, t + h, end, q, qd)
            if _largest_defect(arrays, phase, end, step.velocity) <= closed:
                return StepSolution(OK, end, rank_one)
    return StepSolution(NOT_CONVERGED, end, rank_one)
