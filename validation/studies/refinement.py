"""Refinement: one scenario over levels of elements, modes, steps, stiffness or tolerance, and what converges."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.ticker import FuncFormatter, NullLocator

from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import plain, writing
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.progress import OnProgress, silent
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.scenario import Scenario, require_scenario
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
    shown_unit,
    with_unit,
)
from oblique_impact.validation.report.parameters import differing, parameters
from oblique_impact.validation.studies.convergence import CONVERGED, RULE, VERDICTS
from oblique_impact.validation.studies.ladders import AXES, Ladder, LadderResult, QuantityResult, Study, judge
from oblique_impact.validation.studies.parallel import check_limits
from oblique_impact.validation.studies.quantities import default_quantities
from oblique_impact.validation.studies.shipped import shipped_study
from oblique_impact.validation.studies.study import run_study

#: axes that a user can refine
OPTIONS = ("elements", "modes", "steps", "stiffness", "tolerances")
#: levels that a verdict needs, and most that are run
FEWEST, MOST = 3, 16
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")
#: quantities that converge at no order of a method: counts, and largest values among samples
_ROUGH = ("contacts", "events", "peak_force", "unaccounted")


@dataclass(frozen=True, repr=False)
class StudyResult:
    """A study with everything it found.

    Attributes
    ----------
    study : Study
        What was refined.
    tolerance : float
        Relative uncertainty at which a quantity counts as converged.
    ladders : tuple of LadderResult
        With runs and verdicts.
    seconds : float
        Wall time (s): with those of the runs, the only numbers that change from time to time.
    """

    study: Study
    tolerance: float
    ladders: tuple[LadderResult, ...]
    seconds: float

    def quantity(self, name: str, ladder: int = 0) -> QuantityResult:
        """Return the result of a quantity on a ladder (by number from 0); raises KeyError."""
        return self.ladders[ladder].quantity(name)

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each ladder, quantity and level, as in results.csv; NaN where there is nothing."""
        parts = []
        for part in self.ladders:
            for item in part.results:
                before = {
                    "ladder": part.ladder.name,
                    "axis": part.ladder.axis,
                    "level": part.ladder.levels,
                    "outcome": part.runs["outcome"].tolist(),
                    "quantity": item.quantity.name,
                    "unit": item.quantity.unit,
                    "gap": item.gaps,
                }
                levels = pd.concat([pd.DataFrame(before), item.analysis.levels], axis=1)
                parts.append(levels.assign(verdict=item.analysis.words))
        return pd.concat(parts, ignore_index=True)

    def _repr_html_(self) -> str:
        """Show the head of the report in a notebook."""
        return report(self)._repr_html_()

    def __repr__(self) -> str:
        """Return a line for each quantity, and what stands against them."""
        shown = [f"<StudyResult: {', '.join(found.ladder.name for found in self.ladders)}; {self.seconds:.1f} s>"]
        for found in self.ladders:
            shown += [f"  {line}" for line in (*map(repr, found.results), *found.remarks)]
        return "\n".join(shown)


