"""Fixed-step marching as the paper does it: classical RK4, states judged once per step.

Contact begins at the end of the first step with Z_n < 0 and Z_n' < 0; in contact every step asks whether the
slip sticks (:func:`~oblique_impact.contact.forces.can_stick`) and whether the normal force still pushes (paper,
Secs. 5.3 and 6).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any

from oblique_impact.contact.forces import can_stick
from oblique_impact.contact.state import END, FREE, JUDGED, LOWER, NORMAL, SLIDING, UPPER, Instant, Phase
from oblique_impact.contact.transitions import Judgement
from oblique_impact.kernels.jit import jitable, kernel
from oblique_impact.kernels.reference import by_reference
from oblique_impact.kernels.workspace import Array, copy
from oblique_impact.marching.equations import derivative
from oblique_impact.marching.scheme import (
    AT_GUARD,
    AT_STOP,
    FAILED_FINITE,
    LEG_FULL,
    NO_GUARD,
    Front,
    Leg,
    Progress,
    Returned,
    Scheme,
    Scratch,
    bounded,
    keep_sample,
    progress_of,
)


@jitable
def _step(system: Any, phase: Phase, t: float, y: Array, h: float, s: Scratch) -> int:
    """One step of RK4 from (t, y) into s.y_new; s.K[0] holds the derivative at the start."""
    K, at = s.K, s.at
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
def _judge(phase: Phase, c: Instant, stopping_time: float, rounding: float) -> int:
    """Guard that fell at the end of a step, or NO_GUARD; a slip velocity within `rounding` (m/s) has no sign."""
    if phase.state == FREE:
        return NORMAL if phase.watched and phase.side * c.gap < 0.0 and phase.side * c.gap_rate < 0.0 else NO_GUARD
    if c.normal_force <= 0.0:
        return NORMAL
    if c.slip < phase.first or c.slip > phase.last:
        return END
    sticks = phase.static >= 0.0 and can_stick(phase, c, stopping_time)
    if phase.state != SLIDING:
        return NO_GUARD if sticks else JUDGED
    if sticks:
        return JUDGED
    if c.slip_rate < phase.lower - rounding:
        return LOWER
    if c.slip_rate > phase.upper + rounding:
        return UPPER
    return NO_GUARD


@kernel("the fixed steps")
def march_fixed(
    system: Any, phase: Phase, h: float, stopping_time: float, front: Front, y: Array, leg: Leg, s: Scratch
) -> Returned:
    """Advance y in place by steps of h until a step's judgement differs from the phase, or the leg is full."""
    system, phase, s = by_reference(system), by_reference(phase), by_reference(s)
    origin, done, sample, count = front.origin, front.done, front.sample, 0
    t, peak, depth, reason, guard, steps = front.t, 0.0, 0.0, AT_STOP, NO_GUARD, 0
    status, c = derivative(system, phase, t, y, s.work, s.K[0])
    while status == 0:
        if t >= leg.t_stop:
            origin, done = t, 0  # the last step was cut; the next ones are counted from here
            break
        if count >= s.times.shape[0] or steps >= leg.most_steps:
            reason = LEG_FULL
            break
        following = origin + (done + 1) * h
        if following > leg.t_stop - 1e-9 * h:
            following = leg.t_stop
        status = _step(system, phase, t, y, following - t, s)
        if status != 0:
            break
        steps += 1
        done += 1
        t = following
        copy(s.y_new, y)
        if not bounded(y, s):
            reason = FAILED_FINITE
            break
        status, c = derivative(system, phase, t, y, s.work, s.K[0])
        if status != 0:
            break
        peak, depth = max(peak, c.normal_force), max(depth, -c.gap)
        guard = _judge(phase, c, stopping_time, s.tolerances.velocity)
        if guard != NO_GUARD:
            reason = AT_GUARD
            break
        sample, count = keep_sample(t, y, sample, count, leg, s)
    reason = reason if status == 0 else -status
    return reason, guard, (t, h, sample, origin, done, front.taken + steps), steps, 0, count, peak, depth


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
    def judgement(self) -> Judgement:  # noqa: D102
        return Judgement(inf if self.literal else self.contact_step)

    @property
    def shortest_flight(self) -> float:  # noqa: D102
        return self.free_step

    def march(  # noqa: D102
        self, system: Any, phase: Phase, before: Phase | None, front: Front, y: Array, leg: Leg, scratch: Scratch
    ) -> Progress:
        h = self.free_step if phase.state == FREE else self.contact_step
        return progress_of(march_fixed(system, phase, h, self.judgement.stopping_time, front, y, leg, scratch))
