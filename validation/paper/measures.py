"""The runs of the paper's case and of what it leaves open, and the numbers that claims are judged by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.history.history import History
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import compute_history as simulate

Array = NDArray[np.float64]
#: start and end (s)
Span = tuple[float, float]

NAN = float("nan")
#: s, the reversal in the first and the stick in the second macro-collision, in the paper
REVERSAL, STICK = 0.325, 0.699
#: times at which runs are compared
_POINTS = 20_001

#: contact.friction of the three models, in the order of the paper
MODELS = ("hybrid", "frictionless", "modified-coulomb")
#: the two schemes that integrate the same equations, and their names in the report
SCHEMES = {"fixed-step": "fixed-step, as printed", "event": "event-located"}

#: output intervals (s) for figures, whose curves are not to be aliased (a period of the second clamped mode is
#: 10 ms), and for numbers
FINE, COARSE = 1e-5, 1e-4

#: friction coefficient at which the tip sticks on the paper's own slope (stick needs about 10 there)
ROUGH = 12.0


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

    def before(self, name: str) -> Array:
        """Return the samples of a variable in the hybrid model before any of the runs touches the slope."""
        return within(self.hybrid, name, 0.0, self.before_contact)

    @property
    def after_first(self) -> float:
        """Time (s) at which the first macro-collision of all runs is over."""
        return max(collision(run, 1)[1] for run in self)

    @property
    def end(self) -> float:
        """Time (s) that all runs reach."""
        return min(run.end_time for run in self)


def paper(scheme: str, model: str = "hybrid", output_interval: float = COARSE, **changes: Any) -> Scenario:
    """Return the paper's case by a scheme and a friction law."""
    case = Scenario.builtin("paper").replace(solver__output_interval=output_interval, **changes)
    return _marched(case, scheme, model)


def _marched(case: Scenario, scheme: str, model: str) -> Scenario:
    """Return a case by a scheme and a law; fixed steps judge stick as printed (Sec. 5.3), by the force alone."""
    stick = {"solver__stick": "force"} if (scheme, model) == ("fixed-step", "hybrid") else {}
    return case.adapted(contact__friction=model, solver__scheme=scheme, **stick)


def cases() -> dict[str, Scenario]:
    """Return the scenarios that are drawn and judged, by group/scheme/model.

    `paper` is behind figures 2 to 16.  `sticking` (a steep rough slope) and `rough` (the paper's slope with much
    friction) stick.
    """
    steep = Scenario.builtin("sticking").replace(solver__output_interval=COARSE)
    friction: dict[str, Any] = {"contact__mu_static": ROUGH, "contact__mu_kinetic": ROUGH}
    rough = paper("event", **friction, discretization__frame="mean-axis", discretization__modes=3)
    found = {f"paper/{scheme}/{model}": paper(scheme, model, FINE) for scheme, model in product(SCHEMES, MODELS)}
    for (group, scenario), scheme, model in product(
        {"sticking": steep, "rough": rough}.items(), SCHEMES, ("hybrid", "modified-coulomb")
    ):
        found[f"{group}/{scheme}/{model}"] = _marched(scenario, scheme, model)
    return found


def combinations() -> list[dict[str, Any]]:
    """Return all combinations of modes, g, shortening and Baumgarte's form, each as `paper` takes it.

    The form matters to the fixed-step scheme only: located contacts have nothing to stabilize.
    """
    names = ("scheme", "discretization__modes", "gravity", "contact__shortening", "solver__baumgarte_form")
    grid = product(SCHEMES, (1, 2, 3, 4), (9.8, 9.81), (True, False), ("squared", "plain"))
    found = [dict(zip(names, point, strict=True)) for point in grid]
    return [c for c in found if c["scheme"] == "fixed-step" or c["solver__baumgarte_form"] == "squared"]


def run_light(scenario: Scenario) -> History:
    """Simulate a scenario; returns its history with the total `energy` (J).

    What varies along the beam is left out: it would not fit in memory.
    """
    history = simulate(scenario)
    return replace(history, data=history.data.drop_dims("station").assign(energy=history.total_energy))


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


def stays(run: History, during: Span) -> list[Stay]:
    """Return the stays in contact that begin in a span of time."""
    ends = [event.time for event in run.events[1:]] + [run.end_time]
    return [
        Stay(event.time, end, event.state, event.tangential_velocity)
        for event, end in zip(run.events, ends, strict=False)
        if event.state != State.FREE and during[0] <= event.time <= during[1]
    ]


def sticks(run: History, during: Span | None = None) -> list[Stay]:
    """Return the stays in the state STICK that begin in a span of time, or in the whole run."""
    return [stay for stay in stays(run, during or (0.0, run.end_time)) if stay.state == State.STICK]


def longest(found: Sequence[Stay]) -> tuple[float, float]:
    """Return start and duration (s) of the longest of some stays; NaN and 0 if there is none."""
    stay = max(found, key=lambda stay: stay.duration, default=None)
    return (stay.start, stay.duration) if stay else (NAN, 0.0)


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
