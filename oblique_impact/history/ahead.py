"""What becomes of samples while the run goes on: one that ends, or is interrupted, has little left to do."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import NamedTuple

from oblique_impact.beam.section_forces import BLOCK
from oblique_impact.history.draft import Draft
from oblique_impact.history.growing import Column, Columns
from oblique_impact.history.samples import Samples, join
from oblique_impact.marching.loop import Record, Status

#: samples that are worth the trouble
_PORTION = 1024

ProgressCallback = Callable[[Status], None]


class _Done(NamedTuple):
    """How far it has come; replaced as a whole, for an interrupt may come at any instant."""

    segments: int  # that are gathered
    rows: int  # that have their variables
    waiting: Samples | None  # gathered, less than a block
    last: float  # time (s) of the last sample that is gathered


class Ahead:
    """The progress of a run: its samples become variables of its history on the way.

    The blocks of samples whose fields are computed together are the same whatever the portions, bit for bit.

    Parameters
    ----------
    gather : callable
        Puts segments together to samples, whose times come `after` one in s.
    derive : callable
        Returns the variables, arrays (samples, ...) by name, of samples.
    on_progress : callable, optional
        Called with every status.
    draft : Draft, optional
        Where the variables are written ahead.

    Attributes
    ----------
    record : Record
        Of the run that is followed; to be set before it begins.
    seconds : float
        Wall time (s) that this took.
    """

    def __init__(
        self,
        gather: Callable[..., Samples],
        derive: Callable[[Samples], dict[str, Column]],
        on_progress: ProgressCallback | None,
        draft: Draft | None,
    ) -> None:
        self.record = Record()
        self.seconds = 0.0
        self._gather, self._derive, self._on_progress, self._draft = gather, derive, on_progress, draft
        self._columns = Columns()
        self._done = _Done(0, 0, None, -math.inf)
        self._first: Samples | None = None

    def __call__(self, status: Status) -> None:
        """Take what has come, if it is much."""
        started = time.perf_counter()
        if sum(segment.times.size for segment in self.record.segments[self._done.segments :]) >= _PORTION:
            self._take()
            if self._draft is not None:
                self._draft.advance(self._columns.view(self._done.rows))
        self.seconds += time.perf_counter() - started
        if self._on_progress:
            self._on_progress(status)

    def finish(self) -> tuple[dict[str, Column], Samples, Samples]:
        """Return the variables of all samples, the first sample and the last."""
        last = self._take(to_the_end=True).part(slice(-1, None))
        assert self._first is not None
        return self._columns.take_out(self._done.rows), self._first, last

    def _take(self, *, to_the_end: bool = False) -> Samples:
        """Return the samples that were taken, or are still waiting."""
        segments, rows, waiting, last = self._done
        samples = self._gather(self.record.segments[segments:], after=last)
        samples = join(waiting, samples) if waiting else samples
        if rows == 0:
            self._first = samples.part(slice(1))
        count = samples.time.size
        count -= 0 if to_the_end else count % BLOCK
        self._columns.put(rows, self._derive(samples.part(slice(count))))
        taken = len(self.record.segments)
        self._done = _Done(taken, rows + count, samples.part(slice(count, None)), float(samples.time[-1]))
        self.record.segments[segments:taken] = [
            segment._replace(times=segment.times[:0], states=segment.states[:0])
            for segment in self.record.segments[segments:taken]
        ]
        return samples
