"""Generalized-alpha: implicit, second order, with selectable dissipation at high frequencies.

Chung and Hulbert, J. Appl. Mech. 60 (1993), in the form of Arnold and Bruels, Multibody Syst. Dyn. 18 (2007):
equilibrium holds at the end of the step, M q'' = Q + D^T lambda, and the algorithmic acceleration a follows by

    (1 - alpha_m) a1 + alpha_m a0 = (1 - alpha_f) q''1 + alpha_f q''0
    q1 = q0 + h q'0 + h^2 ((1/2 - beta) a0 + beta a1),     q'1 = q'0 + h ((1 - gamma) a0 + gamma a1)

Each iteration solves with the constant effective matrix and takes the contact forces from its Schur
complement.  A rigid contact is held on the velocity, Z' = 0 (index 2), which keeps the forces well conditioned
in the shortest of steps, and then projected onto Z = 0.  Transitions are located by shortening the step.

What is reported of a rigid contact, forces and accelerations, are the algorithm's own means,
(1 - alpha_f) lambda1 + alpha_f lambda0: the values at the ends of the steps swing about them by a factor of
-rho_infinity per step after every jump.
"""

from __future__ import annotations

import time
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact import (
    FREE,
    GUARD_NORMAL,
    MASS_NOT_POSITIVE,
    NO_SLIDING_SOLUTION,
    NO_STICKING_SOLUTION,
    SLIDING,
    STICKING,
    Phase,
    accelerate,
    measure_guards,
    spring_force,
)
from oblique_impact.dense import row_dot
from oblique_impact.implicit import approach, factor_effective, mass_product, residual, solve_effective
from oblique_impact.integrators.base import (
    AT_GUARD,
    AT_STOP,
    BUFFER_FULL,
    FAILED_FINITE,
    FAILED_ITERATION,
    Course,
    Progress,
    Scheme,
    Scratch,
    Tolerances,
    arm,
)
from oblique_impact.integrators.motion import (
    DAMPING_LOSS,
    NORMAL_IMPULSE,
    QUADRATURES,
    STABILIZATION_LOSS,
    TANGENTIAL_IMPULSE,
    copy,
    quadrature_rates,
)
from oblique_impact.jit import jitable
from oblique_impact.system import (
    A_NN,
    A_NT,
    A_TT,
    ACCELERATION,
    DAMPING_POWER,
    FIRST_GUARD,
    FORCES,
    GAP,
    GAP_RATE,
    GUARDS,
    INCREMENT,
    LAMBDA_N,
    LAMBDA_T,
    NORMAL_RESPONSE,
    NORMAL_ROW,
    PRODUCT_A,
    PRODUCT_B,
    RESIDUAL,
    SLIP,
    SLIP_RATE,
    TANGENT_RESPONSE,
    TANGENT_ROW,
    Array,
    Work,
    damping_power,
)

# The state vector goes on behind the quadratures: acceleration to report (d), acceleration q'' (d), algorithmic
# acceleration a (d), then contact forces (N) to report, at the end of the step, and as the algorithm averages them
REPORTED_N, REPORTED_T, CONTACT_N, CONTACT_T, FILTERED_N, FILTERED_T = range(6)
RATES = 6  # rates of the quadratures (6)
EXTRAS = RATES + QUADRATURES

NOT_CONVERGED = -FAILED_ITERATION

FAR, NEAR, ODD = 0, 1, 2  # slots of the effective matrix: step in flight, step in and near contact, a cut step

_MOST_ITERATIONS = 60
_CLOSED = 1e-10  # m/s, error of the velocity in a contact that counts as zero
_FADING = 1.05  # a contraction that was not measured counts so much less with every step
_STALLED, _ROUNDING = 0.25, 1e4  # a residual that stays above this part, and corrections in tolerances by rounding
_UNBOUNDED = 1e12
_LOCATED = 1e-12  # s
_LANDED = 1e-12  # m, or the unit of another guard: how far below zero it may be found
_FIRST_LEG, _SECONDS_PER_LEG = 200, 0.1
_START, _END = 0, 1


