"""The report of a refinement study: a page with pictures, and the same numbers as JSON and CSV."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

from oblique_impact.errors import Outcome
from oblique_impact.renders.style import GREY, SERIES
from oblique_impact.scenario.scenario import Scenario, builtin_names
from oblique_impact.scenario.toml import flat_keys
from oblique_impact.validation.report import (
    Block,
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
from oblique_impact.validation.studies.convergence import (
    CONVERGED,
    CONVERGING,
    NO_VERDICT,
    NOT_CONFIRMED,
    NOT_CONVERGING,
    NOT_DETERMINED,
    RULE,
)
from oblique_impact.validation.studies.refinement import LadderResult, QuantityResult, StudyResult

_KINDS = {
    CONVERGED: "pass",
    CONVERGING: "partly",
    NOT_CONFIRMED: "partly",
    NOT_CONVERGING: "fail",
    NOT_DETERMINED: "fail",
    NO_VERDICT: "dim",
}
#: inches: width of the printed page, what is drawn is what is read; height of a row of panels
_PAGE, _ROW = 7.1, 2.9
_MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<")


def write_study(folder: Path, result: StudyResult, command: str) -> Path:
    """Write report.html, results.json and results.csv; returns the page.  `command` repeats the study."""
    return report(result, command).write(folder, study_data(result, command), level_frame(result))


def study_data(result: StudyResult, command: str) -> dict[str, Any]:
    """Return everything the report tells as plain data; `times` and `command` may differ from run to run."""
    return {
        "study": result.study.name,
        "title": result.study.title,
        "command": command,
        "tolerance": result.tolerance,
        "rule": list(RULE),
        "ladders": [_ladder_data(ladder) for ladder in result.ladders],
        "times": {
            "wall_time": result.seconds,
            "runs": [ladder.runs["wall_time"].tolist() for ladder in result.ladders],
        },
    }


def _ladder_data(result: LadderResult) -> dict[str, Any]:
    ladder = result.ladder
    return {
        "name": ladder.name,
        "axis": ladder.axis,
        "levels": list(ladder.levels),
        "sizes": list(result.sizes),
        "size": result.axis.size,
        "remark": result.remark,
        "finest_scenario": ladder.scenario_at(ladder.levels[-1]).model_dump(mode="json"),
        "runs": [
            {
                "level": row["level"],
                "outcome": row["outcome"],
                "end_time": row["stopped_at"],
                "steps": row["steps"],
                "events": row["events"],
                "warnings": row["warnings"].splitlines(),
            }
            for row in result.runs.to_dict("records")
        ],
        "quantities": [_quantity_data(item) for item in result.results],
    }


def _quantity_data(item: QuantityResult) -> dict[str, Any]:
    return {
        "name": item.quantity.name,
        "unit": item.quantity.unit,
        "meaning": item.quantity.meaning,
        "values": list(item.values),
        "gaps": list(item.gaps),
        "declared_order": item.declared,
        "words": item.analysis.words,
        "scale": item.scale,
        "without_limit": item.without_limit,
        **asdict(item.analysis),
    }


def level_frame(result: StudyResult) -> pd.DataFrame:
    """Return a row for each ladder, quantity and level; NaN where there is nothing."""
    return pd.concat([_levels(part, item) for part in result.ladders for item in part.results], ignore_index=True)


def _levels(part: LadderResult, item: QuantityResult) -> pd.DataFrame:
    a = item.analysis
    return pd.DataFrame(
        {
            "ladder": part.ladder.name,
            "axis": part.ladder.axis,
            "level": part.ladder.levels,
            "size": part.sizes,
            "outcome": part.runs["outcome"].tolist(),
            "quantity": item.quantity.name,
            "unit": item.quantity.unit,
            "value": item.values,
            "gap": item.gaps,
            "difference": a.differences,
            "observed_order": a.observed_orders,
            "richardson_limit": a.richardson_limits,
            "grid_convergence_index": a.grid_convergence_indices,
            "above_noise": a.above_noise,
            "verdict": a.words,
        }
    )


def report(result: StudyResult, command: str) -> Report:
    """Return the report; `command` repeats the study."""
    groups: dict[str, list[LadderResult]] = {}
    for ladder in result.ladders:
        groups.setdefault(ladder.ladder.group, []).append(ladder)
    together = [group for group in groups.values() if len(group) > 1]
    return Report(
        f"Refinement study: {result.study.title}",
        result.study.text,
        command,
        result.seconds,
        facts=[("tolerance", f"{number(result.tolerance)} (relative)")],
        overview=[
            *(_matrix(group) for group in together),
            *(block for group in together for block in _comparison(group, result.study.compare)),
            _verdicts(result),
            *(
                Text(f"{part.ladder.name}: {remark}.", note=True)
                for part in result.ladders
                for remark in part.remarks
            ),
            Fold("How a verdict is found", [Text(text) for text in RULE]),
        ],
        sections=[_section(ladder) for ladder in result.ladders],
    )


def _matrix(group: Sequence[LadderResult]) -> Table:
    """Verdicts: quantities by ladders."""
    names = list(dict.fromkeys(item.quantity.name for ladder in group for item in ladder.results))
    rows = []
    for ladder in group:
        cells = {}
        for item in ladder.results:
            a = item.analysis
            order = f", p = {a.order:.2f}" if math.isfinite(a.order) else ""
            cells[item.quantity.name] = Cell(f"{a.verdict}{order}", _kind(item))
        rows.append([ladder.ladder.name, *(cells.get(name, "") for name in names)])
    return Table(["", *names], rows, "What converges; p is the confirmed order")


def _kind(item: QuantityResult) -> str:
    """Return the kind of a verdict's cell: "partly" at one number of modes where there is no limit over them."""
    return "partly" if item.analysis.verdict == CONVERGED and item.without_limit else _KINDS[item.analysis.verdict]


