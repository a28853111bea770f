"""The report of a refinement study: a page with pictures, and the same numbers as JSON and CSV."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.ticker import FuncFormatter, NullLocator

from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.scenario import Scenario, builtin_names
from oblique_impact.scenario.toml import flat_keys
from oblique_impact.validation.report import (
    Cell,
    Fold,
    Picture,
    Report,
    Section,
    Table,
    Text,
    cell,
    number,
    picture,
    with_unit,
)
from oblique_impact.validation.studies.convergence import CONVERGED, RULE, VERDICTS
from oblique_impact.validation.studies.ladders import LadderResult, QuantityResult, StudyResult

_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")


def study_data(result: StudyResult, command: str) -> dict[str, Any]:
    """Return everything the report tells as plain data; `times` and `command` may differ from run to run."""
    return {
        "study": result.study.name,
        "title": result.study.title,
        "command": command,
        "tolerance": result.tolerance,
        "rule": list(RULE),
        "ladders": [_ladder_data(part) for part in result.ladders],
        "times": {
            "wall_time": result.seconds,
            "runs": [part.runs["wall_time"].tolist() for part in result.ladders],
        },
    }


def _ladder_data(result: LadderResult) -> dict[str, Any]:
    ladder, names = result.ladder, ["level", "outcome", "stopped_at", "steps", "events", "warnings"]
    runs = result.runs[names].rename(columns={"stopped_at": "end_time"})
    return {
        "name": ladder.name,
        "axis": ladder.axis,
        "levels": list(ladder.levels),
        "sizes": list(result.sizes),
        "size": result.axis.size,
        "remark": result.remark,
        "finest_scenario": ladder.finest.model_dump(mode="json"),
        "runs": runs.assign(warnings=runs["warnings"].map(str.splitlines)).to_dict("records"),
        "quantities": [_quantity_data(item) for item in result.results],
    }


def _quantity_data(item: QuantityResult) -> dict[str, Any]:
    a = item.analysis
    plural = {name: f"{name}s" for name in ("value", "difference", "observed_order", "richardson_limit")}
    plural["grid_convergence_index"] = "grid_convergence_indices"
    return {
        "name": item.quantity.name,
        "unit": item.quantity.unit,
        "meaning": item.quantity.meaning,
        "gaps": item.gaps,
        "declared_order": item.declared,
        "words": a.words,
        "scale": item.scale,
        "without_limit": item.without_limit,
        **a.levels.drop(columns="size").rename(columns=plural).to_dict("list"),
        **{name: value for name, value in vars(a).items() if name != "levels"},
    }


def level_frame(result: StudyResult) -> pd.DataFrame:
    """Return a row for each ladder, quantity and level; NaN where there is nothing."""
    parts = []
    for part in result.ladders:
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


def report(result: StudyResult, command: str) -> Report:
    """Return the report; `command` repeats the study."""
    rows = []
    for part in result.ladders:
        for item in part.results:
            a, q = item.analysis, item.quantity
            finest, limit = (Cell(a.shown(value), "number") for value in (item.values[-1], a.limit))
            # what has no limit over modes has converged at one number of them only
            kind = "partly" if a.verdict == CONVERGED and item.without_limit else VERDICTS[a.verdict]
            found = [part.ladder.name, q.name, finest, q.unit, limit, cell(a.uncertainty, 2), Cell(a.words, kind)]
            rows.append([*found, a.reason])
    columns = ["ladder", "quantity", "finest value", "unit", "limit", "uncertainty", "verdict", "because"]
    caption = "Verdicts; limits are given where the order is confirmed"
    return Report(
        f"Refinement study: {result.study.title}",
        result.study.text,
        command,
        result.seconds,
        facts=[("tolerance", f"{number(result.tolerance)} (relative)")],
        overview=[
            Table(columns, rows, caption, wide=[0, 7]),
            Fold("How a verdict is found", [Text(text) for text in RULE]),
        ],
        sections=[_section(part) for part in result.ladders],
    )


def _section(result: LadderResult) -> Section:
    ladder, axis = result.ladder, result.axis
    levels = ", ".join(number(level) for level in ladder.levels)
    note = f"Scenario {Path(ladder.scenario).name}; {_changes(result)}. "
    note += f"Refined: {ladder.axis} {levels}; h is {axis.size}. {result.remark}"
    columns = {"level": with_unit(axis.label, axis.unit), "h": "h", "outcome": "outcome", "stopped_at": "ended at"}
    columns |= {"steps": "steps", "events": "events", "message": ""}
    return Section(
        ladder.name,
        [
            *([Text(ladder.text)] if ladder.text else []),
            Text(note, note=True),
            *(Text(f"{remark[:1].upper()}{remark[1:]}.", note=True) for remark in result.remarks),
            _picture(result),
            Table.of_frame(result.runs.assign(h=result.sizes), "Runs", wide=[6], columns=columns),
            *(_level_table(result, item) for item in result.results),
        ],
    )


def _changes(result: LadderResult) -> str:
    """Return what is changed against the scenario of that name, or against the defaults."""
    name, known = result.ladder.scenario, result.ladder.scenario in builtin_names()
    original = Scenario.builtin(name) if known else Scenario()
    given, plain = (flat_keys(s.model_dump(mode="json")) for s in (result.ladder.base, original))
    changed = [f"{key} = {value}" for key, value in given.items() if repr(value) != repr(plain.get(key))]
    return ", ".join(changed) + ("" if known else " (against the defaults)") if changed else "no changes"


def _level_table(result: LadderResult, item: QuantityResult) -> Table:
    a, unit, axis = item.analysis, item.quantity.unit, result.axis
    rows = []
    for level, gap, row in zip(result.ladder.levels, item.gaps, a.levels.itertuples(), strict=True):
        kind = "number" if row.above_noise else "dim"
        order, index = number(row.observed_order, 3), number(row.grid_convergence_index, 2)
        found = [Cell(text, kind) for text in (order, a.shown(row.richardson_limit), index)]
        value = Cell(gap, "dim") if gap else Cell(a.shown(row.value), "number")
        rows.append([level, value, cell(row.difference, 3), *found])
    declared = f", declared order {item.declared:g}" if item.declared else ""
    caption = (
        f"{item.quantity.name}: {item.quantity.meaning}{declared}. Verdict: {a.words} ({a.reason}); "
        f"uncertainty {number(a.uncertainty, 2)} {unit}, noise {number(a.noise, 2)} {unit}, "
        f"GCI of the last two levels alone {number(a.two_level_index, 2)} {unit}"
    )
    units = {"value": unit, "difference": unit, "observed order": "1", "Richardson limit": unit, "GCI": unit}
    return Table([with_unit(*pair) for pair in ({axis.label: axis.unit} | units).items()], rows, caption)


def _picture(result: LadderResult) -> Picture:
    """Draw differences between successive levels and values, relative to the finest value, over the levels."""
    axis, ladder = result.axis, result.ladder
    places, largest = np.array(ladder.levels if axis.rising else result.sizes), 0.0
    caption = (
        f"{ladder.name}. Left: differences between successive levels. Right: values. Both relative to the finest."
    )
    words = "; ".join(f"{item.quantity.name}: {item.analysis.words}" for item in result.results)
    with picture(caption, 7.1, 3.4, f"Refinement of {ladder.name}: {words}.") as drawn:
        left, right = drawn.figure.subplots(1, 2)
        for index, item in enumerate(result.results):
            style: dict[str, Any] = {"color": SERIES[index % len(SERIES)], "markersize": 4.5}
            style["marker"] = _MARKERS[index % len(_MARKERS)]
            known = [value for value in item.values if math.isfinite(value)]
            finest = known[-1] if known and known[-1] else math.nan
            right.plot(places, np.array(item.values) / finest, label=item.quantity.name, **style)
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
        drawn.figure.legend(*right.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return drawn
