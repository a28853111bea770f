"""The exact beam over a step of :mod:`oblique_impact.marching.time_stepping`, as its protocol asks for it.

Residuals have the internal forces of a whole step, whose work is the change of the strain energy, in the place of
those in its middle.  Steps to which a root is moved are prescribed: the accelerations of its unknowns are those
that lead there, and what their equations leave is the force of the drive.
"""

from __future__ import annotations

from oblique_impact.contact.state import Candidate, Contacts
from oblique_impact.fem_beam.exact.exact_system import (
    LENGTH,
    MIDDLE,
    ExactModel,
    hold_at,
    load_at,
    work_of_drives,
)
from oblique_impact.fem_beam.exact.step_forces import (
    NODE,
    add_forces,
    add_inertia,
    add_tangent,
    damping_loss,
    set_to_inertia,
    take_fields,
)
from oblique_impact.fem_beam.exact.stop import place_of, rows_at
from oblique_impact.kernels.band_rows import BANDWIDTH, factor_rows, solve_rows_of
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import (
    INCREMENT,
    RESIDUAL,
    SCRATCH_A,
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
    hold_at(model, t + h, step.moved)
    for j in range(NODE):
        step.moved[j] = step.moved[j] - q[j] if model.numbers.held == NODE else 0.0
    step.times[LENGTH], step.times[MIDDLE] = h, t + 0.5 * h


@jitable
def take_residual(model: ExactModel, t: float, q: Array, qd: Array, qdd: Array, w: Workspace) -> Evaluation:
    """Take the residual of a step with the means q and q' and the acceleration q''.

    Of a prescribed unknown it is what is missing of its acceleration.
    """
    step, beam, numbers = model.step, model.beam, model.numbers
    residual, supply, end, h = w.vectors[RESIDUAL], w.vectors[SUPPLY], w.vectors[SCRATCH_A], step.times[LENGTH]
    for j in range(q.shape[0]):
        end[j] = step.q[j] + h * qd[j]
        residual[j] = supply[j] = 0.0
    take_fields(beam, end, step.ended)
    add_forces(beam, step.begun, step.ended, numbers.kelvin_voigt / h, residual)
    add_inertia(beam, 1.0, qdd, residual)
    for j in range(q.shape[0]):
        residual[j] = step.load[j] - residual[j]
    power = work_of_drives(model, t, qd)
    for i in range(numbers.held if numbers.held == NODE else 0):
        power -= residual[i] * qd[i]
        missing = 2.0 * (step.moved[i] - h * qd[i]) / (h * h)
        residual[i] = missing
        # the force of the drive changes with the accelerations that are still to come
        for j in range(i + BANDWIDTH + 1):
            supply[j] += 0.5 * h * h * step.rows[i, BANDWIDTH + j - i] * qd[i]
    power -= dot(supply, qdd)
    return Evaluation(0.0, power, 0.0)


@jitable
def factor_effective(
    model: ExactModel, t: float, q: Array, velocity: float, position: float, w: Workspace, slot: int, stale: bool
) -> bool:
    """Factor the derivatives of a step's residual by its end."""
    step, numbers, h = model.step, model.numbers, model.step.times[LENGTH]
    set_to_inertia(model.beam, 2.0 / (h * h), step.rows)
    add_tangent(model.beam, step.begun, step.ended, numbers.kelvin_voigt / h, step.rows)
    return bool(factor_rows(step.rows, numbers.held))


@jitable
def solve_effective(
    model: ExactModel, rank_one: float, w: Workspace, slot: int, contacts: Contacts, closed: bool
) -> None:
    """Increments of q'' by the residual."""
    step, held, residual, x = model.step, model.numbers.held, w.vectors[RESIDUAL], w.vectors[INCREMENT]
    copy(residual, x)
    scale = 2.0 / (step.times[LENGTH] * step.times[LENGTH])
    for i in range(held, held + BANDWIDTH if held == NODE else 0):
        for j in range(max(0, i - BANDWIDTH), held):
            x[i] -= step.rows[i, BANDWIDTH + j - i] / scale * residual[j]
    solve_rows_of(step.rows, held, x)
    for j in range(x.shape[0]):
        x[j] *= scale
    for j in range(held if held == NODE else 0):
        x[j] = residual[j]


@jitable
def solve_rows(
    model: ExactModel, rank_one: float, w: Workspace, slot: int, sides: int, rows: Array, responses: Array
) -> None:
    """Accelerations by unit forces along contact rows."""
    step = model.step
    scale = 2.0 / (step.times[LENGTH] * step.times[LENGTH])
    for k in range(rows.shape[0]):
        for a in range(sides):
            x = responses[k, a]
            copy(rows[k, a], x)
            solve_rows_of(step.rows, model.numbers.held, x)
            for j in range(x.shape[0]):
                x[j] *= scale


@jitable
def damping_at(model: ExactModel, t: float, q: Array, qd: Array, w: Workspace) -> float:
    """Mean power (W) that damping takes in the step with the means q and q'."""
    step, kelvin_voigt, end = model.step, model.numbers.kelvin_voigt, w.vectors[SCRATCH_A]
    if kelvin_voigt == 0.0:
        return 0.0
    h = step.times[LENGTH]
    for j in range(q.shape[0]):
        end[j] = step.q[j] + h * qd[j]
    take_fields(model.beam, end, step.ended)
    return float(damping_loss(model.beam, step.begun, step.ended, kelvin_voigt / h) / h)


@jitable
def touch(
    model: ExactModel, i: int, t: float, q: Array, qd: Array, w: Workspace, c: Candidate, rows: Array
) -> None:
    """Kinematics of one place.

    Rows leave out prescribed unknowns, whose part of the rates in a step that has begun is a mean.
    """
    step, touching = model.step, model.touchings[i]
    place = place_of(model.beam, touching, q, qd)
    c.gap, c.slip, c.gap_rate, c.slip_rate = place.gap, place.slip, place.gap_rate, place.slip_rate
    rows_at(model.beam, touching, q, rows[0], rows[1])
    for j in range(model.numbers.held):
        if t == step.times[MIDDLE]:
            more = step.moved[j] / step.times[LENGTH] - qd[j]
            c.gap_rate += more * rows[0, j]
            c.slip_rate += more * rows[1, j]
        rows[0, j] = rows[1, j] = 0.0


@jitable
def measure(model: ExactModel, t: float, q: Array, qd: Array, w: Workspace, contacts: Contacts) -> None:
    """Gap, slip and rates of all places."""
    for i in range(len(contacts.each)):
        c, place = contacts.each[i], place_of(model.beam, model.touchings[i], q, qd)
        c.gap, c.slip, c.gap_rate, c.slip_rate = place.gap, place.slip, place.gap_rate, place.slip_rate


@inlined
def set_massless(model: ExactModel, mean: Array, v: Array) -> None:
    """Do nothing: all places have inertia."""


class SteppedModel(ExactModel):
    """The exact beam with rigid obstacles: a class of its own, so that others compile without it."""

    __slots__ = ()
    described = "the exact beam with rigid obstacles"

    begin_step = begin_step
    take_residual = take_residual
    factor_effective = factor_effective
    solve_effective = solve_effective
    solve_rows = solve_rows
    damping_at = damping_at
    touch = touch
    measure = measure
    set_massless = set_massless
