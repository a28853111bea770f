"""Time-stepping of the exact beam: energy-consistent steps, transitions located within them.

Steps are those of :mod:`~oblique_impact.fem_beam.exact.step`.  Near obstacles they are chosen by their error: the
mid-point rule errs in places by h^3/12 of the rate of the acceleration, which is that from the mean acceleration
of one step to that of the next.  A step that is too long is taken again.  Where a gap would fall below zero and
rise again within a step, this is shortened too.

A trial step decides between stick and slip.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.forces import OK, guards_of
from oblique_impact.contact.state import END, FREE, GUARDS, LOWER, SLIDING, STICKING, UPPER, Candidate, Contacts
from oblique_impact.contact.transitions import StickCriterion
from oblique_impact.fem_beam.exact.averages import Averages
from oblique_impact.fem_beam.exact.exact_system import ExactModel, drive_forces, hold_at, load_at, take_root
from oblique_impact.fem_beam.exact.point_loads import add_point_forces, take_point_forces
from oblique_impact.fem_beam.exact.root import ANGLE_AFTER, ANGLE_BEFORE, root_loss, root_moment
from oblique_impact.fem_beam.exact.step import (
    DAMPED,
    FORCE,
    KEEPING,
    REACTION,
    NewtonBuffers,
    take_end,
    take_newton_step,
)
from oblique_impact.fem_beam.exact.step_forces import NODE, damping_loss, mean_resultants, take_fields
from oblique_impact.fem_beam.exact.stop import (
    Ends,
    Place,
    force_at,
    friction_at,
    mean_force,
    place_of,
)
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array, copy, dot
from oblique_impact.marching.advance import (
    FAILED_ITERATION,
    Limits,
    Position,
    Step,
    StepState,
    keep_sample,
    refused,
)
from oblique_impact.marching.buffers import AT, KEPT, NEXT, NO_GUARD, VALUES, Scratch
from oblique_impact.marching.equations import (
    DAMPING_LOSS,
    FRICTION_LOSS,
    NORMAL_IMPULSE,
    OF_A_CONTACT,
    QUADRATURES,
    STOP_LOSS,
    SUPPLIED,
    TANGENTIAL_IMPULSE,
)
from oblique_impact.marching.location import cubic_dip, find_fall
from oblique_impact.marching.scheme import Prepared, Scheme, Task

#: a guard that has fallen within this part of a step has fallen at its beginning; how closely others are located
_AT_ONCE, _CLOSE = 1e-6, 1e-12
#: part of a step that decides between stick and slip after each transition at the same instant, and how often
_SHORTER, _SHORTEST = 0.1, 6
#: increment, over the length or 1 rad, at which Newton's iterations of a step end: what they leave of its energy
#: is rounding then
_CONVERGED = 1e-11
#: of the step that the error asks for; a step whose error is beyond so many tolerances is taken again; bounds of
#: the next step over the last one
_SAFETY, _TOO_MUCH, _SHRINK, _GROW = 0.9, 2.0, 0.2, 3.0
#: of the shortest step: the accelerations of shorter ones are rounding
_LONG_ENOUGH = 0.5
#: steps of a call, some hundredths of a second
_STEPS_PER_CALL = 256
#: of a call that takes as many: a step and two requests at most of each, and those where it begins
_LOGGED = 3 * _STEPS_PER_CALL + 3
_NO_LIMITS = Limits(inf, inf, inf, 0)

# `ExactBuffers.places`: at the start of a step and at its end
BEFORE, AFTER = 0, 1
GAP, SLIP, GAP_RATE, SLIP_RATE, PLACE = range(5)
# `ExactBuffers.pace`, s: where the march is and the next stop or sample; the step that the error asks for; the
# time from the middle of the last step to the present
TIME, UNTIL, CHOSEN, SINCE = range(4)
# `ExactBuffers.counts`: transitions that have followed each other at one instant, entries of the log, whether a
# part of a step has not converged
AT_ONCE, ENTRIES, FAILED = range(3)
# kinds of entries in the log
CUT, REQUEST, BEGINNING, STEP = range(4)


class ExactBuffers(NamedTuple):
    """Buffers of a run with n contacts."""

    step: NewtonBuffers
    places: Array  # (2, n, 5) contacts at the start of a step and at its end, see above
    acceleration: Array  # (d,) mean of the last step
    pace: Array  # (4,) see above
    counts: NDArray[np.int64]  # (3,) see above
    log: Array  # (entries, 3 + 6 elements + n): kind, start and end (s) of a step, its mean forces

    @classmethod
    def new(cls, elements: int, n: int, forces: int) -> ExactBuffers:
        """Allocate them for a beam with n contacts and a number of forces."""
        return cls(
            NewtonBuffers.new(elements, n, forces),
            np.zeros((2, n, 5)),
            np.zeros(NODE * (2 * elements + 1)),
            np.zeros(4),
            np.zeros(3, dtype=np.int64),
            np.zeros((_LOGGED, 3 + 6 * elements + n)),
        )


class Recorder:
    """Buffers of a run, and the mean forces of its steps at the instants that are reported."""

    def __init__(self, buffers: ExactBuffers) -> None:
        self.buffers, self.averages = buffers, Averages()

    def take_log(self) -> None:
        """Take what the steps of the last call have logged."""
        b, averages = self.buffers, self.averages
        rows = b.log[: b.counts[ENTRIES]].copy()
        for (kind, start, end), forces in zip(rows[:, :3].tolist(), rows[:, 3:], strict=True):
            if kind == STEP:
                averages.add(start, end, forces)
            elif kind == CUT:
                averages.cut()
            else:
                averages.request(start, begins=kind == BEGINNING)
        b.counts[ENTRIES] = 0


class ExactStepper(NamedTuple):
    """Steps of the exact beam in one phase; a `Stepper`."""

    system: ExactModel
    contacts: Contacts
    free_step: float  # s
    shortest: float  # s, step near obstacles
    near: float  # m, of an obstacle
    tolerance: float
    limits: Limits
    scratch: Scratch
    buffers: ExactBuffers

    def begin(self, start: StepState, y: Array) -> tuple[int, float]:
        """Take the state; section forces may jump where a phase begins or the root's motion is not smooth."""
        b, d = self.buffers, self.buffers.acceleration.shape[0]
        b.pace[TIME] = start.t
        take_fields(self.system.beam, y[:d], b.step.begun)
        _take_places(self, BEFORE, y[:d], y[d : 2 * d])
        cut = start.taken == 0
        for k in range(self.system.jumps.shape[0]):
            cut = cut or start.t == self.system.jumps[k]
        if cut:
            _enter(b, CUT, start.t, start.t)
        if start.taken == 0:
            _enter(b, BEGINNING, start.t, start.t)
        return OK, _distance(self)

    def length(self, gap: float, h: float) -> float:
        """Equal steps to the next output instant, near an obstacle at most as long as the error asks for."""
        pace, samples, longest = self.buffers.pace, self.scratch.samples, self.free_step
        if gap < self.near:
            longest = min(max(pace[CHOSEN], self.shortest), self.free_step)
        instant, stop = samples.counts[NEXT] * self.limits.interval, self.limits.t_stop
        pace[UNTIL] = instant if instant < stop - 1e-9 * self.limits.interval else stop
        left = pace[UNTIL] - pace[TIME]
        return float(left / max(1, ceil(left / longest - 1e-9)))

    def take(self, now: Position, length: float, end: float, y: Array) -> Step:
        """Take a step, or the part of it up to the first guard that falls."""
        b, close = self.buffers, now.gap < self.near and length > self.shortest * (1.0 + 1e-9)
        b.counts[FAILED] = 0
        if length >= (b.pace[UNTIL] - now.t) * (1.0 - 1e-12):
            end = float(b.pace[UNTIL])
        if not _solve(self, now.t, length, y):
            return _shorter(self, 0.25 * length) if close else _fail(self, now.t)
        error = _error(self, length, y)
        if close and error > _TOO_MUCH:
            return _shorter(self, length * max(_SHRINK, _SAFETY * error ** (-1.0 / 3.0)))
        if close and _dips(self, length):
            return _shorter(self, 0.5 * length)
        guard, part = _first_fall(self, now.t, length, y)
        if b.counts[FAILED]:
            return _fail(self, now.t)
        if guard == NO_GUARD:
            _accept(self, now.t, end, length, y)
            _choose(self, length, error)
            return Step(OK, True, end, length, NO_GUARD, _distance(self))
        if part > 0.0:
            length *= part
            if not _solve(self, now.t, length, y):
                return _fail(self, now.t)
            error = _error(self, length, y)
            _accept(self, now.t, now.t + length, length, y)
            _choose(self, length, error)
            guard = _decide(self, b.pace[TIME], guard, self.scratch.y_new)
            b.counts[AT_ONCE] = 0
        else:
            guard = _decide(self, now.t, guard, y)
            b.counts[AT_ONCE] += 1
            _enter(b, REQUEST, now.t, now.t)
        if b.counts[FAILED]:
            return _fail(self, b.pace[TIME])
        return Step(OK, part > 0.0, float(b.pace[TIME]), length, guard, _distance(self))

    def arrive(self, step: Step, y: Array) -> Step:
        """Keep a sample if one is due."""
        counts = self.scratch.samples.counts
        kept = counts[KEPT]
        if step.guard == NO_GUARD:
            keep_sample(step.end, y, self.limits, self.scratch.samples)
        if step.guard != NO_GUARD or counts[KEPT] > kept or step.end == self.limits.t_stop:
            _enter(self.buffers, REQUEST, step.end, step.end)
        return step


