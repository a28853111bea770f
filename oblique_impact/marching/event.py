"""Event-located marching: adaptive order 8, every change of a guard's sign found inside the step.

The dense output of each step is searched for the first fall of a guard (`search`).  The time found is
sharpened by repeating the step up to it, so an event is as accurate as a step.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from oblique_impact.contact.forces import FREE, GUARD_NORMAL, Phase, measure_guards
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.system import GAP, Array
from oblique_impact.marching.dop853 import (
    DENSE_STAGES,
    ORDER,
    STAGES,
    error_norm,
    interpolant,
    interpolate,
    stages,
)
from oblique_impact.marching.equations import QUADRATURES, copy, derivative
from oblique_impact.marching.scheme import (
    AT_GUARD,
    AT_STOP,
    BUFFER_FULL,
    FAILED_FINITE,
    FAILED_STEP,
    Course,
    Pace,
    Progress,
    Scheme,
    Scratch,
    Tolerances,
    arm,
)
from oblique_impact.marching.search import NO_GUARD, UNDEFINED, first_fall, shifted

_SAFETY, _SHRINK, _GROW = 0.9, 0.2, 6.0
_EXPONENT = -1.0 / 8.0
_UNBOUNDED = 1e12
_SHARE_OF_A_STEP = 0.02
_SMALLEST, _SMALLEST_TIME = 1e-14, 1e-3  # steps below this part of the time (s) are lost in rounding


@jitable
def _step_factor(error: float) -> float:
    """Ratio of the next step to the last one."""
    if error == 0.0:
        return _GROW
    if not error < _UNBOUNDED:
        return _SHRINK
    return float(min(_GROW, max(_SHRINK, _SAFETY * error**_EXPONENT)))


@jitable
def _emit(t: float, end: float, h: float, y: Array, interval: float, number: int, count: int, s: Scratch) -> int:
    """Write the output samples before `end` from the dense output; returns how many there are now."""
    while (number + count) * interval < end * (1.0 - 1e-14):
        time = (number + count) * interval
        interpolate(s.F, y, (time - t) / h, s.states[count])
        s.times[count] = time
        count += 1
    return count


@jitable
def _bounded(y: Array, size: int) -> bool:
    for m in range(size):  # noqa: SIM110  a generator would not compile
        if not abs(y[m]) < _UNBOUNDED:
            return False
    return True


@jitable
def _land(
    system: Any, phase: Phase, t: float, y: Array, length: float, rate: float, guard: int, s: Scratch
) -> float:
    """Repeat the step so that it ends on the event; its length (s), with the state there in s.y_new.

    The secant method on the length, started with the guard's slope `rate`; the dense output that bracketed
    the event is only of order 7.
    """
    last_value, last_length = 0.0, 0.0
    for trial in range(4):
        status, _ = stages(system, phase, t, y, length, 1, STAGES, s.K, s.work, s.y_new)
        measure_guards(phase, s.work.scalars)
        value = shifted(s, guard)
        if trial > 0 and length != last_length:
            rate = (value - last_value) / (length - last_length)
        correction = -value / rate if rate < 0.0 else 0.0
        if status != 0 or not 1e-15 * t < abs(correction) < 0.1 * length:
            return length
        last_value, last_length = value, length
        length += correction
    stages(system, phase, t, y, length, 1, STAGES, s.K, s.work, s.y_new)
    return length


@jitable
def march_event(
    system: Any,
    phase: Phase,
    t: float,
    y: Array,
    h: float,
    t_stop: float,
    tolerance: float,
    interval: float,
    number: int,
    most_steps: int,
    s: Scratch,
) -> Progress:
    """Advance y in place until a guard falls, until t_stop, until the sample buffer is full, or for `most_steps`.

    Output samples are the multiples number, number + 1, ... of `interval`.
    """
    steps, rejected, count, peak, depth = 0, 0, 0, 0.0, 0.0
    mechanical, capacity = y.shape[0] - QUADRATURES, s.times.shape[0]
    status = derivative(system, phase, t, y, s.work, s.K[0])
    if status != 0:
        return Progress(-status, NO_GUARD, t, h, steps, rejected, count, peak, depth)
    gap = s.work.scalars[GAP]
    while t < t_stop:
        if count > capacity // 2 or steps >= most_steps:
            return Progress(BUFFER_FULL, NO_GUARD, t, h, steps, rejected, count, peak, depth)
        h = min(h, 0.45 * capacity * interval)
        if h <= _SMALLEST * max(t, _SMALLEST_TIME):
            return Progress(
                -status if status != 0 else FAILED_STEP, NO_GUARD, t, h, steps, rejected, count, peak, depth
            )
        last = t + h * (1.0 + 1e-9) >= t_stop
        length = t_stop - t if last else h
        status, speed = stages(system, phase, t, y, length, 1, STAGES, s.K, s.work, s.y_new)
        error = error_norm(length, y, s.y_new, s.K, mechanical, tolerance) if status == 0 else np.inf
        if not error <= 1.0:
            rejected += 1
            h = length * min(_step_factor(error), 1.0)
            continue
        gap_new = s.work.scalars[GAP]
        clear = phase.state == FREE and (not phase.watched or min(gap, gap_new) > 2.0 * length * speed)
        due = (number + count) * interval < t + length
        guard, place, rate = NO_GUARD, 1.0, 0.0
        if due or not clear:
            status, _ = stages(system, phase, t, y, length, STAGES + 1, DENSE_STAGES - 1, s.K, s.work, s.at)
            interpolant(y, s.y_new, length, s.K, s.F)
        if clear:
            s.armed[GUARD_NORMAL] = True
        elif status == 0:
            guard, place, rate, force, deepest = first_fall(system, phase, t, length, y, s)
            peak, depth = max(peak, force), max(depth, deepest)
        if status != 0 or guard == UNDEFINED:
            # the contact problem has no solution further on in this step: approach that point
            rejected += 1
            h = _SHRINK * length
            continue
        if due:
            count = _emit(t, t + place * length, length, y, interval, number, count, s)
        steps += 1
        if guard >= 0:
            length = _land(system, phase, t, y, place * length, rate, guard, s)
            copy(s.y_new, y)
            return Progress(AT_GUARD, guard, t + length, h, steps, rejected, count, peak, depth)
        t = t_stop if last else t + length
        copy(s.y_new, y)
        copy(s.K[STAGES], s.K[0])
        gap = gap_new
        if not last:
            h = length * _step_factor(error)
        if not _bounded(y, mechanical):
            return Progress(FAILED_FINITE, NO_GUARD, t, h, steps, rejected, count, peak, depth)
    return Progress(AT_STOP, NO_GUARD, t, h, steps, rejected, count, peak, depth)


class EventScheme(Scheme):
    """Adaptive order 8 with located transitions.

    Parameters
    ----------
    tolerance : float
        Accuracy wanted of q and q', absolute and relative; the error of a single step is held to a
        fiftieth of it, because a second of motion takes thousands of steps.
    march : callable
        `march_event` itself for a system in plain Python, or its compiled form.
    """

    name = "event"
    order = ORDER
    stepwise = False

    def __init__(self, tolerance: float, march: Any = march_event) -> None:
        self.tolerance = tolerance
        self._march = march
        self._pace = Pace()

    def begin(self, phase: Phase, scratch: Scratch, tolerances: Tolerances, initial_guards: Array) -> None:
        """Arm the guards that start clearly positive; the others must rise first."""
        arm(phase, scratch, tolerances, initial_guards)

    def march(self, system: Any, phase: Phase, course: Course, t_stop: float, scratch: Scratch) -> Progress:
        """Advance to the next event, or for about a tenth of a second of computing."""
        started = time.perf_counter()
        progress: Progress = self._march(
            system,
            phase,
            course.t,
            course.y,
            course.h,
            t_stop,
            _SHARE_OF_A_STEP * self.tolerance,
            course.output_interval,
            course.next_sample,
            self._pace.steps,
            scratch,
        )
        self._pace.learn(progress.steps, time.perf_counter() - started)
        course.t, course.h = progress.t, progress.h
        course.next_sample += progress.samples
        return progress
