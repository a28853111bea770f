"""Refinement: one scenario over levels of elements, modes, steps, stiffness or tolerance, and what converges."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.ticker import FuncFormatter, NullLocator

from oblique_impact.beam_problem import SCHEMES
from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.messages import refused
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.report import (
    Block,
    Column,
    Picture,
    Section,
    Table,
    Text,
    capitalized,
    number,
    picture,
    shown_unit,
    with_unit,
)
from oblique_impact.validation.result import Result
from oblique_impact.validation.studies.convergence import (
    CONVERGED,
    CONVERGING,
    NO_VERDICT,
    RULE,
    VERDICTS,
    analyse,
)
from oblique_impact.validation.studies.parallel import check_limits
from oblique_impact.validation.studies.quantities import default_quantities, natural_scale, quantity
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


_COLUMNS = {
    "series": Column("refined"),
    "quantity": Column("symbol", code=True),
    "meaning": Column("quantity", text=True, page=True),
    "value": Column("finest value", within="uncertainty"),
    "uncertainty": Column(digits=2),
    "limit": Column(within="uncertainty"),
    "unit": Column(),
    "verdict": Column(),
    "order": Column(digits=3),
    "because": Column(text=True),
}


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
    remark = f"the mean steps do not fall from level to level; tolerance^(1/{order}) is the size"
    return [level ** (1.0 / order) for level in levels], remark


def judge(refined: RefinementSeries, runs: pd.DataFrame, tolerance: float) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Judge every quantity of a series by the frame of its runs.

    Returns
    -------
    rows : DataFrame
        A row for each quantity: the finest `value` with its `uncertainty`, `limit` and `order` where that is
        confirmed, `verdict` and `because`; `noise`, the `declared` order, and why it has no limit as modes or
        elements are added, `without_limit`.
    levels : DataFrame
        A row for each quantity and level, coarse to fine: `level`, size `h`, why it has no value, `gap`, and the
        columns of :class:`~oblique_impact.validation.studies.convergence.Analysis`.
    """
    count = len(refined.levels)
    runs, noisy = runs.iloc[:count], runs.iloc[count:]
    h, _ = sizes_of(refined.axis, refined.levels, (runs["stopped_at"] / runs["steps"].clip(lower=1)).tolist())
    finest, finest_scenario = runs.iloc[-1], refined.finest
    lost, rows, levels = reasons(finest["undetermined"]), [], []
    for name in refined.quantities:
        q, values, noise = quantity(name), runs[name].tolist(), 0.0
        # a run that failed has nothing but its message
        gaps = [
            "" if math.isfinite(row[name]) else reasons(row["gaps"]).get(name, row["message"])
            for row in runs.to_dict("records")
        ]
        if len(noisy) and math.isfinite(values[-1]):
            other = float(noisy[name].iloc[0])
            noise = abs(other - values[-1]) if math.isfinite(other) else math.inf
        scale = natural_scale(q.unit, finest_scenario, finest["energy"])
        declared, without_limit = refined.declared.get(name), lost.get(name, "")
        a = analyse(h, values, tolerance=tolerance, scale=scale, noise=noise, declared=declared)
        if without_limit and not refined.within and a.verdict != NO_VERDICT:
            a = a.undetermined(without_limit)
        verdict = a.verdict
        if verdict in (CONVERGED, CONVERGING):
            # what has no limit over modes has converged at one number of them only
            verdict += f"{refined.within}{' alone' if without_limit else ''}"
        about = {"series": refined.name, "quantity": name, "unit": q.unit}
        found = {name: getattr(a, name) for name in ("uncertainty", "limit", "order", "noise")}
        words = {"verdict": verdict, "because": gaps[-1] or a.reason, "meaning": q.meaning}
        judged = {"scale": scale, "declared": declared, "without_limit": without_limit}
        rows.append({**about, "value": values[-1], **found, **words, **judged})
        place = {"level": refined.levels, "h": h, "outcome": runs["outcome"].tolist(), "gap": gaps}
        levels.append(pd.concat([pd.DataFrame({**about, **place}), a.levels.drop(columns="size")], axis=1))
    return pd.DataFrame(rows), pd.concat(levels, ignore_index=True)


