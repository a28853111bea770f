"""The end of a step of generalized-alpha: what it keeps, impulses, the balance of energy, the constraints."""

from __future__ import annotations

from typing import Any

from oblique_impact.contact.forces import drift_of, with_forces
from oblique_impact.contact.several import contact_at, contact_count, contact_phase, keep_forces
from oblique_impact.contact.state import FREE, STICKING, ContactArrays, Instant, Phase
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array, Workspace, copy, dot
from oblique_impact.marching.alpha_contacts import project_sticking
from oblique_impact.marching.alpha_state import (
    GAP,
    GAP_RATE,
    MEMORY,
    SLIP_RATE,
    AlgorithmState,
    Attempt,
    Coefficients,
    algorithm_state,
    is_backward_euler,
    keep_kinematics,
)
from oblique_impact.marching.alpha_step import StepSolution
from oblique_impact.marching.equations import (
    DAMPING_LOSS,
    FRICTION_LOSS,
    NORMAL_IMPULSE,
    OF_A_CONTACT,
    QUADRATURES,
    STABILIZATION_LOSS,
    STOP_LOSS,
    TANGENTIAL_IMPULSE,
    rates_into,
)


@jitable
def finish_step(a: Attempt, h: float, solution: StepSolution) -> None:
    """Complete the state after a converged step of length h: algorithmic acceleration, forces, quadratures.

    Forces to report are in `solution`, those at its end are kept already.
    """
    phase, c, y, y_new, w = a.phase, a.c, a.y, a.scratch.y_new, a.scratch.work
    d, v = w.vectors.forces.shape[0], w.vectors
    arrays = phase.arrays
    before, after = algorithm_state(arrays, y, d), algorithm_state(arrays, y_new, d)
    scale = 1.0 / (1.0 - c.alpha_m)
    rigid = phase.state != FREE and not phase.stop.compliant
    for i in range(d):
        mean = (1.0 - c.alpha_f) * after.acceleration[i] + c.alpha_f * before.acceleration[i]
        after.algorithmic[i] = scale * (mean - c.alpha_m * before.algorithmic[i])
        after.reported[i] = mean if rigid else after.acceleration[i]
    copy(after.acceleration, v.acceleration)
    last, lag = solution.end, c.alpha_f * h
    for i in range(contact_count(arrays)):
        at = contact_at(arrays, solution.end, i)
        after.reported[d + 2 * i], after.reported[d + 2 * i + 1] = at.normal_force, at.tangential_force
        keep_kinematics(after, i, lag, at)
        last = keep_forces(arrays, last, i, after.forces[2 * i], after.forces[2 * i + 1])
    supplied = last.supplied_power + dot(v.supply, v.acceleration)
    last = with_forces(last, last.normal_force, last.tangential_force, supplied)
    # damping is sampled at the mean velocity, below: at the ends it is that of vibrations cut short
    rates_into(arrays, phase, last, y_new[d : 2 * d], w, after.rates)
    after.rates[DAMPING_LOSS] = 0.0
    for i in range(after.rates.shape[0]):
        y_new[2 * d + i] = y[2 * d + i] + 0.5 * h * (before.rates[i] + after.rates[i])
    for k in (NORMAL_IMPULSE, TANGENTIAL_IMPULSE, FRICTION_LOSS):
        y_new[2 * d + k] = y[2 * d + k]
    for i in range(contact_count(arrays)):
        _take_applied_impulses(a, h, i)
    y_new[2 * d + STABILIZATION_LOSS] += _dissipation(a, h, solution.rank_one)
    y_new[2 * d + DAMPING_LOSS] += h * _mean_damping_power(a, h)
    y_new[2 * d + STABILIZATION_LOSS] += _project_constraints(arrays, a, h, solution.end)


@jitable
def _project_constraints(arrays: ContactArrays | None, a: Attempt, h: float, end: Instant) -> float:
    """Project the state onto the constraints of closed contacts, if there are any; the work done (J)."""
    phase, w, y_new = a.phase, a.scratch.work, a.scratch.y_new
    if arrays is None and phase.stick.compliance != 0.0:
        return 0.0
    if arrays is not None:
        return project_sticking(arrays, a.system, phase, a.t + h, w, y_new)
    if phase.state == STICKING or (phase.state != FREE and not phase.stop.compliant):
        return _project(a.system, phase, a.t + h, end, w, y_new)
    return 0.0


