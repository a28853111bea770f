"""Two histories compared: their events aligned, everything they sampled, their collisions; with a report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.files import prepare_folder
from oblique_impact.history.history import History, require_history
from oblique_impact.history.sample_times import jumps
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.toml import flat_keys
from oblique_impact.validation.event_pairs import align, largest_difference, pair_events
from oblique_impact.validation.report import (
    Picture,
    Report,
    Section,
    Table,
    Text,
    cell,
    picture,
    provenance_data,
    with_unit,
    write_json,
)
from oblique_impact.validation.runs import column

Array = NDArray[np.float64]
Pair = tuple[Array, Array]

#: events further apart than this part of the common span are not the same event
MAX_SHIFT = 0.1
#: times (s) are the same within this part of the span
SAME = 1e-12
#: events without a partner that a text lists at most
LISTED = 10
_COLLISION = {"start": "s", "end": "s", "contacts": "1"}
_COLLISION |= {"normal_impulse": "N s", "tangential_impulse": "N s", "peak_force": "N"}
_ENERGIES = ("final", "lost_impact", "lost_friction", "lost_damping", "lost_scheme")
#: columns of the differences of variables, with their headings in the report
_COLUMNS = {
    "unit": "unit",
    "scale": "scale",
    "plain_rms": "rms, same time",
    "plain_largest": "largest",
    "plain_at": "at (s)",
    "aligned_rms": "rms, aligned",
    "aligned_largest": "largest",
    "aligned_at": "at (s)",
}
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
    events : DataFrame
        A row for each event, in the order of time: kind, state after it, times (s) and impulses (N s) of both,
        differences; NaN without a partner.
    variables : DataFrame
        A row for each variable: unit; scale, the range of both in the common span; and the root of the mean square
        over time (and along the beam), the largest difference with its sign and its time (s), each at equal times
        (`plain`) and on a clock in which each shared event is at the mean of its two times (`aligned`).
    measures : DataFrame
        A row for each number of collisions and energies: unit, left, right, difference; NaN where one lacks it.
    state_disagreement : float
        Part of the common time, events aligned, in which the contact states differ.
    skipped : sequence of str
        Variables that cannot be compared: those of one history alone, whole numbers, coordinates of different
        discretizations.
    """

    names: tuple[str, str]
    histories: tuple[History, History]
    span: tuple[float, float]
    events: pd.DataFrame
    variables: pd.DataFrame
    measures: pd.DataFrame
    state_disagreement: float
    skipped: Sequence[str]

    def __getitem__(self, name: str) -> pd.Series[Any]:
        """Return the differences of one variable, e.g. ``comparison["theta"].aligned_rms``; raises KeyError."""
        return self.variables.loc[name]

    @property
    def outcomes(self) -> tuple[str, str]:
        """How the two ended."""
        return self.histories[0].outcome.label, self.histories[1].outcome.label

    @property
    def shared(self) -> pd.DataFrame:
        """Events that both have."""
        return self.events[self.events["time_difference"].notna()]

    @property
    def only_left(self) -> pd.DataFrame:
        """Events that only the left history has."""
        return self.events[self.events["right_time"].isna()]

    @property
    def only_right(self) -> pd.DataFrame:
        """Events that only the right history has."""
        return self.events[self.events["left_time"].isna()]

    @property
    def largest_shift(self) -> float:
        """Largest time difference (s) of shared events."""
        return largest_difference(self.shared)

    @property
    def changed_keys(self) -> dict[str, tuple[Any, Any]]:
        """Keys of the scenarios that differ, with both values; "not given" where one does not have the key."""
        left, right = (flat_keys(_sections(history)) for history in self.histories)
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

    def summary(self) -> list[str]:
        """Return how outcomes, events, contact states and scenarios differ, and the warnings, in sentences."""
        left, right = self.names
        outcomes, changed = list(dict.fromkeys(self.outcomes)), self.changed_keys
        alone = [
            f"  only in {name}: {event.kind} -> {event.state} at {getattr(event, f'{side}_time'):.6f} s"
            for name, side, events in ((left, "left", self.only_left), (right, "right", self.only_right))
            for event in events.itertuples()
        ]
        return [
            f"{left} and {right}, {self.span[0]:g} to {self.span[1]:g} s",
            f"outcome{'s' if len(outcomes) > 1 else ''}: {', '.join(outcomes)}",
            f"events: {len(self.shared)} shared, {len(self.only_left)} only in {left}, "
            f"{len(self.only_right)} only in {right}; largest time difference {self.largest_shift:.2g} s",
            *alone[:LISTED],
            *([f"  and {len(alone) - LISTED} more"] if len(alone) > LISTED else []),
            f"contact states differ in {100.0 * self.state_disagreement:.2g} % of the time",
            f"scenarios: {len(changed)} keys differ" if len(changed) != 1 else "scenarios: 1 key differs",
            *(f"  {key}: {a} in {left}, {b} in {right}" for key, (a, b) in changed.items()),
            *(f"warning ({names}): {text}" for names, text in self.warnings),
        ]

    def __str__(self) -> str:
        table = self.variables.to_string(float_format=lambda value: f"{value:.3g}")
        return "\n".join([*self.summary(), "", table])


