"""Which samples of a history the page keeps as frames of its film."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from oblique_impact.history.history import History
from oblique_impact.history.sample_times import first_sample, last_sample
from oblique_impact.renders.timeline import TimeMap

Integers = NDArray[np.int64]
Item = TypeVar("Item")

FRAMES = 2000  # about, besides those that are always there
LISTED = 1000  # events or contacts at most


def frames(history: History, course: TimeMap) -> Integers:
    """Choose the samples that become frames, ascending: even in film time, and what has to be seen.

    That is both sides of every listed event, the largest force of every collision and the largest stress.
    """
    times, force = history["time"].values, np.nan_to_num(history["lambda_n"].values)
    events = np.array([event.time for event in evenly(history.events)])
    found = [np.searchsorted(course.film_at(times), np.linspace(0.0, course.duration, FRAMES))]
    found += [first_sample(times, events), last_sample(times, events)]
    stress = history.section_forces()["bending_stress"].values
    found.append(np.nan_to_num(np.abs(stress)).max(axis=1).argmax(keepdims=True))
    for collision in history.summary["macro_collisions"]:
        start, stop = np.searchsorted(times[:-1], [collision["start"], collision["end"]])
        found.append(start + force[start : max(start, stop) + 1].argmax(keepdims=True))
    # another run may go on when the course, which is that of the first one, has ended
    return np.unique(np.clip(np.concatenate(found), 0, int(last_sample(times, course.times[-1]))))


def evenly(items: Sequence[Item]) -> list[Item]:
    """Return all items, or of very many some, evenly spread."""
    return [items[k] for k in np.linspace(0, len(items) - 1, min(len(items), LISTED)).astype(int)]
