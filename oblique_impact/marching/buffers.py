"""The buffers of a march, allocated once per run: samples, and guards with what arms them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
from oblique_impact.kernels.jit import inlined
from oblique_impact.kernels.workspace import Array, Workspace

NO_GUARD = -1
#: samples that a march keeps at most before it returns
SAMPLES_PER_CALL = 4096
SAMPLE_MEMORY = 4_000_000  # numbers in the buffer of samples: 32 MB


class GuardTable(NamedTuple):
    """Guards while a step is searched for the first that falls.

    Rows of values and slopes are the start, the middle and the end of a part of a step; the last column is the
    normal force.
    """

    values: Array  # (3, 6)
    slopes: Array  # (3, 6)
    armed: NDArray[np.bool_]  # (5,)
    thresholds: Array  # (5,)


NEXT, KEPT = 0, 1


class Samples(NamedTuple):
    """Output samples of a march, at multiples of the output interval."""

    times: Array  # (samples,)
    states: Array  # (samples, ny)
    counts: NDArray[np.int64]  # (2,) which multiple is NEXT, and how many samples of this call are KEPT


@inlined
def new_sample(t: float, samples: Samples) -> int:
    """Begin the sample at a time (s); returns the row of its state, which is to be filled."""
    kept = int(samples.counts[KEPT])
    samples.times[kept] = t
    samples.counts[KEPT] = kept + 1
    samples.counts[NEXT] += 1
    return kept


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
        samples=Samples(np.zeros(samples), np.zeros((samples, ny)), np.zeros(2, dtype=np.int64)),
        scales=scales,
        tolerances=tolerances,
    )


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