def refine(
    scenario: Scenario | None = None,
    *,
    elements: Sequence[int] | None = None,
    modes: Sequence[int] | None = None,
    steps: Sequence[float] | None = None,
    tolerances: Sequence[float] | None = None,
    stiffness: Sequence[float] | None = None,
    quantities: Sequence[str] = (),
    study: str | Study | None = None,
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
    scenario : Scenario, optional
        What is refined; a study brings its own.
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
    study : str or Study, optional
        A shipped study by name, or a user-defined one, in place of a scenario and levels.
    changes : sequence of str
        For every ladder of a study: "section.key=value" as on the command line.
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
    if study is None:
        if changes:
            raise InputError("changes: are for a study; scenario.replace changes a scenario")
        described = _own_study(scenario, name, chosen, quantities)
    else:
        described = shipped_study(study) if isinstance(study, str) else study
        for given in ("scenario", *(f"--{axis}" for axis in chosen))[scenario is None :]:
            raise InputError(f"{given} together with --study {described.name}: a shipped study has its own levels")
    started = time.perf_counter()
    # everything that can be refused is refused before a folder appears
    ladders = [ladder.changed(changes, quantities) for ladder in described.ladders]
    runs = [run for ladder in ladders for run in ladder.runs()]
    check_limits(scheduler, workers, timeout)
    with writing(out):
        frame = run_study(
            runs, out, scheduler=scheduler, workers=workers, timeout=timeout, on_progress=on_progress
        )
        tolerance = described.tolerance if within is None else within
        found = tuple(judge(ladder, frame[frame["ladder"] == ladder.name], tolerance) for ladder in ladders)
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


def check_levels(axis: str, levels: Sequence[float]) -> None:
    """Raise InputError unless there are enough levels, each finer than the one before."""
    rising, text = AXES[axis].rising, ",".join(f"{level:g}" for level in levels)
    if not all(math.isfinite(level) and level > 0.0 for level in levels):
        raise InputError(f"--{axis} {text}: should be numbers above 0")
    if axis in ("elements", "modes") and any(level % 1.0 for level in levels):
        raise InputError(f"--{axis} {text}: should be whole numbers")
    if not FEWEST <= len(levels) <= MOST:
        raise InputError(f"--{axis} {text}: a verdict takes {FEWEST} to {MOST} levels, these are {len(levels)}")
    if not all(b > a if rising else b < a for a, b in pairwise(levels)):
        order = "increase" if rising else "decrease"
        raise InputError(f"--{axis} {text}: should {order}, from coarse to fine")


def lines(result: StudyResult) -> list[str]:
    """Return what a study found in lines, for a terminal."""
    found = []
    for part in result.ladders:
        found.append(f"{part.ladder.name}:")
        for run in part.runs.to_dict("records"):
            if run["outcome"] != Outcome.COMPLETED.label:
                words = f"{run['outcome']} at t = {run['stopped_at']:.6g} s" if run["steps"] else run["message"]
                found.append(f"  {part.axis.label} {run['level']:g}: {words}")
        for item in part.results:
            a = item.analysis
            found.append(f"  {item.quantity.name:24} {item.finest:32} {a.words} ({a.reason})")
        found += [f"  {remark}" for remark in part.remarks]
    return found


def declared_orders(axis: str, scenario: Scenario, quantities: Sequence[str]) -> dict[str, float]:
    """Return the orders that hold for any scenario, by quantity; few do.

    Frequencies of Hermite elements, and with them everything at a fixed number of modes, converge at order 4;
    generalized-alpha is of its order on motions without a rigid stop.  Forces and counts get none.
    """
    rigid = scenario.contact.enabled and scenario.contact.normal == "rigid"
    if axis == "elements" and scenario.discretization.modes > 0:
        order = 4.0
    elif axis == "steps" and scenario.solver.scheme == "generalized-alpha" and not rigid:
        order = float(GeneralizedAlphaScheme.order)
    else:
        return {}
    return {name: order for name in quantities if name not in _ROUGH and ":" not in name}


def _own_study(
    scenario: Scenario | None, name: str, chosen: Mapping[str, tuple[float, ...]], quantities: Sequence[str]
) -> Study:
    """Describe the user's own ladder."""
    if not chosen:
        options = ", ".join(f"--{axis}" for axis in OPTIONS)
        raise InputError(f"refine: give one of {options} with levels, or --study")
    if len(chosen) > 1:
        raise InputError(f"--{' together with --'.join(chosen)}: refine one at a time, the others with --set")
    if scenario is None:
        raise InputError("refine: a scenario is needed besides levels")
    require_scenario(scenario, "refine")
    ((axis, levels),) = chosen.items()
    check_levels(axis, levels)
    names = tuple(dict.fromkeys(quantities)) or default_quantities(scenario)
    title = f"{axis} of {name}"
    declared = declared_orders(axis, AXES[axis].change(scenario, levels[-1]), names)
    ladder = Ladder(title, scenario, axis, levels, names, declared, scenario=name)
    text = f"The scenario over {AXES[axis].label}, from coarse to fine; everything else stays as it is."
    return Study(title.replace(" ", "-"), title, text, (ladder,))


# --- report


def study_data(result: StudyResult) -> dict[str, Any]:
    """Return everything that was found as plain data, named as in Python; `times` differ from run to run."""
    ladders = [{**plain(part), "runs": plain(part.runs.drop(columns="wall_time"))} for part in result.ladders]
    times = {"wall_time": result.seconds, "runs": [part.runs["wall_time"].tolist() for part in result.ladders]}
    study = {"study": result.study.name, "title": result.study.title, "tolerance": result.tolerance}
    return {**study, "rule": RULE, "ladders": ladders, "times": times}


def report(result: StudyResult) -> Report:
    """Return the report."""
    bases = {part.ladder.name: part.ladder.base for part in result.ladders}
    several, rows = len(bases) > 1, []
    for part in result.ladders:
        for item in part.results:
            a, q = item.analysis, item.quantity
            finest, limit = (Cell(a.shown(value), "number") for value in (item.values[-1], a.limit))
            # what has no limit over modes has converged at one number of them only
            kind = "partly" if a.verdict == CONVERGED and item.without_limit else VERDICTS[a.verdict]
            unit, uncertainty = shown_unit(q.unit), cell(a.uncertainty, 2)
            name = [part.ladder.name if item is part.results[0] else ""]  # once for all its quantities
            row = [q.meaning, finest, limit, uncertainty, unit, Cell(a.words, kind), a.reason]
            rows.append([*name, *row] if several else row)
    columns = ["quantity", "finest value", "limit", "uncertainty", "unit", "verdict", "because"]
    columns = ["refined", *columns] if several else columns
    caption = "Verdicts; limits are given where the order is confirmed"
    refined = "What is refined changes from level to level."
    return Report(
        f"Refinement study: {result.study.title}",
        result.study.text,
        result.seconds,
        facts=[("tolerance", f"{number(result.tolerance)} (relative)")],
        overview=[
            Table(columns, rows, caption, wide=[0, 1, 7] if several else [0, 6]),
            *([differing(bases)] if several else map(_picture, result.ladders)),
        ],
        sections=[
            *(_section(part, several) for part in result.ladders),
            *parameters(bases, refined),
            Section("How a verdict is found", [*map(Text, RULE)]),
        ],
    )


def _section(result: LadderResult, pictured: bool) -> Section:
    ladder, axis = result.ladder, result.axis
    levels = ", ".join(number(level) for level in ladder.levels)
    note = f"Scenario {Path(ladder.scenario).name}; {ladder.axis} {levels}; h is {axis.size}. {result.remark}"
    columns = {"level": with_unit(axis.label, axis.unit), "h": "h", "outcome": "outcome", "stopped_at": "ended at"}
    columns |= {"steps": "steps", "events": "events"} | ({"message": ""} if result.runs["message"].any() else {})
    return Section(
        ladder.name,
        [
            Text(note, note=True),
            *(Text(f"{capitalized(remark)}.", note=True) for remark in result.remarks),
            _picture(result) if pictured else None,
            Table.of_frame(result.runs.assign(h=result.sizes), "Runs", wide=[6], columns=columns),
            *(_level_table(result, item) for item in result.results),
        ],
    )


def _level_table(result: LadderResult, item: QuantityResult) -> Table:
    a, unit, axis = item.analysis, item.quantity.unit, result.axis
    rows = []
    for level, gap, row in zip(result.ladder.levels, item.gaps, a.levels.itertuples(), strict=True):
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


def _picture(result: LadderResult) -> Picture:
    """Draw differences between successive levels and values, relative to the finest value, over the levels."""
    axis, ladder = result.axis, result.ladder
    places, largest = np.array(ladder.levels if axis.rising else result.sizes), 0.0
    caption = (
        f"Refinement of {ladder.name}. Left: differences between successive levels. Right: values. Both relative "
        "to the finest."
    )
    words = "; ".join(f"{item.quantity.meaning}: {item.analysis.words}" for item in result.results)
    with picture(caption, 7.1, 3.4, f"Refinement of {ladder.name}: {words}.") as drawn:
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
