"""The contract between the marching schemes and the loop that drives them.

A scheme advances one phase until a guard of its state changes sign, until `t_stop`, or for as many steps as it is
allowed, and says which.  It knows nothing of transitions, and holds no state of a run: that is in the arguments.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.forces import MASS_NOT_POSITIVE, NO_SLIDING_SOLUTION, NO_STICKING_SOLUTION
from oblique_impact.contact.state import (
    END,
    FREE,
    GUARDS,
    LOWER,
    NORMAL,
    SLIDING,
    UPPER,
    Guards,
    Phase,
    Tolerances,
)
from oblique_impact.contact.transitions import StickCriterion
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.system import NormalModes
from oblique_impact.kernels.workspace import Array, Workspace

# Why a march returned: positive reasons are ordinary, negative ones end the run
AT_STOP, AT_GUARD, LIMIT_REACHED = 0, 1, 2
FAILED_MASS, FAILED_SLIDING, FAILED_STICKING = -MASS_NOT_POSITIVE, -NO_SLIDING_SOLUTION, -NO_STICKING_SOLUTION
FAILED_STEP, FAILED_FINITE, FAILED_ITERATION = -10, -11, -12

NO_GUARD = -1
#: samples that a march keeps at most before it returns
SAMPLES_PER_CALL = 4096
SAMPLE_MEMORY = 4_000_000  # numbers in the buffer of samples: 32 MB
UNBOUNDED = 1e12  # in units of the scales: beyond it a solution has diverged


class StepState(NamedTuple):
    """Time, step and counters of a march; with the state vector all that it needs to continue."""

    t: float  # s
    h: float  # s, step to go on with
    sample: int  # number of the next output sample
    origin: float  # s; steps of constant length end at origin + done h
    done: int
    taken: int  # steps since the phase began


class Limits(NamedTuple):
    """Bounds of time and steps at which a march returns."""

    t_stop: float  # s
    interval: float  # s, of output samples
    most_steps: int


class Progress(NamedTuple):
    """State at which a march returned, the reason, and its costs."""

    reason: int
    guard: int
    state: StepState
    steps: int
    rejected: int
    samples: int
    peak_force: float  # N
    depth: float  # m; the largest, of a contact with a compliant stop


#: a `Progress` in plain tuples, as kernels return it: numba makes named ones by calls that an interrupt may break
Returned = tuple[int, int, tuple[float, float, int, float, int, int], int, int, int, float, float]


def progress_of(found: Returned) -> Progress:
    """Return a kernel's progress with its names."""
    return Progress(found[0], found[1], StepState(*found[2]), *found[3:])


class GuardTable(NamedTuple):
    """Guards while a step is searched for the first that falls.

    Rows of values and slopes are the start, the middle and the end of a part of a step; the last column is the
    normal force.
    """

    values: Array  # (3, 6)
    slopes: Array  # (3, 6)
    armed: NDArray[np.bool_]  # (5,)
    thresholds: Array  # (5,)


class Samples(NamedTuple):
    """Output samples of a march."""

    times: Array  # (samples,)
    states: Array  # (samples, ny)


class Scratch(NamedTuple):
    """Buffers that all schemes share, allocated once per run."""

    work: Workspace
    y_new: Array  # (ny,) end of a step
    at: Array  # (ny,) a place inside of it
    guards: GuardTable
    samples: Samples
    scales: Array  # (2 d,) sizes of q and q' for absolute tolerances
    tolerances: Tolerances


