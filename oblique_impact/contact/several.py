"""Forces of several contacts at once, each in its state.

The contact forces of all closed contacts follow from one system of equations.  A rigid contact has the unknown
lambda_n, its constraint is that on the acceleration of its gap; one that sticks has lambda_tau too; one that
slides has lambda_tau = r lambda_n.  The force of a compliant stop is known.  With one contact they are those of
`oblique_impact.contact.forces`.
"""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np

from oblique_impact.contact.forces import (
    MASS_NOT_POSITIVE,
    NEARLY_PAINLEVE,
    NO_SLIDING_SOLUTION,
    NO_STICKING_SOLUTION,
    OK,
    SINGULAR,
    accelerate,
    drift_of,
    end_push,
    flying,
    friction_rate,
    friction_ratio,
    guards_of,
    instant_of,
    moved,
    share_of,
    stop_force,
    with_forces,
)
from oblique_impact.contact.friction import Branch
from oblique_impact.contact.state import (
    A_NN,
    A_TT,
    CELL,
    COMPLIANCE,
    DEFINITE,
    FIRST,
    FREE,
    GAP,
    GAP_ACCELERATION,
    GAP_RATE,
    GUARDS,
    HELD,
    HIGHEST,
    INTERCEPT,
    KEPT_SLIP,
    LAST,
    LOWER,
    LOWEST,
    NO_CONTACT,
    NORMAL_FORCE,
    SENSE,
    SIDE,
    SLIDING,
    SLIP,
    SLIP_ACCELERATION,
    SLIP_RATE,
    SLOPE,
    STATE,
    STATIC,
    STICKING,
    STIFFNESS,
    TANGENTIAL_FORCE,
    UPPER,
    ContactArrays,
    Instant,
    Phase,
    Stick,
    Stop,
    Surface,
)
from oblique_impact.kernels.dense import eliminate
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array, Workspace, copy, dot

NORMAL_DIRECTION, TANGENTIAL_DIRECTION = 0, 1
_OUTSIDE = 1e-9  # of the friction cone: a located end of stick is at its edge but for less


@inlined
def phase_of(shared: Phase, arrays: ContactArrays, i: int) -> Phase:
    """State of one of several contacts."""
    row, stop, surface = arrays.rows[i], shared.stop, shared.surface
    share, fading = share_of(arrays.instants[i, SLIP], row[FIRST], row[LAST], row[CELL])
    return Phase(
        int(row[STATE]),
        Stop(stop.compliant, stop.massless, row[STIFFNESS], stop.damping, stop.law, row[CELL], share, fading),
        Branch(row[INTERCEPT], row[SLOPE], row[LOWEST], row[HIGHEST]),
        Stick(row[STATIC], row[KEPT_SLIP], row[HELD], row[COMPLIANCE], row[SENSE]),
        shared.stabilization,
        Surface(surface.enabled, row[SIDE], row[FIRST], row[LAST]),
        shared.residual,
        None,
    )


def row_of(phase: Phase) -> list[float]:
    """Return the row of one of several contacts in this state."""
    friction, stick, surface = phase.friction, phase.stick, phase.surface
    ends = surface.side, surface.first, surface.last
    return [float(phase.state), *friction, *stick, *ends, phase.stop.stiffness, phase.stop.cell]


@inlined
def shared_flexibility(row: Array, other: Array) -> float:
    """Displacement (m/N) along the tangent of one contact by a force along that of another, by their rows."""
    return float(row[SENSE] * other[SENSE] * min(row[COMPLIANCE], other[COMPLIANCE]))


@inlined
def instant_at(arrays: ContactArrays, i: int) -> Instant:
    """Contact problem of one of several contacts where they were solved last."""
    c = arrays.instants[i]
    return Instant(c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10], 0.0, 0.0)


# one contact or several: `arrays` is an argument of its own, so that the compiler drops one of the two branches


@inlined
def contact_count(arrays: ContactArrays | None) -> int:
    """Return the number of contacts."""
    if arrays is None:
        return 1
    return int(arrays.rows.shape[0])