def compare(left: History, right: History, *, names: tuple[str, str] = ("left", "right")) -> Comparison:
    """Compare two histories, with their events aligned.

    They may have other output intervals, other discretizations (the beam's variables are taken at common stations)
    and other end times: what both cover is compared.  Differences are taken at equal times, and besides them on a
    clock in which shared events coincide, so that an impact a little later does not hide everything else.  Both
    are exact for courses that are linear between their samples.  Events of one kind that are further apart than a
    tenth of the common span are not the same event.

    Parameters
    ----------
    left, right : History
        Of beams or of user-defined systems.
    names : tuple of str
        What the two are called, in tables.

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
    both = left, right
    for history in both:
        require_history(history, "compare")
    times = column(left, "time"), column(right, "time")
    start, end = max(float(t[0]) for t in times), min(float(t[-1]) for t in times)
    if min(t.size for t in times) < 2 or not start < end:
        covered = " and ".join(f"{t[0]:g} to {t[-1]:g} s" for t in times)
        raise InputError(f"compare: the histories have no time in common: {covered}")
    limit = MAX_SHIFT * (end - start)
    logs = [[event for event in history.events if start <= event.time <= end] for history in both]
    pairs = pair_events(logs[0], logs[1], limit)
    aligned = _on_common_clock(times, pairs, end - start)
    every = dict.fromkeys(str(name) for history in both for name in history.data.data_vars)
    rows = {name: _difference(name, both, times, aligned) for name in every if _comparable(name, left, right)}
    states = [history["state"].values for history in both]
    return Comparison(
        names,
        both,
        (start, end),
        pairs,
        pd.DataFrame(rows, list(_COLUMNS)).T,
        _measures(left, right, (start, end), limit),
        _disagreement(aligned, states),
        [name for name in every if name not in rows and name != "state"],
    )


# --- variables


def _difference(name: str, both: tuple[History, History], times: Pair, aligned: Pair) -> list[Any]:
    """Return the entries of `_COLUMNS` of a variable."""
    values, weights = _at_common_stations(both, name)
    grid = _union(times)
    inside = np.concatenate([v[(t >= grid[0]) & (t <= grid[-1])] for t, v in zip(times, values, strict=True)])
    finite = inside[np.isfinite(inside)]
    scale = (float(np.ptp(finite)) or float(np.max(np.abs(finite)))) if finite.size else 0.0
    unit = str(both[0][name].attrs.get("units", "1"))
    return [unit, scale, *_deviation(times, values, weights), *_deviation(aligned, values, weights)]


def _union(times: Pair) -> Array:
    """Return the instants of both in the span that both cover."""
    start, end = max(t[0] for t in times), min(t[-1] for t in times)
    return np.unique(np.clip(np.union1d(*times), start, end))


def _deviation(times: Pair, values: Sequence[Array], weights: Array) -> tuple[float, float, float]:
    """Return root mean square, largest difference and its time of values (samples, points).

    They are linear between samples, of which integrals are exact; the mean over the points has `weights` of sum 1.
    """
    grid = _union(times)
    left, right = (_interpolated(t, v, grid) for t, v in zip(times, values, strict=True))
    apart = np.where(np.isnan(left) & np.isnan(right), 0.0, right - left)
    with np.errstate(invalid="ignore", over="ignore"):
        squares = apart[:-1] ** 2 + apart[:-1] * apart[1:] + apart[1:] ** 2
    mean = np.where(np.isnan(squares), np.inf, squares) @ weights / 3.0
    rms = float(np.sqrt(np.diff(grid) @ mean / (grid[-1] - grid[0])))
    row, point = np.unravel_index(int(np.argmax(np.abs(apart))), apart.shape)
    return rms, float(apart[row, point]), float(grid[row])


def _disagreement(times: Pair, values: Sequence[NDArray[Any]]) -> float:
    """Return the part of the time in which values differ that hold from their sample on to the next."""
    grid = _union(times)
    left, right = (v[np.searchsorted(t, grid[:-1], "right") - 1] for t, v in zip(times, values, strict=True))
    return float(np.diff(grid) @ (left != right) / (grid[-1] - grid[0]))


def _interpolated(x: Array, values: Array, at: Array) -> Array:
    """Return values (samples, points) at other places, linear in between."""
    return np.stack([np.interp(at, x, column) for column in values.T], axis=1)


def _at_common_stations(both: tuple[History, History], name: str) -> tuple[list[Array], Array]:
    """Return values (samples, points) of both, at the stations of the first one, and the weights of a mean.

    Stations beyond the other beam's end are left out.
    """
    values = [column(history, name) for history in both]
    values = [v.reshape(len(v), -1) for v in values]
    if "station" not in both[0][name].dims:
        points = values[0].shape[1]
        return values, np.full(points, 1.0 / points)
    first, second = (column(history, "station") for history in both)
    common = first[first <= second[-1]]
    widths = np.diff(common, prepend=common[0], append=common[-1])
    weights = 0.5 * (widths[1:] + widths[:-1])
    at_common = [values[0][:, : common.size], _interpolated(second, values[1].T, common).T]
    return at_common, weights / weights.sum()


def _on_common_clock(times: Pair, pairs: pd.DataFrame, length: float) -> Pair:
    """Return the times of either on a common clock: shared events at the mean of their times, linear in between.

    The beginnings coincide if they are the same; before the first shared instant and after the last one the clocks
    go on as they are.
    """
    begins = float(times[0][0]), float(times[1][0])
    shared = [begins] if abs(begins[1] - begins[0]) <= SAME * length else []
    for both in pairs[["left_time", "right_time"]].dropna().itertuples(index=False):
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


def _comparable(name: str, left: History, right: History) -> bool:
    """Whether both have a variable of the same dimensions and coordinates that is linear between samples."""
    if not (name in left and name in right):
        return False
    a, b = left[name], right[name]
    if name in ("q", "qd") and _sections(left).get("discretization") != _sections(right).get("discretization"):
        return False
    lengths = [[one.sizes[d] for d in one.dims if d not in ("time", "station")] for one in (a, b)]
    return a.dims == b.dims and a.dtype.kind not in "iu" and lengths[0] == lengths[1]


def _measures(left: History, right: History, span: tuple[float, float], limit: float) -> pd.DataFrame:
    """Return the table of collisions and energies."""
    rows = left.macro_collisions, right.macro_collisions
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
    if abs(column(right, "time")[-1] - column(left, "time")[-1]) <= SAME * (span[1] - span[0]):
        for key in _ENERGIES:
            energies = (history.balance.get(key, np.nan) for history in (left, right))
            measures[f"energy: {key.replace('_', ' ')}"] = ["J", *energies]
    frame = pd.DataFrame.from_dict(measures, orient="index", columns=["unit", "left", "right"])
    frame["difference"] = frame["right"].astype(float) - frame["left"].astype(float)
    return frame


def _sections(history: History) -> dict[str, Any]:
    """Return the sections of the scenario of a history, none of a user-defined system."""
    return history.scenario.model_dump(mode="json") if history.scenario else {}


# --- report


def check_target(out: Path) -> None:
    """Raise InputError for a file of another kind than a page (.html) or numbers (.json)."""
    if out.suffix not in (".html", ".json"):
        raise InputError(f"--out {out}: should end in .html or .json")


def save_comparison(found: Comparison, out: Path) -> Path:
    """Write a page (.html) or the numbers (.json), whole or not at all.

    Raises InputError for another suffix, or if the file cannot be written.
    """
    check_target(out)
    folder = prepare_folder(out.parent)
    if out.suffix == ".json":
        return write_json(out, comparison_data(found))
    return report(found).write(folder, name=out.name)


def comparison_data(found: Comparison) -> dict[str, Any]:
    """Return everything that was found, in SI units, for JSON; differences are right minus left."""
    names = (
        "names",
        "outcomes",
        "changed_keys",
        "span",
        "largest_shift",
        "state_disagreement",
        "events",
        "skipped",
    )
    return {
        **{name: getattr(found, name) for name in names},
        "warnings": [{"runs": runs, "warning": text} for runs, text in found.warnings],
        **{name: getattr(found, name).rename_axis("name").reset_index() for name in ("variables", "measures")},
        **provenance_data(),
    }


def report(found: Comparison) -> Report:
    """Return the report."""
    left, right = found.names
    variables = found.variables.rename_axis("variable").reset_index()
    scale = variables["scale"].where(variables["scale"] > 0.0, 1.0).astype(float)
    for name in ("plain_rms", "plain_largest", "aligned_rms", "aligned_largest"):
        variables[name] = [cell(value, 2) for value in variables[name] / scale]
    caption = (
        "Differences relative to the scale, the range of the values: at the same time; and aligned, on a clock in "
        "which shared events coincide."
    )
    events = {"kind": "event", "state": "then", "left_time": f"{left}: t (s)", "right_time": f"{right}: t (s)"}
    events |= {"time_difference": "difference (s)"}
    events |= {"left_impulse": f"{left}: impulse (N s)", "right_impulse": f"{right}: impulse (N s)"}
    measures = found.measures.rename_axis("measure").reset_index().rename(columns={"left": left, "right": right})
    tables = [
        ("Variables", Table.of_frame(variables, caption, 4, columns={"variable": "variable"} | _COLUMNS)),
        ("Events", Table.of_frame(found.events, digits=9, columns=events) if len(found.events) else None),
        ("Collisions and energies", Table.of_frame(measures, digits=9) if len(measures) else None),
    ]
    return Report(
        f"{left} and {right}",
        f"Two runs side by side, from {found.span[0]:g} to {found.span[1]:g} s. Differences are those of {right} "
        f"from {left}.",
        overview=[*(Text(sentence) for sentence in found.summary()[1:]), _picture(found)],
        sections=[
            *(Section(title, [table]) for title, table in tables if table),
            *([Section("Not compared", [Text(", ".join(found.skipped))])] if found.skipped else []),
        ],
    )


def _picture(found: Comparison) -> Picture:
    """Draw both runs on top of each other, fields at their last station."""
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
            for time in (*found.only_left["left_time"], *found.only_right["right_time"]):
                axes.axvline(time, color=GREY, linewidth=0.8, linestyle=":")
            axes.set(ylabel=_DRAWN.get(name, with_unit(name, found[name].unit)), xlim=found.span)
        panels[-1].set_xlabel("time (s)")
        drawn.figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return drawn
