"""One step of generalized-alpha, with the contact forces from the Schur complement of the effective matrix.

Each iteration solves with the constant effective matrix.  A contact that sticks is held on the velocity, Z' = 0
(index 2), which keeps its force well conditioned in the shortest of steps, and then projected onto Z = 0
(:mod:`~oblique_impact.marching.alpha_balance`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from oblique_impact.contact.elastic import press
from oblique_impact.contact.forces import MASS_NOT_POSITIVE, OK, touch_contacts
from oblique_impact.contact.state import FREE, Contacts
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import INCREMENT, RESIDUAL, Array, dot
from oblique_impact.marching.advance import FAILED_ITERATION, UNBOUNDED
from oblique_impact.marching.alpha_contacts import add_forces, largest_defect, solve_contacts
from oblique_impact.marching.alpha_state import (
    Attempt,
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
    supplied: float  # W, by drives at q'' = 0 at its end; forces and motion of the contacts are in their records
    rank_one: float  # of the mass matrix at its end, see `Evaluation`


@inlined
def _predict(a: Attempt, h: float, unchanged: float) -> None:
    """Position and velocity for an acceleration q'' that is this part of the one before."""
    c, y, y_new, d = a.c, a.y, a.scratch.y_new, a.scratch.work.vectors.shape[1]
    before, after = algorithm_state(a.contacts, y, d), algorithm_state(a.contacts, y_new, d)
    for i in range(d):
        kept, a0 = unchanged * before.acceleration[i], before.algorithmic[i]
        a1 = ((1.0 - c.alpha_f) * kept + c.alpha_f * kept - c.alpha_m * a0) / (1.0 - c.alpha_m)
        y_new[i] = y[i] + h * y[d + i] + h * h * ((0.5 - c.beta) * a0 + c.beta * a1)
        y_new[d + i] = y[d + i] + h * ((1.0 - c.gamma) * a0 + c.gamma * a1)
        after.acceleration[i] = kept


@jitable
def _approach(a: Attempt, t: float, q: Array, qd: Array, closed: int) -> float:
    """Contacts at (q, q'), of those in flight gap and gap rate alone; the supplied power (W)."""
    e = a.system.approach(t, q, qd, a.scratch.work)
    if closed > 0:
        touch_contacts(a.system, a.contacts, t, q, qd, a.scratch.work)
    else:
        a.system.measure(t, q, qd, a.scratch.work, a.contacts)
        press(a.contacts)
    return float(e.supplied_power)


@jitable
def take_step(a: Attempt, h: float, slot: int) -> StepSolution:
    """One step of length h into the scratch, with the effective matrix of a slot.

    Where a contact without inertia begins on a damped fine mesh, iterations that start from the acceleration and
    the force there may diverge; a step of backward Euler does not depend on them.
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
    system, contacts, t, s, w, iterations = a.system, a.contacts, a.t, a.scratch, a.scratch.work, a.iterations
    y_new, v, tolerance, d = s.y_new, w.vectors, a.c.tolerance, w.vectors.shape[1]
    residual, increment = v[RESIDUAL], v[INCREMENT]
    step = step_length(a.c, h)
    begin_travel(contacts, a.y, d, h)
    q, qd, qdd = y_new[:d], y_new[d : 2 * d], algorithm_state(contacts, y_new, d).acceleration
    _predict(a, h, unchanged)
    closed = _begin_forces(contacts, algorithm_state(contacts, a.y, d).forces, unchanged)
    iterations.contraction[slot] = -1.0 if stale else _FADING * iterations.contraction[slot]
    iterations.rounded[slot] = 0.0 if stale else iterations.rounded[slot] / _FADING
    still = _CLOSED * s.tolerances.velocity
    change, before, rank_one, supplied = np.inf, 0.0, 0.0, 0.0
    least, flat = np.inf, 0
    for iteration in range(_MOST_ITERATIONS):
        e = system.take_residual(t + h, q, qd, qdd, w)
        rank_one, supplied = e.rank_one, e.supplied_power
        if closed > 0:
            touch_contacts(system, contacts, t + h, q, qd, w)
            add_forces(contacts, residual)
        left = float(np.sqrt(dot(residual, residual)))
        if iteration == 0:
            if not system.factor_effective(t + h, q, step.velocity, step.position, w, slot, stale):
                return StepSolution(MASS_NOT_POSITIVE, supplied, rank_one)
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
            if accurate and largest_defect(contacts, step.velocity) <= still:
                if closed == 0 and contacts.each[0].enabled:
                    supplied = _approach(a, t + h, q, qd, closed)
                return StepSolution(OK, supplied, rank_one)
            if not left < UNBOUNDED:
                return StepSolution(NOT_CONVERGED, supplied, rank_one)
        system.solve_effective(rank_one, w, slot, contacts, closed > 0)
        status = solve_contacts(contacts, step, w)
        if status != OK:
            return StepSolution(status, supplied, rank_one)
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
            supplied = _approach(a, t + h, q, qd, closed)
            if largest_defect(contacts, step.velocity) <= still:
                return StepSolution(OK, supplied, rank_one)
    return StepSolution(NOT_CONVERGED, supplied, rank_one)


@inlined
def _begin_forces(contacts: Contacts, forces: Array, unchanged: float) -> int:
    """Begin with this part of the forces (2 n,) at the start of the step; returns how many contacts are closed."""
    closed = 0
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        c.normal_force = 0.0
        c.tangential_force = 0.0
        if c.state != FREE:
            closed += 1
            c.tangential_force = unchanged * forces[2 * i + 1]
            c.normal_force = unchanged * forces[2 * i] - c.tilt * c.tangential_force
    return closed
