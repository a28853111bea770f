"""The march through one phase: one loop for all schemes.

The loop owns the times of steps, of which one is cut at a stop, their number, the bounds of a call and the reasons
to return.  A scheme is a `Stepper`: how long a step is to be, the step itself with the first guard that falls in
it, and what follows once the state has moved on.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

import numpy as np

from oblique_impact.contact.forces import MASS_NOT_POSITIVE, NO_SLIDING_SOLUTION, NO_STICKING_SOLUTION, OK
from oblique_impact.kernels.jit import (
    by_reference,
    compiled_protocol,
    inlined,
    is_compiled,
    jitable,
    kernel,
    vectorized,
)
from oblique_impact.kernels.workspace import Array, copy
from oblique_impact.marching.buffers import KEPT, NEXT, NO_GUARD, OutputSamples, Scratch, new_sample

# Why a march returned: positive reasons are ordinary, negative ones end the run
AT_STOP, AT_GUARD, LIMIT_REACHED = 0, 1, 2
FAILED_MASS, FAILED_SLIDING, FAILED_STICKING = -MASS_NOT_POSITIVE, -NO_SLIDING_SOLUTION, -NO_STICKING_SOLUTION
FAILED_STEP, FAILED_FINITE, FAILED_ITERATION = -10, -11, -12

UNBOUNDED = 1e12  # in units of the scales: beyond it a solution has diverged

_SAME = 1e-9  # of a step: one that would end so close to a stop ends there
_ROUNDING = 1e-15  # of the time, some units: where steps have ended further from their count, another one began
#: smaller steps, as a part of the time, are lost: some hundred units of rounding.  At the start of a run, when the
#: time is zero, a part of the time scale stands in its place
_SMALLEST, _SMALLEST_TIME = 1e-14, 1e-3


class StepState(NamedTuple):
    """Time, step and counters of a march; with the state vector all that it needs to continue."""

    t: float  # s
    h: float  # s, step to go on with
    origin: float  # s; steps of constant length end at origin + done h
    done: int
    taken: int  # steps since the phase began


class Limits(NamedTuple):
    """Bounds of time and steps at which a march returns."""

    t_stop: float  # s
    end: float  # s, of the run, which keeps its last sample by itself
    interval: float  # s, of output samples
    most_steps: int


class MarchResult(NamedTuple):
    """State at which a march returned, the reason, and its costs."""

    reason: int
    guard: int
    state: StepState
    steps: int
    rejected: int
    samples: int


class Position(NamedTuple):
    """A march before a step."""

    t: float  # s
    h: float  # s, length of a whole step
    gap: float  # m, the smallest distance of a candidate in flight
    taken: int  # steps since the phase began


class Step(NamedTuple):
    """A step that was tried; the state at its end is in `Scratch.y_new`.

    One that is not accepted is tried again with the length that is proposed; with 0 there is none, because of its
    status or because a guard falls at once.
    """

    status: int  # OK, or why the contact problem has no solution
    accepted: bool
    end: float  # s, where a guard has ended it earlier than it was to end as well
    proposed: float  # s, length of the next whole step
    guard: int  # the first that falls, or NO_GUARD
    gap: float  # m, at the end


@compiled_protocol
class Stepper(Protocol):
    """The steps of a scheme in one phase: a named tuple whose methods kernels call, or any object."""

    @property
    def system(self) -> Any:
        """The mechanical system."""

    @property
    def limits(self) -> Limits:
        """Bounds of the call."""

    @property
    def scratch(self) -> Scratch:
        """The buffers of the run."""

    def begin(self, start: StepState, y: Array) -> tuple[int, float]:
        """Prepare the first step of a call; status and gap (m).

        `start.taken` is 0 at the start of a phase; `start.done` is, and behind a stop as well.
        """

    def length(self, gap: float, h: float) -> float:
        """Length (s) of the next whole step, that of the last one having been h."""

    def take(self, now: Position, length: float, end: float, y: Array) -> Step:
        """Try a step of this length from (now.t, y) to the time `end`.

        A scheme that interpolates keeps the samples that are due inside of it.
        """

    def arrive(self, step: Step, y: Array) -> Step:
        """Follow an accepted step, y being its end: a scheme that does not locate decides here which guard fell.

        A scheme that does not interpolate keeps a sample if one is due.
        """


@inlined
def refused(status: int, proposed: float) -> Step:
    """Return a step that is not accepted."""
    return Step(status, False, 0.0, proposed, NO_GUARD, 0.0)


def _all_bounded(y: Array, s: Scratch) -> bool:
    return bool(np.all(np.abs(y[: s.scales.size]) < UNBOUNDED * s.scales))


@vectorized(_all_bounded)
def bounded(y: Array, s: Scratch) -> bool:
    """Whether coordinates and velocities are finite and below 1e12 of their scales."""
    scales, beyond = s.scales, 0
    for m in range(scales.shape[0]):  # to the end, several entries at a time
        if not abs(y[m]) < UNBOUNDED * scales[m]:
            beyond += 1
    return beyond == 0


@jitable
def keep_sample(t: float, y: Array, limits: Limits, samples: OutputSamples) -> None:
    """Keep the end of a step as a sample if one is due."""
    if t >= samples.counts[NEXT] * limits.interval * (1.0 - 1e-12) and t < limits.end:
        copy(y, samples.states[new_sample(t, samples)])
        samples.counts[NEXT] = int(t / limits.interval * (1.0 + 1e-12)) + 1


#: `MarchResult` in plain tuples, as kernels return it: numba makes named ones by calls that an interrupt may break
_Returned = tuple[int, int, tuple[float, float, float, int, int], int, int, int]


@jitable
def advance(stepper: Stepper, start: StepState, y: Array) -> _Returned:
    """Advance y in place until a guard falls, to the stop, or until a bound of the call is reached.

    Steps of one length end at origin + done h, so that no rounding adds up.
    """
    limits, s = stepper.limits, stepper.scratch
    t, h, origin, done = start.t, start.h, start.origin, start.done
    steps, rejected, reason, fallen = 0, 0, AT_STOP, NO_GUARD
    counts, room = s.samples.counts, s.samples.times.shape[0] // 2  # one step may fill the other half
    counts[KEPT] = 0
    status, gap = stepper.begin(start, y)
    if status != OK:
        reason = -status
    while reason == AT_STOP and t < limits.t_stop:
        if counts[KEPT] > room or steps >= limits.most_steps:
            reason = LIMIT_REACHED
            break
        wanted = stepper.length(gap, h)
        if wanted != h or abs(t - (origin + done * h)) > _ROUNDING * t:
            origin, done, h = t, 0, wanted
        end = origin + (done + 1) * h
        whole = end <= limits.t_stop - _SAME * h
        end, length = (end, h) if whole else (limits.t_stop, limits.t_stop - t)
        step = stepper.take(Position(t, h, gap, start.taken + steps), length, end, y)
        if not step.accepted:
            if step.guard != NO_GUARD:
                reason, fallen = AT_GUARD, step.guard
                break
            rejected, h = rejected + 1, step.proposed
            if h <= _SMALLEST * max(t, _SMALLEST_TIME * s.tolerances.time):
                reason = -step.status if step.status != OK else FAILED_STEP
            continue
        copy(s.y_new, y)
        t, gap, steps, done = step.end, step.gap, steps + 1, done + 1
        if whole and t == end:
            h = step.proposed
        if not bounded(y, s):
            reason = FAILED_FINITE
            break
        step = stepper.arrive(step, y)
        if step.status != OK:
            reason = -step.status
        elif step.guard != NO_GUARD:
            reason, fallen = AT_GUARD, step.guard
    if reason == AT_STOP:
        origin, done = t, 0  # the last step was cut; the next ones are counted from here
    return reason, fallen, (t, h, origin, done, start.taken + steps), steps, rejected, counts[KEPT]


@kernel("the march")
def _march(stepper: Stepper, start: StepState, y: Array) -> _Returned:
    return advance(by_reference(stepper), start, by_reference(y))


def march(stepper: Stepper, start: StepState, y: Array) -> MarchResult:
    """Call :func:`advance`, compiled if that is possible."""
    compiled = isinstance(stepper, tuple) and is_compiled(stepper.system)
    found = _march(stepper, start, y) if compiled else advance(stepper, start, y)
    return MarchResult(found[0], found[1], StepState(*found[2]), *found[3:])