@inlined
def _enter(b: ExactBuffers, kind: int, start: float, end: float) -> int:
    """Enter something in the log; returns the row."""
    row = int(b.counts[ENTRIES])
    b.log[row, 0], b.log[row, 1], b.log[row, 2] = kind, start, end
    b.counts[ENTRIES] = row + 1
    return row


@inlined
def _shorter(stepper: ExactStepper, length: float) -> Step:
    """Return a step that is to be taken again with a shorter length (s)."""
    stepper.buffers.pace[CHOSEN] = max(length, stepper.shortest)
    return refused(OK, stepper.buffers.pace[CHOSEN])


@inlined
def _fail(stepper: ExactStepper, t: float) -> Step:
    """Return a step that does not converge."""
    _enter(stepper.buffers, REQUEST, t, t)
    return refused(-FAILED_ITERATION, 0.0)


@jitable
def _take_places(stepper: ExactStepper, which: int, q: Array, v: Array) -> None:
    """Take gaps, slips, their rates and places along the beam of all contacts at a state."""
    places, model = stepper.buffers.places, stepper.system
    for i in range(places.shape[1]):
        at = place_of(model.beam, model.touchings[i], q, v)
        places[which, i, GAP], places[which, i, SLIP] = at.gap, at.slip
        places[which, i, GAP_RATE], places[which, i, SLIP_RATE] = at.gap_rate, at.slip_rate
        places[which, i, PLACE] = at.x


