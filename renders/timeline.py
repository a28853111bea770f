"""When the frames of a film are: time is stretched around contacts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from oblique_impact.errors import InputError
from oblique_impact.history.history import History

Array = NDArray[np.float64]

FPS = 30  # of a film, if not told otherwise
_AIM = 20.0  # s: about the length of the film of a page
_ROUND = (0.5, 1.0, 2.0, 5.0, 10.0)
_SHARE = 0.5  # of the film that contacts take
_RAMP = 1.0  # s of film, from one rate to the other
_GRID = 20_000
_MOST = 100_000  # frames of a film


@dataclass(frozen=True)
class TimeMap:
    """From physical to film time: piecewise linear between knots.

    At each of the knots, (knots,): physical time (s), ascending; film time (s), ascending from 0; their rate,
    physical over film time.
    """

    times: Array
    film: Array
    rates: Array

    @property
    def duration(self) -> float:
        """Length (s) of the film."""
        return float(self.film[-1])

    def film_at(self, time: Array | float) -> Array:
        """Return the film times (s) at which physical times (s) are shown."""
        return np.asarray(np.interp(time, self.times, self.film))

    def time_at(self, film: Array | float) -> Array:
        """Return the physical times (s) shown at film times (s)."""
        return np.asarray(np.interp(film, self.film, self.times))

    def rate_at(self, time: Array | float) -> Array:
        """Return physical over film time at physical times (s)."""
        return np.asarray(np.interp(time, self.times, self.rates))

    def part(self, first: float, last: float) -> TimeMap:
        """Return the stretch between two physical times (s): the same rates, its film from 0."""
        inner = self.times[(self.times > first) & (self.times < last)]
        times = np.concatenate([[first], inner, [last]])
        film = self.film_at(times)
        return TimeMap(times, film - film[0], self.rate_at(times))

    def lasting(self, duration: float) -> TimeMap:
        """Return the map of a film of another length (s): all rates are scaled."""
        stretch = duration / self.duration
        return TimeMap(self.times, self.film * stretch, self.rates / stretch)


@dataclass(frozen=True)
class Timeline:
    """Frames per second of a film, physical times of its frames (s), (frames,), and what lies between them."""

    fps: int
    times: Array
    course: TimeMap

    @property
    def rates(self) -> Array:
        """Physical over film time at each frame."""
        return self.course.rate_at(self.times)

    @property
    def duration(self) -> float:
        """Length of the film (s)."""
        return self.times.size / self.fps


def time_map(
    history: History,
    speed: float | None = None,
    contact_speed: float | None = None,
    seconds: float | None = None,
) -> TimeMap:
    """Lay out the course of the film of a run, the same for parts of it, and for its page but for the length.

    Parameters
    ----------
    history : History
        Its contacts are where time is stretched.
    speed, contact_speed : float, optional
        Physical over film time in flight and in contact; what is not given is one of 1, 1/2, 1/5, 1/10..., so
        that the film of the run lasts about twenty seconds.  Where contacts take more time than flight does, time
        is not stretched around them.
    seconds : float, optional
        If no speed is given the film of the run lasts exactly so long, at rates that are not round.

    Raises InputError for values out of range.
    """
    aim = _AIM if seconds is None else seconds
    if not 1.0 <= aim <= 3600.0:
        raise InputError(f"--seconds {aim:g}: should be from 1 to 3600")
    for name, value in (("--speed", speed), ("--contact-speed", contact_speed)):
        if value is not None and not 0.0 < value <= 1e6:
            raise InputError(f"{name} {value:g}: should be a positive number")
    if speed and contact_speed and contact_speed > speed:
        raise InputError(f"--contact-speed {contact_speed:g}: should be at most --speed, {speed:g}")
    first, last = float(history["time"][0]), float(history["time"][-1])
    if last <= first:
        return TimeMap(np.array([first]), np.zeros(1), np.ones(1))
    spans = np.clip(contact_spans(history), first, last)
    inside = float(np.sum(spans[:, 1] - spans[:, 0]))
    free = (last - first - inside) / ((1.0 - _SHARE if inside else 1.0) * aim)
    closed = max(inside, 1e-4) / (_SHARE * aim)
    if closed > free:
        free = closed = (last - first) / aim
    free, closed = speed or _round_rate(free), contact_speed or _round_rate(closed)
    if contact_speed:
        free = max(free, closed)
    closed = min(closed, free)
    # fine enough for the contacts and the ramps around them
    width, near = np.maximum(spans[:, 1:] - spans[:, :1], 1e-7), np.geomspace(1e-7, 0.05, 200)
    grid = [spans[:, :1] + width * np.linspace(0.0, 1.0, 200), spans[:, :1] - near, spans[:, 1:] + near]
    times = np.concatenate([np.linspace(first, last, _GRID), *(part.ravel() for part in grid)])
    times = np.unique(np.clip(times, first, last))
    rates = np.full(times.size, free)
    if spans.size and closed < free:
        after = np.searchsorted(spans[:, 0], times, side="right")
        since = times - np.append(-np.inf, spans[:, 1])[after]  # the end of the span that began last
        until = np.append(spans[:, 0], np.inf)[after] - times  # the start of the next one
        away = np.maximum(np.minimum(since, until), 0.0)
        # around contacts the rate grows by a constant factor per film time, d(rate)/d(film) =
        # rate log(free/closed)/ramp: so it is linear in the physical time from the contact
        rates = np.minimum(free, closed + np.log(free / closed) / _RAMP * away)
    film = cumulative_trapezoid(1.0 / rates, times, initial=0.0)
    course = TimeMap(times, film, rates)
    # rounded rates and the ramps around contacts take another time than was asked for
    return course if seconds is None or speed or contact_speed else course.lasting(seconds)


def contact_spans(history: History) -> Array:
    """Return when at least one contact is closed, (spans, 2): starts and ends (s), ascending and apart."""
    spans: list[list[float]] = []
    for start, end, *_ in sorted(history.contacts):
        if spans and start <= spans[-1][1]:
            spans[-1][1] = max(spans[-1][1], end)
        else:
            spans.append([start, end])
    return np.array(spans).reshape(-1, 2)


def _round_rate(rate: float) -> float:
    """Return the largest of 1, 1/2, 1/5, 1/10... (or 2, 5, 10...) that is not above 1.2 times `rate`."""
    decade = 10.0 ** np.floor(np.log10(max(rate, 1e-12)))
    return float(max(s * decade for s in _ROUND if s * decade <= 1.2 * rate or s == _ROUND[0]))


def make_timeline(
    course: TimeMap,
    fps: int = FPS,
    between: tuple[float, float] | None = None,
    frames: int | None = None,
) -> Timeline:
    """Lay out the frames of a film.

    Parameters
    ----------
    course : TimeMap
        Of the film of the whole run.
    fps : int
        Frames per second.
    between : tuple, optional
        Part of the run (s); its rates are those of the film of the whole run.
    frames : int, optional
        Exactly so many frames: all rates are scaled.

    Raises InputError for values out of range.
    """
    if not 1 <= fps <= 240:
        raise InputError(f"--fps {fps}: should be from 1 to 240")
    if frames is not None and not 2 <= frames <= _MOST:
        raise InputError(f"--frames {frames}: should be from 2 to {_MOST}")
    begin, end = course.times[[0, -1]].tolist()
    first, last = between or (begin, end)
    if not begin <= first < last <= end:
        raise InputError(
            f"--between {first:g},{last:g}: should be two increasing times from {begin:g} to {end:g} s"
        )
    course = course.part(first, last)
    if frames is None:
        frames = math.ceil(course.duration * fps - 1e-9) + 1
        if frames > _MOST:
            raise InputError(f"--speed, --fps: a film of {frames} frames: should have at most {_MOST}")
    else:
        course = course.lasting((frames - 1) / fps)
    times = course.time_at(np.arange(frames) / fps)
    times[-1] = last
    return Timeline(fps, times, course)


def rate_text(rate: float) -> str:
    """Return physical over film time in words."""
    if abs(rate - 1.0) < 0.005:
        return "real time"
    if rate > 1.0:
        return f"{rate:.3g} times real time"
    return f"1/{float(f'{1.0 / rate:.2g}'):.10g} of real time"
