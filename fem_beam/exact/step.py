"""One step in time, and equilibrium at rest, by Newton's method.

A step of the length h from (q0, v0) to (q1, v1) is the mid-point rule for the inertia,

    M (v1 - v0)/h = f        r1 - r0 = h (v1 + v0)/2,   2 tan((phi1 - phi0)/2) = h (phi1' + phi0')/2

with internal forces whose work is the change of the strain energy
(:mod:`~oblique_impact.fem_beam.exact.step_forces`), so that

    T(v1) + V(q1) - T(v0) - V(q0) = work of the other forces on q1 - q0

holds whatever the length of the step (Simo and Tarnow 1992; Gonzalez 2000).  Momentum is conserved likewise, and
angular momentum: the rotations are those that a rigid body has in which places move by the mid-point rule (Simo,
Tarnow and Doblare 1995).

The matrix of the first iteration serves those after it as well, as long as each increment is far smaller than the
one before.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import LinAlgError, solve_banded

from oblique_impact.contact.state import FREE, STICKING, Candidate, Contacts
from oblique_impact.fem_beam.exact.exact_beam import ExactBeam, Stage
from oblique_impact.fem_beam.exact.point_loads import COLUMNS, add_point_forces, subtract_point_tangent
from oblique_impact.fem_beam.exact.root import (
    ARM,
    ROOT_NUMBERS,
    add_root,
    bind_matrix,
    bind_move,
    bind_row,
    stiffen_root,
)
from oblique_impact.fem_beam.exact.step_forces import (
    FIELDS,
    NODE,
    BeamData,
    add_forces,
    add_inertia,
    add_tangent,
    angle_of,
    set_to_inertia,
    take_fields,
    turn_forces,
    turn_inertia,
    turn_of,
    turn_rows,
)
from oblique_impact.fem_beam.exact.stop import TOUCHING, end_push, friction_at, mean_force, place_of, take_rows
from oblique_impact.kernels.band_rows import BANDWIDTH, factor_rows, new_rows, solve_rows_of
from oblique_impact.kernels.dense import eliminate
from oblique_impact.kernels.jit import by_reference, inlined, is_compiled, jitable, kernel
from oblique_impact.kernels.workspace import Array, copy, dot

#: Newton's iterations of a step; it takes two or three
MOST_ITERATIONS = 16
#: increments, relative to the length and to 1 rad, at which the iterations end: the next would be their square
CONVERGED = 1e-10
#: the matrix is a new one after a first increment beyond this, or where one is not so much smaller than the last
_LARGE, _SLOW = 1e-3, 0.1
#: points that hold the same place share its force: each yields by this part of what the beam itself would
_YIELDS = 1e-10
#: `NewtonBuffers.numbers`: mean normal force (N) of a contact, damping in it, its rate and that of friction (N/m),
#: the force that keeps it where it is if it sticks and the one that would keep its slip velocity as it is: what is
#: left of this from the last step, as little as it may be, takes a large force to reverse in a very short step
FORCE, DAMPED, RATE, DRAG, REACTION, KEEPING, BEGUN = range(7)
_NUMBERS = 7


class NotConvergedError(ArithmeticError):
    """Newton's iterations did not converge."""


