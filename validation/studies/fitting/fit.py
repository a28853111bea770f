"""Keys of a scenario found from measured data: the call, its result and its report."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from oblique_impact.errors import InputError
from oblique_impact.files import save_text, writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.scenario import Scenario, require_scenario
from oblique_impact.scenario.schema import label_of
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.report import (
    Block,
    Cell,
    Picture,
    Report,
    Section,
    Table,
    Text,
    number_within,
    picture,
    shown_unit,
    with_unit,
)
from oblique_impact.validation.report.parameters import parameters as section_of_parameters
from oblique_impact.validation.studies.fitting import intervals, least_squares
from oblique_impact.validation.studies.fitting.intervals import Estimate, caveats, find_intervals
from oblique_impact.validation.studies.fitting.least_squares import (
    FitProblem,
    SearchResult,
    find_keys,
    parameters_of,
)
from oblique_impact.validation.studies.fitting.measured import read_measured

STARTS, MOST_STARTS = 4, 100
#: series that the report draws at most, and values of the whole run that it lists
_DRAWN, _LISTED = 8, 200


@dataclass(frozen=True, repr=False)
class FitResult:
    """Keys that fit measured data."""

    #: the fitted one
    scenario: Scenario
    #: a row for each: `key`, `unit`, `start`, `value`, `low` and `high` of the 95 % interval (infinite or 0 where
    #: it is open, NaN of a key without effect), `interval`, which is "Jacobian", "profile" or "no effect"
    keys: pd.DataFrame
    #: a row for each value: `column`, `unit`, `time` (s), `measured`, `deviation`, `fitted`, `residual` (measured
    #: less fitted, over the deviation)
    data: pd.DataFrame
    #: of the keys with an effect (of their logarithms, where positive)
    correlation: pd.DataFrame
    #: a row for each start: where it began, where it ended, and `sum_of_squares` there, infinite where no run has
    #: all that was measured
    starts: pd.DataFrame
    #: of the residuals over their deviations, which are the same for all starts
    sum_of_squares: float
    degrees_of_freedom: int
    #: what lmfit reports: statistics, values with standard errors, correlations
    fit_report: str
    #: what stands against the result, and warnings of the fitted run
    warnings: tuple[str, ...]
    #: wall time (s)
    seconds: float

    def __repr__(self) -> str:
        """Return a line for each key, the sum of squares, and what stands against them."""
        return "\n".join(["<FitResult>", *(f"  {line}" for line in lines(self))])

    def _repr_html_(self) -> str:
        """Show the head of the report in a notebook."""
        return report(self)._repr_html_()

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each key: `keys`."""
        return self.keys

    def value(self, key: str) -> float:
        """Fitted value of a key."""
        return float(self.scenario.value_of(key))

    def interval(self, key: str) -> tuple[float, float]:
        """Its 95 % interval."""
        row = self.keys.set_index("key").loc[key]
        return float(row["low"]), float(row["high"])


def fit(
    scenario: Scenario,
    data: str | os.PathLike[str],
    *,
    vary: Sequence[str],
    starts: int = STARTS,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    name: str = "scenario",
    on_progress: OnProgress = silent,
) -> FitResult:
    """Find the keys of a scenario with which it says what was measured.

    Parameters
    ----------
    scenario : Scenario
        Holds all that is known, and a first guess of the rest.
    data : path
        A file as of :mod:`~oblique_impact.validation.studies.fitting.measured`.
    vary : sequence of str
        Keys "section.key"; "key,key" have the same value, "key=low:high" stays in a range.
    starts : int
        Starts of the search, the first from the scenario.
    out : path, optional
        Folder for report.html, results.json, results.csv with the residuals, and scenario.toml, the fitted one.
    workers : int, optional
        Parallel processes; default: the cores.
    name : str
        What the scenario is called in the report.
    on_progress : callable
        Called after each start, and after each end of a profile.

    Raises
    ------
    InputError
        In one line for a faulty file or key, for too few values, or if no start has all that was measured.
    """
    started, base = time.perf_counter(), require_scenario(scenario, "fit")
    parameters = parameters_of(vary, base)
    if not 1 <= starts <= MOST_STARTS:
        raise InputError(f"--starts {starts}: should be from 1 to {MOST_STARTS}")
    measured = read_measured(data, base)
    count, least = len(measured.table), len(parameters) + (not measured.has_deviations)
    if count < least:
        raise InputError(f"{data}: {count} values for {len(parameters)} keys: at least {least} are needed")
    if measured.table["time"].notna().all():  # of series the rest of the run is not needed
        base = base.replace(end_time=float(measured.table["time"].max()))
    with writing(out):
        problem = FitProblem(base, parameters, measured, measured.first_deviations())
        found = find_keys(problem, starts, workers, on_progress)
        estimate = find_intervals(found.problem, found.solutions[found.best], workers, on_progress)
        found.solutions[found.best] = estimate.solution
        history = simulate(found.problem.scenario(estimate.solution.u))
        fitted = measured.table.assign(deviation=found.problem.deviations, fitted=measured.predict(history))
        result = FitResult(
            scenario=found.problem.scenario(estimate.solution.u).replace(end_time=scenario.end_time),
            keys=_keys(found.problem, estimate),
            data=fitted.assign(residual=-estimate.solution.residuals),
            correlation=estimate.correlation,
            starts=_starts(found),
            sum_of_squares=estimate.solution.squares,
            degrees_of_freedom=estimate.degrees_of_freedom,
            fit_report=estimate.report,
            warnings=tuple(caveats(found, estimate, history, workers)),
            seconds=time.perf_counter() - started,
        )
        if out is not None:
            numbers = {**vars(result), "correlation": result.correlation.to_dict()}
            numbers["times"] = {"wall_time": numbers.pop("seconds")}
            report(result, name).write(Path(out), numbers, result.data)
            save_text(Path(out) / "scenario.toml", result.scenario.to_toml())
    return result


