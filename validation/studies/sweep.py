"""Sweeps: a scenario over axes of its keys, in parallel, resumable, into one table with its report."""

from __future__ import annotations

import itertools
import json
import math
import os
import time
from pathlib import Path

import numpy as np
import pandas as pd

from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import save_text, writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.scenario.messages import counted
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.report import Block, Cell, Column, Table, cell, shown_unit
from oblique_impact.validation.result import Result
from oblique_impact.validation.studies.design import Plan, SweepFile, load_plan, plan_of
from oblique_impact.validation.studies.maps import basin_pictures, sweep_pictures
from oblique_impact.validation.studies.parallel import check_limits
from oblique_impact.validation.studies.periodic import bracket_jump, steady_state
from oblique_impact.validation.studies.quantities import VARIABLES
from oblique_impact.validation.studies.study import (
    FAILURES,
    LARGEST,
    LEAST,
    SECTION,
    motion_state,
    reasons,
    run_study,
    same_warnings,
)

#: a jump is sought where the range changes by so much of itself, or the beam begins or ceases to touch
_SUSPECT = 0.5
#: columns of the table of jumps
_ENDS = "last before", "first behind", "change of range"
#: distinct warnings that are shown at most
_SHOWN = 5
_KINDS = {outcome.label: "partly" for outcome in Outcome} | dict.fromkeys(FAILURES, "fail")
_KINDS[Outcome.COMPLETED.label] = "pass"


def sweep(
    source: str | os.PathLike[str] | SweepFile | Plan,
    out: str | os.PathLike[str],
    *,
    base: Scenario | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    timeout: float | None = None,
    on_progress: OnProgress = silent,
) -> Result:
    """Run a scenario over axes of its keys, or what is missing of it, and write the table and its report.

    Parameters
    ----------
    source : str, path, SweepFile or Plan
        A sweep file, or what such a file would say.
    out : path
        Folder; a sweep that was interrupted there goes on.
    base : Scenario, optional
        In place of the scenario that the source names.
    scheduler, workers, timeout, on_progress
        As for :func:`~oblique_impact.validation.studies.study.run_study`.

    Returns
    -------
    Result
        A row for each run, by its number: values, quantities, and how it ended as its verdict.

    Raises
    ------
    InputError
        In one line, before anything runs, for a faulty source or folder.  Runs that are not possible, or that the
        physics stops, are rows that say so.

    Examples
    --------
    >>> from oblique_impact.validation import AxisSection, SweepFile, sweep
    >>> friction = AxisSection(keys=["contact.mu_static", "contact.mu_kinetic"], values=[0.1, 0.2])
    >>> plan = SweepFile(scenario="paper", axes=[friction], quantities=["impulse"])
    >>> result = sweep(plan, "out/friction", workers=1)  # doctest: +SKIP
    >>> result.frame["impulse"]  # doctest: +SKIP
    """
    if isinstance(source, Plan):
        if base is not None:
            raise InputError("base: a plan has its own scenario")
        plan = source
    else:
        plan = plan_of(source, base=base) if isinstance(source, SweepFile) else load_plan(source, base)
    started, folder = time.monotonic(), Path(out)
    check_limits(scheduler, workers, timeout)
    with writing(folder):
        frame = run_study(
            plan.runs,
            out,
            scheduler=scheduler,
            workers=workers,
            timeout=timeout,
            units={key: direction.unit for direction in plan.directions for key in direction.names},
            histories=plan.file.histories,
            exclusive=True,
            on_progress=on_progress,
        )
        save_text(folder / "scenario.toml", plan.base.to_toml())
        save_text(folder / "sweep.toml", plan.to_toml())
        tables = {"jumps": jumps(plan, frame), "basins": basins(plan, frame)} if plan.file.periodic else {}
        result = _result(plan, frame, tables, time.monotonic() - started)
        result.save(folder)
    return result