class NewtonBuffers(NamedTuple):
    """Buffers of a step of a beam with n contacts, and what it results in."""

    begun: Array  # (elements, 2, 8) state at Gauss points at the start, to be given
    ended: Array  # and at the end
    drift: Array  # (d,) h v0
    move: Array  # (d,) q1 - q0: increments keep more digits than places
    q1: Array  # (d,)
    v1: Array  # (d,)
    load: Array  # (d,) mean forces from outside, to be given
    forces: Array  # (k, 7) those at places of the beam, see the module `point_loads`, to be given
    held: Array  # (3,) values of prescribed unknowns at the end, to be given
    root: Array  # (5,) the root that yields or turns on a radius, to be given
    spare: Array  # (d,)
    change: Array  # (d,) residual, then the increment
    rows: Array  # (d + 8, 17) matrix, then its factors
    normals: Array  # (n, d) rows of gap and slip over the step
    tangents: Array  # (n, d)
    directions: Array  # (n, d) of the force of the spring with its friction
    responses: Array  # (n, 2, d) to this, and to a tangential force
    matrix: Array  # (2 n, 2 n + 2) equations of the changes of these forces
    numbers: Array  # (n, 7) see above
    increments: Array  # (16,) of the iterations, relative

    @classmethod
    def new(cls, elements: int, contacts: int, forces: int = 0) -> NewtonBuffers:
        """Allocate them."""
        d, fields = NODE * (2 * elements + 1), (elements, 2, FIELDS)
        return cls(
            begun=np.zeros(fields),
            ended=np.zeros(fields),
            drift=np.zeros(d),
            move=np.zeros(d),
            q1=np.zeros(d),
            v1=np.zeros(d),
            load=np.zeros(d),
            forces=np.zeros((forces, COLUMNS)),
            held=np.zeros(NODE),
            root=np.zeros(ROOT_NUMBERS),
            spare=np.zeros(d),
            change=np.zeros(d),
            rows=new_rows(d),
            normals=np.zeros((contacts, d)),
            tangents=np.zeros((contacts, d)),
            directions=np.zeros((contacts, d)),
            responses=np.zeros((contacts, 2, d)),
            matrix=np.zeros((2 * contacts, 2 * contacts + 2)),
            numbers=np.zeros((contacts, _NUMBERS)),
            increments=np.zeros(MOST_ITERATIONS),
        )


@jitable
def take_newton_step(
    beam: BeamData,
    touchings: Any,
    contacts: Contacts,
    b: NewtonBuffers,
    q0: Array,
    v0: Array,
    h: float,
    relaxation: float,
    count: int,
    tolerance: float,
) -> int:
    """Take a step of the length h (s); returns how many iterations it took, 0 if they do not converge.

    The first `count` unknowns are prescribed.  `relaxation` is Kelvin-Voigt damping (s) over h, `tolerance` the
    increment at which the iterations end.
    """
    inertia, last, stale, length = 2.0 / (h * h), np.inf, True, beam.x[-1]
    b.numbers[:, :] = 0.0
    for i in range(b.numbers.shape[0]):
        if contacts.each[i].state == STICKING:
            b.numbers[i, BEGUN] = h * place_of(beam, touchings[i], q0, v0).slip_rate
    for j in range(q0.shape[0]):
        b.drift[j] = h * v0[j]
        drifted = angle_of(b.drift[j]) if j % NODE == 2 else b.drift[j]
        b.move[j] = b.held[j] - q0[j] if j < count else drifted
    bind_move(b.root, q0, b.move)
    for iteration in range(MOST_ITERATIONS):
        _take_residual(beam, b, q0, inertia, relaxation)
        forces = _push(beam, touchings, contacts, b, q0, h)
        if stale:
            set_to_inertia(beam, inertia, b.rows)
            turn_inertia(b.move, b.rows)
            add_tangent(beam, b.begun, b.ended, b.move, relaxation, b.rows)
            turn_rows(b.move, b.spare, b.rows)
            subtract_point_tangent(b.forces, b.q1, b.rows)
            stiffen_root(b.root, h, b.rows)
            bind_matrix(b.root, q0[2], b.q1[2], b.change, b.rows)
            if not factor_rows(b.rows, count):
                return 0
        _bind(contacts, b, q0, h)
        solve_rows_of(b.rows, count, b.change)
        if forces > 0 and not _add_contacts(contacts, b, forces, count):
            return 0
        size = 0.0
        for j in range(q0.shape[0]):
            b.move[j] += b.change[j]
            increment = abs(b.change[j]) / (length if j % NODE < 2 else 1.0)
            if not increment <= size:  # no number as well
                size = increment
        b.increments[iteration] = size
        if not size < np.inf:
            return 0
        bind_move(b.root, q0, b.move)
        if size < tolerance:
            for j in range(q0.shape[0]):
                b.q1[j] = q0[j] + b.move[j]
                b.v1[j] = 2.0 / h * (turn_of(b.move[j]) if j % NODE == 2 else b.move[j]) - v0[j]
            return iteration + 1
        stale = size > _LARGE if iteration == 0 else size > _SLOW * last
        last = size
    return 0


