"""Quantities of interest: one number of a run each, with its unit, or the reason why the run does not have it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.validity.small_deflection import contact_force_error, deflection_error, largest_motion
from oblique_impact.beam_problem import beam_of
from oblique_impact.contact.state import State
from oblique_impact.errors import InputError, Outcome
from oblique_impact.history.history import History
from oblique_impact.history.interpolation import RATES, value_at
from oblique_impact.history.variables import OF_A_BEAM, OF_A_SYSTEM, SECTION_FORCES
from oblique_impact.scenario.messages import counted, did_you_mean
from oblique_impact.scenario.scenario import Scenario


class UnknownQuantityError(InputError):
    """Raised for a name that is no quantity."""


class GapError(Exception):
    """Raised when a run does not have a quantity; the message says why."""


@dataclass(frozen=True)
class Quantity:
    """A number that every run of a study is asked for."""

    name: str
    #: SI unit, "1" for counts
    unit: str
    meaning: str
    #: takes a History, returns the number, raises GapError
    measure: Callable[[History], float] = field(repr=False)
    #: the macro-collision, from 1, whose end (start, if it is a start) decides about it; 0: none
    collision: int = 0


#: variables over time that `VARIABLE@TIME` knows: unit and meaning
VARIABLES = {
    name: (variable.units, variable.long_name)
    for name, variable in (OF_A_BEAM | OF_A_SYSTEM).items()
    if variable.dimensions == ("time",) and name not in ("time", "state")
} | {"energy": ("J", "kinetic, elastic and gravity energy")}
#: variables over time and along the beam, for the extremes besides
FIELDS = {name: (variable.units, variable.long_name) for name, variable in SECTION_FORCES.items()}
#: among the samples: words, and what finds them
_EXTREMES: dict[str, tuple[str, Callable[[np.ndarray], float]]] = {
    "max": ("largest", np.nanmax),
    "min": ("least", np.nanmin),
    "peak": ("largest magnitude of", lambda values: np.nanmax(np.abs(values))),
}
_SAME_TIME = 1e-12  # s; a multiple of the output interval in floating point


def quantity(name: str, end_time: float = math.inf) -> Quantity:
    """Return the quantity of a name; `end_time` (s) bounds the TIME of `VARIABLE@TIME`.

    Raises InputError with one line that lists the known ones.
    """
    if name in _NAMED:
        return _NAMED[name]
    variable, at, moment = name.partition("@")
    if at and variable in VARIABLES:
        return _sampled(name, variable, moment, end_time)
    extreme, colon, variable = name.partition(":")
    if colon and extreme in _NUMBERED and variable.isdecimal() and 1 <= int(variable) <= _LAST:
        unit, meaning, measure = _NUMBERED[extreme]
        return Quantity(name, unit, meaning.format(variable), measure(int(variable) - 1))
    if colon and extreme == "lost_after":
        return _lost_after(name, variable)
    known = {**VARIABLES, **FIELDS}
    if colon and extreme in _EXTREMES and variable in known:
        unit, meaning = known[variable]
        words, find = _EXTREMES[extreme]
        of_samples = f"{words} {meaning} among the samples"
        return Quantity(name, unit, of_samples, lambda history: float(find(_values(history, variable))))
    known_names = [*_NAMED, *(f"{v}{at}{moment}" for v in VARIABLES), *(f"{extreme}:{v}" for v in known)]
    raise UnknownQuantityError(
        f"--quantity {name}: known are {', '.join(_NAMED)}; VARIABLE@TIME or VARIABLE@end with "
        f"{', '.join(VARIABLES)}; max:VARIABLE, min:VARIABLE and peak:VARIABLE (the largest magnitude) with these "
        f"and {', '.join(FIELDS)}; "
        f"{', '.join(f'{kind}:N' for kind in _NUMBERED)} with N from 1 to {_LAST}; lost_after:SECONDS"
        f"{did_you_mean(name, known_names)}"
    )


def quantity_table() -> pd.DataFrame:
    """Return the quantities that a study can be asked for, a row each: name, unit, meaning.

    VARIABLE is a variable of a history over time or `energy`, for `max:`, `min:` and `peak:` also one of the
    section forces along the beam; TIME and SECONDS are in s, N counts from 1.

    Examples
    --------
    >>> quantity_table().loc["impulse", "unit"]
    'N s'
    """
    rows = [(found.name, found.unit, found.meaning) for found in _NAMED.values()]
    rows += [(f"{name}:N", unit, text.format("N")) for name, (unit, text, _) in _NUMBERED.items()]
    rows += [
        ("VARIABLE@TIME", "of the variable", "a variable at a time"),
        ("VARIABLE@end", "of the variable", "a variable at the end"),
        ("max:VARIABLE", "of the variable", "largest value among the samples"),
        ("min:VARIABLE", "of the variable", "least value among the samples"),
        ("peak:VARIABLE", "of the variable", "largest magnitude among the samples"),
        ("lost_after:SECONDS", "J", "energy that the beam has lost so long after the first touch-down"),
    ]
    return pd.DataFrame(rows, columns=["quantity", "unit", "meaning"]).set_index("quantity")


def default_quantities(scenario: Scenario) -> tuple[str, ...]:
    """Names of the quantities asked for if the user names none."""
    if scenario.contact.enabled:
        # the force of a rigid stop has no largest value in the limit
        force = () if scenario.contact.normal == "rigid" else ("peak_force",)
        return ("first_impact", "collision_end", "impulse", *force, "energy_final", "second_impact")
    return ("theta@end", "tip_x@end", "tip_y@end", "deflection@end", "energy_kinetic@end", "energy_elastic@end")


#: what has no limit with an entry of `without_limit`, and why
_WITH = {
    "peak_force": (
        ("peak_force", "max:lambda_n", "peak:lambda_n", "max:lambda_tau", "min:lambda_tau", "peak:lambda_tau"),
        "the force of a rigid stop grows with every mode or element",
    ),
    "tangential_impulse": (
        ("tangential_impulse", "max:lambda_tau", "min:lambda_tau", "peak:lambda_tau"),
        "friction along a beam that cannot stretch does not converge in time-stepping",
    ),
}


def not_determined(names: Sequence[str], history: History) -> dict[str, str]:
    """Return the quantities among `names` that have no limit as modes or elements are added, with the reason.

    What follows the first touch-down is not determined where the run says so in its summary; under a damped beam
    it is the force of a rigid stop alone, and what friction does along a beam that cannot stretch.
    """
    if not history.macro_collisions:
        return {}
    limits = history.summary.get("without_limit", ())
    if "start" in limits:
        touch_down = float(history.macro_collisions[0]["start"])
        why = "what follows the first touch-down is not determined, see the warning"
        return {name: why for name in names if decided_at(name, history) > touch_down}
    lost = {name: why for entry, (with_it, why) in _WITH.items() if entry in limits for name in with_it}
    return {name: lost[name] for name in names if name in lost}


def decided_at(name: str, history: History) -> float:
    """Time (s) at which the value of a quantity in a run is decided; infinite if the rest of the run has a say."""
    _, at, moment = name.partition("@")
    if at:
        return math.inf if moment == "end" else float(moment)
    kind, _, part = name.partition(":")
    if kind in _EXTREMES:
        values = _values(history, part)
        values = np.abs(values) if kind == "peak" else values
        where = np.argwhere(values == _EXTREMES[kind][1](values))  # none among samples without section forces
        return float(history["time"].values[where[0, 0]]) if len(where) else math.inf
    if name == "unaccounted":  # the error of the balance, which goes to zero
        return -math.inf
    number = int(part) if kind in _NUMBERED else _NAMED[name].collision if name in _NAMED else 0
    try:
        if kind == "event":
            return _event_time(history, number - 1)
        if kind in ("start", "first_impact", "second_impact"):
            return _start(history, number - 1)
        # behind the jump of an impact that is a collision by itself
        return math.nextafter(_collision(history, number - 1)["end"], math.inf) if number else math.inf
    except GapError:
        return math.inf


def is_of_samples(name: str) -> bool:
    """Return whether a quantity is the extreme of a variable among the samples, which lies between two of them."""
    return name.partition(":")[0] in _EXTREMES


def natural_scale(unit: str, scenario: Scenario, energy: float) -> float:
    """Scale by which a small value of this unit is measured: the length of the beam, the energy (J) of the run."""
    return {"m": scenario.beam.length, "J": energy}.get(unit, 0.0)


# --- variables


def _sampled(name: str, variable: str, moment: str, end_time: float) -> Quantity:
    """Return the quantity VARIABLE@MOMENT."""
    unit, meaning = VARIABLES[variable]
    if moment == "end":
        return Quantity(name, unit, f"{meaning} at the end", lambda history: _at(history, variable, math.inf))
    time = _seconds(moment)
    if not 0.0 <= time <= end_time:
        upper = f" {end_time:g}" if math.isfinite(end_time) else ""
        raise InputError(f"--quantity {name}: the time should be from 0 to end_time{upper} (s), or end")
    return Quantity(name, unit, f"{meaning} at {time:g} s", lambda history: _at(history, variable, time))


def _lost_after(name: str, seconds: str) -> Quantity:
    """Return the quantity lost_after:SECONDS."""
    delay = _seconds(seconds)
    if not 0.0 <= delay < math.inf:
        raise InputError(f"--quantity {name}: the time after the first touch-down should be at least 0 (s)")

    def measure(history: History) -> float:
        return float(history.total_energy.values[0]) - _at(history, "energy", _start(history) + delay)

    meaning = f"energy that the beam has lost {delay:g} s after the first touch-down"
    return Quantity(name, "J", meaning, measure)


def _seconds(text: str) -> float:
    """Read a time (s), NaN of a text that is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


