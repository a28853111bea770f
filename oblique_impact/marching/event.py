"""Event-located marching: adaptive order 8, every change of a guard's sign found inside the step.

The dense output of each step is searched for the first fall of a guard (`search`).  The time found is
sharpened by repeating the step up to it, so an event is as accurate as a step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

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
from oblique_impact.marching.leaps import WORTHWHILE, Leaps, Position, new_leaps, no_leaps, try_leap
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


@kernel("the event scheme")
def march_event(
    system: Any, phase: Phase, tolerance: float, front: Front, y: Array, leg: Leg, s: Scratch
) -> Returned:
    """Advance y in place until a guard falls, until the stop, until the sample buffer or the leg is full."""
    system, phase, s = by_reference(system), by_reference(phase), by_reference(s)
    t, h, taken = front.t, front.h, front.taken
    steps, rejected, count, peak, depth = 0, 0, 0, 0.0, 0.0
    capacity, reason, fallen = s.times.shape[0], AT_STOP, NO_GUARD
    status, c = derivative(system, phase, t, y, s.work, s.K[0])
    if status != 0:
        unchanged = (t, h, front.sample, front.origin, front.done, taken)
        return -status, NO_GUARD, unchanged, steps, rejected, count, peak, depth
    gap, speed = c.gap, abs(c.gap_rate)
    level, patience = s.leaps.lengths.shape[0] - 1, 0
    leaping = level >= 0 and phase.state == FREE
    while t < leg.t_stop:
        if count > capacity // 2 or steps >= leg.most_steps:
            reason = LEG_FULL
            break
        if leaping and patience == 0:
            now = Position(t, gap, speed, front.sample + count, count)
            level = level if level >= 0 else s.leaps.lengths.shape[0] - 1
            level, now = try_leap(system, phase, now, y, level, tolerance, _LEAP * h, leg, s)
            if level >= 0:
                t, gap, speed, count = now.t, now.gap, now.speed, now.kept
                s.armed[NORMAL] = True
                steps += 1
                if not bounded(y, s):
                    reason = FAILED_FINITE
                    break
                continue
            patience = _PATIENCE
        patience = max(patience - 1, 0)
        h = min(h, 0.45 * capacity * leg.interval)
        if h <= _SMALLEST * max(t, _SMALLEST_TIME * s.tolerances.time):
            reason = -status if status != 0 else FAILED_STEP
            break
        last = t + h * (1.0 + 1e-9) >= leg.t_stop
        length = leg.t_stop - t if last else h
        following = (front.sample + count) * leg.interval
        meets = leaping and t < following * (1.0 - 1e-14) and following < t + length  # leaps begin at samples
        length = following - t if meets else length
        status, c, speed = take_stages(system, phase, t, y, length, 1, STAGES, s, s.y_new)
        error = error_norm(length, y, s, tolerance) if status == 0 else np.inf
        if not error <= 1.0:
            rejected += 1
            h = length * min(_step_factor(error), 1.0)
            continue
        gap_new = c.gap
        clear = phase.state == FREE and (not phase.watched or min(gap, gap_new) > 2.0 * length * speed)
        due = (front.sample + count) * leg.interval < t + length
        guard, place, rate = NO_GUARD, 1.0, 0.0
        if due or not clear:
            status, _, _ = take_stages(system, phase, t, y, length, STAGES + 1, DENSE_STAGES - 1, s, s.at)
            interpolant(y, s.y_new, length, s.K, s.F)
        if clear:
            s.armed[NORMAL] = True
        elif status == 0:
            guard, place, rate, force, deepest = first_fall(DenseStep(system, phase, t, length, y, s))
            peak, depth = max(peak, force), max(depth, deepest)
        if status != 0 or guard == UNDEFINED:
            # the contact problem has no solution further on in this step: approach that point
            rejected += 1
            h = _SHRINK * length
            continue
        kept = _emit(t, t + place * length, length, y, front.sample, count, leg, s) if due else count
        if guard >= 0:
            status, landed = _land(system, phase, t, y, place * length, rate, guard, s)
            if status != 0:
                rejected += 1
                h = _SHRINK * length
                continue
            t, reason, fallen = t + landed, AT_GUARD, guard
        else:
            t = leg.t_stop if last and not meets else following if meets else t + length
            copy(s.K[STAGES], s.K[0])
            gap = gap_new
            patience = 0 if meets else patience
            if not last and not meets:
                h = length * _step_factor(error)
        count = kept
        steps += 1
        copy(s.y_new, y)
        if guard < 0 and not bounded(y, s):
            reason = FAILED_FINITE
        if reason != AT_STOP:
            break
    return reason, fallen, (t, h, front.sample + count, t, 0, taken + steps), steps, rejected, count, peak, depth


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

    def leaps(self, modes: NormalModes | None, interval: float, end_time: float) -> Leaps:  # noqa: D102
        if modes is None or np.max(np.abs(modes.eigenvalues)) * end_time < WORTHWHILE:
            return no_leaps()
        return new_leaps(modes, interval)

    def march(  # noqa: D102
        self, system: Any, phase: Phase, before: Phase | None, front: Front, y: Array, leg: Leg, scratch: Scratch
    ) -> Progress:
        tolerance = _SHARE_OF_A_STEP * self.tolerance
        return progress_of(march_event(system, phase, tolerance, front, y, leg, scratch))