def new_scratch(work: Workspace, ny: int, scales: Array, tolerances: Tolerances) -> Scratch:
    """Allocate buffers for state vectors of `ny` entries around the workspace of a system."""
    samples = max(16, min(SAMPLES_PER_CALL, SAMPLE_MEMORY // ny))
    rows = np.zeros((3, GUARDS + 1)), np.zeros((3, GUARDS + 1))
    return Scratch(
        work=work,
        y_new=np.zeros(ny),
        at=np.zeros(ny),
        guards=GuardTable(*rows, np.zeros(GUARDS, dtype=np.bool_), np.zeros(GUARDS)),
        samples=Samples(np.zeros(samples), np.zeros((samples, ny))),
        scales=scales,
        tolerances=tolerances,
    )


@dataclass(frozen=True)
class Prepared:
    """A system with the buffers of a march, the same from call to call."""

    system: Any
    scratch: Scratch
    own: Any  # see `Scheme.buffers`


def arm(phase: Phase, scratch: Scratch, initial: Guards) -> None:
    """Arm the guards that start a phase clearly positive; the others must rise above their thresholds first."""
    guards, tolerances, values = scratch.guards, scratch.tolerances, np.array(initial)
    thresholds = guards.thresholds
    if phase.state == FREE:
        thresholds[:] = tolerances.gap
    else:
        thresholds[:] = tolerances.force
        thresholds[END] = tolerances.gap
        if phase.stop.compliant:
            thresholds[NORMAL] = tolerances.gap
        if phase.state == SLIDING:
            thresholds[LOWER] = thresholds[UPPER] = tolerances.velocity
    guards.armed[:] = values > thresholds
    thresholds += np.maximum(-values, 0.0)  # one that starts below zero, by rounding, has not fallen yet


@inlined
def raised(value: float, guard: int, guards: GuardTable) -> float:
    """Return a guard's value, raised by its threshold until it is armed."""
    return value if guards.armed[guard] else value + guards.thresholds[guard]


@jitable
def bounded(y: Array, s: Scratch) -> bool:
    """Whether coordinates and velocities are finite and below 1e12 of their scales."""
    scales, beyond = s.scales, 0
    for m in range(scales.shape[0]):  # to the end, several entries at a time
        if not abs(y[m]) < UNBOUNDED * scales[m]:
            beyond += 1
    return beyond == 0


@jitable
def keep_sample(t: float, y: Array, sample: int, count: int, limits: Limits, samples: Samples) -> tuple[int, int]:
    """Keep the end of a step as a sample if one is due; the numbers of the next sample and of those kept."""
    if t >= sample * limits.interval * (1.0 - 1e-12) and t < limits.t_stop:
        samples.times[count] = t
        for m in range(y.shape[0]):
            samples.states[count, m] = y[m]
        return int(t / limits.interval * (1.0 + 1e-12)) + 1, count + 1
    return sample, count


class Scheme(ABC):
    """A marching scheme; subclasses state their order of convergence in the step.

    A scheme is immutable: the same object marches any number of runs.
    """

    name: str
    order: int

    @property
    def stick_criterion(self) -> StickCriterion | None:
        """Criterion that distinguishes stick from slip at the ends of steps; None if transitions are located."""
        return None

    @property
    def shortest_flight(self) -> float:
        """Length (s) of flights between bounces below which bounces are taken as accumulated."""
        return 0.0

    def buffers(self, ny: int, modes: NormalModes | None, interval: float, end_time: float) -> Any:
        """Return the buffers of this scheme alone, for state vectors of `ny` entries; by default None.

        The system has `modes` where its linear part is known; samples are `interval` (s) apart.
        """
        return None

    def check(self, end_time: float) -> None:  # noqa: B027  most schemes have nothing to check
        """Raise InputError if this cannot march; called before a run of a user-defined integrator."""

    def extra_state(self, size: int) -> int:
        """Entries of the state vector behind the quadratures, of a system of `size`; NaN as a phase starts.

        The first `size` + 2 of them, if there are any, are the acceleration and the contact forces to report.
        """
        return 0

    def steps_per_call(self, size: int) -> int:
        """Return after how many steps a march returns; 0: as many as take about a tenth of a second."""
        return 0

    @abstractmethod
    def march(
        self, prepared: Prepared, phase: Phase, before: Phase | None, start: StepState, y: Array, limits: Limits
    ) -> Progress:
        """Advance `y` in place from where a march is; samples go to `prepared.scratch.samples`.

        `before` is the phase that came before this one, None at the start of a run.
        """
