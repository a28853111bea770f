"""When the frames of a film are: time is stretched around contacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.history import History

Array = NDArray[np.float64]

FPS, SECONDS = 30, 20.0  # of a film, if not told otherwise
_SERIES = (1.0, 2.0, 5.0)
_SHARE = 0.5  # of the film that contacts take
_RAMP = 1.0  # s of film, from one rate to the other
_GRID = 20_000


@dataclass(frozen=True)
class Timeline:
    """Times of the frames and their rate.

    Attributes
    ----------
    fps : int
        Frames per second.
    times : ndarray, shape (frames,)
        Physical time of each frame (s).
    rates : ndarray, shape (frames,)
        Physical over film time.
    """

    fps: int
    times: Array
    rates: Array

    @property
    def duration(self) -> float:
        """Length of the film (s)."""
        return self.times.size / self.fps

    def film_time(self, time: Array | float) -> Array:
        """Film time (s) at which a physical time (s) is shown."""
        return np.asarray(np.interp(time, self.times, np.arange(self.times.size) / self.fps))


def contact_windows(history: History) -> list[tuple[float, float]]:
    """Return starts and ends (s) of the contacts; an impact that rebounds at once is one of no length."""
    found: list[tuple[float, float]] = []
    opened: float | None = None
    for event in history.events:
        kind = event.kind.value
        if kind == "impact" and opened is None:
            opened = event.time
        elif kind == "rebound":
            found.append((event.time, event.time))
        elif kind == "release" and opened is not None:
            found.append((opened, event.time))
            opened = None
    if opened is not None:
        found.append((opened, float(history["time"][-1])))
    return found


def make_timeline(
    history: History,
    fps: int = FPS,
    speed: float | None = None,
    contact_speed: float | None = None,
    between: tuple[float, float] | None = None,
    frames: int | None = None,
) -> Timeline:
    """Lay out the frames of a film.

    Parameters
    ----------
    history : History
        Its contacts are where time is stretched.
    fps : int
        Frames per second.
    speed, contact_speed : float, optional
        Physical over film time in flight and in contact; chosen so that the film lasts about `SECONDS`, from
        1, 1/2, 1/5, 1/10..., if not given.
    between : tuple, optional
        Part of the run (s).
    frames : int, optional
        Exactly so many frames: all rates are scaled a little.

    Raises InputError for values out of range.
    """
    _check(fps, speed, contact_speed, frames)
    end = float(history["time"][-1])
    first, last = between or (float(history["time"][0]), end)
    if not (np.isfinite(first) and np.isfinite(last)) or not float(history["time"][0]) <= first < last <= end:
        raise InputError(f"--between {first:g},{last:g}: should be two increasing times from 0 to {end:g} s")
    windows = [(max(a, first), min(b, last)) for a, b in contact_windows(history) if b >= first and a <= last]
    inside = sum(b - a for a, b in windows)
    free = speed or _round((last - first - inside) / ((1.0 - _SHARE if inside else 1.0) * SECONDS))
    closed = min(contact_speed or _round(max(inside, 1e-4) / (_SHARE * SECONDS)), free)
    grid = _grid(first, last, windows)
    rate = _rates(grid, windows, free, closed)
    film = np.concatenate([[0.0], np.cumsum(np.diff(grid) * 0.5 * (1.0 / rate[1:] + 1.0 / rate[:-1]))])
    count = frames or max(2, round(film[-1] * fps) + 1)
    at = np.linspace(0.0, film[-1], count)
    times = np.interp(at, film, grid)
    stretch = 1.0 if frames is None else film[-1] * fps / max(frames - 1, 1)
    return Timeline(fps, times, np.interp(times, grid, rate) * stretch)


def _check(fps: int, speed: float | None, contact_speed: float | None, frames: int | None) -> None:
    if not 1 <= fps <= 240:
        raise InputError(f"--fps {fps}: should be from 1 to 240")
    for name, value in (("--speed", speed), ("--contact-speed", contact_speed)):
        if value is not None and not 0.0 < value <= 1e6:
            raise InputError(f"{name} {value:g}: should be a positive number")
    if frames is not None and not 2 <= frames <= 100_000:
        raise InputError(f"--frames {frames}: should be from 2 to 100000")


def _round(rate: float) -> float:
    """Largest of 1, 1/2, 1/5, 1/10... (and 2, 5, 10...) that is not above `rate` by more than a fifth."""
    decade = 10.0 ** np.floor(np.log10(max(rate, 1e-12)))
    return float(max(s * decade for s in (0.5, *_SERIES, 10.0) if s * decade <= 1.2 * rate or s == 0.5))


def _grid(first: float, last: float, windows: list[tuple[float, float]]) -> Array:
    """Physical times fine enough for the ramps and the contacts."""
    parts = [np.linspace(first, last, _GRID)]
    for a, b in windows:
        parts.append(np.linspace(a, max(b, a + 1e-7), 200))
        parts += [a - np.geomspace(1e-7, 0.05, 200), b + np.geomspace(1e-7, 0.05, 200)]
    return np.unique(np.clip(np.concatenate(parts), first, last))


def _rates(grid: Array, windows: list[tuple[float, float]], free: float, closed: float) -> Array:
    """Rate at each time: `closed` in contacts, growing to `free` around them over about `_RAMP` of film.

    Growth by a constant factor per film time, d(rate)/d(film) = rate log(free/closed)/ramp, makes the rate
    linear in the physical time from the contact.
    """
    slope = np.log(free / closed) / _RAMP if free > closed else 0.0
    distance = np.full(grid.size, np.inf)
    for a, b in windows:
        distance = np.minimum(distance, np.maximum(np.maximum(a - grid, grid - b), 0.0))
    if not windows:
        return np.full(grid.size, free)
    return np.minimum(free, closed + slope * distance) if slope else np.full(grid.size, free)