def _verdicts(result: StudyResult) -> Table:
    rows = []
    for ladder in result.ladders:
        for item in ladder.results:
            a, q = item.analysis, item.quantity
            finest, limit = (Cell(a.shown(value), "number") for value in (item.values[-1], a.limit))
            verdict = Cell(a.words, _kind(item))
            rows.append(
                [ladder.ladder.name, q.name, finest, q.unit, limit, cell(a.uncertainty, 2), verdict, a.reason]
            )
    columns = ["ladder", "quantity", "finest value", "unit", "limit", "uncertainty", "verdict", "because"]
    return Table(columns, rows, "Verdicts; limits are given where the order is confirmed", wide=[0, 7])


def _section(result: LadderResult) -> Section:
    ladder, axis = result.ladder, result.axis
    scenario = ladder.scenario if "/" not in ladder.scenario else Path(ladder.scenario).name
    levels = ", ".join(number(level) for level in ladder.levels)
    note = f"Scenario {scenario}; {_changes(result)}. Refined: {axis.name} {levels}; h is {axis.size}."
    completed = result.runs["outcome"] == Outcome.COMPLETED.label
    runs = [
        [
            row["level"],
            cell(size, 4),
            Cell(row["outcome"], "" if done else "fail"),
            row["stopped_at"],
            row["steps"],
            row["events"],
            row["message"],
        ]
        for row, size, done in zip(result.runs.to_dict("records"), result.sizes, completed, strict=True)
    ]
    columns = [axis.heading, "h", "outcome", "ended at (s)", "steps", "events", ""]
    return Section(
        ladder.name,
        [
            *([Text(ladder.text)] if ladder.text else []),
            Text(f"{note} {result.remark}", note=True),
            _picture(result),
            Table(columns, runs, "Runs", wide=[6]),
            *(Text(f"{remark[:1].upper()}{remark[1:]}.", note=True) for remark in result.remarks),
            *(_level_table(result, item) for item in result.results),
        ],
    )


