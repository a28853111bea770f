"""The numbers that claims are judged by, from runs of the same case with different friction models."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from validation.reproduction.runs import Macro, Run

Array = NDArray[np.float64]

_POINTS = 20_001  # of the grids of time on which runs are compared


class Trio(NamedTuple):
    """The three models on the same case."""

    hybrid: Run
    frictionless: Run
    modified: Run

    @property
    def starts(self) -> list[float]:
        """First touch of the first macro-collision in each run (s)."""
        return [run.macros[0].start for run in self if run.macros]


def grid(start: float, end: float) -> Array:
    """Return the points of time (s) on which runs are compared."""
    return np.linspace(start, end, _POINTS)


def force_difference(a: Run, b: Run, name: str, number: int) -> float:
    """Difference of a contact force during a macro-collision, 0 (the same) to 1 (no overlap at all).

    int |a - b| dt / int (|a| + |b|) dt over the time from the first touch to the last release in either run;
    NaN if one of them has no such macro-collision or there is no force.
    """
    first, second = a.macro(number), b.macro(number)
    if first is None or second is None:
        return float("nan")
    times = grid(min(first.start, second.start), max(first.end, second.end))
    x, y = a.at(name, times), b.at(name, times)
    total = float(np.sum(np.abs(x) + np.abs(y)))
    return float(np.sum(np.abs(x - y))) / total if total > 0.0 else float("nan")


def before_contact(trio: Trio) -> float:
    """Time (s) just before any of the runs touches the slope."""
    return min(trio.starts) * (1.0 - 1e-9)


def between(trio: Trio, number: int) -> float | None:
    """Return the time (s) in the middle of the flight after macro-collision `number`; None if they overlap."""
    ends = [run.macro(number) for run in trio]
    starts = [run.macro(number + 1) for run in trio]
    if any(macro is None for macro in ends):
        return None
    last = max(macro.end for macro in ends if macro)
    first = min((macro.start for macro in starts if macro), default=min(run.end_time for run in trio))
    return 0.5 * (last + first) if first > last else None


def flights(run: Run) -> list[tuple[float, float]]:
    """Windows of time (s) before, between and after the macro-collisions."""
    starts = [0.0, *(macro.end for macro in run.macros)]
    ends = [*(macro.start for macro in run.macros), run.end_time]
    return [(start, end) for start, end in zip(starts, ends, strict=True) if end > start]


def flight_ranges(run: Run, name: str) -> list[float]:
    """Largest minus smallest value of a variable in each flight; the last flight may be cut by the end."""
    return [float(np.ptp(run[name][run.inside(start, end)])) for start, end in flights(run)]


def smallest_share(run: Run, others: list[Run], name: str, start: float, end: float) -> float:
    """Part of a window of time in which `run` has the smallest value of all."""
    times = grid(start, end)
    least = np.min([other.at(name, times) for other in others], axis=0)
    return float(np.mean(run.at(name, times) < least))


def mean(run: Run, name: str, start: float, end: float) -> float:
    """Mean over time."""
    return float(np.mean(run.at(name, grid(start, end))))


def correlation(a: Run, b: Run, name: str, start: float, end: float) -> float:
    """Correlation coefficient of a variable of two runs over a window of time."""
    times = grid(start, end)
    return float(np.corrcoef(a.at(name, times), b.at(name, times))[0, 1])


def largest_difference(trio: Trio, names: tuple[str, ...], end: float) -> float:
    """Largest difference between any two runs up to `end`, relative to the largest value of each variable."""
    times = grid(0.0, end)
    worst = 0.0
    for name in names:
        values = np.array([run.at(name, times) for run in trio])
        worst = max(worst, float(np.max(np.ptp(values, axis=0))) / (float(np.max(np.abs(values))) or 1.0))
    return worst


def existing(values: list[float]) -> list[float]:
    """Return the values in front of the first that does not exist (NaN)."""
    return values[: next((i for i, value in enumerate(values) if np.isnan(value)), len(values))]


def increasing(values: list[float]) -> bool:
    """Whether there are two values at least, each larger than the one before."""
    return len(values) > 1 and all(a < b for a, b in pairwise(values))


def longest_stick(run: Run, macro: Macro) -> tuple[float, float]:
    """Start and duration (s) of the longest stick in a macro-collision; NaN and 0 if there is none."""
    sticks = run.sticks_in(macro)
    if not sticks:
        return float("nan"), 0.0
    longest = max(sticks, key=lambda stick: stick.duration)
    return longest.start, longest.duration


def stick_share(run: Run, macros: list[Macro]) -> float:
    """Part of the time in contact that the tip spends in the state STICK, over some macro-collisions."""
    contact = sum(run.contact_time(macro) for macro in macros)
    stuck = sum(stick.duration for macro in macros for stick in run.sticks_in(macro))
    return stuck / contact if contact > 0.0 else 0.0