class Coefficients(NamedTuple):
    """Parameters of the scheme."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    tolerance: float  # of the iterations, on the root of the energy of a correction (J^1/2)


def coefficients(rho_infinity: float, tolerance: float) -> Coefficients:
    """Optimal parameters for a spectral radius rho_infinity at infinite frequency (Chung and Hulbert 1993)."""
    alpha_m = (2.0 * rho_infinity - 1.0) / (rho_infinity + 1.0)
    alpha_f = rho_infinity / (rho_infinity + 1.0)
    gamma = 0.5 - alpha_m + alpha_f
    return Coefficients(alpha_m, alpha_f, 0.25 * (gamma + 0.5) ** 2, gamma, tolerance)


@jitable
def start_phase(system: Any, phase: Phase, t: float, y: Array, work: Work) -> int:
    """Consistent accelerations and contact forces at the start of a phase into the tail of y."""
    d = work.vectors.shape[1]
    q, qd, tail = y[:d], y[d : 2 * d], 3 * d + QUADRATURES
    status = accelerate(system, phase, t, q, qd, work)
    if status != 0:
        return status
    extras = tail + 2 * d
    for i in range(d):
        for block in range(-1, 2):
            y[tail + block * d + i] = work.vectors[ACCELERATION, i]
    y[extras + REPORTED_N] = work.scalars[LAMBDA_N]
    y[extras + REPORTED_T] = work.scalars[LAMBDA_T]
    y[extras + CONTACT_N] = work.scalars[LAMBDA_N]
    y[extras + CONTACT_T] = work.scalars[LAMBDA_T]
    y[extras + FILTERED_N] = work.scalars[LAMBDA_N]
    y[extras + FILTERED_T] = work.scalars[LAMBDA_T]
    work.scalars[DAMPING_POWER] = 0.0
    quadrature_rates(system, phase, t, q, qd, work, y[extras + RATES :])
    return 0


@jitable
def _contact_defect(phase: Phase, k: Array, velocity: float) -> float:
    """How far the contact forces and the motion are from the contact's laws (m/s)."""
    if phase.spring > 0.0:
        force = spring_force(phase.spring, phase.dashpot, k[GAP], k[GAP_RATE])
        normal = abs(force - k[LAMBDA_N]) * k[A_NN] * velocity
    else:
        normal = abs(k[GAP_RATE])
    if phase.state == STICKING:
        tangential = abs(k[SLIP_RATE])
    else:
        ratio = phase.intercept + phase.slope * k[SLIP_RATE]
        tangential = abs(ratio * k[LAMBDA_N] - k[LAMBDA_T]) * k[A_TT] * velocity
    return float(max(normal, tangential))


