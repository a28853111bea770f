"""The numbers that claims are judged by, from runs of the same case with different friction models."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.history.summary import MacroCollision
from oblique_impact.validation.reproduction.runs import Run, Stay

Array = NDArray[np.float64]

_POINTS = 20_001  # times at which runs are compared


class Trio(NamedTuple):
    """The three models on the same case."""

    hybrid: Run
    frictionless: Run
    modified: Run

    @property
    def before_contact(self) -> float:
        """Time (s) just before any of the runs touches the slope."""
        return min(run.macros[0].start for run in self if run.macros) * (1.0 - 1e-9)

    @property
    def end(self) -> float:
        """Time (s) that all runs reach."""
        return min(run.end_time for run in self)


def sampled(runs: Sequence[Run], name: str, start: float, end: float) -> Array:
    """Values (runs, points) of a variable at many times from `start` to `end` (s), linear between samples."""
    times = np.linspace(start, end, _POINTS)
    return np.stack([np.interp(times, run["time"], run[name]) for run in runs])


def force_difference(a: Run, b: Run, name: str, number: int) -> float:
    """Difference of a contact force during a macro-collision, 0 (the same) to 1 (no overlap at all).

    int |a - b| dt / int (|a| + |b|) dt over the time from the first touch to the last release in either run;
    NaN if one of them has no such macro-collision or there is no force.
    """
    if min(len(a.macros), len(b.macros)) < number:
        return float("nan")
    first, second = a.macro(number), b.macro(number)
    x, y = sampled((a, b), name, min(first.start, second.start), max(first.end, second.end))
    total = float(np.sum(np.abs(x) + np.abs(y)))
    return float(np.sum(np.abs(x - y))) / total if total > 0.0 else float("nan")


def between(trio: Trio, number: int) -> float | None:
    """Return the time (s) in the middle of the flight after macro-collision `number`; None if they overlap."""
    if min(len(run.macros) for run in trio) < number:
        return None
    last = max(run.macro(number).end for run in trio)
    first = min((run.macros[number].start for run in trio if len(run.macros) > number), default=trio.end)
    return 0.5 * (last + first) if first > last else None


def flight_ranges(run: Run, name: str) -> list[float]:
    """Largest minus smallest value of a variable in each flight; the last flight may be cut by the end."""
    starts = [0.0, *(macro.end for macro in run.macros)]
    ends = [*(macro.start for macro in run.macros), run.end_time]
    flights = [run.inside(start, end) for start, end in zip(starts, ends, strict=True) if end > start]
    return [float(np.ptp(run[name][inside])) for inside in flights]


def largest_difference(trio: Trio, names: tuple[str, ...], end: float) -> float:
    """Largest difference between any two runs up to `end`, relative to the largest value of each variable."""
    courses = [sampled(trio, name, 0.0, end) for name in names]
    return max(float(np.max(np.ptp(v, axis=0))) / (float(np.max(np.abs(v))) or 1.0) for v in courses)


def existing(values: list[float]) -> list[float]:
    """Return the values in front of the first that does not exist (NaN)."""
    return values[: next((i for i, value in enumerate(values) if np.isnan(value)), len(values))]


def increasing(values: list[float]) -> bool:
    """Whether there are two values at least, each larger than the one before."""
    return len(values) > 1 and all(a < b for a, b in pairwise(values))


def longest(sticks: Sequence[Stay]) -> tuple[float, float]:
    """Start and duration (s) of the longest of some sticks; NaN and 0 if there is none."""
    found = max(sticks, key=lambda stick: stick.duration, default=None)
    return (found.start, found.duration) if found else (float("nan"), 0.0)


def stick_share(run: Run, macros: list[MacroCollision]) -> float:
    """Part of the time in contact that the tip spends in the state STICK, over some macro-collisions."""
    contact = sum(stay.duration for macro in macros for stay in run.stays_in(macro))
    stuck = sum(stick.duration for macro in macros for stick in run.sticks_in(macro))
    return stuck / contact if contact > 0.0 else 0.0
