"""Two histories compared: their events aligned, everything they sampled, their collisions; with a report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.files import prepare_folder
from oblique_impact.history.history import History, require_history
from oblique_impact.history.sample_times import jumps
from oblique_impact.scenario.toml import flat_keys, parse_toml
from oblique_impact.validation.event_pairs import EventPair, align, largest_difference, pair_events

if TYPE_CHECKING:
    from oblique_impact.validation.report import Picture, Report

Array = NDArray[np.float64]

#: events further apart than this part of the common span are not the same event
MAX_SHIFT = 0.1
#: times (s) are the same within this part of the span
SAME = 1e-12
#: events without a partner that a text lists at most
LISTED = 10
#: suffixes of reports
SUFFIXES = (".html", ".json")
_COORDINATES = ("q", "qd")
_COLLISION = {
    "start": "s",
    "end": "s",
    "contacts": "1",
    "normal_impulse": "N s",
    "tangential_impulse": "N s",
    "peak_force": "N",
}
_COLUMNS = (
    "unit",
    "scale",
    "plain_rms",
    "plain_largest",
    "plain_at",
    "aligned_rms",
    "aligned_largest",
    "aligned_at",
)
_ENERGIES = ("final", "lost_impact", "lost_friction", "lost_damping", "lost_scheme")
#: what the picture shows, if both histories have it: label and unit of the axis
_DRAWN = {
    "gap": "gap (m)",
    "theta_dot": "angular velocity (rad/s)",
    "lambda_n": "normal force (N)",
    "slip_rate": "slip velocity (m/s)",
}


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
    variables : DataFrame
        A row for each variable: unit; scale, the range of both in the common span; and the root of the mean square
        over time (and along the beam), the largest difference with its sign and its time (s), each at equal times
        (`plain`) and on a clock in which each shared event is at the mean of its two times (`aligned`).
    measures : DataFrame
        A row for each number of collisions and energies: unit, left, right, difference; NaN where one lacks it.
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
    variables: pd.DataFrame
    measures: pd.DataFrame
    state_disagreement: float
    skipped: Mapping[str, str]

    def __getitem__(self, name: str) -> pd.Series[Any]:
        """Return the differences of one variable, e.g. ``comparison["theta"].aligned_rms``; raises KeyError."""
        return self.variables.loc[name]

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
        return largest_difference(self.shared)

    @property
    def changed_keys(self) -> dict[str, tuple[Any, Any]]:
        """Keys of the scenarios that differ, with both values; "not given" where one does not have the key."""
        left, right = (flat_keys(_scenario(history)) for history in self.histories)
        both = {key: (left.get(key, "not given"), right.get(key, "not given")) for key in {**left, **right}}
        return {key: (a, b) for key, (a, b) in both.items() if a != b}

    @property
    def warnings(self) -> list[tuple[str, str]]:
        """Warnings of the runs, each with the name of its run, or of both."""
        found: dict[str, list[str]] = {}
        for name, history in zip(self.names, self.histories, strict=True):
            for text in history.summary.get("warnings", ()):
                found.setdefault(text, []).append(name)
        return [(" and ".join(names), text) for text, names in found.items()]

    @property
    def event_table(self) -> pd.DataFrame:
        """A row for each event: kind and state, times (s) and impulses (N s) of both, differences."""
        rows = []
        for pair in self.events:
            row: dict[str, Any] = {"kind": pair.event.kind.value, "state": pair.event.state.name.lower()}
            for side, event in (("left", pair.left), ("right", pair.right)):
                row |= {f"{side}_time": event and event.time, f"{side}_impulse": event and event.normal_impulse}
            row |= {"time_difference": pair.time_difference, "impulse_difference": pair.impulse_difference}
            rows.append(row)
        return pd.DataFrame(rows)

    def summary(self) -> list[str]:
        """Return how outcomes, events, contact states and scenarios differ, and the warnings, in sentences."""
        left, right = self.names
        alone, changed = (*self.only_left, *self.only_right), self.changed_keys
        one = len(set(self.outcomes)) == 1
        return [
            f"{left} and {right}, {self.span[0]:g} to {self.span[1]:g} s",
            f"outcome: {self.outcomes[0]}" if one else f"outcomes: {', '.join(self.outcomes)}",
            f"events: {len(self.shared)} shared, {len(self.only_left)} only in {left}, "
            f"{len(self.only_right)} only in {right}; largest time difference {self.largest_shift:.2g} s",
            *(
                f"  only in {left if pair.left else right}: {pair.kind} at {pair.event.time:.6f} s"
                for pair in alone[:LISTED]
            ),
            *([f"  and {len(alone) - LISTED} more"] if len(alone) > LISTED else []),
            f"contact states differ in {100.0 * self.state_disagreement:.2g} % of the time",
            f"scenarios: {len(changed)} keys differ" if len(changed) != 1 else "scenarios: 1 key differs",
            *(f"  {key}: {a} in {left}, {b} in {right}" for key, (a, b) in changed.items()),
            *(f"warning ({names}): {text}" for names, text in self.warnings),
        ]

    def __str__(self) -> str:
        table = self.variables.to_string(float_format=lambda value: f"{value:.3g}")
        return "\n".join([*self.summary(), "", table])


def compare(
    left: History,
    right: History,
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
        In one line, if the histories have no time in common.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> from oblique_impact.validation import compare
    >>> paper = Scenario.builtin("paper").replace(end_time=0.33)
    >>> found = compare(simulate(paper), simulate(paper.replace(discretization__method="fem")))
    >>> len(found.only_left), found.largest_shift < 1e-6, bool(found["theta"].aligned_rms < 1e-6)
    (0, True, True)
    """
    for history in (left, right):
        require_history(history, "compare")
    times = _times(left), _times(right)
    start, end = max(float(t[0]) for t in times), min(float(t[-1]) for t in times)
    if min(t.size for t in times) < 2 or not start < end:
        covered = " and ".join(f"{t[0]:g} to {t[-1]:g} s" for t in times)
        raise InputError(f"compare: the histories have no time in common: {covered}")
    limit = MAX_SHIFT * (end - start) if max_shift is None else float(max_shift)
    if not limit >= 0.0:
        raise InputError(f"max_shift = {limit}: should be a time in s, 0 or more")
    logs = [[event for event in h.events if start <= event.time <= end] for h in (left, right)]
    pairs = pair_events(logs[0], logs[1], limit)
    reasons = _obstacles(left, right)
    wanted, skipped = [n for n in reasons if not reasons[n]], {n: why for n, why in reasons.items() if why}
    clocks = times, _on_common_clock(times, pairs, end - start)
    return Comparison(
        names,
        (left, right),
        (start, end),
        limit,
        tuple(pairs),
        pd.DataFrame({name: _difference(name, (left, right), *clocks) for name in wanted}, _COLUMNS).T,
        _measures(left, right, (start, end), limit),
        _disagreement(clocks[1], [history["state"].values for history in (left, right)]),
        skipped,
    )


