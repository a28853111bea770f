"""How fast the film runs: real time between collisions, stretched smoothly around them.

The film lasts the integral of the stretch s(t) over the run, with

    s(t) = flight + (slow - flight) / (1 + (d / D)^6),   D = _LEAD / slow

where d is the distance of t from the nearest collision.  The tails of a collision so take about `_LEAD`
seconds of film each.  A collision that would last too long (a beam that sticks) is slowed at its events only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oblique_impact.history import History

Array = NDArray[np.float64]

_FLIGHTS = 10.0  # s of film that the run would take without collisions
_LONGEST = 75.0  # s of film, with the collisions
_COLLISION = 20.0  # s of film that one collision may take as a whole
_LEAD = 2.0  # s of film in which the film slows down, and speeds up again
_SLOWER = (100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0)  # than in flight
_ROUND = tuple(m * 10.0**e for e in range(-9, 10) for m in (1.0, 2.0, 5.0))


@dataclass(frozen=True)
class Film:
    """The course of the film: knots of a piecewise linear map from the time of the run to that of the film.

    Attributes
    ----------
    times : ndarray (knots,)
        Times of the run (s), strictly ascending.
    film : ndarray (knots,)
        Times of the film (s) at normal speed, strictly ascending from 0.
    """

    times: Array
    film: Array

    @property
    def duration(self) -> float:
        """Length (s) of the film at normal speed."""
        return float(self.film[-1])

    def at(self, times: Array) -> Array:
        """Return times of the film (s) at times of the run (s)."""
        return np.asarray(np.interp(times, self.times, self.film))


def film_of(history: History) -> Film:
    """Choose the stretch: the slowest collisions with which the film stays shorter than `_LONGEST`."""
    times = np.unique(history["time"].values)
    if times.size < 2:
        return Film(times, np.zeros(times.size))
    run = float(times[-1] - times[0])
    flight = min(_ROUND, key=lambda stretch: abs(np.log(stretch * run / _FLIGHTS)))
    candidates = [_course(history, times, flight, flight * slower) for slower in _SLOWER]
    return next((film for film in candidates if film.duration <= _LONGEST), candidates[-1])


def _course(history: History, times: Array, flight: float, slow: float) -> Film:
    spans = _spans(history, _COLLISION / slow)
    reach = _LEAD / slow
    # the stretch bends within a few D of a collision, whatever the samples do there
    near = np.concatenate([spans[:, 0, None] - reach * _BEND, spans[:, 1, None] + reach * _BEND]).ravel()
    grid = np.union1d(times, near[(near > times[0]) & (near < times[-1])])
    stretch = flight + (slow - flight) / (1.0 + (_distance(grid, spans) / reach) ** 6)
    pieces = 0.5 * np.diff(grid) * (stretch[1:] + stretch[:-1])
    return Film(grid, np.concatenate([[0.0], np.cumsum(pieces)]))


_BEND = np.concatenate([np.linspace(0.0, 3.0, 31), np.geomspace(3.2, 30.0, 12)])


def _spans(history: History, longest: float) -> Array:
    """Intervals (n, 2) of time that are shown slowly, ascending and apart from each other."""
    events = np.array([event.time for event in history.events])
    found: list[tuple[float, float]] = []
    for collision in history.summary["macro_collisions"]:
        start, end = float(collision["start"]), float(collision["end"])
        if end - start <= longest:
            found.append((start, end))
        else:
            inside = np.unique(events[(events >= start) & (events <= end)])
            found.extend((t, t) for t in inside.tolist())
    return np.array(sorted(found)).reshape(-1, 2)


def _distance(times: Array, spans: Array) -> Array:
    """Distance (s) of each time from the nearest interval; infinite if there is none."""
    if not spans.size:
        return np.full(times.shape, np.inf)
    after = np.searchsorted(spans[:, 0], times, side="right")  # intervals that have begun
    last, following = np.maximum(after - 1, 0), np.minimum(after, spans.shape[0] - 1)
    gone = np.where(after > 0, np.maximum(times - spans[last, 1], 0.0), np.inf)
    ahead = np.where(after < spans.shape[0], spans[following, 0] - times, np.inf)
    return np.asarray(np.minimum(gone, ahead))
