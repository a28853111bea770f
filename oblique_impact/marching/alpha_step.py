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
    MASS_NOT_POSITIVE,
    NO_SLIDING_SOLUTION,
    NO_STICKING_SOLUTION,
    OK,
    accelerate,
    friction_ratio,
    stop_force,
    stop_tangent,
    with_forces,
)
from oblique_impact.contact.state import FREE, SLIDING, STICKING, Instant, Phase, no_instant
from oblique_impact.kernels import rows as row
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array, Evaluation, Workspace, dot
from oblique_impact.marching.equations import (
    DAMPING_LOSS,
    FRICTION_LOSS,
    NORMAL_IMPULSE,
    QUADRATURES,
    STABILIZATION_LOSS,
    TANGENTIAL_IMPULSE,
    quadrature_rates,
)
from oblique_impact.marching.scheme import FAILED_ITERATION, Scratch

NOT_CONVERGED = -FAILED_ITERATION

FAR, NEAR, ODD = 0, 1, 2  # effective matrices of the step in flight, the step in and near contact, a cut step

_MOST_ITERATIONS = 60
_CLOSED = 10.0  # tolerances of velocity: the error of the velocity in a contact that counts as zero
_FADING = 1.05  # a contraction that was not measured counts so much less with every step
_STALLED, _ROUNDING = 0.25, 1e4  # a residual that stays above this part, and corrections in tolerances by rounding
_UNBOUNDED = 1e12


class Coefficients(NamedTuple):
    """Parameters of the scheme."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float


def coefficients(rho_infinity: float) -> Coefficients:
    """Optimal parameters for a spectral radius rho_infinity at infinite frequency (Chung and Hulbert 1993)."""
    alpha_m = (2.0 * rho_infinity - 1.0) / (rho_infinity + 1.0)
    alpha_f = rho_infinity / (rho_infinity + 1.0)
    gamma = 0.5 - alpha_m + alpha_f
    return Coefficients(alpha_m, alpha_f, 0.25 * (gamma + 0.5) ** 2, gamma)


class StepLength(NamedTuple):
    """A step and the factors from q'' to q' and q at its end."""

    h: float  # s
    velocity: float  # s
    position: float  # s^2


@inlined
def step_length(c: Coefficients, h: float) -> StepLength:
    """Return the factors of a step of length h (s)."""
    ratio = (1.0 - c.alpha_f) / (1.0 - c.alpha_m)
    return StepLength(h, h * c.gamma * ratio, h * h * c.beta * ratio)


class Kept(NamedTuple):
    """What the scheme keeps in the state vector, behind the quadratures."""

    reported: Array  # (d + 2,) acceleration and contact forces of the algorithm's own mean
    acceleration: Array  # (d,) q''
    algorithmic: Array  # (d,) a
    forces: Array  # (2,) contact forces (N) at the end of the step
    averaged: Array  # (2,) as the algorithm averages them
    rates: Array  # (7,) of the quadratures
    memory: Array  # (4,) how far the reported forces lag behind (s), slip velocity (m/s), rates of the means (N/s)


LAG, SLIP_RATE, MEAN_RATES = 0, 1, 2
UNKNOWN = 1e300  # a rate of which nothing is known yet


def kept_size(d: int) -> int:
    """Entries of :class:`Kept` for d degrees of freedom."""
    return 3 * d + 2 + 2 + 2 + QUADRATURES + 4


@inlined
def kept_of(y: Array, d: int) -> Kept:
    """Return the parts of the state vector that the scheme keeps."""
    a = 2 * d + QUADRATURES
    b = a + d + 2
    e = b + 2 * d
    return Kept(
        y[a:b],
        y[b : b + d],
        y[b + d : e],
        y[e : e + 2],
        y[e + 2 : e + 4],
        y[e + 4 : e + 4 + QUADRATURES],
        y[e + 4 + QUADRATURES : e + 8 + QUADRATURES],
    )


