"""The summary of a run, as in summary.json: outcome, macro-collisions, energy balance, costs, versions.

The balance of energy says what impact, friction, damping and the scheme took, and what does not add up:

    initial + supplied - lost_impact - lost_friction - lost_damping - lost_scheme - final = unaccounted

Losses are integrated along with the motion (friction, damping, stabilization) or summed over the
impacts; energies are evaluated from the states.  `unaccounted` is therefore a check on both.
"""

from __future__ import annotations

import json
import math
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from oblique_impact.errors import InputError, Outcome
from oblique_impact.history.provenance import provenance
from oblique_impact.history.samples import Samples
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.equations import (
    DAMPING_LOSS,
    FRICTION_LOSS,
    STABILIZATION_LOSS,
    STOP_LOSS,
    SUPPLIED,
)
from oblique_impact.marching.records import Contact, Event, Record
from oblique_impact.scenario.scenario import Scenario

#: s; the gap of histories that do not record one: it was the same for all beams
EARLIER_MACRO_GAP = 0.03
_REPORTED_PACKAGES = ("oblique-impact", "numpy", "scipy", "numba", "scikit-fem", "xarray")
_OUTCOMES = tuple(outcome.label for outcome in Outcome)


@dataclass(frozen=True)
class Ledger:
    """Energy balance of a run (J); `kinetic`, `elastic`, `gravity`, `contact` are the parts of `final`."""

    initial: float
    final: float
    kinetic: float
    elastic: float
    gravity: float
    contact: float
    supplied: float
    lost_impact: float
    lost_friction: float
    lost_damping: float
    lost_scheme: float
    unaccounted: float


def balance(
    initial: float, parts: tuple[float, float, float, float], quadratures: Array, events: list[Event]
) -> Ledger:
    """Close the balance of a run.

    Parameters
    ----------
    initial : float
        Energy at the start (J).
    parts : tuple
        Kinetic, elastic, gravity and contact energy at the end (J).
    quadratures : ndarray, shape (7,)
        The integrals carried along with the motion, at the end.
    events : list of Event
        The event log.
    """
    final = sum(parts)
    supplied = float(quadratures[SUPPLIED])
    impact = sum(event.energy_loss for event in events if event.kind.impulsive)
    friction = float(quadratures[FRICTION_LOSS])
    damping = float(quadratures[DAMPING_LOSS] + quadratures[STOP_LOSS])
    scheme = float(quadratures[STABILIZATION_LOSS])
    return Ledger(
        initial=initial,
        final=final,
        kinetic=parts[0],
        elastic=parts[1],
        gravity=parts[2],
        contact=parts[3],
        supplied=supplied,
        lost_impact=impact,
        lost_friction=friction,
        lost_damping=damping,
        lost_scheme=scheme,
        unaccounted=initial + supplied - impact - friction - damping - scheme - final,
    )


@dataclass(frozen=True)
class MacroCollision:
    """Contacts that follow each other within the macro gap (SI units)."""

    start: float
    end: float
    contacts: int
    normal_impulse: float
    tangential_impulse: float
    peak_force: float


def macro_collisions(contacts: Sequence[Contact], macro_gap: float) -> list[MacroCollision]:
    """Group contacts in order of time that are less than `macro_gap` (s) apart.

    Impulses add up, the peak is the largest finite force.
    """
    groups: list[list[Contact]] = []
    for contact in contacts:
        if groups and contact.start - groups[-1][-1].end < macro_gap:
            groups[-1].append(contact)
        else:
            groups.append([contact])
    return [
        MacroCollision(
            start=group[0].start,
            end=group[-1].end,
            contacts=len(group),
            normal_impulse=sum(c.normal_impulse for c in group),
            tangential_impulse=sum(c.tangential_impulse for c in group),
            peak_force=max(c.peak_force for c in group),
        )
        for group in groups
    ]


