"""Units of the scenario's keys: a text such as "12 mm" becomes a number in SI units, by pint."""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

#: units for pint.  Unlike in its own list an angle has a dimension, so that "5 Hz" is not taken for 5 rad/s;
#: in fractions "12 mm" is 0.012 to the last digit
_DEFINITIONS = """
nano- = 1e-9 = n-
micro- = 1e-6 = u- = µ- = μ-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
deci- = 1e-1 = d-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
pi = 3.1415926535897932384626433832795028841971693993751
meter = [length] = m
gram = [mass] = g
second = [time] = s
radian = [angle] = rad
degree = pi / 180 * radian = deg = °
turn = 2 * pi * radian
minute = 60 * second = min
hertz = 1 / second = Hz
rpm = turn / minute
newton = kilogram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
joule = newton * meter = J
inch = 0.0254 * meter = in
foot = 12 * inch = ft
pound = 453.59237 * gram = lb
"""
_KNOWN = "m, g, s, rad, N, Pa, J, Hz, deg, rpm, min, in, ft, lb, with prefixes n u m c d k M G"
_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?)\s*(\D.*|1\s*/.*)")
#: in the schema of a file: a number and something behind it
_TEXT = {"type": "string", "pattern": r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?\s*(1\s*/\s*)?[A-Za-zµμ°]"}


@dataclass(frozen=True)
class Unit:
    """SI unit of a key, for pydantic's ``Annotated``: texts with a unit become numbers before validation."""

    symbol: str  # as it is typed, such as "kg/m^3"
    over: str = "m"  # in tables, the unit of the first number of a row

    @property
    def shown(self) -> str:
        """As it is printed, such as "kg/m³"."""
        return re.sub(r"\^(\d)", lambda power: "⁰¹²³⁴⁵⁶⁷⁸⁹"[int(power[1])], self.symbol)

    def to_si(self, text: str) -> float:
        """Return the number of "12 mm" in this unit; raises ValueError that says what is allowed."""
        found = _QUANTITY.fullmatch(text)
        if found is None:
            example = f'a text with number and unit such as "1 {self.symbol}"'
            raise ValueError(f"a number in {self.symbol}, or {example}")
        try:
            return float(Fraction(found[1]) * _factor(found[2].strip(), self.symbol))
        except OverflowError:
            raise ValueError("a finite number") from None

    def convert(self, value: Any) -> Any:
        """Return a value in which texts are numbers: itself, or those of a list or a table [[x, value]]."""
        if isinstance(value, str):
            return self.to_si(value)
        if not isinstance(value, list | tuple):
            return value
        rows = []
        for number, row in enumerate(value, start=1):
            try:
                is_pair = isinstance(row, list | tuple) and len(row) == 2
                of_first = Unit(self.over) if is_pair else self
                rows.append([of_first.convert(row[0]), self.convert(row[1])] if is_pair else self.convert(row))
            except ValueError as error:
                raise ValueError(f"{error}; entry {number} is {str(row)[:40]!r}") from None
        return rows

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self.convert, handler(source))

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"unit": self.symbol, **_with_texts(handler(core))}


def unit_of(field: FieldInfo) -> Unit | None:
    """Return the unit that a field of a model declares, if it does."""
    return next((entry for entry in field.metadata if isinstance(entry, Unit)), None)


@cache
def _registry() -> Any:
    import pint  # takes half a second, and most scenarios are numbers

    return pint.UnitRegistry(_DEFINITIONS.strip().splitlines(), non_int_type=Fraction)


@cache
def _factor(unit: str, wanted: str) -> Fraction:
    """Return the value of a unit in another one; raises ValueError."""
    from pint import DimensionalityError

    allowed = f"in {wanted} or deg" if wanted == "rad" else f"in {wanted}"
    powers = re.sub(r"([A-Za-zµμ°])(\d)", r"\1^\2", unit)  # "mm2"
    try:
        return Fraction(_registry().Quantity(Fraction(1), powers).to(wanted).magnitude)
    except DimensionalityError:
        raise ValueError(f"{allowed}, not in {unit}") from None
    except Exception:  # pint raises errors of many kinds for a text that is no unit
        raise ValueError(f"{allowed}; {unit!r} is no unit (known: {_KNOWN})") from None


def _with_texts(schema: JsonSchemaValue) -> JsonSchemaValue:
    """Return a JSON Schema whose numbers may be texts with a unit as well."""
    if "anyOf" in schema:
        return {**schema, "anyOf": [part for inner in schema["anyOf"] for part in _alternatives(inner)]}
    if schema.get("type") == "number":
        return {"anyOf": _alternatives(schema)}
    found = dict(schema)
    if "items" in schema:
        found["items"] = _with_texts(schema["items"])
    if "prefixItems" in schema:  # of a pair
        found["prefixItems"] = [_with_texts(item) for item in schema["prefixItems"]]
    return found


def _alternatives(schema: JsonSchemaValue) -> list[JsonSchemaValue]:
    return [schema, _TEXT] if schema.get("type") == "number" else [_with_texts(schema)]
