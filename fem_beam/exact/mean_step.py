"""The exact beam over a step of :mod:`oblique_impact.marching.time_stepping`, as its protocol asks for it.

Residuals have the internal forces of a whole step, whose work is the change of the strain energy, in the place of
those in its middle.  As in :mod:`~oblique_impact.fem_beam.exact.step` mean angular velocities are those of turns
2 tan(Delta phi/2), and moments belong to these.

The first node moves as its root does.  Of a driven one the accelerations are those that lead where it is at the
end of the step, and what their equations leave is the force of the drive; a hub's turns with its section.
"""

from __future__ import annotations

from oblique_impact.contact.state import Candidate, Contacts
from oblique_impact.fem_beam.exact.exact_system import (
    LENGTH,
    MIDDLE,
    ExactModel,
    drive_forces,
    hold_at,
    load_at,
    take_root,
)
from oblique_impact.fem_beam.exact.point_loads import add_point_forces, subtract_point_tangent, take_point_forces
from oblique_impact.fem_beam.exact.root import (
    ANGLE_AFTER,
    ANGLE_BEFORE,
    ARM,
    bind_matrix,
    bind_row,
    levers,
    root_loss,
    root_moment,
    stiffen_root,
)
from oblique_impact.fem_beam.exact.step_forces import (
    NODE,
    add_forces,
    add_inertia,
    add_tangent,
    angle_of,
    damping_loss,
    set_to_inertia,
    take_fields,
    turn_of,
    turn_ratio,
)
from oblique_impact.fem_beam.exact.stop import place_of, rows_at
from oblique_impact.kernels.band_rows import BANDWIDTH, factor_rows, solve_rows_of
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import (
    INCREMENT,
    RESIDUAL,
    SCRATCH_A,
    SCRATCH_B,
    SUPPLY,
    Array,
    Evaluation,
    Workspace,
    copy,
    dot,
)


@jitable
def begin_step(model: ExactModel, t: float, h: float, q: Array, w: Workspace) -> None:
    """Begin a step of the length h (s) from t and q (d,)."""
    step = model.step
    copy(q, step.q)
    take_fields(model.beam, q, step.begun)
    load_at(model, t + 0.5 * h, step.load)
    take_point_forces(model.forces, t + 0.5 * h, step.forces)
    take_root(model, t, h, step.root)
    hold_at(model, t + h, step.moved)
    for j in range(NODE):
        step.moved[j] = step.moved[j] - q[j] if model.numbers.driven else 0.0
    step.moved[2] = turn_of(step.moved[2])
    step.times[LENGTH], step.times[MIDDLE] = h, t + 0.5 * h


@inlined
def end_step(model: ExactModel, h: float, q: Array, qd: Array, end: Array) -> None:
    """Put the rotations at the end of a step from q with the mean velocities q' into `end`."""
    for j in range(2, q.shape[0], NODE):
        end[j] = q[j] + angle_of(h * qd[j])


@jitable
def _move(model: ExactModel, qd: Array, end: Array) -> None:
    """Take displacements and state at Gauss points at the end of the step with the mean velocities q'."""
    step = model.step
    for j in range(qd.shape[0]):
        moved = step.times[LENGTH] * qd[j]
        step.move[j] = angle_of(moved) if j % NODE == 2 else moved
        end[j] = step.q[j] + step.move[j]
    take_fields(model.beam, end, step.ended)


@jitable
def take_residual(model: ExactModel, t: float, q: Array, qd: Array, qdd: Array, w: Workspace) -> Evaluation:
    """Take the residual of a step with the mean velocities q' and the acceleration q''.

    Of an unknown that moves as the root does it is what is missing of its acceleration.
    """
    step, beam, numbers, root = model.step, model.beam, model.numbers, model.step.root
    residual, supply, end, h = w.vectors[RESIDUAL], w.vectors[SUPPLY], w.vectors[SCRATCH_A], step.times[LENGTH]
    _move(model, qd, end)
    for j in range(q.shape[0]):
        residual[j] = supply[j] = 0.0
    driving = w.vectors[SCRATCH_B]
    drive_forces(model, t, driving)
    add_forces(beam, step.begun, step.ended, step.move, numbers.kelvin_voigt / h, residual)
    add_inertia(beam, 1.0, qdd, residual)
    moment, (ratio, _) = root_moment(root, step.q[2], end[2], h), turn_ratio(step.move[2])
    for j in range(q.shape[0]):
        load = step.load[j] - (moment if j == 2 else 0.0)
        residual[j] = (load / turn_ratio(step.move[j])[0] if j % NODE == 2 else load) - residual[j]
    add_point_forces(step.forces, step.q, end, residual)
    add_point_forces(step.forces, step.q, end, driving)
    power = (dot(driving, step.move) - moment * (root[ANGLE_AFTER] - root[ANGLE_BEFORE])) / h
    for j in range(q.shape[0]):  # powers change with the accelerations that are still to come
        supply[j] = 0.5 * h * driving[j]
    step.pull[0], step.pull[1] = residual[0], residual[1]
    if numbers.driven:
        for i in range(numbers.held):
            power -= residual[i] * qd[i]
            for j in range(i + BANDWIDTH + 1):
                supply[j] += 0.5 * h * h * step.rows[i, BANDWIDTH + j - i] * qd[i]
    power -= dot(supply, qdd)
    if root[ARM] > 0.0:
        lever, _, _ = levers(root, step.q[2], end[2])
        residual[2] += (lever.real * step.pull[0] + lever.imag * step.pull[1]) / ratio
        step.moved[0], step.moved[1] = lever.real * step.move[2], lever.imag * step.move[2]
    for i in range(numbers.held):
        residual[i] = 2.0 * (step.moved[i] - h * qd[i]) / (h * h)
    return Evaluation(0.0, power, 0.0)


