"""Event-located marching: adaptive order 8, every change of a guard's sign found inside the step.

After each step the guards and their slopes are taken at five points of the dense output.  A sign change
between two points brackets an event; a cubic through values and slopes shows where a guard may dip
below zero in between, and the dip is searched.  The bracketed time is then sharpened by repeating the
step up to it, so an event is as accurate as a step.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from oblique_impact.contact import FREE, GUARD_LOWER, GUARD_NORMAL, GUARD_UPPER, Phase, measure_guards
from oblique_impact.integrators.base import (
    AT_GUARD,
    AT_STOP,
    BUFFER_FULL,
    FAILED_FINITE,
    FAILED_STEP,
    Course,
    Progress,
    Scheme,
    Scratch,
    Tolerances,
)
from oblique_impact.integrators.dop853 import (
    DENSE_STAGES,
    ORDER,
    STAGES,
    error_norm,
    interpolant,
    interpolate,
    stages,
)
from oblique_impact.integrators.motion import QUADRATURES, copy, derivative
from oblique_impact.jit import jitable
from oblique_impact.system import FIRST_GUARD, GAP, GUARDS, LAMBDA_N, Array

_INTERVALS = 4
_SLOPE_STEP = 1e-4  # of a step
_SAFETY, _SHRINK, _GROW = 0.9, 0.2, 6.0
_EXPONENT = -1.0 / 8.0
_SUSPECT = 0.25  # a dip estimated below this part of its neighbours is searched
_SUSPECT_SCALE = 1e-3
_UNBOUNDED = 1e12
_SHARE_OF_A_STEP = 0.02
_FIRST_LEG, _SECONDS_PER_LEG = 500, 0.1  # steps, and wall time of a leg: progress and interrupts stay prompt
_NO_GUARD, _UNDEFINED = -1, -2
_SMALLEST, _SMALLEST_TIME = 1e-14, 1e-3  # steps below this part of the time (s) are lost in rounding


@jitable
def _guards_at(system: Any, phase: Phase, t: float, h: float, x: float, y: Array, s: Scratch) -> bool:
    """Guards at the fraction x of the step into the work; False if they are undefined there."""
    interpolate(s.F, y, x, s.at)
    if derivative(system, phase, t + x * h, s.at, s.work, s.K[DENSE_STAGES - 1]) != 0:
        return False
    measure_guards(phase, s.work.scalars)
    return True


@jitable
def _shifted(s: Scratch, guard: int) -> float:
    """Return a measured guard, raised by its threshold until it is armed."""
    return float(s.work.scalars[FIRST_GUARD + guard] + (0.0 if s.armed[guard] else s.thresholds[guard]))


@jitable
def _locate(
    system: Any, phase: Phase, t: float, h: float, y: Array, s: Scratch, guard: int, a: float, b: float, dip: bool
) -> float:
    """Fraction in (a, b] of the step where the guard falls through zero; -1 if it never does.

    With `dip` the guard is positive at both ends and its least value is searched first (golden section);
    then the Illinois method closes in on the root.
    """
    if dip:
        lower, upper, found = a, b, False
        for _ in range(60):
            probe = lower + 0.381966011250105 * (upper - lower)
            mirror = lower + upper - probe
            left = _shifted(s, guard) if _guards_at(system, phase, t, h, probe, y, s) else -1.0
            right = _shifted(s, guard) if _guards_at(system, phase, t, h, mirror, y, s) else -1.0
            if left <= 0.0 or right <= 0.0:
                b, found = (probe if left <= 0.0 else mirror), True
                break
            if left < right:
                upper = mirror
            else:
                lower = probe
            if upper - lower < 1e-7:
                break
        if not found:
            return -1.0
    fa = _shifted(s, guard) if _guards_at(system, phase, t, h, a, y, s) else -1.0
    if not s.armed[guard]:
        # a flight shorter than the subinterval: its end is a root only where the guard has risen before
        x = b
        for _ in range(40):
            x = a + 0.5 * (x - a)
            defined = _guards_at(system, phase, t, h, x, y, s)
            if defined and s.work.scalars[FIRST_GUARD + guard] > s.thresholds[guard]:
                a, fa = x, s.work.scalars[FIRST_GUARD + guard]
                s.armed[guard] = True
                break
    fb = _shifted(s, guard) if _guards_at(system, phase, t, h, b, y, s) else -1.0
    if fa <= 0.0:
        return a
    for _ in range(200):
        if b - a <= 1e-13 or fb == 0.0:
            break
        x = (a * fb - b * fa) / (fb - fa)
        if not (a < x < b):
            x = 0.5 * (a + b)
        fx = _shifted(s, guard) if _guards_at(system, phase, t, h, x, y, s) else -1.0
        if fx > 0.0:
            a, fa, fb = x, fx, 0.5 * fb
        else:
            b, fb, fa = x, fx, 0.5 * fa
    return b


@jitable
def _cubic_dip(ga: float, gb: float, sa: float, sb: float) -> tuple[float, bool]:
    """Least value of the cubic with these end values and slopes on [0, 1], and whether it lies inside."""
    best, inside = min(ga, gb), False
    c2 = 3.0 * (gb - ga) - 2.0 * sa - sb
    c3 = sa + sb - 2.0 * (gb - ga)
    discriminant = c2 * c2 - 3.0 * c3 * sa
    if discriminant < 0.0:
        return best, inside
    root = np.sqrt(discriminant)
    for sign in (-1.0, 1.0):
        denominator = c2 + sign * root
        if denominator == 0.0:
            continue
        x = -sa / denominator
        if 0.0 < x < 1.0:
            value = ga + x * (sa + x * (c2 + x * c3))
            if value < best:
                best, inside = value, True
    return best, inside


@jitable
def _suspect(s: Scratch, i: int, guard: int) -> int:
    """Whether a guard falls (2) or may dip (1) below zero in subinterval i, or stays positive (0)."""
    offset = 0.0 if s.armed[guard] else s.thresholds[guard]
    ga, gb = s.values[i, guard] + offset, s.values[i + 1, guard] + offset
    if gb <= 0.0:
        return 2
    sa, sb = s.slopes[i, guard] / _INTERVALS, s.slopes[i + 1, guard] / _INTERVALS
    least, inside = _cubic_dip(ga, gb, sa, sb)
    scale = max(abs(ga), abs(gb), abs(sa), abs(sb))
    # a guard that has not risen yet starts near zero: only a dip below its threshold is one
    margin = _SUSPECT * min(ga, gb) + _SUSPECT_SCALE * scale if s.armed[guard] else 0.0
    return 1 if inside and least < margin else 0


@jitable
def _largest_force(s: Scratch, i: int) -> float:
    """Largest normal force in subinterval i, by the cubic through values and slopes."""
    a, b = s.values[i, GUARDS], s.values[i + 1, GUARDS]
    sa, sb = s.slopes[i, GUARDS] / _INTERVALS, s.slopes[i + 1, GUARDS] / _INTERVALS
    return -_cubic_dip(-a, -b, -sa, -sb)[0]


@jitable
def _first_fall(system: Any, phase: Phase, t: float, h: float, y: Array, s: Scratch) -> tuple[int, float, float]:
    """First guard that falls through zero within the step, the fraction where, and the peak normal force."""
    defined = _INTERVALS + 1
    for i in range(2 * (_INTERVALS + 1)):
        end, slope = i // 2, i % 2 == 1
        shift = (-_SLOPE_STEP if end == _INTERVALS else _SLOPE_STEP) if slope else 0.0
        if not _guards_at(system, phase, t, h, end / _INTERVALS + shift, y, s):
            defined = end
            break
        for k in range(GUARDS + 1):
            value = s.work.scalars[FIRST_GUARD + k] if k < GUARDS else s.work.scalars[LAMBDA_N]
            if slope:
                s.slopes[end, k] = (value - s.values[end, k]) / shift
            else:
                s.values[end, k] = value
    peak = 0.0
    for i in range(defined - 1):
        first, place = _NO_GUARD, 2.0
        for k in range(GUARDS):
            suspicion = _suspect(s, i, k)
            if suspicion > 0:
                a, b = i / _INTERVALS, (i + 1) / _INTERVALS
                x = _locate(system, phase, t, h, y, s, k, a, b, suspicion == 1)
                if 0.0 <= x < place:
                    first, place = k, x
        if first >= 0:
            return first, place, max(peak, s.values[i, GUARDS])
        peak = max(peak, _largest_force(s, i))
        for k in range(GUARDS):
            s.armed[k] = s.armed[k] or s.values[i + 1, k] > s.thresholds[k]
    return (_NO_GUARD if defined == _INTERVALS + 1 else _UNDEFINED), 1.0, peak


@jitable
def _fall_rate(s: Scratch, place: float, h: float, guard: int) -> float:
    """Slope of a guard (per second) at a fraction of the step, from the sampled slopes."""
    i = min(int(place * _INTERVALS), _INTERVALS - 1)
    part = place * _INTERVALS - i
    return float(((1.0 - part) * s.slopes[i, guard] + part * s.slopes[i + 1, guard]) / h)


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

    Newton's method on the length with the guard's slope `rate`; the dense output that bracketed the event
    is only of order 7.
    """
    for _ in range(4):
        status, _ = stages(system, phase, t, y, length, 1, STAGES, s.K, s.work, s.y_new)
        measure_guards(phase, s.work.scalars)
        correction = -_shifted(s, guard) / rate if rate < 0.0 else 0.0
        if status != 0 or not 1e-15 * t < abs(correction) < 0.1 * length:
            return length
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
    steps, rejected, count, peak = 0, 0, 0, 0.0
    mechanical, capacity = y.shape[0] - QUADRATURES, s.times.shape[0]
    status = derivative(system, phase, t, y, s.work, s.K[0])
    if status != 0:
        return Progress(-status, _NO_GUARD, t, h, steps, rejected, count, peak)
    gap = s.work.scalars[GAP]
    while t < t_stop:
        if count > capacity // 2 or steps >= most_steps:
            return Progress(BUFFER_FULL, _NO_GUARD, t, h, steps, rejected, count, peak)
        h = min(h, 0.45 * capacity * interval)
        if h <= _SMALLEST * max(t, _SMALLEST_TIME):
            return Progress(-status if status != 0 else FAILED_STEP, _NO_GUARD, t, h, steps, rejected, count, peak)
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
        guard, place = _NO_GUARD, 1.0
        if due or not clear:
            status, _ = stages(system, phase, t, y, length, STAGES + 1, DENSE_STAGES - 1, s.K, s.work, s.at)
            interpolant(y, s.y_new, length, s.K, s.F)
        if clear:
            s.armed[GUARD_NORMAL] = True
        elif status == 0:
            guard, place, force = _first_fall(system, phase, t, length, y, s)
            peak = max(peak, force)
        if status != 0 or guard == _UNDEFINED:
            # the contact problem has no solution further on in this step: approach that point
            rejected += 1
            h = _SHRINK * length
            continue
        if due:
            count = _emit(t, t + place * length, length, y, interval, number, count, s)
        steps += 1
        if guard >= 0:
            rate = _fall_rate(s, place, length, guard)
            length = _land(system, phase, t, y, place * length, rate, guard, s)
            copy(s.y_new, y)
            return Progress(AT_GUARD, guard, t + length, h, steps, rejected, count, peak)
        t = t_stop if last else t + length
        copy(s.y_new, y)
        copy(s.K[STAGES], s.K[0])
        gap = gap_new
        if not last:
            h = length * _step_factor(error)
        if not _bounded(y, mechanical):
            return Progress(FAILED_FINITE, _NO_GUARD, t, h, steps, rejected, count, peak)
    return Progress(AT_STOP, _NO_GUARD, t, h, steps, rejected, count, peak)


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
        self._leg = _FIRST_LEG

    def begin(self, phase: Phase, scratch: Scratch, tolerances: Tolerances, initial_guards: Array) -> None:
        """Arm the guards that start clearly positive; the others must rise first."""
        thresholds = scratch.thresholds
        if phase.state == FREE:
            thresholds[:] = tolerances.gap
        else:
            thresholds[:] = tolerances.force
            if phase.spring > 0.0:
                thresholds[GUARD_NORMAL] = tolerances.gap
            if phase.state == 1:
                thresholds[GUARD_LOWER] = thresholds[GUARD_UPPER] = tolerances.velocity
        scratch.armed[:] = initial_guards > thresholds

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
            self._leg,
            scratch,
        )
        if progress.steps >= self._leg:
            pace = (time.perf_counter() - started) / progress.steps
            self._leg = max(1, int(min(_SECONDS_PER_LEG / pace, 1e6)))
        course.t, course.h = progress.t, progress.h
        course.next_sample += progress.samples
        return progress