@jitable
def start_phase(system: Any, phase: Phase, t: float, y: Array, w: Workspace) -> tuple[int, Instant]:
    """Consistent accelerations and contact forces at the start of a phase into what y keeps."""
    d = w.vectors.shape[1]
    qd, kept = y[d : 2 * d], kept_of(y, d)
    status, c = accelerate(system, phase, t, y[:d], qd, w)
    if status != OK:
        return status, c
    acceleration = w.vectors[row.ACCELERATION]
    for i in range(d):
        kept.reported[i] = acceleration[i]
        kept.acceleration[i] = acceleration[i]
        kept.algorithmic[i] = acceleration[i]
    kept.reported[d], kept.reported[d + 1] = c.normal_force, c.tangential_force
    kept.forces[0], kept.forces[1] = c.normal_force, c.tangential_force
    kept.averaged[0], kept.averaged[1] = c.normal_force, c.tangential_force
    kept.memory[LAG], kept.memory[SLIP_RATE] = 0.0, c.slip_rate
    kept.memory[MEAN_RATES], kept.memory[MEAN_RATES + 1] = UNKNOWN, UNKNOWN
    rates = quadrature_rates(phase, c, qd, w)
    for i in range(QUADRATURES):
        kept.rates[i] = rates[i] if i != DAMPING_LOSS else 0.0
    return OK, c


@jitable
def _responding(e: Evaluation, w: Workspace, normal: float, tangential: float) -> Instant:
    """Return the contact of an iteration, with the Delassus entries of the effective matrix."""
    v = w.vectors
    return Instant(
        e.gap,
        e.slip,
        e.gap_rate,
        e.slip_rate,
        dot(v[row.NORMAL], v[row.NORMAL_RESPONSE]),
        dot(v[row.NORMAL], v[row.TANGENTIAL_RESPONSE]),
        dot(v[row.TANGENTIAL], v[row.TANGENTIAL_RESPONSE]),
        0.0,
        0.0,
        normal,
        tangential,
        0.0,
        e.supplied_power,
    )


@inlined
def _moved(c: Instant, e: Evaluation, normal: float, tangential: float) -> Instant:
    """Return the contact with other kinematics and forces (N) and the same Delassus entries."""
    return Instant(
        e.gap,
        e.slip,
        e.gap_rate,
        e.slip_rate,
        c.a_nn,
        c.a_nt,
        c.a_tt,
        0.0,
        0.0,
        normal,
        tangential,
        0.0,
        e.supplied_power,
    )


@jitable
def _contact_defect(phase: Phase, c: Instant, velocity: float) -> float:
    """How far the contact forces and the motion are from the contact's laws (m/s)."""
    normal, tangential = abs(c.gap_rate), abs(c.slip_rate)
    if phase.gives_way:
        normal = abs(stop_force(phase, c.gap, c.gap_rate) - c.normal_force) * c.a_nn * velocity
    if phase.state != STICKING:
        wanted = friction_ratio(phase, c.slip_rate) * c.normal_force
        tangential = abs(wanted - c.tangential_force) * c.a_tt * velocity
    return float(max(normal, tangential))


@jitable
def _contact_step(phase: Phase, c: Instant, w: Workspace, step: StepLength) -> tuple[int, float, float]:
    """Newton step of the two contact forces in an iteration, also into increment and residual; its status."""
    v, velocity = w.vectors, step.velocity
    normal, tangential = dot(v[row.NORMAL], v[row.INCREMENT]), dot(v[row.TANGENTIAL], v[row.INCREMENT])
    # n1 dn + n2 dt = n3,  t1 dn + t2 dt = t3
    if phase.gives_way:
        over_depth, over_rate = stop_tangent(phase, c.gap, c.gap_rate)
        stiff = over_depth * step.position + over_rate * velocity
        force = stop_force(phase, c.gap, c.gap_rate)
        n1, n2 = 1.0 + stiff * c.a_nn, stiff * c.a_nt
        n3 = force - c.normal_force - stiff * normal
    else:
        n1, n2 = velocity * c.a_nn, velocity * c.a_nt
        n3 = -c.gap_rate - velocity * normal
    if phase.state == SLIDING:
        ratio = friction_ratio(phase, c.slip_rate)
        if not phase.gives_way and not c.a_nn + ratio * c.a_nt > 0.0:
            return NO_SLIDING_SOLUTION, 0.0, 0.0
        viscous = phase.slope * c.normal_force * velocity
        t1, t2 = -ratio - viscous * c.a_nt, 1.0 - viscous * c.a_tt
        t3 = ratio * c.normal_force - c.tangential_force + viscous * tangential
    else:
        t1, t2, t3 = velocity * c.a_nt, velocity * c.a_tt, -c.slip_rate - velocity * tangential
    determinant = n1 * t2 - n2 * t1
    if determinant == 0.0:
        return NO_STICKING_SOLUTION, 0.0, 0.0
    dn, dt = (n3 * t2 - n2 * t3) / determinant, (n1 * t3 - n3 * t1) / determinant
    for i in range(v.shape[1]):
        v[row.INCREMENT, i] += dn * v[row.NORMAL_RESPONSE, i] + dt * v[row.TANGENTIAL_RESPONSE, i]
        v[row.RESIDUAL, i] += dn * v[row.NORMAL, i] + dt * v[row.TANGENTIAL, i]
    return OK, dn, dt


