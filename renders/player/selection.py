"""Which samples of a history the page keeps as frames of its film."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import first_sample, last_sample
from oblique_impact.renders.timeline import TimeMap

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Item = TypeVar("Item")

FRAMES = 2000  # about, besides both sides of events
LISTED = 1000  # events or contacts at most
_BY_FILM = 0.4  # part of the frames that are even in film time; the others follow vibrations, which are faster


def frames(history: History, course: TimeMap) -> Integers:
    """Choose the samples that become frames, ascending: about `FRAMES`, with both sides of every listed event.

    All samples in contact are frames if they are less than half of them; so are those of the largest force of
    every collision and of the largest stress of the run.
    """
    times = history["time"].values
    contact = np.flatnonzero(history["state"].values != State.FREE)
    contact = contact[:0] if contact.size > FRAMES // 2 else contact
    events = np.array([event.time for event in evenly(history.events)])
    always = [[0, times.size - 1], _extremes(history), first_sample(times, events), last_sample(times, events)]
    film, motion = (values / max(values[-1], 1e-300) for values in (course.film_at(times), _path(history)))
    measure = _BY_FILM * film + (1.0 - _BY_FILM) * motion
    even = np.searchsorted(measure, np.linspace(0.0, measure[-1], FRAMES - contact.size))
    found = np.unique(np.concatenate([*always, contact, even]).astype(np.int64))
    return found[(found >= 0) & (found < times.size)]


def _path(history: History) -> Array:
    """Return the path that angle and shape have gone up to each sample, each over its extent in the run."""
    path = np.minimum(np.abs(np.diff(history["theta"].values)) / np.pi, 1.0)
    for name in ("uy", "bending_stress"):
        values = np.nan_to_num(history[name].values, posinf=0.0, neginf=0.0)
        extent = float(np.abs(values).max()) or 1.0
        path = path + np.abs(np.diff(values, axis=0)).max(axis=1) / extent
    return np.concatenate([[0.0], np.cumsum(np.nan_to_num(path))])


def _extremes(history: History) -> Integers:
    """Return the samples of the largest force of every collision, and of the largest stress of the run."""
    times, force = history["time"].values, np.nan_to_num(history["lambda_n"].values)
    found = [int(np.nan_to_num(np.abs(history["bending_stress"].values)).max(axis=1).argmax())]
    for collision in history.summary["macro_collisions"]:
        start, stop = np.searchsorted(times, [collision["start"], collision["end"]])
        found.append(int(start + force[start : stop + 1].argmax()))
    return np.array(found)


def evenly(items: Sequence[Item]) -> list[Item]:
    """Return all items, or of very many some, evenly spread."""
    return [items[k] for k in np.linspace(0, len(items) - 1, min(len(items), LISTED)).astype(int)]
