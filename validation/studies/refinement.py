"""Refinement: one scenario over levels of elements, modes, steps, stiffness or tolerance, and what converges."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.ticker import FuncFormatter, NullLocator

from oblique_impact.beam_problem import SCHEMES
from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import plain, writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.messages import refused
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.report import (
    Cell,
    Picture,
    Report,
    Section,
    Table,
    Text,
    capitalized,
    cell,
    number,
    picture,
    rounded,
    shown_unit,
    with_unit,
)
from oblique_impact.validation.report.parameters import differing, parameters
from oblique_impact.validation.studies.convergence import (
    CONVERGED,
    NO_VERDICT,
    RULE,
    VERDICTS,
    Analysis,
    analyse,
)
from oblique_impact.validation.studies.parallel import check_limits
from oblique_impact.validation.studies.quantities import Quantity, default_quantities, natural_scale, quantity
from oblique_impact.validation.studies.series import (
    AXES,
    Axis,
    RefinementSeries,
    Study,
    check_levels,
    load_study,
)
from oblique_impact.validation.studies.study import reasons, run_study, same_warnings

#: axes that a user can refine
OPTIONS = ("elements", "modes", "steps", "stiffness", "tolerances")
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")
#: quantities that converge at no order of a method: counts, and largest values among samples
_ROUGH = ("contacts", "events", "peak_force", "unaccounted")


@dataclass(frozen=True, repr=False)
class QuantityResult:
    """One quantity over the levels of a series, and what its values say."""

    quantity: Quantity
    #: order that the method declares
    declared: float | None
    #: what a small value is measured by (unit of the value)
    scale: float
    #: why a level does not have it, "" if it does
    gaps: tuple[str, ...]
    analysis: Analysis
    #: why it has no limit as modes or elements are added, "" if it has
    without_limit: str = ""

    @property
    def values(self) -> list[float]:
        """Values, coarse to fine; NaN where a level does not have it."""
        return [float(value) for value in self.analysis.levels["value"]]

    @property
    def finest(self) -> str:
        """The finest value in the digits of its uncertainty, with that and the unit, or why there is none."""
        a, unit = self.analysis, shown_unit(self.quantity.unit)
        value, digits = rounded(self.values[-1], a.uncertainty)
        known = f" +- {a.uncertainty:.2g}" if math.isfinite(a.uncertainty) else ""
        return self.gaps[-1] or f"{value:.{digits}g}{known} {unit}".strip()

    def __repr__(self) -> str:
        """Return value, verdict and reason in a line."""
        return f"{self.quantity.name:24} {self.finest:32} {self.analysis.words} ({self.analysis.reason})"


@dataclass(frozen=True, repr=False)
class SeriesResult:
    """A series with the frame of its levels, coarse to fine; `remark` is about the sizes h."""

    refined: RefinementSeries
    runs: pd.DataFrame
    sizes: tuple[float, ...]
    remark: str
    results: tuple[QuantityResult, ...]

    def __repr__(self) -> str:
        """Return what the terminal shows: levels that did not complete, a line for each quantity, remarks."""
        shown = list[object]()
        for run in self.runs.to_dict("records"):
            if run["outcome"] != Outcome.COMPLETED.label:
                words = f"{run['outcome']} at t = {run['stopped_at']:.6g} s" if run["steps"] else run["message"]
                shown.append(f"{self.axis.label} {run['level']:g}: {words}")
        shown += [*self.results, *self.remarks]
        return "\n".join([f"{self.refined.name}:", *(f"  {line}" for line in shown)])

    @property
    def axis(self) -> Axis:
        """Axis of the refinement: elements, modes, steps, stiffness or tolerance."""
        return AXES[self.refined.axis]

    def quantity(self, name: str) -> QuantityResult:
        """Return the result of one quantity by name; raises KeyError."""
        return {item.quantity.name: item for item in self.results}[name]

    @property
    def remarks(self) -> list[str]:
        """Sentences about the series: what has no limit over modes, uneven events, warnings with their levels."""
        remarks = []
        lost = [item for item in self.results if item.without_limit]
        if self.refined.within and lost:
            names = "; ".join(item.quantity.meaning for item in lost)
            remarks.append(
                f"{names}: no limit as modes or elements are added ({lost[0].without_limit}); "
                f"what has converged{self.refined.within} has done so at this number of modes or elements alone"
            )
        counts = self.runs["events"][self.runs["outcome"] == Outcome.COMPLETED.label].tolist()
        if len(set(counts)) > 1:
            remarks.append(
                f"the number of events differs from level to level ({', '.join(map(str, counts))}); what comes "
                "after the first event that some level lacks is not the same motion, whatever its verdict"
            )
        labels = (f"{level:g}" for level in self.refined.levels)
        found = same_warnings(zip(labels, self.runs["warnings"], strict=True))
        return remarks + [f"warning ({self.axis.label} {', '.join(levels)}): {text}" for text, levels in found]


@dataclass(frozen=True, repr=False)
class StudyResult:
    """A study with everything it found.

    Attributes
    ----------
    study : Study
        What was refined.
    tolerance : float
        Relative uncertainty at which a quantity counts as converged.
    series : tuple of SeriesResult
        With runs and verdicts.
    seconds : float
        Wall time (s): with those of the runs, the only numbers that change from time to time.
    """

    study: Study
    tolerance: float
    series: tuple[SeriesResult, ...]
    seconds: float

    def quantity(self, name: str, series: int = 0) -> QuantityResult:
        """Return the result of a quantity in a series (by number from 0); raises KeyError."""
        return self.series[series].quantity(name)

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each series, quantity and level, as in results.csv; NaN where there is nothing."""
        parts = []
        for part in self.series:
            for item in part.results:
                before = {
                    "series": part.refined.name,
                    "axis": part.refined.axis,
                    "level": part.refined.levels,
                    "outcome": part.runs["outcome"].tolist(),
                    "quantity": item.quantity.name,
                    "unit": item.quantity.unit,
                    "gap": item.gaps,
                }
                levels = pd.concat([pd.DataFrame(before), item.analysis.levels], axis=1)
                parts.append(levels.assign(uncertainty=item.analysis.uncertainty, verdict=item.analysis.words))
        return pd.concat(parts, ignore_index=True)

    def _repr_html_(self) -> str:
        """Show the head of the report in a notebook."""
        return report(self)._repr_html_()

    def __repr__(self) -> str:
        """Return what the terminal shows of each series."""
        return "\n".join(map(repr, self.series))


