"""Event-located marching: adaptive order 8, every change of a guard's sign found inside the step.

The dense output of each step is searched for the first fall of a guard (`search`).  The time found is
sharpened by repeating the step up to it, so an event is as accurate as a step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import OK, is_free, nearest
from oblique_impact.contact.state import Contacts
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array, copy
from oblique_impact.marching.advance import Limits, Position, Step, StepState, refused
from oblique_impact.marching.buffers import (
    AT,
    NEXT,
    NO_GUARD,
    THRESHOLD,
    OutputSamples,
    Scratch,
    arm_flight,
    new_sample,
    raised,
)
from oblique_impact.marching.dop853 import (
    DENSE_STAGES,
    ORDER,
    STAGES,
    Stages,
    error_norm,
    interpolant,
    interpolate,
    take_stages,
)
from oblique_impact.marching.equations import derivative
from oblique_impact.marching.exponential import (
    Exponential,
    begin_flight,
    begins_at_samples,
    follow_step,
    is_worthwhile,
    new_exponential,
    take_exponential_step,
)
from oblique_impact.marching.scheme import Prepared, Scheme, Task
from oblique_impact.marching.search import UNDEFINED, DenseStep, first_fall, take_guards

# as in the codes of Hairer, Norsett and Wanner (Sec. II.4)
_SAFETY, _SHRINK, _GROW = 0.9, 0.2, 6.0
_EXPONENT = -1.0 / 8.0
#: of the tolerance: a second of motion takes thousands of steps, whose errors add up
_SHARE_OF_A_STEP = 0.02
#: corrections of the end of a step on an event; four converge from the dense output, which is of order 7
_CORRECTIONS = 4


class EventBuffers(NamedTuple):
    """Buffers of the event scheme."""

    stages: Stages
    exponential: Exponential | None  # tables for long steps of free flights, where these are worth their time


@jitable
def _step_factor(error: float) -> float:
    """Ratio of the next step to the last one."""
    if error == 0.0:
        return _GROW
    if not error < 1e12:
        return _SHRINK
    return float(min(_GROW, max(_SHRINK, _SAFETY * error**_EXPONENT)))


@jitable
def _keep_samples(
    t: float, end: float, h: float, y: Array, F: Array, interval: float, samples: OutputSamples
) -> None:
    """Keep the output samples before `end` from the dense output of a step of length h from t."""
    while samples.counts[NEXT] * interval < end * (1.0 - 1e-14):
        time = samples.counts[NEXT] * interval
        interpolate(F, y, (time - t) / h, samples.states[new_sample(time, samples)])


@jitable
def _land(
    system: Any,
    contacts: Contacts,
    t: float,
    y: Array,
    length: float,
    rate: float,
    guard: int,
    s: Scratch,
    K: Array,
) -> tuple[int, bool, float]:
    """Repeat the step so that it ends on the event; status, whether it does, and length (s); state in s.y_new.

    The secant method on the length, started with the guard's slope `rate`; the dense output that bracketed
    the event is only of order 7.  It has located the event where guards have no rates, and where it only touches
    zero, within the tolerance of the guard; elsewhere a step that is too long is to be a shorter one.
    """
    last_value, last_length, close = 0.0, 0.0, False
    for trial in range(_CORRECTIONS + 1):
        status, _ = take_stages(system, contacts, t, y, length, 1, STAGES, K, s.work, s.y_new)
        if status != 0:
            return status, False, length
        if not take_guards(system, contacts, t + length, s.y_new, K[STAGES], s, K[DENSE_STAGES - 2]):
            return 0, True, length
        value = raised(s.guards[AT, guard], guard, s.guards)
        if trial > 0 and length != last_length:
            rate = (value - last_value) / (length - last_length)
        correction = -value / rate if rate < 0.0 else np.inf
        close = abs(value) <= s.guards[THRESHOLD, guard] or abs(correction) <= 1e-15 * t
        if abs(correction) <= 1e-15 * t or not abs(correction) < 0.1 * length or trial == _CORRECTIONS:
            break
        last_value, last_length = value, length
        length += correction
    return 0, close, length


class EventStepper(NamedTuple):
    """Steps of the event scheme; a `Stepper`."""

    system: Any
    contacts: Contacts
    tolerance: float  # of a step
    limits: Limits
    scratch: Scratch
    stages: Stages
    tables: Exponential | None

    def begin(self, start: StepState, y: Array) -> tuple[int, float]:
        """Evaluate the derivative at the start of a phase and behind a stop, where the root moves in another way.

        Else it is there, to the last bit as in one call.
        """
        K = self.stages.K
        status = derivative(self.system, self.contacts, start.t, y, self.scratch.work, K[1])
        gap, speed = nearest(self.contacts)
        if start.done == 0:
            copy(K[1], K[0])
            begin_flight(self.tables, speed)
        return status, gap

    def length(self, gap: float, h: float) -> float:
        """Length that the error of the last step asks for; its samples fit into half of their buffer."""
        room = self.scratch.samples.times.shape[0]
        return float(min(h, 0.45 * room * self.limits.interval))

    def take(self, now: Position, length: float, end: float, y: Array) -> Step:
        """Try a step, an exponential one where that is longer, and end it at the first guard that falls."""
        step = _exponential_step(self, self.tables, now, y)
        if step.accepted:
            return step
        system, contacts, s, stages = self.system, self.contacts, self.scratch, self.stages
        interval, free = self.limits.interval, is_free(contacts)
        t, sample = now.t, s.samples.counts[NEXT] * interval
        cut = end >= self.limits.t_stop
        if begins_at_samples(self.tables, free) and t < sample * (1.0 - 1e-14) and sample < t + length:
            length, end, cut = sample - t, sample, True
        status, speed = take_stages(system, contacts, t, y, length, 1, STAGES, stages.K, s.work, s.y_new)
        error = error_norm(length, y, stages, s, self.tolerance) if status == 0 else np.inf
        if not error <= 1.0:
            return refused(status, min(_step_factor(error), 1.0) * length)
        (gap, _), guard, due, located = nearest(contacts), NO_GUARD, sample < t + length, True
        # no candidate can have reached its obstacle within the step
        clear = free and min(now.gap, gap) > 2.0 * length * speed
        if due or not clear:
            status, _ = take_stages(
                system, contacts, t, y, length, STAGES + 1, DENSE_STAGES - 1, stages.K, s.work, s.at
            )
            interpolant(y, s.y_new, length, stages)
        if clear:
            arm_flight(s.guards)
        elif status == 0:
            guard, place, rate = first_fall(DenseStep(system, contacts, t, length, y, s, stages))
            if guard >= 0:
                status, located, landed = _land(system, contacts, t, y, place * length, rate, guard, s, stages.K)
                end = t + landed
        if status != 0 or guard == UNDEFINED or not located:
            # a contact problem without a solution further on in this step, or an event that is not found: approach
            return refused(status, _SHRINK * length)
        if due:
            _keep_samples(t, end, length, y, stages.F, interval, s.samples)
        copy(stages.K[STAGES], stages.K[0])
        follow_step(self.tables, speed, cut)
        return Step(OK, True, end, _step_factor(error) * length, guard, gap)

    def arrive(self, step: Step, y: Array) -> Step:
        """Return the step: its guard is found and its samples are kept."""
        return step


@jitable
def _exponential_step(stepper: EventStepper, tables: Exponential | None, now: Position, y: Array) -> Step:
    """Take an exponential step of a flight, if there are tables; else the compiler leaves it out."""
    return refused(OK, 0.0) if tables is None else take_exponential_step(stepper, tables, now, y)


@dataclass(frozen=True)
class EventScheme(Scheme):
    """Adaptive order 8 with located transitions.

    Attributes
    ----------
    tolerance : float
        Accuracy wanted of q and q', absolute and relative; the error of a single step is held to a
        fiftieth of it, because a second of motion takes thousands of steps.
    """

    tolerance: float = 1e-10
    name = "event"
    order = ORDER

    def buffers(self, task: Task) -> EventBuffers:  # noqa: D102
        modes, tables = task.modes, None
        if modes is not None and is_worthwhile(modes, task.output_interval, task.end_time):
            tables = new_exponential(modes, task.output_interval)
        return EventBuffers(Stages.new(task.entries), tables)

    def stepper(self, prepared: Prepared, limits: Limits) -> EventStepper:  # noqa: D102
        own, tolerance = prepared.own, _SHARE_OF_A_STEP * self.tolerance
        system, scratch = prepared.system, prepared.scratch
        return EventStepper(system, prepared.contacts, tolerance, limits, scratch, own.stages, own.exponential)
