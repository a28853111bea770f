"""The contract for explicit integrators of one's own: one step is theirs, transitions and samples are found here.

Steps are `solver.free_step` long in flight and `solver.contact_step` in contact.  A guard that is found fallen
at the end of a step is located by repeating the step with other lengths, so an event is as accurate as a step.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import brentq

from oblique_impact.contact.forces import FREE, GUARD_NORMAL, Phase, measure_guards
from oblique_impact.kernels.system import FIRST_GUARD, GAP, GAP_RATE, GUARDS, LAMBDA_N, Array
from oblique_impact.marching.equations import derivative
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

if TYPE_CHECKING:
    from oblique_impact.scenario.scenario import SolverSection

Rates = Callable[[float, Array], Array]

_UNBOUNDED = 1e12
_STEPS_PER_LEG = 200
_LOCATED = 1e-14  # relative length of a step


class _NoSolutionError(Exception):
    """The contact problem has no solution at a stage."""

    def __init__(self, status: int) -> None:
        self.status = status


class _End:
    """What a step left: the state, the guards and the gap rate there."""

    def __init__(self, t: float, y: Array, guards: Array, k: Array) -> None:
        self.t, self.y, self.guards = t, y, guards
        self.gap_rate, self.force, self.depth = float(k[GAP_RATE]), float(k[LAMBDA_N]), -float(k[GAP])


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

    stepwise = False

    def __init__(self, solver: SolverSection) -> None:
        self.free_step, self.contact_step = solver.free_step, solver.contact_step

    @abstractmethod
    def step(self, rates: Rates, t: float, y: Array, h: float) -> Array:
        """Return the state at t + h from `y` at t; ``rates(t, y)`` is its time derivative, a new array."""

    def begin(self, phase: Phase, scratch: Scratch, tolerances: Tolerances, initial_guards: Array) -> None:
        """Arm the guards that start clearly positive; the others must rise first."""
        arm(phase, scratch, tolerances, initial_guards)

    def march(self, system: Any, phase: Phase, course: Course, t_stop: float, scratch: Scratch) -> Progress:
        """Advance to the next event, or for some thousand steps."""
        return _Leg(self, system, phase, course, t_stop, scratch).march()


class _Leg:
    """One leg of steps in one phase."""

    def __init__(
        self, scheme: ExplicitScheme, system: Any, phase: Phase, course: Course, t_stop: float, scratch: Scratch
    ) -> None:
        self.scheme, self.system, self.phase, self.course = scheme, system, phase, course
        self.t_stop, self.scratch = t_stop, scratch
        self.h = scheme.free_step if phase.state == FREE else scheme.contact_step
        self.steps = self.samples = 0
        self.peak = self.depth = 0.0
        self._derivative = _derivative_of(system)

    def march(self) -> Progress:
        """Advance the course in place."""
        course = self.course
        try:
            start = self._measure(course.t, course.y)
            while course.t < self.t_stop:
                if self.samples >= self.scratch.times.size or self.steps >= _STEPS_PER_LEG:
                    return self._progress(BUFFER_FULL)
                end = self._take(course.t, course.y, self._following() - course.t)
                if not np.all(np.abs(end.y[: 2 * self.scratch.work.vectors.shape[1]]) < _UNBOUNDED):
                    return self._progress(FAILED_FINITE)
                guard, located = self._first_fall(start, end)
                self._accept(located)
                if guard >= 0:
                    return self._progress(AT_GUARD, guard)
                course.phase_steps += 1
                self.scratch.armed[end.guards > self.scratch.thresholds] = True
                self._keep_sample()
                start = end
        except _NoSolutionError as none:
            return self._progress(-none.status)
        course.phase_start, course.phase_steps = course.t, 0  # the last step was cut; count from here
        return self._progress(AT_STOP)

    def _following(self) -> float:
        """End of the next step: times are start + k h, so that nothing adds up."""
        following = self.course.phase_start + (self.course.phase_steps + 1) * self.h
        return self.t_stop if following > self.t_stop - 1e-9 * self.h else following

    def _rates(self, t: float, y: Array) -> Array:
        dy = np.empty_like(y)
        status = self._derivative(self.system, self.phase, t, y, self.scratch.work, dy)
        if status != 0:
            raise _NoSolutionError(status)
        return dy

    def _take(self, t: float, y: Array, h: float) -> _End:
        return self._measure(t + h, np.asarray(self.scheme.step(self._rates, t, y, h), dtype=float))

    def _measure(self, t: float, y: Array) -> _End:
        self._rates(t, y)
        k = self.scratch.work.scalars
        measure_guards(self.phase, k)
        guards = k[FIRST_GUARD : FIRST_GUARD + GUARDS].copy()
        return _End(t, y, guards, k)

    def _raised(self, end: _End, guard: int) -> float:
        """Return a guard, raised by its threshold until it is armed."""
        return float(end.guards[guard] + (0.0 if self.scratch.armed[guard] else self.scratch.thresholds[guard]))

    def _first_fall(self, start: _End, end: _End) -> tuple[int, _End]:
        """Guard that falls first in a step, or -1, and the step up to there."""
        first = -1
        dip = self._dip(start, end)
        if dip is not None:
            end = dip
        for guard in range(GUARDS):
            # each guard found fallen shortens the step; one that falls earlier still is fallen there too
            if self._raised(end, guard) <= 0.0:
                first, end = guard, self._locate(start, end, guard)
        return first, end

    def _dip(self, start: _End, end: _End) -> _End | None:
        """Look at the least gap inside a step that begins closing and ends opening; None if it stays open."""
        if self.phase.state != FREE or not self.scratch.armed[GUARD_NORMAL] or end.guards[GUARD_NORMAL] <= 0.0:
            return None
        if start.gap_rate >= 0.0 or end.gap_rate <= 0.0:
            return None
        h = end.t - start.t
        length = h * brentq(lambda x: self._take(start.t, start.y, x * h).gap_rate, 1e-9, 1.0)
        least = self._take(start.t, start.y, length)
        return least if least.guards[GUARD_NORMAL] <= 0.0 else None

    def _locate(self, start: _End, end: _End, guard: int) -> _End:
        """Return the step that ends where a guard, fallen at `end`, falls."""
        h = end.t - start.t

        def value(part: float) -> float:
            return self._raised(self._take(start.t, start.y, part * h), guard)

        low = 1e-3
        while low > 1e-12 and value(low) <= 0.0:  # a phase that starts at zero rises first
            low *= 1e-3
        if value(low) <= 0.0:
            return self._take(start.t, start.y, low * h)
        part = brentq(value, low, 1.0, xtol=_LOCATED, rtol=8.9e-16)
        return self._take(start.t, start.y, part * h)

    def _accept(self, end: _End) -> None:
        self.course.t = end.t
        self.course.y[:] = end.y
        self.steps += 1
        self.peak, self.depth = max(self.peak, end.force), max(self.depth, end.depth)

    def _keep_sample(self) -> None:
        course = self.course
        if course.t >= course.next_sample * course.output_interval * (1.0 - 1e-12) and course.t < self.t_stop:
            self.scratch.times[self.samples] = course.t
            self.scratch.states[self.samples] = course.y
            self.samples += 1
            course.next_sample = int(course.t / course.output_interval * (1.0 + 1e-12)) + 1

    def _progress(self, reason: int, guard: int = -1) -> Progress:
        return Progress(reason, guard, self.course.t, self.h, self.steps, 0, self.samples, self.peak, self.depth)


def _derivative_of(system: Any) -> Callable[..., int]:
    """Return the compiled derivative for the beams, which are packed tuples, the plain one for other systems."""
    if not isinstance(system, tuple):
        return derivative
    from oblique_impact.marching import kernels

    compiled: Callable[..., int] = kernels.derivative
    return compiled
