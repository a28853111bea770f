"""Histories of consecutive spans of time, joined to one."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import pairwise
from typing import Any

import numpy as np
import tomli_w
import xarray as xr

from oblique_impact.contact.state import State
from oblique_impact.errors import InputError, Outcome
from oblique_impact.history.history import History, require_history
from oblique_impact.history.sample_times import ascending, shifted
from oblique_impact.history.summary import Ledger, macro_collisions
from oblique_impact.marching.records import Contact
from oblique_impact.scenario.messages import short
from oblique_impact.scenario.rules import TABLE

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
        New arrays; its scenario is the first one's with the whole `end_time`.

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
    parts = [histories[0]]
    for number, history in enumerate(histories[1:], start=2):
        _check_alike(histories[0], history, number)
        _check_finished(histories[number - 2], number - 1)
        parts.append(_moved(parts[-1], history, number, shift))
    joints = [_end(part) for part in parts[:-1]]
    return History(
        _samples([part.data for part in parts]),
        [event for part in parts for event in part.events],
        _summary(parts, joints),
        _scenario(parts),
        _contacts(parts),
    )


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
    return replace(history, data=data, events=events, summary=summary, contacts=contacts)


def _check_finished(history: History, number: int) -> None:
    if history.outcome not in (Outcome.COMPLETED, Outcome.INTERRUPTED):
        raise InputError(f"history {number}: ended by {history.outcome.label}; nothing can follow it")


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
    one, two = (_flat(tomllib.loads(history.scenario_toml)) for history in (first, other))
    for key in [*one, *two]:
        if key.partition(".")[0] not in (*OF_A_SPAN, TABLE) and one.get(key) != two.get(key):
            raise InputError(
                f"history {number}: {key} = {short(two.get(key))}, in history 1 it is {short(one.get(key))}; "
                f"only {', '.join(OF_A_SPAN)} may differ"
            )


def _flat(sections: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return {"section.key": value}."""
    flat: dict[str, Any] = {}
    for name, value in sections.items():
        flat |= _flat(value, f"{prefix}{name}.") if isinstance(value, dict) else {f"{prefix}{name}": value}
    return flat


def _samples(parts: Sequence[xr.Dataset]) -> xr.Dataset:
    """Put the samples behind each other; a sample that repeats the one before a joint is left out."""
    kept = [parts[0]]
    for before, after in pairwise(parts):
        kept.append(after.isel(time=slice(1 if _same(before, after) else 0, None)))
    joined = xr.concat(
        kept,
        "time",
        data_vars="all",
        coords="minimal",
        compat="override",
        join="override",
        combine_attrs="override",
    )
    times = ascending(joined["time"].values)
    return joined.assign_coords(time=("time", times, parts[0]["time"].attrs))


def _same(before: xr.Dataset, after: xr.Dataset, names: Sequence[str] = ()) -> bool:
    """Whether the last sample of one is the first of the other, in all variables or in those of `names`."""
    for name in names or map(str, before.data_vars):
        left, right = np.asarray(before[name].values), np.asarray(after[name].values)
        size = max(float(np.max(np.abs(np.nan_to_num(v)), initial=0.0)) for v in (left, right))
        if not np.allclose(left[-1], right[0], rtol=0.0, atol=EQUAL * size, equal_nan=True):
            return False
    return True


def _summary(parts: Sequence[History], joints: list[float]) -> dict[str, Any]:
    summaries = [part.summary for part in parts]
    total = {
        key: sum(summary[key] for summary in summaries)
        for key in ("events", "steps", "rejected_steps", "wall_time")
        if all(key in summary for summary in summaries)
    }
    said = [warning for summary in summaries for warning in summary.get("warnings", [])]
    jumps = [
        f"the motion jumps at {t:g} s, where two spans meet"
        for t, (before, after) in zip(joints, pairwise(parts), strict=True)
        if not _same(before.data, after.data, ("q", "qd"))
    ]
    macro_gap = parts[0].macro_gap
    distances = [summary["clearance"] for summary in summaries if summary.get("clearance")]
    return {
        **summaries[-1],
        "macro_gap": macro_gap,
        "clearance": min(distances, key=lambda found: found["distance"], default=None),
        "macro_collisions": [asdict(m) for m in macro_collisions(_contacts(parts), macro_gap)],
        **total,
        "energy": asdict(_energy([summary["energy"] for summary in summaries])),
        "versions": _versions([summary.get("versions", {}) for summary in summaries]),
        "provenance": _provenance([summary.get("provenance", {}) for summary in summaries]),
        "warnings": list(dict.fromkeys([*said, *jumps])),
        "joints": sorted([*joints, *(t for summary in summaries for t in summary.get("joints", []))]),
    }


def _contacts(parts: Sequence[History]) -> list[Contact]:
    """Contacts of all parts; one that a joint cuts in two is one."""
    found: list[Contact] = []
    for number, part in enumerate(parts):
        rest = list(part.contacts)
        if found and rest and _cut(parts[number - 1], part, found[-1].end, rest[0].start):
            a, b = found[-1], rest.pop(0)
            peaks = max(a.peak_force, b.peak_force), max(a.peak_energy, b.peak_energy)
            normal, tangential = a.normal_impulse + b.normal_impulse, a.tangential_impulse + b.tangential_impulse
            found[-1] = Contact(a.start, b.end, normal, tangential, *peaks, a.energy_loss + b.energy_loss)
        found += rest
    return found


def _cut(before: History, after: History, end: float, start: float) -> bool:
    """Whether a joint cuts one contact in two."""
    free = int(State.FREE)
    touching = (
        before["state"].values[-1] != free and after["state"].values[-1 if after["time"].size < 2 else 1] != free
    )
    return bool(touching and end == _end(before) and start == float(after["time"].values[0]))


def _energy(rows: Sequence[dict[str, float]]) -> Ledger:
    losses = {key: sum(row[key] for row in rows) for key in rows[0] if key.startswith("lost_")}
    supplied = sum(row["supplied"] for row in rows)
    first, last = rows[0], rows[-1]
    ends = {key: last[key] for key in ("final", "kinetic", "elastic", "gravity", "contact")}
    left = first["initial"] + supplied - sum(losses.values()) - last["final"]
    return Ledger(initial=first["initial"], **ends, supplied=supplied, **losses, unaccounted=left)


def _versions(rows: Sequence[dict[str, str]]) -> dict[str, str]:
    """Versions of all spans: one, or all of them where they differ."""
    names = dict.fromkeys(name for row in rows for name in row)
    return {name: ", ".join(dict.fromkeys(row[name] for row in rows if name in row)) for name in names}


def _provenance(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return what made the spans: one, or all of them where they differ."""
    parts = {name: digest for row in rows for name, digest in row.get("user_defined", {}).items()}
    plain = [{key: value for key, value in row.items() if key != "user_defined"} for row in rows]
    return {**_versions(plain), **({"user_defined": parts} if parts else {})}


def _scenario(parts: Sequence[History]) -> str:
    """Return the first scenario with the end of the last span; it is "" for a system that has none."""
    sections = tomllib.loads(parts[0].scenario_toml)
    return tomli_w.dumps({**sections, "end_time": _end(parts[-1])}) if sections else ""