@inlined
def _distance(stepper: ExactStepper) -> float:
    """Smallest distance (m) of a place that can touch, negative in contact."""
    b, least = stepper.buffers, np.inf
    for i in range(b.places.shape[1]):
        least = min(least, stepper.contacts.each[i].side * b.places[BEFORE, i, GAP])
    return least


@jitable
def _solve(stepper: ExactStepper, t: float, length: float, y: Array) -> bool:
    """Solve for a step from (t, y), whose state at Gauss points is there, and for the places at its end."""
    model, s = stepper.system, stepper.buffers.step
    d, relaxation = s.q1.shape[0], model.numbers.kelvin_voigt / length
    load_at(model, t + 0.5 * length, s.load)
    take_point_forces(model.forces, t + 0.5 * length, s.forces)
    hold_at(model, t + length, s.held)
    take_root(model, t, length, s.root)
    q0, v0 = y[:d], y[d : 2 * d]
    taken = take_newton_step(
        model.beam,
        model.touchings,
        stepper.contacts,
        s,
        q0,
        v0,
        length,
        relaxation,
        model.numbers.held,
        _CONVERGED,
    )
    if taken == 0:
        return False
    _take_places(stepper, AFTER, s.q1, s.v1)
    return True


# --- the length of steps


@jitable
def _error(stepper: ExactStepper, length: float, y: Array) -> float:
    """Error of a step in places, over the length of the beam and the tolerance; 0 of the first one."""
    b, largest = stepper.buffers, 0.0
    d, since = b.acceleration.shape[0], b.pace[SINCE]
    if since == 0.0:
        return 0.0
    for j in range(d):
        if j % NODE < 2:
            acceleration = (b.step.v1[j] - y[d + j]) / length
            largest = max(largest, abs(acceleration - b.acceleration[j]))
    rate = largest / (since + 0.5 * length)
    return float(rate * length**3 / (12.0 * stepper.system.beam.x[-1] * stepper.tolerance))