def _values(history: History, variable: str) -> np.ndarray:
    if variable == "energy":
        return np.asarray(history.total_energy.values, dtype=float)
    data = history.section_forces() if variable in FIELDS else history
    return np.asarray(data[variable].values, dtype=float)


def _at(history: History, variable: str, time: float) -> float:
    """Value at a time (s, infinite: the end), after the jump if there is one; between samples by a cubic."""
    times, values = history["time"].values, _values(history, variable)
    if math.isinf(time):
        _require_completed(history)
        return float(values[-1])
    if time > times[-1] + _SAME_TIME:
        raise GapError(f"ended at {times[-1]:.4g} s: {history.outcome.label}")
    near = np.flatnonzero(np.abs(times - time) <= _SAME_TIME)
    if near.size:
        return float(values[near[-1]])
    rates = _values(history, RATES[variable]) if variable in RATES else None
    return float(value_at(times, values, rates, time))


def _require_completed(history: History) -> None:
    if history.outcome is not Outcome.COMPLETED:
        raise GapError(f"stopped at {history.end_time:.4g} s: {history.outcome.label}")


# --- macro-collisions, by their numbers from 0


def _start(history: History, number: int = 0) -> float:
    """Return the start of a macro-collision (s)."""
    found = history.macro_collisions
    if len(found) > number:
        return float(found[number]["start"])
    what = "no contact"
    if found:
        what = "no second impact" if number == 1 else f"no macro-collision {number + 1}, only {len(found)},"
    if history.outcome is Outcome.COMPLETED:
        raise GapError(f"{what} before end_time")
    raise GapError(f"{what} before it stopped at {history.end_time:.4g} s: {history.outcome.label}")


