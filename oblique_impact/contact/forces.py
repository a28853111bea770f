"""Forces of all contacts at once, each in its state.

The force of a rigid contact follows from the constraint on the acceleration level with Baumgarte's
stabilization, Z'' + c Z' + k Z = 0 (Yuan et al. 2016, Secs. 4 and 5; Baumgarte 1972).  With the
Delassus entries A_nn = D_n M^-1 D_n^T, A_nt, A_tt:

    SLIP    lambda_tau = r lambda_n,  r = intercept + slope Z_tau'
            (A_nn + r A_nt) lambda_n = -(Z_n''free + c Z_n' + k Z_n)
    STICK   both constraints at once, a 2 x 2 system

which is what one contact alone has; of several all unknown forces follow from one system of equations.

An elastic contact has no normal constraint: its force is a function of depth and rate
(:mod:`oblique_impact.contact.elastic`).  Friction and stick are the same.

What the coordinates leave out of a body moves its place of contact along the tangent as well: by the forces on
compliances C_nn and C_tn and a stop of stiffness k the slip is Z_tau + t Z_n, t = -C_tn/(1/k + C_nn), on a rigid
side that the body meets at the angle beta tan beta (`incline`).  The force conjugate to Z_n is
N = lambda_n - t lambda_tau, and with lambda_tau = r lambda_n the contact's laws read lambda_tau = r N/(1 - r t).
With the row D_tau + t D_n of this slip the forces N and lambda_tau act as those of any contact: N is what
`Candidate.normal_force` holds, lambda_n what is reported.

The factor A_nn + r A_nt is the effective inverse normal mass of the sliding contact; where it is not
positive the forward problem has no solution (Painleve), or the contact opens, also where it could hold.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.elastic import bears, is_pushed, press, softness, stop_force, take_boundary_power
from oblique_impact.contact.state import (
    DIRECTION,
    FREE,
    GUARDS,
    LOWER,
    RESPONSE,
    SLIDING,
    STICKING,
    UPPER,
    Candidate,
    Contacts,
    Guards,
)
from oblique_impact.kernels.dense import eliminate
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.laws import Law
from oblique_impact.kernels.system import System
from oblique_impact.kernels.workspace import (
    ACCELERATION,
    FORCES,
    FREE_ACCELERATION,
    SUPPLY,
    Array,
    Workspace,
    add,
    copy,
    dot,
)

#: status of a solution of the contact problem
OK, MASS_NOT_POSITIVE, NO_SLIDING_SOLUTION, NO_STICKING_SOLUTION = 0, 1, 2, 3

#: relative determinant of the 2 x 2 system of a sticking contact, which is rounding where it is smaller
SINGULAR = 1e-13
#: relative effective inverse mass at which sliding ends: the force grows as its inverse, and steps up to 0 would
#: shrink without end
NEARLY_PAINLEVE = 1e-9


class Forces(NamedTuple):
    """Contact forces (N), or the reason why there are none."""

    status: int
    normal: float  # conjugate to the gap
    tangential: float


# --- friction and stick of one contact


@inlined
def friction_ratio(c: Candidate) -> float:
    """lambda_tau / N of a sliding contact, N = lambda_n - tilt lambda_tau; see `can_slide`."""
    ratio = c.intercept + c.slope * c.slip_rate
    return ratio / (1.0 - ratio * c.tilt)


@inlined
def can_slide(c: Candidate) -> bool:
    """Whether the force of an elastic contact can push its place while it slides."""
    return (c.intercept + c.slope * c.slip_rate) * c.tilt < 1.0 - NEARLY_PAINLEVE


@inlined
def lambda_n(c: Candidate) -> float:
    """Return the normal force (N) of a contact, lambda_n = N + tilt lambda_tau."""
    return c.normal_force + c.tilt * c.tangential_force


@inlined
def drift_of(c: Candidate) -> float:
    """Slip (m) of a sticking contact from where it is held."""
    return (c.slip - c.kept_slip) * c.held


@inlined
def travelled(c: Candidate) -> float:
    """Return the integral of the slip velocity (m): the slip, or of a point that rolls its travel."""
    return c.slip if c.held != 0.0 else c.travel


@inlined
def axial_force(c: Candidate, travel: float) -> float:
    """Tangential force (N) of a contact that sticks on the axial flexibility alone, at its travel (m)."""
    return (c.kept_slip - travel) / c.axial


@inlined
def follows(c: Candidate) -> bool:
    """Whether the rate of a contact's friction follows from that of its depth: on a stop that nothing damps."""
    return bool(c.compliant and c.damping == 0.0 and c.linear_damping == 0.0 and c.relaxation == 0.0)