def summarize(
    record: Record,
    samples: Samples,
    wall: float,
    macro_gap: float,
    scenario: Scenario | None = None,
) -> dict[str, Any]:
    """Return summary.json of a run, without what only a beam has: clearance and warnings.

    Parameters
    ----------
    record : Record
        What the loop left.
    samples : Samples
        All samples of the run.
    wall : float
        Wall time of the marching (s).
    macro_gap : float
        Contacts less than this apart (s) are one macro-collision.
    scenario : Scenario, optional
        Names the user-defined parts for the provenance.
    """
    first, last = samples.part(slice(1)), samples.part(slice(-1, None))
    ledger = balance(
        float(first.kinetic[0] + first.elastic[0] + first.gravity[0]),
        (float(last.kinetic[0]), float(last.elastic[0]), float(last.gravity[0]), record.stored),
        last.quadratures[0],
        record.events,
    )
    return {
        "outcome": record.outcome.label,
        "message": record.outcome.sentence,
        "end_time": float(last.time[0]),
        "macro_gap": macro_gap,
        "macro_collisions": [asdict(m) for m in macro_collisions(record.contacts, macro_gap)],
        "events": len(record.events),
        "energy": asdict(ledger),
        "steps": record.steps,
        "rejected_steps": record.rejected,
        "wall_time": wall,
        "versions": {"python": platform.python_version(), **_versions()},
        "provenance": dict(provenance(scenario)),
    }


def _versions() -> dict[str, str]:
    found = {}
    for name in _REPORTED_PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def read_json(text: Any, name: str, kind: type) -> Any:
    """Return the JSON of an attribute, a list or a dict; raises InputError, in a few words."""
    try:
        found = json.loads(str(text))
    except (ValueError, RecursionError):
        raise InputError(f"attribute {name}: is not JSON") from None
    if not isinstance(found, kind):
        raise InputError(f"attribute {name}: should be a {kind.__name__}")
    return found


def check_summary(summary: dict[str, Any], first: float, last: float) -> None:
    """Raise InputError for a summary that lacks what it should have, or has something else there."""
    if summary.get("outcome") not in _OUTCOMES:
        raise InputError(f"attribute summary: outcome should be one of {', '.join(_OUTCOMES)}")
    _check_numbers(summary, ("end_time", "events", "steps", "wall_time"), "summary")
    _check_numbers({"macro_gap": EARLIER_MACRO_GAP, **summary}, ("macro_gap",), "summary")
    collisions = summary.get("macro_collisions")
    if not isinstance(collisions, list) or not all(isinstance(item, dict) for item in collisions):
        raise InputError("attribute summary: macro_collisions should be a list of objects")
    for item in collisions:
        _check_numbers(item, _names(MacroCollision), "macro_collisions")
        if not first <= item["start"] <= item["end"] <= last:
            raise InputError(f"attribute summary: macro_collisions should lie between {first:g} and {last:g} s")
    energy = summary.get("energy")
    if not isinstance(energy, dict):
        raise InputError("attribute summary: energy should be an object")
    _check_numbers(energy, _names(Ledger), "energy")
    clearance = summary.get("clearance") or {"distance": 0.0, "x": 0.0, "time": 0.0}
    if not isinstance(clearance, dict):
        raise InputError("attribute summary: clearance should be an object")
    _check_numbers(clearance, ("distance", "x", "time"), "clearance")
    warnings = summary.get("warnings", [])
    if not isinstance(warnings, list) or not all(isinstance(line, str) for line in warnings):
        raise InputError("attribute summary: warnings should be a list of sentences")
    if not isinstance(summary.get("message", ""), str) or not isinstance(summary.get("versions", {}), dict):
        raise InputError("attribute summary: message or versions are not words")


def _check_numbers(values: dict[str, Any], names: tuple[str, ...], where: str) -> None:
    for name in names:
        value = values.get(name)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not _fits(value):
            raise InputError(f"attribute summary: {where}: {name} should be a number")


def _names(entry: type[Ledger] | type[MacroCollision]) -> tuple[str, ...]:
    return tuple(field.name for field in fields(entry))


def _fits(value: float) -> bool:
    """Whether a number can be a float; energies of a run that diverged are not finite."""
    try:
        return not math.isnan(float(value)) or isinstance(value, float)
    except OverflowError:
        return False
