"""The contract for user-defined explicit integrators: they take one step, transitions and samples are found here.

Steps are `solver.free_step` long in flight and `solver.contact_step` in contact.  A guard that is found fallen
at the end of a step is located by repeating the step with other lengths, so an event is as accurate as a step.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import guards_of
from oblique_impact.contact.state import FREE, GUARDS, NORMAL, Guards, Instant, Phase
from oblique_impact.kernels.workspace import Array, own_numbers
from oblique_impact.marching.equations import take_derivative
from oblique_impact.marching.location import cubic_dip, find_fall, find_trough
from oblique_impact.marching.scheme import (
    AT_GUARD,
    AT_STOP,
    FAILED_FINITE,
    LIMIT_REACHED,
    NO_GUARD,
    Limits,
    Prepared,
    Progress,
    Scheme,
    Scratch,
    StepState,
    bounded,
    keep_sample,
    raised,
)

if TYPE_CHECKING:
    from oblique_impact.scenario.sections import SolverSection

Rates = Callable[[float, Array], Array]

_STEPS_PER_CALL = 200
_LOCATED = 1e-14  # relative length of a step


class _NoSolutionError(Exception):
    """The contact problem has no solution at a stage."""

    def __init__(self, status: int) -> None:
        self.status = status


class _End(NamedTuple):
    """State, contact and guards at the end of a step."""

    t: float
    y: Array
    contact: Instant
    guards: Guards


class ExplicitScheme(Scheme):
    """An explicit integrator with steps of given length; a subclass has `name`, `order` and `step`.

    Parameters
    ----------
    solver : SolverSection
        The scenario's section `solver`: steps of flight and contact (s).

    Examples
    --------
    >>> class Heun(ExplicitScheme):
    ...     name, order = "heun", 2
    ...
    ...     def step(self, rates, t, y, h):
    ...         k1 = rates(t, y)
    ...         return y + 0.5 * h * (k1 + rates(t + h, y + h * k1))
    """

    def __init__(self, solver: SolverSection) -> None:
        self.free_step, self.contact_step = solver.free_step, solver.contact_step

    @abstractmethod
    def step(self, rates: Rates, t: float, y: Array, h: float) -> Array:
        """Return the state at t + h from `y` (ny,) at t; ``rates(t, y)`` is its time derivative, a new array.

        Arrays may be views, of any real type; one of another shape, or of complex numbers, is an InputError.
        """

    def steps_per_call(self, size: int) -> int:  # noqa: D102
        return _STEPS_PER_CALL

    def march(  # noqa: D102
        self, prepared: Prepared, phase: Phase, before: Phase | None, start: StepState, y: Array, limits: Limits
    ) -> Progress:
        return _March(self, prepared.system, phase, prepared.scratch).advance(start, y, limits)


class _March:
    """The steps of one phase."""

    def __init__(self, scheme: ExplicitScheme, system: Any, phase: Phase, scratch: Scratch) -> None:
        self.scheme, self.system, self.phase, self.scratch = scheme, system, phase, scratch
        self.h = scheme.free_step if phase.state == FREE else scheme.contact_step
        self.name, self.shape = type(scheme).__name__, scratch.y_new.shape

    def advance(self, begin: StepState, y: Array, limits: Limits) -> Progress:
        """Advance y in place."""
        s, origin, done, sample = self.scratch, begin.origin, begin.done, begin.sample
        t, steps, count, peak, depth, reason, guard = begin.t, 0, 0, 0.0, 0.0, AT_STOP, NO_GUARD
        try:
            start = self._measure(t, y.copy())
            while t < limits.t_stop:
                if count >= s.samples.times.size or steps >= limits.most_steps:
                    reason = LIMIT_REACHED
                    break
                following = origin + (done + 1) * self.h  # so that no rounding adds up
                following = limits.t_stop if following > limits.t_stop - 1e-9 * self.h else following
                end = self.take(start, following - t)
                if not bounded(end.y, s):
                    reason = FAILED_FINITE
                    break
                guard, end = self._first_fall(start, end)
                t, y[:] = end.t, end.y
                steps, done = steps + 1, done + 1
                peak, depth = max(peak, end.contact.normal_force), max(depth, -end.contact.gap)
                if guard != NO_GUARD:
                    reason = AT_GUARD
                    break
                s.guards.armed[np.array(end.guards) > s.guards.thresholds] = True
                sample, count = keep_sample(t, y, sample, count, limits, s.samples)
                start = end
            else:
                origin, done = t, 0  # the last step was cut; the next ones are counted from here
        except _NoSolutionError as none:
            reason = -none.status
        reached = StepState(t, self.h, sample, origin, done, begin.taken + steps)
        return Progress(reason, guard, reached, steps, 0, count, peak, depth)

    def _rates(self, t: float, y: Array) -> Array:
        return self._derivative(float(t), own_numbers(y, self.shape, f"{self.name}: y of rates(t, y)"))[0]

    def _derivative(self, t: float, y: Array) -> tuple[Array, Instant]:
        dy = np.empty_like(y)
        status, contact = take_derivative(self.system, self.phase, t, y, self.scratch.work, dy)
        if status != 0:
            raise _NoSolutionError(status)
        return dy, contact

    def take(self, start: _End, h: float) -> _End:
        end = self.scheme.step(self._rates, start.t, start.y.copy(), h)
        return self._measure(start.t + h, own_numbers(end, self.shape, f"{self.name}: what step returns"))

    def _measure(self, t: float, y: Array) -> _End:
        contact = self._derivative(t, y)[1]
        return _End(t, y, contact, guards_of(self.phase, contact))

    def _first_fall(self, start: _End, end: _End) -> tuple[int, _End]:
        """Guard that falls first in a step, or NO_GUARD, and the step up to there."""
        first, trial = NO_GUARD, _Shorter(self, start, end.t - start.t)
        part = self._dip(trial, end)
        end = end if part == 1.0 else trial.up_to(part)
        for guard in range(GUARDS):
            # each guard found fallen shortens the step
            before, after = (raised(at.guards[guard], guard, self.scratch.guards) for at in (start, end))
            if after <= 0.0:
                part = (end.t - start.t) / trial.h
                first = guard
                end = trial.up_to(find_fall(trial, guard, 0.0, before, part, after, _LOCATED, 0.0))
        return first, end

    def _dip(self, trial: _Shorter, end: _End) -> float:
        """Fraction of a step that ends in the air where the slope has been reached before; 1 if nowhere."""
        start, h = trial.start, trial.h
        if self.phase.state != FREE or not self.scratch.guards.armed[NORMAL] or end.guards.normal <= 0.0:
            return 1.0
        rates = self.phase.surface.side * start.contact.gap_rate, self.phase.surface.side * end.contact.gap_rate
        if rates[0] >= 0.0 or rates[1] <= 0.0:
            return 1.0
        _, place = cubic_dip(start.guards.normal, end.guards.normal, h * rates[0], h * rates[1])
        part, _ = find_trough(trial, NORMAL, 0.0, 1.0, place)
        return part if part > 0.0 else 1.0


class _Shorter(NamedTuple):
    """A step of length h (s) of which shorter ones are taken; a `Trial`."""

    march: _March
    start: _End
    h: float

    def up_to(self, x: float) -> _End:
        return self.march.take(self.start, x * self.h)

    def guard_at(self, x: float, guard: int) -> float:
        return raised(self.up_to(x).guards[guard], guard, self.march.scratch.guards)