@inlined
def friction_rate(c: Candidate) -> float:
    """Rate of the friction (N/s) of a contact that slides on an elastic stop without damping, or begins to."""
    own = softness(c)
    rate = c.depth_rate
    pushing = 1.0 + c.damping * rate * own / (own + c.compliance)
    ratio = c.intercept / (1.0 - c.intercept * c.tilt)
    return ratio * rate / (own / pushing + c.compliance) if pushing > 0.0 else 0.0


@inlined
def begins_with_a_jump(c: Candidate) -> bool:
    """Whether the force of an elastic contact is not zero where it begins, by its dashpot or that of the body."""
    return c.linear_damping > 0.0 or (c.relaxation > 0.0 and c.compliance > 0.0)


@inlined
def slip_velocity(c: Candidate) -> float:
    """Velocity (m/s) that friction sees while a contact slides, as its force stretches the axis."""
    if c.axial == 0.0 or not follows(c):  # see `add_stretch`
        return c.slip_rate
    return c.slip_rate + c.axial * friction_rate(c)


@inlined
def sliding_inertia(c: Candidate) -> float:
    """Effective inverse normal mass (1/kg) of a contact that slides on a rigid stop, which may be negative."""
    return c.a_nn + friction_ratio(c) * c.a_nt


@inlined
def stabilized(c: Candidate) -> float:
    """Acceleration of the gap (m/s^2) that the force of a rigid stop takes up."""
    return c.gap_acceleration + c.correct_rate * c.gap_rate + c.correct_place * c.gap


@jitable
def sliding_force(law: Law | None, c: Candidate) -> Forces:
    """Contact force of a sliding contact, 0 of one that opens; NO_SLIDING_SOLUTION if Painleve.

    Where the effective inverse mass is not positive a gap that grows without force solves the problem, perhaps
    among others.
    """
    ratio = friction_ratio(c)
    if c.compliant:
        if not can_slide(c):
            return Forces(NO_SLIDING_SOLUTION, 0.0, 0.0)
        push = stop_force(law, c, c.depth, c.depth_rate)
        return Forces(OK, push, ratio * push)
    effective = sliding_inertia(c)
    if not effective > 0.0:
        return Forces(OK if stabilized(c) >= 0.0 else NO_SLIDING_SOLUTION, 0.0, 0.0)
    normal = -stabilized(c) / effective
    return Forces(OK, normal, ratio * normal)


@jitable
def sticking_force(law: Law | None, c: Candidate) -> Forces:
    """Both forces of a contact that sticks; NO_STICKING_SOLUTION if the constraints are redundant."""
    if c.axial != 0.0:
        hold = axial_force(c, travelled(c))
        if not c.compliant:
            return Forces(OK, -(stabilized(c) + c.a_nt * hold) / c.a_nn, hold)
        return Forces(OK, stop_force(law, c, c.depth, c.depth_rate), hold)
    return holding_force(law, c, c.correct_rate * c.slip_rate + c.correct_place * drift_of(c))


@jitable
def holding_force(law: Law | None, c: Candidate, correction: float) -> Forces:
    """Both forces that keep the gap and give the slip the acceleration -correction (m/s^2)."""
    tangential = c.slip_acceleration + correction
    if c.compliant:
        if not c.a_tt > 0.0:
            return Forces(NO_STICKING_SOLUTION, 0.0, 0.0)
        push = stop_force(law, c, c.depth, c.depth_rate)
        return Forces(OK, push, -(tangential + c.a_nt * push) / c.a_tt)
    determinant = c.a_nn * c.a_tt - c.a_nt * c.a_nt
    if not determinant > SINGULAR * c.a_nn * c.a_tt:
        return Forces(NO_STICKING_SOLUTION, 0.0, 0.0)
    normal = stabilized(c)
    return Forces(
        OK,
        (c.a_nt * tangential - c.a_tt * normal) / determinant,
        (c.a_nt * normal - c.a_nn * tangential) / determinant,
    )


@jitable
def contact_force(law: Law | None, c: Candidate) -> Forces:
    """Contact force of a closed contact in its state, if it is alone."""
    return sliding_force(law, c) if c.state == SLIDING else sticking_force(law, c)


