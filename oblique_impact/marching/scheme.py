"""The contract between the marching schemes and the loop that drives them.

A scheme advances one phase until a guard of its state changes sign, until `t_stop`, or until its leg is full, and
says which.  It knows nothing of transitions, and holds no state of a run: that is in the front and the scratch.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
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
from oblique_impact.contact.transitions import Judgement
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.system import NormalModes
from oblique_impact.kernels.workspace import EFFECTIVE_SLOTS, Array, Workspace

# Why a march returned: positive reasons are ordinary, negative ones end the run
AT_STOP, AT_GUARD, LEG_FULL = 0, 1, 2
FAILED_MASS, FAILED_SLIDING, FAILED_STICKING = -MASS_NOT_POSITIVE, -NO_SLIDING_SOLUTION, -NO_STICKING_SOLUTION
FAILED_STEP, FAILED_FINITE, FAILED_ITERATION = -10, -11, -12

NO_GUARD = -1
SAMPLES_PER_LEG = 4096
SAMPLE_MEMORY = 4_000_000  # numbers in the buffer of samples
UNBOUNDED = 1e12  # in units of the scales: beyond it a solution has diverged


class Front(NamedTuple):
    """Where a march is; with the state vector that is all it needs to go on."""

    t: float  # s
    h: float  # s, step to go on with
    sample: int  # number of the next output sample
    origin: float  # s; steps of constant length end at origin + done h
    done: int
    taken: int  # steps since the phase began


class Leg(NamedTuple):
    """How far a march may go before it returns."""

    t_stop: float  # s
    interval: float  # s, of output samples
    most_steps: int


class Progress(NamedTuple):
    """Where a march stopped and what it cost."""

    reason: int
    guard: int
    front: Front
    steps: int
    rejected: int
    samples: int
    peak_force: float  # N
    depth: float  # m; the largest, of a contact with a stop that gives way


#: a `Progress` in plain tuples, as kernels return it: numba makes named ones by calls that an interrupt may break
Returned = tuple[int, int, tuple[float, float, int, float, int, int], int, int, int, float, float]


def progress_of(found: Returned) -> Progress:
    """Return a kernel's progress with its names."""
    return Progress(found[0], found[1], Front(*found[2]), *found[3:])


class Scratch(NamedTuple):
    """Buffers of a march, allocated once per run."""

    work: Workspace
    K: Array  # (16, ny) stages
    F: Array  # (7, ny) dense output
    y_new: Array  # (ny,)
    at: Array  # (ny,)
    values: Array  # (3, 6) guards and normal force at the ends and the middle of a part of a step
    slopes: Array  # (3, 6)
    armed: NDArray[np.bool_]  # (5,)
    thresholds: Array  # (5,)
    scales: Array  # (2 d,) sizes of q and q' for absolute tolerances
    tolerances: Tolerances
    contraction: Array  # (3,) of an implicit scheme's iterations, by slot; negative: not known
    rounded: Array  # (3,) residuals below which they do not fall, by slot; 0: not known
    times: Array  # (samples,)
    states: Array  # (samples, ny)
    tables: Any  # what the scheme computes once for a run, or None


def new_scratch(work: Workspace, ny: int, scales: Array, tolerances: Tolerances, tables: Any = None) -> Scratch:
    """Allocate buffers for state vectors of `ny` entries around the workspace of a system."""
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
        scales=scales,
        tolerances=tolerances,
        contraction=np.full(EFFECTIVE_SLOTS, -1.0),
        rounded=np.zeros(EFFECTIVE_SLOTS),
        times=np.zeros(samples),
        states=np.zeros((samples, ny)),
        tables=tables,
    )


def arm(phase: Phase, scratch: Scratch, initial: Guards) -> None:
    """Arm the guards that start a phase clearly positive; the others must rise above their thresholds first."""
    thresholds, tolerances, values = scratch.thresholds, scratch.tolerances, np.array(initial)
    if phase.state == FREE:
        thresholds[:] = tolerances.gap
    else:
        thresholds[:] = tolerances.force
        thresholds[END] = tolerances.gap
        if phase.gives_way:
            thresholds[NORMAL] = tolerances.gap
        if phase.state == SLIDING:
            thresholds[LOWER] = thresholds[UPPER] = tolerances.velocity
    scratch.armed[:] = values > thresholds
    thresholds += np.maximum(-values, 0.0)  # one that starts below zero, by rounding, has not fallen yet


@inlined
def raised(value: float, guard: int, s: Scratch) -> float:
    """Return a guard's value, raised by its threshold until it is armed."""
    return value if s.armed[guard] else value + s.thresholds[guard]


@jitable
def bounded(y: Array, s: Scratch) -> bool:
    """Whether coordinates and velocities are finite and below 1e12 of their scales."""
    scales, beyond = s.scales, 0
    for m in range(scales.shape[0]):  # to the end, several entries at a time
        if not abs(y[m]) < UNBOUNDED * scales[m]:
            beyond += 1
    return beyond == 0


@jitable
def keep_sample(t: float, y: Array, sample: int, count: int, leg: Leg, s: Scratch) -> tuple[int, int]:
    """Keep the end of a step as a sample if one is due; the numbers of the next sample and of those kept."""
    if t >= sample * leg.interval * (1.0 - 1e-12) and t < leg.t_stop:
        s.times[count] = t
        for m in range(y.shape[0]):
            s.states[count, m] = y[m]
        return int(t / leg.interval * (1.0 + 1e-12)) + 1, count + 1
    return sample, count


class Scheme(ABC):
    """A marching scheme; subclasses state their order of convergence in the step.

    A scheme is immutable: the same object marches any number of runs.
    """

    name: str
    order: int

    @property
    def judgement(self) -> Judgement | None:
        """How stick and slip are told apart at the ends of steps; None if transitions are located."""
        return None

    @property
    def shortest_flight(self) -> float:
        """Length (s) of flights between bounces that are too short to be told apart."""
        return 0.0

    def tables(self, modes: NormalModes | None, interval: float, end_time: float) -> Any:
        """Return what this computes once for a run of a system with `modes`, a named tuple; by default None."""
        return None

    def check(self, end_time: float) -> None:  # noqa: B027  most schemes have nothing to check
        """Raise InputError if this cannot march; called before a run of a user-defined integrator."""

    def extra_state(self, size: int) -> int:
        """Entries of the state vector behind the quadratures, of a system of `size`; NaN as a phase starts.

        The first `size` + 2 of them, if there are any, are the acceleration and the contact forces to report.
        """
        return 0

    def steps_per_leg(self, size: int) -> int:
        """Return after how many steps a march returns; 0: as many as take about a tenth of a second."""
        return 0

    @abstractmethod
    def march(
        self, system: Any, phase: Phase, before: Phase | None, front: Front, y: Array, leg: Leg, scratch: Scratch
    ) -> Progress:
        """Advance `y` in place from the front; samples go to `scratch.times` and `scratch.states`.

        `before` is the phase that came before this one, None at the start of a run.
        """