@jitable
def _contact_step(phase: Phase, k: Array, v: Array, velocity: float, position: float) -> int:
    """Newton step of the two contact forces in an iteration, into scalars and INCREMENT; its status.

    `velocity` and `position` are the factors from q'' to q' and q at the end of the step.
    """
    k[A_NN] = row_dot(v, NORMAL_ROW, NORMAL_RESPONSE)
    k[A_NT] = row_dot(v, NORMAL_ROW, TANGENT_RESPONSE)
    k[A_TT] = row_dot(v, TANGENT_ROW, TANGENT_RESPONSE)
    normal, tangential = row_dot(v, NORMAL_ROW, INCREMENT), row_dot(v, TANGENT_ROW, INCREMENT)
    # n1 dn + n2 dt = n3,  t1 dn + t2 dt = t3
    if phase.spring > 0.0:
        depth = max(0.0, -k[GAP])
        grip = 1.0 - phase.dashpot * k[GAP_RATE]
        stiff = phase.spring * (grip * position + depth * phase.dashpot * velocity) if depth * grip > 0.0 else 0.0
        force = spring_force(phase.spring, phase.dashpot, k[GAP], k[GAP_RATE])
        n1, n2 = 1.0 + stiff * k[A_NN], stiff * k[A_NT]
        n3 = force - k[LAMBDA_N] - stiff * normal
    else:
        n1, n2 = velocity * k[A_NN], velocity * k[A_NT]
        n3 = -k[GAP_RATE] - velocity * normal
    if phase.state == SLIDING:
        ratio = phase.intercept + phase.slope * k[SLIP_RATE]
        if phase.spring == 0.0 and not k[A_NN] + ratio * k[A_NT] > 0.0:
            return NO_SLIDING_SOLUTION
        viscous = phase.slope * k[LAMBDA_N] * velocity
        t1, t2 = -ratio - viscous * k[A_NT], 1.0 - viscous * k[A_TT]
        t3 = ratio * k[LAMBDA_N] - k[LAMBDA_T] + viscous * tangential
    else:
        drift = k[SLIP_RATE]
        t1, t2, t3 = velocity * k[A_NT], velocity * k[A_TT], -drift - velocity * tangential
    determinant = n1 * t2 - n2 * t1
    if determinant == 0.0:
        return NO_STICKING_SOLUTION
    dn, dt = (n3 * t2 - n2 * t3) / determinant, (n1 * t3 - n3 * t1) / determinant
    k[LAMBDA_N] += dn
    k[LAMBDA_T] += dt
    for i in range(v.shape[1]):
        v[INCREMENT, i] += dn * v[NORMAL_RESPONSE, i] + dt * v[TANGENT_RESPONSE, i]
        v[RESIDUAL, i] += dn * v[NORMAL_ROW, i] + dt * v[TANGENT_ROW, i]
    return 0


@jitable
def _predict(c: Coefficients, y: Array, h: float, d: int, y_new: Array) -> None:
    """Position and velocity for an unchanged acceleration q''."""
    tail = 3 * d + QUADRATURES
    for i in range(d):
        kept, a0 = y[tail + i], y[tail + d + i]
        a1 = ((1.0 - c.alpha_f) * kept + c.alpha_f * kept - c.alpha_m * a0) / (1.0 - c.alpha_m)
        y_new[i] = y[i] + h * y[d + i] + h * h * ((0.5 - c.beta) * a0 + c.beta * a1)
        y_new[d + i] = y[d + i] + h * ((1.0 - c.gamma) * a0 + c.gamma * a1)
        y_new[tail + i] = kept


@jitable
def _take_contact(phase: Phase, work: Work) -> float:
    """Add the contact forces to the residual; its largest entry."""
    v, k, largest = work.vectors, work.scalars, 0.0
    if phase.state != FREE:
        for i in range(v.shape[1]):
            v[RESIDUAL, i] += k[LAMBDA_N] * v[NORMAL_ROW, i] + k[LAMBDA_T] * v[TANGENT_ROW, i]
    for i in range(v.shape[1]):
        largest = max(largest, abs(v[RESIDUAL, i]))
    return largest