def _keys(problem: FitProblem, estimate: Estimate) -> pd.DataFrame:
    """Return a row for each key: start, value, interval."""
    columns, rows = ["key", "unit", "start", "value", "low", "high", "interval"], []
    for p, u, interval in zip(problem.parameters, estimate.solution.u, estimate.intervals, strict=True):
        numbers = [p.start, *(p.value(x) for x in (u, interval.low, interval.high))]
        rows += [[key, p.unit, *numbers, interval.kind] for key in p.keys]
    return pd.DataFrame(rows, columns=columns)


def _starts(found: SearchResult) -> pd.DataFrame:
    """Return a row for each start: from where to where, and the sum of squares."""
    table = pd.DataFrame()
    for k, p in enumerate(found.problem.parameters):
        table[f"{p.label} from"] = [p.value(u[k]) for u in found.points]
        table[f"{p.label} to"] = [p.value(solution.u[k]) for solution in found.solutions]
    return table.assign(sum_of_squares=[solution.squares for solution in found.solutions])


# --- report


def lines(result: FitResult) -> list[str]:
    """Return what a fit found in lines, for a terminal."""
    found = []
    for row in result.keys.itertuples():
        known = row.interval != "no effect"
        interval = f"  95 %: {row.low:.5g} to {row.high:.5g} ({row.interval})" if known else ""
        found.append(f"{row.key:28} {row.value:.6g} {shown_unit(row.unit)}{interval}")
    return [*found, *result.fit_report.splitlines(), *result.warnings]


def _squares(result: FitResult) -> str:
    return f"{result.sum_of_squares:.4g} on {result.degrees_of_freedom} degrees of freedom"


def report(result: FitResult, name: str = "scenario") -> Report:
    """Return the report: keys with their intervals, data and fit, residuals, correlations, starts."""
    name = Path(name).name
    starts = result.starts.rename(columns={"sum_of_squares": "sum of squares"})
    of_starts = "Where each began and ended, and the sum of squares there, over the deviations of the result."
    correlation = result.correlation.rename_axis("key").reset_index()
    of_lmfit = Table(["lmfit"], [[Cell(line.strip(), "code")] for line in result.fit_report.splitlines()])
    method = f"{least_squares.__doc__}\n\n{intervals.__doc__}".split("\n\n")
    return Report(
        "Fit of a scenario to measured data",
        f"Keys of {name}, found from {len(result.data)} measured values by least squares.",
        result.seconds,
        facts=[("sum of squares", _squares(result))],
        overview=[_table_of_keys(result.keys), *(Text(f"{warning}.") for warning in result.warnings)],
        sections=[
            Section("Data and fit", _data_and_fit(result.data)),
            Section("Correlation", [_as_it_is(correlation, "Of logarithms where keys are positive.", 3)]),
            *section_of_parameters({name: result.scenario}, "The fitted scenario."),
            Section("Report of lmfit", [of_lmfit], opened=False),
            Section("Starts", [_as_it_is(starts, of_starts)]),
            Section("How it is found", [Text(" ".join(paragraph.split())) for paragraph in method]),
        ],
    )


def _table_of_keys(keys: pd.DataFrame) -> Table:
    """Return the table of values and intervals, in the digits that the intervals leave."""
    kinds, rows = {"Jacobian": "pass", "profile": "partly", "no effect": "fail"}, []
    for row in keys.itertuples():
        numbers = [number_within(v, 0.5 * (row.high - row.low)) for v in (row.value, row.low, row.high)]
        names = [label_of(row.key), Cell(row.key, "code"), shown_unit(row.unit), row.start]
        rows.append([*names, *(Cell(n, "number") for n in numbers), Cell(row.interval, kinds[row.interval])])
    columns = ["parameter", "key", "unit", "start", "value", "from", "to", "interval by"]
    return Table(columns, rows, "Values with their 95 % intervals; an end that is infinite, or 0, is open.", (0,))


def _as_it_is(frame: pd.DataFrame, caption: str, digits: int = 6) -> Table:
    """Return the table of a frame whose columns are keys."""
    return Table.of_frame(frame, caption, digits, columns={name: name for name in frame})


def _data_and_fit(data: pd.DataFrame) -> list[Block]:
    """Return the pictures of series, or residuals and table of quantities of the whole run."""
    if data["time"].notna().all():
        return [_series_picture(str(name), of) for name, of in [*data.groupby("column", sort=False)][:_DRAWN]]
    shown = data.head(_LISTED)[["column", "unit", "measured", "deviation", "fitted", "residual"]]
    return [_residual_picture(data), Table.of_frame(shown, "Values of the whole run.", digits=4)]


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


def _residual_picture(data: pd.DataFrame) -> Picture:
    """Draw the residuals of quantities of the whole run."""
    with picture("Residuals over their standard deviations; nearly all should lie within 2.", height=2.8) as drawn:
        axes = drawn.figure.subplots()
        axes.axhspan(-2.0, 2.0, color=GREY, alpha=0.15, linewidth=0.0)
        axes.plot(data["column"], data["residual"], "o", color=SERIES[0], markersize=4)
        axes.set(ylabel="residual")
    return drawn