@inlined
def contact_phase(arrays: ContactArrays | None, phase: Phase, i: int) -> Phase:
    """State of contact i; both branches have one type for the compiler, which of several contacts sees both."""
    if arrays is None:
        stop, friction, surface = phase.stop, phase.friction, phase.surface
        return Phase(
            phase.state,
            Stop(stop.compliant, stop.massless, stop.stiffness, stop.damping, stop.law, 0.0, 1.0, 0.0),
            Branch(friction.intercept, friction.slope, friction.lower, friction.upper),
            Stick(
                phase.stick.static, phase.stick.slip, phase.stick.held, phase.stick.compliance, phase.stick.sense
            ),
            phase.stabilization,
            Surface(surface.enabled, surface.side, surface.first, surface.last),
            phase.residual,
            None,
        )
    return phase_of(phase, arrays, i)


@inlined
def contact_at(arrays: ContactArrays | None, c: Instant, i: int) -> Instant:
    """Contact problem of contact i where they were solved last; of a single one it is c."""
    if arrays is None:
        return c
    return instant_at(arrays, i)


@inlined
def keep_forces(arrays: ContactArrays | None, c: Instant, i: int, normal: float, tangential: float) -> Instant:
    """Keep the forces (N) of contact i; returns those of all, c with these forces of a single one."""
    if arrays is None:
        return with_forces(c, normal, tangential, c.supplied_power)
    arrays.instants[i, NORMAL_FORCE], arrays.instants[i, TANGENTIAL_FORCE] = normal, tangential
    return c


@jitable
def solve_contacts(
    arrays: ContactArrays | None, system: Any, phase: Phase, t: float, q: Array, qd: Array, w: Workspace
) -> tuple[int, Instant]:
    """Acceleration of `phase`.

    Returns as :func:`oblique_impact.contact.forces.accelerate`; of several contacts the smallest distance in
    flight, the largest gap rate and the sum of the normal forces.
    """
    if arrays is None:
        return accelerate(system, phase, t, q, qd, w)
    return _accelerate_coupled(arrays, system, phase, t, q, qd, w)


@jitable
def _accelerate_coupled(
    arrays: ContactArrays, system: Any, phase: Phase, t: float, q: Array, qd: Array, w: Workspace
) -> tuple[int, Instant]:
    e, v = system.evaluate(t, q, qd, w), w.vectors
    if not system.solve_mass(e.rank_one, w, False):
        return MASS_NOT_POSITIVE, flying(e)
    least, fastest = take_contacts(arrays, system, phase, e.rank_one, t, q, qd, w)
    acceleration = v.acceleration
    copy(v.free_acceleration, acceleration)
    _push_stops(arrays, phase, acceleration)
    status = _solve_constraints(arrays, phase, acceleration)
    if status != OK:
        return status, flying(e)
    normal = 0.0
    for i in range(arrays.rows.shape[0]):
        normal += arrays.instants[i, NORMAL_FORCE]
    supplied = e.supplied_power + dot(v.supply, acceleration)
    return OK, Instant(least, 0.0, fastest, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, normal, 0.0, e.damping_power, supplied)


@jitable
def touch_contacts(
    arrays: ContactArrays, system: Any, phase: Phase, t: float, q: Array, qd: Array, w: Workspace
) -> tuple[float, float]:
    """Kinematics of all contacts, with the rows of the closed ones, and no force of those in flight.

    Returns the smallest distance (m) of a contact in flight and the largest gap rate (m/s).
    """
    least, fastest = 1e300, 0.0
    system.take_state(t, q, qd, w)
    for i in range(arrays.rows.shape[0]):
        k, c = system.touch(i, t, q, qd, w), arrays.instants[i]
        c[GAP], c[SLIP], c[GAP_RATE], c[SLIP_RATE] = k.gap, k.slip, k.gap_rate, k.slip_rate
        fastest = max(fastest, abs(k.gap_rate))
        if arrays.rows[i, STATE] == FREE:
            c[NORMAL_FORCE], c[TANGENTIAL_FORCE] = 0.0, 0.0
            least = min(least, arrays.rows[i, SIDE] * k.gap)
        else:
            copy(w.vectors.normal_row, arrays.directions[i, 0])
            copy(w.vectors.tangential_row, arrays.directions[i, 1])
    return least, fastest


