"""Histories of consecutive spans of time, joined to one."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import tomli_w
import xarray as xr

from oblique_impact.contact.state import State
from oblique_impact.errors import InputError, Outcome
from oblique_impact.history.history import History, require_history
from oblique_impact.history.sample_times import ascending, shifted
from oblique_impact.history.summary import macro_collisions
from oblique_impact.marching.records import Contact
from oblique_impact.scenario.messages import short
from oblique_impact.scenario.scenario import DERIVED as TABLE
from oblique_impact.scenario.toml import flat_keys

#: spans are consecutive if they meet within this part of their length
MEETING = 1e-9
#: samples are equal within this part of the largest value
EQUAL = 1e-9
#: what the scenarios of two spans need not share: where a span begins and ends, and how it is computed
OF_A_SPAN = ("initial", "end_time", "solver")


def concatenate(*histories: History, shift: bool = False) -> History:
    """Join histories of consecutive spans to one, which saves, loads, draws and exports like any other.

    Samples and events follow each other.  Where two spans meet, two samples that are equal become one; two that
    differ both stay, the earlier span's first, as at any jump, and a warning says so.  Macro-collisions that go on
    across a joint are one; the first history's `macro_gap` holds for all.  Losses and supplied energy of the
    ledger add up, its `initial` is the first one's and its `final` the last one's, so that a jump of the energy at
    a joint appears as `unaccounted`.  Steps, rejected steps and wall times add up; the outcome is the last one's;
    ``summary["joints"]`` lists the times (s) where spans meet.

    Parameters
    ----------
    *histories : History
        In the order of time, one or more, of one system; `initial`, `end_time` and `solver` of their scenarios may
        differ.
    shift : bool
        Move the times of each history so that it begins where the one before it ends.  Without it they have to
        meet: the program's runs begin at 0 s.

    Returns
    -------
    History
        Its scenario is the first one's with the whole `end_time`.

    Raises
    ------
    InputError
        In one line, if there is none, if two do not meet, if one but the last was stopped by the physics, or if
        variables, coordinates, stations or scenarios differ.

    Examples
    --------
    >>> from oblique_impact import Scenario, concatenate, simulate
    >>> swing = simulate(Scenario.builtin("paper").replace(end_time=0.1))
    >>> twice = concatenate(swing, swing, shift=True)
    >>> float(twice["time"][-1]), twice.summary["joints"]
    (0.2, [0.1])
    """
    if not histories:
        raise InputError("concatenate: no histories given")
    for history in histories:
        require_history(history, "concatenate")
    joined = histories[0]
    for number, history in enumerate(histories[1:], start=2):
        _check_alike(histories[0], history, number)
        before = histories[number - 2].outcome
        if before not in (Outcome.COMPLETED, Outcome.INTERRUPTED):
            raise InputError(f"history {number - 1}: ended by {before.label}; nothing can follow it")
        joined = _joined(joined, _moved(joined, history, number, shift))
    return joined


def _end(history: History) -> float:
    return float(history["time"].values[-1])


def _moved(before: History, history: History, number: int, shift: bool) -> History:
    """Return `history` with times that go on from those of `before`."""
    time = np.asarray(history["time"].values)
    offset = _end(before) - float(time[0])
    if not shift:
        length = max(_end(before) - float(before["time"].values[0]), float(time[-1] - time[0]))
        if abs(offset) > MEETING * length:
            raise InputError(
                f"history {number}: begins at {time[0]:g} s, but history {number - 1} ends at {_end(before):g} s; "
                "shift=True moves it there"
            )
        return history
    # the first sample lies exactly on the last one before: a sum may miss it by a rounding
    moved = ascending(np.concatenate([[_end(before)], shifted(time, offset)[1:]]))
    data = history.data.assign_coords(time=("time", moved, history.data["time"].attrs))
    events = [event._replace(time=event.time + offset) for event in history.events]
    contacts = [c._replace(start=c.start + offset, end=c.end + offset) for c in history.contacts]
    joints = [t + offset for t in history.summary.get("joints", [])]
    summary = {**history.summary, "joints": joints, "end_time": float(moved[-1])}
    if summary.get("clearance"):
        summary["clearance"] = {**summary["clearance"], "time": summary["clearance"]["time"] + offset}
    if summary.get("slope_ends"):
        summary["slope_ends"] = [{**end, "time": end["time"] + offset} for end in summary["slope_ends"]]
    return replace(history, data=data, events=events, summary=summary, contacts=contacts)


def _check_alike(first: History, other: History, number: int) -> None:
    """Refuse a history of another system."""
    kinds = [{str(name): v.dims for name, v in history.data.variables.items()} for history in (first, other)]
    for name in [*kinds[0], *kinds[1]]:
        if kinds[0].get(name) != kinds[1].get(name):
            has, lacks = (1, number) if name in kinds[0] else (number, 1)
            words = (
                "has other dimensions" if name in kinds[0] and name in kinds[1] else f"is only in history {has}"
            )
            raise InputError(f"history {lacks}: variable {name!r} {words}")
    for dimension, size in first.data.sizes.items():
        theirs = other.data.sizes[dimension]
        if dimension != "time" and theirs != size:
            raise InputError(f"history {number}: {theirs} along {dimension!r}, in history 1 there are {size}")
    for coordinate in map(str, first.data.coords):
        if coordinate != "time" and not np.allclose(first[coordinate].values, other[coordinate].values, rtol=1e-9):
            raise InputError(f"history {number}: other values of {coordinate!r} than history 1")
    one, two = (flat_keys(tomllib.loads(history.scenario_toml)) for history in (first, other))
    for key in [*one, *two]:
        if key.partition(".")[0] not in (*OF_A_SPAN, TABLE) and one.get(key) != two.get(key):
            raise InputError(
                f"history {number}: {key} = {short(two.get(key))}, in history 1 it is {short(one.get(key))}; "
                f"only {', '.join(OF_A_SPAN)} may differ"
            )


def _joined(before: History, after: History) -> History:
    """Return both spans as one; the second begins where the first ends."""
    options: Any = {"coords": "minimal", "compat": "override", "join": "override", "combine_attrs": "override"}
    rest = after.data.isel(time=slice(1 if _same(before.data, after.data) else 0, None))
    data = xr.concat([before.data, rest], "time", data_vars="all", **options)
    times = ascending(data["time"].values)
    sections = tomllib.loads(before.scenario_toml)  # none of a system without a scenario
    contacts = _contacts(before, after)
    return History(
        data.assign_coords(time=("time", times, before["time"].attrs)),
        [*before.events, *after.events],
        _summary(before, after, contacts),
        tomli_w.dumps({**sections, "end_time": _end(after)}) if sections else "",
        contacts,
    )


def _same(before: xr.Dataset, after: xr.Dataset, names: Sequence[str] = ()) -> bool:
    """Whether the last sample of one is the first of the other, in all variables or in those of `names`."""
    for name in names or map(str, before.data_vars):
        left, right = np.asarray(before[name].values), np.asarray(after[name].values)
        size = max(float(np.max(np.abs(np.nan_to_num(v)), initial=0.0)) for v in (left, right))
        if not np.allclose(left[-1], right[0], rtol=0.0, atol=EQUAL * size, equal_nan=True):
            return False
    return True


def _summary(before: History, after: History, contacts: list[Contact]) -> dict[str, Any]:
    one, two, joint = before.summary, after.summary, _end(before)
    counts = [key for key in ("events", "steps", "rejected_steps", "wall_time") if key in one and key in two]
    jumps = not _same(before.data, after.data, ("q", "qd"))
    said = [f"the motion jumps at {joint:g} s, where two spans meet"] if jumps else []
    distances = [summary["clearance"] for summary in (one, two) if summary.get("clearance")]
    return {
        **two,
        "macro_gap": before.macro_gap,
        "clearance": min(distances, key=lambda found: found["distance"], default=None),
        "slope_ends": [*one.get("slope_ends", []), *two.get("slope_ends", [])],
        "macro_collisions": [asdict(m) for m in macro_collisions(contacts, before.macro_gap)],
        **{key: one[key] + two[key] for key in counts},
        "energy": _energy(one["energy"], two["energy"]),
        "versions": _both(one.get("versions", {}), two.get("versions", {})),
        "provenance": _both(one.get("provenance", {}), two.get("provenance", {})),
        "warnings": list(dict.fromkeys([*one.get("warnings", []), *two.get("warnings", []), *said])),
        "joints": sorted([*one.get("joints", []), joint, *two.get("joints", [])]),
    }


def _contacts(before: History, after: History) -> list[Contact]:
    """Contacts of both spans; one that the joint cuts in two is one."""
    if not (before.contacts and after.contacts):
        return [*before.contacts, *after.contacts]
    (*first, a), (b, *rest) = before.contacts, after.contacts
    closed = before["state"].values[-1] != State.FREE and after["state"].values[:2][-1] != State.FREE
    if not (closed and a.end == _end(before) and b.start == float(after["time"].values[0])):
        return [*first, a, b, *rest]
    whole = a._replace(
        end=b.end,
        normal_impulse=a.normal_impulse + b.normal_impulse,
        tangential_impulse=a.tangential_impulse + b.tangential_impulse,
        peak_force=max(a.peak_force, b.peak_force),
        peak_energy=max(a.peak_energy, b.peak_energy),
        energy_loss=a.energy_loss + b.energy_loss,
    )
    return [*first, whole, *rest]


def _energy(one: dict[str, float], two: dict[str, float]) -> dict[str, float]:
    added = {key: one[key] + two[key] for key in one if key.startswith("lost_") or key == "supplied"}
    lost = sum(value for key, value in added.items() if key != "supplied")
    unaccounted = one["initial"] + added["supplied"] - lost - two["final"]
    return {**two, "initial": one["initial"], **added, "unaccounted": unaccounted}


def _both(one: dict[str, Any], two: dict[str, Any]) -> dict[str, Any]:
    """Return what made both spans, or all of it where they differ."""
    found: dict[str, Any] = {}
    for name in one | two:
        values = [row[name] for row in (one, two) if name in row]
        if isinstance(values[0], dict):  # digests of user-defined parts
            found[name] = values[0] | values[-1]
        else:
            found[name] = ", ".join(dict.fromkeys(", ".join(values).split(", ")))
    return found
