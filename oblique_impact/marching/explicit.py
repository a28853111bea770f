"""The contract for user-defined explicit integrators: they take one step, transitions and samples are found here.

Steps are `solver.free_step` long in flight and `solver.contact_step` in contact.  A guard that is found fallen
at the end of a step is located by repeating the step with other lengths, so an event is as accurate as a step.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import OK, guards_of
from oblique_impact.contact.state import FREE, GUARDS, NORMAL, Guards, Instant, Phase
from oblique_impact.kernels.workspace import Array, own_numbers
from oblique_impact.marching.advance import Limits, Position, Step, Stepper, StepState, keep_sample, refused
from oblique_impact.marching.buffers import NO_GUARD, Scratch, raised
from oblique_impact.marching.equations import take_derivative
from oblique_impact.marching.location import cubic_dip, find_fall, find_trough
from oblique_impact.marching.scheme import Prepared, Scheme

if TYPE_CHECKING:
    from oblique_impact.scenario.sections import SolverSection

Rates = Callable[[float, Array], Array]

_STEPS_PER_CALL = 200  # some hundredths of a second in plain Python, so that interrupts are prompt
_LOCATED = 1e-14  # of a step: how closely an event is located, some units of rounding


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

    def stepper(  # noqa: D102
        self, prepared: Prepared, phase: Phase, before: Phase | None, limits: Limits
    ) -> Stepper:
        return _ExplicitStepper(self, prepared.system, phase, prepared.scratch, limits)


class _ExplicitStepper:
    """Steps of one phase; a `Stepper`."""

    def __init__(
        self, scheme: ExplicitScheme, system: Any, phase: Phase, scratch: Scratch, limits: Limits
    ) -> None:
        self.scheme, self.system, self.phase, self.scratch, self.limits = scheme, system, phase, scratch, limits
        self.h = scheme.free_step if phase.state == FREE else scheme.contact_step
        self.name, self.shape = type(scheme).__name__, scratch.y_new.shape
        self.start: _End
        self.end: _End

    def begin(self, start: StepState, y: Array) -> tuple[int, float]:
        try:
            self.start = self._measure(start.t, y.copy())
        except _NoSolutionError as none:
            return none.status, 0.0
        return OK, self.start.contact.gap

    def length(self, gap: float, h: float) -> float:
        return self.h

    def take(self, now: Position, length: float, end: float, y: Array) -> Step:
        try:
            guard, self.end = self._first_fall(self.part(length))
        except _NoSolutionError as none:
            return refused(none.status, 0.0)
        self.scratch.y_new[:] = self.end.y
        c, landed = self.end.contact, end if guard == NO_GUARD else self.end.t
        return Step(OK, True, landed, length, guard, c.gap, c.normal_force, -c.gap)

    def arrive(self, step: Step, y: Array) -> Step:
        s, self.start = self.scratch, self.end._replace(t=step.end)
        if step.guard == NO_GUARD:
            s.guards.armed[np.array(self.end.guards) > s.guards.thresholds] = True
            keep_sample(step.end, y, self.limits, s.samples)
        return step

    def part(self, h: float) -> _End:
        """Return the end of a step of another length (s)."""
        start = self.start
        end = self.scheme.step(self._rates, start.t, start.y.copy(), h)
        return self._measure(start.t + h, own_numbers(end, self.shape, f"{self.name}: what step returns"))

    def _rates(self, t: float, y: Array) -> Array:
        return self._derivative(float(t), own_numbers(y, self.shape, f"{self.name}: y of rates(t, y)"))[0]

    def _derivative(self, t: float, y: Array) -> tuple[Array, Instant]:
        dy = np.empty_like(y)
        status, contact = take_derivative(self.system, self.phase, t, y, self.scratch.work, dy)
        if status != OK:
            raise _NoSolutionError(status)
        return dy, contact

    def _measure(self, t: float, y: Array) -> _End:
        contact = self._derivative(t, y)[1]
        return _End(t, y, contact, guards_of(self.phase, contact))

    def _first_fall(self, end: _End) -> tuple[int, _End]:
        """Guard that falls first in a step, or NO_GUARD, and the step up to there."""
        first, start = NO_GUARD, self.start
        trial = _Shorter(self, end.t - start.t)
        part = self._dip(trial, end)
        end = end if part == 1.0 else self.part(part * trial.h)
        for guard in range(GUARDS):
            # each guard found fallen shortens the step
            before, after = (raised(at.guards[guard], guard, self.scratch.guards) for at in (start, end))
            if after <= 0.0:
                part = (end.t - start.t) / trial.h
                first = guard
                end = self.part(trial.h * find_fall(trial, guard, 0.0, before, part, after, _LOCATED, 0.0))
        return first, end

    def _dip(self, trial: _Shorter, end: _End) -> float:
        """Fraction of a step that ends in the air where the slope has been reached before; 1 if nowhere."""
        start, h = self.start, trial.h
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

    stepper: _ExplicitStepper
    h: float

    def guard_at(self, x: float, guard: int) -> float:
        return raised(self.stepper.part(x * self.h).guards[guard], guard, self.stepper.scratch.guards)
