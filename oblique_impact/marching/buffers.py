"""The buffers of a march, allocated once per run: samples, and guards with what arms them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.several import phase_of
from oblique_impact.contact.state import (
    END,
    FREE,
    GUARDS,
    LOWER,
    NORMAL,
    SLIDING,
    UPPER,
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

    Rows of values and slopes are the start, the middle and the end of a part of a step; the last columns, one for
    each of n contacts, are the normal forces.
    """

    values: Array  # (3, 6 n)
    slopes: Array  # (3, 6 n)
    armed: NDArray[np.bool_]  # (5 n,)
    thresholds: Array  # (5 n,)
    at: Array  # (6 n,) at one instant
    largest: Array  # (2, n) normal force (N) and depth (m) so far


NEXT, KEPT = 0, 1


class OutputSamples(NamedTuple):
    """Output samples of a march, at multiples of the output interval."""

    times: Array  # (samples,)
    states: Array  # (samples, ny)
    counts: NDArray[np.int64]  # (2,) which multiple is NEXT, and how many samples of this call are KEPT


@inlined
def new_sample(t: float, samples: OutputSamples) -> int:
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
    samples: OutputSamples
    scales: Array  # (2 d,) sizes of q and q' for absolute tolerances
    tolerances: Tolerances


def new_scratch(work: Workspace, ny: int, scales: Array, tolerances: Tolerances, contacts: int = 1) -> Scratch:
    """Allocate buffers for state vectors of `ny` entries around the workspace of a system."""
    samples = max(16, min(SAMPLES_PER_CALL, SAMPLE_MEMORY // ny))
    count, columns = GUARDS * contacts, (GUARDS + 1) * contacts
    return Scratch(
        work=work,
        y_new=np.zeros(ny),
        at=np.zeros(ny),
        guards=GuardTable(
            np.zeros((3, columns)),
            np.zeros((3, columns)),
            np.zeros(count, dtype=np.bool_),
            np.zeros(count),
            np.zeros(columns),
            np.zeros((2, contacts)),
        ),
        samples=OutputSamples(np.zeros(samples), np.zeros((samples, ny)), np.zeros(2, dtype=np.int64)),
        scales=scales,
        tolerances=tolerances,
    )


def arm(phase: Phase, scratch: Scratch, initial: Array) -> None:
    """Arm the guards that start a phase clearly positive; the others must rise above their thresholds first.

    `initial` (5 n,) are the guards of n contacts at the start of the phase.
    """
    guards, arrays = scratch.guards, phase.arrays
    states = [phase] if arrays is None else [phase_of(phase, arrays, i) for i in range(len(arrays.rows))]
    thresholds = np.concatenate([_thresholds(state, scratch.tolerances) for state in states])
    guards.armed[:] = initial > thresholds
    # one that starts below zero, by rounding, has not fallen yet
    guards.thresholds[:] = thresholds + np.maximum(-initial, 0.0)


def _thresholds(phase: Phase, tolerances: Tolerances) -> Array:
    """Return what the guards of a contact must rise above to be armed, (5,)."""
    if phase.state == FREE:
        return np.full(GUARDS, tolerances.gap)
    found = np.full(GUARDS, tolerances.force)
    found[END] = tolerances.gap
    if phase.stop.compliant:
        found[NORMAL] = tolerances.gap
    if phase.state == SLIDING:
        found[LOWER] = found[UPPER] = tolerances.velocity
    elif phase.stick.compliance != 0.0:  # the force of a spring is known as well as its length
        found[LOWER] = found[UPPER] = tolerances.gap / phase.stick.compliance
    return found


@inlined
def raised(value: float, guard: int, guards: GuardTable) -> float:
    """Return a guard's value, raised by its threshold until it is armed."""
    return value if guards.armed[guard] else value + guards.thresholds[guard]
