"""The report of a sweep: one page with its pictures; the numbers are in the table."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from oblique_impact.errors import Outcome
from oblique_impact.validation.report.document import (
    Block,
    Cell,
    Document,
    Paragraph,
    Section,
    Table,
    number,
    number_cells,
    write_report,
)
from oblique_impact.validation.report.provenance import provenance
from oblique_impact.validation.sweeps.design import Dimension
from oblique_impact.validation.sweeps.figures import sweep_pictures
from oblique_impact.validation.sweeps.keys import unit
from oblique_impact.validation.sweeps.plan import Plan
from oblique_impact.validation.sweeps.table import warned

if TYPE_CHECKING:
    import pyarrow as pa

#: runs that did not complete, and distinct warnings, listed at most
_LISTED = 20


def write_sweep_report(folder: Path, plan: Plan, table: pa.Table, command: str) -> Path:
    """Write report.html; returns the file.  Raises InputError."""
    return write_report(folder, sweep_document(plan, table, command))


def sweep_document(plan: Plan, table: pa.Table, command: str) -> Document:
    """Return the report of a finished sweep; `command` repeats it."""
    seconds = [float(value) for value in table["wall_time"].to_pylist()]
    sections = []
    pictures = sweep_pictures(plan, table)
    if pictures:
        sections.append(Section("Pictures", pictures))
    sections.append(Section("Directions and quantities", _descriptions(plan, table)))
    unfinished = _unfinished(table)
    if unfinished:
        sections.append(Section("Runs that did not complete", unfinished))
    overview: list[Block] = [_outcomes(table), *_warnings(table)]
    if not pictures:
        overview.append(Paragraph("Pictures are drawn for sweeps with one or two directions.", note=True))
    return Document(
        plan.file.title or "Sweep",
        plan.file.description or "A scenario over axes of its keys; every run is a row of results.parquet.",
        [
            ("runs", str(plan.design.size)),
            ("scenario", Path(plan.file.scenario).name),
            ("changes", ", ".join(f"{key} = {value}" for key, value in plan.changes.items()) or "none"),
            ("fingerprint", plan.fingerprint),
            *provenance(),
        ],
        [
            ("command", command),
            ("wall time of all runs together", f"{sum(seconds):.1f} s"),
            ("of one run", f"{sum(seconds) / len(seconds):.3f} s in the mean, {max(seconds):.3f} s at most"),
        ],
        overview,
        sections,
    )


def _outcomes(table: pa.Table) -> Table:
    outcomes = Counter(zip(table["outcome"].to_pylist(), table["regime"].to_pylist(), strict=True))
    rows = [
        [Cell(outcome, "" if outcome == Outcome.COMPLETED.label else "dim"), regime or "–", *number_cells(n)]
        for (outcome, regime), n in sorted(outcomes.items(), key=lambda item: (-item[1], item[0]))
    ]
    return Table(["outcome", "first macro-collision", "runs"], rows, "How the runs ended.")


def _warnings(table: pa.Table) -> list[Block]:
    rows: list[list[str | Cell]] = [[*number_cells(count, run), text] for count, run, text in warned(table)]
    caption = "Warnings of the runs; the column warnings of the table has those of each."
    return [Table(["runs", "the first", "warning"], rows[:_LISTED], caption, wide=(2,))] if rows else []


def _descriptions(plan: Plan, table: pa.Table) -> list[Block]:
    directions = [_direction_row(dimension, table) for dimension in plan.design.dimensions]
    quantities: list[list[str | Cell]] = []
    for q in plan.quantities:
        values = [v for v in table[q.name].to_pylist() if v is not None]
        cells = number_cells(min(values, default=None), max(values, default=None), plan.design.size - len(values))
        quantities.append([Cell(q.name, "code"), q.meaning, q.unit, *cells])
    return [
        Table(["direction", "unit", "values", "from", "to"], directions, "What changes from run to run."),
        Table(
            ["quantity", "meaning", "unit", "least", "largest", "missing"],
            quantities,
            "What each run is asked for; the column gaps of the table says why a value is missing.",
            wide=(1,),
        ),
    ]


def _direction_row(dimension: Dimension, table: pa.Table) -> list[str | Cell]:
    values = table[dimension.keys[0]].to_pylist()
    numeric = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in values)
    ends = (number(min(values)), number(max(values))) if numeric else (str(values[0]), str(values[-1]))
    return [Cell(dimension.label, "code"), unit(dimension.keys[0]), *number_cells(len(set(values)), *ends)]


def _unfinished(table: pa.Table) -> list[Block]:
    rows = [
        [*number_cells(row["run"]), row["outcome"], *number_cells(row["stopped_at"]), row["message"]]
        for row in table.select(["run", "outcome", "stopped_at", "message"]).to_pylist()
        if row["outcome"] != Outcome.COMPLETED.label
    ]
    if not rows:
        return []
    more = f"The first {_LISTED} of {len(rows)}." if len(rows) > _LISTED else ""
    return [Table(["run", "outcome", "at (s)", "why"], rows[:_LISTED], more, wide=(3,))]
