"""One run as figures, claims and tables need it: what varies along the beam is left out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.history.history import History
from oblique_impact.history.summary import MacroCollision
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import simulate
from oblique_impact.validation.reproduction.cases import Case
from oblique_impact.validation.reproduction.sticking import StickCheck, along_contact, at_events


class MissingError(Exception):
    """Raised where a run does not have what is asked for; the message says what that is."""


class Stay(NamedTuple):
    """One stay in a state of contact: when (s), and how fast the tip moved as it began (m/s).

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


@dataclass(frozen=True)
class Run:
    """One run.

    Attributes
    ----------
    key : str
        Name of the case.
    history : History
        Variables over time, besides those of a history `kinetic`, `elastic`, `gravity` and total `energy` (J), the
        rates of the contact point's displacements in the floating frame (m/s), and if asked for the forces of the
        sticking solution (N).
    checks : list of StickCheck
        The sticking solution wherever the slip velocity vanished or stick was judged, if asked for.
    """

    key: str
    history: History
    checks: list[StickCheck]

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return the samples of one variable."""
        return np.asarray(self.history.data[name].values)

    def at(self, name: str, time: float) -> float:
        """Value at a time (s)."""
        return float(self.history.at(time)[name])

    @cached_property
    def scenario(self) -> Scenario:
        """What was simulated."""
        return Scenario.from_toml(self.history.scenario_toml)

    @property
    def energy(self) -> dict[str, float]:
        """The energy ledger (J)."""
        ledger: dict[str, float] = self.history.summary["energy"]
        return ledger

    @cached_property
    def macros(self) -> list[MacroCollision]:
        """Macro-collisions in order of time."""
        return [MacroCollision(**macro) for macro in self.history.macro_collisions]

    @property
    def end_time(self) -> float:
        """Last time (s)."""
        return float(self["time"][-1])

    def macro(self, number: int) -> MacroCollision:
        """Return the macro-collision `number` (1 is the first); raises MissingError if there are fewer."""
        if len(self.macros) < number:
            raise MissingError("no collision" if number == 1 else "no second collision")
        return self.macros[number - 1]

    @cached_property
    def stays(self) -> list[Stay]:
        """Stays in contact and rebounds, one that lasts to the end included."""
        events = self.history.events
        ends = [event.time for event in events[1:]] + [self.end_time]
        return [
            Stay(
                event.time,
                event.time if event.state == State.FREE else end,
                event.state,
                event.tangential_velocity,
            )
            for event, end in zip(events, ends, strict=False)
            if event.state != State.FREE or event.kind.impulsive
        ]

    @cached_property
    def sticks(self) -> list[Stay]:
        """Every stay in the state STICK."""
        return [stay for stay in self.stays if stay.state == State.STICK]

    def stays_in(self, macro: MacroCollision) -> list[Stay]:
        """Stays in contact and rebounds during a macro-collision."""
        return [stay for stay in self.stays if macro.start <= stay.start <= macro.end]

    def sticks_in(self, macro: MacroCollision) -> list[Stay]:
        """Stays in the state STICK during a macro-collision."""
        return [stay for stay in self.stays_in(macro) if stay.state == State.STICK]

    def reversals_in(self, macro: MacroCollision) -> list[float]:
        """Return the times (s) at which the direction of slip turned in contact during a macro-collision."""
        turned = [event.time for event in self.history.events if event.kind == EventKind.REVERSAL]
        return [time for time in turned if macro.start <= time <= macro.end]

    def inside(self, start: float, end: float) -> NDArray[np.bool_]:
        """Return which samples lie in a window of time."""
        return np.asarray((self["time"] >= start) & (self["time"] <= end))


def run_case(case: Case) -> Run:
    """Simulate a case and read everything off its history."""
    history = simulate(case.scenario)
    tip = history.data.sel(station=case.scenario.contact.point, method="nearest")
    found: dict[str, Any] = {
        **{part: history[f"energy_{part}"] for part in ("kinetic", "elastic", "gravity")},
        "energy": history.total_energy,
        "shortening_rate": ("time", tip["ux_dot"].values),
        "deflection_rate": ("time", tip["uy_dot"].values),
    }
    if case.sticking:
        found |= {name: ("time", values) for name, values in along_contact(case.scenario, history).items()}
    checks = at_events(case.scenario, history) if case.sticking else []
    data: xr.Dataset = history.data.drop_dims(["station", "coordinate"]).assign(found)
    return Run(case.key, replace(history, data=data), checks)
