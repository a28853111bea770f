"""Which samples of a history the page keeps: frames of the film, and points of the charts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import first_sample, last_sample
from oblique_impact.marching.records import Event
from oblique_impact.renders.timeline import TimeMap

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Item = TypeVar("Item")

MAX_EVENTS = 1000  # of which the page keeps both sides
CHART_POINTS = 4500
_BY_FILM = 0.3  # share of the frames that follow the film; the others follow the motion


def frames(history: History, course: TimeMap, steps: int) -> Index:
    """Choose the samples that become frames, ascending: about `steps`, and besides them both sides of every event.

    All samples in contact are frames if they are less than half of `steps`.  The density of the others follows
    the film in part, so that none of it is poor in frames, and mostly the change of shape and stress, so that
    the vibrations of a flight are met.
    """
    times = history["time"].values
    contact = np.flatnonzero(history["state"].values != State.FREE)
    contact = contact[:0] if contact.size > steps // 2 else contact
    measure = _BY_FILM * _share(course.film_at(times)) + (1.0 - _BY_FILM) * _share(_activity(history))
    kept = np.concatenate([event_samples(history), _extremes(history), [0, times.size - 1]]).astype(int)
    return np.union1d(np.union1d(kept, contact), _equal_parts(measure, steps - contact.size))


def event_samples(history: History) -> Index:
    """Return the first and last sample at the time of each listed event: its left and its right side."""
    times = history["time"].values
    at = np.array([event.time for _, event in listed_events(history)])
    left, right = first_sample(times, at), last_sample(times, at)
    return np.unique(np.clip(np.concatenate([left, right]), 0, times.size - 1)).astype(int)


def listed_events(history: History) -> list[tuple[int, Event]]:
    """Return the events that the page lists, with their numbers from 1: all, or some of very many."""
    return evenly(list(enumerate(history.events, start=1)))


def evenly(items: Sequence[Item]) -> list[Item]:
    """Return all items, or of more than `MAX_EVENTS` as many, evenly spread."""
    chosen = np.linspace(0, len(items) - 1, min(len(items), MAX_EVENTS)).astype(int)
    return [items[k] for k in chosen]


def chart_points(series: list[Array], frame_samples: Index, state: Index, count: int = CHART_POINTS) -> Index:
    """Choose the samples that the charts show, ascending: the frames, and of every stretch the extremes.

    Parameters
    ----------
    series : list of ndarray (samples,)
        Everything the charts draw; no peak of any of them is lost.
    frame_samples : ndarray
        The samples that are frames.
    state : ndarray (samples,)
        The contact state; all samples in contact are kept if they are less than half of `count`.
    count : int
        About the largest number of samples; if there are fewer, all are kept.
    """
    size = series[0].size
    if size <= count:
        return np.arange(size)
    parts = max(1, count // (2 * len(series)))
    edges = np.linspace(0, size, parts + 1).astype(int)
    contact = np.flatnonzero(state != State.FREE)
    found = [frame_samples, contact[:0] if contact.size > count // 2 else contact]
    for values in series:
        clean = np.nan_to_num(values)
        for start, stop in pairwise(edges):
            part = clean[start:stop]
            found.append(np.array([start + int(part.argmin()), start + int(part.argmax())]))
    return np.unique(np.concatenate(found))


def _equal_parts(measure: Array, count: int) -> Index:
    """Choose about `count` samples that divide a measure into equal parts, as far as samples allow."""
    size = min(count, measure.size)
    while True:  # parts that fall on one sample are spent elsewhere
        wanted = np.linspace(measure[0], measure[-1], size)
        found = np.unique(np.clip(np.searchsorted(measure, wanted), 0, measure.size - 1))
        if found.size >= min(count, measure.size) or size > 64 * count:
            return found
        size = math.ceil(1.02 * size)


def _share(values: Array) -> Array:
    """Scale a non-decreasing course to end at one."""
    rise = values - values[0]
    return np.asarray(rise / max(float(rise[-1]), 1e-300))


def _activity(history: History) -> Array:
    """Return the path that shape and stress have gone, each relative to its extent in the run."""
    turns = np.abs(np.diff(history["theta"].values)) / np.pi
    steps = np.nan_to_num(np.minimum(turns, 1.0))
    for name in ("uy", "bending_stress"):
        values = history[name].values
        finite = np.abs(values[np.isfinite(values)])
        scale = float(np.max(finite, initial=0.0)) or 1.0
        change = np.nan_to_num(np.abs(np.diff(values / scale, axis=0)).max(axis=1), posinf=1.0)
        steps = steps + np.minimum(change, 1.0)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _extremes(history: History) -> Index:
    """Return the samples of the largest force of every collision, and of the largest stress of the run."""
    times, force = history["time"].values, np.nan_to_num(history["lambda_n"].values)
    stress = np.nan_to_num(np.abs(history["bending_stress"].values)).max(axis=1)
    found = [int(np.argmax(stress)), int(np.argmax(np.abs(np.nan_to_num(history["lambda_tau"].values))))]
    for collision in history.summary["macro_collisions"]:
        start, stop = np.searchsorted(times, [collision["start"], collision["end"]], side="left")
        found.append(int(start) + int(np.argmax(force[start : stop + 1])))
    return np.array(found)