@jitable
def factor_effective(
    model: ExactModel, t: float, q: Array, velocity: float, position: float, w: Workspace, slot: int, stale: bool
) -> bool:
    """Factor the derivatives of a step's residual by its end, but for the difference of turns and angles."""
    step, h = model.step, model.step.times[LENGTH]
    set_to_inertia(model.beam, 2.0 / (h * h), step.rows)
    add_tangent(model.beam, step.begun, step.ended, step.move, model.numbers.kelvin_voigt / h, step.rows)
    subtract_point_tangent(step.forces, w.vectors[SCRATCH_A], step.rows)
    stiffen_root(step.root, h, step.rows)
    bind_matrix(step.root, step.q[2], step.q[2] + step.move[2], step.pull, step.rows)
    return bool(factor_rows(step.rows, model.numbers.held))


@jitable
def _solve(model: ExactModel, x: Array) -> None:
    """Solve for accelerations of the unknowns behind those that move as the root does; a hub's turns."""
    step = model.step
    scale = 2.0 / (step.times[LENGTH] * step.times[LENGTH])
    solve_rows_of(step.rows, model.numbers.held, x)
    for j in range(x.shape[0]):
        x[j] *= scale
    if step.root[ARM] > 0.0:
        _, _, turned = levers(step.root, step.q[2], step.q[2] + step.move[2])
        x[0], x[1] = turned.real * x[2], turned.imag * x[2]


@jitable
def solve_effective(
    model: ExactModel, rank_one: float, w: Workspace, slot: int, contacts: Contacts, closed: bool
) -> None:
    """Increments of q'' by the residual."""
    step, held, residual, x = model.step, model.numbers.held, w.vectors[RESIDUAL], w.vectors[INCREMENT]
    copy(residual, x)
    share = 0.5 * step.times[LENGTH] * step.times[LENGTH]
    for i in range(held, held + BANDWIDTH):
        for j in range(max(0, i - BANDWIDTH), held):
            x[i] -= share * step.rows[i, BANDWIDTH + j - i] * residual[j]
    _solve(model, x)
    for j in range(held):
        x[j] += residual[j]


@jitable
def solve_rows(
    model: ExactModel, rank_one: float, w: Workspace, slot: int, sides: int, rows: Array, responses: Array
) -> None:
    """Accelerations by unit forces along contact rows."""
    for k in range(rows.shape[0]):
        for a in range(sides):
            copy(rows[k, a], responses[k, a])
            _solve(model, responses[k, a])


@jitable
def damping_at(model: ExactModel, t: float, q: Array, qd: Array, w: Workspace) -> float:
    """Mean power (W) that damping takes in the step with the mean velocities q'."""
    step, kelvin_voigt, h = model.step, model.numbers.kelvin_voigt, model.step.times[LENGTH]
    _move(model, qd, w.vectors[SCRATCH_A])
    lost = root_loss(step.root, step.q[2], step.q[2] + step.move[2], h)
    if kelvin_voigt > 0.0:
        lost += damping_loss(model.beam, step.begun, step.ended, kelvin_voigt / h)
    return float(lost / h)


@jitable
def touch(
    model: ExactModel, i: int, t: float, q: Array, qd: Array, w: Workspace, c: Candidate, rows: Array
) -> None:
    """Kinematics of one place.

    Rows leave out what moves as the root does.  In a step that has begun the part of a driven root in the rates is
    its mean, and that of a hub's first node follows its section.
    """
    step, touching = model.step, model.touchings[i]
    place = place_of(model.beam, touching, q, qd)
    c.gap, c.slip, c.gap_rate, c.slip_rate = place.gap, place.slip, place.gap_rate, place.slip_rate
    rows_at(model.beam, touching, q, rows[0], rows[1])
    turns = step.root[ARM] > 0.0
    _, _, turned = levers(step.root, q[2], q[2])
    for j in range(model.numbers.held if t == step.times[MIDDLE] else 0):
        mean = step.moved[j] / step.times[LENGTH]
        if turns:
            mean = (turned.real if j == 0 else turned.imag) * qd[2]
        c.gap_rate += (mean - qd[j]) * rows[0, j]
        c.slip_rate += (mean - qd[j]) * rows[1, j]
    if turns:
        bind_row(step.root, q[2], q[2], rows[0])
        bind_row(step.root, q[2], q[2], rows[1])
    for j in range(model.numbers.held):
        rows[0, j] = rows[1, j] = 0.0


@inlined
def set_massless(model: ExactModel, mean: Array, v: Array) -> None:
    """Do nothing: all places have inertia."""


class SteppedModel(ExactModel):
    """The exact beam with rigid obstacles: a class of its own, so that others compile without it."""

    __slots__ = ()
    described = "the exact beam with rigid obstacles"

    begin_step = begin_step
    end_step = end_step
    take_residual = take_residual
    factor_effective = factor_effective
    solve_effective = solve_effective
    solve_rows = solve_rows
    damping_at = damping_at
    touch = touch
    set_massless = set_massless
