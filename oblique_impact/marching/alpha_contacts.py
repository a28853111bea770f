"""The contacts in a step of generalized-alpha.

The forces of all closed contacts follow in every iteration from one system of equations, two for each: the law of
its stop; and friction or, where it sticks, a slip velocity of zero or the law of the axial flexibility behind it.
What one closed contact has is known in closed form.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from oblique_impact.contact.elastic import bears, between_normals, is_pushed, stop_force, stop_tangent
from oblique_impact.contact.forces import (
    NO_SLIDING_SOLUTION,
    NO_STICKING_SOLUTION,
    OK,
    axial_force,
    can_slide,
    drift_of,
    friction_ratio,
    shared_flexibility,
    touch_contacts,
)
from oblique_impact.contact.state import DIRECTION, FREE, RESPONSE, SLIDING, STICKING, Contacts
from oblique_impact.kernels.dense import eliminate
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import FORCES, INCREMENT, RESIDUAL, Array, Workspace, add, dot
from oblique_impact.marching.alpha_state import StepLength


@inlined
def add_forces(contacts: Contacts, residual: Array) -> None:
    """Add the contact forces, and those by the change of compliances, to the residual."""
    if is_pushed(contacts):
        add(contacts.push, residual)
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        if c.state != FREE:
            normal, tangential = c.normal_force, c.tangential_force
            normal_row, tangential_row = contacts.rows[DIRECTION, i, 0], contacts.rows[DIRECTION, i, 1]
            for k in range(residual.shape[0]):
                residual[k] += normal * normal_row[k] + tangential * tangential_row[k]


@jitable
def largest_defect(contacts: Contacts, velocity: float) -> float:
    """Return the largest residual (m/s) of the contact laws at the forces and the motion."""
    largest = 0.0
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        if c.state == FREE:
            continue
        normal = abs(stop_force(contacts.law, c, c.depth, c.depth_rate) - c.normal_force) * c.a_nn * velocity
        tangential = abs(c.slip_rate)
        if c.state != STICKING:
            tangential = abs(friction_ratio(c) * c.normal_force - c.tangential_force) * c.a_tt * velocity
        elif c.axial != 0.0:
            tangential = 0.0  # its law is linear: it holds as soon as the motion is known
        largest = max(largest, normal, tangential)
    return largest


class Linear(NamedTuple):
    """The laws of a contact, linear in the changes of all forces: of its own and of the accelerations by all.

    dN + by_gap D_n dq'' = normal,    own_tangential dT - ratio dN + by_slip D_tau dq'' = tangential

    The normal force grows by `by_depth` with the depth of the contact, which those of others take away.
    """

    status: int
    by_depth: float  # N/m
    by_gap: float
    normal: float
    own_tangential: float
    ratio: float
    by_slip: float
    tangential: float


@jitable
def _linearize(contacts: Contacts, i: int, increment: Array, step: StepLength) -> Linear:
    """Return the laws of a closed contact at the motion with the `increment` of q'' without changes of forces."""
    c, velocity, h = contacts.each[i], step.velocity, step.h
    normal_row, tangential_row = contacts.rows[DIRECTION, i, 0], contacts.rows[DIRECTION, i, 1]
    over_depth, over_rate = stop_tangent(contacts.law, c)
    by_gap = over_depth * step.position + over_rate * velocity
    normal = stop_force(contacts.law, c, c.depth, c.depth_rate) - c.normal_force
    normal -= by_gap * dot(normal_row, increment)
    ratio, own_tangential, by_slip, tangential, status = 0.0, 0.0, velocity, -c.slip_rate, OK
    if c.state == SLIDING:
        ratio, own_tangential = friction_ratio(c), 1.0
        if not can_slide(c):
            status = NO_SLIDING_SOLUTION
        inclined = 1.0 + c.tilt * ratio
        by_slip = -c.slope * inclined * inclined * c.normal_force * velocity
        tangential = ratio * c.normal_force - c.tangential_force
    elif c.axial != 0.0:
        own_tangential, by_slip, travel = 1.0, step.position / c.axial, c.slip
        if c.held == 0.0:  # it rolls: its travel by the trapezoidal rule, whose start is in `travel`
            by_slip, travel = 0.5 * h * velocity / c.axial, c.travel + 0.5 * h * c.slip_rate
        tangential = axial_force(c, travel)
        for j in range(len(contacts.each)):
            tangential -= shared_flexibility(c, contacts.each[j]) / c.axial * contacts.each[j].tangential_force
    tangential -= by_slip * dot(tangential_row, increment)
    return Linear(status, over_depth, by_gap, normal, own_tangential, ratio, by_slip, tangential)


@inlined
def solve_contacts(contacts: Contacts, step: StepLength, w: Workspace) -> int:
    """Solve for the changes of all forces; add them to the increment of q'', the residual and the forces.

    The rows of the closed contacts are solved for.  Returns the status.
    """
    each, rows, closed, last = contacts.each, contacts.rows, 0, -1
    residual, increment = w.vectors[RESIDUAL], w.vectors[INCREMENT]
    for i in range(len(each)):
        c = each[i]
        if c.state != FREE:
            normal, tangential = rows[DIRECTION, i, 0], rows[DIRECTION, i, 1]
            c.a_nn = dot(normal, rows[RESPONSE, i, 0])
            c.a_nt = dot(normal, rows[RESPONSE, i, 1])
            c.a_tt = dot(tangential, rows[RESPONSE, i, 1])
            closed, last = closed + 1, i
    if closed == 0:
        return OK
    if closed == 1:
        status = _solve_one(contacts, last, increment, step)
    else:
        status = _solve_coupled(contacts.matrix, contacts, closed, increment, step)
    if status != OK:
        return status
    for i in range(len(each)):
        c = each[i]
        if c.state != FREE:
            dn, dt = c.normal_change, c.tangential_change
            c.normal_force += dn
            c.tangential_force += dt
            normal, tangential = rows[DIRECTION, i, 0], rows[DIRECTION, i, 1]
            to_normal, to_tangential = rows[RESPONSE, i, 0], rows[RESPONSE, i, 1]
            for j in range(increment.shape[0]):
                increment[j] += dn * to_normal[j] + dt * to_tangential[j]
                residual[j] += dn * normal[j] + dt * tangential[j]
    return OK


@jitable
def _solve_one(contacts: Contacts, i: int, increment: Array, step: StepLength) -> int:
    """Solve for the changes of the forces of the one closed contact; returns the status."""
    c, law = contacts.each[i], _linearize(contacts, i, increment, step)
    if law.status != OK:
        return law.status
    n1, n2 = 1.0 + law.by_gap * c.a_nn, law.by_gap * c.a_nt
    t1, t2 = law.by_slip * c.a_nt - law.ratio, law.own_tangential + law.by_slip * c.a_tt
    determinant = n1 * t2 - n2 * t1
    if determinant == 0.0:
        return NO_STICKING_SOLUTION
    c.normal_change = (law.normal * t2 - n2 * law.tangential) / determinant
    c.tangential_change = (n1 * law.tangential - law.normal * t1) / determinant
    return OK


@jitable
def _solve_coupled(
    matrix: Array | None, contacts: Contacts, closed: int, increment: Array, step: StepLength
) -> int:
    """Solve for the changes of the forces of several closed contacts; the compiler drops this of one."""
    if matrix is None:
        return OK
    each, rows, last, k = contacts.each, contacts.rows, 2 * closed, 0
    for i in range(len(each)):
        c = each[i]
        if c.state == FREE:
            continue
        law, column = _linearize(contacts, i, increment, step), 0
        if law.status != OK:
            return law.status
        normal, tangential = rows[DIRECTION, i, 0], rows[DIRECTION, i, 1]
        for j in range(len(each)):
            if each[j].state == FREE:
                continue
            for side in range(2):
                matrix[k, column + side] = law.by_gap * dot(normal, rows[RESPONSE, j, side])
                matrix[k + 1, column + side] = law.by_slip * dot(tangential, rows[RESPONSE, j, side])
            if j == i:
                matrix[k, column] += 1.0
                matrix[k + 1, column] -= law.ratio
                matrix[k + 1, column + 1] += law.own_tangential
            else:
                if bears(c) and bears(each[j]):
                    matrix[k, column] += law.by_depth * between_normals(contacts.compliance, i, j)
                if c.state == STICKING and c.axial != 0.0:
                    matrix[k + 1, column + 1] += shared_flexibility(c, each[j]) / c.axial
            column += 2
        matrix[k, last], matrix[k + 1, last] = law.normal, law.tangential
        k += 2
    if not eliminate(matrix, last):
        return NO_STICKING_SOLUTION
    k = 0
    for i in range(len(each)):
        if each[i].state != FREE:
            each[i].normal_change, each[i].tangential_change = matrix[k, last], matrix[k + 1, last]
            k += 2
    return OK


@jitable
def project_constraints(system: Any, contacts: Contacts, t: float, w: Workspace, y: Array) -> float:
    """Move q, then q', onto the constraints of contacts along the responses of the step; the work done (J).

    Contacts that stick keep their slip, but for axial flexibility behind it.  The velocity is left exact to
    rounding, because a step cut short divides what is left by its length.
    """
    each, rows, d, forces, done, m, last = (
        contacts.each,
        contacts.rows,
        w.vectors.shape[1],
        w.vectors[FORCES],
        0.0,
        0,
        0,
    )
    for i in range(len(each)):
        c = each[i]
        c.tangential_unknown = -1
        c.tangential_change = 0.0
        if c.state == STICKING and c.axial == 0.0:
            c.tangential_unknown = m
            m += 1
            last = i
    if m == 0:
        return 0.0
    for level in range(2):
        if level == 1:
            touch_contacts(system, contacts, t, y[:d], y[d : 2 * d], w)
        if not _take_corrections(contacts.matrix, contacts, last, level, m):
            return done
        for i in range(len(each)):
            tangential = each[i].tangential_change
            if tangential == 0.0:
                continue
            for j in range(d):
                move = tangential * rows[RESPONSE, i, 1, j]
                y[level * d + j] += move
                done += (1.0 - level) * forces[j] * move
    return done


@jitable
def _take_corrections(matrix: Array | None, contacts: Contacts, last: int, level: int, m: int) -> bool:
    """Multiples of the responses that take slips, or at level 1 their rates, to zero; False if singular.

    The compiler drops the equations of several contacts where there is one, `last`.
    """
    each, rows = contacts.each, contacts.rows
    if matrix is None:
        c = each[last]
        c.tangential_change = -(drift_of(c) if level == 0 else c.slip_rate) / c.a_tt
        return True
    for i in range(len(each)):
        c = each[i]
        k = c.tangential_unknown
        if k < 0:
            continue
        for j in range(len(each)):
            other = each[j]
            if other.tangential_unknown >= 0:
                matrix[k, other.tangential_unknown] = dot(rows[DIRECTION, i, 1], rows[RESPONSE, j, 1])
        matrix[k, m] = -drift_of(c) if level == 0 else -c.slip_rate
    if not eliminate(matrix, m):
        return False
    for i in range(len(each)):
        c = each[i]
        c.tangential_change = matrix[c.tangential_unknown, m] if c.tangential_unknown >= 0 else 0.0
    return True