def _changes(result: LadderResult) -> str:
    """Return what is changed against the scenario of that name, or against the defaults."""
    name = result.ladder.scenario
    original = Scenario.builtin(name) if name in builtin_names() else Scenario()
    assert result.ladder.base is not None
    given, plain = (flat_keys(s.model_dump(mode="json")) for s in (result.ladder.base, original))
    changed = [f"{key} = {value}" for key, value in given.items() if repr(value) != repr(plain.get(key))]
    against = "" if name in builtin_names() else " (against the defaults)"
    return ", ".join(changed) + against if changed else "no changes"


def _level_table(result: LadderResult, item: QuantityResult) -> Table:
    a, unit = item.analysis, item.quantity.unit
    rows = []
    for row in _levels(result, item).itertuples():
        kind = "number" if row.above_noise else "dim"
        found = (
            number(row.observed_order, 3),
            a.shown(row.richardson_limit),
            number(row.grid_convergence_index, 2),
        )
        value = Cell(row.gap, "dim") if row.gap else Cell(a.shown(row.value), "number")
        rows.append([row.level, value, cell(row.difference, 3), *(Cell(text, kind) for text in found)])
    declared = f", declared order {item.declared:g}" if item.declared else ""
    caption = (
        f"{item.quantity.name}: {item.quantity.meaning}{declared}. Verdict: {a.words} ({a.reason}); "
        f"uncertainty {number(a.uncertainty, 2)} {unit}, noise {number(a.noise, 2)} {unit}, "
        f"GCI of the last two levels alone {number(a.two_level_index, 2)} {unit}"
    )
    with_units = [with_unit(name, unit) for name in ("value", "difference", "Richardson limit", "GCI")]
    columns = [result.axis.heading, *with_units[:2], "observed order", *with_units[2:]]
    return Table(columns, rows, caption)


# --- pictures


def _style(index: int) -> dict[str, Any]:
    return {
        "color": SERIES[index % len(SERIES)],
        "marker": _MARKERS[index % len(_MARKERS)],
        "markersize": 4.5,
    }


