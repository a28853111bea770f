"""Which samples of a history become frames of an export."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import jumps
from oblique_impact.renders.timeline import distance_from

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

FRAMES = 1000  # of an export that asks for nothing else, besides those at events


@dataclass(frozen=True)
class Selection:
    """What to keep of a history; samples at events and jumps and the last one always belong to it.

    Attributes
    ----------
    every : int or None
        Keep the samples whose number is a multiple of this, 1 for all; None keeps about `FRAMES`, evenly in time.
    between : (float, float) or None
        Keep this span of time (s), both ends included.
    around_events : float or None
        Keep only what is within so many seconds of an event.
    """

    every: int | None = None
    between: tuple[float, float] | None = None
    around_events: float | None = None

    def __post_init__(self) -> None:
        if self.every is not None and self.every < 1:
            raise InputError(f"--every {self.every}: should be at least 1")
        first, last = self.between or (0.0, 1.0)
        if not -math.inf < first < last < math.inf:
            raise InputError(f"--between {first:g},{last:g}: should be two times in s, the first one earlier")
        if self.around_events is not None and not 0.0 <= self.around_events < math.inf:
            raise InputError(f"--around-events {self.around_events:g}: should be a time in s, 0 or more")

    def samples(self, history: History) -> Integers:
        """Return the numbers of the chosen samples, ascending.

        Samples whose shape is not finite (the last ones of a run that diverged) are left out.  Raises InputError
        if no sample is left.
        """
        time = np.asarray(history["time"].values, dtype=float)
        events = np.unique([event.time for event in history.events])
        side = sides(time)
        # both sides of a jump are of one instant: a span that ends at an event keeps both
        instant = np.where(side > 0, np.roll(time, 1), time)
        shapes = [history[name].values.reshape(time.size, -1) for name in ("theta", "ux", "uy")]
        wanted = np.isfinite(np.concatenate(shapes, axis=1)).all(axis=1)
        if self.between is not None:
            wanted &= (instant >= self.between[0]) & (instant <= self.between[1])
        if self.around_events is not None:
            wanted &= distance_from(np.stack([events, events], axis=1), instant) <= self.around_events
        if not wanted.any():
            raise InputError(f"history: no sample is left; it covers {time[0]:g} to {time[-1]:g} s")
        chosen = np.isin(time, events) | (side != 0)
        chosen[-1] = True
        if self.every is None:
            chosen[_evenly(time, np.flatnonzero(wanted), FRAMES)] = True
        else:
            chosen[:: self.every] = True
        return np.flatnonzero(wanted & chosen)


def sides(time: Array) -> Integers:
    """Return -1 for samples left of a jump, 1 for those right of it, 0 elsewhere."""
    jump = jumps(time)
    right, left = np.concatenate([[False], jump]), np.concatenate([jump, [False]])
    return np.where(right, 1, np.where(left, -1, 0))


def _evenly(time: Array, samples: Integers, count: int) -> Integers:
    """Choose `count` of some samples, evenly in time; over gaps between them no time passes."""
    if samples.size <= count:
        return samples
    steps = np.where(np.diff(samples) == 1, np.diff(time[samples]), 0.0)
    passed = np.concatenate([[0.0], np.cumsum(steps)])
    return np.asarray(samples[np.searchsorted(passed, np.linspace(0.0, passed[-1], count))])