# --- variables


def _difference(
    name: str, histories: tuple[History, History], times: tuple[Array, Array], aligned: tuple[Array, Array]
) -> list[Any]:
    """Return the entries of `_COLUMNS` of a variable."""
    values, weights = _at_common_stations(histories, name)
    grid = _union(times)
    inside = [v[(t >= grid[0]) & (t <= grid[-1])] for t, v in zip(times, values, strict=True)]
    finite = np.concatenate([v[np.isfinite(v)] for v in inside])
    scale = (float(np.ptp(finite)) or float(np.max(np.abs(finite)))) if finite.size else 0.0
    unit = str(histories[0][name].attrs.get("units", "1"))
    return [unit, scale, *_deviation(times, values, weights), *_deviation(aligned, values, weights)]


def _union(times: tuple[Array, Array]) -> Array:
    """Return the instants of both in the span that both cover."""
    start, end = max(t[0] for t in times), min(t[-1] for t in times)
    union = np.union1d(*times)
    return np.unique(np.concatenate([[start], union[(union > start) & (union < end)], [end]]))


def _deviation(
    times: tuple[Array, Array], values: Sequence[Array], weights: Array | None
) -> tuple[float, float, float]:
    """Return root mean square, largest difference and its time of values (samples,) or (samples, points).

    They are linear between samples, of which integrals are exact; the mean along the beam has `weights` of sum 1.
    """
    grid = _union(times)
    left, right = (_interpolated(t, v, grid) for t, v in zip(times, values, strict=True))
    wild = ~np.isfinite(left), ~np.isfinite(right)
    with np.errstate(invalid="ignore"):
        apart = np.where(wild[0] & wild[1], 0.0, right - left)
    apart = np.where(wild[0] ^ wild[1], np.inf, apart).reshape(grid.size, -1)
    if grid.size < 2:
        return 0.0, 0.0, float(grid[0])
    share = np.full(apart.shape[1], 1.0 / apart.shape[1]) if weights is None else weights
    with np.errstate(invalid="ignore", over="ignore"):
        squares = apart[:-1] ** 2 + apart[:-1] * apart[1:] + apart[1:] ** 2
    mean = np.where(np.isnan(squares), np.inf, squares) @ share / 3.0
    rms = float(np.sqrt(np.diff(grid) @ mean / (grid[-1] - grid[0])))
    row, column = np.unravel_index(int(np.argmax(np.abs(apart))), apart.shape)
    return rms, float(apart[row, column]), float(grid[row])