def jumps(plan: Plan, frame: pd.DataFrame) -> pd.DataFrame:
    """Bracket the values of the last axis at which a steady response jumps, to 1e-3 of the value, by bisection.

    Returns a row for each jump: the values of the other axes, the direction, the last value before the jump and
    the first one behind it, and the change of the range of the sampled variable over a period.
    """
    *others, last = plan.directions
    periodic, rows = plan.file.periodic, list[dict[str, object]]()
    continuous = pd.api.types.is_float_dtype(frame[last.names[0]]) and not last.whole
    if periodic is None or not continuous:
        return pd.DataFrame()
    touching = frame["events"].to_numpy() > 0
    swings = (frame[LARGEST] - frame[LEAST]).to_numpy(float)
    for n, run in enumerate(plan.runs):
        change, larger = swings[n] - swings[n - 1], max(swings[n], swings[n - 1])
        jumps_wide = abs(change) > _SUSPECT * larger or touching[n] != touching[n - 1]
        if not (run.continued and math.isfinite(change) and jumps_wide) or run.scenario is None:
            continue
        state = motion_state(frame.iloc[n - 1].to_dict())
        ends = tuple(float(frame[last.names[0]].iloc[k]) for k in (n - 1, n))
        assert state is not None

        def at(value: float, scenario: Scenario = run.scenario) -> Scenario:
            return scenario.replace(**{name.replace(".", "__"): value for name in last.names})

        try:
            found = bracket_jump(at, (ends[0], ends[1]), state, periodic)
        except InputError:  # a value in between that is not possible
            continue
        if found:
            fixed = {key: frame[key].iloc[n] for direction in others for key in direction.names}
            rows.append({**fixed, "direction": run.labels["direction"], **dict(zip(_ENDS, found, strict=True))})
    table = pd.DataFrame(rows).rename_axis("jump")
    unit = VARIABLES[periodic.sample][0]
    table.attrs["units"] = {key: d.unit for d in others for key in d.names} | dict(
        zip(_ENDS, (last.unit, last.unit, unit), strict=True)
    )
    return table


def basins(plan: Plan, frame: pd.DataFrame) -> pd.DataFrame:
    """Follow starts around the two states of the run at which the ways up and down differ most.

    Coordinates and velocities of a start lie, each for itself, on the straight line through those of the two
    states, up to half of their distance beyond them: a grid of the sampled variable and its rate.  Returns a row
    for each start: these two (SI units), the period, and the way to whose response it comes, by the range over a
    period.
    """
    periodic, key = plan.file.periodic, plan.directions[-1].names[0]
    if periodic is None or not periodic.starts:
        return pd.DataFrame()
    columns = [name for direction in plan.directions for name in direction.names]
    ways = [frame[frame["direction"] == way].set_index(columns) for way in ("down", "up")]
    ranges = [way[LARGEST] - way[LEAST] for way in ways]
    apart = (ranges[1] - ranges[0]).abs()
    if not apart.notna().any():
        return pd.DataFrame()
    place = apart.idxmax()
    low, high = (way.loc[place] for way in ways)
    first, second = motion_state(low.to_dict()), motion_state(high.to_dict())
    points = [json.loads(row[SECTION])[-1] for row in (low, high)]
    scenario = plan.runs[int(low["run"]) - 1].scenario
    assert scenario is not None
    assert first is not None
    assert second is not None
    rows, parts = list[dict[str, object]](), np.linspace(-0.5, 1.5, periodic.starts)
    for place_part, rate_part in itertools.product(parts, parts):
        shares = (place_part, rate_part)
        start = [a + share * (b - a) for share, a, b in zip(shares, first, second, strict=True)]
        value = [a + share * (b - a) for share, a, b in zip(shares, *points, strict=True)]
        try:
            found = steady_state(scenario, (start[0], start[1]), periodic).summary.get("periodic")
        except InputError:  # inside of a rigid stop
            continue
        if found:
            reached = found["largest"] - found["least"]
            near = [abs(reached - (row[LARGEST] - row[LEAST])) for row in (low, high)]
            way = ("down", "up")[int(np.argmin(near))]
            rows.append({"value": value[0], "rate": value[1], "period": found["period"] or 0, "way": way})
    table = pd.DataFrame(rows).rename_axis("start")
    table.attrs = {"at": float(scenario.value_of(key)), "states": dict(zip(("down", "up"), points, strict=True))}
    return table