@jitable
def _take_residual(beam: BeamData, b: NewtonBuffers, q0: Array, inertia: float, relaxation: float) -> None:
    """Put load less internal forces and inertia into `change`, and the end of the step.

    Internal forces and inertia, with moments that belong to turns, stay in `spare`.
    """
    for j in range(q0.shape[0]):
        b.q1[j] = q0[j] + b.move[j]
        b.change[j] = (turn_of(b.move[j]) if j % NODE == 2 else b.move[j]) - b.drift[j]
        b.spare[j] = 0.0
    take_fields(beam, b.q1, b.ended)
    add_forces(beam, b.begun, b.ended, b.move, relaxation, b.spare)
    add_inertia(beam, inertia, b.change, b.spare)
    copy(b.spare, b.change)
    turn_forces(b.move, b.change)
    for j in range(q0.shape[0]):
        b.change[j] = b.load[j] - b.change[j]
    add_point_forces(b.forces, q0, b.q1, b.change)


@jitable
def take_end(
    beam: BeamData,
    touchings: Any,
    contacts: Contacts,
    b: NewtonBuffers,
    q0: Array,
    h: float,
    relaxation: float,
    count: int,
) -> float:
    """Take forces, rows and the state at Gauss points at the end of a step that has converged.

    Returns the work (J) of the forces on the `count` unknowns that are prescribed; those that hold the first node
    of a hub at its radius do none.
    """
    _take_residual(beam, b, q0, 2.0 / (h * h), relaxation)
    _push(beam, touchings, contacts, b, q0, h)
    _bind(contacts, b, q0, h)
    work = 0.0
    for j in range(0 if b.root[ARM] > 0.0 else count):
        force = -b.change[j]
        for i in range(b.numbers.shape[0]):
            force -= b.numbers[i, REACTION] * b.tangents[i, j]
        work += force * b.move[j]
    return work


@jitable
def _push(beam: BeamData, touchings: Any, contacts: Contacts, b: NewtonBuffers, q0: Array, h: float) -> int:
    """Add the forces of closed contacts to the residual; returns how many forces are unknown.

    They are the changes of normal forces with their friction, of friction with the slip velocity, and the forces
    that keep sticking points where they are.
    """
    forces = 0
    for i in range(b.numbers.shape[0]):
        c, numbers = contacts.each[i], b.numbers[i]
        if c.state == FREE:
            continue
        ends = take_rows(beam, touchings[i], q0, b.q1, b.normals[i], b.tangents[i])
        force, rate, numbers[DAMPED] = mean_force(c, ends, h)
        friction = friction_at(c, dot(b.tangents[i], b.move) / h)
        along = end_push(c, ends, beam.x[-1])
        numbers[FORCE], numbers[RATE] = force, rate
        numbers[DRAG] = 0.0 if c.state == STICKING else force * c.slope / h
        for j in range(q0.shape[0]):
            b.directions[i, j] = b.normals[i, j] + friction * b.tangents[i, j]
            b.change[j] += force * b.directions[i, j] + along * b.tangents[i, j]
        c.normal_unknown, c.tangential_unknown, forces = forces, -1, forces + 1
        if c.state == STICKING or numbers[DRAG] != 0.0:
            c.tangential_unknown, forces = forces, forces + 1
    return forces