@jitable
def take_contacts(
    arrays: ContactArrays, system: Any, phase: Phase, rank_one: float, t: float, q: Array, qd: Array, w: Workspace
) -> tuple[float, float]:
    """Kinematics of all contacts, and rows, responses and Delassus entries of the closed ones, without forces.

    The system is evaluated and its mass matrix solved.  Returns the smallest distance (m) of a contact in flight
    and the largest gap rate (m/s).
    """
    v, least, fastest = w.vectors, 1e300, 0.0
    normal_row, tangential_row = v.normal_row, v.tangential_row
    normal_response, tangential_response = v.normal_response, v.tangential_response
    system.take_state(t, q, qd, w)
    for i in range(arrays.rows.shape[0]):
        k = system.touch(i, t, q, qd, w)
        fastest = max(fastest, abs(k.gap_rate))
        if arrays.rows[i, STATE] == FREE:
            c = moved(NO_CONTACT, k, 0.0, 0.0, 0.0)
            least = min(least, arrays.rows[i, SIDE] * k.gap)
        else:
            system.solve_mass(rank_one, w, True)
            c = instant_of(k, w)
            copy(normal_row, arrays.directions[i, 0])
            copy(tangential_row, arrays.directions[i, 1])
            copy(normal_response, arrays.responses[i, 0])
            copy(tangential_response, arrays.responses[i, 1])
        arrays.biases[i, 0], arrays.biases[i, 1] = k.gap_bias, k.slip_bias
        for j in range(arrays.instants.shape[1]):
            arrays.instants[i, j] = c[j]
    if phase.stop.compliant:
        _push_at_ends(arrays, phase, v.free_acceleration)
    return least, fastest


@jitable
def push_at_end(arrays: ContactArrays, phase: Phase, i: int) -> float:
    """Force (N) along the slide at contact i where the beam lies over the end of a bedding."""
    if arrays.rows[i, CELL] == 0.0 or arrays.rows[i, STATE] == FREE:
        return 0.0
    return end_push(phase_of(phase, arrays, i).stop, arrays.instants[i, GAP])


@jitable
def _push_at_ends(arrays: ContactArrays, phase: Phase, free_acceleration: Array) -> None:
    """Add the known forces at the ends of beddings, which are no friction, to the free accelerations."""
    for i in range(arrays.rows.shape[0]):
        push, response = push_at_end(arrays, phase, i), arrays.responses[i, 1]
        if push == 0.0:
            continue
        for j in range(free_acceleration.shape[0]):
            free_acceleration[j] += push * response[j]
        for k in range(arrays.rows.shape[0]):
            if arrays.rows[k, STATE] != FREE:
                arrays.instants[k, GAP_ACCELERATION] += push * dot(arrays.directions[k, 0], response)
                arrays.instants[k, SLIP_ACCELERATION] += push * dot(arrays.directions[k, 1], response)


@jitable
def _push_stops(arrays: ContactArrays, phase: Phase, acceleration: Array) -> None:
    """Add the known forces of compliant stops, with the friction of those that slide, to the acceleration."""
    if not phase.stop.compliant:
        return
    for i in range(arrays.rows.shape[0]):
        p = phase_of(phase, arrays, i)
        if p.state == FREE:
            continue
        c = instant_at(arrays, i)
        push = stop_force(p.stop, p.residual, c.gap, c.gap_rate)
        drag = friction_ratio(p, c.slip_rate) * push if p.state == SLIDING else 0.0
        arrays.instants[i, NORMAL_FORCE], arrays.instants[i, TANGENTIAL_FORCE] = push, drag
        for j in range(acceleration.shape[0]):
            acceleration[j] += arrays.responses[i, 0, j] * push + arrays.responses[i, 1, j] * drag


@jitable
def axially_held(arrays: ContactArrays) -> int:
    """Collect the contacts that stick on the axial flexibility among the unknowns; returns their number."""
    m = 0
    for i in range(arrays.rows.shape[0]):
        if arrays.rows[i, STATE] == STICKING and arrays.rows[i, COMPLIANCE] != 0.0:
            arrays.unknowns[m, 0] = i
            m += 1
    return m


@jitable
def _stretch(arrays: ContactArrays, m: int) -> bool:
    """Solve for m forces that give displacements along the axis, in column m of the matrix, or for their rates."""
    for k in range(m):
        own = arrays.rows[int(arrays.unknowns[k, 0])]
        for column in range(m):
            other = arrays.rows[int(arrays.unknowns[column, 0])]
            arrays.matrix[k, column] = shared_flexibility(own, other)
    return eliminate(arrays.matrix, m)


@jitable
def _yielding_to_sliding(arrays: ContactArrays, phase: Phase, i: int) -> float:
    """Rate (m/s) at which the axial flexibility yields at contact i to the friction of others that slide."""
    rate = 0.0
    for j in range(arrays.rows.shape[0]):
        if j != i and arrays.rows[j, STATE] == SLIDING:
            shared = shared_flexibility(arrays.rows[i], arrays.rows[j])
            rate += shared * friction_rate(phase_of(phase, arrays, j), instant_at(arrays, j))
    return rate