@jitable
def can_stick(law: Law | None, c: Candidate, stopping_time: float) -> bool:
    """Whether contact sticks, for a scheme that does not locate the end of slip.

    The force that keeps it sticking lies in the friction cone, and the sliding force stops the slip within
    `stopping_time` (s) or has done so.  With an infinite time the slip velocity is not asked for, as the paper
    writes in Sec. 5.3; the force is then that of the stabilized constraint.
    """
    correction = 0.0
    if stopping_time < 1e300:
        if c.state == SLIDING:
            acceleration = c.slip_acceleration + c.a_nt * c.normal_force + c.a_tt * c.tangential_force
            ahead = c.slip_rate + stopping_time * acceleration
            direction = 1.0 if c.lower >= 0.0 else -1.0
            if c.slip_rate * direction > 0.0 and ahead * direction > 0.0:
                return False
    else:
        drift = drift_of(c) if c.state == STICKING else 0.0
        correction = c.correct_rate * c.slip_rate + c.correct_place * drift
    force = holding_force(law, c, correction)
    normal = force.normal + c.tilt * force.tangential
    return force.status == OK and normal > 0.0 and abs(force.tangential) <= c.static * normal


@jitable
def guards_of(c: Candidate) -> Guards:
    """Guards of the state at an instant with its forces; 1 where a state has none."""
    if c.state == FREE:
        return Guards(-c.side * c.depth if c.enabled else 1.0, 1.0, 1.0, 1.0, 1.0)
    end = 1.0
    if c.last < 1e300:  # about the distance from the nearer end, but smooth
        end = (c.slip - c.first) * (c.last - c.slip) / (c.last - c.first)
    push = lambda_n(c)
    normal = c.depth if c.compliant else push
    if c.state == SLIDING:
        rate = slip_velocity(c) + c.stretching
        return Guards(
            normal,
            rate - c.lower if c.lower > -1e300 else 1.0,
            c.upper - rate if c.upper < 1e300 else 1.0,
            # of a compliant stop it is decided as the slip begins
            1.0 if c.compliant else c.definite - NEARLY_PAINLEVE,
            end,
        )
    limit = c.static * push  # of the friction cone
    return Guards(normal, limit - c.tangential_force, limit + c.tangential_force, 1.0, end)


# --- all contacts


@inlined
def touch_contacts(system: System, contacts: Contacts, t: float, q: Array, qd: Array, w: Workspace) -> int:
    """Kinematics and rows of all candidates, and no force of those in flight; returns how many are closed."""
    each, rows, closed = contacts.each, contacts.rows, 0
    system.take_state(t, q, qd, w)
    for i in range(len(each)):
        system.touch(i, t, q, qd, w, each[i], rows[DIRECTION, i])
    press(contacts)
    for i in range(len(each)):
        c = each[i]
        if c.state == FREE:
            c.normal_force = 0.0
            c.tangential_force = 0.0
            continue
        closed += 1
        take_boundary_power(c, rows[DIRECTION, i], qd)
        if bears(c) and (c.tilt != 0.0 or c.tilt_slope != 0.0):
            incline(c, rows[DIRECTION, i])
    return closed


class Touched(NamedTuple):
    """A candidate of contact with its rows."""

    contact: Candidate
    normal: Array  # (d,) D_n
    tangential: Array  # (d,) D_tau


def touched(system: Any, i: int, t: float, q: Array, qd: Array, w: Workspace) -> Touched:
    """Return candidate i at (t, q, q') with its rows, in plain Python."""
    found, rows = Candidate(), np.zeros((2, q.size))
    system.take_state(t, q, qd, w)
    system.touch(i, t, q, qd, w, found, rows)
    return Touched(found, *rows)


@jitable
def incline(c: Candidate, rows: Array) -> None:
    """Take the slip of a contact whose place slips as the body yields, Z_tau + tilt Z_n, into its rows (3, d)."""
    t, turned, turning = c.tilt, c.tilt_slope * c.gap, c.shift_rate
    c.slip += t * c.gap
    c.slip_rate += t * c.gap_rate + turned * turning
    c.slip_bias += t * c.gap_bias + 2.0 * c.tilt_slope * turning * c.gap_rate
    c.slip_bias += turned * c.shift_bias + c.tilt_bend * turning * turning * c.gap
    for j in range(rows.shape[1]):
        rows[1, j] += t * rows[0, j] + turned * rows[2, j]


