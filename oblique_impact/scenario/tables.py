"""Tables of a number over x in a scenario file, `[[x, value], ...]`."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator, WithJsonSchema

from oblique_impact.scenario.messages import short

MAX_ROWS = 1000
LARGEST = 1e30  # a bound that only keeps infinity out

Table = tuple[tuple[float, float], ...]


def _number_or_table(value: Any) -> float | Table:
    """Check a positive number, or the rows of a table as far as they can be judged without the beam's length."""
    if not isinstance(value, (list, tuple)):
        if not _is_number(value):
            raise ValueError("a number greater than 0, or a table of pairs [x, value]")
        return _positive(value, "")
    rows = value
    if not 2 <= len(rows) <= MAX_ROWS:
        raise ValueError(f"a number, or a table of 2 to {MAX_ROWS} pairs [x, value], not of {len(rows)}")
    table: list[tuple[float, float]] = []
    for number, row in enumerate(rows, start=1):
        where = f"; row {number} is {short(row)}"
        if not (isinstance(row, (list, tuple)) and len(row) == 2 and all(_is_number(v) for v in row)):
            raise ValueError(f"a table of pairs [x, value] of numbers{where}")
        if not table and row[0] != 0.0:
            raise ValueError(f"a table that begins at x = 0, not at {row[0]}")
        if table and not table[-1][0] < row[0] <= LARGEST:
            raise ValueError(f"a table with finite, strictly ascending x{where}")
        table.append((float(row[0]), _positive(row[1], where)))
    return tuple(table)


def _size_or_table(value: Any) -> float | Table:
    """Check a number that may be 0, which is as if it were not given, or a table of positive ones."""
    if not _is_number(value) or not value <= 0.0:
        return _number_or_table(value)
    if value < 0.0:
        raise ValueError("a finite number greater than or equal to 0, or a table of pairs [x, value]")
    return 0.0


def _positive(value: Any, where: str) -> float:
    if not 0.0 < value <= LARGEST:
        raise ValueError(f"a finite number greater than 0, less than or equal to {LARGEST:g}{where}")
    return float(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


_POSITIVE = {"type": "number", "exclusiveMinimum": 0.0, "maximum": LARGEST}
_PAIR = {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number", "minimum": 0.0}}
_PAIRS = {"type": "array", "minItems": 2, "maxItems": MAX_ROWS, "items": _PAIR}

#: a positive number, or a table of it over x from 0 to beam.length
Tabulated = Annotated[
    float | Table,
    PlainValidator(_number_or_table),
    PlainSerializer(lambda value: value, return_type=Any),
    WithJsonSchema({"anyOf": [_POSITIVE, _PAIRS]}),
]
#: the same, or 0
Size = Annotated[
    float | Table,
    PlainValidator(_size_or_table),
    PlainSerializer(lambda value: value, return_type=Any),
    WithJsonSchema({"anyOf": [{"type": "number", "minimum": 0.0, "maximum": LARGEST}, _PAIRS]}),
]