@jitable
def _take_applied_impulses(a: Attempt, h: float, i: int) -> None:
    """Add what contact i contributes: impulses that the algorithm has applied, and the work they do.

    With the applied impulses momentum balances to rounding.
    The force is singular where a rigid contact of a damped beam begins, and jumps where one without inertia does:
    the trapezoidal sum of its power is no loss.  Friction takes the applied impulse times the mean slip velocity;
    the dashpot of a contact point without inertia that times the change of the gap, less what its spring stores.
    By how much the work of the mean forces, that of `_dissipation`, differs is the scheme's.
    """
    arrays, c, y, y_new = a.phase.arrays, a.c, a.y, a.scratch.y_new
    d, phase = a.scratch.work.vectors.forces.shape[0], contact_phase(a.phase.arrays, a.phase, i)
    before, after = algorithm_state(arrays, y, d), algorithm_state(arrays, y_new, d)
    normal = _applied(c, before, after, h, 2 * i)
    tangential = _applied(c, before, after, h, 2 * i + 1)
    slip_rate = 0.5 * (before.memory[MEMORY * i + SLIP_RATE] + after.memory[MEMORY * i + SLIP_RATE])
    along = 0.5 * h * (before.forces[2 * i + 1] + after.forces[2 * i + 1])
    friction = -tangential * slip_rate
    y_new[2 * d + NORMAL_IMPULSE] += normal
    y_new[2 * d + TANGENTIAL_IMPULSE] += tangential
    y_new[2 * d + FRICTION_LOSS] += friction
    _add_to_contact(arrays, y[2 * d :], y_new[2 * d :], i, normal, tangential, friction)
    work = along * _of_displacement(c, before, after, MEMORY * i + SLIP_RATE)
    y_new[2 * d + STABILIZATION_LOSS] += -friction - work
    if phase.stop.massless:
        gap_rate = _of_displacement(c, before, after, GAP_RATE)
        applied = normal - phase.residual.tilt * tangential
        d0, d1 = max(0.0, -before.memory[GAP]), max(0.0, -after.memory[GAP])
        stored = 0.5 * (d1 * d1 - d0 * d0) / phase.residual.compliance
        y_new[2 * d + STOP_LOSS] = y[2 * d + STOP_LOSS] - applied * gap_rate - stored
        excess = applied - 0.5 * h * (before.forces[0] + after.forces[0]) + phase.residual.tilt * along
        y_new[2 * d + STABILIZATION_LOSS] += excess * gap_rate


@jitable
def _applied(c: Coefficients, before: AlgorithmState, after: AlgorithmState, h: float, k: int) -> float:
    """Impulse (N s) that the algorithm has applied by the contact force number k; keeps its average."""
    mean = (1.0 - c.alpha_f) * after.forces[k] + c.alpha_f * before.forces[k]
    after.averaged[k] = 1.0 / (1.0 - c.alpha_m) * (mean - c.alpha_m * before.averaged[k])
    return float(h * ((1.0 - c.gamma) * before.averaged[k] + c.gamma * after.averaged[k]))


@jitable
def _add_to_contact(
    arrays: ContactArrays | None,
    before: Array,
    after: Array,
    i: int,
    normal: float,
    tangential: float,
    friction: float,
) -> None:
    """Set impulses (N s) and loss by friction (J) of one of several contacts among the quadratures."""
    if arrays is not None:
        own = QUADRATURES + OF_A_CONTACT * i
        after[own], after[own + 1] = before[own] + normal, before[own + 1] + tangential
        after[own + 2] = before[own + 2] + friction


@inlined
def _of_displacement(c: Coefficients, before: AlgorithmState, after: AlgorithmState, which: int) -> float:
    """Displacement of a step over its length (m/s): the mean rate, or the last one of backward Euler."""
    first, last = float(before.memory[which]), float(after.memory[which])
    return last if is_backward_euler(c) else 0.5 * (first + last)