def sizes_of(axis: str, levels: Sequence[float], mean_steps: Sequence[float]) -> tuple[list[float], str]:
    """Return the sizes h of the levels, and a remark if they are not what the axis promises.

    The size that goes with a tolerance is the mean step (s) the run took.  If these do not fall, as with loose
    tolerances whose steps are cut by stability, the root of the tolerance to the scheme's order takes its place.
    """
    if AXES[axis].rising:
        return [1.0 / level for level in levels], ""
    if axis == "steps":
        return list(levels), ""
    if all(b < a for a, b in pairwise(mean_steps)):
        return list(mean_steps), ""
    order = SCHEMES["event"].order
    remark = f"The mean steps do not fall from level to level; tolerance^(1/{order}) is the size."
    return [level ** (1.0 / order) for level in levels], remark


def judge(refined: RefinementSeries, frame: pd.DataFrame, tolerance: float) -> SeriesResult:
    """Judge every quantity of a series by the frame of its runs."""
    count = len(refined.levels)
    runs, noisy = frame.iloc[:count], frame.iloc[count:]
    h, remark = sizes_of(refined.axis, refined.levels, (runs["stopped_at"] / runs["steps"].clip(lower=1)).tolist())
    finest, finest_scenario = runs.iloc[-1], refined.finest
    lost, results = reasons(finest["undetermined"]), []
    for name in refined.quantities:
        q, values, noise = quantity(name), runs[name].tolist(), 0.0
        # a run that failed has nothing but its message
        gaps = tuple(
            "" if math.isfinite(row[name]) else reasons(row["gaps"]).get(name, row["message"])
            for row in runs.to_dict("records")
        )
        if len(noisy) and math.isfinite(values[-1]):
            other = float(noisy[name].iloc[0])
            noise = abs(other - values[-1]) if math.isfinite(other) else math.inf
        scale = natural_scale(q.unit, finest_scenario, finest["energy"])
        declared, without_limit = refined.declared.get(name), lost.get(name, "")
        analysis = analyse(h, values, tolerance=tolerance, scale=scale, noise=noise, declared=declared)
        analysis = replace(analysis, within=refined.within)
        if without_limit and not refined.within and analysis.verdict != NO_VERDICT:
            analysis = analysis.undetermined(without_limit)
        results.append(QuantityResult(q, declared, scale, gaps, analysis, without_limit))
    return SeriesResult(refined, runs, tuple(h), remark, tuple(results))


