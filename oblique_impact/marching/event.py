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
from oblique_impact.kernels.jit import jitable, kernel
from oblique_impact.kernels.reference import by_reference
from oblique_impact.kernels.system import NormalModes
from oblique_impact.kernels.workspace import Array, copy
from oblique_impact.marching.dop853 import (
    DENSE_STAGES,
    ORDER,
    STAGES,
    error_norm,
    interpolant,
    interpolate,
    take_stages,
)
from oblique_impact.marching.equations import derivative
from oblique_impact.marching.leaps import (
    CONTRACTION,
    LEVEL,
    PATIENCE,
    SPEED,
    WORTHWHILE,
    Flight,
    Leaps,
    Position,
    new_leaps,
    try_leap,
)
from oblique_impact.marching.scheme import (
    AT_GUARD,
    AT_STOP,
    FAILED_FINITE,
    FAILED_STEP,
    LEG_FULL,
    NO_GUARD,
    Front,
    Leg,
    Progress,
    Returned,
    Scheme,
    Scratch,
    bounded,
    progress_of,
    raised,
)
from oblique_impact.marching.search import UNDEFINED, DenseStep, first_fall

_SAFETY, _SHRINK, _GROW = 0.9, 0.2, 6.0
_EXPONENT = -1.0 / 8.0
_SHARE_OF_A_STEP = 0.02
_LEAP, _PATIENCE = 4.0, 8  # a leap is worth so many steps; so many are taken until another one is tried
_SMALLEST, _SMALLEST_TIME = 1e-14, 1e-3  # smaller steps, as a part of the time (in time scales), are lost


@jitable
def _step_factor(error: float) -> float:
    """Ratio of the next step to the last one."""
    if error == 0.0:
        return _GROW
    if not error < 1e12:
        return _SHRINK
    return float(min(_GROW, max(_SHRINK, _SAFETY * error**_EXPONENT)))


@jitable
def _emit(t: float, end: float, h: float, y: Array, first: int, count: int, leg: Leg, s: Scratch) -> int:
    """Write the output samples before `end` from the dense output; returns how many there are now.

    Samples are the multiples first, first + 1, ... of the interval.
    """
    while (first + count) * leg.interval < end * (1.0 - 1e-14):
        time = (first + count) * leg.interval
        interpolate(s.F, y, (time - t) / h, s.states[count])
        s.times[count] = time
        count += 1
    return count


@jitable
def _land(
    system: Any, phase: Phase, t: float, y: Array, length: float, rate: float, guard: int, s: Scratch
) -> tuple[int, float]:
    """Repeat the step so that it ends on the event; status and length (s), with the state there in s.y_new.

    The secant method on the length, started with the guard's slope `rate`; the dense output that bracketed
    the event is only of order 7.
    """
    last_value, last_length = 0.0, 0.0
    for trial in range(5):
        status, c, _ = take_stages(system, phase, t, y, length, 1, STAGES, s, s.y_new)
        if status != 0 or trial == 4:
            return status, length
        value = raised(guards_of(phase, c)[guard], guard, s)
        if trial > 0 and length != last_length:
            rate = (value - last_value) / (length - last_length)
        correction = -value / rate if rate < 0.0 else 0.0
        if not 1e-15 * t < abs(correction) < 0.1 * length:
            return 0, length
        last_value, last_length = value, length
        length += correction
    return 0, length


class Attempt(NamedTuple):
    """What became of a step; an accepted one ends in s.y_new, with its interpolant in s.F if that was needed."""

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
def _attempt(
    system: Any, phase: Phase, now: Position, y: Array, length: float, due: bool, tolerance: float, s: Scratch
) -> Attempt:
    """Try a step, and end it at the first guard that falls; `due` if samples are wanted inside of it."""
    status, c, speed = take_stages(system, phase, now.t, y, length, 1, STAGES, s, s.y_new)
    error = error_norm(length, y, s, tolerance) if status == 0 else np.inf
    if not error <= 1.0:
        return Attempt(status, False, min(_step_factor(error), 1.0), length, NO_GUARD, c.gap, speed, 0.0, 0.0)
    factor, gap, guard, peak, depth, landed = _step_factor(error), phase.side * c.gap, NO_GUARD, 0.0, 0.0, length
    clear = phase.state == FREE and (not phase.watched or min(now.gap, gap) > 2.0 * length * speed)
    if due or not clear:
        status, _, _ = take_stages(system, phase, now.t, y, length, STAGES + 1, DENSE_STAGES - 1, s, s.at)
        interpolant(y, s.y_new, length, s.K, s.F)
    if clear:
        s.armed[NORMAL] = True
    elif status == 0:
        guard, place, rate, peak, depth = first_fall(DenseStep(system, phase, now.t, length, y, s))
        if guard >= 0:
            status, landed = _land(system, phase, now.t, y, place * length, rate, guard, s)
    # a contact problem without a solution further on in this step: approach that point
    accepted = status == 0 and guard != UNDEFINED
    return Attempt(status, accepted, factor if accepted else _SHRINK, landed, guard, gap, speed, peak, depth)