def _collision(history: History, number: int = 0) -> dict[str, Any]:
    """Return a macro-collision that has ended."""
    _start(history, number)
    collision = history.macro_collisions[number]
    if len(history.macro_collisions) == number + 1:
        end, completed = history.end_time, history.outcome is Outcome.COMPLETED
        if not completed and end - collision["end"] < history.clustering_time:
            raise GapError(f"stopped at {end:.4g} s, within the collision: {history.outcome.label}")
        if history["state"].values[-1] != State.FREE:
            raise GapError("still in contact at end_time")
    return collision


def _duration(history: History) -> float:
    return float(_collision(history)["end"]) - _start(history)


def _energy_after(history: History) -> float:
    return _at(history, "energy", float(_collision(history)["end"]))


def _nearest_place(history: History) -> float:
    """Return the least place along the beam (m) that touches in the first macro-collision."""
    end = _collision(history)["end"]
    return min(contact.first_place for contact in history.contacts if contact.start <= end)


def _restitution(history: History) -> float:
    collision, times = _collision(history), history["time"].values
    start, end = (np.flatnonzero(np.abs(times - collision[key]) <= _SAME_TIME) for key in ("start", "end"))
    before, after = _mean_spin(history, int(start[0])), _mean_spin(history, int(end[-1]))
    if not before:
        raise GapError("the beam does not turn before the collision")
    return -after / before


def _mean_spin(history: History, sample: int) -> float:
    """Angular momentum about the pin over moment of inertia (rad/s), to first order in the deflection.

    That is theta' + S B'/J (theory, Sec. 2), with what turns with sections; in the mean-axis frame S B = 0.
    """
    scenario = history.scenario
    if scenario is None or scenario.root.kind != "pin":
        raise GapError("only for a beam on a pin, which carries all of its angular momentum")
    spin = float(history["theta_dot"].values[sample])
    if scenario.discretization.frame == "mean-axis":
        return spin
    sections, x = Sections.from_scenario(scenario), history["station"].values
    rate = history["uy_dot"].values[sample]
    moment = float(simpson(sections.mass_per_length(x) * x * rate, x=x))
    along = CubicSpline(x, rate)
    moment += float((sections.point_masses * sections.places) @ along(sections.places))
    moment += float(sections.point_inertias @ along(sections.places, 1))
    return spin + moment / sections.whole_inertia


def _model_error(history: History) -> float:
    """Estimate of :mod:`oblique_impact.beam.validity.small_deflection`."""
    scenario = history.scenario
    if scenario is None or scenario.is_absolute:
        raise GapError("only for the small-deflection model of the floating frame")
    variables = {name: history[name].values for name in ("uy", "theta_dot", "q", "qd")}
    motion = largest_motion(beam_of(scenario), variables)
    if scenario.contact.enabled:
        return contact_force_error(scenario, motion)
    return deflection_error(scenario, motion)