@jitable
def _step(
    system: Any, phase: Phase, c: Coefficients, t: float, y: Array, h: float, slot: int, stale: bool, s: Scratch
) -> int:
    """One step of length h from (t, y) into s.y_new; status of the contact problem, or NOT_CONVERGED.

    Afterwards `s.work` holds the end of the step: kinematics, contact forces, guards.
    """
    d, work, y_new = s.work.vectors.shape[1], s.work, s.y_new
    v, k, tail = work.vectors, work.scalars, 3 * d + QUADRATURES
    ratio = (1.0 - c.alpha_f) / (1.0 - c.alpha_m)
    velocity, position = h * c.gamma * ratio, h * h * c.beta * ratio
    q, qd, qdd = y_new[:d], y_new[d : 2 * d], y_new[tail : tail + d]
    contact = phase.state != FREE
    _predict(c, y, h, d, y_new)
    k[LAMBDA_N] = y[tail + 2 * d + CONTACT_N] if contact else 0.0
    k[LAMBDA_T] = y[tail + 2 * d + CONTACT_T] if contact else 0.0
    s.contraction[slot] = -1.0 if stale else _FADING * s.contraction[slot]
    change, before = np.inf, 0.0
    for iteration in range(_MOST_ITERATIONS):
        residual(system, t + h, q, qd, qdd, contact, work)
        left = _take_contact(phase, work)
        if iteration == 0:
            if not factor_effective(system, t + h, q, velocity, position, work, slot, stale):
                return MASS_NOT_POSITIVE
        else:
            # the next change is about the last one times the ratio of the residuals
            s.contraction[slot] = left / before
            accurate = change * left <= c.tolerance * before
            if not accurate and left > _STALLED * before:
                # the residual K q of a fine mesh is rounded: it falls no further
                accurate = change <= _ROUNDING * c.tolerance
            if accurate and (not contact or _contact_defect(phase, k, velocity) <= _CLOSED):
                break
            if not left < _UNBOUNDED:
                return NOT_CONVERGED
        solve_effective(system, work, slot, contact)
        if contact:
            status = _contact_step(phase, k, v, velocity, position)
            if status != 0:
                return status
        before = left
        change = velocity * np.sqrt(abs(row_dot(v, INCREMENT, RESIDUAL)))
        for i in range(d):
            step = v[INCREMENT, i]
            qdd[i] += step
            q[i] += position * step
            qd[i] += velocity * step
        if 0.0 < change * s.contraction[slot] <= c.tolerance:
            # known well enough from the last steps; what is known fades, and is measured anew before long
            approach(system, t + h, q, qd, work)
            if not contact or _contact_defect(phase, k, velocity) <= _CLOSED:
                return 0
    else:
        return NOT_CONVERGED
    if not contact and phase.watched:
        approach(system, t + h, q, qd, work)
    return 0


@jitable
def _finish(system: Any, phase: Phase, c: Coefficients, t: float, y: Array, h: float, s: Scratch) -> None:
    """Complete s.y_new after a converged step: algorithmic acceleration, averaged forces, quadratures."""
    d, work, y_new = s.work.vectors.shape[1], s.work, s.y_new
    v, k, tail = work.vectors, work.scalars, 3 * d + QUADRATURES
    algorithmic, extras = tail + d, tail + 2 * d
    kept, scale = c.alpha_f, 1.0 / (1.0 - c.alpha_m)
    rigid = phase.state != FREE and phase.spring == 0.0
    for i in range(d):
        mean = (1.0 - kept) * y_new[tail + i] + kept * y[tail + i]
        y_new[algorithmic + i] = scale * (mean - c.alpha_m * y[algorithmic + i])
        y_new[2 * d + QUADRATURES + i] = mean if rigid else y_new[tail + i]
        v[ACCELERATION, i] = y_new[tail + i]
    y_new[extras + REPORTED_N], y_new[extras + REPORTED_T] = k[LAMBDA_N], k[LAMBDA_T]
    k[LAMBDA_N], k[LAMBDA_T] = y_new[extras + CONTACT_N], y_new[extras + CONTACT_T]
    k[DAMPING_POWER] = 0.0  # sampled at the mean velocity, below: at the ends it is that of vibrations cut short
    quadrature_rates(system, phase, t + h, y_new[:d], y_new[d : 2 * d], work, y_new[extras + RATES :])
    for i in range(QUADRATURES):
        y_new[2 * d + i] = y[2 * d + i] + 0.5 * h * (y[extras + RATES + i] + y_new[extras + RATES + i])
    # the impulse that the algorithm has applied, so that momentum balances to rounding
    for force, averaged, impulse in (
        (CONTACT_N, FILTERED_N, NORMAL_IMPULSE),
        (CONTACT_T, FILTERED_T, TANGENTIAL_IMPULSE),
    ):
        mean = (1.0 - kept) * y_new[extras + force] + kept * y[extras + force]
        y_new[extras + averaged] = scale * (mean - c.alpha_m * y[extras + averaged])
        applied = (1.0 - c.gamma) * y[extras + averaged] + c.gamma * y_new[extras + averaged]
        y_new[2 * d + impulse] = y[2 * d + impulse] + h * applied
    y_new[2 * d + STABILIZATION_LOSS] += _dissipation(system, c, y, h, s)
    y_new[2 * d + DAMPING_LOSS] += h * damping_power(system, t, y_new[:d], s.at[:d], work)
    if rigid or phase.state == STICKING:
        y_new[2 * d + STABILIZATION_LOSS] += _project(system, phase, t + h, work, y_new)


