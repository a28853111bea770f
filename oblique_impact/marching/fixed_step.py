"""Fixed-step marching as the paper does it: classical RK4, contact states decided once per step.

Contact begins at the end of the first step with Z_n < 0 and Z_n' < 0; in contact every step asks whether the
slip sticks (:func:`~oblique_impact.contact.forces.can_stick`) and whether the normal force still pushes (paper,
Secs. 5.3 and 6).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import OK, can_stick, slip_velocity
from oblique_impact.contact.several import coupled_instant, instant_at, phase_of, take_yielding
from oblique_impact.contact.state import (
    END,
    FREE,
    GUARDS,
    LOWER,
    NORMAL,
    SLIDING,
    SWITCHED,
    UPPER,
    ContactArrays,
    Instant,
    Phase,
)
from oblique_impact.contact.transitions import StickCriterion
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.system import NormalModes
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.advance import Limits, Position, Step, StepState, keep_sample, refused
from oblique_impact.marching.buffers import NO_GUARD, Scratch
from oblique_impact.marching.equations import derivative
from oblique_impact.marching.scheme import Prepared, Scheme


@jitable
def _fallen(phase: Phase, c: Instant, yielding: float, stopping_time: float, rounding: float) -> int:
    """Guard that fell at the end of a step, or NO_GUARD; a slip velocity within `rounding` (m/s) has no sign.

    For `yielding` (m/s) see `guards_of`.
    """
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
    if phase.stick.compliance != 0.0:
        return _axially_fallen(phase, c, yielding)
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


@jitable
def _axially_fallen(phase: Phase, c: Instant, yielding: float) -> int:
    """Guard that fell of a closed contact with axial flexibility: its slip has turned, or it has left the cone."""
    if phase.state == SLIDING:
        direction = 1.0 if phase.friction.lower >= 0.0 else -1.0
        return SWITCHED if direction * (slip_velocity(phase, c) + yielding) < 0.0 else NO_GUARD
    if abs(c.tangential_force) <= phase.stick.static * c.normal_force:
        return NO_GUARD
    return LOWER if c.tangential_force > 0.0 else UPPER


@jitable
def _fallen_of(
    arrays: ContactArrays | None, phase: Phase, c: Instant, stopping_time: float, rounding: float, s: Scratch
) -> int:
    """Guard that fell, of several contacts the first of them; a switch of contact i has the number 5 n + i."""
    if arrays is None:
        return _fallen(phase, c, 0.0, stopping_time, rounding)
    return _first_fallen(arrays, phase, stopping_time, rounding, s)


@jitable
def _first_fallen(arrays: ContactArrays, phase: Phase, stopping_time: float, rounding: float, s: Scratch) -> int:
    """Return the guard of the first contact of which one fell; keeps the largest force and depth of each."""
    count, largest, first = arrays.rows.shape[0], s.guards.largest, NO_GUARD
    take_yielding(arrays, phase)
    for i in range(count):
        p, at = phase_of(phase, arrays, i), instant_at(arrays, i)
        if p.state != FREE:
            at = coupled_instant(arrays, i)
            largest[0, i] = max(largest[0, i], at.normal_force)
            largest[1, i] = max(largest[1, i], -at.gap)
        guard = _fallen(p, at, arrays.yielding[i], stopping_time, rounding)
        if guard != NO_GUARD and first == NO_GUARD:
            first = GUARDS * count + i if guard == SWITCHED else GUARDS * i + guard
    return first


class FixedStepper(NamedTuple):
    """Steps of RK4; a `Stepper`."""

    system: Any
    phase: Phase
    h: float  # s
    stopping_time: float  # s, see `can_stick`
    limits: Limits
    scratch: Scratch
    K: Array  # (4, ny) derivatives at the stages; the first is there before a step

    def begin(self, start: StepState, y: Array) -> tuple[int, float]:
        """Evaluate the derivative at the start."""
        status, c = derivative(self.system, self.phase, start.t, y, self.scratch.work, self.K[0])
        return status, c.gap

    def length(self, gap: float, h: float) -> float:
        """Length of the phase's steps."""
        return self.h

    def take(self, now: Position, length: float, end: float, y: Array) -> Step:
        """Take a step, whatever happens in it."""
        s, K, at, y_new = self.scratch, self.K, self.scratch.at, self.scratch.y_new
        h = end - now.t  # as the clock counts
        for i in range(3):
            part = h if i == 2 else 0.5 * h
            for m in range(y.shape[0]):
                at[m] = y[m] + part * K[i, m]
            status, _ = derivative(self.system, self.phase, now.t + part, at, s.work, K[i + 1])
            if status != OK:
                return refused(status, 0.0)
        for m in range(y.shape[0]):
            y_new[m] = y[m] + h / 6.0 * (K[0, m] + 2.0 * (K[1, m] + K[2, m]) + K[3, m])
        return Step(OK, True, end, length, NO_GUARD, 0.0, 0.0, 0.0)

    def arrive(self, step: Step, y: Array) -> Step:
        """Decide at the end of a step whether the contact state changes."""
        s, t = self.scratch, step.end
        status, c = derivative(self.system, self.phase, t, y, s.work, self.K[0])
        guard, phase = NO_GUARD, self.phase
        if status == OK:
            guard = _fallen_of(phase.arrays, phase, c, self.stopping_time, s.tolerances.velocity, s)
        if status == OK and guard == NO_GUARD:
            keep_sample(t, y, self.limits, s.samples)
        return Step(status, True, t, step.proposed, guard, c.gap, c.normal_force, -c.gap)


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

    def stepper(  # noqa: D102
        self, prepared: Prepared, phase: Phase, before: Phase | None, limits: Limits
    ) -> FixedStepper:
        h = self.free_step if phase.state == FREE else self.contact_step
        stopping_time = self.stick_criterion.stopping_time
        return FixedStepper(prepared.system, phase, h, stopping_time, limits, prepared.scratch, prepared.own)
