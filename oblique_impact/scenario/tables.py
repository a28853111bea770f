"""Numbers that may be tables over x in a scenario file: `[[x, value], ...]`, linear between the rows."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator
from pydantic_core import PydanticCustomError

from oblique_impact.scenario.messages import short

MAX_ROWS = 1000
_LARGEST = 1e30

Table = tuple[tuple[float, float], ...]


def _validate(value: Any) -> float | Table:
    """Check a positive number, or the rows of a table as far as they can be judged without the beam's length."""
    if isinstance(value, (list, tuple)):
        return _table(value)
    if not _is_number(value):
        raise _fault("a number greater than 0, or a table of pairs [x, value]")
    return _positive(value, "")


def _table(rows: list[Any] | tuple[Any, ...]) -> Table:
    if not 2 <= len(rows) <= MAX_ROWS:
        raise _fault(f"a number, or a table of 2 to {MAX_ROWS} pairs [x, value], not of {len(rows)}")
    table: list[tuple[float, float]] = []
    for number, row in enumerate(rows, start=1):
        if not (isinstance(row, (list, tuple)) and len(row) == 2 and all(_is_number(v) for v in row)):
            raise _fault(f"a table of pairs [x, value] of numbers; row {number} is {short(row)}")
        x, value = (_float(v, f"; row {number} is {short(row)}") for v in row)
        if not table and x != 0.0:
            raise _fault(f"a table that begins at x = 0, not at {x}")
        if table and x <= table[-1][0]:
            raise _fault(f"a table with strictly ascending x; in row {number} {x} follows {table[-1][0]}")
        table.append((x, _positive(value, f"; row {number} is {short(row)}")))
    return tuple(table)


def _positive(value: Any, where: str) -> float:
    number = _float(value, where)
    if not number > 0.0:
        raise _fault(f"greater than 0{where}")
    if number > _LARGEST:
        raise _fault(f"less than or equal to {_LARGEST:g}{where}")
    return number


def _float(value: Any, where: str) -> float:
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise _fault(f"a finite number{where}")
    return number


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _fault(message: str) -> PydanticCustomError:
    # without a context the message is taken as it is, braces and all
    return PydanticCustomError("number_or_table", message)


def _as_it_is(value: float | Table) -> float | Table:
    return value


#: a positive number, or a table of it over x from 0 to beam.length
Tabulated = Annotated[float | Table, PlainValidator(_validate), PlainSerializer(_as_it_is, return_type=Any)]