def refine(
    source: Scenario | Study | str | os.PathLike[str],
    *,
    elements: Sequence[int] | None = None,
    modes: Sequence[int] | None = None,
    steps: Sequence[float] | None = None,
    tolerances: Sequence[float] | None = None,
    stiffness: Sequence[float] | None = None,
    quantities: Sequence[str] = (),
    changes: Sequence[str] = (),
    within: float | None = None,
    out: str | os.PathLike[str] | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    timeout: float | None = None,
    name: str = "scenario",
    on_progress: OnProgress = silent,
) -> StudyResult:
    """Refine elements, modes, steps, stiffness or tolerances, and judge what converges.

    Parameters
    ----------
    source : Scenario, Study or path
        What is refined: a scenario, with levels; or a study, which has its own, such as a file of docs/studies
        (:class:`~oblique_impact.validation.studies.series.StudySection` says what it holds).
    elements, modes : sequence of int, optional
        Levels, ascending; of these and the next three exactly one is given, with at least three levels.
    steps : sequence of float, optional
        Free steps (s), descending; contact steps keep their ratio to them.
    tolerances : sequence of float, optional
        Tolerances of the event scheme, descending.
    stiffness : sequence of float, optional
        Of an elastic stop (N/m), ascending: towards the rigid one.
    quantities : sequence of str
        Names as in :mod:`~oblique_impact.validation.studies.quantities`, e.g. "impulse", "tip_y@0.5"; empty: the
        usual ones.
    changes : sequence of str
        For every series of a study: "section.key=value" as on the command line.
    within : float, optional
        Relative uncertainty at which a quantity counts as converged, between 0 and 1; default: 1e-3, or the
        study's own.
    out : path, optional
        Folder for report.html, results.json, results.csv and results.parquet, where an interrupted study goes on;
        without it nothing is written.
    scheduler, workers, timeout, on_progress
        As for :func:`~oblique_impact.validation.studies.study.run_study`.
    name : str
        What the scenario is called in the report.

    Returns
    -------
    StudyResult
        Values, observed orders, limits and verdicts; `quantity` finds those of one quantity.

    Raises
    ------
    InputError
        In one line, before anything runs, if levels, quantities, changes or the folder are not possible.

    Examples
    --------
    >>> from oblique_impact import Scenario
    >>> from oblique_impact.validation import refine
    >>> swing = Scenario.builtin("paper").replace(end_time=0.1, discretization__frame="mean-axis")
    >>> result = refine(swing, elements=[4, 8, 16], quantities=["theta@end"], workers=1)
    >>> result.quantity("theta@end").analysis.verdict
    'converged'
    """
    every = zip(OPTIONS, (elements, modes, steps, stiffness, tolerances), strict=True)
    chosen = {axis: tuple(map(float, levels)) for axis, levels in every if levels is not None}
    if within is not None and not 0.0 < within < 1.0:
        raise InputError(f"--within {within}: should be between 0 and 1, relative to the value")
    if isinstance(source, Scenario):
        if changes:
            raise InputError("changes: are for a study; scenario.replace changes a scenario")
        described = _own_study(source, name, chosen, quantities)
    elif chosen:
        raise InputError(f"--{next(iter(chosen))} together with a study: a study has its own levels")
    elif isinstance(source, Study):
        described = source
    elif isinstance(source, str | os.PathLike):
        described = load_study(source)
    else:
        raise refused("refine", source, "should be a Scenario, a Study or the path of a study file")
    started = time.perf_counter()
    # everything that can be refused is refused before a folder appears
    series = [one.changed(changes, quantities) for one in described.series]
    runs = [run for one in series for run in one.runs()]
    check_limits(scheduler, workers, timeout)
    with writing(out):
        frame = run_study(
            runs, out, scheduler=scheduler, workers=workers, timeout=timeout, on_progress=on_progress
        )
        tolerance = described.tolerance if within is None else within
        found = tuple(judge(one, frame[frame["series"] == one.name], tolerance) for one in series)
        result = StudyResult(described, tolerance, found, time.perf_counter() - started)
        if out is not None:
            report(result).write(Path(out), study_data(result), result.to_dataframe())
    return result


