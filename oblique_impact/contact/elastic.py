"""Elastic contacts: the normal force of a stop in series with what the body yields.

A stop alone has a force of its compression d and its rate,

    lambda_n = k d (1 + a d') + c d'        (Hunt and Crossley 1975; c: linear damping)

or that of the law of a run; it never pulls.  Behind it stands the compliance C of the body between all places
(:mod:`oblique_impact.contact.compliance`): at rest the forces s of closed contacts with gaps g obey

    g + (1/k + C) s = 0

so that they hold V = s.(-g)/2, of which stops and body have their parts.  The depth of a contact is -g less what
the forces at rest of the *others* lift its place.  With its own compliance C_ii it is one spring, of which the
stop has its part at rest in the rate as well, and the viscosity eta of the body relaxes it (`stop_force`).  A
rigid stop under a place without inertia has k infinite: C alone is left, and its damping.

V depends on the coordinates by the gaps, and by C and k where places slide and bodies turn: hence the forces
s_i dC_ij/dp s_j on the shifts p of the contacts (`Candidate.shift`), and -1/2 (dk/ds) d^2 on the slip over an end
of a bed.
"""

from __future__ import annotations

from oblique_impact.contact.compliance import Compliance, across, across_by_shift, locate
from oblique_impact.contact.state import DIRECTION, FREE, Candidate, Contacts
from oblique_impact.kernels.dense import eliminate
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.laws import Law
from oblique_impact.kernels.workspace import Array, dot

_MOST_SECANTS, _SOLVED = 60, 1e-14  # of the forces at rest by laws that are no springs

# --- one contact


@inlined
def spring_force(depth: float, rate: float, stiffness: float, damping: float) -> float:
    """Force (N) of a linear spring with Hunt and Crossley's damping, which may be negative."""
    return stiffness * depth * (1.0 + damping * rate)


@inlined
def share_of(slip: float, first: float, last: float, cell: float) -> tuple[float, float]:
    """Part of a cell (m) of the beam that is over a bedding, and its derivative by the slip (1/m).

    Between `first` and `last` (m along the side) some of the cell is.
    """
    share, fading = 1.0, 0.0
    if cell > 0.0:
        if slip - first < cell:
            share, fading = share - 1.0 + (slip - first) / cell, fading + 1.0 / cell
        if last - slip < cell:
            share, fading = share - 1.0 + (last - slip) / cell, fading - 1.0 / cell
    return (share, fading) if share > 0.0 else (0.0, 0.0)


@inlined
def softness(c: Candidate) -> float:
    """Compliance 1/k (m/N) of that part of a spring or bed that is there; of none a large one."""
    stiffness = c.share * c.stiffness
    return 1.0 / stiffness if stiffness > 0.0 else 1e300


@jitable
def _own_force(law: Law, depth: float, rate: float) -> float:
    """Force (N) of the law of a stop alone, never negative."""
    return max(0.0, law(depth, rate))


@jitable
def stop_force(law: Law | None, c: Candidate, depth: float, rate: float) -> float:
    """Return the normal force (N) of an elastic contact at a depth (m) and its rate (m/s), never negative.

    The stop's part of the rate is its part of the depth at rest: the body follows without inertia.  The compiler
    drops one of the two branches.
    """
    depth, flexible = max(0.0, depth), c.compliance
    if law is None:
        own = softness(c)
        at_rest = 1.0 / (own + flexible)
        stop_rate = own * at_rest * rate
        pushing = 1.0 + c.damping * stop_rate
        if not pushing > 0.0:
            return 0.0
        own /= pushing
        relaxing = c.relaxation * flexible * at_rest * rate
        return max(0.0, (depth + relaxing + own * c.linear_damping * stop_rate) / (own + flexible))
    if flexible == 0.0 or depth == 0.0:
        return _own_force(law, depth, rate)
    if rate != 0.0:
        rate *= 1.0 - flexible * _bracketed_force(law, c, depth, 0.0) / depth
    force = _bracketed_force(law, c, depth, rate)
    return max(0.0, force * (1.0 + c.relaxation * flexible * force * rate / (depth * depth)))


@jitable
def _bracketed_force(law: Law, c: Candidate, depth: float, rate: float) -> float:
    """Force (N) of a stop of any law at the compression (m) that a spring in series leaves it, at a given rate.

    The regula falsi (Illinois); where a step has not halved the bracket the next one does, so that it ends, at the
    latest with two neighbouring numbers.  Some ten steps are usual.  A law that pushes more than the spring bears
    where it is not yet compressed leaves the spring the whole depth.
    """
    compliance, above = c.compliance, _own_force(law, depth, rate)
    low, high, halve = 0.0, min(above, depth / compliance), False
    below = high - _own_force(law, max(0.0, depth - compliance * high), rate)
    if not below > 0.0:
        return high
    while True:
        middle = low + 0.5 * (high - low)
        if not low < middle < high:
            return high
        force = middle if halve else (low * below + high * above) / (above + below)
        if not low < force < high:
            force = middle
        width, error = high - low, _own_force(law, max(0.0, depth - compliance * force), rate) - force
        if abs(error) <= 1e-15 * force:  # of a law that grows with the depth the force is as close
            return force
        if error > 0.0:
            low, above, below = force, error, 0.5 * below
        else:
            high, below, above = force, -error, 0.5 * above
        halve = high - low > 0.5 * width


