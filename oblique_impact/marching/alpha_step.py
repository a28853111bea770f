"""One step of generalized-alpha, with the contact forces from the Schur complement of the effective matrix.

Chung and Hulbert, J. Appl. Mech. 60 (1993), in the form of Arnold and Bruels, Multibody Syst. Dyn. 18 (2007):
equilibrium holds at the end of the step, M q'' = Q + D^T lambda, and the algorithmic acceleration a follows by

    (1 - alpha_m) a1 + alpha_m a0 = (1 - alpha_f) q''1 + alpha_f q''0
    q1 = q0 + h q'0 + h^2 ((1/2 - beta) a0 + beta a1),     q'1 = q'0 + h ((1 - gamma) a0 + gamma a1)

Each iteration solves with the constant effective matrix.  A rigid contact is held on the velocity, Z' = 0 (index
2), which keeps the forces well conditioned in the shortest of steps, and then projected onto Z = 0.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import (
    FREE,
    MASS_NOT_POSITIVE,
    NO_SLIDING_SOLUTION,
    NO_STICKING_SOLUTION,
    SLIDING,
    STICKING,
    Phase,
    accelerate,
    stop_force,
    stop_tangent,
)
from oblique_impact.kernels.dense import row_dot
from oblique_impact.kernels.implicit import approach, factor_effective, mass_product, residual, solve_effective
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.system import (
    A_NN,
    A_NT,
    A_TT,
    ACCELERATION,
    DAMPING_POWER,
    FORCES,
    GAP,
    GAP_RATE,
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
from oblique_impact.marching.equations import (
    DAMPING_LOSS,
    NORMAL_IMPULSE,
    QUADRATURES,
    STABILIZATION_LOSS,
    TANGENTIAL_IMPULSE,
    quadrature_rates,
)
from oblique_impact.marching.scheme import (
    FAILED_ITERATION,
    Scratch,
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
        force = stop_force(phase, k[GAP], k[GAP_RATE])
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
        over_depth, over_rate = stop_tangent(phase, k[GAP], k[GAP_RATE])
        stiff = over_depth * position + over_rate * velocity
        force = stop_force(phase, k[GAP], k[GAP_RATE])
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
def take_step(
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
def finish_step(system: Any, phase: Phase, c: Coefficients, t: float, y: Array, h: float, s: Scratch) -> None:
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
    y_new[2 * d + DAMPING_LOSS] += h * _mean_damping_power(system, c, t, y_new, s)
    if rigid or phase.state == STICKING:
        y_new[2 * d + STABILIZATION_LOSS] += _project(system, phase, t + h, work, y_new)


@jitable
def _mean_damping_power(system: Any, c: Coefficients, t: float, y_new: Array, s: Scratch) -> float:
    """Power (W) of damping forces over a step, their mean times the displacement; s.at holds the mean velocity v.

    The displacement is h v but for a step of backward Euler, where it is h times the velocity v1 at the end.
    After an impact v1 is a small part of v if the step does not resolve the damping: v1 C v is not v C v.
    """
    d = s.work.vectors.shape[1]
    q, mean, end = y_new[:d], s.at[:d], y_new[d : 2 * d]
    if not (c.alpha_m == 0.0 and c.alpha_f == 0.0 and c.gamma == 1.0):
        return damping_power(system, t, q, mean, s.work)
    for i in range(d):
        s.at[d + i] = end[i] - mean[i]
        mean[i] += end[i]
    whole = damping_power(system, t, q, mean, s.work)
    return 0.25 * (whole - damping_power(system, t, q, s.at[d : 2 * d], s.work))


@jitable
def _corrections(phase: Phase, k: Array, gap: float, slip: float) -> tuple[float, float]:
    """Multiples of the responses that take a gap and, while sticking, a slip to zero (or their rates)."""
    if phase.state != STICKING:
        return (0.0 if phase.spring > 0.0 else -gap / k[A_NN]), 0.0
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
