"""The table of a sweep: one Parquet file, one row a run, in the order of the runs; every column with its unit.

All columns but `wall_time`, the last one, are the same from one sweep to the next, bit for bit.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, write_whole
from oblique_impact.validation.measuring import REGIMES, Row, same_warnings
from oblique_impact.validation.sweeps.keys import kind, unit
from oblique_impact.validation.sweeps.plan import Plan

_TYPES = {float: pa.float64(), int: pa.int64(), bool: pa.bool_(), str: pa.string(), tuple: pa.string()}

#: columns after those of the keys and the quantities: type, unit, meaning
_COLUMNS = {
    "regime": (pa.string(), "", f"first macro-collision: {', '.join(REGIMES)}"),
    "outcome": (pa.string(), "", "how the run ended"),
    "message": (pa.string(), "", "why, if it did not reach its end time"),
    "gaps": (pa.string(), "", "why quantities are missing"),
    "warnings": (pa.string(), "", "warnings of the run"),
    "stopped_at": (pa.float64(), "s", "time that the run reached"),
    "steps": (pa.int64(), "1", "steps"),
    "wall_time": (pa.float64(), "s", "wall time of the run; the only column that differs from sweep to sweep"),
}


def make_table(plan: Plan, rows: Iterable[Row]) -> pa.Table:
    """Put the rows of all runs, in any order, into one table.

    Raises ValueError if a run is missing.
    """
    by_run = {row["run"]: row for row in rows}
    ordered = [by_run[run] for run in range(plan.design.size) if run in by_run]
    if len(ordered) != plan.design.size:
        raise ValueError(f"{plan.design.size - len(ordered)} of {plan.design.size} runs are missing")
    fields = [pa.field("run", pa.int64(), metadata=_about("1", "number of the run, from 1"))]
    columns: list[list[Any]] = [list(range(1, len(ordered) + 1))]
    values = [plan.design.values(run) for run in range(plan.design.size)]
    for place, key in enumerate(plan.design.keys):
        column = [row[place] for row in values]
        type_ = _column_type(key, column)
        fields.append(pa.field(key, type_, metadata=_about(unit(key), "key of the scenario")))
        as_text = type_ == pa.string() and kind(key) is not str
        columns.append([json.dumps(v) for v in column] if as_text else column)
    for q in plan.quantities:
        fields.append(pa.field(q.name, pa.float64(), metadata=_about(q.unit, q.meaning)))
        columns.append([_known(row["values"].get(q.name)) for row in ordered])
    for name, (type_, its_unit, meaning) in _COLUMNS.items():
        fields.append(pa.field(name, type_, metadata=_about(its_unit, meaning)))
        columns.append([_entry(row, name) for row in ordered])
    schema = pa.schema(fields, metadata=_head(plan))
    return pa.table([pa.array(c, f.type) for c, f in zip(columns, fields, strict=True)], schema=schema)


def warned(table: pa.Table) -> list[tuple[int, str, str]]:
    """Return the warnings: number of runs that have it, the first of them, and the text; most frequent first."""
    texts = zip(map(str, table["run"].to_pylist()), table["warnings"].to_pylist(), strict=True)
    found = same_warnings((run, [text] if text else []) for run, text in texts)
    return sorted(((len(runs), runs[0], text) for text, runs in found), key=lambda entry: -entry[0])


def write_table(path: Path, table: pa.Table) -> None:
    """Write the file, whole or not at all; raises InputError if it cannot be written."""
    try:
        write_whole(path, lambda temporary: pq.write_table(table, temporary, write_page_checksum=True))
    except OSError as error:
        raise cannot_write(path, error) from None


def read_table(path: Path, plan: Plan) -> pa.Table:
    """Read the file; raises InputError if it is damaged, or not of this plan."""
    try:
        # a table is a single file: other files that its metadata or its neighbours speak of are not read
        with pq.ParquetFile(path, page_checksum_verification=True) as file:
            if file.schema_arrow.names != [
                "run",
                *plan.design.keys,
                *(q.name for q in plan.quantities),
                *_COLUMNS,
            ]:
                raise pa.ArrowInvalid("has other columns than this sweep")
            table = file.read()
        table.validate(full=True)
        if table["run"].to_pylist() != list(range(1, plan.design.size + 1)):
            raise pa.ArrowInvalid("runs are missing")
    except (OSError, pa.ArrowException, ValueError) as error:
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"{path}: not a readable table: {reason}; delete it and sweep again") from None
    return table


def _about(unit: str, meaning: str) -> dict[str, str]:
    return {"unit": unit, "meaning": meaning}


def _head(plan: Plan) -> dict[str, str]:
    changes = {key: list(v) if isinstance(v, tuple) else v for key, v in plan.changes.items()}
    return {
        "title": plan.file.title,
        "fingerprint": plan.fingerprint,
        "scenario": plan.base.to_toml(),
        "changes": json.dumps(changes),
    }


def _column_type(key: str, values: list[Any]) -> pa.DataType:
    """Type of a key's column; tables over x become JSON."""
    if any(isinstance(value, tuple) for value in values):
        return pa.string()
    return _TYPES[kind(key)]


def _known(value: float | None) -> float | None:
    return None if value is None or math.isnan(value) else value


def _entry(row: Row, name: str) -> Any:
    if name == "gaps":
        return "; ".join(f"{quantity}: {why}" for quantity, why in row["gaps"].items())
    if name == "warnings":
        return "; ".join(row["warnings"])
    value = row[name]  # type: ignore[literal-required]
    return _known(value) if isinstance(value, float) else value
