"""The end of a step of generalized-alpha: what it keeps, impulses, the balance of energy, the constraints."""

from __future__ import annotations

from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import ACCELERATION, PRODUCT_A, PRODUCT_B, SUPPLY, copy, dot
from oblique_impact.marching.alpha_contacts import project_constraints
from oblique_impact.marching.alpha_state import (
    GAP_RATE,
    HELD,
    MEMORY,
    SHIFTING,
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


@inlined
def finish_step(a: Attempt, h: float, solution: StepSolution) -> None:
    """Complete the state after a converged step of length h: algorithmic acceleration, forces, quadratures.

    Forces at its end are kept already, those to report are in the reported part of the state.
    """
    contacts, c, y, y_new, w = a.contacts, a.c, a.y, a.scratch.y_new, a.scratch.work
    d, acceleration = w.vectors.shape[1], w.vectors[ACCELERATION]
    before, after = algorithm_state(contacts, y, d), algorithm_state(contacts, y_new, d)
    scale, lag = 1.0 / (1.0 - c.alpha_m), c.alpha_f * h
    for i in range(len(contacts.each)):
        keep_kinematics(after, i, lag, contacts.each[i])
    for i in range(d):
        mean = (1.0 - c.alpha_f) * after.acceleration[i] + c.alpha_f * before.acceleration[i]
        after.algorithmic[i] = scale * (mean - c.alpha_m * before.algorithmic[i])
    copy(after.acceleration, acceleration)
    supplied = solution.supplied + dot(w.vectors[SUPPLY], acceleration)
    # damping is sampled at the mean velocity, below: at the ends it is that of vibrations cut short
    rates_into(contacts, 0.0, supplied, y_new[d : 2 * d], after.rates)
    for i in range(after.rates.shape[0]):
        y_new[2 * d + i] = y[2 * d + i] + 0.5 * h * (before.rates[i] + after.rates[i])
    for i in range(len(contacts.each)):
        _take_applied_impulses(a, h, i)
    y_new[2 * d + STABILIZATION_LOSS] += _dissipation(a, h, solution.rank_one)
    y_new[2 * d + DAMPING_LOSS] += h * _mean_damping_power(a, h)
    y_new[2 * d + STABILIZATION_LOSS] += project_constraints(a.system, contacts, a.t + h, w, y_new)


@inlined
def _take_applied_impulses(a: Attempt, h: float, i: int) -> None:
    """Add what contact i contributes: impulses that the algorithm has applied, and the work they do.

    With the applied impulses momentum balances to rounding.
    The force jumps where a contact without inertia begins: the trapezoidal sum of its power is no loss.  Friction
    takes the applied impulse times the mean slip velocity; the dashpot of a contact point without inertia that
    times the change of the gap, less what its spring stores.  By how much the work of the mean forces, that of
    `_dissipation`, differs is the scheme's.
    """
    contact, c, y, y_new, d = a.contacts.each[i], a.c, a.y, a.scratch.y_new, a.scratch.work.vectors.shape[1]
    before, after = algorithm_state(a.contacts, y, d), algorithm_state(a.contacts, y_new, d)
    normal = _applied(c, before, after, h, 2 * i)
    tangential = _applied(c, before, after, h, 2 * i + 1)
    slip_rate = 0.5 * (before.memory[MEMORY * i + SLIP_RATE] + after.memory[MEMORY * i + SLIP_RATE])
    along = 0.5 * h * (before.forces[2 * i + 1] + after.forces[2 * i + 1])
    friction = -tangential * slip_rate
    own = 2 * d + QUADRATURES + OF_A_CONTACT * i
    y_new[own + NORMAL_IMPULSE] = y[own + NORMAL_IMPULSE] + normal
    y_new[own + TANGENTIAL_IMPULSE] = y[own + TANGENTIAL_IMPULSE] + tangential
    y_new[own + FRICTION_LOSS] = y[own + FRICTION_LOSS] + friction
    work = along * _of_displacement(c, before, after, MEMORY * i + SLIP_RATE)
    y_new[2 * d + STABILIZATION_LOSS] += -friction - work
    if contact.compliant and contact.stiffness > 1e300:
        gap_rate = _of_displacement(c, before, after, MEMORY * i + GAP_RATE)
        applied = normal - contact.tilt * tangential
        gained = after.memory[MEMORY * i + HELD] - before.memory[MEMORY * i + HELD]
        shifting = 0.5 * h * (before.memory[MEMORY * i + SHIFTING] + after.memory[MEMORY * i + SHIFTING])
        lost = -applied * gap_rate - gained - shifting
        y_new[own + STOP_LOSS] = y[own + STOP_LOSS] + lost
        mean = 0.5 * h * (before.forces[2 * i] + after.forces[2 * i])
        y_new[2 * d + STABILIZATION_LOSS] += (applied - mean + contact.tilt * along) * gap_rate


@inlined
def _applied(c: Coefficients, before: AlgorithmState, after: AlgorithmState, h: float, k: int) -> float:
    """Impulse (N s) that the algorithm has applied by the contact force number k; keeps its average."""
    mean = (1.0 - c.alpha_f) * after.forces[k] + c.alpha_f * before.forces[k]
    after.averaged[k] = 1.0 / (1.0 - c.alpha_m) * (mean - c.alpha_m * before.averaged[k])
    return float(h * ((1.0 - c.gamma) * before.averaged[k] + c.gamma * after.averaged[k]))


@inlined
def _of_displacement(c: Coefficients, before: AlgorithmState, after: AlgorithmState, which: int) -> float:
    """Displacement of a step over its length (m/s): the mean rate, or the last one of backward Euler."""
    first, last = float(before.memory[which]), float(after.memory[which])
    return last if is_backward_euler(c) else 0.5 * (first + last)


@jitable
def _mean_damping_power(a: Attempt, h: float) -> float:
    """Power (W) of damping forces over a step, their mean times the displacement; s.at holds the mean velocity v.

    The displacement is h v but for a step of backward Euler, where it is h times the velocity v1 at the end.
    Where the force has jumped v1 is a small part of v if the step does not resolve the damping: v1 C v is not
    v C v.
    """
    s, y_new, w = a.scratch, a.scratch.y_new, a.scratch.work
    d = w.vectors.shape[1]
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


@inlined
def _dissipation(a: Attempt, h: float, rank_one: float) -> float:
    """Energy (J) that the algorithm itself takes in a step.

    That is the trapezoidal work of the forces M q'' less the kinetic energy gained.  With the means v of q'
    and A of q'':  h^2 (beta - gamma/2) A.M (a1 - a0) - v.M (q'1 - q'0 - h A).
    """
    s, y, y_new, w = a.scratch, a.y, a.scratch.y_new, a.scratch.work
    d, product_a, product_b = w.vectors.shape[1], w.vectors[PRODUCT_A], w.vectors[PRODUCT_B]
    before, after = algorithm_state(a.contacts, y, d), algorithm_state(a.contacts, y_new, d)
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
