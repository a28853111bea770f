"""Fixed-step marching as the paper does it: classical RK4, states judged once per step.

Contact begins at the end of the first step with Z_n < 0 and Z_n' < 0; in contact every step asks
whether the sticking solution lies inside the friction cone (paper Sec. 5.3) and whether the normal
force still pushes (paper Sec. 6).
"""

from __future__ import annotations

import time
from typing import Any

from oblique_impact.contact.forces import (
    FREE,
    GUARD_LOWER,
    GUARD_NORMAL,
    GUARD_UPPER,
    SLIDING,
    Phase,
    sticking_force,
)
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.system import GAP, GAP_RATE, LAMBDA_N, LAMBDA_T, SLIP, SLIP_RATE, Array
from oblique_impact.marching.equations import QUADRATURES, copy, derivative
from oblique_impact.marching.scheme import (
    AT_GUARD,
    AT_STOP,
    BUFFER_FULL,
    FAILED_FINITE,
    Course,
    Pace,
    Progress,
    Scheme,
    Scratch,
    Tolerances,
)

GUARD_JUDGED = 4  # the paper's judgement changed between sliding and sticking

_UNBOUNDED = 1e12


@jitable
def _step(system: Any, phase: Phase, t: float, y: Array, h: float, s: Scratch) -> int:
    """One step of RK4 from (t, y) into s.y_new; s.K[0] holds the derivative at the start."""
    K, at = s.K, s.at
    for i in range(3):
        part = h if i == 2 else 0.5 * h
        for m in range(y.shape[0]):
            at[m] = y[m] + part * K[i, m]
        status = derivative(system, phase, t + part, at, s.work, K[i + 1])
        if status != 0:
            return status
    for m in range(y.shape[0]):
        s.y_new[m] = y[m] + h / 6.0 * (K[0, m] + 2.0 * (K[1, m] + K[2, m]) + K[3, m])
    return 0


@jitable
def sticks(phase: Phase, reference: float, k: Array) -> bool:
    """Whether the sticking solution at a condensed instant pushes and lies in the cone; keeps the forces."""
    normal, tangential = k[LAMBDA_N], k[LAMBDA_T]
    status = sticking_force(phase, reference, k)
    inside = status == 0 and k[LAMBDA_N] > 0.0 and abs(k[LAMBDA_T]) <= phase.static * k[LAMBDA_N]
    k[LAMBDA_N], k[LAMBDA_T] = normal, tangential
    return inside


@jitable
def _judge(phase: Phase, k: Array) -> int:
    """Guard that fell at the end of a step, or -1."""
    if phase.state == FREE:
        return GUARD_NORMAL if phase.watched and k[GAP] < 0.0 and k[GAP_RATE] < 0.0 else -1
    if k[LAMBDA_N] <= 0.0:
        return GUARD_NORMAL
    if phase.state != SLIDING:
        return -1 if sticks(phase, phase.slip_reference, k) else GUARD_JUDGED
    if phase.static >= 0.0 and sticks(phase, k[SLIP], k):
        return GUARD_JUDGED
    if k[SLIP_RATE] < phase.lower:
        return GUARD_LOWER
    if k[SLIP_RATE] > phase.upper:
        return GUARD_UPPER
    return -1


@jitable
def march_fixed(
    system: Any,
    phase: Phase,
    start: float,
    done: int,
    y: Array,
    h: float,
    t_stop: float,
    output_interval: float,
    next_sample: int,
    most_steps: int,
    s: Scratch,
) -> tuple[Progress, int]:
    """Advance y in place by steps of h, the times being start + k h; returns the next sample's number too."""
    steps, count, peak, depth = 0, 0, 0.0, 0.0
    t = start + done * h
    mechanical = y.shape[0] - QUADRATURES
    status = derivative(system, phase, t, y, s.work, s.K[0])
    while True:
        if status != 0:
            return Progress(-status, -1, t, h, steps, 0, count, peak, depth), next_sample
        if t >= t_stop:
            return Progress(AT_STOP, -1, t, h, steps, 0, count, peak, depth), next_sample
        if count >= s.times.shape[0] or steps >= most_steps:
            return Progress(BUFFER_FULL, -1, t, h, steps, 0, count, peak, depth), next_sample
        following = start + (done + 1) * h
        if following > t_stop - 1e-9 * h:
            following = t_stop
        status = _step(system, phase, t, y, following - t, s)
        if status != 0:
            continue
        steps += 1
        done += 1
        t = following
        copy(s.y_new, y)
        for m in range(mechanical):
            if not abs(y[m]) < _UNBOUNDED:
                return Progress(FAILED_FINITE, -1, t, h, steps, 0, count, peak, depth), next_sample
        status = derivative(system, phase, t, y, s.work, s.K[0])
        if status != 0:
            continue
        peak, depth = max(peak, s.work.scalars[LAMBDA_N]), max(depth, -s.work.scalars[GAP])
        guard = _judge(phase, s.work.scalars)
        if guard >= 0:
            return Progress(AT_GUARD, guard, t, h, steps, 0, count, peak, depth), next_sample
        if t >= next_sample * output_interval * (1.0 - 1e-12) and t < t_stop:
            s.times[count] = t
            copy(y, s.states[count])
            count += 1
            next_sample = int(t / output_interval * (1.0 + 1e-12)) + 1


class FixedStepScheme(Scheme):
    """Classical RK4 with one step for free flight and one for contact."""

    name = "fixed-step"
    order = 4
    stepwise = True

    def __init__(self, free_step: float, contact_step: float, march: Any = march_fixed) -> None:
        self.free_step, self.contact_step = free_step, contact_step
        self._march = march
        self._pace = Pace()

    def begin(self, phase: Phase, scratch: Scratch, tolerances: Tolerances, initial_guards: Array) -> None:
        """Nothing to prepare: every step is judged on its own."""

    def march(self, system: Any, phase: Phase, course: Course, t_stop: float, scratch: Scratch) -> Progress:
        """Advance until a step's judgement differs from the phase, or for about a tenth of a second."""
        h = self.free_step if phase.state == FREE else self.contact_step
        started = time.perf_counter()
        progress, course.next_sample = self._march(
            system,
            phase,
            course.phase_start,
            course.phase_steps,
            course.y,
            h,
            t_stop,
            course.output_interval,
            course.next_sample,
            self._pace.steps,
            scratch,
        )
        self._pace.learn(progress[4], time.perf_counter() - started)
        course.t = progress.t
        course.phase_steps += progress.steps
        if progress.reason == AT_STOP:  # the last step was cut; the next ones are counted from here
            course.phase_start, course.phase_steps = progress.t, 0
        return Progress(*progress)
