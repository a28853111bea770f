"""Numbers from runs: what happens in a macro-collision, and how runs with different friction models differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.history.history import History
from oblique_impact.history.summary import MacroCollision
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import simulate

Array = NDArray[np.float64]

NAN = float("nan")
#: s, the reversal in the first and the stick in the second macro-collision, in the paper
REVERSAL, STICK = 0.325, 0.699
#: times at which runs are compared
_POINTS = 20_001


class MissingError(Exception):
    """Raised where a run does not have what is asked for; the message says what that is."""


class Stay(NamedTuple):
    """One stay in a state of contact: start and end (s), and the slip velocity as it began (m/s).

    A rebound has no length.
    """

    start: float
    end: float
    state: State
    slip_rate: float

    @property
    def duration(self) -> float:
        """Length (s)."""
        return self.end - self.start


class Models(NamedTuple):
    """Runs of the same case with the three friction models."""

    hybrid: History
    frictionless: History
    modified: History

    @property
    def before_contact(self) -> float:
        """Time (s) just before any of the runs touches the slope."""
        return min(macros(run)[0].start for run in self if macros(run)) * (1.0 - 1e-9)

    @property
    def end(self) -> float:
        """Time (s) that all runs reach."""
        return min(run.end_time for run in self)


def run_light(scenario: Scenario) -> History:
    """Simulate a scenario; returns its history without what varies along the beam, which would not fit in memory.

    It has the total `energy` (J) and the rates of the contact point's displacements in the floating frame,
    `shortening_rate` and `deflection_rate` (m/s), besides.
    """
    history = simulate(scenario)
    tip = history.data.sel(station=scenario.contact.point, method="nearest")
    data = history.data.drop_dims("station").assign(
        energy=history.total_energy,
        shortening_rate=("time", tip["ux_dot"].values),
        deflection_rate=("time", tip["uy_dot"].values),
    )
    return replace(history, data=data)


# --- one run


def values(run: History, name: str) -> NDArray[Any]:
    """Return the samples of a variable."""
    return np.asarray(run.data[name].values)


def value_at(run: History, name: str, time: float) -> float:
    """Return a variable at a time (s)."""
    return float(run.at(time)[name])


def inside(run: History, start: float, end: float) -> NDArray[np.bool_]:
    """Return which samples lie in a window of time (s)."""
    times = values(run, "time")
    return np.asarray((times >= start) & (times <= end))


def macros(run: History) -> list[MacroCollision]:
    """Return the macro-collisions in order of time."""
    return [MacroCollision(**macro) for macro in run.macro_collisions]


def macro(run: History, number: int) -> MacroCollision:
    """Return the macro-collision `number` (1 is the first); raises MissingError if there are fewer."""
    found = macros(run)
    if len(found) < number:
        raise MissingError("no collision" if number == 1 else "no second collision")
    return found[number - 1]


def stays(run: History, during: MacroCollision | None = None) -> list[Stay]:
    """Return stays in contact and rebounds, in the whole run or during a macro-collision."""
    ends = [event.time for event in run.events[1:]] + [run.end_time]
    found = [
        Stay(event.time, event.time if event.state == State.FREE else end, event.state, event.tangential_velocity)
        for event, end in zip(run.events, ends, strict=False)
        if event.state != State.FREE or event.kind.impulsive
    ]
    return [stay for stay in found if during is None or during.start <= stay.start <= during.end]


def sticks(run: History, during: MacroCollision | None = None) -> list[Stay]:
    """Return every stay in the state STICK, in the whole run or during a macro-collision."""
    return [stay for stay in stays(run, during) if stay.state == State.STICK]


def longest(found: Sequence[Stay]) -> tuple[float, float]:
    """Return start and duration (s) of the longest of some stays; NaN and 0 if there is none."""
    stay = max(found, key=lambda stay: stay.duration, default=None)
    return (stay.start, stay.duration) if stay else (NAN, 0.0)


def reversals(run: History, during: MacroCollision) -> list[float]:
    """Return the times (s) at which the direction of slip turned in contact during a macro-collision."""
    turned = [event.time for event in run.events if event.kind == EventKind.REVERSAL]
    return [time for time in turned if during.start <= time <= during.end]


def stick_share(run: History, among: Sequence[MacroCollision]) -> float:
    """Return the part of the time in contact that is spent in the state STICK, over some macro-collisions."""
    contact = sum(stay.duration for macro in among for stay in stays(run, macro))
    stuck = sum(stay.duration for macro in among for stay in sticks(run, macro))
    return stuck / contact if contact > 0.0 else 0.0


def flight_ranges(run: History, name: str) -> list[float]:
    """Return largest minus smallest value of a variable in each flight; the last may be cut by the end."""
    starts = [0.0, *(macro.end for macro in macros(run))]
    ends = [*(macro.start for macro in macros(run)), run.end_time]
    flights = [inside(run, start, end) for start, end in zip(starts, ends, strict=True) if end > start]
    return [float(np.ptp(values(run, name)[flight])) for flight in flights]


def collision_numbers(run: History, number: int) -> dict[str, float]:
    """Return what happens in a macro-collision (SI units); NaN or 0 where the run has no such one.

    `reversal` is the one nearest to 0.325 s (first) or the first one (second), `energy_left` the total energy in
    the flight that follows.
    """
    found = macros(run)
    if len(found) < number:
        it, turned, stuck, left = MacroCollision(NAN, NAN, 0, NAN, NAN, NAN), [], [], NAN
    else:
        it = found[number - 1]
        turned, stuck = reversals(run, it), sticks(run, it)
        until = found[number].start if len(found) > number else run.end_time
        left = value_at(run, "energy", 0.5 * (it.end + until))
    wanted = REVERSAL if number == 1 else it.start
    return {
        **asdict(it),
        "reversals": len(turned),
        "reversal": min(turned, key=lambda time: abs(time - wanted), default=NAN),
        "sticks": len(stuck),
        "stick_time": sum(stay.duration for stay in stuck),
        "longest_stick_start": longest(stuck)[0],
        "energy_left": left,
    }


# --- runs beside each other


def sampled(runs: Sequence[History], name: str, start: float, end: float) -> Array:
    """Return values (runs, points) of a variable, linear between samples, at many times from `start` to `end`."""
    times = np.linspace(start, end, _POINTS)
    return np.stack([np.interp(times, values(run, "time"), values(run, name)) for run in runs])


def force_difference(a: History, b: History, name: str, number: int) -> float:
    """Return the difference of a contact force during a macro-collision, 0 (the same) to 1 (no overlap at all).

    int |a - b| dt / int (|a| + |b|) dt over the time from the first touch to the last release in either run;
    NaN if one of them has no such macro-collision or there is no force.
    """
    if min(len(macros(a)), len(macros(b))) < number:
        return NAN
    first, second = macro(a, number), macro(b, number)
    x, y = sampled((a, b), name, min(first.start, second.start), max(first.end, second.end))
    total = float(np.sum(np.abs(x) + np.abs(y)))
    return float(np.sum(np.abs(x - y))) / total if total > 0.0 else NAN


def between(models: Models, number: int) -> float | None:
    """Return the time (s) in the middle of the flight after macro-collision `number`; None if they overlap."""
    found = [macros(run) for run in models]
    if min(map(len, found)) < number:
        return None
    last = max(own[number - 1].end for own in found)
    first = min((own[number].start for own in found if len(own) > number), default=models.end)
    return 0.5 * (last + first) if first > last else None


def largest_difference(models: Models, names: Sequence[str], end: float) -> float:
    """Return the largest difference of any two runs up to `end`, relative to each variable's largest value."""
    courses = [sampled(models, name, 0.0, end) for name in names]
    return max(float(np.max(np.ptp(v, axis=0))) / (float(np.max(np.abs(v))) or 1.0) for v in courses)


def existing(numbers: Sequence[float]) -> list[float]:
    """Return the numbers in front of the first that does not exist (NaN)."""
    return list(numbers[: next((i for i, value in enumerate(numbers) if np.isnan(value)), len(numbers))])


def increasing(numbers: Sequence[float]) -> bool:
    """Return whether there are two numbers at least, each larger than the one before."""
    return len(numbers) > 1 and all(a < b for a, b in pairwise(numbers))
