"""Two histories compared: their events aligned, everything they sampled, their collisions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from oblique_impact.errors import InputError
from oblique_impact.history.history import History, require_history
from oblique_impact.history.sample_times import jumps
from oblique_impact.scenario.toml import flat_keys, parse_toml
from oblique_impact.validation.curves import Array, Courses, Deviation, interpolated
from oblique_impact.validation.event_pairs import EventPair, align, largest_difference, pair_events

if TYPE_CHECKING:
    import pandas as pd

#: events further apart than this part of the common span are not the same event
MAX_SHIFT = 0.1
#: times (s) are the same within this part of the span
SAME = 1e-12
#: events without a partner that a text lists at most
LISTED = 10
_COORDINATES = ("q", "qd")
_COLLISION = {
    "start": "s",
    "end": "s",
    "contacts": "1",
    "normal_impulse": "N s",
    "tangential_impulse": "N s",
    "peak_force": "N",
}
_ENERGIES = ("final", "lost_impact", "lost_friction", "lost_damping", "lost_scheme")


@dataclass(frozen=True)
class VariableDifference:
    """How far one variable of two histories is apart.

    Attributes
    ----------
    name, unit : str
        Of the variable.
    scale : float
        Range of the values of both histories in the common span; what relative differences refer to.
    plain : Deviation
        At equal times.
    aligned : Deviation
        At corresponding times: each shared event at the mean of its two times, linear in between.
    hausdorff : float or None
        Distance of the two graphs, time relative to the common span, values to the scale; for variables that jump.
    """

    name: str
    unit: str
    scale: float
    plain: Deviation
    aligned: Deviation
    hausdorff: float | None

    def relative(self, value: float) -> float:
        """Return a difference over the scale; 0 where there is none."""
        return value / self.scale if value else 0.0


class Measure(NamedTuple):
    """One number of either history; None where a history does not have it."""

    name: str
    unit: str
    left: float | None
    right: float | None

    @property
    def difference(self) -> float | None:
        """Right minus left."""
        return None if self.left is None or self.right is None else self.right - self.left


@dataclass(frozen=True)
class Comparison:
    """Two histories side by side; differences are right minus left.

    Attributes
    ----------
    names : tuple of str
        What the two are called.
    histories : tuple of History
        The two.
    span : tuple of float
        Times (s) that both cover; what lies outside is not compared.
    max_shift : float
        Events further apart (s) are not paired.
    events : tuple of EventPair
        In the order of time.
    variables : mapping
        A `VariableDifference` by name of the variable.
    measures : tuple of Measure
        Collisions and energies.
    state_disagreement : float
        Part of the common time, events aligned, in which the contact states differ.
    skipped : mapping
        Why a variable is not compared, by name.
    """

    names: tuple[str, str]
    histories: tuple[History, History]
    span: tuple[float, float]
    max_shift: float
    events: tuple[EventPair, ...]
    variables: Mapping[str, VariableDifference]
    measures: tuple[Measure, ...]
    state_disagreement: float
    skipped: Mapping[str, str]

    def __getitem__(self, name: str) -> VariableDifference:
        """Return the difference of one variable, e.g. ``comparison["theta"]``; raises KeyError."""
        return self.variables[name]

    @property
    def outcomes(self) -> tuple[str, str]:
        """How the two ended."""
        return self.histories[0].outcome.label, self.histories[1].outcome.label

    @property
    def shared(self) -> tuple[EventPair, ...]:
        """Events that both have."""
        return tuple(pair for pair in self.events if pair.left and pair.right)

    @property
    def only_left(self) -> tuple[EventPair, ...]:
        """Events that only the left history has."""
        return tuple(pair for pair in self.events if not pair.right)

    @property
    def only_right(self) -> tuple[EventPair, ...]:
        """Events that only the right history has."""
        return tuple(pair for pair in self.events if not pair.left)

    @property
    def largest_shift(self) -> float:
        """Largest time difference (s) of shared events."""
        return largest_difference(list(self.shared))

    @property
    def changed_keys(self) -> dict[str, tuple[Any, Any]]:
        """Keys of the scenarios that differ, with both values; None where a scenario does not have the key."""
        both = zip(self.histories, self.names, strict=True)
        left, right = (flat_keys(_scenario(history, name)) for history, name in both)
        keys = [*left, *(key for key in right if key not in left)]
        return {key: (left.get(key), right.get(key)) for key in keys if left.get(key) != right.get(key)}

    @property
    def warnings(self) -> list[tuple[str, str]]:
        """Warnings of the runs, each with the name of its run, or of both."""
        found: dict[str, list[str]] = {}
        for name, history in zip(self.names, self.histories, strict=True):
            for text in history.summary.get("warnings", ()):
                found.setdefault(text, []).append(name)
        return [(" and ".join(names), text) for text, names in found.items()]

    def to_dataframe(self) -> pd.DataFrame:
        """Return a pandas table with a row per variable, in its unit."""
        import pandas as pd

        rows = [
            {
                "variable": v.name,
                "unit": v.unit,
                "scale": v.scale,
                **{f"plain_{key}": value for key, value in v.plain._asdict().items()},
                **{f"aligned_{key}": value for key, value in v.aligned._asdict().items()},
                "hausdorff": np.nan if v.hausdorff is None else v.hausdorff,
            }
            for v in self.variables.values()
        ]
        return pd.DataFrame(rows).set_index("variable") if rows else pd.DataFrame()

    def summary(self) -> list[str]:
        """Return what differs, in sentences, keys of the scenarios that do, and the warnings of both runs."""
        left, right = self.names
        changed = self.changed_keys
        count = f"{len(changed)} keys differ" if len(changed) != 1 else "1 key differs"
        return [
            *self.findings(),
            f"scenarios: {count}",
            *(f"  {key}: {shown(a)} in {left}, {shown(b)} in {right}" for key, (a, b) in changed.items()),
            *(f"warning ({names}): {text}" for names, text in self.warnings),
        ]

    def findings(self) -> list[str]:
        """Return how outcomes, events and contact states differ, in sentences."""
        left, right = self.names
        alone = (*self.only_left, *self.only_right)
        one = len(set(self.outcomes)) == 1
        found = [
            f"{left} and {right}, {self.span[0]:g} to {self.span[1]:g} s",
            f"outcome: {self.outcomes[0]}" if one else f"outcomes: {', '.join(self.outcomes)}",
            f"events: {len(self.shared)} shared, {len(self.only_left)} only in {left}, "
            f"{len(self.only_right)} only in {right}; largest time difference {self.largest_shift:.2g} s",
        ]
        found += [
            f"  only in {left if pair.left else right}: {pair.kind} at {pair.event.time:.6f} s"
            for pair in alone[:LISTED]
        ]
        found += [f"  and {len(alone) - LISTED} more"] if len(alone) > LISTED else []
        return [*found, f"contact states differ in {100.0 * self.state_disagreement:.2g} % of the time"]

    def __str__(self) -> str:
        head = f"{'relative to the scale':20}  {'scale':>14}  rms, same time  largest  rms, aligned  largest"
        lines = [*self.summary(), "", head]
        for v in self.variables.values():
            scale = f"{v.scale:.4g} {v.unit.removeprefix('1')}".strip()
            found = [
                f"{v.relative(d):8.1e}" for d in (v.plain.rms, v.plain.largest, v.aligned.rms, v.aligned.largest)
            ]
            lines.append(f"{v.name:20}  {scale:>14}  {found[0]:>14} {found[1]} {found[2]:>13} {found[3]}")
        return "\n".join(lines)


def shown(value: Any) -> str:
    """Return a value of a scenario as text."""
    return "not given" if value is None else str(value)


def _scenario(history: History, name: str) -> dict[str, Any]:
    """Return the sections of the scenario of a history, none of a user-defined system."""
    return parse_toml(history.scenario_toml, f"scenario of the {name} history")


def compare(
    left: History,
    right: History,
    variables: Sequence[str] | None = None,
    *,
    names: tuple[str, str] = ("left", "right"),
    max_shift: float | None = None,
) -> Comparison:
    """Compare two histories, with their events aligned.

    They may have other output intervals, other discretizations (the beam's variables are taken at common stations)
    and other end times: what both cover is compared.  Differences are taken at equal times, and besides them on a
    clock in which shared events coincide, so that an impact a little later does not hide everything else.  Both
    are exact for courses that are linear between their samples.

    Parameters
    ----------
    left, right : History
        Of beams or of user-defined systems.
    variables : sequence of str, optional
        Names of the variables to compare; default: all that both have.
    names : tuple of str
        What the two are called, in tables.
    max_shift : float, optional
        Events of one kind that are further apart (s) are not the same event; default: a tenth of the common span.

    Returns
    -------
    Comparison
        ``print`` it, or see its `events`, `variables` and `measures`.

    Raises
    ------
    InputError
        In one line, if the histories have no time in common, or a variable is unknown or not comparable.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> from validation import compare
    >>> paper = Scenario.builtin("paper").replace(end_time=0.33)
    >>> found = compare(simulate(paper), simulate(paper.replace(discretization__method="fem")))
    >>> len(found.only_left), found.largest_shift < 1e-6, found["theta"].aligned.rms < 1e-6
    (0, True, True)
    """
    for history in (left, right):
        require_history(history, "compare")
    span = _common_span(left, right)
    length = span[1] - span[0]
    limit = MAX_SHIFT * length if max_shift is None else float(max_shift)
    if not limit >= 0.0:
        raise InputError(f"max_shift = {limit}: should be a time in s, 0 or more")
    logs = [[event for event in h.events if span[0] <= event.time <= span[1]] for h in (left, right)]
    pairs = pair_events(logs[0], logs[1], limit)
    wanted, skipped = _chosen(left, right, variables)
    times = _times(left), _times(right)
    plain, aligned = Courses(times), Courses(_on_common_clock(times, pairs, length))
    return Comparison(
        names,
        (left, right),
        span,
        limit,
        tuple(pairs),
        {name: _difference(name, (left, right), plain, aligned) for name in wanted},
        tuple(_measures(left, right, span, limit)),
        aligned.disagreement([history["state"].values for history in (left, right)]),
        skipped,
    )


# --- variables


def _difference(
    name: str, histories: tuple[History, History], plain: Courses, aligned: Courses
) -> VariableDifference:
    values, weights = _at_common_stations(histories, name)
    inside = [v[(t >= plain.grid[0]) & (t <= plain.grid[-1])] for t, v in zip(plain.times, values, strict=True)]
    finite = np.concatenate([v[np.isfinite(v)] for v in inside])
    scale = (float(np.ptp(finite)) or float(np.max(np.abs(finite)))) if finite.size else 0.0
    unit = str(histories[0][name].attrs.get("units", "1"))
    deviations = plain.deviation(values, weights), aligned.deviation(values, weights)
    return VariableDifference(name, unit, scale, *deviations, plain.hausdorff(values, scale))


def _at_common_stations(histories: tuple[History, History], name: str) -> tuple[list[Array], Array | None]:
    """Values of both on common stations, and the weights of these in a mean along the beam."""
    values = [np.asarray(history[name].values, dtype=float) for history in histories]
    if "station" not in histories[0][name].dims:
        return values, None
    stations = [np.asarray(history["station"].values, dtype=float) for history in histories]
    common = np.union1d(*stations)
    common = common[(common >= max(s[0] for s in stations)) & (common <= min(s[-1] for s in stations))]
    # points closer than rounding are one
    common = common[np.concatenate([[True], np.diff(common) > SAME * (common[-1] or 1.0)])]
    widths = np.concatenate([[0.0], np.diff(common), [0.0]])
    weights = 0.5 * (widths[1:] + widths[:-1])
    return [interpolated(s, v.T, common).T for s, v in zip(stations, values, strict=True)], weights / weights.sum()


def _times(history: History) -> Array:
    return np.asarray(history["time"].values, dtype=float)


def _common_span(left: History, right: History) -> tuple[float, float]:
    times = _times(left), _times(right)
    start, end = max(float(t[0]) for t in times), min(float(t[-1]) for t in times)
    if min(t.size for t in times) < 2 or not start < end:
        covered = " and ".join(f"{t[0]:g} to {t[-1]:g} s" for t in times)
        raise InputError(f"compare: the histories have no time in common: {covered}")
    return start, end


def _on_common_clock(times: tuple[Array, Array], pairs: Sequence[EventPair], length: float) -> tuple[Array, Array]:
    """Return the times of either on a common clock: shared events at the mean of their times, linear in between.

    The beginnings coincide if they are the same; before the first shared instant and after the last one the clocks
    go on as they are.
    """
    begins = float(times[0][0]), float(times[1][0])
    shared = [begins] if abs(begins[1] - begins[0]) <= SAME * length else []
    for pair in pairs:
        if pair.left and pair.right:
            both = pair.left.time, pair.right.time
            # only those that ascend on both sides
            if not shared or min(both[0] - shared[-1][0], both[1] - shared[-1][1]) > SAME * length:
                shared.append(both)
    if not shared:
        return times
    knots = np.array(shared).T
    mean = knots.mean(axis=0)
    found = []
    for own, at in zip(times, knots, strict=True):
        ends = np.array([min(own[0], at[0]) - 1.0, max(own[-1], at[-1]) + 1.0])
        shift = mean[[0, -1]] - at[[0, -1]]
        common = np.interp(own, np.insert(ends, 1, at), np.insert(ends + shift, 1, mean))
        for k in np.flatnonzero(jumps(own)):  # both sides of a jump stay next to each other
            common[k + 1] = np.nextafter(common[k], np.inf)
        found.append(common)
    return found[0], found[1]


def _chosen(left: History, right: History, wanted: Sequence[str] | None) -> tuple[list[str], dict[str, str]]:
    """Names of the variables to compare, and why others are not; what is asked for has to be possible."""
    every = dict.fromkeys([*map(str, left.data.data_vars), *map(str, right.data.data_vars)])
    # what decides the meaning of the coordinates
    both = zip((left, right), ("left", "right"), strict=True)
    shapes = [_scenario(history, name).get("discretization") for history, name in both]
    why = {name: _obstacle(left, right, name, shapes[0] == shapes[1]) for name in every}
    for name in wanted or ():
        if name not in every:
            raise InputError(f"variables: {name!r}: should be among {', '.join(every)}")
        if why[name]:
            raise InputError(f"variables: {name!r}: {why[name]}")
    names = [name for name in (every if wanted is None else wanted) if not why[name]]
    return names, {name: reason for name, reason in why.items() if reason}


def _obstacle(left: History, right: History, name: str, same_shapes: bool) -> str:
    """Why a variable cannot be compared, "" if it can."""
    if name == "state":
        return "contact states are compared as state_disagreement"
    for history, side in ((left, "left"), (right, "right")):
        if name not in history.data.data_vars:
            return f"the {side} history does not have it"
    if left[name].dims != right[name].dims:
        return "other dimensions"
    if name in _COORDINATES and not same_shapes:
        return "coordinates of other shape functions"
    sizes = [{d: n for d, n in h[name].sizes.items() if d not in ("time", "station")} for h in (left, right)]
    return "" if sizes[0] == sizes[1] else "other numbers of coordinates"


def _measures(left: History, right: History, span: tuple[float, float], limit: float) -> list[Measure]:
    rows = [history.summary.get("macro_collisions", []) for history in (left, right)]
    begins = [[float(m["start"]) for m in found] for found in rows]
    places = align(begins[0], begins[1], [""] * len(begins[0]), [""] * len(begins[1]), limit)
    both = [(None if i is None else rows[0][i], None if j is None else rows[1][j]) for i, j in places]
    # one that goes on after the shorter history is cut there
    whole = [m for m in both if all(one is None or span[0] <= one["start"] <= one["end"] <= span[1] for one in m)]
    measures = []
    for number, collisions in enumerate(whole, start=1):
        for key, unit in _COLLISION.items():
            a, b = (None if one is None else float(one[key]) for one in collisions)
            measures.append(Measure(f"collision {number}: {key.replace('_', ' ')}", unit, a, b))
    ends = [float(_times(history)[-1]) for history in (left, right)]
    if abs(ends[1] - ends[0]) <= SAME * (span[1] - span[0]):
        energies = [history.summary.get("energy", {}) for history in (left, right)]
        for key in _ENERGIES:
            a, b = (float(energy[key]) if key in energy else None for energy in energies)
            measures.append(Measure(f"energy: {key.replace('_', ' ')}", "J", a, b))
    return measures