@jitable
def _mean_damping_power(a: Attempt, h: float) -> float:
    """Power (W) of damping forces over a step, their mean times the displacement; s.at holds the mean velocity v.

    The displacement is h v but for a step of backward Euler, where it is h times the velocity v1 at the end.
    After an impact v1 is a small part of v if the step does not resolve the damping: v1 C v is not v C v.
    """
    s, y_new, w = a.scratch, a.scratch.y_new, a.scratch.work
    d = w.vectors.forces.shape[0]
    mean, other, end = s.at[:d], s.at[d : 2 * d], y_new[d : 2 * d]
    if not is_backward_euler(a.c):
        for i in range(d):
            other[i] = 0.5 * (a.y[i] + y_new[i])  # a damping matrix may depend on q: that of the middle
        return float(a.system.damping_at(a.t + 0.5 * h, other, mean, w))
    for i in range(d):
        other[i] = end[i] - mean[i]
        mean[i] += end[i]
    whole = a.system.damping_at(a.t + h, y_new[:d], mean, w)
    return float(0.25 * (whole - a.system.damping_at(a.t + h, y_new[:d], other, w)))


@jitable
def _corrections(phase: Phase, c: Instant, gap: float, slip: float) -> tuple[float, float]:
    """Multiples of the responses that take a gap and, while sticking, a slip to zero (or their rates)."""
    if phase.state != STICKING:
        return (0.0 if phase.stop.compliant else -gap / c.a_nn), 0.0
    if phase.stop.compliant:
        return 0.0, -slip / c.a_tt
    determinant = c.a_nn * c.a_tt - c.a_nt * c.a_nt
    return (c.a_nt * slip - c.a_tt * gap) / determinant, (c.a_nt * gap - c.a_nn * slip) / determinant


@jitable
def _project(system: Any, phase: Phase, t: float, c: Instant, w: Workspace, y: Array) -> float:
    """Move q, then q', onto the constraints of a contact along the responses of the step; the work done (J).

    The velocity is left exact to rounding, because a step cut short divides what is left by its length.
    """
    d, v, done = w.vectors.forces.shape[0], w.vectors, 0.0
    forces, normal_response, tangential_response = v.forces, v.normal_response, v.tangential_response
    normal, tangential = _corrections(phase, c, c.gap, drift_of(phase.stick, c))
    normal += phase.residual.tilt * tangential
    for i in range(d):
        move = normal * normal_response[i] + tangential * tangential_response[i]
        y[i] += move
        done += forces[i] * move
    e = system.approach(t, y[:d], y[d : 2 * d], True, w)
    normal, tangential = _corrections(phase, c, e.gap_rate, e.slip_rate + phase.residual.tilt * e.gap_rate)
    normal += phase.residual.tilt * tangential
    for i in range(d):
        y[d + i] += normal * normal_response[i] + tangential * tangential_response[i]
    return done


@jitable
def _dissipation(a: Attempt, h: float, rank_one: float) -> float:
    """Energy (J) that the algorithm itself takes in a step.

    That is the trapezoidal work of the forces M q'' less the kinetic energy gained.  With the means v of q'
    and A of q'':  h^2 (beta - gamma/2) A.M (a1 - a0) - v.M (q'1 - q'0 - h A).
    """
    s, y, y_new, w = a.scratch, a.y, a.scratch.y_new, a.scratch.work
    d, v = w.vectors.forces.shape[0], w.vectors
    product_a, product_b = v.product_a, v.product_b
    arrays = a.phase.arrays
    before, after = algorithm_state(arrays, y, d), algorithm_state(arrays, y_new, d)
    for i in range(d):
        s.at[i] = 0.5 * (y[d + i] + y_new[d + i])
        s.at[d + i] = 0.5 * (before.acceleration[i] + after.acceleration[i])
    a.system.mass_product(rank_one, w, s.at[:d], product_a)
    a.system.mass_product(rank_one, w, s.at[d : 2 * d], product_b)
    curved, lagging = 0.0, 0.0
    for i in range(d):
        curved += product_b[i] * (after.algorithmic[i] - before.algorithmic[i])
        lagging += product_a[i] * (y_new[d + i] - y[d + i] - h * s.at[d + i])
    return h * h * (a.c.beta - 0.5 * a.c.gamma) * curved - lagging
