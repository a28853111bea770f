"""The contract between the marching schemes and the loop that drives them.

A scheme advances one phase until a guard of its state changes sign, until `t_stop`, or until its
buffer is full, and says which.  It knows nothing of transitions.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.forces import (
    FREE,
    GUARD_LOWER,
    GUARD_NORMAL,
    GUARD_UPPER,
    MASS_NOT_POSITIVE,
    NO_SLIDING_SOLUTION,
    NO_STICKING_SOLUTION,
    SLIDING,
    Phase,
)
from oblique_impact.kernels.system import EFFECTIVE_SLOTS, GUARDS, Array, Work

# Why a march returned: positive reasons are ordinary, negative ones end the run
AT_STOP, AT_GUARD, BUFFER_FULL = 0, 1, 2
FAILED_MASS, FAILED_SLIDING, FAILED_STICKING = -MASS_NOT_POSITIVE, -NO_SLIDING_SOLUTION, -NO_STICKING_SOLUTION
FAILED_STEP, FAILED_FINITE, FAILED_ITERATION = -10, -11, -12

SAMPLES_PER_LEG = 4096
FIRST_LEG, SECONDS_PER_LEG = 20, 0.1  # steps, and wall time
SAMPLE_MEMORY = 4_000_000  # numbers in the buffer of samples


class Pace:
    """How many steps a leg takes: about a tenth of a second of computing.

    So progress and interrupts are prompt.  Where a leg ends does not change the steps.
    """

    def __init__(self) -> None:
        self.steps = FIRST_LEG

    def learn(self, steps: int, seconds: float) -> None:
        """Follow a leg that took so many steps."""
        if steps >= self.steps:
            self.steps = max(1, int(min(SECONDS_PER_LEG * steps / max(seconds, 1e-9), 20.0 * steps, 1e6)))


class Tolerances(NamedTuple):
    """What counts as zero: a guard must rise above this before its fall through zero is an event."""

    gap: float = 1e-12  # m
    force: float = 1e-9  # N
    velocity: float = 1e-11  # m/s
    flight: float = 0.0  # s, bounces shorter than this are taken as accumulated (a fixed step's length)


class Scratch(NamedTuple):
    """Buffers of a march, allocated once per run."""

    work: Work
    K: Array  # (16, ny) stages
    F: Array  # (7, ny) dense output
    y_new: Array  # (ny,)
    at: Array  # (ny,)
    values: Array  # (3, 5) guards and normal force at the ends and the middle of a part of a step
    slopes: Array  # (3, 5)
    armed: NDArray[np.bool_]  # (4,)
    thresholds: Array  # (4,)
    contraction: Array  # (3,) of an implicit scheme's iterations, by slot; negative: not known
    times: Array  # (samples,)
    states: Array  # (samples, ny)


def new_scratch(work: Work, ny: int) -> Scratch:
    """Allocate buffers for state vectors of `ny` entries around the work arrays of a system."""
    samples = max(16, min(SAMPLES_PER_LEG, SAMPLE_MEMORY // ny))
    return Scratch(
        work=work,
        K=np.zeros((16, ny)),
        F=np.zeros((7, ny)),
        y_new=np.zeros(ny),
        at=np.zeros(ny),
        values=np.zeros((3, GUARDS + 1)),
        slopes=np.zeros((3, GUARDS + 1)),
        armed=np.zeros(GUARDS, dtype=np.bool_),
        thresholds=np.zeros(GUARDS),
        contraction=np.full(EFFECTIVE_SLOTS, -1.0),
        times=np.zeros(samples),
        states=np.zeros((samples, ny)),
    )


def arm(phase: Phase, scratch: Scratch, tolerances: Tolerances, initial_guards: Array) -> None:
    """Arm the guards that start a phase clearly positive; the others must rise above their thresholds first."""
    thresholds = scratch.thresholds
    if phase.state == FREE:
        thresholds[:] = tolerances.gap
    else:
        thresholds[:] = tolerances.force
        if phase.spring > 0.0:
            thresholds[GUARD_NORMAL] = tolerances.gap
        if phase.state == SLIDING:
            thresholds[GUARD_LOWER] = thresholds[GUARD_UPPER] = tolerances.velocity
    scratch.armed[:] = initial_guards > thresholds
    thresholds += np.maximum(-initial_guards, 0.0)  # one that starts below zero, by rounding, has not fallen yet


class Progress(NamedTuple):
    """Where a march stopped and what it cost."""

    reason: int
    guard: int
    t: float
    h: float  # step to continue with (s)
    steps: int
    rejected: int
    samples: int
    peak_force: float  # N
    depth: float  # m; the largest, of a contact with a stop that gives way


@dataclass
class Course:
    """The moving front of a run: time, state vector and the bookkeeping a scheme needs to continue."""

    t: float
    y: Array
    h: float
    output_interval: float
    next_sample: int = 1
    phase_start: float = 0.0
    phase_steps: int = 0

    def begin_phase(self) -> None:
        """Start a new phase here; output samples continue with the next multiple of the interval."""
        self.phase_start = self.t
        self.phase_steps = 0
        ratio = self.t / self.output_interval
        self.next_sample = int(np.floor(ratio * (1.0 + 1e-14) + 1e-9)) + 1


class Scheme(ABC):
    """A marching scheme; subclasses state their order of convergence in the step."""

    name: str
    order: int
    #: whether transitions are judged once per step (the paper's way) or located as roots
    stepwise: bool

    def check(self, end_time: float) -> None:  # noqa: B027  most schemes have nothing to check
        """Raise InputError if this cannot march; called before a run of an integrator of one's own."""

    def extra_state(self, size: int) -> int:
        """Entries of the state vector behind the quadratures, of a system of `size`; NaN as a phase starts."""
        return 0

    @abstractmethod
    def begin(self, phase: Phase, scratch: Scratch, tolerances: Tolerances, initial_guards: Array) -> None:
        """Prepare the scratch arrays for a phase that starts with these guards."""

    @abstractmethod
    def march(self, system: Any, phase: Phase, course: Course, t_stop: float, scratch: Scratch) -> Progress:
        """Advance `course` in place (t, y, h); samples go to `scratch.times` and `scratch.states`."""