@inlined
def yielding_at(arrays: ContactArrays | None, i: int) -> float:
    """Rate (m/s) at which the axial flexibility yields at contact i to the forces of others, 0 of a single one."""
    if arrays is None:
        return 0.0
    return float(arrays.yielding[i])


@jitable
def take_yielding(arrays: ContactArrays | None, phase: Phase) -> None:
    """Take the rates at which the axial flexibility yields at each contact to the forces of the others."""
    if arrays is not None and phase.stop.compliant:
        _take_yielding(arrays, phase)


@jitable
def _take_yielding(arrays: ContactArrays, phase: Phase) -> None:
    n, closed = arrays.rows.shape[0], 0
    for i in range(n):
        arrays.yielding[i] = 0.0
        if arrays.rows[i, STATE] != FREE and arrays.rows[i, COMPLIANCE] != 0.0:
            closed += 1
    if closed < 2:
        return
    m = axially_held(arrays)
    for k in range(m):
        i = int(arrays.unknowns[k, 0])
        arrays.matrix[k, m] = -(arrays.instants[i, SLIP_RATE] + _yielding_to_sliding(arrays, phase, i))
    if not _stretch(arrays, m):
        return
    for i in range(n):
        if arrays.rows[i, STATE] == SLIDING:
            arrays.yielding[i] = _yielding_to_sliding(arrays, phase, i)
            for k in range(m):
                other = arrays.rows[int(arrays.unknowns[k, 0])]
                arrays.yielding[i] += shared_flexibility(arrays.rows[i], other) * arrays.matrix[k, m]


@jitable
def _solve_constraints(arrays: ContactArrays, phase: Phase, acceleration: Array) -> int:
    """Solve for the forces of rigid and sticking contacts and add them to the acceleration; returns the status.

    Gauss's elimination in the order of the contacts: its pivots are the effective inverse masses, which are
    positive where the problem has one solution.
    """
    matrix, unknowns, m = arrays.matrix, arrays.unknowns, _collect(arrays, phase, acceleration)
    status = OK
    for k in range(m):
        i, pivot = int(unknowns[k, 0]), matrix[k, k]
        normal = unknowns[k, 1] == NORMAL_DIRECTION
        own = arrays.instants[i, A_NN] if normal else arrays.instants[i, A_TT]
        if not normal and arrays.rows[i, COMPLIANCE] != 0.0:
            own = arrays.rows[i, COMPLIANCE]
        if normal:
            arrays.definite[i] = pivot / own
        if not pivot > SINGULAR * own:
            sliding = arrays.rows[i, STATE] == SLIDING and arrays.rows[i, INTERCEPT] != 0.0
            status = NO_SLIDING_SOLUTION if sliding else NO_STICKING_SOLUTION
            return status
        for r in range(k + 1, m):
            factor = matrix[r, k] / pivot
            for column in range(k + 1, m + 1):
                matrix[r, column] -= factor * matrix[k, column]
    for k in range(m - 1, -1, -1):
        force = matrix[k, m]
        for column in range(k + 1, m):
            force -= matrix[k, column] * matrix[column, m]
        matrix[k, m] = force / matrix[k, k]
    for k in range(m):
        _apply_unknown(arrays, phase, int(unknowns[k, 0]), unknowns[k, 1], matrix[k, m], acceleration)
    return status