def parse_levels(axis: str, text: str) -> list[float]:
    """Read the levels of an axis from the command line: numbers separated by commas; raises InputError."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"--{axis} {text}: should be numbers separated by commas") from None


def declared_orders(axis: str, scenario: Scenario, quantities: Sequence[str]) -> dict[str, float]:
    """Return the orders that hold for any scenario, by quantity; few do.

    Frequencies of Hermite elements, and with them everything at a fixed number of modes, converge at order 4;
    generalized-alpha is of its order on motions without a rigid stop.  Forces and counts get none.
    """
    rigid = scenario.contact.enabled and scenario.contact.normal == "rigid"
    if axis == "elements" and scenario.discretization.modes > 0:
        order = 4.0
    elif axis == "steps" and scenario.solver.scheme == "generalized-alpha" and not rigid:
        order = float(SCHEMES["generalized-alpha"].order)
    else:
        return {}
    return {name: order for name in quantities if name not in _ROUGH and ":" not in name}


def _own_study(
    scenario: Scenario, name: str, chosen: Mapping[str, tuple[float, ...]], quantities: Sequence[str]
) -> Study:
    """Describe the user's own series."""
    if not chosen:
        options = ", ".join(f"--{axis}" for axis in OPTIONS)
        raise InputError(f"refine: give one of {options} with levels, or the file of a study")
    if len(chosen) > 1:
        raise InputError(f"--{' together with --'.join(chosen)}: refine one at a time, the others with --set")
    ((axis, levels),) = chosen.items()
    check_levels(axis, levels, f"--{axis}")
    names = tuple(dict.fromkeys(quantities)) or default_quantities(scenario)
    title = f"{axis} of {name}"
    declared = declared_orders(axis, AXES[axis].change(scenario, levels[-1]), names)
    series = RefinementSeries(title, scenario, axis, levels, names, declared, scenario=name)
    text = f"The scenario over {AXES[axis].label}, from coarse to fine; everything else stays as it is."
    return Study(title.replace(" ", "-"), title, text, (series,))


# --- report


def study_data(result: StudyResult) -> dict[str, Any]:
    """Return everything that was found as plain data, named as in Python; `times` differ from run to run."""
    series = [
        {**plain(part.refined), **plain(part), "runs": plain(part.runs.drop(columns="wall_time"))}
        for part in result.series
    ]
    for one in series:
        del one["refined"]
    times = {"wall_time": result.seconds, "runs": [part.runs["wall_time"].tolist() for part in result.series]}
    study = {"study": result.study.name, "title": result.study.title, "tolerance": result.tolerance}
    return {**study, "rule": RULE, "series": series, "times": times}


def report(result: StudyResult) -> Report:
    """Return the report."""
    bases = {part.refined.name: part.refined.base for part in result.series}
    several, rows = len(bases) > 1, []
    for part in result.series:
        for item in part.results:
            a, q = item.analysis, item.quantity
            finest, limit = (Cell(a.shown(value), "number") for value in (item.values[-1], a.limit))
            # what has no limit over modes has converged at one number of them only
            kind = "partly" if a.verdict == CONVERGED and item.without_limit else VERDICTS[a.verdict]
            unit, uncertainty = shown_unit(q.unit), cell(a.uncertainty, 2)
            name = [part.refined.name if item is part.results[0] else ""]  # once for all its quantities
            row = [q.meaning, finest, limit, uncertainty, unit, Cell(a.words, kind), a.reason]
            rows.append([*name, *row] if several else row)
    columns = ["quantity", "finest value", "limit", "uncertainty", "unit", "verdict", "because"]
    columns = ["refined", *columns] if several else columns
    caption = "Verdicts; limits are given where the order is confirmed"
    refined = "What is refined changes from level to level."
    return Report(
        f"Refinement study: {result.study.title}",
        result.study.description,
        result.seconds,
        facts=[("tolerance", f"{number(result.tolerance)} (relative)")],
        overview=[
            Table(columns, rows, caption, wide=[0, 1, 7] if several else [0, 6]),
            *([differing(bases)] if several else map(_picture, result.series)),
        ],
        sections=[
            *(_section(part, several) for part in result.series),
            *parameters(bases, refined),
            Section("How a verdict is found", [*map(Text, RULE)]),
        ],
    )