def _result(plan: Plan, frame: pd.DataFrame, tables: dict[str, pd.DataFrame], seconds: float) -> Result:
    """Return what a sweep has found."""
    name, count = Path(plan.file.scenario).name, len(frame)
    warnings = same_warnings(zip(frame["run"].map(str), frame["warnings"], strict=True))
    remarks = [
        f"warning of {len(runs)} of {count} runs, the first run {runs[0]}: {text}"
        for text, runs in sorted(warnings, key=lambda found: -len(found[1]))[:_SHOWN]
    ]
    if len(warnings) > _SHOWN:
        remarks.append(f"and {counted(len(warnings) - _SHOWN, 'other warning')}, in the column warnings")
    columns = {key: Column(key, code=True) for key in plan.runs[0].labels}
    columns |= {q.name: Column(q.name, 5) for q in plan.quantities}
    if "period" in columns:
        columns["period"] = Column("period", instead=lambda row: "none" if row["period"] == 0.0 else "")
    return Result(
        plan.file.title or f"Parameter study of {name}",
        plan.file.description or f"The scenario {name} with other values of some parameters.",
        "runs",
        frame.drop(columns="key").set_index("run"),
        _KINDS,
        columns | {"outcome": Column(), "message": Column(text=True)},
        "Runs.",
        verdict="outcome",
        remarks=remarks,
        scenarios={name: plan.base},
        facts=[("scenario", name)],
        seconds=seconds,
        tables={name: table for name, table in tables.items() if name != "basins" or len(table)},
        overview=lambda _: [
            *_descriptions(plan, frame),
            *_jump_table(tables),
            *sweep_pictures(plan, frame, tables.get("jumps")),
            *basin_pictures(plan, tables.get("basins", pd.DataFrame())),
        ],
    )


def _jump_table(tables: dict[str, pd.DataFrame]) -> list[Block]:
    """Return the table of jumps, if there are any."""
    found = tables.get("jumps", pd.DataFrame())
    caption = "Where the response jumps: bracketed by bisection, each value from the last state before the jump."
    return [Table.of_frame(found.reset_index(drop=True), caption)] if len(found) else []


def _clear(values: pd.Series[float]) -> pd.Series[float]:
    """Return values without what is rounding beside the largest of them."""
    return values.mask(values.abs() < 1e-12 * values.abs().max(), 0.0)


def _descriptions(plan: Plan, frame: pd.DataFrame) -> list[Block]:
    """Return tables of what changes from run to run, and of what each run is asked for."""
    directions = []
    for direction in plan.directions:
        values = frame[direction.names[0]]
        numeric = pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values)
        ends = (values.min(), values.max()) if numeric else (str(values.iloc[0]), str(values.iloc[-1]))
        unit = shown_unit(direction.unit)
        directions.append([direction.words, Cell(direction.label, "code"), unit, int(values.nunique()), *ends])
    undetermined = pd.Series([name for lines in frame["undetermined"] for name in reasons(lines)]).value_counts()
    quantities = [
        [
            q.meaning,
            Cell(q.name, "code"),
            shown_unit(q.unit),
            *(cell(value, 4) for value in (values.min(), values.max())),
            int(values.isna().sum()),
            int(undetermined.get(q.name, 0)),
        ]
        for q, values in ((q, _clear(frame[q.name])) for q in plan.quantities)
    ]
    columns = ["quantity", "symbol", "unit", "least", "largest", "missing in runs", "not determined in runs"]
    caption = (
        "What each run is asked for. Why a value is missing is in the column gaps of results.parquet; one that is "
        "not determined has no limit as modes or elements are added."
    )
    changes = ["parameter", "key", "unit", "values", "from", "to"]
    return [
        Table(changes, directions, "What changes from run to run.", wide=(0, 1)),
        Table(columns, quantities, caption, wide=(0,)),
    ]