@jitable
def _predict(c: Coefficients, y: Array, h: float, d: int, y_new: Array) -> None:
    """Position and velocity for an unchanged acceleration q''."""
    before, after = kept_of(y, d), kept_of(y_new, d)
    for i in range(d):
        kept, a0 = before.acceleration[i], before.algorithmic[i]
        a1 = ((1.0 - c.alpha_f) * kept + c.alpha_f * kept - c.alpha_m * a0) / (1.0 - c.alpha_m)
        y_new[i] = y[i] + h * y[d + i] + h * h * ((0.5 - c.beta) * a0 + c.beta * a1)
        y_new[d + i] = y[d + i] + h * ((1.0 - c.gamma) * a0 + c.gamma * a1)
        after.acceleration[i] = kept


@jitable
def _add_contact(phase: Phase, normal: float, tangential: float, w: Workspace) -> float:
    """Add the contact forces to the residual; its largest entry."""
    v, largest = w.vectors, 0.0
    if phase.state != FREE:
        for i in range(v.shape[1]):
            v[row.RESIDUAL, i] += normal * v[row.NORMAL, i] + tangential * v[row.TANGENTIAL, i]
    for i in range(v.shape[1]):
        largest = max(largest, abs(v[row.RESIDUAL, i]))
    return largest


class Step(NamedTuple):
    """What a step of the scheme returns besides the new state vector."""

    status: int  # OK, the reason why there is no solution, or NOT_CONVERGED
    end: Instant  # the contact at its end, with its forces
    rank_one: float  # of the mass matrix at its end, see `Evaluation`


@jitable
def take_step(
    system: Any,
    phase: Phase,
    c: Coefficients,
    tolerance: float,
    t: float,
    y: Array,
    h: float,
    slot: int,
    stale: bool,
    s: Scratch,
) -> Step:
    """One step of length h from (t, y) into s.y_new.

    `tolerance` (J^1/2) is that of the iterations, on the root of the energy of a correction.
    """
    d, w, y_new = s.work.vectors.shape[1], s.work, s.y_new
    step, v, contact = step_length(c, h), s.work.vectors, phase.state != FREE
    q, qd, qdd = y_new[:d], y_new[d : 2 * d], kept_of(y_new, d).acceleration
    _predict(c, y, h, d, y_new)
    forces = kept_of(y, d).forces
    normal, tangential = (forces[0], forces[1]) if contact else (0.0, 0.0)
    s.contraction[slot] = -1.0 if stale else _FADING * s.contraction[slot]
    closed, end = _CLOSED * s.tolerances.velocity, no_instant()
    change, before, rank_one = np.inf, 0.0, 0.0
    for iteration in range(_MOST_ITERATIONS):
        e = system.take_residual(t + h, q, qd, qdd, contact, w)
        rank_one, end = e.rank_one, _moved(end, e, normal, tangential)
        left = _add_contact(phase, normal, tangential, w)
        if iteration == 0:
            if not system.factor_effective(t + h, q, step.velocity, step.position, w, slot, stale):
                return Step(MASS_NOT_POSITIVE, end, rank_one)
        else:
            # the next change is about the last one times the ratio of the residuals
            s.contraction[slot] = left / before if before > 0.0 else -1.0
            accurate = change * left <= tolerance * before
            if not accurate and left > _STALLED * before:
                # the residual K q of a fine mesh is rounded: it falls no further
                accurate = change <= _ROUNDING * tolerance
            if accurate and (not contact or _contact_defect(phase, end, step.velocity) <= closed):
                if not contact and phase.watched:
                    end = _moved(end, system.approach(t + h, q, qd, w), 0.0, 0.0)
                return Step(OK, end, rank_one)
            if not left < _UNBOUNDED:
                return Step(NOT_CONVERGED, end, rank_one)
        system.solve_effective(rank_one, w, slot, contact)
        if contact:
            end = _responding(e, w, normal, tangential)
            status, pressing, along = _contact_step(phase, end, w, step)
            if status != OK:
                return Step(status, end, rank_one)
            normal += pressing
            tangential += along
        before = left
        change = step.velocity * np.sqrt(abs(dot(v[row.INCREMENT], v[row.RESIDUAL])))
        for i in range(d):
            more = v[row.INCREMENT, i]
            qdd[i] += more
            q[i] += step.position * more
            qd[i] += step.velocity * more
        if 0.0 < change * s.contraction[slot] <= tolerance:
            # known well enough from the last steps; what is known fades, and is measured anew before long
            end = _moved(end, system.approach(t + h, q, qd, w), normal, tangential)
            if not contact or _contact_defect(phase, end, step.velocity) <= closed:
                return Step(OK, end, rank_one)
    return Step(NOT_CONVERGED, end, rank_one)


