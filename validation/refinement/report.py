"""The report of a refinement study: HTML to read, JSON and CSV with the same numbers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from oblique_impact.errors import Outcome
from oblique_impact.scenario.scenario import Scenario, builtin_names
from oblique_impact.scenario.toml import flat_keys
from oblique_impact.validation.refinement.convergence import (
    CONVERGED,
    CONVERGING,
    NO_VERDICT,
    NOT_CONFIRMED,
    NOT_CONVERGING,
    NOT_DETERMINED,
    RULE,
)
from oblique_impact.validation.refinement.figures import comparison_picture, ladder_picture, relative_errors
from oblique_impact.validation.refinement.study import LadderResult, QuantityResult, StudyResult
from oblique_impact.validation.report.document import (
    Block,
    Cell,
    Document,
    Fold,
    Paragraph,
    Section,
    Table,
    number,
    number_cells,
    with_unit,
    write_csv,
    write_json,
    write_report,
)
from oblique_impact.validation.report.provenance import provenance, provenance_data

_KINDS = {
    CONVERGED: "pass",
    CONVERGING: "partly",
    NOT_CONFIRMED: "partly",
    NOT_CONVERGING: "fail",
    NOT_DETERMINED: "fail",
    NO_VERDICT: "dim",
}
CSV_COLUMNS = (
    "ladder",
    "axis",
    "level",
    "size",
    "outcome",
    "quantity",
    "unit",
    "value",
    "gap",
    "difference",
    "observed_order",
    "richardson_limit",
    "grid_convergence_index",
    "above_noise",
    "verdict",
)


def write_study(folder: Path, result: StudyResult, command: str) -> Path:
    """Write report.html, results.json and results.csv; returns the page.

    `command` is the command line that repeats the study.
    """
    write_json(folder, "results.json", study_data(result, command))
    write_csv(folder, "results.csv", CSV_COLUMNS, csv_rows(result))
    return write_report(folder, study_document(result, command))


def study_data(result: StudyResult, command: str) -> dict[str, Any]:
    """Everything the report says, for machines; `times` and `command` may differ between runs on one machine."""
    return {
        "study": result.study.name,
        "title": result.study.title,
        "command": command,
        "tolerance": result.tolerance,
        "rule": list(RULE),
        **provenance_data(),
        "ladders": [_ladder_data(ladder) for ladder in result.ladders],
        "times": {
            "wall_time": result.seconds,
            "runs": [[run["wall_time"] for run in r.runs] for r in result.ladders],
        },
    }


def _ladder_data(result: LadderResult) -> dict[str, Any]:
    ladder = result.ladder
    return {
        "name": ladder.name,
        "axis": ladder.axis,
        "levels": list(ladder.levels),
        "sizes": list(result.sizes),
        "size": result.axis.size_label,
        "remark": result.remark,
        "finest_scenario": result.scenarios[-1].model_dump(mode="json"),
        "runs": [
            {
                "level": level,
                "outcome": run["outcome"],
                "end_time": run["stopped_at"],
                "steps": run["steps"],
                "events": run["events"],
                "warnings": run["warnings"],
            }
            for level, run in zip(ladder.levels, result.runs, strict=True)
        ],
        "quantities": [_quantity_data(item) for item in result.results],
    }


def _quantity_data(item: QuantityResult) -> dict[str, Any]:
    a = item.analysis
    triplets = [asdict(t) if t else None for t in a.triplets]
    return {
        "name": item.quantity.name,
        "unit": item.quantity.unit,
        "meaning": item.quantity.meaning,
        "values": list(item.values),
        "gaps": list(item.gaps),
        "differences": list(a.differences),
        "observed_orders": [t and t["order"] for t in triplets],
        "richardson_limits": [t and t["limit"] for t in triplets],
        "grid_convergence_indices": [t and t["index"] for t in triplets],
        "two_level_index": a.pair_index,
        "noise": a.noise,
        "declared_order": item.declared,
        "verdict": a.verdict,
        "words": a.words,
        "order": a.order,
        "limit": a.limit,
        "uncertainty": a.uncertainty,
        "scale": item.scale,
        "reason": a.reason,
        "without_limit": item.without_limit,
    }


def csv_rows(result: StudyResult) -> Iterable[list[Any]]:
    """One row for each ladder, quantity and level; empty cells where there is nothing."""
    for ladder in result.ladders:
        for item in ladder.results:
            for i, level in enumerate(ladder.ladder.levels):
                t = item.analysis.triplets[i]
                numbers = (item.values[i], item.gaps[i], item.analysis.differences[i])
                found = (t.order, t.limit, t.index) if t else ("", "", "")
                yield [
                    ladder.ladder.name,
                    ladder.ladder.axis,
                    level,
                    ladder.sizes[i],
                    ladder.runs[i]["outcome"],
                    item.quantity.name,
                    item.quantity.unit,
                    *("" if value != value else value for value in (*numbers, *found)),
                    ("yes" if t.resolved else "no") if t else "",
                    item.analysis.words,
                ]


def study_document(result: StudyResult, command: str) -> Document:
    """Return the report as a document."""
    study = result.study
    facts = [
        ("tolerance", f"{number(result.tolerance)} (relative)"),
        *provenance(),
    ]
    matrices = [_matrix(group) for group in _groups(result) if len(group) > 1]
    return Document(
        f"Refinement study: {study.title}",
        study.text,
        facts,
        [("command", command), ("wall time", f"{result.seconds:.1f} s")],
        overview=[
            *matrices,
            *_comparisons(result),
            _verdicts(result),
            *(
                Paragraph(f"{ladder.ladder.name}: {remark}.", note=True)
                for ladder in result.ladders
                for remark in ladder.remarks
            ),
            Fold("How a verdict is found", [Paragraph(text) for text in RULE]),
        ],
        sections=[_section(ladder) for ladder in result.ladders],
    )


def _comparisons(result: StudyResult) -> list[Block]:
    """Pictures of the ladders side by side, one a group, with a table where differences are shown."""
    if not result.study.compare:
        return []
    errors = result.study.compare == "errors"
    blocks: list[Block] = []
    for together in _groups(result):
        group = [ladder for ladder in together if ladder.axis.name in ("elements", "modes")]
        if len(group) > 1:
            blocks.append(comparison_picture(group, errors))
            blocks += [_errors(group)] if errors else []
    return blocks


def _errors(group: list[LadderResult]) -> Table:
    first = group[0]
    rows: list[list[str | Cell]] = []
    for item in first.results:
        name = item.quantity.name
        for ladder in group:
            errors = relative_errors(ladder.quantity(name), item)
            rows.append([name, ladder.ladder.name, *number_cells(*errors, digits=2)])
    columns = ["quantity", "ladder", *(f"{number(level)} {first.axis.label}" for level in first.ladder.levels)]
    return Table(columns, rows, f"Relative differences from the finest level of {first.ladder.name}")


def _groups(result: StudyResult) -> list[list[LadderResult]]:
    groups: dict[str, list[LadderResult]] = {}
    for ladder in result.ladders:
        groups.setdefault(ladder.ladder.group, []).append(ladder)
    return list(groups.values())


def _matrix(group: list[LadderResult]) -> Table:
    """Verdicts: quantities by ladders."""
    names = list(dict.fromkeys(item.quantity.name for ladder in group for item in ladder.results))
    rows: list[list[str | Cell]] = []
    for ladder in group:
        by_name = {item.quantity.name: _short_cell(item) for item in ladder.results}
        rows.append([ladder.ladder.name, *(by_name.get(name, Cell("", "dim")) for name in names)])
    return Table(["", *names], rows, "What converges; p is the confirmed order")


def _short_cell(item: QuantityResult) -> Cell:
    a = item.analysis
    order = f", p = {a.order:.2f}" if a.order == a.order else ""
    return Cell(f"{a.verdict}{order}", _kind(item))


def _kind(item: QuantityResult) -> str:
    """Kind of the cell of a verdict; "partly" at one number of modes where there is no limit over them."""
    return "partly" if item.analysis.verdict == CONVERGED and item.without_limit else _KINDS[item.analysis.verdict]


def _verdicts(result: StudyResult) -> Table:
    rows: list[list[str | Cell]] = []
    for ladder in result.ladders:
        for item in ladder.results:
            a = item.analysis
            finest = number_cells(a.shown(item.values[-1]))
            limit = number_cells(a.shown(a.limit), number(a.uncertainty, 2))
            verdict = Cell(a.words, _kind(item))
            name, unit = item.quantity.name, item.quantity.unit
            rows.append([ladder.ladder.name, name, *finest, unit, *limit, verdict, a.reason])
    columns = ["ladder", "quantity", "finest value", "unit", "limit", "uncertainty", "verdict", "because"]
    return Table(columns, rows, "Verdicts; limits are given where the order is confirmed", wide=[0, 7])


def _section(result: LadderResult) -> Section:
    ladder, axis = result.ladder, result.axis
    scenario = ladder.scenario if "/" not in ladder.scenario else Path(ladder.scenario).name
    blocks = [
        Paragraph(ladder.text) if ladder.text else None,
        Paragraph(
            f"Scenario {scenario}; {_changes(result)}. Refined: {axis.name} "
            f"{', '.join(number(level) for level in ladder.levels)}; h is {axis.size_label}. {result.remark}",
            note=True,
        ),
        ladder_picture(result),
        _runs(result),
        *(Paragraph(f"{remark[:1].upper()}{remark[1:]}.", note=True) for remark in result.remarks),
        *(_levels(result, item) for item in result.results),
    ]
    return Section(ladder.name, [block for block in blocks if block])


def _changes(result: LadderResult) -> str:
    """Say what is changed against the scenario of that name, or against the defaults."""
    name = result.ladder.scenario
    original = Scenario.builtin(name) if name in builtin_names() else Scenario()
    given, plain = (flat_keys(scenario.model_dump(mode="json")) for scenario in (result.base, original))
    changed = [f"{key} = {value}" for key, value in given.items() if repr(value) != repr(plain.get(key))]
    against = "" if name in builtin_names() else " (against the defaults)"
    return ", ".join(changed) + against if changed else "no changes"


def _runs(result: LadderResult) -> Table:
    rows: list[list[str | Cell]] = []
    for level, size, run in zip(result.ladder.levels, result.sizes, result.runs, strict=True):
        completed = run["outcome"] == Outcome.COMPLETED.label
        outcome = Cell(run["outcome"], "" if completed else "fail")
        others = number_cells(run["stopped_at"], run["steps"], run["events"])
        rows.append([*number_cells(level, number(size, 4)), outcome, *others, run["message"]])
    columns = [result.axis.heading, "h", "outcome", "ended at (s)", "steps", "events", ""]
    return Table(columns, rows, "Runs", wide=[6])


def _levels(result: LadderResult, item: QuantityResult) -> Table:
    a, unit = item.analysis, item.quantity.unit
    rows: list[list[str | Cell]] = []
    for i, level in enumerate(result.ladder.levels):
        t = a.triplets[i]
        dim = "number" if t is None or t.resolved else "dim"
        value = Cell(item.gaps[i], "dim") if item.gaps[i] else Cell(a.shown(item.values[i]), "number")
        found = (number(t.order, 3), a.shown(t.limit), number(t.index, 2)) if t else ("–", "–", "–")
        difference = number_cells(a.differences[i], digits=3)
        rows.append([*number_cells(level), value, *difference, *(Cell(text, dim) for text in found)])
    declared = f", declared order {item.declared:g}" if item.declared else ""
    caption = (
        f"{item.quantity.name}: {item.quantity.meaning}{declared}. Verdict: {a.words} ({a.reason}); "
        f"uncertainty {number(a.uncertainty, 2)} {unit}, noise {number(a.noise, 2)} {unit}, "
        f"GCI of the last two levels alone {number(a.pair_index, 2)} {unit}"
    )
    columns = [
        result.axis.heading,
        with_unit("value", unit),
        with_unit("difference", unit),
        "observed order",
        with_unit("Richardson limit", unit),
        with_unit("GCI", unit),
    ]
    return Table(columns, rows, caption)
