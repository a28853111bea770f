"""Fixed-step marching as the paper does it: classical RK4, contact states decided once per step.

Contact begins at the end of the first step with Z_n < 0 and Z_n' < 0; in contact every step asks whether the
slip sticks (:func:`~oblique_impact.contact.forces.can_stick`) and whether the normal force still pushes (paper,
Secs. 5.3 and 6).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np

from oblique_impact.contact.forces import can_stick
from oblique_impact.contact.state import END, FREE, LOWER, NORMAL, SLIDING, SWITCHED, UPPER, Instant, Phase
from oblique_impact.contact.transitions import StickCriterion
from oblique_impact.kernels.jit import by_reference, jitable, kernel
from oblique_impact.kernels.system import NormalModes
from oblique_impact.kernels.workspace import Array, copy
from oblique_impact.marching.equations import derivative
from oblique_impact.marching.scheme import (
    AT_GUARD,
    AT_STOP,
    FAILED_FINITE,
    LIMIT_REACHED,
    NO_GUARD,
    Limits,
    Prepared,
    Progress,
    Returned,
    Scheme,
    Scratch,
    StepState,
    bounded,
    keep_sample,
    progress_of,
)


@jitable
def _step(system: Any, phase: Phase, t: float, y: Array, h: float, s: Scratch, K: Array) -> int:
    """One step of RK4 from (t, y) into s.y_new; K[0] holds the derivative at the start."""
    at = s.at
    for i in range(3):
        part = h if i == 2 else 0.5 * h
        for m in range(y.shape[0]):
            at[m] = y[m] + part * K[i, m]
        status, _ = derivative(system, phase, t + part, at, s.work, K[i + 1])
        if status != 0:
            return status
    for m in range(y.shape[0]):
        s.y_new[m] = y[m] + h / 6.0 * (K[0, m] + 2.0 * (K[1, m] + K[2, m]) + K[3, m])
    return 0


@jitable
def _fallen(phase: Phase, c: Instant, stopping_time: float, rounding: float) -> int:
    """Guard that fell at the end of a step, or NO_GUARD; a slip velocity within `rounding` (m/s) has no sign."""
    if phase.state == FREE:
        return (
            NORMAL
            if phase.surface.enabled and phase.surface.side * c.gap < 0.0 and phase.surface.side * c.gap_rate < 0.0
            else NO_GUARD
        )
    if c.normal_force <= 0.0:
        return NORMAL
    if c.slip < phase.surface.first or c.slip > phase.surface.last:
        return END
    sticks = phase.stick.static >= 0.0 and can_stick(phase, c, stopping_time)
    if phase.state != SLIDING:
        return NO_GUARD if sticks else SWITCHED
    if sticks:
        return SWITCHED
    if c.slip_rate < phase.friction.lower - rounding:
        return LOWER
    if c.slip_rate > phase.friction.upper + rounding:
        return UPPER
    return NO_GUARD


@kernel("the fixed steps")
def march_fixed(
    system: Any,
    phase: Phase,
    h: float,
    stopping_time: float,
    start: StepState,
    y: Array,
    limits: Limits,
    s: Scratch,
    K: Array,
) -> Returned:
    """Advance y in place by steps of h until the contact state changes, to the stop, or to the limit of steps."""
    system, phase, s = by_reference(system), by_reference(phase), by_reference(s)
    origin, done, sample, count = start.origin, start.done, start.sample, 0
    t, peak, depth, reason, guard, steps = start.t, 0.0, 0.0, AT_STOP, NO_GUARD, 0
    status, c = derivative(system, phase, t, y, s.work, K[0])
    while status == 0:
        if t >= limits.t_stop:
            origin, done = t, 0  # the last step was cut; the next ones are counted from here
            break
        if count >= s.samples.times.shape[0] or steps >= limits.most_steps:
            reason = LIMIT_REACHED
            break
        following = origin + (done + 1) * h
        if following > limits.t_stop - 1e-9 * h:
            following = limits.t_stop
        status = _step(system, phase, t, y, following - t, s, K)
        if status != 0:
            break
        steps += 1
        done += 1
        t = following
        copy(s.y_new, y)
        if not bounded(y, s):
            reason = FAILED_FINITE
            break
        status, c = derivative(system, phase, t, y, s.work, K[0])
        if status != 0:
            break
        peak, depth = max(peak, c.normal_force), max(depth, -c.gap)
        guard = _fallen(phase, c, stopping_time, s.tolerances.velocity)
        if guard != NO_GUARD:
            reason = AT_GUARD
            break
        sample, count = keep_sample(t, y, sample, count, limits, s.samples)
    reason = reason if status == 0 else -status
    return reason, guard, (t, h, sample, origin, done, start.taken + steps), steps, 0, count, peak, depth


@dataclass(frozen=True)
class FixedStepScheme(Scheme):
    """Classical RK4 with one step for free flight and one for contact.

    Attributes
    ----------
    free_step, contact_step : float
        s.
    literal : bool
        Contact sticks, as the paper writes, where the force that would keep it sticking lies in the friction cone,
        whatever its slip velocity.  Default: the force must be able to stop the slip within the step as well.
    """

    free_step: float
    contact_step: float
    literal: bool = False
    name = "fixed-step"
    order = 4

    @property
    def stick_criterion(self) -> StickCriterion:  # noqa: D102
        return StickCriterion(inf if self.literal else self.contact_step)

    @property
    def shortest_flight(self) -> float:  # noqa: D102
        return self.free_step

    def buffers(  # noqa: D102
        self, ny: int, modes: NormalModes | None, interval: float, end_time: float
    ) -> Array:
        return np.zeros((4, ny))  # derivatives at the stages

    def march(  # noqa: D102
        self, prepared: Prepared, phase: Phase, before: Phase | None, start: StepState, y: Array, limits: Limits
    ) -> Progress:
        h = self.free_step if phase.state == FREE else self.contact_step
        stopping_time = self.stick_criterion.stopping_time
        system, scratch, stages = prepared.system, prepared.scratch, prepared.own
        return progress_of(march_fixed(system, phase, h, stopping_time, start, y, limits, scratch, stages))
