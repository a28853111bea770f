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

from oblique_impact.contact.forces import OK, can_stick, couple, lambda_n, nearest, slip_velocity, take_stretching
from oblique_impact.contact.state import (
    END,
    FREE,
    GUARDS,
    LOWER,
    NORMAL,
    SLIDING,
    SWITCHED,
    UPPER,
    Candidate,
    Contacts,
)
from oblique_impact.contact.transitions import StickCriterion
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.laws import Law
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.advance import Limits, Position, Step, StepState, keep_sample, refused
from oblique_impact.marching.buffers import NO_GUARD, Scratch
from oblique_impact.marching.equations import derivative
from oblique_impact.marching.scheme import Prepared, Scheme, Task


@jitable
def _fallen(law: Law | None, c: Candidate, stopping_time: float, rounding: float) -> int:
    """Guard that fell at the end of a step, or NO_GUARD; a slip velocity within `rounding` (m/s) has no sign."""
    if c.state == FREE:
        return NORMAL if c.enabled and c.side * c.depth > 0.0 and c.side * c.depth_rate > 0.0 else NO_GUARD
    if lambda_n(c) <= 0.0:
        return NORMAL
    if c.slip < c.first or c.slip > c.last:
        return END
    if c.axial != 0.0:
        return _axially_fallen(c)
    sticks = c.static >= 0.0 and can_stick(law, c, stopping_time)
    if c.state != SLIDING:
        return NO_GUARD if sticks else SWITCHED
    if sticks:
        return SWITCHED
    if c.slip_rate < c.lower - rounding:
        return LOWER
    if c.slip_rate > c.upper + rounding:
        return UPPER
    return NO_GUARD


@jitable
def _axially_fallen(c: Candidate) -> int:
    """Guard that fell of a closed contact with axial flexibility: its slip has turned, or it has left the cone."""
    if c.state == SLIDING:
        direction = 1.0 if c.lower >= 0.0 else -1.0
        return SWITCHED if direction * (slip_velocity(c) + c.stretching) < 0.0 else NO_GUARD
    if abs(c.tangential_force) <= c.static * lambda_n(c):
        return NO_GUARD
    return LOWER if c.tangential_force > 0.0 else UPPER


@jitable
def _first_fallen(contacts: Contacts, stopping_time: float, rounding: float) -> int:
    """Return the guard of the first contact of which one fell; keeps the largest force and depth of each.

    A switch of contact i has the number 5 n + i.
    """
    n, first = len(contacts.each), NO_GUARD
    take_stretching(contacts.matrix, contacts)
    for i in range(n):
        c = contacts.each[i]
        if c.state != FREE:
            couple(contacts, i)
            c.peak_force, c.peak_depth = max(c.peak_force, lambda_n(c)), max(c.peak_depth, -c.gap)
        guard = _fallen(contacts.law, c, stopping_time, rounding)
        if guard != NO_GUARD and first == NO_GUARD:
            first = GUARDS * n + i if guard == SWITCHED else GUARDS * i + guard
    return first


class FixedStepper(NamedTuple):
    """Steps of RK4; a `Stepper`."""

    system: Any
    contacts: Contacts
    h: float  # s
    stopping_time: float  # s, see `can_stick`
    limits: Limits
    scratch: Scratch
    K: Array  # (4, ny) derivatives at the stages; the first is there before a step

    def begin(self, start: StepState, y: Array) -> tuple[int, float]:
        """Evaluate the derivative at the start."""
        status = derivative(self.system, self.contacts, start.t, y, self.scratch.work, self.K[0])
        return status, nearest(self.contacts)[0]

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
            status = derivative(self.system, self.contacts, now.t + part, at, s.work, K[i + 1])
            if status != OK:
                return refused(status, 0.0)
        for m in range(y.shape[0]):
            y_new[m] = y[m] + h / 6.0 * (K[0, m] + 2.0 * (K[1, m] + K[2, m]) + K[3, m])
        return Step(OK, True, end, length, NO_GUARD, 0.0)

    def arrive(self, step: Step, y: Array) -> Step:
        """Decide at the end of a step whether the contact state changes."""
        s, t, guard = self.scratch, step.end, NO_GUARD
        status = derivative(self.system, self.contacts, t, y, s.work, self.K[0])
        if status == OK:
            guard = _first_fallen(self.contacts, self.stopping_time, s.tolerances.velocity)
        if status == OK and guard == NO_GUARD:
            keep_sample(t, y, self.limits, s.samples)
        return Step(status, True, t, step.proposed, guard, nearest(self.contacts)[0])


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

    def buffers(self, task: Task) -> Array:  # noqa: D102
        return np.zeros((4, task.entries))  # derivatives at the stages

    def stepper(self, prepared: Prepared, limits: Limits) -> FixedStepper:  # noqa: D102
        contacts = prepared.contacts
        free = all(contacts.of(i).state == FREE for i in range(len(contacts.each)))
        h, stopping_time = self.free_step if free else self.contact_step, self.stick_criterion.stopping_time
        return FixedStepper(prepared.system, contacts, h, stopping_time, limits, prepared.scratch, prepared.own)