@jitable
def _choose(stepper: ExactStepper, length: float, error: float) -> None:
    """Choose the length of the next step from the error of this one."""
    pace = stepper.buffers.pace
    factor = _GROW if error == 0.0 else min(_GROW, max(_SHRINK, _SAFETY * error ** (-1.0 / 3.0)))
    if length >= _LONG_ENOUGH * stepper.shortest:
        pace[CHOSEN] = min(max(factor * length, stepper.shortest), stepper.free_step)


@jitable
def _dips(stepper: ExactStepper, length: float) -> bool:
    """Whether a gap falls below zero, or a depth, and rises again within the step."""
    places, each = stepper.buffers.places, stepper.contacts.each
    for i in range(places.shape[1]):
        side = each[i].side if each[i].state == FREE else -1.0
        first, last = side * places[BEFORE, i, GAP], side * places[AFTER, i, GAP]
        falling, rising = side * places[BEFORE, i, GAP_RATE] * length, side * places[AFTER, i, GAP_RATE] * length
        if first > 0.0 and last > 0.0 and falling < 0.0 < rising:
            least, _ = cubic_dip(first, last, falling, rising)
            if least < 0.0:
                return True
    return False


# --- what a step leaves


@jitable
def _accept(stepper: ExactStepper, t: float, end: float, length: float, y: Array) -> None:
    """Go to the end of a step, with its impulses and losses, and the forces there to report."""
    b, model, contacts, y_new = stepper.buffers, stepper.system, stepper.contacts, stepper.scratch.y_new
    s, n, d = b.step, b.places.shape[1], b.acceleration.shape[0]
    numbers, relaxation = model.numbers, model.numbers.kelvin_voigt / length
    work = take_end(model.beam, model.touchings, contacts, s, y[:d], length, relaxation, numbers.held)
    copy(y, y_new)
    copy(s.q1, y_new[:d])
    copy(s.v1, y_new[d : 2 * d])
    gained = y_new[2 * d : 2 * d + QUADRATURES + OF_A_CONTACT * n]
    if relaxation > 0.0:
        gained[DAMPING_LOSS] += damping_loss(model.beam, s.begun, s.ended, relaxation)
    drive_forces(model, t + 0.5 * length, s.spare)
    add_point_forces(s.forces, y[:d], s.q1, s.spare)
    gained[SUPPLIED] += work + dot(s.spare, s.move)
    if numbers.root_stiffness > 0.0 or numbers.root_damping > 0.0:
        gained[DAMPING_LOSS] += root_loss(s.root, y[2], s.q1[2], length)
        moment = root_moment(s.root, y[2], s.q1[2], length)
        gained[SUPPLIED] -= moment * (s.root[ANGLE_AFTER] - s.root[ANGLE_BEFORE])
    row = b.log[_enter(b, STEP, t, end), 3:]
    points = 2 * s.begun.shape[0]
    for e in range(s.begun.shape[0]):
        for g in range(2):
            force, moment = mean_resultants(model.beam.sections[e, g], s.begun[e, g], s.ended[e, g], relaxation)
            k = 2 * e + g
            row[k], row[points + k], row[2 * points + k] = force.real, force.imag, moment
    for i in range(n):
        row[3 * points + i] = s.numbers[i, REACTION]
        if contacts.each[i].state != FREE:
            _add_gain(stepper, i, length, gained[QUADRATURES + OF_A_CONTACT * i :])
    if length >= _LONG_ENOUGH * stepper.shortest:
        for j in range(d):
            b.acceleration[j] = (s.v1[j] - y[d + j]) / length
        b.pace[SINCE] = 0.5 * length
    elif b.pace[SINCE] > 0.0:
        b.pace[SINCE] += length
    for e in range(s.begun.shape[0]):
        for g in range(2):
            copy(s.ended[e, g], s.begun[e, g])
    for i in range(n):
        copy(b.places[AFTER, i], b.places[BEFORE, i])
    b.pace[TIME] = end
    _report(stepper, y_new[2 * d + QUADRATURES + OF_A_CONTACT * n :])