@jitable
def finish_step(
    system: Any, phase: Phase, c: Coefficients, t: float, y: Array, h: float, step: Step, s: Scratch
) -> Instant:
    """Complete s.y_new after a converged step: algorithmic acceleration, averaged forces, quadratures.

    Forces to report are in `step`, those at its end in s.y_new.  Returns the contact there.
    """
    d, w, y_new = s.work.vectors.shape[1], s.work, s.y_new
    v, before, after = w.vectors, kept_of(y, d), kept_of(y_new, d)
    scale, end = 1.0 / (1.0 - c.alpha_m), step.end
    rigid = phase.state != FREE and not phase.gives_way
    for i in range(d):
        mean = (1.0 - c.alpha_f) * after.acceleration[i] + c.alpha_f * before.acceleration[i]
        after.algorithmic[i] = scale * (mean - c.alpha_m * before.algorithmic[i])
        after.reported[i] = mean if rigid else after.acceleration[i]
        v[row.ACCELERATION, i] = after.acceleration[i]
    after.reported[d], after.reported[d + 1] = end.normal_force, end.tangential_force
    after.memory[LAG], after.memory[SLIP_RATE] = c.alpha_f * h, end.slip_rate
    supplied = end.supplied_power + dot(v[row.SUPPLY], v[row.ACCELERATION])
    last = with_forces(end, after.forces[0], after.forces[1], supplied)
    # damping is sampled at the mean velocity, below: at the ends it is that of vibrations cut short
    rates = quadrature_rates(phase, last, y_new[d : 2 * d], w)
    for i in range(QUADRATURES):
        after.rates[i] = rates[i] if i != DAMPING_LOSS else 0.0
        y_new[2 * d + i] = y[2 * d + i] + 0.5 * h * (before.rates[i] + after.rates[i])
    _take_applied_impulses(c, y, h, d, y_new)
    y_new[2 * d + STABILIZATION_LOSS] += _dissipation(system, c, y, h, step.rank_one, s)
    y_new[2 * d + DAMPING_LOSS] += h * _mean_damping_power(system, c, t, y_new, s)
    if rigid or phase.state == STICKING:
        y_new[2 * d + STABILIZATION_LOSS] += _project(system, phase, t + h, end, w, y_new)
    return last


@jitable
def _take_applied_impulses(c: Coefficients, y: Array, h: float, d: int, y_new: Array) -> None:
    """Impulses that the algorithm has applied, so that momentum balances to rounding, and the friction they do.

    The force is singular where a rigid contact of a damped beam begins: the trapezoidal sum of its power is no
    friction loss.  That is the applied impulse times the mean slip velocity; the difference is the scheme's.
    """
    before, after, scale = kept_of(y, d), kept_of(y_new, d), 1.0 / (1.0 - c.alpha_m)
    for k in range(2):
        mean = (1.0 - c.alpha_f) * after.forces[k] + c.alpha_f * before.forces[k]
        after.averaged[k] = scale * (mean - c.alpha_m * before.averaged[k])
        applied = h * ((1.0 - c.gamma) * before.averaged[k] + c.gamma * after.averaged[k])
        place = 2 * d + (NORMAL_IMPULSE if k == 0 else TANGENTIAL_IMPULSE)
        y_new[place] = y[place] + applied
        if k == 1:
            summed = y_new[2 * d + FRICTION_LOSS] - y[2 * d + FRICTION_LOSS]
            done = -applied * 0.5 * (before.memory[SLIP_RATE] + after.memory[SLIP_RATE])
            y_new[2 * d + FRICTION_LOSS] = y[2 * d + FRICTION_LOSS] + done
            y_new[2 * d + STABILIZATION_LOSS] += summed - done


