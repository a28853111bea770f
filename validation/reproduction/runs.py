"""What is read off a history: samples, events and macro-collisions, light enough to send between processes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.history.history import History
from oblique_impact.marching.records import Event
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import simulate
from validation.reproduction.cases import Case
from validation.reproduction.sticking import StickCheck, along_contact, at_events

Array = NDArray[np.float64]

#: our names of the variables that are plotted, from those of the history
_VARIABLES = (
    "gap",
    "slip",
    "gap_rate",
    "slip_rate",
    "lambda_n",
    "lambda_tau",
    "theta",
    "theta_dot",
    "tip_x",
    "tip_y",
    "tip_vx",
    "tip_vy",
    "deflection",
    "shortening",
)


class Macro(NamedTuple):
    """One macro-collision (SI units)."""

    start: float
    end: float
    contacts: int
    normal_impulse: float
    tangential_impulse: float
    peak_force: float

    @property
    def middle(self) -> float:
        """Middle between first touch and last release (s)."""
        return 0.5 * (self.start + self.end)


class Stick(NamedTuple):
    """One stay in the state STICK: when (s), and how fast the tip moved as it began (m/s)."""

    start: float
    end: float
    slip_rate: float

    @property
    def duration(self) -> float:
        """Length (s)."""
        return self.end - self.start


@dataclass(frozen=True)
class Run:
    """One run: everything figures, claims and tables need.

    Attributes
    ----------
    key : str
        Name of the case.
    scenario : Scenario
        What was simulated.
    outcome : str
        How it ended.
    arrays : dict
        Samples (samples,) by name, SI units, `time` and `state` among them.
    events : list of Event
        The event log.
    macros : list of Macro
        Macro-collisions in order of time.
    energy : dict
        The energy ledger (J).
    checks : list of StickCheck
        The sticking solution wherever the slip velocity vanished or stick was judged, if asked for.
    """

    key: str
    scenario: Scenario
    outcome: str
    arrays: dict[str, Array]
    events: list[Event]
    macros: list[Macro]
    energy: dict[str, float]
    checks: list[StickCheck]

    def __getitem__(self, name: str) -> Array:
        """Return the samples of one variable."""
        return self.arrays[name]

    def at(self, name: str, times: Any) -> Array:
        """Values at given times, linear between the samples."""
        return np.asarray(np.interp(times, self["time"], self[name]))

    @cached_property
    def end_time(self) -> float:
        """Last time (s)."""
        return float(self["time"][-1])

    def macro(self, number: int) -> Macro | None:
        """Return the macro-collision `number` (1 is the first), None if there are fewer."""
        return self.macros[number - 1] if len(self.macros) >= number else None

    @cached_property
    def sticks(self) -> list[Stick]:
        """Every stay in the state STICK, one that lasts to the end included."""
        return [
            Stick(event.time, end, event.tangential_velocity)
            for event, end in stays(self.events, self.end_time)
            if event.state == State.STICK
        ]

    def sticks_in(self, macro: Macro) -> list[Stick]:
        """Stays in the state STICK during a macro-collision."""
        return [stick for stick in self.sticks if macro.start <= stick.start <= macro.end]

    def reversals_in(self, macro: Macro) -> list[float]:
        """Return the times (s) at which the direction of slip turned in contact during a macro-collision."""
        turned = [event.time for event in self.events if event.kind == EventKind.REVERSAL]
        return [time for time in turned if macro.start <= time <= macro.end]

    def contact_time(self, macro: Macro) -> float:
        """Time (s) in contact during a macro-collision."""
        total, since = 0.0, None
        for event in self.events:
            if not macro.start <= event.time <= macro.end:
                continue
            if since is None and event.state != State.FREE:
                since = event.time
            elif since is not None and event.state == State.FREE:
                total, since = total + event.time - since, None
        return total if since is None else total + macro.end - since

    def inside(self, start: float, end: float) -> NDArray[np.bool_]:
        """Return which samples lie in a window of time."""
        return np.asarray((self["time"] >= start) & (self["time"] <= end))

    def only(self, *names: str) -> Run:
        """Return the run with some of its arrays."""
        kept = {name: self.arrays[name] for name in ("time", "state", *names)}
        return Run(self.key, self.scenario, self.outcome, kept, self.events, self.macros, self.energy, self.checks)


def stays(events: list[Event], end: float) -> list[tuple[Event, float]]:
    """Return each event with the time (s) of the next one, the last with `end`: how long its state lasts."""
    following = [event.time for event in events[1:]] + [end]
    return list(zip(events, following[: len(events)], strict=True))


def run_case(case: Case) -> Run:
    """Simulate a case and read everything off it."""
    return read(case, simulate(case.scenario))


def run_contact(case: Case) -> Run:
    """Simulate a case; only what describes its contact is kept."""
    return run_case(case).only("energy")


def read(case: Case, history: History) -> Run:
    """Read a history."""
    arrays: dict[str, Array] = {name: history[name].values for name in _VARIABLES}
    arrays["time"] = history["time"].values
    arrays["state"] = history["state"].values.astype(float)
    for part in ("kinetic", "elastic", "gravity"):
        arrays[part] = history[f"energy_{part}"].values
    arrays["energy"] = arrays["kinetic"] + arrays["elastic"] + arrays["gravity"]
    arrays |= _floating_rates(case.scenario, arrays)
    checks: list[StickCheck] = []
    if case.sticking:
        arrays |= along_contact(case.scenario, history)
        checks = at_events(case.scenario, history)
    macros = [Macro(**macro) for macro in history.summary["macro_collisions"]]
    energy = dict(history.summary["energy"])
    return Run(case.key, case.scenario, history.outcome.label, arrays, history.events, macros, energy, checks)


def _floating_rates(scenario: Scenario, arrays: dict[str, Array]) -> dict[str, Array]:
    """Rates (m/s) of the contact point's displacements in the floating frame, from its inertial velocity."""
    sine, cosine, spin = np.sin(arrays["theta"]), np.cos(arrays["theta"]), arrays["theta_dot"]
    arm = scenario.root.hub_radius + scenario.contact.point + arrays["shortening"]
    axial = cosine * arrays["tip_vx"] + sine * arrays["tip_vy"]
    transverse = -sine * arrays["tip_vx"] + cosine * arrays["tip_vy"]
    return {
        "shortening_rate": axial + spin * arrays["deflection"],
        "deflection_rate": transverse - spin * arm,
    }