@jitable
def _collect(arrays: ContactArrays, phase: Phase, acceleration: Array) -> int:
    """Put the equations of the unknown forces into the matrix; returns their number."""
    matrix, unknowns, m = arrays.matrix, arrays.unknowns, 0
    for i in range(arrays.rows.shape[0]):
        state = int(arrays.rows[i, STATE])
        if state != FREE and not phase.stop.compliant:
            unknowns[m, 0], unknowns[m, 1] = i, NORMAL_DIRECTION
            m += 1
        if state == STICKING:
            unknowns[m, 0], unknowns[m, 1] = i, TANGENTIAL_DIRECTION
            m += 1
    for k in range(m):
        if unknowns[k, 1] == TANGENTIAL_DIRECTION and arrays.rows[int(unknowns[k, 0]), COMPLIANCE] != 0.0:
            _hold_axially(arrays, phase, k, m)
            continue
        i, which = int(unknowns[k, 0]), int(unknowns[k, 1])
        p, c, row = phase_of(phase, arrays, i), instant_at(arrays, i), arrays.directions[i, which]
        rate, place = c.gap_rate, c.gap
        if which == TANGENTIAL_DIRECTION:
            rate, place = c.slip_rate, drift_of(p.stick, c)
        correction = p.stabilization.damping * rate + p.stabilization.stiffness * place
        for column in range(m):
            j = int(unknowns[column, 0])
            if unknowns[column, 1] == TANGENTIAL_DIRECTION:
                entry = dot(row, arrays.responses[j, 1])
            else:
                entry = dot(row, arrays.responses[j, 0])
                other = phase_of(phase, arrays, j)
                if other.state == SLIDING:
                    ratio = friction_ratio(other, arrays.instants[j, SLIP_RATE])
                    entry += ratio * dot(row, arrays.responses[j, 1])
            matrix[k, column] = entry
        matrix[k, m] = -(dot(row, acceleration) + arrays.biases[i, which] + correction)
    return m


@jitable
def _hold_axially(arrays: ContactArrays, phase: Phase, k: int, m: int) -> None:
    """Put the equation of unknown k into the matrix, the force of a contact that sticks on the axial flexibility.

    All tangential forces together stretch the axis by what its material has been carried along.
    """
    i = int(arrays.unknowns[k, 0])
    row, matrix = arrays.rows[i], arrays.matrix
    matrix[k, m] = row[KEPT_SLIP] - arrays.travel[i]
    for j in range(arrays.rows.shape[0]):  # of those that slide on elastic stops; others are not known yet
        matrix[k, m] -= shared_flexibility(row, arrays.rows[j]) * arrays.instants[j, TANGENTIAL_FORCE]
    for column in range(m):
        j = int(arrays.unknowns[column, 0])
        part = 1.0
        if arrays.unknowns[column, 1] == NORMAL_DIRECTION:
            other = phase_of(phase, arrays, j)
            part = friction_ratio(other, arrays.instants[j, SLIP_RATE]) if other.state == SLIDING else 0.0
        matrix[k, column] = part * shared_flexibility(row, arrays.rows[j])


@jitable
def add_stretch(arrays: ContactArrays | None, phase: Phase, c: Instant, times: float, guards: Array) -> None:
    """Add what the tangential forces stretch the axis, `times` (1/s), to the slip velocities in the guards.

    The difference of two instants over the time between them is the rate at which the axis yields to forces that
    follow from accelerations, those of rigid stops.
    """
    for i in range(contact_count(arrays)):
        p, stretch = contact_phase(arrays, phase, i), 0.0
        if p.state != SLIDING:
            continue
        if arrays is None:
            stretch = p.stick.compliance * c.tangential_force
        else:
            for j in range(arrays.rows.shape[0]):
                shared = shared_flexibility(arrays.rows[i], arrays.rows[j])
                stretch += shared * arrays.instants[j, TANGENTIAL_FORCE]
        if p.friction.lower > -1e300:
            guards[GUARDS * i + LOWER] += times * stretch
        if p.friction.upper < 1e300:
            guards[GUARDS * i + UPPER] -= times * stretch


@jitable
def slides_stretching(arrays: ContactArrays | None, phase: Phase) -> bool:
    """Whether a contact slides on a rigid stop with axial flexibility."""
    if phase.stop.compliant:
        return False
    for i in range(contact_count(arrays)):
        p = contact_phase(arrays, phase, i)
        if p.state == SLIDING and p.stick.compliance != 0.0:
            return True
    return False


@jitable
def _apply_unknown(
    arrays: ContactArrays, phase: Phase, i: int, which: float, force: float, acceleration: Array
) -> None:
    """Add a force (N), with the friction of a sliding contact, to the acceleration and to its contact."""
    normal, tangential = force, 0.0
    if which == TANGENTIAL_DIRECTION:
        normal, tangential = 0.0, force
    elif arrays.rows[i, STATE] == SLIDING:
        tangential = friction_ratio(phase_of(phase, arrays, i), arrays.instants[i, SLIP_RATE]) * force
    arrays.instants[i, NORMAL_FORCE] += normal
    arrays.instants[i, TANGENTIAL_FORCE] += tangential
    for j in range(acceleration.shape[0]):
        acceleration[j] += arrays.responses[i, 0, j] * normal + arrays.responses[i, 1, j] * tangential


