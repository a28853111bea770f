"""Which samples of a history become frames, and the times they carry.

A history has two samples at a jump, with the same time; file formats want increasing times.  So the left
sample keeps its time, and the right one carries the next larger double: one ulp later, 1e-16 of a second at
t = 1 s.  All other times are exact.  The time of the history stands in the field data of every frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.history import History

Array = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Frames:
    """The chosen samples, in order.

    Attributes
    ----------
    sample : (frames,) integer array
        Their numbers in the history.
    time : (frames,) array
        Their times (s) in the history; two at a jump are equal.
    stamp : (frames,) array
        The times (s) of the frames: strictly increasing.
    side : (frames,) integer array
        -1 left of a jump, 1 right of it, 0 where there is none.
    """

    sample: Integers
    time: Array
    stamp: Array
    side: Integers


@dataclass(frozen=True)
class Selection:
    """What to keep of a history.

    Attributes
    ----------
    every : int
        Keep the samples whose number is a multiple of this; those at events and jumps and the last one are
        always kept.
    between : (float, float) or None
        Keep this span of time (s), both ends included.
    around_events : float or None
        Keep only what is within so many seconds of an event.
    """

    every: int = 1
    between: tuple[float, float] | None = None
    around_events: float | None = None

    def __post_init__(self) -> None:
        if self.every < 1:
            raise InputError(f"--every {self.every}: should be at least 1")
        if self.between is not None:
            start, end = self.between
            if not (math.isfinite(start) and math.isfinite(end) and start < end):
                raise InputError(f"--between {start:g},{end:g}: should be two times in s, the first one earlier")
        if self.around_events is not None and not 0.0 <= self.around_events < math.inf:
            raise InputError(f"--around-events {self.around_events:g}: should be a time in s, 0 or more")

    def frames(self, history: History) -> Frames:
        """Choose the frames; what has no finite shape is left out.  Raises InputError if nothing is left."""
        time = np.asarray(history["time"].values, dtype=float)
        events = np.unique([event.time for event in history.events])
        sides = _sides(time)
        keep = (np.arange(time.size) % self.every == 0) | np.isin(time, events) | (sides != 0)
        keep[-1:] = True
        keep &= _finite(history)
        if self.between is not None:
            keep &= (time >= self.between[0]) & (time <= self.between[1])
            if not np.any(keep):
                raise InputError(
                    f"--between {self.between[0]:g},{self.between[1]:g}: holds none of the samples kept; "
                    f"the history covers {time[0]:g} to {time[-1]:g} s"
                )
        if self.around_events is not None:
            if not events.size:
                raise InputError(f"--around-events {self.around_events:g}: the history has no events")
            keep &= _distance(time, events) <= self.around_events
            if not np.any(keep):
                raise InputError(f"--around-events {self.around_events:g}: holds none of the samples kept")
        sample = np.flatnonzero(keep)
        return Frames(sample, time[sample], increasing(time)[sample], sides[sample])


def increasing(times: Array) -> Array:
    """Return the times (s) with every one that does not increase moved to the next double after its forerunner."""
    found = np.array(times, dtype=float)
    for k in np.flatnonzero(np.diff(times) <= 0.0) + 1:
        # the moved one may meet the next: go on until there is room
        while k < found.size and found[k] <= found[k - 1]:
            found[k] = np.nextafter(found[k - 1], np.inf)
            k += 1
    return found


def _finite(history: History) -> NDArray[np.bool_]:
    """Where the shape is finite: the last sample of a run that diverged may not be."""
    theta, ux, uy = (np.isfinite(history[name].values) for name in ("theta", "ux", "uy"))
    return np.asarray(theta & ux.all(axis=1) & uy.all(axis=1))


def _sides(times: Array) -> Integers:
    same = np.diff(times) == 0.0
    right = np.concatenate([[False], same])
    left = np.concatenate([same, [False]])
    return np.where(right, 1, np.where(left, -1, 0))


def _distance(times: Array, events: Array) -> Array:
    """Distance (s) of each time from the nearest event."""
    after = np.searchsorted(events, times).clip(0, events.size - 1)
    before = (after - 1).clip(0)
    return np.asarray(np.minimum(np.abs(times - events[before]), np.abs(times - events[after])))