def _of_period(key: str) -> Callable[[History], float]:
    """Return what measures an entry of the periodic response, see `validation.studies.periodic`."""

    def measure(history: History) -> float:
        _require_completed(history)
        if "periodic" not in history.summary:
            raise GapError("only of a periodic response")
        return float(history.summary["periodic"][key] or 0)

    return measure


def _event_time(history: History, number: int) -> float:
    if len(history.events) <= number:
        raise GapError(f"has {counted(len(history.events), 'event')}")
    return float(history.events[number].time)


def _ledger(*keys: str) -> Callable[[History], float]:
    """Return what measures a sum of entries of the energy balance."""

    def measure(history: History) -> float:
        _require_completed(history)
        return float(sum(history.balance[key] for key in keys))

    return measure


def _of_collision(key: str, number: int = 0) -> Callable[[History], float]:
    """Return what measures an entry of a macro-collision."""
    return lambda history: float(_collision(history, number)[key])


#: of the N-th macro-collision or event: unit, meaning, what returns the measure of a number from 0
_NUMBERED: dict[str, tuple[str, str, Callable[[int], Callable[[History], float]]]] = {
    "start": ("s", "start of macro-collision {}", lambda number: partial(_start, number=number)),
    "collision_impulse": ("N s", "normal impulse of macro-collision {}", partial(_of_collision, "normal_impulse")),
    "collision_contacts": ("1", "contacts of macro-collision {}", partial(_of_collision, "contacts")),
    "event": ("s", "time of event {}", lambda number: partial(_event_time, number=number)),
}
_LAST = 9999

_LOSSES = ("lost_impact", "lost_friction", "lost_damping", "lost_scheme")
_FIRST, _SECOND = "of the first macro-collision", "of the second macro-collision"
_BOUNCE = f"effective restitution {_FIRST}: minus the mean spin after it over that before it"
_PERIOD = "period of the response in periods of what drives it, none if it does not repeat"
_IMPACTS = "contacts that begin in the periodic response, per period of what drives it"
_MODEL_ERROR = (
    "estimated relative error of the small-deflection model: with contact of the largest force, else of the "
    "deflection within two elastic periods"
)
_NAMED = {
    q.name: q
    for q in (
        Quantity("first_impact", "s", "first touch-down", _start, 1),
        Quantity("collision_end", "s", f"end {_FIRST}", _of_collision("end"), 1),
        Quantity("collision_duration", "s", f"length {_FIRST}", _duration, 1),
        Quantity("impulse", "N s", f"normal impulse {_FIRST}", _of_collision("normal_impulse"), 1),
        Quantity(
            "tangential_impulse", "N s", f"tangential impulse {_FIRST}", _of_collision("tangential_impulse"), 1
        ),
        Quantity("peak_force", "N", f"largest normal force {_FIRST}", _of_collision("peak_force"), 1),
        Quantity("contacts", "1", f"contacts {_FIRST}", _of_collision("contacts"), 1),
        Quantity("zone", "m", f"least place along the beam that touches something {_FIRST}", _nearest_place, 1),
        Quantity("energy_after_collision", "J", f"energy at the end {_FIRST}", _energy_after, 1),
        Quantity("restitution", "1", _BOUNCE, _restitution, 1),
        Quantity("second_impact", "s", f"start {_SECOND}", partial(_start, number=1), 2),
        Quantity("second_impulse", "N s", f"normal impulse {_SECOND}", _of_collision("normal_impulse", 1), 2),
        Quantity("energy_final", "J", "energy at the end", _ledger("final")),
        Quantity("lost_impact", "J", "energy lost in impacts", _ledger("lost_impact")),
        Quantity("lost_friction", "J", "energy lost in friction", _ledger("lost_friction")),
        Quantity("lost_damping", "J", "energy lost in damping", _ledger("lost_damping")),
        Quantity("lost_scheme", "J", "energy the scheme takes", _ledger("lost_scheme")),
        Quantity("unaccounted", "J", "energy the ledger cannot explain", _ledger("unaccounted")),
        Quantity("energy_lost", "J", "energy lost in impacts, friction, damping and scheme", _ledger(*_LOSSES)),
        Quantity("supplied", "J", "work of the base, of drives and torques", _ledger("supplied")),
        Quantity("period", "1", _PERIOD, _of_period("period")),
        Quantity("transient", "1", "periods of what drives it until then", _of_period("transient")),
        Quantity("impacts_per_period", "1", _IMPACTS, _of_period("impacts_per_period")),
        Quantity("events", "1", "transitions of the whole run", lambda history: float(len(history.events))),
        Quantity("model_error", "1", _MODEL_ERROR, _model_error),
    )
}