def remarks_of(refined: RefinementSeries, runs: pd.DataFrame, rows: pd.DataFrame) -> list[str]:
    """Return sentences about a series.

    They name levels whose runs did not complete, what has no limit over modes, uneven numbers of events, sizes
    that are not what the axis promises, and warnings with their levels.
    """
    runs, axis, remarks = runs.iloc[: len(refined.levels)], AXES[refined.axis], list[str]()
    for run in runs.to_dict("records"):
        if run["outcome"] != Outcome.COMPLETED.label:
            words = f"{run['outcome']} at t = {run['stopped_at']:.6g} s" if run["steps"] else run["message"]
            remarks.append(f"{axis.label} {run['level']:g}: {words}")
    lost = rows[rows["without_limit"] != ""]
    if refined.within and len(lost):
        remarks.append(
            f"{'; '.join(lost['meaning'])}: no limit as modes or elements are added "
            f"({lost['without_limit'].iloc[0]}); what has converged{refined.within} has done so at this number of "
            "modes or elements alone"
        )
    counts = runs["events"][runs["outcome"] == Outcome.COMPLETED.label].tolist()
    if len(set(counts)) > 1:
        remarks.append(
            f"the number of events differs from level to level ({', '.join(map(str, counts))}); what comes "
            "after the first event that some level lacks is not the same motion, whatever its verdict"
        )
    steps = (runs["stopped_at"] / runs["steps"].clip(lower=1)).tolist()
    remarks += filter(None, [sizes_of(refined.axis, refined.levels, steps)[1]])
    labels = (f"{level:g}" for level in refined.levels)
    found = same_warnings(zip(labels, runs["warnings"], strict=True))
    return remarks + [f"warning ({axis.label} {', '.join(levels)}): {text}" for text, levels in found]


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
) -> Result:
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
    Result
        A row for each quantity (of each series of a study), and the tables `levels` and `runs`; see `judge`.

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
    >>> result["theta@end"].verdict
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
        result = _result(replace(described, series=tuple(series), tolerance=tolerance), frame, started)
        if out is not None:
            result.save(out)
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
    generalized-alpha is of its order in flight and on springs.  Forces and counts get none.
    """
    rigid = scenario.contact.enabled and scenario.contact.normal == "rigid"
    if axis == "elements" and scenario.discretization.in_modes:
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


# --- result


def _result(study: Study, frame: pd.DataFrame, started: float) -> Result:
    """Return what a study has found, from the frame of its runs."""
    runs = {one.name: frame[frame["series"] == one.name] for one in study.series}
    judged = {one.name: judge(one, runs[one.name], study.tolerance) for one in study.series}
    rows = pd.concat([rows for rows, _ in judged.values()]).set_index("quantity")
    several = len(study.series) > 1
    remarks = {one.name: remarks_of(one, runs[one.name], judged[one.name][0]) for one in study.series}
    named = [f"{name}: {line}" if several else line for name, lines in remarks.items() for line in lines]
    kinds = {
        f"{verdict}{within}{alone}": "partly" if alone and kind == "pass" else kind
        for verdict, kind in VERDICTS.items()
        for within in dict.fromkeys(["", *(one.within for one in study.series)])
        for alone in ("", " alone")
    }
    return Result(
        f"Refinement study: {study.title}",
        study.description,
        "quantities",
        rows,
        kinds,
        {name: column for name, column in _COLUMNS.items() if several or name != "series"},
        "Verdicts; limits are given where the order is confirmed.",
        tables={
            "levels": pd.concat([levels for _, levels in judged.values()]).set_index("quantity"),
            "runs": frame,
        },
        remarks=named,
        rule=RULE,
        scenarios={one.name: one.base for one in study.series},
        about={"study": study.name, "tolerance": study.tolerance},
        facts=[("tolerance", f"{number(study.tolerance)} (relative)")],
        seconds=time.perf_counter() - started,
        sections=lambda result: (_section(one, result) for one in study.series),
    )


def _section(refined: RefinementSeries, result: Result) -> Section:
    """Return the part of a series: its picture, its runs, and a table of the levels of each quantity."""
    axis, count = AXES[refined.axis], len(refined.levels)
    rows, levels, runs = (
        frame[frame["series"] == refined.name] for frame in (result.frame, *result.tables.values())
    )
    columns = {
        "level": Column(with_unit(axis.label, axis.unit)),
        "outcome": Column(),
        "stopped_at": Column("ended at"),
    }
    columns |= {name: Column() for name in ("steps", "events")} | {"message": Column(text=True)}
    note = f"Scenario {Path(refined.scenario).name}; h is {axis.size}."
    blocks: list[Block] = [
        Text(note, note=True),
        _picture(refined, rows, levels),
        Table.of_frame(runs[:count], "Runs.", columns),
    ]
    return Section(refined.name, [*blocks, *(_level_table(axis, row, levels) for row in rows.itertuples())])


def _level_table(axis: Axis, row: Any, levels: pd.DataFrame) -> Table:
    """Return the table of the levels of a quantity."""
    declared = f", declared order {row.declared:g}" if row.declared and math.isfinite(row.declared) else ""
    noise = f"{number(row.noise, 2)} {shown_unit(row.unit)}".strip()
    columns = {
        "level": Column(with_unit(axis.label, axis.unit)),
        "h": Column(digits=3),
        "value": Column(with_unit("value", row.unit), within="uncertainty"),
        "difference": Column(digits=3),
        "observed_order": Column(digits=3),
        "richardson_limit": Column("Richardson limit", within="uncertainty"),
        "grid_convergence_index": Column("GCI", digits=2),
        "gap": Column(text=True),
    }
    caption = f"{capitalized(row.meaning)}{declared}: {row.verdict}; noise {noise}."
    own = levels[levels.index == row.Index].reset_index(drop=True).assign(uncertainty=row.uncertainty)
    return Table.of_frame(own, caption, columns)


def _picture(refined: RefinementSeries, rows: pd.DataFrame, levels: pd.DataFrame) -> Picture:
    """Draw differences between successive levels and values, relative to the finest value, over the levels."""
    axis, largest = AXES[refined.axis], 0.0
    sizes = levels["h"].to_numpy()[: len(refined.levels)]
    places = np.array(refined.levels if axis.rising else sizes)
    caption = (
        f"Refinement of {refined.name}. Left: differences between successive levels. Right: values. Both relative "
        "to the finest."
    )
    words = "; ".join(f"{row.meaning}: {row.verdict}" for row in rows.itertuples())
    with picture(caption, 7.1, 3.4, f"Refinement of {refined.name}: {words}.") as drawn:
        left, right = drawn.figure.subplots(1, 2)
        for index, row in enumerate(rows.itertuples()):
            own = levels[levels.index == row.Index]
            style: dict[str, Any] = {"color": SERIES[index % len(SERIES)], "markersize": 4.5}
            style["marker"] = _MARKERS[index % len(_MARKERS)]
            known = own["value"].dropna()
            finest = known.iloc[-1] if len(known) and known.iloc[-1] else math.nan
            right.plot(places, own["value"] / finest, label=row.meaning, **style)
            errors = own["difference"].abs() / np.fmax(abs(finest), row.scale)
            left.plot(places, errors.where(errors > 0.0), **style)
            largest = max(largest, np.nan_to_num(errors.max()))
        orders = [*rows["declared"].dropna(), *rows["order"].dropna()]
        if largest and orders:
            h = sizes[1:]
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
