"""Generalized-alpha: implicit, second order, with selectable dissipation at high frequencies.

The steps are those of :mod:`~oblique_impact.marching.alpha_step`; transitions are located by shortening
the step.  What is reported of a rigid contact, forces and accelerations, are the algorithm's own means,
(1 - alpha_f) lambda1 + alpha_f lambda0: the values at the ends of the steps swing about them by a factor of
-rho_infinity per step after every jump.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from oblique_impact.contact.forces import FREE, GUARD_NORMAL, Phase, measure_guards, stop_force
from oblique_impact.kernels.implicit import residual
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.system import FIRST_GUARD, GAP, GAP_RATE, GUARDS, LAMBDA_N, LAMBDA_T, Array
from oblique_impact.marching.alpha_step import (
    CONTACT_N,
    CONTACT_T,
    EXTRAS,
    FAR,
    NEAR,
    ODD,
    REPORTED_N,
    REPORTED_T,
    Coefficients,
    coefficients,
    finish_step,
    start_phase,
    take_step,
)
from oblique_impact.marching.equations import QUADRATURES, copy
from oblique_impact.marching.scheme import (
    AT_GUARD,
    AT_STOP,
    BUFFER_FULL,
    FAILED_FINITE,
    Course,
    Progress,
    Scheme,
    Scratch,
    Tolerances,
    arm,
)

_UNBOUNDED = 1e12
_LOCATED = 1e-12  # s
_LANDED = 1e-12  # m, or the unit of another guard: how far below zero it may be found
#: a leg begins with what is known of the convergence forgotten, so its length is part of the result in the last
#: digits: counted, not timed, or two runs would differ
_STEPS_PER_LEG, _WORK_PER_LEG = 2_000, 500_000  # the latter in steps times degrees of freedom
_START, _END = 0, 1
_GENTLE_STEPS = 1


@jitable
def _measure(phase: Phase, s: Scratch, row: int) -> None:
    """Guards at the end of a step, the gap and its rate into a row of the scratch."""
    measure_guards(phase, s.work.scalars)
    for g in range(GUARDS):
        s.values[row, g] = s.work.scalars[FIRST_GUARD + g]
    s.slopes[row, GUARD_NORMAL] = s.work.scalars[GAP_RATE]


@jitable
def _measure_end(phase: Phase, c: Coefficients, y: Array, s: Scratch) -> None:
    """Guards at the end of a step from y, with the contact forces to report; those of the end go into s.y_new."""
    k, extras = s.work.scalars, 5 * s.work.vectors.shape[1] + QUADRATURES
    s.y_new[extras + CONTACT_N], s.y_new[extras + CONTACT_T] = k[LAMBDA_N], k[LAMBDA_T]
    if phase.state != FREE and phase.spring > 0.0:
        k[LAMBDA_N] = stop_force(phase, k[GAP], k[GAP_RATE])  # its law to the last digit
    elif phase.state != FREE:
        k[LAMBDA_N] += c.alpha_f * (y[extras + CONTACT_N] - k[LAMBDA_N])
        k[LAMBDA_T] += c.alpha_f * (y[extras + CONTACT_T] - k[LAMBDA_T])
    _measure(phase, s, _END)


@jitable
def _raised(s: Scratch, row: int, guard: int) -> float:
    """Return a guard, raised by its threshold until it is armed."""
    return float(s.values[row, guard] + (0.0 if s.armed[guard] else s.thresholds[guard]))


@jitable
def _shorten(
    system: Any, phase: Phase, c: Coefficients, t: float, y: Array, h: float, guard: int, s: Scratch
) -> tuple[int, float]:
    """Length in (0, h] of the step that ends where the guard, fallen at h, falls (Illinois), and the status."""
    a, b, fa, fb = 0.0, h, _raised(s, _START, guard), _raised(s, _END, guard)
    status = 0
    for _ in range(80):
        if (
            fb >= -0.1 * min(s.thresholds[guard], _LANDED)
            or b - a <= (1e-3 if phase.state == FREE else 1.0) * _LOCATED
        ):
            break
        x = 0.5 * (a + b)  # a phase that starts at zero may rise first and fall later: halve until it is seen
        if fa > 0.0:
            x = (a * fb - b * fa) / (fb - fa)
            x = min(max(x, a + 0.01 * (b - a)), b - 0.01 * (b - a))
        status = take_step(system, phase, c, t, y, x, ODD, True, s)
        if status != 0:
            return status, x
        _measure_end(phase, c, y, s)
        fx = _raised(s, _END, guard)
        if fx > 0.0:
            fb = 0.5 * fb if a > 0.0 else fb
            a, fa = x, fx
        else:
            fa = 0.5 * fa if b < h else fa
            b, fb = x, fx
    return status, b


@jitable
def _dip(s: Scratch, h: float) -> float:
    """Part of a step where the cubic through gap and gap rate has its least value, if below zero; else 0."""
    ga, gb = s.values[_START, GUARD_NORMAL], s.values[_END, GUARD_NORMAL]
    sa, sb = h * s.slopes[_START, GUARD_NORMAL], h * s.slopes[_END, GUARD_NORMAL]
    if sa >= 0.0 or sb <= 0.0:
        return 0.0
    c2, c3 = 3.0 * (gb - ga) - 2.0 * sa - sb, sa + sb - 2.0 * (gb - ga)
    x = -sa / (c2 + np.sqrt(max(c2 * c2 - 3.0 * c3 * sa, 0.0)))
    value = ga + x * (sa + x * (c2 + x * c3))
    return float(x) if 0.0 < x < 1.0 and value < 0.0 else 0.0


@jitable
def _fall(
    system: Any, phase: Phase, c: Coefficients, t: float, y: Array, h: float, s: Scratch
) -> tuple[int, int, float]:
    """First guard that falls in the step just taken, or -1; the status and the length of the step up to it.

    Afterwards s.y_new is that shorter step, or the whole one.
    """
    first, length, redo = -1, h, False
    if phase.state == FREE and s.armed[GUARD_NORMAL] and s.values[_END, GUARD_NORMAL] > 0.0:
        part = _dip(s, h)
        if part > 0.0:
            redo, length = True, part * h
            status = take_step(system, phase, c, t, y, length, ODD, True, s)
            if status != 0:
                return -1, status, length
            _measure_end(phase, c, y, s)
            if s.values[_END, GUARD_NORMAL] > 0.0:  # the gap only comes close
                length = h
    for guard in range(GUARDS):
        # each guard found fallen shortens the step; one that falls earlier still is fallen there too
        if _raised(s, _END, guard) <= 0.0:
            status, length = _shorten(system, phase, c, t, y, length, guard, s)
            if status != 0:
                return -1, status, length
            first, redo = guard, True
            status = take_step(system, phase, c, t, y, length, ODD, True, s)
            if status != 0:
                return -1, status, length
            _measure_end(phase, c, y, s)
    if redo and first < 0:
        status = take_step(system, phase, c, t, y, length, ODD, True, s)
        if status != 0:
            return -1, status, length
        _measure_end(phase, c, y, s)
    return first, 0, length


@jitable
def _open(system: Any, phase: Phase, t: float, y: Array, fresh: bool, s: Scratch) -> int:
    """Guards at the start of a leg; a `fresh` phase gets its accelerations and forces first."""
    d, k, status = s.work.vectors.shape[1], s.work.scalars, 0
    if fresh:
        status = start_phase(system, phase, t, y, s.work)
    else:
        extras = 5 * d + QUADRATURES
        residual(system, t, y[:d], y[d : 2 * d], y[3 * d + QUADRATURES : 4 * d + QUADRATURES], True, s.work)
        k[LAMBDA_N], k[LAMBDA_T] = y[extras + REPORTED_N], y[extras + REPORTED_T]
    _measure(phase, s, _START)
    return status


@jitable
def _carry_on(s: Scratch) -> None:
    """Make the end of a step the start of the next."""
    for g in range(GUARDS):
        s.armed[g] = s.armed[g] or s.values[_END, g] > s.thresholds[g]
        s.values[_START, g] = s.values[_END, g]
    s.slopes[_START, GUARD_NORMAL] = s.slopes[_END, GUARD_NORMAL]


@jitable
def _forget(y: Array, d: int) -> None:
    """Set the algorithmic acceleration to zero: with it a gentle step is one of backward Euler."""
    for i in range(4 * d + QUADRATURES, 5 * d + QUADRATURES):
        y[i] = 0.0


@jitable
def march_alpha(
    system: Any,
    phase: Phase,
    c: Coefficients,
    gentle: Coefficients,
    gentle_steps: int,
    start: float,
    done: int,
    last: float,
    y: Array,
    far_step: float,
    near_step: float,
    near: float,
    t_stop: float,
    output_interval: float,
    next_sample: int,
    most_steps: int,
    fresh: bool,
    s: Scratch,
) -> tuple[Progress, int, float, int]:
    """Advance y in place; the times are start + k h as long as the step h (`last`) stays the same.

    The first `gentle_steps` take the coefficients `gentle` and no initial acceleration.  Returns the progress,
    the number of the next sample, and the new start and k.
    """
    steps, count, peak, depth = 0, 0, 0.0, 0.0
    d, capacity = s.work.vectors.shape[1], s.times.shape[0]
    t, h = start + done * last, last
    status = _open(system, phase, t, y, fresh, s)
    gap = s.work.scalars[GAP]
    stale_far, stale_near = True, True
    while True:
        if status != 0:
            return Progress(-status, -1, t, h, steps, 0, count, peak, depth), next_sample, start, done
        if t >= t_stop:
            return Progress(AT_STOP, -1, t, h, steps, 0, count, peak, depth), next_sample, t, 0
        if count >= capacity or steps >= most_steps:
            return Progress(BUFFER_FULL, -1, t, h, steps, 0, count, peak, depth), next_sample, start, done
        flying = phase.state == FREE and (not phase.watched or gap > near)
        wanted = far_step if flying else near_step
        if wanted != h:
            start, done, h = t, 0, wanted
        following = start + (done + 1) * h
        cut = following > t_stop - 1e-9 * h
        following = t_stop if cut else following
        length = following - t if cut else h
        now = c
        if steps < gentle_steps:
            now = gentle
            _forget(y, d)
        slot = ODD if cut or steps < gentle_steps else (FAR if flying else NEAR)
        stale = slot == ODD or (stale_far if flying else stale_near)
        status = take_step(system, phase, now, t, y, length, slot, stale, s)
        if status != 0:
            continue
        stale_far, stale_near = stale_far and slot != FAR, stale_near and slot != NEAR
        _measure_end(phase, now, y, s)
        guard, whole = -1, length
        if phase.state != FREE or phase.watched:
            guard, status, length = _fall(system, phase, now, t, y, whole, s)
            if status != 0:
                continue
        if guard >= 0 and length <= _LOCATED:
            # it falls with the very first of the step: what the last step left is where the phase ends
            return Progress(AT_GUARD, guard, t, h, steps, 0, count, peak, depth), next_sample, t, 0
        finish_step(system, phase, now, t, y, length, s)
        copy(s.y_new, y)
        steps += 1
        peak = max(peak, y[5 * d + QUADRATURES + REPORTED_N])
        gap = s.work.scalars[GAP]
        depth = max(depth, -gap)
        for m in range(2 * d):
            if not abs(y[m]) < _UNBOUNDED:
                return Progress(FAILED_FINITE, -1, t, h, steps, 0, count, peak, depth), next_sample, start, done
        if guard >= 0:
            return (
                Progress(AT_GUARD, guard, t + length, h, steps, 0, count, peak, depth),
                next_sample,
                t + length,
                0,
            )
        _carry_on(s)
        t, done = following, done + 1
        if t >= next_sample * output_interval * (1.0 - 1e-12) and t < t_stop:
            s.times[count] = t
            copy(y, s.states[count])
            count += 1
            next_sample = int(t / output_interval * (1.0 + 1e-12)) + 1


class GeneralizedAlphaScheme(Scheme):
    """Generalized-alpha with one step for flight, one for contact and flight close to the slope.

    Parameters
    ----------
    free_step, contact_step : float
        s.
    rho_infinity : float
        Spectral radius at infinite frequency, from 0 (annihilates) to 1 (conserves).
    near : float
        Gap (m) below which a flight takes the contact step: short flights between the impacts of one
        collision carry the vibrations that decide when the next begins.
    tolerance : float
        Of the iterations of a step, on the root of the energy of a correction (J^1/2).
    march : callable
        `march_alpha` itself for a system in plain Python, or its compiled form.
    """

    name = "generalized-alpha"
    order = 2
    stepwise = False

    def __init__(
        self,
        free_step: float,
        contact_step: float,
        rho_infinity: float = 0.8,
        near: float = 0.0,
        tolerance: float = 1e-10,
        march: Any = march_alpha,
    ) -> None:
        self.free_step, self.contact_step, self.near = free_step, contact_step, near
        self.coefficients = coefficients(rho_infinity, tolerance)
        self._gentle = Coefficients(0.0, 0.0, 1.0, 1.0, tolerance)
        self._gentle_steps = 0
        self._rigid = self._flying = False  # what the phase before was
        self._march = march
        self._fresh = True

    def extra_state(self, size: int) -> int:
        """Accelerations, contact forces and rates behind the quadratures."""
        return 3 * size + EXTRAS

    def begin(self, phase: Phase, scratch: Scratch, tolerances: Tolerances, initial_guards: Array) -> None:
        """Arm the guards that start clearly positive; accelerations start anew.

        Accelerations that start anew throw vibrations that the step does not resolve: their velocity overshoots
        by omega h (Hilber and Hughes 1978), and with every impact of a rigid contact energy would be gained.  The
        first steps of phases that begin or end at one, also of a flight after a rebound, are those of backward
        Euler, which has no use for them.
        """
        arm(phase, scratch, tolerances, initial_guards)
        rigid = phase.state != FREE and phase.spring == 0.0
        rebound = phase.state == FREE and self._flying
        self._gentle_steps = _GENTLE_STEPS if rigid or self._rigid or rebound else 0
        self._fresh, self._rigid, self._flying = True, rigid, phase.state == FREE

    def march(self, system: Any, phase: Phase, course: Course, t_stop: float, scratch: Scratch) -> Progress:
        """Advance to the next event, or for some thousand steps."""
        if self._fresh:
            course.phase_steps = 0
        progress, course.next_sample, course.phase_start, course.phase_steps = self._march(
            system,
            phase,
            self.coefficients,
            self._gentle,
            self._gentle_steps,
            course.phase_start,
            course.phase_steps,
            0.0 if self._fresh else course.h,
            course.y,
            self.free_step,
            self.contact_step,
            self.near,
            t_stop,
            course.output_interval,
            course.next_sample,
            min(_STEPS_PER_LEG, max(1, _WORK_PER_LEG // scratch.work.vectors.shape[1])),
            self._fresh,
            scratch,
        )
        self._fresh = progress[0] == AT_GUARD
        progress = Progress(*progress)
        self._gentle_steps = max(0, self._gentle_steps - progress.steps)
        course.t, course.h = progress.t, progress.h
        return progress
