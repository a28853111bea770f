"""The buffers of a march, allocated once per run: samples, and guards with what arms them."""

from __future__ import annotations

from collections.abc import Sequence
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
    Candidate,
    Tolerances,
)
from oblique_impact.kernels.jit import inlined
from oblique_impact.kernels.workspace import Array, Workspace

NO_GUARD = -1
#: samples that a march keeps at most before it returns
SAMPLES_PER_CALL = 4096
SAMPLE_MEMORY = 4_000_000  # numbers in the buffer of samples: 32 MB


# rows of a table of guards (9, 6 n), which a step is searched with for the first that falls: values and slopes at
# the start, the middle and the end of a part of a step; values at one instant; what a guard must rise above to be
# armed, and whether it is, 1 or 0.  The last n columns are the normal forces.
VALUES, SLOPES, AT, THRESHOLD, ARMED = 0, 3, 6, 7, 8
_GUARD_ROWS = 9


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
    guards: Array  # (9, 6 n) see above
    samples: OutputSamples
    scales: Array  # (2 d,) sizes of q and q' for absolute tolerances
    tolerances: Tolerances


def new_scratch(work: Workspace, ny: int, scales: Array, tolerances: Tolerances, contacts: int) -> Scratch:
    """Allocate buffers for state vectors of `ny` entries around the workspace of a system."""
    samples = max(16, min(SAMPLES_PER_CALL, SAMPLE_MEMORY // ny))
    return Scratch(
        work=work,
        y_new=np.zeros(ny),
        at=np.zeros(ny),
        guards=np.zeros((_GUARD_ROWS, (GUARDS + 1) * contacts)),
        samples=OutputSamples(np.zeros(samples), np.zeros((samples, ny)), np.zeros(2, dtype=np.int64)),
        scales=scales,
        tolerances=tolerances,
    )


@inlined
def guard_count(guards: Array) -> int:
    """Return the number of guards in a table."""
    return int(guards.shape[1] // (GUARDS + 1) * GUARDS)


def arm(contacts: Sequence[Candidate], scratch: Scratch, initial: Array) -> None:
    """Arm the guards that start a phase clearly positive; the others must rise above their thresholds first.

    `initial` (5 n,) are the guards of n contacts at the start of the phase.
    """
    thresholds = np.concatenate([_thresholds(c, scratch.tolerances) for c in contacts])
    scratch.guards[ARMED, : initial.size] = initial > thresholds
    # one that starts below zero, by rounding, has not fallen yet
    scratch.guards[THRESHOLD, : initial.size] = thresholds + np.maximum(-initial, 0.0)


def _thresholds(c: Candidate, tolerances: Tolerances) -> Array:
    """Return what the guards of a contact must rise above to be armed, (5,)."""
    if c.state == FREE:
        return np.full(GUARDS, tolerances.gap)
    found = np.full(GUARDS, tolerances.force)
    found[END] = tolerances.gap
    if c.compliant:
        found[NORMAL] = tolerances.gap
    if c.state == SLIDING:
        found[LOWER] = found[UPPER] = tolerances.velocity
    elif c.axial != 0.0:  # the force of a spring is known as well as its length
        found[LOWER] = found[UPPER] = tolerances.gap / c.axial
    return found


@inlined
def raised(value: float, guard: int, guards: Array) -> float:
    """Return a guard's value, raised by its threshold until it is armed."""
    return value if guards[ARMED, guard] != 0.0 else value + guards[THRESHOLD, guard]


@inlined
def arm_flight(guards: Array) -> None:
    """Arm the gaps of contacts that are all in flight."""
    for i in range(guards.shape[1] // (GUARDS + 1)):
        guards[ARMED, GUARDS * i + NORMAL] = 1.0