def _picture(result: LadderResult) -> Picture:
    """Draw differences between successive levels and values relative to the finest, over the levels."""
    words = "; ".join(f"{item.quantity.name}: {item.analysis.words}" for item in result.results)
    caption = (
        f"{result.ladder.name}. Left: differences between successive levels, relative to the finest value; finer "
        "levels are to the right; hollow marks are within the noise. Right: values."
    )
    places = np.array(result.ladder.levels if result.axis.rising else result.sizes)
    with picture(caption, _PAGE, _ROW + 0.5, f"Refinement of {result.ladder.name}: {words}.") as drawn:
        left, right = drawn.figure.subplots(1, 2)
        largest = 0.0
        for index, item in enumerate(result.results):
            values, style = np.array(item.values), _style(index)
            known = values[np.isfinite(values) & (values != 0.0)]
            finest = (
                values[-1] if np.isfinite(values[-1]) and values[-1] else (known[-1] if known.size else np.nan)
            )
            right.plot(places, values / finest, label=item.quantity.name, **style)
            scale = max(abs(values[-1]), item.scale) if np.isfinite(values[-1]) else item.scale
            if scale:
                y = np.abs(item.analysis.differences) / scale
                left.plot(places[y > 0.0], y[y > 0.0], **style)
                hollow = (y > 0.0) & (y <= item.analysis.noise / scale)
                left.plot(places[hollow], y[hollow], "o", ms=7, mfc="white", color=style["color"])
                largest = max(largest, float(np.nanmax(y, initial=0.0)))
        _reference_slope(left, result, places, largest)
        left.set(ylabel="relative difference", title="Difference from the level before")
        right.set(ylabel="value / value at the finest level", title="Values")
        for axes in (left, right):
            axes.set_xscale("log")
            axes.set_xlabel(result.axis.heading if result.axis.rising else result.axis.size)
            _ticks(axes, places)
            axes.margins(x=0.08, y=0.1)
            if not result.axis.rising:
                axes.invert_xaxis()
        right.ticklabel_format(axis="y", useOffset=False)
        if largest:
            _decades(left)
        drawn.figure.legend(*right.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return drawn


def _reference_slope(axes: Axes, result: LadderResult, places: np.ndarray, largest: float) -> None:
    """Draw a grey line of the declared order, or of the first confirmed one, above the differences."""
    declared = [item.declared for item in result.results if item.declared]
    confirmed = [item.analysis.order for item in result.results if math.isfinite(item.analysis.order)]
    if not (declared or confirmed) or not largest:
        return
    order = [*declared, *confirmed][0]
    h = np.array(result.sizes)[1:]
    y = 2.5 * largest * (h / h[0]) ** order
    axes.plot(places[1:], y, "--", color=GREY, linewidth=1.1)
    text = f"{'declared order' if declared else 'order'} {order:.3g}"
    style: dict[str, Any] = {"textcoords": "offset points", "color": GREY, "fontsize": 8.5}
    axes.annotate(text, (places[1], y[0]), xytext=(4, 4), **style)


def _comparison(group: Sequence[LadderResult], what: str) -> list[Block]:
    """Draw the ladders of a group side by side: `what` is "values", "errors" or ""."""
    group = [ladder for ladder in group if ladder.ladder.axis in ("elements", "modes")]
    if not what or len(group) < 2:
        return []
    first, errors = group[0], what == "errors"
    names = [item.quantity.name for item in first.results]
    shown = f"differences from the finest level of {first.ladder.name}" if errors else "values"
    ladders = ", ".join(ladder.ladder.name for ladder in group)
    alternative = f"{', '.join(names)} over elements or modes for {ladders}."
    rows = math.ceil(len(names) / 2)
    with picture(f"The ladders side by side: {shown}.", _PAGE, _ROW * rows + 0.5, alternative) as drawn:
        panels = drawn.figure.subplots(rows, 2, squeeze=False).ravel()
        for axes, name in zip(panels, names, strict=False):
            goal, spread = first.quantity(name).values[-1], []
            for index, ladder in enumerate(group):
                values = np.array(ladder.quantity(name).values)
                if errors:
                    values = np.abs(values / goal - 1.0) if goal else np.full(values.size, np.nan)
                    values[values == 0.0] = np.nan
                label = ladder.ladder.name.removeprefix(f"{ladder.ladder.group}, ")
                axes.plot(ladder.ladder.levels, values, label=label, **_style(index))
                spread += [abs(v) for v in values if np.isfinite(v)]
            label = name.replace("_", " ")
            unit = first.quantity(name).quantity.unit
            axes.set(title=name, ylabel="relative difference" if errors else with_unit(label, unit))
            axes.set_xscale("log", base=2)
            axes.set_xlabel(" or ".join(sorted({ladder.axis.label for ladder in group}, reverse=True)))
            _ticks(axes, sorted({level for ladder in group for level in ladder.ladder.levels}))
            if spread and min(spread) > 0.0 and (errors or max(spread) > 5.0 * min(spread)):
                _decades(axes)
        for axes in panels[len(names) :]:
            axes.axis("off")
        drawn.figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return [drawn]


def _ticks(axes: Axes, places: Sequence[float] | np.ndarray) -> None:
    axes.set_xticks(list(places))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: number(float(value), 3)))
    axes.xaxis.set_minor_locator(NullLocator())
    if any(len(number(float(place), 3)) > 4 for place in places):
        axes.tick_params(axis="x", labelrotation=30)


def _decades(axes: Axes) -> None:
    axes.set_yscale("log")
    axes.yaxis.set_minor_formatter(NullFormatter())
