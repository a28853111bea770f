"""Histories compared: their events aligned, everything they sampled, their collisions; with a report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from oblique_impact.beam.validity.integration import ROUNDING
from oblique_impact.errors import InputError
from oblique_impact.files import prepare_folder
from oblique_impact.history.history import History, require_history
from oblique_impact.history.sample_times import jumps
from oblique_impact.renders import panels
from oblique_impact.renders.style import GREY
from oblique_impact.scenario.messages import counted
from oblique_impact.validation.event_pairs import align, largest_difference, pair_events
from oblique_impact.validation.report import (
    Cell,
    Picture,
    Report,
    Section,
    Table,
    Text,
    cell,
    listed,
    number_within,
    picture,
    provenance_data,
    shown_unit,
    write_json,
)
from oblique_impact.validation.report.parameters import changed_keys, differing, parameters
from oblique_impact.validation.runs import column
from oblique_impact.validation.studies.quantities import default_quantities, quantity
from oblique_impact.validation.studies.study import measure, same_warnings

Array = NDArray[np.float64]
Pair = tuple[Array, Array]

#: events further apart than this part of the common span are not the same event
MAX_SHIFT = 0.1
#: times (s) are the same within this part of the span
SAME = 1e-12
#: rows of a table of the report from which on it is folded
_LONG = 30
_COLLISION = {"start": "s", "end": "s", "contacts": "1"}
_COLLISION |= {"normal_impulse": "N s", "tangential_impulse": "N s", "peak_force": "N"}
_ENERGIES = ("final", "lost_impact", "lost_friction", "lost_damping", "lost_scheme")
#: columns of the differences of variables
_COLUMNS = [
    "unit",
    "scale",
    *(f"{clock}_{name}" for clock in ("plain", "aligned") for name in ("rms", "largest", "at")),
]
#: times are shown to this part of the common span
_SHOWN = 1e-5
#: what the picture shows, if all histories have it and it is not 0 throughout, and what it is called
_DRAWN = {
    "gap": "gap",
    "theta_dot": "angular velocity",
    "lambda_n": "normal force",
    "slip_rate": "slip velocity",
}


@dataclass(frozen=True, repr=False)
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
        """Outcomes of both runs."""
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
        names = dict(zip(("left", "right"), (history.scenario for history in self.histories), strict=True))
        return {key: (a, b) for key, (a, b) in changed_keys(names).items()}

    @property
    def warnings(self) -> list[tuple[str, str]]:
        """Warnings of the runs, each with the name of its run, or of both."""
        return _warnings(self.histories, self.names)

    def summary(self) -> list[str]:
        """Return which keys of the scenarios, outcomes, events and contact states differ, and the warnings."""
        left, right = self.names
        outcomes, changed = list(dict.fromkeys(self.outcomes)), self.changed_keys
        return [
            f"{left} and {right}, {self.span[0]:g} to {self.span[1]:g} s",
            f"scenarios: {counted(len(changed), 'key')} {'differs' if len(changed) == 1 else 'differ'}",
            *(f"  {key}: {a} in {left}, {b} in {right}" for key, (a, b) in changed.items()),
            f"outcome{'s' if len(outcomes) > 1 else ''}: {', '.join(outcomes)}",
            _events(self),
            *(f"warning ({names}): {text}" for names, text in self.warnings),
        ]

    def to_dataframe(self) -> pd.DataFrame:
        """Return the differences of the variables, a row each: `variables`."""
        return self.variables

    def __str__(self) -> str:
        table = self.variables.to_string(float_format=lambda value: f"{value:.3g}")
        return "\n".join([*self.summary(), "", table])

    def __repr__(self) -> str:
        """Return which keys differ, how the two agree, and the warnings of both."""
        line = f"<Comparison: {', '.join(self.changed_keys) or 'no key'} differs; {_events(self)}>"
        return "\n".join([line, *(f"  warning ({names}): {text}" for names, text in self.warnings)])

    def _repr_html_(self) -> str:
        """Show the head of the report in a notebook."""
        return report([self])._repr_html_()


class Comparisons(list[Comparison]):
    """Comparisons with the same first run."""

    def _repr_html_(self) -> str:
        """Show the head of the report in a notebook."""
        return report(self)._repr_html_()


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
        pd.DataFrame(rows, _COLUMNS).T,
        _measures(left, right, (start, end), limit),
        _disagreement(aligned, states),
        [name for name in every if name not in rows and name != "state"],
    )


def compare_all(histories: Sequence[History], names: Sequence[str] = ()) -> Comparisons:
    """Compare histories with the first of them, as `compare` does; `report` and `save_comparison` take the list.

    Parameters
    ----------
    histories : sequence of History
        At least two.
    names : sequence of str
        What they are called; default: "run 1", "run 2", ...

    Raises
    ------
    InputError
        In one line, if there are fewer, or one has no time in common with the first.
    """
    if len(histories) < 2:
        raise InputError("compare: takes at least two runs")
    first, *others = names or [f"run {number}" for number in range(1, len(histories) + 1)]
    pairs = zip(histories[1:], others, strict=True)
    return Comparisons(compare(histories[0], other, names=(first, name)) for other, name in pairs)


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
    meshes = [getattr(history.scenario, "discretization", None) for history in (left, right)]
    if name in ("q", "qd") and meshes[0] != meshes[1]:
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


# --- report


def check_target(out: Path) -> None:
    """Raise InputError for a file of another kind than a page (.html) or numbers (.json)."""
    if out.suffix not in (".html", ".json"):
        raise InputError(f"--out {out}: should end in .html or .json")


def save_comparison(found: Comparison | Sequence[Comparison], out: Path) -> Path:
    """Write a page (.html) or the numbers (.json) of one comparison, or of several with the same run.

    Raises InputError for another suffix, or if the file cannot be written.
    """
    check_target(out)
    folder, pairs = prepare_folder(out.parent), [found] if isinstance(found, Comparison) else found
    if out.suffix == ".json":
        return write_json(out, comparison_data(pairs))
    return report(pairs).write(folder, name=out.name)


def comparison_data(pairs: Sequence[Comparison]) -> dict[str, Any]:
    """Return everything that was found, in SI units, for JSON; differences are right minus left.

    Of several comparisons it is the list `comparisons`.
    """
    found = [_pair_data(pair) for pair in pairs]
    return (found[0] if len(found) == 1 else {"comparisons": found}) | provenance_data()


def _pair_data(found: Comparison) -> dict[str, Any]:
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
    tables = {name: getattr(found, name).rename_axis("name").reset_index() for name in ("variables", "measures")}
    warnings = [{"runs": runs, "warning": text} for runs, text in found.warnings]
    return {name: getattr(found, name) for name in names} | {"warnings": warnings} | tables


def report(pairs: Sequence[Comparison]) -> Report:
    """Return the report of comparisons with the same first run."""
    names = [pairs[0].names[0], *(pair.names[1] for pair in pairs)]
    histories = [pairs[0].histories[0], *(pair.histories[1] for pair in pairs)]
    scenarios = dict(zip(names, (history.scenario for history in histories), strict=True))
    warnings = [[text, runs] for runs, text in _warnings(histories, names)]
    return Report(
        f"Comparison of {listed(names)}",
        f"Runs side by side. Differences are those from {names[0]}.",
        overview=[
            differing(scenarios),
            _runs(histories, names),
            *(Text(f"{_events(pair)}.") for pair in pairs),
            Table(["warning", "runs"], warnings, "Warnings.", wide=(0,)),
            _picture(histories, names, pairs),
            _envelopes(histories, names),
        ],
        sections=[*(section for pair in pairs for section in _sections_of(pair)), *parameters(scenarios)],
    )


def _warnings(histories: Sequence[History], names: Sequence[str]) -> list[tuple[str, str]]:
    """Return the warnings of runs, each with the names of those that have it."""
    texts = ["\n".join(history.summary.get("warnings", ())) for history in histories]
    return [(listed(runs), text) for text, runs in same_warnings(zip(names, texts, strict=True))]


def _events(found: Comparison) -> str:
    """Return how events and contact states agree, in a sentence."""
    (left, right), shared = found.names, len(found.shared)
    counts = [shared + len(alone) for alone in (found.only_left, found.only_right)]
    apart = f", which are at most {found.largest_shift:.2g} s apart" if shared else ""
    return (
        f"{left} and {right} share {shared} of {counts[0]} and {counts[1]} events between {found.span[0]:g} and "
        f"{found.span[1]:g} s{apart}; their contact states differ in {100.0 * found.state_disagreement:.2g} % of "
        "the time"
    )


def _runs(histories: Sequence[History], names: Sequence[str]) -> Table:
    """Return the table of the runs, a column for each."""
    asked = [name for one in histories if one.scenario for name in default_quantities(one.scenario)]
    asked = list(dict.fromkeys([*asked, "energy_lost", "events"]))
    found = [measure(history, asked) for history in histories]
    rows: list[list[Any]] = [["outcome", "", *(Cell(one["outcome"], "number") for one in found)]]
    rows += [["end of the run", "s", *(cell(one["stopped_at"]) for one in found)]]
    for q in map(quantity, asked):
        values = [_clear(one[q.name], q.unit, one["energy"]) for one in found]
        rows.append([q.meaning, shown_unit(q.unit), *(cell(value, 5) for value in values)])
    return Table(["quantity", "unit", *names], rows, "The runs.", wide=(0,))


def _clear(value: float, unit: str, energy: float) -> float:
    """Return a value without what is rounding beside the energy (J) of its run."""
    return 0.0 if unit == "J" and abs(value) < ROUNDING * energy else value


def _sections_of(found: Comparison) -> list[Section]:
    """Return the sections of one pair: variables, events, collisions and energies."""
    left, right = found.names
    span = found.span[1] - found.span[0]

    def time(value: float) -> Cell:
        return Cell(number_within(value, _SHOWN * span), "number")

    variables = []
    for name, row in found.variables[found.variables["scale"] > 0.0].iterrows():
        long = str(found.histories[0][str(name)].attrs.get("long_name", ""))
        found_at = [
            time(row[column]) if column.endswith("_at") else cell(row[column] / row["scale"], 2)
            for column in _COLUMNS[2:]
        ]
        variables.append([long, Cell(str(name), "code"), row["unit"], cell(row["scale"], 4), *found_at])
    caption = (
        f"Differences of {right} from {left}, root of the mean square and largest one, relative to the range of "
        "the values: at the same time; and aligned, on a clock in which shared events coincide. Variables that "
        "are 0 in both are left out."
    )
    events = [
        [
            event.kind,
            event.state,
            time(event.left_time),
            time(event.right_time),
            cell(event.time_difference, 2),
            cell(event.left_impulse, 5),
            cell(event.right_impulse, 5),
        ]
        for event in found.events.itertuples()
    ]
    columns = ["event", "state after it", f"{left}: time (s)", f"{right}: time (s)", "difference (s)"]
    columns += [f"{left}: normal impulse (N s)", f"{right}: normal impulse (N s)"]
    energy = max(abs(history.balance[key]) for history in found.histories for key in ("initial", "final"))
    measures = []
    for name, row in found.measures.iterrows():
        values = [_clear(row[column], row["unit"], energy) for column in ("left", "right", "difference")]
        cells = [cell(value, digits) for value, digits in zip(values, (6, 6, 2), strict=True)]
        measures.append([name, shown_unit(row["unit"]), *cells])
    heading = ["quantity", "symbol", "unit", "range", "rms", "largest", "at (s)"]
    heading += ["rms, aligned", "largest, aligned", "at (s)"]
    skipped = f"Not compared: {', '.join(found.skipped)}, which only one run has, or in other coordinates."
    tables = {
        "variables": Table(heading, variables, caption),
        "events": Table(columns, events, "Events; – where there is no partner."),
        "collisions and energies": Table(
            ["quantity", "unit", left, right, "difference"], measures, "Macro-collisions and energies."
        ),
    }
    return [
        *(
            Section(f"{right}: {title}", [table], "", counted(len(table.rows), "row"), len(table.rows) <= _LONG)
            for title, table in tables.items()
        ),
        Section(f"{right}: not compared", [Text(skipped) if found.skipped else None]),
    ]


def _picture(histories: Sequence[History], names: Sequence[str], pairs: Sequence[Comparison]) -> Picture:
    """Draw the runs on top of each other, fields at their last station."""
    shared = [name for name in pairs[0].variables.index if all(name in pair.variables.index for pair in pairs)]
    moving = [
        name for name in _DRAWN if name in shared and any(history[name].values.any() for history in histories)
    ]
    drawn_names = moving or shared[:1]
    caption = "The runs over time" + ("; dotted lines are events that only one has." if len(pairs) == 1 else ".")
    alternative = f"{', '.join(drawn_names)} of {listed(names)} over time."
    runs = panels.Runs(histories, names)
    clock = panels.clock(min(pair.span[0] for pair in pairs), max(pair.span[1] for pair in pairs))
    with picture(caption, height=2.2 * len(drawn_names) + 0.5, alternative=alternative) as drawn:
        places = drawn.figure.subplots(len(drawn_names), 1, sharex=True, squeeze=False).ravel()
        for axes, name in zip(places, drawn_names, strict=True):
            shown = panels.gap(runs) if name == "gap" else panels.variable(runs, name, _DRAWN.get(name, name))
            panels.draw_curves(axes, shown, clock)
            if len(pairs) == 1:  # of more runs the lines would hide them
                for time in (*pairs[0].only_left["left_time"], *pairs[0].only_right["right_time"]):
                    axes.axvline(float(clock.at(time)), color=GREY, linewidth=0.8, linestyle=":")
            axes.label_outer()
        drawn.figure.legend(*places[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return drawn


def _envelopes(histories: Sequence[History], names: Sequence[str]) -> Picture | None:
    """Draw least and largest values along the beam in the runs; None for systems that are no beams."""
    if any(history.scenario is None for history in histories):
        return None
    runs, what = panels.Runs(histories, names), list(panels.ENVELOPES)
    caption = "Least and largest values in the runs, along the beam."
    with picture(caption, height=5.0, alternative=f"{listed(what)} of {listed(names)} along the beam.") as drawn:
        places = drawn.figure.subplots(2, 2).ravel()
        for axes, one in zip(places, what, strict=True):
            panels.draw_envelope(axes, runs, one)
        drawn.figure.legend(*places[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return drawn