@jitable
def _mean_damping_power(system: Any, c: Coefficients, t: float, y_new: Array, s: Scratch) -> float:
    """Power (W) of damping forces over a step, their mean times the displacement; s.at holds the mean velocity v.

    The displacement is h v but for a step of backward Euler, where it is h times the velocity v1 at the end.
    After an impact v1 is a small part of v if the step does not resolve the damping: v1 C v is not v C v.
    """
    d = s.work.vectors.shape[1]
    q, mean, end = y_new[:d], s.at[:d], y_new[d : 2 * d]
    if not (c.alpha_m == 0.0 and c.alpha_f == 0.0 and c.gamma == 1.0):
        return float(system.damping_at(t, q, mean, s.work))
    for i in range(d):
        s.at[d + i] = end[i] - mean[i]
        mean[i] += end[i]
    whole = system.damping_at(t, q, mean, s.work)
    return float(0.25 * (whole - system.damping_at(t, q, s.at[d : 2 * d], s.work)))


@jitable
def _corrections(phase: Phase, c: Instant, gap: float, slip: float) -> tuple[float, float]:
    """Multiples of the responses that take a gap and, while sticking, a slip to zero (or their rates)."""
    if phase.state != STICKING:
        return (0.0 if phase.gives_way else -gap / c.a_nn), 0.0
    if phase.gives_way:
        return 0.0, -slip / c.a_tt
    determinant = c.a_nn * c.a_tt - c.a_nt * c.a_nt
    return (c.a_nt * slip - c.a_tt * gap) / determinant, (c.a_nt * gap - c.a_nn * slip) / determinant


@jitable
def _project(system: Any, phase: Phase, t: float, c: Instant, w: Workspace, y: Array) -> float:
    """Move q, then q', onto the constraints of a contact along the responses of the step; the work done (J).

    The velocity is left exact to rounding, because a step cut short divides what is left by its length.
    """
    d, v, done = w.vectors.shape[1], w.vectors, 0.0
    normal, tangential = _corrections(phase, c, c.gap, c.slip - phase.slip_reference)
    for i in range(d):
        move = normal * v[row.NORMAL_RESPONSE, i] + tangential * v[row.TANGENTIAL_RESPONSE, i]
        y[i] += move
        done += v[row.FORCES, i] * move
    e = system.approach(t, y[:d], y[d : 2 * d], w)
    normal, tangential = _corrections(phase, c, e.gap_rate, e.slip_rate)
    for i in range(d):
        y[d + i] += normal * v[row.NORMAL_RESPONSE, i] + tangential * v[row.TANGENTIAL_RESPONSE, i]
    return done


@jitable
def _dissipation(system: Any, c: Coefficients, y: Array, h: float, rank_one: float, s: Scratch) -> float:
    """Energy (J) that the algorithm itself takes in a step.

    That is the trapezoidal work of the forces M q'' less the kinetic energy gained.  With the means v of q'
    and A of q'':  h^2 (beta - gamma/2) A.M (a1 - a0) - v.M (q'1 - q'0 - h A).
    """
    d, w, y_new = s.work.vectors.shape[1], s.work, s.y_new
    v, before, after = w.vectors, kept_of(y, d), kept_of(y_new, d)
    for i in range(d):
        s.at[i] = 0.5 * (y[d + i] + y_new[d + i])
        s.at[d + i] = 0.5 * (before.acceleration[i] + after.acceleration[i])
    system.mass_product(rank_one, w, s.at[:d], v[row.PRODUCT_A])
    system.mass_product(rank_one, w, s.at[d : 2 * d], v[row.PRODUCT_B])
    curved, lagging = 0.0, 0.0
    for i in range(d):
        curved += v[row.PRODUCT_B, i] * (after.algorithmic[i] - before.algorithmic[i])
        lagging += v[row.PRODUCT_A, i] * (y_new[d + i] - y[d + i] - h * s.at[d + i])
    return h * h * (c.beta - 0.5 * c.gamma) * curved - lagging