@jitable
def _corrections(phase: Phase, k: Array, gap: float, slip: float) -> tuple[float, float]:
    """Multiples of the responses that take a gap and, while sticking, a slip to zero (or their rates)."""
    if phase.state != STICKING:
        return (-gap / k[A_NN] if phase.spring == 0.0 else 0.0), 0.0
    if phase.spring > 0.0:
        return 0.0, -slip / k[A_TT]
    determinant = k[A_NN] * k[A_TT] - k[A_NT] * k[A_NT]
    return (k[A_NT] * slip - k[A_TT] * gap) / determinant, (k[A_NT] * gap - k[A_NN] * slip) / determinant


@jitable
def _project(system: Any, phase: Phase, t: float, work: Work, y: Array) -> float:
    """Move q, then q', onto the constraints of a contact along the responses of the step; the work done (J).

    The velocity is left exact to rounding, because a step cut short divides what is left by its length.
    """
    d, v, k, done = work.vectors.shape[1], work.vectors, work.scalars, 0.0
    normal, tangential = _corrections(phase, k, k[GAP], k[SLIP] - phase.slip_reference)
    for i in range(d):
        move = normal * v[NORMAL_RESPONSE, i] + tangential * v[TANGENT_RESPONSE, i]
        y[i] += move
        done += v[FORCES, i] * move
    approach(system, t, y[:d], y[d : 2 * d], work)
    normal, tangential = _corrections(phase, k, k[GAP_RATE], k[SLIP_RATE])
    for i in range(d):
        y[d + i] += normal * v[NORMAL_RESPONSE, i] + tangential * v[TANGENT_RESPONSE, i]
    return done


@jitable
def _dissipation(system: Any, c: Coefficients, y: Array, h: float, s: Scratch) -> float:
    """Energy (J) that the algorithm itself takes in a step.

    That is the trapezoidal work of the forces M q'' less the kinetic energy gained.  With the means v of q'
    and A of q'':  h^2 (beta - gamma/2) A.M (a1 - a0) - v.M (q'1 - q'0 - h A).
    """
    d, work, y_new = s.work.vectors.shape[1], s.work, s.y_new
    tail = 3 * d + QUADRATURES
    for i in range(d):
        s.at[i] = 0.5 * (y[d + i] + y_new[d + i])
        s.at[d + i] = 0.5 * (y[tail + i] + y_new[tail + i])
    mass_product(system, work, s.at[:d], PRODUCT_A)
    mass_product(system, work, s.at[d : 2 * d], PRODUCT_B)
    curved, lagging = 0.0, 0.0
    for i in range(d):
        curved += work.vectors[PRODUCT_B, i] * (y_new[tail + d + i] - y[tail + d + i])
        lagging += work.vectors[PRODUCT_A, i] * (y_new[d + i] - y[d + i] - h * s.at[d + i])
    return h * h * (c.beta - 0.5 * c.gamma) * curved - lagging