@jitable
def _bind(contacts: Contacts, b: NewtonBuffers, q0: Array, h: float) -> None:
    """Add the moment at a root that yields to the residual; let the first node of a hub turn with its section."""
    add_root(b.root, q0[2], b.q1[2], h, b.change)
    if b.root[ARM] > 0.0:
        bind_row(b.root, q0[2], b.q1[2], b.change)
        for i in range(b.numbers.shape[0]):
            if contacts.each[i].state != FREE:
                bind_row(b.root, q0[2], b.q1[2], b.normals[i])
                bind_row(b.root, q0[2], b.q1[2], b.tangents[i])
                bind_row(b.root, q0[2], b.q1[2], b.directions[i])


@jitable
def _add_contacts(contacts: Contacts, b: NewtonBuffers, forces: int, count: int) -> bool:
    """Add what the unknown forces change to the increment, and keep those that hold sticking points.

    A place that slides along the beam couples elements that no band holds; so each of these forces has its
    response, and they follow from equations of their own.  Mean rows stand in for derivatives by the end of a
    step: they differ by what the beam turns in it.
    """
    n, each = b.numbers.shape[0], contacts.each
    for i in range(n):
        if each[i].state == FREE:
            continue
        copy(b.directions[i], b.responses[i, 0])
        solve_rows_of(b.rows, count, b.responses[i, 0])
        if each[i].tangential_unknown >= 0:
            copy(b.tangents[i], b.responses[i, 1])
            solve_rows_of(b.rows, count, b.responses[i, 1])
    for i in range(n):
        if each[i].state == FREE:
            continue
        # force: a - rate (row of the gap) . change = 0;  stick: (slip's row) . (move + change) = 0
        _take_equation(contacts, b, each[i].normal_unknown, 1.0, b.normals[i], b.numbers[i, RATE], forces)
        own = each[i].tangential_unknown
        if own < 0:
            continue
        if each[i].state != STICKING:
            _take_equation(contacts, b, own, 1.0, b.tangents[i], b.numbers[i, DRAG], forces)
            continue
        _take_equation(contacts, b, own, 0.0, b.tangents[i], 1.0, forces)
        moved = dot(b.tangents[i], b.move)
        b.matrix[own, own] *= 1.0 + _YIELDS
        b.matrix[own, forces] += moved
        b.matrix[own, forces + 1] += moved - b.numbers[i, BEGUN]
    for row in range(forces):
        scale = abs(b.matrix[row, row])
        for column in range(forces + 2):
            b.matrix[row, column] /= scale
    if not eliminate(b.matrix, forces, 2):
        return False
    for i in range(n):
        if each[i].state == FREE:
            continue
        _add_response(b, b.matrix[each[i].normal_unknown, forces], b.responses[i, 0])
        own = each[i].tangential_unknown
        if own < 0:
            continue
        _add_response(b, b.matrix[own, forces], b.responses[i, 1])
        if each[i].state == STICKING:
            b.numbers[i, REACTION], b.numbers[i, KEEPING] = b.matrix[own, forces], b.matrix[own, forces + 1]
    return True


@jitable
def _take_equation(
    contacts: Contacts, b: NewtonBuffers, own: int, unit: float, row: Array, factor: float, forces: int
) -> None:
    """Take the equation unit a - factor row . (free change + responses) = 0 of an unknown force a."""
    for k in range(b.numbers.shape[0]):
        c = contacts.each[k]
        if c.state == FREE:
            continue
        b.matrix[own, c.normal_unknown] = -factor * dot(row, b.responses[k, 0])
        if c.tangential_unknown >= 0:
            b.matrix[own, c.tangential_unknown] = -factor * dot(row, b.responses[k, 1])
    b.matrix[own, own] += unit
    b.matrix[own, forces] = b.matrix[own, forces + 1] = factor * dot(row, b.change)


@inlined
def _add_response(b: NewtonBuffers, force: float, response: Array) -> None:
    for j in range(response.shape[0]):
        b.change[j] += force * response[j]


