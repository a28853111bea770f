"""Event-located marching: adaptive order 8, every change of a guard's sign found inside the step.

The dense output of each step is searched for the first fall of a guard (`search`).  The time found is
sharpened by repeating the step up to it, so an event is as accurate as a step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import guards_of
from oblique_impact.contact.state import FREE, NORMAL, Phase
from oblique_impact.kernels.jit import by_reference, jitable, kernel
from oblique_impact.kernels.system import NormalModes
from oblique_impact.kernels.workspace import Array, copy
from oblique_impact.marching.dop853 import (
    DENSE_STAGES,
    ORDER,
    STAGES,
    Stages,
    error_norm,
    interpolant,
    interpolate,
    take_stages,
)
from oblique_impact.marching.equations import derivative
from oblique_impact.marching.exponential import (
    CONTRACTION,
    LEVEL,
    PATIENCE,
    SPEED,
    WORTHWHILE,
    Exponential,
    Flight,
    Position,
    new_exponential,
    try_exponential_step,
)
from oblique_impact.marching.scheme import (
    AT_GUARD,
    AT_STOP,
    FAILED_FINITE,
    FAILED_STEP,
    LIMIT_REACHED,
    NO_GUARD,
    Limits,
    Prepared,
    Progress,
    Returned,
    Samples,
    Scheme,
    Scratch,
    StepState,
    bounded,
    progress_of,
    raised,
)
from oblique_impact.marching.search import UNDEFINED, DenseStep, first_fall

# as in the codes of Hairer, Norsett and Wanner (Sec. II.4)
_SAFETY, _SHRINK, _GROW = 0.9, 0.2, 6.0
_EXPONENT = -1.0 / 8.0
#: of the tolerance: a second of motion takes thousands of steps, whose errors add up
_SHARE_OF_A_STEP = 0.02
#: an exponential step should replace so many others at least; so many are taken before another one is tried
_EXPONENTIAL_COST, _PATIENCE = 4.0, 8
_SMALLEST, _SMALLEST_TIME = 1e-14, 1e-3  # smaller steps, as a part of the time (in time scales), are lost
#: corrections of the end of a step on an event; four converge from the dense output, which is of order 7
_CORRECTIONS = 4


class EventBuffers(NamedTuple):
    """Buffers of the event scheme."""

    stages: Stages
    exponential: Exponential | None  # tables for long steps of free flights, where these are worth their time


@jitable
def _step_factor(error: float) -> float:
    """Ratio of the next step to the last one."""
    if error == 0.0:
        return _GROW
    if not error < 1e12:
        return _SHRINK
    return float(min(_GROW, max(_SHRINK, _SAFETY * error**_EXPONENT)))


@jitable
def _emit(
    t: float, end: float, h: float, y: Array, first: int, count: int, interval: float, F: Array, samples: Samples
) -> int:
    """Write the output samples before `end` from the dense output; returns how many there are now.

    Samples are the multiples first, first + 1, ... of the interval.
    """
    while (first + count) * interval < end * (1.0 - 1e-14):
        time = (first + count) * interval
        interpolate(F, y, (time - t) / h, samples.states[count])
        samples.times[count] = time
        count += 1
    return count


@jitable
def _land(
    system: Any, phase: Phase, t: float, y: Array, length: float, rate: float, guard: int, s: Scratch, K: Array
) -> tuple[int, float]:
    """Repeat the step so that it ends on the event; status and length (s), with the state there in s.y_new.

    The secant method on the length, started with the guard's slope `rate`; the dense output that bracketed
    the event is only of order 7.
    """
    last_value, last_length = 0.0, 0.0
    for trial in range(_CORRECTIONS + 1):
        status, c, _ = take_stages(system, phase, t, y, length, 1, STAGES, K, s.work, s.y_new)
        if status != 0 or trial == _CORRECTIONS:
            return status, length
        value = raised(guards_of(phase, c)[guard], guard, s.guards)
        if trial > 0 and length != last_length:
            rate = (value - last_value) / (length - last_length)
        correction = -value / rate if rate < 0.0 else 0.0
        if not 1e-15 * t < abs(correction) < 0.1 * length:
            return 0, length
        last_value, last_length = value, length
        length += correction
    return 0, length


class TriedStep(NamedTuple):
    """Result of trying a step; an accepted one ends in s.y_new, with its dense output in F if that was needed."""

    status: int
    accepted: bool
    factor: float  # ratio of the next step to this one
    length: float  # s; of a step that an event ends, up to that
    guard: int
    gap: float  # m, distance from the line of the slope at the end
    speed: float  # m/s, the largest gap rate
    peak: float  # N
    depth: float  # m


@jitable
def _try_step(step: DenseStep, now: Position, due: bool, tolerance: float) -> TriedStep:
    """Try a step, and end it at the first guard that falls; `due` if samples are wanted inside of it."""
    system, phase, t, length, y = step.system, step.phase, step.t, step.h, step.y
    s, stages = step.scratch, step.stages
    status, c, speed = take_stages(system, phase, t, y, length, 1, STAGES, stages.K, s.work, s.y_new)
    error = error_norm(length, y, stages, s, tolerance) if status == 0 else np.inf
    if not error <= 1.0:
        return TriedStep(status, False, min(_step_factor(error), 1.0), length, NO_GUARD, c.gap, speed, 0.0, 0.0)
    factor, gap, guard = _step_factor(error), phase.surface.side * c.gap, NO_GUARD
    peak, depth, landed = 0.0, 0.0, length
    # the contact point cannot have reached the slope within the step
    clear = phase.state == FREE and (not phase.surface.enabled or min(now.gap, gap) > 2.0 * length * speed)
    if due or not clear:
        status, _, _ = take_stages(
            system, phase, t, y, length, STAGES + 1, DENSE_STAGES - 1, stages.K, s.work, s.at
        )
        interpolant(y, s.y_new, length, stages)
    if clear:
        s.guards.armed[NORMAL] = True
    elif status == 0:
        guard, place, rate, peak, depth = first_fall(step)
        if guard >= 0:
            status, landed = _land(system, phase, t, y, place * length, rate, guard, s, stages.K)
    # a contact problem without a solution further on in this step: approach that point
    accepted = status == 0 and guard != UNDEFINED
    return TriedStep(status, accepted, factor if accepted else _SHRINK, landed, guard, gap, speed, peak, depth)


@jitable
def _extent(now: Position, h: float, aligned: bool, limits: Limits) -> tuple[float, float, bool]:
    """Length (s) and end (s) of the next step, and whether it is as long as h.

    Steps are cut at the stop and, where `aligned`, at the next sample, because exponential steps begin at samples.
    """
    following, last = now.sample * limits.interval, now.t + h * (1.0 + 1e-9) >= limits.t_stop
    length, end = (limits.t_stop - now.t, limits.t_stop) if last else (h, now.t + h)
    if aligned and now.t < following * (1.0 - 1e-14) and following < now.t + length:
        return following - now.t, following, False
    return length, end, not last


@kernel("the event scheme")
def march_event(
    system: Any,
    phase: Phase,
    tolerance: float,
    start: StepState,
    y: Array,
    limits: Limits,
    s: Scratch,
    stages: Stages,
    tables: Exponential | None,
) -> Returned:
    """Advance y in place until a guard falls, until the stop, until the sample buffer or the limit is reached."""
    system, phase, s, stages = by_reference(system), by_reference(phase), by_reference(s), by_reference(stages)
    h, steps, rejected, peak, depth, fallen = start.h, 0, 0, 0.0, 0.0, NO_GUARD
    capacity, exponential, levels, patience = s.samples.times.shape[0], False, 0, 0
    status, c = derivative(system, phase, start.t, y, s.work, stages.K[1])
    if start.taken == 0:  # else it is there, to the last bit as in one call: calls end by the clock
        copy(stages.K[1], stages.K[0])
    reason = -status  # AT_STOP, if there is none
    now = Position(start.t, phase.surface.side * c.gap, abs(c.gap_rate), start.sample, 0)
    if tables is not None:  # else the compiler leaves them out
        exponential, levels = phase.state == FREE, tables.lengths.shape[0]
        if start.taken == 0:
            tables.memory[CONTRACTION] = np.inf
    level = levels - 1
    if tables is not None and start.taken > 0:
        level, patience = int(tables.memory[LEVEL]), int(tables.memory[PATIENCE])
        now = Position(start.t, phase.surface.side * c.gap, tables.memory[SPEED], start.sample, 0)
    while reason == AT_STOP and now.t < limits.t_stop:
        if now.kept > capacity // 2 or steps >= limits.most_steps:
            reason = LIMIT_REACHED
            break
        if tables is not None and exponential and patience == 0:
            level = level if level >= 0 else levels - 1
            flight = by_reference(Flight(system, phase, limits, tolerance, s, stages.K, by_reference(tables)))
            level, now = try_exponential_step(flight, now, y, level, _EXPONENTIAL_COST * h)
            if level >= 0:
                s.guards.armed[NORMAL] = True
                steps += 1
                reason = reason if bounded(y, s) else FAILED_FINITE
                continue
            patience = _PATIENCE
        patience = max(patience - 1, 0)
        h = min(h, 0.45 * capacity * limits.interval)  # its samples fit into the other half of their buffer
        if h <= _SMALLEST * max(now.t, _SMALLEST_TIME * s.tolerances.time):
            reason = -status if status != 0 else FAILED_STEP
            break
        length, end, whole = _extent(now, h, exponential, limits)
        due = now.sample * limits.interval < now.t + length
        tried = _try_step(DenseStep(system, phase, now.t, length, y, s, stages), now, due, tolerance)
        status = tried.status
        if not tried.accepted:
            rejected += 1
            h = tried.factor * length
            continue
        kept, landed = now.kept, now.t + tried.length
        if due:
            kept = _emit(now.t, landed, length, y, start.sample, kept, limits.interval, stages.F, s.samples)
        copy(s.y_new, y)
        copy(stages.K[STAGES], stages.K[0])
        peak, depth, steps = max(peak, tried.peak), max(depth, tried.depth), steps + 1
        if tried.guard >= 0:
            end, reason, fallen = landed, AT_GUARD, tried.guard
        elif not bounded(y, s):
            reason = FAILED_FINITE
        elif whole:
            h = tried.factor * length
        else:
            patience = 0
        now = Position(end, tried.gap, tried.speed, start.sample + kept, kept)
    if tables is not None:
        tables.memory[LEVEL], tables.memory[PATIENCE], tables.memory[SPEED] = level, patience, now.speed
    # behind a stop the root moves in another way: everything begins anew
    reached = (now.t, h, now.sample, now.t, 0, 0 if reason == AT_STOP else start.taken + steps)
    return reason, fallen, reached, steps, rejected, now.kept, peak, depth


@dataclass(frozen=True)
class EventScheme(Scheme):
    """Adaptive order 8 with located transitions.

    Attributes
    ----------
    tolerance : float
        Accuracy wanted of q and q', absolute and relative; the error of a single step is held to a
        fiftieth of it, because a second of motion takes thousands of steps.
    """

    tolerance: float = 1e-10
    name = "event"
    order = ORDER

    def buffers(  # noqa: D102
        self, ny: int, modes: NormalModes | None, interval: float, end_time: float
    ) -> EventBuffers:
        fast = modes is not None and np.max(np.abs(modes.eigenvalues)) * end_time >= WORTHWHILE
        return EventBuffers(Stages.new(ny), new_exponential(modes, interval) if modes and fast else None)

    def march(  # noqa: D102
        self, prepared: Prepared, phase: Phase, before: Phase | None, start: StepState, y: Array, limits: Limits
    ) -> Progress:
        own, scratch = prepared.own, prepared.scratch
        tolerance = _SHARE_OF_A_STEP * self.tolerance
        return progress_of(
            march_event(prepared.system, phase, tolerance, start, y, limits, scratch, own.stages, own.exponential)
        )