@jitable
def _measure(phase: Phase, s: Scratch, row: int) -> None:
    """Guards at the end of a step, the gap and its rate into a row of the scratch."""
    measure_guards(phase, s.work.scalars)
    for g in range(GUARDS):
        s.values[row, g] = s.work.scalars[FIRST_GUARD + g]
    s.slopes[row, GUARD_NORMAL] = s.work.scalars[GAP_RATE]


@jitable
def _measure_end(phase: Phase, c: Coefficients, y: Array, s: Scratch) -> None:
    """Guards at the end of a step from y, with the contact forces to report; those of the end go into s.y_new."""
    k, extras = s.work.scalars, 5 * s.work.vectors.shape[1] + QUADRATURES
    s.y_new[extras + CONTACT_N], s.y_new[extras + CONTACT_T] = k[LAMBDA_N], k[LAMBDA_T]
    if phase.state != FREE and phase.spring == 0.0:
        k[LAMBDA_N] += c.alpha_f * (y[extras + CONTACT_N] - k[LAMBDA_N])
        k[LAMBDA_T] += c.alpha_f * (y[extras + CONTACT_T] - k[LAMBDA_T])
    _measure(phase, s, _END)


@jitable
def _raised(s: Scratch, row: int, guard: int) -> float:
    """Return a guard, raised by its threshold until it is armed."""
    return float(s.values[row, guard] + (0.0 if s.armed[guard] else s.thresholds[guard]))


@jitable
def _shorten(
    system: Any, phase: Phase, c: Coefficients, t: float, y: Array, h: float, guard: int, s: Scratch
) -> tuple[int, float]:
    """Length in (0, h] of the step that ends where the guard, fallen at h, falls (Illinois), and the status."""
    a, b, fa, fb = 0.0, h, _raised(s, _START, guard), _raised(s, _END, guard)
    status = 0
    for _ in range(80):
        if (
            fb >= -0.1 * min(s.thresholds[guard], _LANDED)
            or b - a <= (1e-3 if phase.state == FREE else 1.0) * _LOCATED
        ):
            break
        x = 0.5 * (a + b)  # a phase that starts at zero may rise first and fall later: halve until it is seen
        if fa > 0.0:
            x = (a * fb - b * fa) / (fb - fa)
            x = min(max(x, a + 0.01 * (b - a)), b - 0.01 * (b - a))
        status = _step(system, phase, c, t, y, x, ODD, True, s)
        if status != 0:
            return status, x
        _measure_end(phase, c, y, s)
        fx = _raised(s, _END, guard)
        if fx > 0.0:
            fb = 0.5 * fb if a > 0.0 else fb
            a, fa = x, fx
        else:
            fa = 0.5 * fa if b < h else fa
            b, fb = x, fx
    return status, b


@jitable
def _dip(s: Scratch, h: float) -> float:
    """Part of a step where the cubic through gap and gap rate has its least value, if below zero; else 0."""
    ga, gb = s.values[_START, GUARD_NORMAL], s.values[_END, GUARD_NORMAL]
    sa, sb = h * s.slopes[_START, GUARD_NORMAL], h * s.slopes[_END, GUARD_NORMAL]
    if sa >= 0.0 or sb <= 0.0:
        return 0.0
    c2, c3 = 3.0 * (gb - ga) - 2.0 * sa - sb, sa + sb - 2.0 * (gb - ga)
    x = -sa / (c2 + np.sqrt(max(c2 * c2 - 3.0 * c3 * sa, 0.0)))
    value = ga + x * (sa + x * (c2 + x * c3))
    return float(x) if 0.0 < x < 1.0 and value < 0.0 else 0.0