@jitable
def guards_into(arrays: ContactArrays | None, phase: Phase, c: Instant, values: Array) -> None:
    """Put the guards of all contacts, five of each, into `values` and behind them their normal forces (N)."""
    if arrays is None:
        guards = guards_of(phase, c)
        for k in range(GUARDS):
            values[k] = guards[k]
        values[GUARDS] = c.normal_force
    else:
        _guards_of_each(arrays, phase, values)


@jitable
def _guards_of_each(arrays: ContactArrays, phase: Phase, values: Array) -> None:
    n = arrays.rows.shape[0]
    take_yielding(arrays, phase)
    for i in range(n):
        p, c = phase_of(phase, arrays, i), instant_at(arrays, i)
        guards = guards_of(p, c, arrays.yielding[i])
        for k in range(GUARDS):
            values[GUARDS * i + k] = guards[k]
        if p.state == SLIDING and not p.stop.compliant:
            values[GUARDS * i + DEFINITE] = arrays.definite[i] - NEARLY_PAINLEVE
        values[GUARDS * n + i] = c.normal_force


@jitable
def coupled_instant(arrays: ContactArrays, i: int) -> Instant:
    """Contact problem of a closed contact with the present forces of the others in its accelerations."""
    c, gap, slip = instant_at(arrays, i), 0.0, 0.0
    for j in range(arrays.rows.shape[0]):
        if j == i or arrays.rows[j, STATE] == FREE:
            continue
        normal, tangential = arrays.instants[j, NORMAL_FORCE], arrays.instants[j, TANGENTIAL_FORCE]
        gap += dot(arrays.directions[i, 0], arrays.responses[j, 0]) * normal
        gap += dot(arrays.directions[i, 0], arrays.responses[j, 1]) * tangential
        slip += dot(arrays.directions[i, 1], arrays.responses[j, 0]) * normal
        slip += dot(arrays.directions[i, 1], arrays.responses[j, 1]) * tangential
    return Instant(
        c.gap,
        c.slip,
        c.gap_rate,
        c.slip_rate,
        c.a_nn,
        c.a_nt,
        c.a_tt,
        c.gap_acceleration + gap,
        c.slip_acceleration + slip,
        c.normal_force,
        c.tangential_force,
        0.0,
        0.0,
    )


def _inside_cone(phase: Phase, normal: float, tangential: float) -> Phase:
    """Return the state of a contact, or another one if its forces (N) are outside of the friction cone."""
    static = phase.stick.static
    if phase.state == FREE:
        return phase
    if phase.state == STICKING and abs(tangential) > static * max(normal, 0.0) * (1.0 + _OUTSIDE):
        edge = Branch(static if tangential > 0.0 else -static, 0.0, -inf, inf)
        return phase._replace(state=SLIDING, friction=edge)
    pulls = phase.state == SLIDING and not phase.stop.compliant and normal < 0.0
    return phase._replace(state=FREE) if pulls else phase


def inside_cones(phase: Phase, instant: Array, contacts: Array) -> Phase:
    """Return a phase, or one with forces inside of the friction cones if those of an instant are not.

    A contact that sticks beyond its cone is at its edge, one that pulls is without force.

    Parameters
    ----------
    phase : Phase
        Whose forces may be outside.
    instant : ndarray, shape (13,)
        The fields of `Instant` with the forces.
    contacts : ndarray, shape (n, 13)
        The same of several contacts.
    """
    arrays = phase.arrays
    if arrays is None:
        return _inside_cone(phase, float(instant[NORMAL_FORCE]), float(instant[TANGENTIAL_FORCE]))
    rows = arrays.rows.copy()
    for i, (normal, tangential) in enumerate(contacts[:, [NORMAL_FORCE, TANGENTIAL_FORCE]].tolist()):
        own = phase_of(phase, arrays, i)
        changed = _inside_cone(own, normal, tangential)
        if changed is not own:
            rows[i] = row_of(changed)
    if np.array_equal(rows, arrays.rows):
        return phase
    # arrays of its own: those of the run keep what is solved for its own states
    return phase._replace(arrays=ContactArrays(rows, *(array.copy() for array in arrays[1:])))


def guard_values(phase: Phase, c: Instant) -> Array:
    """Return the guards of all contacts of a phase at an instant, five of each."""
    count = 1 if phase.arrays is None else len(phase.arrays.rows)
    values = np.empty(count * (GUARDS + 1))
    guards_into(phase.arrays, phase, c, values)
    return values[: count * GUARDS]