@inlined
def take_delassus(contacts: Contacts, free: Array) -> None:
    """Delassus entries and accelerations of the closed contacts, whose rows are solved for; no force yet."""
    each, rows = contacts.each, contacts.rows
    for i in range(len(each)):
        c = each[i]
        if c.state != FREE:
            normal, tangential = rows[DIRECTION, i, 0], rows[DIRECTION, i, 1]
            c.a_nn = dot(normal, rows[RESPONSE, i, 0])
            c.a_nt = dot(normal, rows[RESPONSE, i, 1])
            c.a_tt = dot(tangential, rows[RESPONSE, i, 1])
            c.gap_acceleration = dot(normal, free) + c.gap_bias
            c.slip_acceleration = dot(tangential, free) + c.slip_bias
            c.normal_force = 0.0
            c.tangential_force = 0.0


@inlined
def add_push(contacts: Contacts, w: Workspace) -> None:
    """Add the forces by the change of compliances to the generalized forces."""
    if is_pushed(contacts):
        add(contacts.push, w.vectors[FORCES])


@inlined
def accelerate(
    system: System, contacts: Contacts, t: float, q: Array, qd: Array, w: Workspace
) -> tuple[int, float, float]:
    """Acceleration at (t, q, q') into the workspace, contact forces into their records.

    Returns the status, OK or the reason why there is no solution, and the powers (W) that damping takes out and
    drives put in.
    """
    e, v = system.evaluate(t, q, qd, w), w.vectors
    closed = touch_contacts(system, contacts, t, q, qd, w)
    if closed > 0:
        add_push(contacts, w)
    if not system.solve_mass(e.rank_one, w, contacts, closed > 0):
        return MASS_NOT_POSITIVE, e.damping_power, e.supplied_power
    free, acceleration, status = v[FREE_ACCELERATION], v[ACCELERATION], OK
    if closed > 0:
        take_delassus(contacts, free)
    copy(free, acceleration)
    if closed > 0:
        status = solve_forces(contacts, closed, acceleration)
    return status, e.damping_power, e.supplied_power + dot(v[SUPPLY], acceleration)


@inlined
def is_free(contacts: Contacts) -> bool:
    """Whether no contact is closed."""
    free = True
    for i in range(len(contacts.each)):
        free = free and contacts.each[i].state == FREE
    return free


@inlined
def nearest(contacts: Contacts) -> tuple[float, float]:
    """Smallest distance (m) of a candidate in flight and largest gap rate (m/s) of any."""
    least, fastest = 1e300, 0.0
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        if c.state == FREE and c.enabled:
            least = min(least, c.side * c.gap)
        fastest = max(fastest, abs(c.gap_rate))
    return least, fastest


@inlined
def solve_forces(contacts: Contacts, closed: int, acceleration: Array) -> int:
    """Solve for the forces of the closed contacts and add them to the acceleration; returns the status.

    What one contact alone has is known in closed form.
    """
    if closed > 1:
        return _solve_coupled(contacts.matrix, contacts, acceleration)
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        if c.state == FREE:
            continue
        if c.state == SLIDING and not c.compliant:
            c.definite = sliding_inertia(c) / c.a_nn
        force = contact_force(contacts.law, c)
        if force.status != OK:
            return force.status
        c.normal_force = force.normal
        c.tangential_force = force.tangential
        _push(contacts, i, force.normal, force.tangential, acceleration)
    return OK


@inlined
def _push(contacts: Contacts, i: int, normal: float, tangential: float, acceleration: Array) -> None:
    """Add what forces (N) of a contact do to the acceleration."""
    to_normal, to_tangential = contacts.rows[RESPONSE, i, 0], contacts.rows[RESPONSE, i, 1]
    for j in range(acceleration.shape[0]):
        acceleration[j] += to_normal[j] * normal + to_tangential[j] * tangential