@jitable
def _extent(now: Position, h: float, leaping: bool, leg: Leg) -> tuple[float, float, bool]:
    """Length (s) and end (s) of the next step, and whether it is as long as h.

    Steps are cut at the stop, and before leaps, which begin at samples, at the next sample.
    """
    following, last = now.sample * leg.interval, now.t + h * (1.0 + 1e-9) >= leg.t_stop
    length, end = (leg.t_stop - now.t, leg.t_stop) if last else (h, now.t + h)
    if leaping and now.t < following * (1.0 - 1e-14) and following < now.t + length:
        return following - now.t, following, False
    return length, end, not last


@kernel("the event scheme")
def march_event(
    system: Any,
    phase: Phase,
    tolerance: float,
    front: Front,
    y: Array,
    leg: Leg,
    s: Scratch,
    leaps: Leaps | None,
) -> Returned:
    """Advance y in place until a guard falls, until the stop, until the sample buffer or the leg is full."""
    system, phase, s = by_reference(system), by_reference(phase), by_reference(s)
    h, steps, rejected, peak, depth, fallen = front.h, 0, 0, 0.0, 0.0, NO_GUARD
    capacity, leaping, levels, patience = s.times.shape[0], False, 0, 0
    status, c = derivative(system, phase, front.t, y, s.work, s.K[1])
    if front.taken == 0:  # else it is there, to the last bit as in one leg: legs end by the clock
        copy(s.K[1], s.K[0])
    reason = -status  # AT_STOP, if there is none
    now = Position(front.t, phase.side * c.gap, abs(c.gap_rate), front.sample, 0)
    if leaps is not None:  # else the compiler leaves them out
        leaping, levels = phase.state == FREE, leaps.lengths.shape[0]
        if front.taken == 0:
            leaps.memory[CONTRACTION] = np.inf
    level = levels - 1
    if leaps is not None and front.taken > 0:
        level, patience = int(leaps.memory[LEVEL]), int(leaps.memory[PATIENCE])
        now = Position(front.t, phase.side * c.gap, leaps.memory[SPEED], front.sample, 0)
    while reason == AT_STOP and now.t < leg.t_stop:
        if now.kept > capacity // 2 or steps >= leg.most_steps:
            reason = LEG_FULL
            break
        if leaps is not None and leaping and patience == 0:
            level = level if level >= 0 else levels - 1
            flight = by_reference(Flight(system, phase, leg, tolerance, s, by_reference(leaps)))
            level, now = try_leap(flight, now, y, level, _LEAP * h)
            if level >= 0:
                s.armed[NORMAL] = True
                steps += 1
                reason = reason if bounded(y, s) else FAILED_FINITE
                continue
            patience = _PATIENCE
        patience = max(patience - 1, 0)
        h = min(h, 0.45 * capacity * leg.interval)
        if h <= _SMALLEST * max(now.t, _SMALLEST_TIME * s.tolerances.time):
            reason = -status if status != 0 else FAILED_STEP
            break
        length, end, whole = _extent(now, h, leaping, leg)
        due = now.sample * leg.interval < now.t + length
        tried = _attempt(system, phase, now, y, length, due, tolerance, s)
        status = tried.status
        if not tried.accepted:
            rejected += 1
            h = tried.factor * length
            continue
        kept, landed = now.kept, now.t + tried.length
        if due:
            kept = _emit(now.t, landed, length, y, front.sample, kept, leg, s)
        copy(s.y_new, y)
        copy(s.K[STAGES], s.K[0])
        peak, depth, steps = max(peak, tried.peak), max(depth, tried.depth), steps + 1
        if tried.guard >= 0:
            end, reason, fallen = landed, AT_GUARD, tried.guard
        elif not bounded(y, s):
            reason = FAILED_FINITE
        elif whole:
            h = tried.factor * length
        else:
            patience = 0
        now = Position(end, tried.gap, tried.speed, front.sample + kept, kept)
    if leaps is not None:
        leaps.memory[LEVEL], leaps.memory[PATIENCE], leaps.memory[SPEED] = level, patience, now.speed
    # behind a stop the root moves in another way: everything begins anew
    reached = (now.t, h, now.sample, now.t, 0, 0 if reason == AT_STOP else front.taken + steps)
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

    def tables(self, modes: NormalModes | None, interval: float, end_time: float) -> Leaps | None:  # noqa: D102
        if modes is None or np.max(np.abs(modes.eigenvalues)) * end_time < WORTHWHILE:
            return None
        return new_leaps(modes, interval)

    def march(  # noqa: D102
        self, system: Any, phase: Phase, before: Phase | None, front: Front, y: Array, leg: Leg, scratch: Scratch
    ) -> Progress:
        tolerance = _SHARE_OF_A_STEP * self.tolerance
        return progress_of(march_event(system, phase, tolerance, front, y, leg, scratch, scratch.tables))