@jitable
def _fall(
    system: Any, phase: Phase, c: Coefficients, t: float, y: Array, h: float, s: Scratch
) -> tuple[int, int, float]:
    """First guard that falls in the step just taken, or -1; the status and the length of the step up to it.

    Afterwards s.y_new is that shorter step, or the whole one.
    """
    first, length, redo = -1, h, False
    if phase.state == FREE and s.armed[GUARD_NORMAL] and s.values[_END, GUARD_NORMAL] > 0.0:
        part = _dip(s, h)
        if part > 0.0:
            redo, length = True, part * h
            status = _step(system, phase, c, t, y, length, ODD, True, s)
            if status != 0:
                return -1, status, length
            _measure_end(phase, c, y, s)
            if s.values[_END, GUARD_NORMAL] > 0.0:  # the gap only comes close
                length = h
    for guard in range(GUARDS):
        # each guard found fallen shortens the step; one that falls earlier still is fallen there too
        if _raised(s, _END, guard) <= 0.0:
            status, length = _shorten(system, phase, c, t, y, length, guard, s)
            if status != 0:
                return -1, status, length
            first, redo = guard, True
            status = _step(system, phase, c, t, y, length, ODD, True, s)
            if status != 0:
                return -1, status, length
            _measure_end(phase, c, y, s)
    if redo and first < 0:
        status = _step(system, phase, c, t, y, length, ODD, True, s)
        if status != 0:
            return -1, status, length
        _measure_end(phase, c, y, s)
    return first, 0, length


@jitable
def march_alpha(
    system: Any,
    phase: Phase,
    c: Coefficients,
    start: float,
    done: int,
    last: float,
    y: Array,
    far_step: float,
    near_step: float,
    near: float,
    t_stop: float,
    output_interval: float,
    next_sample: int,
    most_steps: int,
    fresh: bool,
    s: Scratch,
) -> tuple[Progress, int, float, int]:
    """Advance y in place; the times are start + k h as long as the step h (`last`) stays the same.

    Returns the progress, the number of the next sample, and the new start and k.
    """
    steps, count, peak = 0, 0, 0.0
    d, capacity = s.work.vectors.shape[1], s.times.shape[0]
    t, h = start + done * last, last
    extras = 5 * d + QUADRATURES
    status = 0
    if fresh:
        status = start_phase(system, phase, t, y, s.work)
        _measure(phase, s, _START)
    else:
        residual(system, t, y[:d], y[d : 2 * d], y[3 * d + QUADRATURES : 4 * d + QUADRATURES], True, s.work)
        s.work.scalars[LAMBDA_N], s.work.scalars[LAMBDA_T] = y[extras + REPORTED_N], y[extras + REPORTED_T]
        _measure(phase, s, _START)
    gap = s.work.scalars[GAP]
    stale_far, stale_near = True, True
    while True:
        if status != 0:
            return Progress(-status, -1, t, h, steps, 0, count, peak), next_sample, start, done
        if t >= t_stop:
            return Progress(AT_STOP, -1, t, h, steps, 0, count, peak), next_sample, t, 0
        if count >= capacity or steps >= most_steps:
            return Progress(BUFFER_FULL, -1, t, h, steps, 0, count, peak), next_sample, start, done
        flying = phase.state == FREE and (not phase.watched or gap > near)
        wanted = far_step if flying else near_step
        if wanted != h:
            start, done, h = t, 0, wanted
        following = start + (done + 1) * h
        cut = following > t_stop - 1e-9 * h
        following = t_stop if cut else following
        length = following - t if cut else h
        slot = ODD if cut else (FAR if flying else NEAR)
        stale = slot == ODD or (stale_far if flying else stale_near)
        status = _step(system, phase, c, t, y, length, slot, stale, s)
        if status != 0:
            continue
        stale_far, stale_near = stale_far and slot != FAR, stale_near and slot != NEAR
        _measure_end(phase, c, y, s)
        guard, whole = -1, length
        if phase.state != FREE or phase.watched:
            guard, status, length = _fall(system, phase, c, t, y, whole, s)
            if status != 0:
                continue
        if guard >= 0 and length <= _LOCATED:
            # it falls with the very first of the step: what the last step left is where the phase ends
            return Progress(AT_GUARD, guard, t, h, steps, 0, count, peak), next_sample, t, 0
        _finish(system, phase, c, t, y, length, s)
        copy(s.y_new, y)
        steps += 1
        peak = max(peak, y[extras + REPORTED_N])
        gap = s.work.scalars[GAP]
        for m in range(2 * d):
            if not abs(y[m]) < _UNBOUNDED:
                return Progress(FAILED_FINITE, -1, t, h, steps, 0, count, peak), next_sample, start, done
        if guard >= 0:
            return Progress(AT_GUARD, guard, t + length, h, steps, 0, count, peak), next_sample, t + length, 0
        for g in range(GUARDS):
            s.armed[g] = s.armed[g] or s.values[_END, g] > s.thresholds[g]
            s.values[_START, g] = s.values[_END, g]
        s.slopes[_START, GUARD_NORMAL] = s.slopes[_END, GUARD_NORMAL]
        t, done = following, done + 1
        if t >= next_sample * output_interval * (1.0 - 1e-12) and t < t_stop:
            s.times[count] = t
            copy(y, s.states[count])
            count += 1
            next_sample = int(t / output_interval * (1.0 + 1e-12)) + 1