@jitable
def _add_gain(stepper: ExactStepper, i: int, length: float, gained: Array) -> None:
    """Add impulses (N s) and losses (J) of a closed contact in a step to its integrals, and take its peaks."""
    s, c, after = stepper.buffers.step, stepper.contacts.each[i], stepper.buffers.places[AFTER, i]
    force, slid = s.numbers[i, FORCE], dot(s.tangents[i], s.move)
    tangential = s.numbers[i, REACTION] if c.state == STICKING else friction_at(c, slid / length) * force
    gained[NORMAL_IMPULSE] += force * length
    gained[TANGENTIAL_IMPULSE] += tangential * length
    gained[FRICTION_LOSS] -= tangential * slid
    gained[STOP_LOSS] += s.numbers[i, DAMPED] * (stepper.buffers.places[BEFORE, i, GAP] - after[GAP])
    c.peak_force = max(c.peak_force, force_at(c, after[GAP], after[SLIP], after[GAP_RATE]))
    c.peak_depth = max(c.peak_depth, -after[GAP])


@inlined
def _ends(stepper: ExactStepper, i: int) -> Ends:
    """Gaps and slips of a contact at both ends of the step."""
    before, after = stepper.buffers.places[BEFORE, i], stepper.buffers.places[AFTER, i]
    return Ends(before[GAP], after[GAP], before[SLIP], after[SLIP])


@jitable
def _report(stepper: ExactStepper, extra: Array) -> None:
    """Fill the forces where the run is; sticking contacts, and accelerations, have none but means of steps."""
    places, d = stepper.buffers.places, stepper.buffers.acceleration.shape[0]
    for j in range(extra.shape[0]):
        extra[j] = 0.0
    for i in range(places.shape[1]):
        c, at = stepper.contacts.each[i], places[BEFORE, i]
        if c.state != FREE:
            force = force_at(c, at[GAP], at[SLIP], at[GAP_RATE])
            extra[d + 2 * i], extra[d + 2 * i + 1] = force, friction_at(c, at[SLIP_RATE]) * force


# --- guards


