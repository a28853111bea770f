"""Keys of a scenario found from measured data: the call, its result and its report."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import pandas as pd

from oblique_impact.errors import InputError
from oblique_impact.files import save_text, writing
from oblique_impact.history.history import History
from oblique_impact.progress import OnProgress, silent
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.messages import counted
from oblique_impact.scenario.scenario import Scenario, require_scenario
from oblique_impact.scenario.schema import label_of
from oblique_impact.validation.report import Block, Cell, Column, Picture, Section, Table, picture, with_unit
from oblique_impact.validation.result import Result
from oblique_impact.validation.studies.fitting import intervals, least_squares
from oblique_impact.validation.studies.fitting.intervals import Estimate, caveats, find_intervals
from oblique_impact.validation.studies.fitting.least_squares import (
    FitProblem,
    Parameter,
    SearchResult,
    find_keys,
    parameters_of,
    shifts_of,
)
from oblique_impact.validation.studies.fitting.measured import Campaign, Experiment, read_measured

STARTS, MOST_STARTS = 4, 100
#: series that the report draws at most, and values of the whole run that it lists
_DRAWN, _LISTED = 8, 200


#: what determines an interval, which is the verdict on its key
_KINDS = {"Jacobian": "pass", "profile": "partly", "no effect": "fail"}
_COLUMNS = {
    "meaning": Column("parameter", text=True, page=True),
    "key": Column(code=True),
    "unit": Column(),
    "start": Column(page=True),
    "value": Column(within="half_width"),
    "low": Column("95 % from", within="half_width"),
    "high": Column("to", within="half_width"),
    "verdict": Column("interval by"),
}


def fit(
    scenario: Scenario,
    data: str | os.PathLike[str],
    *,
    vary: Sequence[str],
    others: Sequence[tuple[Scenario, str | os.PathLike[str]]] = (),
    shift: str = "",
    starts: int = STARTS,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    name: str = "scenario",
    on_progress: OnProgress = silent,
) -> Result:
    """Find the keys of a scenario, or of several, with which they say what was measured.

    Parameters
    ----------
    scenario : Scenario
        Holds all that is known, and a first guess of the rest.
    data : path
        A file as of :mod:`~oblique_impact.validation.studies.fitting.measured`.
    vary : sequence of str
        Keys "section.key"; "key,key" have the same value, "key=low:high" stays in a range.  In all scenarios in
        which it acts a key has the same value.
    others : sequence of (Scenario, path)
        Further scenarios with their data, fitted together with the first.
    shift : str
        A range "low:high" (s) of a time by which series are late, one for each scenario that has any; default:
        they are on time.
    starts : int
        Starts of the search, the first from the scenario.
    out : path, optional
        Folder for report.html, results.json, a CSV for each frame, and scenario.toml, the fitted one, of others
        scenario-2.toml and so on.
    workers : int, optional
        Parallel processes; default: the cores.
    name : str
        What the scenario is called in the report.
    on_progress : callable
        Called after each start, and after each end of a profile.

    Returns
    -------
    Result
        A row for each key: `start`, `value`, `low` and `high` of its 95 % interval (infinite or 0 where it is
        open, NaN of a key without effect); the verdict says what that is from, "Jacobian", "profile" or "no
        effect".  The tables are `data` (a row for each value: `column`, `unit`, `time` (s), `measured`,
        `deviation`, `fitted`, `residual`, which is measured less fitted over the deviation), `correlation` of the
        keys with an effect (of their logarithms, where positive) and `starts` (where each began and ended, and the
        sum of squares there, infinite where no run has all that was measured).  The fitted scenario is
        ``scenarios["fitted"]``, those of others ``scenarios["fitted 2"]`` and so on; `data` has their number then.

    Raises
    ------
    InputError
        In one line for a faulty file or key, for too few values, or if no start has all that was measured.
    """
    started = time.perf_counter()
    if not 1 <= starts <= MOST_STARTS:
        raise InputError(f"--starts {starts}: should be from 1 to {MOST_STARTS}")
    pairs = [(require_scenario(one, "fit"), path) for one, path in ((scenario, data), *others)]
    parameters = parameters_of(vary, [one for one, _ in pairs])
    campaign = Campaign(tuple(Experiment(str(path), one, read_measured(path, one)) for one, path in pairs))
    if shift:
        parameters += shifts_of(shift, campaign.experiments)
    table = campaign.table
    if not campaign.has_deviations and table["deviation"].notna().any():
        raise InputError(f"{data}: give standard deviations in all files, or in none")
    count, least = len(table), len(parameters) + (not campaign.has_deviations)
    if count < least:
        raise InputError(f"{data}: {count} values for {len(parameters)} keys: at least {least} are needed")
    campaign = Campaign(tuple(_shortened(one, parameters) for one in campaign.experiments))
    with writing(out):
        problem = FitProblem(campaign, parameters, campaign.first_deviations())
        found = find_keys(problem, starts, workers, on_progress)
        estimate = find_intervals(found.problem, found.solutions[found.best], workers, on_progress)
        found.solutions[found.best] = estimate.solution
        u = estimate.solution.u
        runs = found.problem.runs(u)
        fitted = table.assign(deviation=found.problem.deviations, fitted=found.problem.predict(u, runs))
        fitted = fitted.assign(residual=-estimate.solution.residuals)
        if not others:
            fitted = fitted.drop(columns="scenario")
        names = ["fitted", *(f"fitted {number}" for number in range(2, len(pairs) + 1))]
        scenarios = zip(found.problem.scenarios(u), pairs, strict=True)
        whole = [one.replace(end_time=given.end_time) for one, (given, _) in scenarios]
        histories = {of: run for of, run in zip(names, runs, strict=True) if isinstance(run, History)}
        squares, freedom = estimate.solution.squares, estimate.degrees_of_freedom
        words = f"{squares:.4g} on {counted(freedom, 'degree')} of freedom"
        result = Result(
            "Fit of a scenario to measured data",
            f"Keys of {Path(name).name}, found from {count} measured values by least squares.",
            "keys",
            _keys(found.problem, estimate).set_index("key"),
            _KINDS,
            _COLUMNS,
            "Values with their 95 % intervals; an end that is infinite, or 0, is open.",
            tables={"data": fitted, "correlation": estimate.correlation, "starts": _starts(found)},
            remarks=[f"sum of squares {words}", *caveats(found, estimate, runs, workers)],
            rule=[
                " ".join(text.split()) for text in f"{least_squares.__doc__}\n\n{intervals.__doc__}".split("\n\n")
            ],
            scenarios=dict(zip(names, whole, strict=True)),
            histories=histories,
            about={"sum_of_squares": squares, "degrees_of_freedom": freedom, "fit_report": estimate.report},
            seconds=time.perf_counter() - started,
            overview=lambda result: _data_and_fit(result.tables["data"]),
            sections=_sections,
        )
        if out is not None:
            result.save(out)
            for number, one in enumerate(whole, start=1):
                save_text(Path(out) / f"scenario{f'-{number}' * (number > 1)}.toml", one.to_toml())
    return result


def _shortened(one: Experiment, parameters: Sequence[Parameter]) -> Experiment:
    """Return an experiment whose run ends with its series, if nothing else is asked of it."""
    if not one.measured.needs_times_alone:
        return one
    late = max((p.limits[1] for p in parameters if p.shifts is not None), default=0.0)
    end = min(float(one.measured.table["time"].max()) + max(late, 0.0), one.scenario.end_time)
    return one._replace(scenario=one.scenario.replace(end_time=end))


def _keys(problem: FitProblem, estimate: Estimate) -> pd.DataFrame:
    """Return a row for each key: start, value, interval."""
    columns, rows = ["key", "unit", "start", "value", "low", "high", "half_width", "verdict", "meaning"], []
    for p, u, interval in zip(problem.parameters, estimate.solution.u, estimate.intervals, strict=True):
        numbers = [p.start, *(p.value(x) for x in (u, interval.low, interval.high))]
        half = 0.5 * (numbers[3] - numbers[2])
        label = "how late series are" if p.shifts is not None else ""
        rows += [[key, p.unit, *numbers, half, interval.kind, label or label_of(key)] for key in p.keys]
    return pd.DataFrame(rows, columns=columns)


def _starts(found: SearchResult) -> pd.DataFrame:
    """Return a row for each start: from where to where, and the sum of squares."""
    table = pd.DataFrame()
    for k, p in enumerate(found.problem.parameters):
        table[f"{p.label} from"] = [p.value(u[k]) for u in found.points]
        table[f"{p.label} to"] = [p.value(solution.u[k]) for solution in found.solutions]
    return table.assign(sum_of_squares=[solution.squares for solution in found.solutions])


# --- page


def _sections(result: Result) -> Iterator[Section]:
    """Yield correlations, the report of lmfit, and the starts."""
    lines = [[Cell(line.strip(), "code")] for line in str(result.about["fit_report"]).splitlines()]
    correlation = result.tables["correlation"].rename_axis("key")
    columns = {str(name): Column(str(name), 3, code=True) for name in ("key", *correlation)}
    words = "Of logarithms where keys are positive."
    yield Section("Correlation", [Table.of_frame(correlation, words, columns)])
    yield Section("Report of lmfit", [Table(["lmfit"], lines)], opened=False)
    starts = result.tables["starts"]
    words = "Where each began and ended, and the sum of squares there, over the deviations of the result."
    columns = {str(name): Column(str(name).replace("sum_of", "sum of")) for name in starts}
    yield Section("Starts", [Table.of_frame(starts, words, columns)])


def _data_and_fit(data: pd.DataFrame) -> list[Block]:
    """Return the pictures of series, and the table of other quantities."""
    timed = data["time"].notna()
    by = ["scenario", "column"] if "scenario" in data else ["column"]
    series = [*data[timed].groupby(by, sort=False)][:_DRAWN]
    found: list[Block] = [_series_picture(" of scenario ".join(map(str, of[::-1])), rows) for of, rows in series]
    shown = data[~timed].head(_LISTED)[[*by, "unit", "measured", "deviation", "fitted", "residual"]]
    if len(shown):
        found.append(Table.of_frame(shown, "Values of the whole run, or at rest.", digits=4))
    return found


def _series_picture(name: str, data: pd.DataFrame) -> Picture:
    """Draw a series, its fit, and the residuals under them."""
    data = data.sort_values("time")
    caption = f"{name}: measured, and of the fitted run; below the residuals over their deviation."
    with picture(caption, height=3.8) as drawn:
        above, below = drawn.figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        above.plot(data["time"], data["measured"], ".", color=GREY, markersize=3, label="measured")
        above.plot(data["time"], data["fitted"], color=SERIES[0], linewidth=1.2, label="fitted")
        below.plot(data["time"], data["residual"], ".", color=GREY, markersize=3)
        above.set(ylabel=with_unit(name, data["unit"].iloc[0]))
        below.set(xlabel="time (s)", ylabel="residual")
        above.legend()
    return drawn