@jitable
def _solve_coupled(matrix: Array | None, contacts: Contacts, acceleration: Array) -> int:
    """Solve for the forces of several closed contacts, see `solve_forces`; the compiler drops this of one.

    Those of compliant stops are known, with their friction; the others by Gauss's elimination in the order of the
    contacts: its pivots are the effective inverse masses, which are positive where the problem has one solution.
    """
    if matrix is None:
        return OK
    each, m = contacts.each, 0
    for i in range(len(each)):
        c = each[i]
        c.normal_unknown = -1
        c.tangential_unknown = -1
        if c.state == FREE:
            continue
        if not c.compliant:
            c.normal_unknown = m
            m += 1
        else:
            c.normal_force = stop_force(contacts.law, c, c.depth, c.depth_rate)
            c.tangential_force = friction_ratio(c) * c.normal_force if c.state == SLIDING else 0.0
            _push(contacts, i, c.normal_force, c.tangential_force, acceleration)
        if c.state == STICKING:
            c.tangential_unknown = m
            m += 1
    for i in range(len(each)):
        c = each[i]
        if c.normal_unknown >= 0:
            _constrain(
                matrix, contacts, i, 0, c.normal_unknown, m, stabilized(c) - c.gap_acceleration, acceleration
            )
        if c.tangential_unknown >= 0:
            if c.axial != 0.0:
                _hold_axially(matrix, contacts, i, c.tangential_unknown, m)
            else:
                correction = c.correct_rate * c.slip_rate + c.correct_place * drift_of(c)
                _constrain(matrix, contacts, i, 1, c.tangential_unknown, m, correction, acceleration)
    for i in range(len(each)):
        status = _reduce(each[i], matrix, m)
        if status != OK:
            return status
    for k in range(m - 1, -1, -1):
        force = matrix[k, m]
        for column in range(k + 1, m):
            force -= matrix[k, column] * matrix[column, m]
        matrix[k, m] = force / matrix[k, k]
    for i in range(len(each)):
        c = each[i]
        normal, tangential = 0.0, 0.0
        if c.normal_unknown >= 0:
            normal = matrix[c.normal_unknown, m]
            tangential = friction_ratio(c) * normal if c.state == SLIDING else 0.0
        if c.tangential_unknown >= 0:
            tangential = matrix[c.tangential_unknown, m]
        if c.state != FREE:
            c.normal_force += normal
            c.tangential_force += tangential
            _push(contacts, i, normal, tangential, acceleration)
    return OK


@jitable
def _reduce(c: Candidate, matrix: Array, m: int) -> int:
    """Eliminate the unknown forces of a contact from the equations after its own; returns the status."""
    for side in range(2):
        k = c.normal_unknown if side == 0 else c.tangential_unknown
        if k < 0:
            continue
        own = c.a_nn
        if side == 1:
            own = c.axial if c.axial != 0.0 else c.a_tt
        pivot = matrix[k, k]
        if side == 0:
            c.definite = pivot / own
        if not pivot > SINGULAR * own:
            return NO_SLIDING_SOLUTION if c.state == SLIDING and c.intercept != 0.0 else NO_STICKING_SOLUTION
        for r in range(k + 1, m):
            factor = matrix[r, k] / pivot
            for column in range(k + 1, m + 1):
                matrix[r, column] -= factor * matrix[k, column]
    return OK


@jitable
def _constrain(
    matrix: Array, contacts: Contacts, i: int, side: int, k: int, m: int, correction: float, acceleration: Array
) -> None:
    """Put the equation of unknown k, of the normal (0) or tangential (1) row of contact i, into the matrix."""
    each, row = contacts.each, contacts.rows[DIRECTION, i, side]
    for j in range(len(each)):
        other, to_normal, to_tangential = each[j], contacts.rows[RESPONSE, j, 0], contacts.rows[RESPONSE, j, 1]
        if other.normal_unknown >= 0:
            entry = dot(row, to_normal)
            if other.state == SLIDING:
                entry += friction_ratio(other) * dot(row, to_tangential)
            matrix[k, other.normal_unknown] = entry
        if other.tangential_unknown >= 0:
            matrix[k, other.tangential_unknown] = dot(row, to_tangential)
    bias = each[i].gap_bias if side == 0 else each[i].slip_bias
    matrix[k, m] = -(dot(row, acceleration) + bias + correction)


# --- axial flexibility behind the friction


@inlined
def shared_flexibility(c: Candidate, other: Candidate) -> float:
    """Displacement (m/N) along the tangent of one contact by a force along that of another."""
    return c.sense * other.sense * min(c.axial, other.axial)


@jitable
def _hold_axially(matrix: Array, contacts: Contacts, i: int, k: int, m: int) -> None:
    """Put the equation of unknown k into the matrix, the force of a contact that sticks on the axial flexibility.

    All tangential forces together stretch the axis by what its material has been carried along.
    """
    each, c = contacts.each, contacts.each[i]
    matrix[k, m] = c.kept_slip - travelled(c)
    for j in range(len(each)):
        other, shared = each[j], shared_flexibility(c, each[j])
        matrix[k, m] -= shared * other.tangential_force  # of those that slide on elastic stops, which is known
        if other.normal_unknown >= 0:
            matrix[k, other.normal_unknown] = friction_ratio(other) * shared if other.state == SLIDING else 0.0
        if other.tangential_unknown >= 0:
            matrix[k, other.tangential_unknown] = shared