class PartOfStep(NamedTuple):
    """A step from (t, y), of which parts can be tried; a `Trial`."""

    stepper: ExactStepper
    t: float  # s
    whole: float  # s, its length
    y: Array

    def guard_at(self, x: float, guard: int) -> float:
        """Return a guard at the end of the part x of the step; 0 where this does not converge."""
        if not _solve(self.stepper, self.t, x * self.whole, self.y):
            self.stepper.buffers.counts[FAILED] = 1
            return 0.0
        guards = self.stepper.scratch.guards[AT]
        _take_guards(self.stepper, guard // GUARDS, x * self.whole, guards)
        return float(guards[guard])


@jitable
def _first_fall(stepper: ExactStepper, t: float, length: float, y: Array) -> tuple[int, float]:
    """Guard that falls first in the step, or NO_GUARD, and the part of the step at whose end; 0: at once."""
    guards, best, least, turns = stepper.scratch.guards[VALUES], NO_GUARD, 2.0, False
    n = stepper.buffers.places.shape[1]
    for i in range(n):
        _take_guards(stepper, i, length, guards)
    for guard in range(GUARDS * n):
        if not guards[guard] < 0.0:
            continue
        part = _locate(stepper, t, length, y, guard, guards[guard])
        # what holds no longer lets go before others that it has held turn
        which = guard % GUARDS
        turning = stepper.contacts.each[guard // GUARDS].state == SLIDING and which in (LOWER, UPPER)
        if part < least or (part == least and turns and not turning):
            best, least, turns = guard, part, turning
    return best, least


@jitable
def _locate(stepper: ExactStepper, t: float, length: float, y: Array, guard: int, last: float) -> float:
    """Part of the step at whose end a guard, `last` at that of the whole, falls to zero; 0 if it falls at once."""
    trial = PartOfStep(stepper, t, length, y)
    first = trial.guard_at(_AT_ONCE, guard)
    return 0.0 if first <= 0.0 else find_fall(trial, guard, _AT_ONCE, first, 1.0, last, _CLOSE, 0.0)


@jitable
def _take_guards(stepper: ExactStepper, i: int, length: float, values: Array) -> None:
    """Take the guards of a contact at the end of a step, of the mean forces of this, into a row of all guards."""
    model, c, after = stepper.system, stepper.contacts.each[i], stepper.buffers.places[AFTER, i]
    touching, numbers = model.touchings[i], stepper.buffers.step.numbers[i]
    c.gap, c.slip, c.gap_rate, c.slip_rate = after[GAP], after[SLIP], after[GAP_RATE], after[SLIP_RATE]
    c.depth, c.depth_rate = -after[GAP], -after[GAP_RATE]
    if c.state != FREE:
        c.normal_force, _, _ = mean_force(c, _ends(stepper, i), length)
        c.tangential_force = numbers[KEEPING]
    guards = guards_of(c)
    for which in range(GUARDS):
        values[GUARDS * i + which] = guards[which]
    if c.state == STICKING:
        # either edge of the cone: what holds may swing from one to the other within a step
        values[GUARDS * i + LOWER] = min(guards.lower, guards.upper)
        values[GUARDS * i + UPPER] = 1.0
    if c.state != FREE and touching.on_side and touching.heir >= 0:
        near_first, tip = abs(c.slip - c.first) < abs(c.slip - c.last), touching.node > 0
        if near_first == ((touching.outer == 0) == tip):
            # an end leaves a side for its corner where this comes onto the beam: both ways at the same place
            corner = stepper.buffers.places[AFTER, touching.heir, PLACE]
            values[GUARDS * i + END] = corner - model.beam.x[-1] if tip else -corner


@jitable
def _decide(stepper: ExactStepper, t: float, guard: int, y: Array) -> int:
    """Return the guard that fell, where slip or stick ends with what follows.

    A contact without slip sticks if the force that would hold it for a step lies in the cone; if not, it slips
    against this force.  At other kinks of its law slip goes on, and a law without stick slips always.
    """
    b, i, which = stepper.buffers, guard // GUARDS, guard % GUARDS
    c = stepper.contacts.each[i]
    state, kink = c.state, c.upper if which == UPPER else c.lower
    slides = state == SLIDING
    passes = slides and (kink != 0.0 or c.static < 0.0)
    if state == FREE or which not in (LOWER, UPPER) or passes:
        return guard
    # where forces turn within a step, what follows contradicts it at once: then a part of the step decides
    length = stepper.shortest * _SHORTER ** min(b.counts[AT_ONCE], _SHORTEST)
    c.state = STICKING
    converged = _solve(stepper, t, length, y)
    force, _, _ = mean_force(c, _ends(stepper, i), length)
    c.state = state
    if not converged:
        b.counts[FAILED] = 1
        return guard
    reaction = b.step.numbers[i, KEEPING]
    if slides and abs(reaction) <= c.static * force:
        return GUARDS * len(stepper.contacts.each) + i
    which = UPPER if reaction < 0.0 else LOWER
    if slides:  # from zero slip, also where it goes on in its direction
        if which == UPPER:
            c.upper = 0.0
        else:
            c.lower = 0.0
    return GUARDS * i + which


@dataclass(frozen=True)
class ExactScheme(Scheme):
    """Energy-consistent steps of the exact beam, of the second order.

    Attributes
    ----------
    free_step, shortest : float
        s; longest step, and shortest one near obstacles.
    near : float
        m; gap below which obstacles are near.
    tolerance : float
        Error of a step near obstacles over the length of the beam.
    forces : int
        Number of forces on the beam.
    """

    free_step: float
    shortest: float
    near: float
    tolerance: float
    forces: int = 0
    name = "time-stepping"
    order = 2

    @property
    def stick_criterion(self) -> StickCriterion:  # noqa: D102
        return StickCriterion(inf, located=True)

    def buffers(self, task: Task) -> Recorder:  # noqa: D102
        return Recorder(ExactBuffers.new((task.size // NODE - 1) // 2, task.contacts, self.forces))

    def extra_state(self, size: int, contacts: int, quadratures: int) -> int:  # noqa: D102
        return size + 2 * contacts

    def fill_extra_state(self, prepared: Prepared, y: Array, extra: Array) -> None:  # noqa: D102
        model, d = prepared.system, NODE * prepared.system.beam.x.size
        extra[:] = 0.0
        for i, touching in enumerate(model.touchings):
            c: Candidate = prepared.contacts.of(i)
            if c.state != FREE:
                at: Place = place_of(model.beam, touching, y[:d], y[d : 2 * d])
                force = force_at(c, at.gap, at.slip, at.gap_rate)
                extra[d + 2 * i :][:2] = force, friction_at(c, at.slip_rate) * force

    def steps_per_call(self, size: int) -> int:  # noqa: D102
        return _STEPS_PER_CALL

    def stepper(self, prepared: Prepared, limits: Limits) -> ExactStepper:  # noqa: D102
        recorder: Recorder = prepared.own
        recorder.take_log()
        return ExactStepper(
            prepared.system,
            prepared.contacts,
            self.free_step,
            self.shortest,
            self.near,
            self.tolerance,
            limits,
            prepared.scratch,
            recorder.buffers,
        )