@inlined
def compression_of(c: Candidate, force: float) -> float:
    """Compression (m) of the stop itself under a force (N): the depth less what the body yields of it.

    Where the body relaxes while a stop of no law opens or closes that is its depth relaxed, see `stop_force`.
    """
    relaxing = 0.0
    if c.relaxation > 0.0:
        relaxing = c.relaxation * c.compliance / (softness(c) + c.compliance) * c.depth_rate
    return max(0.0, max(0.0, c.depth) + relaxing - c.compliance * force)


@jitable
def stop_tangent(law: Law | None, c: Candidate) -> tuple[float, float]:
    """Slopes of the stop's force over depth (N/m) and rate of depth (N s/m); 0 if it does not push.

    Differences are enough: only the pace of Newton's iterations depends on them.
    """
    force = stop_force(law, c, c.depth, c.depth_rate)
    if not force > 0.0:
        return 0.0, 0.0
    deeper, faster, over_depth, over_rate = 1e-6 * max(0.0, c.depth), 1e-6 * abs(c.depth_rate), 0.0, 0.0
    if deeper > 0.0:
        over_depth = (stop_force(law, c, c.depth + deeper, c.depth_rate) - force) / deeper
    if faster > 0.0:
        over_rate = (stop_force(law, c, c.depth, c.depth_rate + faster) - force) / faster
    return over_depth, over_rate


# --- all contacts


@inlined
def bears(c: Candidate) -> bool:
    """Whether a contact is elastic and closed."""
    return bool(c.state != FREE and c.compliant and not c.probed)


@inlined
def press(contacts: Contacts) -> None:
    """Take depths and forces at rest of elastic contacts, and the forces by the change of their compliances."""
    each, push = contacts.each, contacts.push
    for i in range(len(each)):
        c = each[i]
        c.depth, c.depth_rate = -c.gap, -c.gap_rate
        c.end_force, c.shift_force, c.boundary_power = 0.0, 0.0, 0.0
        if c.cell != 0.0:
            c.share = share_of(c.slip, c.first, c.last, c.cell)[0]
    _yield(contacts.compliance, contacts.matrix, contacts)
    for i in range(len(each)):
        if bears(each[i]):
            each[i].rest_force = stop_force(contacts.law, each[i], each[i].depth, 0.0)
    if not is_pushed(contacts):
        return
    for j in range(push.shape[0]):
        push[j] = 0.0
    for i in range(len(each)):
        if bears(each[i]) and each[i].cell != 0.0:
            _push_at_end(contacts, i)
    _push_shifts(contacts.compliance, contacts)


@jitable
def is_pushed(contacts: Contacts) -> bool:
    """Whether there are forces by the change of compliances."""
    found = False
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        found = found or (bears(c) and (c.cell != 0.0 or c.compliance != 0.0))
    return found


@jitable
def _push_at_end(contacts: Contacts, i: int) -> None:
    """Push a contact on a bedding under a cell over an end of it."""
    c, row = contacts.each[i], contacts.rows[DIRECTION, i, 1]
    compressed = max(0.0, max(0.0, c.depth) - c.compliance * c.rest_force)
    fading = share_of(c.slip, c.first, c.last, c.cell)[1]
    c.end_force = -0.5 * c.stiffness * fading * compressed * compressed
    for j in range(row.shape[0]):
        contacts.push[j] += c.end_force * row[j]


@jitable
def _push_shifts(y: Compliance | None, contacts: Contacts) -> None:
    """Push the shifts of contacts behind which compliances change; the compiler drops this of bodies without."""
    if y is None:
        return
    each = contacts.each
    for i in range(len(each)):
        c, row = each[i], contacts.rows[DIRECTION, i, 2]
        if not bears(c):
            continue
        force = 0.0
        for j in range(len(each)):
            if bears(each[j]):
                force += c.rest_force * each[j].rest_force * across_by_shift(y, i, 0, j, 0)
        c.shift_force = force
        for j in range(row.shape[0]):
            contacts.push[j] += force * row[j]


@jitable
def _yield(y: Compliance | None, matrix: Array | None, contacts: Contacts) -> None:
    """Take compliances and depths of contacts with a compliant body; the compiler drops this of others."""
    if y is None:
        return
    each, closed, last = contacts.each, 0, 0
    for i in range(len(each)):
        c = each[i]
        locate(y, i, c.shift)
        c.compliance = across(y, i, 0, i, 0)
        if bears(c) or c.probed:
            _tilt(y, c, i)
        c.relaxation = y.viscosity
        if bears(c):
            closed, last = closed + 1, i
    if closed > 1:
        _take_forces_at_rest(y, matrix, contacts)
    elif closed == 1:
        c = each[last]
        c.rest_force = stop_force(contacts.law, c, c.depth, 0.0)
        c.normal_change = _secant(contacts.law, c, c.rest_force) * c.depth_rate
    if closed > 0:
        for i in range(len(each)):
            _lift(y, contacts, i)