class GeneralizedAlphaScheme(Scheme):
    """Generalized-alpha with one step for flight, one for contact and flight close to the slope.

    Parameters
    ----------
    free_step, contact_step : float
        s.
    rho_infinity : float
        Spectral radius at infinite frequency, from 0 (annihilates) to 1 (conserves).
    near : float
        Gap (m) below which a flight takes the contact step: short flights between the impacts of one
        collision carry the vibrations that decide when the next begins.
    tolerance : float
        Of the iterations of a step, on the root of the energy of a correction (J^1/2).
    march : callable
        `march_alpha` itself for a system in plain Python, or its compiled form.
    """

    name = "generalized-alpha"
    order = 2
    stepwise = False

    def __init__(
        self,
        free_step: float,
        contact_step: float,
        rho_infinity: float = 0.8,
        near: float = 0.0,
        tolerance: float = 1e-10,
        march: Any = march_alpha,
    ) -> None:
        self.free_step, self.contact_step, self.near = free_step, contact_step, near
        self.coefficients = coefficients(rho_infinity, tolerance)
        self._march = march
        self._leg = _FIRST_LEG
        self._fresh = True

    def extra_state(self, size: int) -> int:
        """Accelerations, contact forces and rates behind the quadratures."""
        return 3 * size + EXTRAS

    def begin(self, phase: Phase, scratch: Scratch, tolerances: Tolerances, initial_guards: Array) -> None:
        """Arm the guards that start clearly positive; accelerations start anew."""
        arm(phase, scratch, tolerances, initial_guards)
        self._fresh = True

    def march(self, system: Any, phase: Phase, course: Course, t_stop: float, scratch: Scratch) -> Progress:
        """Advance to the next event, or for about a tenth of a second of computing."""
        started = time.perf_counter()
        if self._fresh:
            course.phase_steps = 0
        progress, course.next_sample, course.phase_start, course.phase_steps = self._march(
            system,
            phase,
            self.coefficients,
            course.phase_start,
            course.phase_steps,
            0.0 if self._fresh else course.h,
            course.y,
            self.free_step,
            self.contact_step,
            self.near,
            t_stop,
            course.output_interval,
            course.next_sample,
            self._leg,
            self._fresh,
            scratch,
        )
        self._fresh = progress[0] == AT_GUARD
        progress = Progress(*progress)
        if progress.steps >= self._leg:
            pace = (time.perf_counter() - started) / progress.steps
            self._leg = max(1, int(min(_SECONDS_PER_LEG / pace, 1e6)))
        course.t, course.h = progress.t, progress.h
        return progress