def _section(result: SeriesResult, pictured: bool) -> Section:
    refined, axis = result.refined, result.axis
    levels = ", ".join(number(level) for level in refined.levels)
    note = f"Scenario {Path(refined.scenario).name}; {refined.axis} {levels}; h is {axis.size}. {result.remark}"
    columns = {"level": with_unit(axis.label, axis.unit), "h": "h", "outcome": "outcome", "stopped_at": "ended at"}
    columns |= {"steps": "steps", "events": "events"} | ({"message": ""} if result.runs["message"].any() else {})
    return Section(
        refined.name,
        [
            Text(note, note=True),
            *(Text(f"{capitalized(remark)}.", note=True) for remark in result.remarks),
            _picture(result) if pictured else None,
            Table.of_frame(result.runs.assign(h=result.sizes), "Runs", wide=[6], columns=columns),
            *(_level_table(result, item) for item in result.results),
        ],
    )


def _level_table(result: SeriesResult, item: QuantityResult) -> Table:
    a, unit, axis = item.analysis, item.quantity.unit, result.axis
    rows = []
    for level, gap, row in zip(result.refined.levels, item.gaps, a.levels.itertuples(), strict=True):
        kind = "number" if row.above_noise else "number dim"
        order, index = number(row.observed_order, 3), number(row.grid_convergence_index, 2)
        found = [Cell(text, kind) for text in (order, a.shown(row.richardson_limit), index)]
        value = Cell(gap, "dim") if gap else Cell(a.shown(row.value), "number")
        rows.append([level, value, cell(row.difference, 3), *found])
    declared = f", declared order {item.declared:g}" if item.declared else ""
    caption = (
        f"{capitalized(item.quantity.meaning)}{declared}. Verdict: {a.words} ({a.reason}); uncertainty "
        f"{number(a.uncertainty, 2)} {shown_unit(unit)}, noise {number(a.noise, 2)} {shown_unit(unit)}"
    )
    units = {"value": unit, "difference": unit, "observed order": "1", "Richardson limit": unit, "GCI": unit}
    return Table([with_unit(*pair) for pair in ({axis.label: axis.unit} | units).items()], rows, caption)


def _picture(result: SeriesResult) -> Picture:
    """Draw differences between successive levels and values, relative to the finest value, over the levels."""
    axis, refined = result.axis, result.refined
    places, largest = np.array(refined.levels if axis.rising else result.sizes), 0.0
    caption = (
        f"Refinement of {refined.name}. Left: differences between successive levels. Right: values. Both relative "
        "to the finest."
    )
    words = "; ".join(f"{item.quantity.meaning}: {item.analysis.words}" for item in result.results)
    with picture(caption, 7.1, 3.4, f"Refinement of {refined.name}: {words}.") as drawn:
        left, right = drawn.figure.subplots(1, 2)
        for index, item in enumerate(result.results):
            style: dict[str, Any] = {"color": SERIES[index % len(SERIES)], "markersize": 4.5}
            style["marker"] = _MARKERS[index % len(_MARKERS)]
            known = [value for value in item.values if math.isfinite(value)]
            finest = known[-1] if known and known[-1] else math.nan
            right.plot(places, np.array(item.values) / finest, label=item.quantity.meaning, **style)
            errors = item.analysis.levels["difference"].abs() / np.fmax(abs(finest), item.scale)
            left.plot(places, errors.where(errors > 0.0), **style)
            largest = max(largest, np.nan_to_num(errors.max()))
        orders = [item.declared for item in result.results if item.declared]
        orders += [item.analysis.order for item in result.results if math.isfinite(item.analysis.order)]
        if largest and orders:
            h = np.array(result.sizes)[1:]
            right.plot([], [], "--", color=GREY, label=f"order {orders[0]:.3g}")
            left.plot(places[1:], 2.5 * largest * (h / h[0]) ** orders[0], "--", color=GREY, linewidth=1.1)
        left.set(ylabel="relative difference", title="Difference from the level before")
        if largest:
            left.set_yscale("log")
        right.set(ylabel="value / value at the finest level", title="Values")
        for axes in (left, right):
            axes.set_xscale("log")
            axes.set_xlabel(with_unit(axis.label, axis.unit) if axis.rising else axis.size)
            axes.set_xticks(places)
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: number(float(value), 3)))
            axes.xaxis.set_minor_locator(NullLocator())
            axes.margins(x=0.08, y=0.1)
            if not axis.rising:
                axes.invert_xaxis()
                axes.tick_params(axis="x", labelrotation=30)
        right.ticklabel_format(axis="y", useOffset=False)
        drawn.figure.legend(*right.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    return drawn
