"""Histories compared: their events aligned, everything they sampled; with a report."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from oblique_impact.beam.validity.integration import ROUNDING
from oblique_impact.errors import InputError, Outcome
from oblique_impact.history.events import Event
from oblique_impact.history.history import History, require_history
from oblique_impact.history.sample_times import jumps
from oblique_impact.history.variables import RATES_ALONG
from oblique_impact.renders import panels
from oblique_impact.renders.style import GREY
from oblique_impact.scenario.messages import counted
from oblique_impact.validation.report import (
    Column,
    Picture,
    Section,
    Table,
    Text,
    listed,
    picture,
)
from oblique_impact.validation.report.parameters import changed_keys
from oblique_impact.validation.result import Result
from oblique_impact.validation.runs import Array, column
from oblique_impact.validation.studies.quantities import default_quantities, quantity
from oblique_impact.validation.studies.study import measure, same_warnings

Pair = tuple[Array, Array]

#: events further apart than this part of the common span are not the same event
MAX_SHIFT = 0.1
#: times (s) are the same within this part of the span
SAME = 1e-12
#: rows of a table of the report from which on it is folded
_LONG = 30
#: quantities of each run, besides those that studies ask for
_ASKED = ("contacts", "lost_impact", "lost_friction", "lost_damping", "lost_scheme", "energy_lost", "events")
#: what the picture shows, if all histories have it and it is not 0 throughout, and what it is called
_DRAWN = {
    "gap": "gap",
    "theta_dot": "angular velocity",
    "lambda_n": "normal force",
    "slip_rate": "slip velocity",
}


#: of the range of a variable: largest difference that is rounding, root of the mean square that hardly is seen
_ROUNDING, _CLOSE = 1e-9, 1e-3
_KINDS = {"same": "pass", "close": "pass", "apart": "partly"}
_RULE = (
    "Differences are those from the first run, at equal times (plain), and on a clock in which each event that "
    "two runs share is at the mean of its two times (aligned), so that an impact a little later does not hide "
    "everything else. Both are exact for courses that are linear between their samples; fields along the beam are "
    "compared at the stations of the first run.",
    f"A variable is the same if its largest aligned difference is at most {_ROUNDING:g} of its range, close if "
    f"the root of their mean square is at most {_CLOSE:g} of it, and else apart. Two runs that are close may "
    "share an error: agreement is no proof.",
)
_SHOWN_COLUMNS = {
    "run": Column(),
    "variable": Column("symbol", code=True),
    "meaning": Column("variable", text=True, page=True),
    "unit": Column(),
    "scale": Column("range", digits=4),
    "plain_rms": Column("rms", digits=2),
    "plain_largest": Column("largest", digits=2),
    "plain_at": Column("at (s)", digits=5, page=True),
    "aligned_rms": Column("rms, aligned", digits=2),
    "aligned_largest": Column("largest, aligned", digits=2),
    "aligned_at": Column("at (s)", digits=5, page=True),
    "verdict": Column(),
}


class _Pair(NamedTuple):
    """A run beside the first one; differences are those of it from that one."""

    variables: pd.DataFrame
    events: pd.DataFrame
    #: row of the table of pairs, see `compare`
    about: dict[str, Any]


def _sentence(first: str, about: dict[str, Any]) -> str:
    """Return how the events and contact states of a pair agree."""
    shared, differ = about["shared_events"], 100.0 * about["state_disagreement"]
    apart = f", which are at most {about['largest_shift']:.2g} s apart" if shared else ""
    return (
        f"{first} and {about['run']} share {shared} of {shared + about['only_left']} and "
        f"{shared + about['only_right']} events between {about['start']:g} and {about['end']:g} s{apart}; their "
        f"contact states differ in {differ:.2g} % of the time"
    )


def compare(left: History, *others: History, names: Sequence[str] = ()) -> Result:
    """Compare histories with the first of them, with their events aligned.

    They may have other output intervals, other discretizations (the beam's variables are taken at common stations)
    and other end times: what both cover is compared.  Events of one kind that are further apart than a tenth of
    the common span are not the same event.

    Parameters
    ----------
    left, *others : History
        At least two, of beams or of user-defined systems.
    names : sequence of str
        What they are called; default: "left" and "right" of two, else "run 1", "run 2", ...

    Returns
    -------
    Result
        A row for each variable (of each other run): unit; `scale`, the range of both in the common span; and the
        root of the mean square over time (and along the beam), the largest difference with its sign and its time
        (s), each at equal times (`plain_...`) and on the common clock (`aligned_...`).  The tables are `events`
        (times (s) and impulses (N s) of both, NaN without a partner), `runs` (what studies measure, a column for
        each) and `pairs` (common span, numbers of events, `largest_shift` (s) of shared ones, part of the time in
        which contact states differ, what is not compared); ``about["largest_shift"]`` is that of all.

    Raises
    ------
    InputError
        In one line, if there are fewer than two, or one has no time in common with the first.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> from oblique_impact.validation import compare
    >>> paper = Scenario.builtin("paper").replace(end_time=0.33)
    >>> found = compare(simulate(paper), simulate(paper.replace(discretization__method="fem")))
    >>> found["theta"].verdict, bool(found["theta"].aligned_rms < 1e-6)
    ('close', True)
    """
    if not others:
        raise InputError("compare: takes at least two runs")
    histories = [left, *others]
    for history in histories:
        require_history(history, "compare")
    names = list(names) or (["left", "right"] if len(others) == 1 else [])
    names = names or [f"run {number}" for number in range(1, len(histories) + 1)]
    pairs = [_pair(left, other, name) for other, name in zip(others, names[1:], strict=True)]
    several = len(pairs) > 1
    runs = dict(zip(names, histories, strict=True))
    scenarios = {name: history.scenario for name, history in runs.items()}
    changed = [f"{key} ({', '.join(map(str, values))})" for key, values in changed_keys(scenarios).items()]
    words = f"{counted(len(changed), 'key')} {'differs' if len(changed) == 1 else 'differ'}"
    remarks = [f"{words}: {', '.join(changed)}" if changed else "no key differs"]
    stopped = {name: history.outcome for name, history in runs.items() if history.outcome is not Outcome.COMPLETED}
    remarks += [f"{name}: {outcome.label}" for name, outcome in stopped.items()]
    remarks += [_sentence(names[0], pair.about) for pair in pairs]
    warnings = ((name, "\n".join(history.summary.get("warnings", ()))) for name, history in runs.items())
    remarks += [f"warning ({listed(having)}): {text}" for text, having in same_warnings(warnings)]
    return Result(
        f"Comparison of {listed(names)}",
        f"Runs side by side. Differences are those from {names[0]}.",
        "variables",
        pd.concat([pair.variables for pair in pairs]),
        _KINDS,
        {name: column for name, column in _SHOWN_COLUMNS.items() if several or name != "run"},
        "Differences, in the units of the variables. Variables that are 0 in both are left out.",
        tables={
            "events": pd.concat([pair.events for pair in pairs]),
            "runs": _runs(runs),
            "pairs": pd.DataFrame([pair.about for pair in pairs]).set_index("run"),
        },
        remarks=remarks,
        rule=_RULE,
        scenarios=scenarios,
        histories=runs,
        about={"largest_shift": max(pair.about["largest_shift"] for pair in pairs)},
        overview=lambda result: [_run_table(result), _picture(result), _envelopes(result)],
        sections=_sections,
    )


def _pair(left: History, right: History, name: str) -> _Pair:
    """Compare two histories."""
    both = left, right
    times = column(left, "time"), column(right, "time")
    start, end = max(float(t[0]) for t in times), min(float(t[-1]) for t in times)
    if min(t.size for t in times) < 2 or not start < end:
        covered = " and ".join(f"{t[0]:g} to {t[-1]:g} s" for t in times)
        raise InputError(f"compare: the histories have no time in common: {covered}")
    logs = [[event for event in history.events if start <= event.time <= end] for history in both]
    pairs = pair_events(logs[0], logs[1], MAX_SHIFT * (end - start))
    aligned = _on_common_clock(times, pairs, end - start)
    every = dict.fromkeys(name for history in both for name in _names(history))
    rows = {name: _difference(name, both, times, aligned) for name in every if _comparable(name, left, right)}
    variables = pd.DataFrame(rows.values(), pd.Index(rows, name="variable")).assign(run=name)
    about = {
        "run": name,
        "start": start,
        "end": end,
        "shared_events": int(pairs["time_difference"].notna().sum()),
        "only_left": int(pairs["right_time"].isna().sum()),
        "only_right": int(pairs["left_time"].isna().sum()),
        "largest_shift": largest_difference(pairs[pairs["time_difference"].notna()]),
        "state_disagreement": _disagreement(aligned, [history["state"].values for history in both]),
        "not_compared": " ".join(name for name in every if name not in rows and name != "state"),
    }
    return _Pair(variables[variables["scale"] > 0.0], pairs.assign(run=name), about)


# --- variables


def _difference(name: str, both: tuple[History, History], times: Pair, aligned: Pair) -> dict[str, Any]:
    """Return the row of a variable."""
    values, weights = _at_common_stations(both, name)
    grid = _union(times)
    inside = np.concatenate([v[(t >= grid[0]) & (t <= grid[-1])] for t, v in zip(times, values, strict=True)])
    finite = inside[np.isfinite(inside)]
    scale = (float(np.ptp(finite)) or float(np.max(np.abs(finite)))) if finite.size else 0.0
    attributes = both[0][name].attrs
    row: dict[str, Any] = {"unit": str(attributes.get("units", "1")), "scale": scale}
    for clock, on_clock in (("plain", times), ("aligned", aligned)):
        found = _deviation(on_clock, values, weights)
        row |= {f"{clock}_{part}": number for part, number in zip(("rms", "largest", "at"), found, strict=True)}
    same, close = abs(row["aligned_largest"]) <= _ROUNDING * scale, row["aligned_rms"] <= _CLOSE * scale
    verdict = "same" if same else "close" if close else "apart"
    return row | {"verdict": verdict, "meaning": str(attributes.get("long_name", ""))}


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


def _names(history: History) -> list[str]:
    """Return the names of variables; those over time alone tell all of a single contact."""
    kept = history.data.drop_vars("qdd", errors="ignore")
    if history.data.sizes.get("contact", 1) == 1:
        kept = kept.drop_dims("contact", errors="ignore").drop_vars("clearance_obstacle", errors="ignore")
    return [*map(str, kept), *(name for name in RATES_ALONG if name in history and name not in kept)]


def _comparable(name: str, left: History, right: History) -> bool:
    """Whether both have a variable of the same dimensions and coordinates that is linear between samples."""
    if not (name in left and name in right):
        return False
    a, b = left[name], right[name]
    meshes = [getattr(history.scenario, "discretization", None) for history in (left, right)]
    if name in ("q", "qd") and meshes[0] != meshes[1]:
        return False
    lengths = [[one.sizes[d] for d in one.dims if d not in ("time", "station")] for one in (a, b)]
    return a.dims == b.dims and a.dtype.kind not in "iu" and lengths[0] == lengths[1]


def _runs(histories: dict[str, History]) -> pd.DataFrame:
    """Return the quantities of the runs, a row each, with a column for each run."""
    asked = [name for one in histories.values() if one.scenario for name in default_quantities(one.scenario)]
    found = {name: measure(history, [*asked, *_ASKED]) for name, history in histories.items()}
    rows = [("end", "end of the run", "s", *(one["stopped_at"] for one in found.values()))]
    for q in map(quantity, dict.fromkeys([*asked, *_ASKED])):
        values = (_clear(one[q.name], q.unit, one["energy"]) for one in found.values())
        rows.append((q.name, q.meaning, q.unit, *values))
    return pd.DataFrame(rows, columns=["quantity", "meaning", "unit", *histories]).set_index("quantity")


def _clear(value: float, unit: str, energy: float) -> float:
    """Return a value without what is rounding beside the energy (J) of its run."""
    return 0.0 if unit == "J" and abs(value) < ROUNDING * energy else value


# --- events


def pair_events(left: Sequence[Event], right: Sequence[Event], max_shift: float = np.inf) -> pd.DataFrame:
    """Align two event logs: the longest common sequence of kinds and states that is closest in time.

    Parameters
    ----------
    left, right : sequence of Event
        In the order of time.
    max_shift : float
        Events further apart (s) are not a pair.

    Returns
    -------
    DataFrame
        A row for each event, in the order of time: kind, state after it, times (s) and normal impulses (N s) of
        both, and their differences, right minus left; NaN without a partner.
    """
    times = [[event.time for event in events] for events in (left, right)]
    kinds = [[(event.kind, event.state) for event in events] for events in (left, right)]
    rows = []
    for i, j in align(times[0], times[1], kinds[0], kinds[1], max_shift):
        one, other = None if i is None else left[i], None if j is None else right[j]
        event = one or other
        assert event is not None
        row: dict[str, object] = {"kind": event.kind.value, "state": event.state.name.lower()}
        for side, found in (("left", one), ("right", other)):
            row |= {f"{side}_time": found.time, f"{side}_impulse": found.normal_impulse} if found else {}
        rows.append(row)
    numbers = ["left_time", "left_impulse", "right_time", "right_impulse"]
    pairs = pd.DataFrame(rows, columns=["kind", "state", *numbers]).astype(dict.fromkeys(numbers, float))
    for name in ("time", "impulse"):
        pairs[f"{name}_difference"] = pairs[f"right_{name}"] - pairs[f"left_{name}"]
    return pairs


def largest_difference(pairs: pd.DataFrame) -> float:
    """Return the largest difference of paired event times (s); infinity if an event has no partner."""
    return float(pairs["time_difference"].abs().fillna(np.inf).max()) if len(pairs) else 0.0


def align(
    left: Sequence[float],
    right: Sequence[float],
    left_kinds: Sequence[Hashable],
    right_kinds: Sequence[Hashable],
    max_shift: float = np.inf,
) -> list[tuple[int | None, int | None]]:
    """Pair two sequences of instants in order: as many pairs as possible, and of these the closest in time.

    Parameters
    ----------
    left, right : sequence of float
        Times (s), ascending.
    left_kinds, right_kinds : sequence
        Only instants of one kind make a pair.
    max_shift : float
        Instants further apart (s) are not a pair.

    Returns
    -------
    list of tuple
        Indices (left, right) in the order of time, None where one has no partner: the longest common subsequence
        with the smallest sum of time differences.
    """
    same = np.array([[a == b for b in right_kinds] for a in left_kinds], dtype=bool).reshape(len(left), len(right))
    apart = np.abs(np.subtract.outer(np.asarray(left, dtype=float), np.asarray(right, dtype=float)))
    largest = float(np.max(apart, initial=0.0)) or 1.0
    # all time differences together count less than one pair
    gain = 1.0 - apart / largest / (2.0 * max(1, min(apart.shape)))
    gain[~same | (apart > max_shift)] = -np.inf
    score = np.zeros((len(left) + 1, len(right) + 1))
    for i in range(len(left)):
        score[i + 1, 1:] = np.maximum.accumulate(np.maximum(score[i, 1:], score[i, :-1] + gain[i]))
    places: list[tuple[int | None, int | None]] = []
    i, j = apart.shape
    while i or j:  # read the pairs off the table, last to first; of two without a partner the later one first
        skip_left = i > 0 and score[i, j] == score[i - 1, j]
        skip_right = j > 0 and score[i, j] == score[i, j - 1]
        if skip_left and not (skip_right and right[j - 1] > left[i - 1]):
            i -= 1
            places.append((i, None))
        elif skip_right:
            j -= 1
            places.append((None, j))
        else:
            i, j = i - 1, j - 1
            places.append((i, j))
    return places[::-1]


# --- report


def _run_table(result: Result) -> Table:
    """Return the table of the runs, a column for each."""
    columns = {"meaning": Column("quantity", text=True), "unit": Column()}
    columns |= {name: Column(name, 5) for name in result.histories}
    return Table.of_frame(result.tables["runs"], "The runs.", columns)


def _sections(result: Result) -> Iterator[Section]:
    """Yield the parts of each pair: variables if there are several pairs, events, what is not compared."""
    left, *others = result.histories
    for right in others:
        variables, events = (frame[frame["run"] == right] for frame in (result.frame, result.tables["events"]))
        if len(others) > 1:
            columns = {name: one for name, one in result.columns.items() if name != "run"}
            yield Section(
                f"{right}: variables", [Table.of_frame(variables, result.caption, columns, result.kinds)]
            )
        columns = {"kind": Column("event"), "state": Column("state after it")}
        for what, unit, digits in (("time", "s", 8), ("impulse", "N s", 5)):
            of = "normal impulse" if what == "impulse" else what
            for side, name in (("left", left), ("right", right)):
                columns[f"{side}_{what}"] = Column(f"{name}: {of} ({unit})", digits)
        columns["time_difference"] = Column("difference (s)", 2)
        table = Table.of_frame(events, "Events; – where there is no partner.", columns)
        yield Section(f"{right}: events", [table], "", counted(len(events), "row"), len(events) <= _LONG)
        skipped = result.tables["pairs"].loc[right, "not_compared"]
        words = f"Not compared, which only one run has, or in other coordinates: {skipped.replace(' ', ', ')}."
        yield Section(f"{right}: not compared", [Text(words) if skipped else None])


def _picture(result: Result) -> Picture:
    """Draw the runs on top of each other, fields at their last station."""
    histories, names, pairs = list(result.histories.values()), list(result.histories), result.tables["pairs"]
    counts = result.frame.index.value_counts()
    shared = [name for name in dict.fromkeys(result.frame.index) if counts[name] == len(pairs)]
    moving = [name for name in _DRAWN if name in shared]
    drawn_names = moving or shared[:1]
    caption = "The runs over time" + ("; dotted lines are events that only one has." if len(pairs) == 1 else ".")
    alternative = f"{', '.join(drawn_names)} of {listed(names)} over time."
    runs, clock = panels.Runs(histories, names), panels.clock(pairs["start"].min(), pairs["end"].max())
    events = result.tables["events"]
    with picture(caption, height=2.2 * len(drawn_names) + 0.5, alternative=alternative) as drawn:
        places = drawn.figure.subplots(len(drawn_names), 1, sharex=True, squeeze=False).ravel()
        for axes, name in zip(places, drawn_names, strict=True):
            shown = panels.gap(runs) if name == "gap" else panels.variable(runs, name, _DRAWN.get(name, name))
            panels.draw_curves(axes, shown, clock)
            if len(pairs) == 1:  # of more runs the lines would hide them
                for event in events[events["time_difference"].isna()].itertuples():
                    time = np.nanmax([event.left_time, event.right_time])
                    axes.axvline(float(clock.at(time)), color=GREY, linewidth=0.8, linestyle=":")
            axes.label_outer()
        drawn.figure.legend(*places[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return drawn


def _envelopes(result: Result) -> Picture | None:
    """Draw least and largest values along the beam in the runs; None for systems that are no beams."""
    histories, names, what = list(result.histories.values()), list(result.histories), list(panels.ENVELOPES)
    if any(history.scenario is None for history in histories):
        return None
    runs = panels.Runs(histories, names)
    caption = "Least and largest values in the runs, along the beam."
    with picture(caption, height=5.0, alternative=f"{listed(what)} of {listed(names)} along the beam.") as drawn:
        places = drawn.figure.subplots(2, 2).ravel()
        for axes, one in zip(places, what, strict=True):
            panels.draw_envelope(axes, runs, one)
        drawn.figure.legend(*places[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return drawn