@jitable
def _tilt(y: Compliance, c: Candidate, i: int) -> None:
    """Take the tilt t = -C_tn/(1/k + C_nn) of contact i, and how it changes as the body turns against a side.

    With the angle C_nn' = 2 C_tn, C_tn' = C_tt - C_nn, C_tt' = -2 C_tn.  On an obstacle's point it is zero.
    """
    leaning, whole = across(y, i, 1, i, 0), softness(c) + c.compliance
    c.tilt = -leaning / whole
    if leaning == 0.0 and y.facing[i] != 0.0:
        return
    apart = across(y, i, 1, i, 1) - c.compliance
    slope = apart * whole - 2.0 * leaning * leaning
    bend = -4.0 * leaning * whole - 2.0 * leaning * apart
    c.tilt_slope = -slope / (whole * whole)
    c.tilt_bend = -(bend - 4.0 * leaning * slope / whole) / (whole * whole)


@jitable
def _secant(law: Law | None, c: Candidate, force: float) -> float:
    """Force at rest over depth (N/m)."""
    if law is None:
        return 1.0 / (softness(c) + c.compliance)
    return force / c.depth if c.depth > 0.0 else 0.0


@jitable
def _lift(y: Compliance, contacts: Contacts, i: int) -> None:
    """Take what the forces at rest of others, and their rates (N/s) in `normal_change`, lift the place of i."""
    each, c = contacts.each, contacts.each[i]
    for j in range(len(each)):
        if j != i and bears(each[j]):
            between = across(y, i, 0, j, 0)
            c.depth -= between * each[j].rest_force
            c.depth_rate -= between * each[j].normal_change


@jitable
def _take_forces_at_rest(y: Compliance, matrix: Array | None, contacts: Contacts) -> None:
    """Solve for the forces at rest of several contacts, and their rates; the compiler drops this of one.

    Laws that are no springs by their secants: in a few iterations, as most of the compliance is a stop's own.
    """
    if matrix is None:
        return
    each = contacts.each
    for i in range(len(each)):
        c = each[i]
        c.rest_force = 0.0
    for _ in range(_MOST_SECANTS):
        size, changed, largest = _solve_at_rest(y, matrix, contacts, True), 0.0, 0.0
        k = 0
        for i in range(len(each)):
            c = each[i]
            if bears(c):
                force = matrix[k, size]
                changed, largest = max(changed, abs(force - c.rest_force)), max(largest, abs(force))
                c.rest_force = force
                k += 1
        if contacts.law is None or changed <= _SOLVED * largest:
            break
    size, k = _solve_at_rest(y, matrix, contacts, False), 0
    for i in range(len(each)):
        c = each[i]
        if bears(c):
            c.normal_change = matrix[k, size]
            k += 1


@jitable
def _solve_at_rest(y: Compliance, matrix: Array, contacts: Contacts, forces: bool) -> int:
    """Solve (1/k + C) s = -g for the forces at rest, or their rates, behind the matrix; returns how many."""
    each, size, k = contacts.each, 0, 0
    for i in range(len(each)):
        if bears(each[i]):
            size += 1
    for i in range(len(each)):
        c = each[i]
        if not bears(c):
            continue
        column = 0
        for j in range(len(each)):
            if bears(each[j]):
                matrix[k, column] = across(y, i, 0, j, 0)
                column += 1
        matrix[k, k] += _own_softness(contacts.law, y, contacts, i)
        matrix[k, size] = -c.gap if forces else -c.gap_rate
        k += 1
    if not eliminate(matrix, size):  # of places that are one
        for k in range(size):
            matrix[k, size] = 0.0
    return size


@jitable
def _own_softness(law: Law | None, y: Compliance, contacts: Contacts, i: int) -> float:
    """Compression over force (m/N) of the stop of contact i alone, at the forces at rest of the last iteration."""
    each, c = contacts.each, contacts.each[i]
    if law is None:
        return softness(c)
    compressed = -c.gap
    for j in range(len(each)):
        if bears(each[j]):
            compressed -= across(y, i, 0, j, 0) * each[j].rest_force
    force = _own_force(law, max(0.0, compressed), 0.0)
    return compressed / force if force > 0.0 and compressed > 0.0 else 1e300


@jitable
def between_normals(y: Compliance | None, i: int, j: int) -> float:
    """Return the gap of contact i by a unit normal force on j (m/N); the compiler drops this of rigid bodies."""
    return 0.0 if y is None else across(y, i, 0, j, 0)


@inlined
def take_boundary_power(c: Candidate, rows: Array, qd: Array) -> None:
    """Take the power (W) of moving boundaries by the forces on slip and shift, beyond that of the coordinates."""
    if c.end_force != 0.0:
        c.boundary_power += c.end_force * (dot(rows[1], qd) - c.slip_rate)
    if c.shift_force != 0.0:
        c.boundary_power += c.shift_force * (dot(rows[2], qd) - c.shift_rate)
