"""Numbers from runs: what happens in a macro-collision, and how runs with different friction models differ."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.history.history import History
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import simulate
from oblique_impact.validation.report import number

Array = NDArray[np.float64]
#: start and end (s)
Span = tuple[float, float]

NAN = float("nan")
#: s, the reversal in the first and the stick in the second macro-collision, in the paper
REVERSAL, STICK = 0.325, 0.699
#: times at which runs are compared
_POINTS = 20_001


class MissingError(Exception):
    """Raised where a run does not have what is asked for; the message says what that is."""


class Stay(NamedTuple):
    """One stay in a state of contact: start and end (s), and the slip velocity as it began (m/s)."""

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
        return min(collisions(run)[0][0] for run in self if run.macro_collisions) * (1.0 - 1e-9)

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


def within(run: History, name: str, start: float, end: float) -> Array:
    """Return the samples of a variable in a window of time (s)."""
    return np.asarray(run[name].sel(time=slice(start, end)).values)


def collisions(run: History) -> list[Span]:
    """Return the macro-collisions in order of time."""
    return [(found["start"], found["end"]) for found in run.macro_collisions]


def collision(run: History, number: int) -> Span:
    """Return the macro-collision `number` (1 is the first); raises MissingError if there are fewer."""
    found = collisions(run)
    if len(found) < number:
        raise MissingError("no collision" if number == 1 else "no second collision")
    return found[number - 1]


def stays(run: History, during: Span | None = None) -> list[Stay]:
    """Return the stays in contact that begin in the whole run or in a macro-collision."""
    ends = [event.time for event in run.events[1:]] + [run.end_time]
    found = [
        Stay(event.time, end, event.state, event.tangential_velocity)
        for event, end in zip(run.events, ends, strict=False)
        if event.state != State.FREE
    ]
    return [stay for stay in found if during is None or during[0] <= stay.start <= during[1]]


def sticks(run: History, during: Span | None = None) -> list[Stay]:
    """Return the stays in the state STICK, in the whole run or in a macro-collision."""
    return [stay for stay in stays(run, during) if stay.state == State.STICK]


def longest(found: Sequence[Stay]) -> tuple[float, float]:
    """Return start and duration (s) of the longest of some stays; NaN and 0 if there is none."""
    stay = max(found, key=lambda stay: stay.duration, default=None)
    return (stay.start, stay.duration) if stay else (NAN, 0.0)


def share_of_stick(run: History, among: Sequence[Span]) -> tuple[float, str]:
    """Return the part of the time in contact that some macro-collisions stick, and that in words."""
    contact = sum(stay.duration for during in among for stay in stays(run, during))
    found = [stay for during in among for stay in sticks(run, during)]
    if not found:
        return 0.0, "no stick"
    total, fastest = sum(stay.duration for stay in found), max(abs(stay.slip_rate) for stay in found)
    share = total / contact if contact > 0.0 else 0.0
    part = f"{number(1e6 * total, 3)} µs in all, {number(100.0 * share, 3)} % of the contact"
    speed = f"slip velocity as they begin up to {number(1e3 * fastest, 3)} mm/s"
    return share, f"{len(found)} stays judged as stick, {part}; {speed}"


def reversals(run: History, during: Span) -> list[float]:
    """Return the times (s) at which the direction of slip turned in contact during a macro-collision."""
    turned = [event.time for event in run.events if event.kind == EventKind.REVERSAL]
    return [time for time in turned if during[0] <= time <= during[1]]


# --- runs beside each other


def sampled(runs: Sequence[History], name: str, start: float, end: float) -> Array:
    """Return values (runs, points) of a variable, linear between samples, at many times from `start` to `end`."""
    times = np.linspace(start, end, _POINTS)
    return np.stack([np.interp(times, run["time"].values, run[name].values) for run in runs])


def force_difference(a: History, b: History, name: str, number: int) -> float:
    """Return the difference of a contact force during a macro-collision, 0 (the same) to 1 (no overlap at all).

    int |a - b| dt / int (|a| + |b|) dt over the time from the first touch to the last release in either run;
    NaN if one of them has no such macro-collision or there is no force.
    """
    if min(len(collisions(a)), len(collisions(b))) < number:
        return NAN
    first, second = collision(a, number), collision(b, number)
    x, y = sampled((a, b), name, min(first[0], second[0]), max(first[1], second[1]))
    total = float(np.sum(np.abs(x) + np.abs(y)))
    return float(np.sum(np.abs(x - y))) / total if total > 0.0 else NAN


def in_flight(models: Models, number: int) -> float | None:
    """Return the time (s) in the middle of the flight after macro-collision `number`; None if they overlap."""
    found = [collisions(run) for run in models]
    if min(map(len, found)) < number:
        return None
    last = max(own[number - 1][1] for own in found)
    first = min((own[number][0] for own in found if len(own) > number), default=models.end)
    return 0.5 * (last + first) if first > last else None