@jitable
def _stretching_by_sliding(contacts: Contacts, i: int) -> float:
    """Rate (m/s) at which the axial flexibility yields at contact i to the friction of others that slide."""
    each, rate = contacts.each, 0.0
    for j in range(len(each)):
        if j != i and each[j].state == SLIDING:
            rate += shared_flexibility(each[i], each[j]) * friction_rate(each[j])
    return rate


@jitable
def take_stretching(matrix: Array | None, contacts: Contacts) -> None:
    """Take the rates at which the axial flexibility yields at each contact to the forces of the others.

    Of rigid and damped stops see `add_stretch`.  The compiler drops this of one contact.
    """
    if matrix is None:
        return
    each, closed, m = contacts.each, 0, 0
    for i in range(len(each)):
        c = each[i]
        c.stretching = 0.0
        if c.state != FREE and c.axial != 0.0 and follows(c):
            closed += 1
    if closed < 2:
        return
    for i in range(len(each)):
        each[i].tangential_unknown = -1
        if each[i].state == STICKING:
            each[i].tangential_unknown = m
            m += 1
    for i in range(len(each)):
        c = each[i]
        if c.tangential_unknown >= 0:
            for j in range(len(each)):
                if each[j].tangential_unknown >= 0:
                    matrix[c.tangential_unknown, each[j].tangential_unknown] = shared_flexibility(c, each[j])
            matrix[c.tangential_unknown, m] = -(c.slip_rate + _stretching_by_sliding(contacts, i))
    if not eliminate(matrix, m):
        return
    for i in range(len(each)):
        c = each[i]
        if c.state == SLIDING:
            c.stretching = _stretching_by_sliding(contacts, i)
            for j in range(len(each)):
                if each[j].tangential_unknown >= 0:
                    c.stretching += shared_flexibility(c, each[j]) * matrix[each[j].tangential_unknown, m]


@jitable
def add_stretch(contacts: Contacts, times: float, guards: Array) -> None:
    """Add what the tangential forces stretch the axis, `times` (1/s), to the slip velocities in the guards.

    The difference of two instants over the time between them is the rate at which the axis yields to forces whose
    rates are not known: those of rigid stops, which follow from accelerations, and of damped ones.
    """
    each = contacts.each
    for i in range(len(each)):
        c, stretch = each[i], 0.0
        if c.state != SLIDING:
            continue
        for j in range(len(each)):
            stretch += shared_flexibility(c, each[j]) * each[j].tangential_force
        if c.lower > -1e300:
            guards[GUARDS * i + LOWER] += times * stretch
        if c.upper < 1e300:
            guards[GUARDS * i + UPPER] -= times * stretch


@jitable
def slides_stretching(contacts: Contacts) -> bool:
    """Whether a contact slides on a rigid or damped stop with axial flexibility."""
    found = False
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        found = found or (c.state == SLIDING and c.axial != 0.0 and not follows(c))
    return found


# --- guards, and the forces of others


@jitable
def guards_into(contacts: Contacts, values: Array) -> None:
    """Put the guards of all contacts, five of each, into `values` and behind them their normal forces (N)."""
    n = len(contacts.each)
    take_stretching(contacts.matrix, contacts)
    for i in range(n):
        c = contacts.each[i]
        guards = guards_of(c)
        for k in range(GUARDS):
            values[GUARDS * i + k] = guards[k]
        values[GUARDS * n + i] = lambda_n(c)


def guard_values(contacts: Contacts) -> Array:
    """Return the guards of all contacts, which are in plain Python, five of each."""
    n = len(contacts.each)
    values = np.empty(n * (GUARDS + 1))
    guards_into(contacts, values)
    return values[: n * GUARDS]


@jitable
def couple(contacts: Contacts, i: int) -> None:
    """Add the present forces of the other contacts to the accelerations of a closed contact."""
    each, rows, c = contacts.each, contacts.rows, contacts.each[i]
    for j in range(len(each)):
        if j == i or each[j].state == FREE:
            continue
        for k in range(2):
            force = each[j].normal_force if k == 0 else each[j].tangential_force
            c.gap_acceleration += dot(rows[DIRECTION, i, 0], rows[RESPONSE, j, k]) * force
            c.slip_acceleration += dot(rows[DIRECTION, i, 1], rows[RESPONSE, j, k]) * force