@kernel("the step of the exact beam")
def _solve_step(
    beam: BeamData,
    touchings: Any,
    contacts: Contacts,
    b: NewtonBuffers,
    q0: Array,
    v0: Array,
    h: float,
    relaxation: float,
    count: int,
    tolerance: float,
) -> int:
    beam, contacts, b = by_reference(beam), by_reference(contacts), by_reference(b)
    take_fields(beam, q0, b.begun)
    return take_newton_step(beam, touchings, contacts, b, q0, v0, h, relaxation, count, tolerance)


class SolvedStep(NamedTuple):
    """Result of a step."""

    stage: Stage  # at its end
    increments: tuple[float, ...]  # of Newton's iterations, relative


def advance(
    beam: ExactBeam,
    start: Stage,
    length: float,
    load: Array,
    *,
    held: Array,
    root: Sequence[float] = (),
    viscosity: float = 0.0,
    contacts: Sequence[tuple[Any, Candidate]] = (),
    tolerance: float = CONVERGED,
) -> SolvedStep:
    """Return the step of the given length (s).

    Parameters
    ----------
    beam : ExactBeam
        The beam.
    start : Stage
        At the beginning of the step.
    length : float
        s.
    load : ndarray, shape (3 n,)
        Mean forces from outside.
    held : ndarray, shape (held,)
        Values at the end of the step of the first unknowns, which are prescribed.
    root : sequence of float
        Numbers of a root that yields or turns on a radius, see the module ``root``.
    viscosity : float
        Kelvin-Voigt damping (s).
    contacts : sequence of pairs
        Records ``TOUCHING`` of the module ``stop``, with the states and laws of the contacts.
    tolerance : float
        Increment at which the iterations end, relative to the length and to 1 rad.

    Raises
    ------
    NotConvergedError
        If Newton's iterations do not converge.
    """
    touchings = np.array([record for record, _ in contacts], dtype=TOUCHING).view(np.recarray)
    states = Contacts.new([state for _, state in contacts], beam.size, is_compiled(beam.data))
    b = NewtonBuffers.new(len(beam.points), len(contacts))
    b.load[:], b.held[: held.size], b.root[: len(root)] = load, held, root
    numbers = length, viscosity / length, held.size, tolerance
    found = _solve_step(beam.data, touchings, states, b, start.q, start.v, *numbers)
    increments = tuple(b.increments[: found or MOST_ITERATIONS].tolist())
    if not found:
        raise NotConvergedError(f"increments {', '.join(f'{i:.1e}' for i in increments)}")
    return SolvedStep(Stage(b.q1, b.v1), increments)


def equilibrium(beam: ExactBeam, q: Array, load: Array, held: int) -> Array:
    """Return nodal values at rest under dead loads (3 n,).

    Parameters
    ----------
    beam : ExactBeam
        The beam.
    q : ndarray, shape (3 n,)
        Where the iterations start; the first `held` unknowns stay.
    load : ndarray, shape (3 n,)
        Forces (N) and moments (N m).
    held : int
        2 for a pin, 3 for a clamped root.

    Raises
    ------
    NotConvergedError
        If Newton's iterations do not converge: put the load on in steps.
    """
    increments: list[float] = []
    for _ in range(5 * MOST_ITERATIONS):
        internal = beam.static_forces(q)
        change = np.zeros(q.size)
        try:
            bands = internal.tangent[:, held:]
            change[held:] = solve_banded((BANDWIDTH, BANDWIDTH), bands, (load - internal.forces)[held:])
        except (LinAlgError, ValueError):  # singular, or no number
            break
        q = q + change
        increments.append(float(np.max(np.abs(change / beam.scale))))
        if increments[-1] < CONVERGED:
            return q
        if not np.isfinite(increments[-1]):
            break
    raise NotConvergedError(f"increments {', '.join(f'{i:.1e}' for i in increments[-5:])}")