def _disagreement(times: tuple[Array, Array], values: Sequence[NDArray[Any]]) -> float:
    """Return the part of the time in which values differ that hold from their sample on to the next."""
    grid = _union(times)
    if grid.size < 2:
        return 0.0
    places = [np.searchsorted(t, grid[:-1], side="right") - 1 for t in times]
    left, right = (v[k] for v, k in zip(values, places, strict=True))
    return float(np.diff(grid) @ (left != right) / (grid[-1] - grid[0]))


def _interpolated(x: Array, values: Array, at: Array) -> Array:
    """Return values (points, ...) at other points, linear in between; a sample that is hit is taken as it is."""
    k = np.clip(np.searchsorted(x, at, side="right") - 1, 0, x.size - 2)
    part = np.clip((at - x[k]) / (x[k + 1] - x[k]), 0.0, 1.0).reshape(-1, *(1,) * (values.ndim - 1))
    with np.errstate(invalid="ignore"):
        between = values[k] + part * (values[k + 1] - values[k])
    return np.asarray(np.where(part == 0.0, values[k], np.where(part == 1.0, values[k + 1], between)))


def _at_common_stations(histories: tuple[History, History], name: str) -> tuple[list[Array], Array | None]:
    """Return values of both on common stations, and the weights of these in a mean along the beam."""
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
    return [
        _interpolated(s, v.T, common).T for s, v in zip(stations, values, strict=True)
    ], weights / weights.sum()


def _times(history: History) -> Array:
    return np.asarray(history["time"].values, dtype=float)


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


def _obstacles(left: History, right: History) -> dict[str, str]:
    """Return why each variable cannot be compared, "" if it can."""
    found = {"state": "contact states are compared as state_disagreement"}
    same_shapes = len({str(_scenario(history).get("discretization")) for history in (left, right)}) == 1
    for name in map(str, {**left.data.data_vars, **right.data.data_vars}):
        both = left.data.get(name), right.data.get(name)
        if name in found:
            continue
        if both[0] is None or both[1] is None:
            found[name] = f"the {'left' if both[0] is None else 'right'} history does not have it"
        elif both[0].dims != both[1].dims:
            found[name] = "other dimensions"
        elif name in _COORDINATES and not same_shapes:
            found[name] = "coordinates of other shape functions"
        else:
            free = [
                d for d in both[0].dims if d not in ("time", "station") and both[0].sizes[d] != both[1].sizes[d]
            ]
            found[name] = "other numbers of coordinates" if free else ""
    return found


def _measures(left: History, right: History, span: tuple[float, float], limit: float) -> pd.DataFrame:
    """Return the table of collisions and energies."""
    rows = [history.summary.get("macro_collisions", []) for history in (left, right)]
    begins = [[float(m["start"]) for m in found] for found in rows]
    places = align(begins[0], begins[1], [""] * len(begins[0]), [""] * len(begins[1]), limit)
    both = [({} if i is None else rows[0][i], {} if j is None else rows[1][j]) for i, j in places]
    # one that goes on after the shorter history is cut there
    whole = [m for m in both if all(not one or span[0] <= one["start"] <= one["end"] <= span[1] for one in m)]
    measures = {
        f"collision {number}: {key.replace('_', ' ')}": [unit, *(one.get(key, np.nan) for one in collisions)]
        for number, collisions in enumerate(whole, start=1)
        for key, unit in _COLLISION.items()
    }
    ends = [float(_times(history)[-1]) for history in (left, right)]
    if abs(ends[1] - ends[0]) <= SAME * (span[1] - span[0]):
        energies = [history.summary.get("energy", {}) for history in (left, right)]
        for key in _ENERGIES:
            measures[f"energy: {key.replace('_', ' ')}"] = ["J", *(found.get(key, np.nan) for found in energies)]
    frame = pd.DataFrame.from_dict(measures, orient="index", columns=["unit", "left", "right"])
    frame["difference"] = frame["right"].astype(float) - frame["left"].astype(float)
    return frame


def _scenario(history: History) -> dict[str, Any]:
    """Return the sections of the scenario of a history, none of a user-defined system."""
    return parse_toml(history.scenario_toml, "scenario of the history")


# --- report


def check_target(out: Path) -> None:
    """Raise InputError for a file of another kind."""
    if out.suffix not in SUFFIXES:
        raise InputError(f"--out {out}: should end in {' or '.join(SUFFIXES)}")


