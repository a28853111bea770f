"""Which samples of a history become frames."""

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
Flags = NDArray[np.bool_]

FRAMES = 1000  # of an export that asks for nothing else, besides those at events


@dataclass(frozen=True)
class Frames:
    """The chosen samples, in order; (frames,) each."""

    sample: Integers  # their numbers in the history
    time: Array  # s, strictly increasing
    side: Integers  # -1 left of a jump, 1 right of it, 0 where there is none

    def some(self, numbers: Integers) -> Frames:
        """Return the frames of these numbers."""
        return Frames(self.sample[numbers], self.time[numbers], self.side[numbers])


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
        side = sides(time)
        instant = np.where(side > 0, np.roll(time, 1), time)  # both sides of a jump are of one instant
        wanted = _finite(history) & self._inside(instant) & self._near(instant, events)
        always = np.isin(time, events) | (side != 0)
        always[-1:] = True
        each = np.arange(time.size)
        chosen = _evenly(time, wanted, FRAMES) if self.every is None else each % self.every == 0
        sample = np.flatnonzero(wanted & (chosen | always))
        if not sample.size:
            raise InputError(f"{self._options()}: no sample is left")
        return Frames(sample, time[sample], side[sample])

    def _options(self) -> str:
        options = [f"--every {self.every}"] if self.every is not None else []
        if self.between is not None:
            options.append(f"--between {self.between[0]:g},{self.between[1]:g}")
        if self.around_events is not None:
            options.append(f"--around-events {self.around_events:g}")
        return " ".join(options) or "history"

    def _inside(self, time: Array) -> Flags:
        if self.between is None:
            return np.ones(time.size, dtype=bool)
        inside = (time >= self.between[0]) & (time <= self.between[1])
        if not np.any(inside):
            raise InputError(
                f"--between {self.between[0]:g},{self.between[1]:g}: holds no sample; "
                f"the history covers {time[0]:g} to {time[-1]:g} s"
            )
        return np.asarray(inside)

    def _near(self, time: Array, events: Array) -> Flags:
        if self.around_events is None:
            return np.ones(time.size, dtype=bool)
        if not events.size:
            raise InputError(f"--around-events {self.around_events:g}: the history has no events")
        return np.asarray(distance_from(np.stack([events, events], axis=1), time) <= self.around_events)


def sides(time: Array) -> Integers:
    """Return -1 for samples left of a jump, 1 for those right of it, 0 elsewhere."""
    jump = jumps(time)
    right, left = np.concatenate([[False], jump]), np.concatenate([jump, [False]])
    return np.where(right, 1, np.where(left, -1, 0))


def _evenly(time: Array, wanted: Flags, count: int) -> Flags:
    """Mark `count` of the wanted samples, evenly in time; where some are left out in between, no time passes."""
    sample = np.flatnonzero(wanted)
    if sample.size <= count:
        return wanted
    steps = np.where(np.diff(sample) == 1, np.diff(time[sample]), 0.0)
    passed = np.concatenate([[0.0], np.cumsum(steps)])
    found = np.zeros_like(wanted)
    found[sample[np.searchsorted(passed, np.linspace(0.0, passed[-1], count))]] = True
    return found


def _finite(history: History) -> Flags:
    """Where the shape is finite: the last sample of a run that diverged may not be."""
    theta, ux, uy = (np.isfinite(history[name].values) for name in ("theta", "ux", "uy"))
    return np.asarray(theta & ux.all(axis=1) & uy.all(axis=1))