def save_comparison(found: Comparison, out: Path, command: str) -> Path:
    """Write a page (.html) or the numbers (.json), whole or not at all; `command` repeats it.

    Raises InputError for another suffix, or if the file cannot be written.
    """
    from oblique_impact.validation.report.document import write_json

    check_target(out)
    folder = prepare_folder(out.parent)
    if out.suffix == ".json":
        return write_json(out, comparison_data(found, command))
    return report(found, command).write(folder, name=out.name)


def comparison_data(found: Comparison, command: str) -> dict[str, Any]:
    """Return everything that was found as plain data in SI units; differences are right minus left."""
    from oblique_impact.validation.report import provenance_data

    return {
        "command": command,
        "names": found.names,
        "outcomes": found.outcomes,
        "changed_keys": found.changed_keys,
        "warnings": [{"runs": names, "warning": text} for names, text in found.warnings],
        "span": found.span,
        "max_shift": found.max_shift,
        "largest_shift": found.largest_shift,
        "state_disagreement": found.state_disagreement,
        "events": found.event_table.to_dict("records"),
        "variables": found.variables.rename_axis("name").reset_index().to_dict("records"),
        "measures": found.measures.rename_axis("name").reset_index().to_dict("records"),
        "skipped": dict(found.skipped),
        **provenance_data(),
    }


def report(found: Comparison, command: str) -> Report:
    """Return the report; `command` repeats it."""
    from oblique_impact.validation.report import Report, Section, Table, Text, cell

    left, right = found.names
    variables = found.variables.rename_axis("variable").reset_index()
    scale = variables["scale"].where(variables["scale"] > 0.0, 1.0).astype(float)
    for name in _COLUMNS[2:]:
        small = not name.endswith("_at")
        values = (variables[name] / scale if small else variables[name]).astype(float)
        variables[name] = [cell(value, 2 if small else 6) for value in values]
    caption = (
        "Differences relative to the scale, the range of the values: at the same time; and aligned, on a clock in "
        "which shared events coincide."
    )
    events = {"kind": "event", "state": "then", "left_time": f"{left}: t (s)", "right_time": f"{right}: t (s)"}
    events |= {"time_difference": "difference (s)"}
    events |= {"left_impulse": f"{left}: impulse (N s)", "right_impulse": f"{right}: impulse (N s)"}
    headings = {"variable": "variable", "unit": "unit", "scale": "scale", "plain_rms": "rms, same time"}
    headings |= {"plain_largest": "largest", "plain_at": "at (s)", "aligned_rms": "rms, aligned"}
    headings |= {"aligned_largest": "largest", "aligned_at": "at (s)"}
    measures = found.measures.rename_axis("measure").reset_index().rename(columns={"left": left, "right": right})
    skipped = "; ".join(f"{name}: {why}" for name, why in found.skipped.items())
    table = found.event_table
    return Report(
        f"{left} and {right}",
        f"Two runs side by side, from {found.span[0]:g} to {found.span[1]:g} s. Differences are those of {right} "
        f"from {left}.",
        command,
        overview=[*(Text(sentence) for sentence in found.summary()[1:]), _picture(found)],
        sections=[
            Section(
                "Variables",
                [
                    Table.of_frame(variables, caption, 4, columns=headings),
                    Text(f"Not compared: {skipped}.", note=True),
                ],
            ),
            *([Section("Events", [Table.of_frame(table, digits=9, columns=events)])] if len(table) else []),
            *([Section("Collisions and energies", [Table.of_frame(measures, digits=9)])] if len(measures) else []),
        ],
    )


def _picture(found: Comparison) -> Picture:
    """Draw both runs on top of each other, fields at their last station."""
    from oblique_impact.renders.style import GREY, SERIES
    from oblique_impact.validation.report import picture, with_unit

    names = [name for name in _DRAWN if name in found.variables.index] or list(found.variables.index)[:1]
    caption = "Both runs over time; dotted lines are events that only one of them has."
    alternative = f"{', '.join(names)} of {' and '.join(found.names)} over time."
    with picture(caption, height=2.2 * len(names) + 0.5, alternative=alternative) as drawn:
        panels = drawn.figure.subplots(len(names), 1, sharex=True, squeeze=False).ravel()
        for axes, name in zip(panels, names, strict=True):
            for k, (history, label) in enumerate(zip(found.histories, found.names, strict=True)):
                values = history[name].values
                last = values.reshape(len(values), -1)[:, -1]
                axes.plot(history["time"].values, last, label=label, color=SERIES[k], linewidth=2.0 - k)
            for pair in found.events:
                if pair.time_difference is None:
                    axes.axvline(pair.event.time, color=GREY, linewidth=0.8, linestyle=":")
            axes.set(ylabel=_DRAWN.get(name, with_unit(name, found[name].unit)), xlim=found.span)
        panels[-1].set_xlabel("time (s)")
        drawn.figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return drawn
