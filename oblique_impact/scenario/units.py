"""Units of the scenario's keys, declared once as data; a text such as "12 mm" becomes a number in SI units."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

from pydantic import GetCoreSchemaHandler
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from oblique_impact.scenario.messages import not_allowed

_LONGEST = 100
#: value in SI units, powers of m, kg, s and rad; exact, so that "12 mm" is 0.012 to the last digit
_UNITS = {
    "m": (Fraction(1), (1, 0, 0, 0)),
    "g": (Fraction(1, 1000), (0, 1, 0, 0)),
    "s": (Fraction(1), (0, 0, 1, 0)),
    "rad": (Fraction(1), (0, 0, 0, 1)),
    "N": (Fraction(1), (1, 1, -2, 0)),
    "Pa": (Fraction(1), (-1, 1, -2, 0)),
    "J": (Fraction(1), (2, 1, -2, 0)),
    "Hz": (Fraction(1), (0, 0, -1, 0)),
}
_PREFIXES = {"n": -9, "u": -6, "µ": -6, "μ": -6, "m": -3, "c": -2, "d": -1, "k": 3, "M": 6, "G": 9}
_PI = Fraction(math.pi)
#: every name of a unit, with its prefixes
_NAMED = {
    **{p + n: (v * Fraction(10) ** e, powers) for n, (v, powers) in _UNITS.items() for p, e in _PREFIXES.items()},
    **_UNITS,
    "1": (Fraction(1), (0, 0, 0, 0)),
    "deg": (_PI / 180, (0, 0, 0, 1)),
    "°": (_PI / 180, (0, 0, 0, 1)),
    "rpm": (_PI / 30, (0, 0, -1, 1)),
}
_QUANTITY = re.compile(r"\s*([+-]?(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d{1,3})?)\s*(.*?)\s*")
_FACTOR = re.compile(r"\s*([/*·]?)\s*(1|[A-Za-zµμ°]+)(?:\^?(-?\d))?")
_RAISED = str.maketrans("⁻¹²³⁴", "-1234")


@dataclass(frozen=True)
class Unit:
    """SI unit of a key, for pydantic's ``Annotated``: texts with a unit become numbers before validation."""

    symbol: str  # as it is typed, such as "kg/m^3"

    @property
    def shown(self) -> str:
        """As it is printed, such as "kg/m³"."""
        return re.sub(r"\^(\d)", lambda power: "⁰¹²³⁴⁵⁶⁷⁸⁹"[int(power[1])], self.symbol)

    def to_si(self, text: str) -> float:
        """Return the number of "12 mm" in this unit; raises PydanticCustomError that says what is wrong."""
        found = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST else None
        wanted = f"{self.symbol} or deg" if self.symbol == "rad" else self.symbol
        if found is None or not found[2]:
            raise not_allowed(
                f'a number in {self.symbol}, or a text with number and unit such as "1 {self.symbol}"'
            )
        factor, powers = _expression(found[2], wanted)
        if powers != _expression(self.symbol, wanted)[1]:
            raise not_allowed(f"in {wanted}, not in {found[2]}")
        try:
            return float(Fraction(found[1]) * factor)
        except OverflowError:
            raise not_allowed("a finite number") from None

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self._convert, handler(source))

    def _convert(self, value: Any) -> Any:
        """Convert a text, the texts of a pair, or those of a table over x (m)."""
        if not isinstance(value, (list, tuple)):
            return self._entry(value)
        rows = []
        for number, row in enumerate(value, start=1):
            try:
                rows.append(self._row(row))
            except PydanticCustomError as error:
                raise not_allowed(f"{error.message()}; entry {number} is {str(row)[:40]!r}") from None
        return rows

    def _row(self, row: Any) -> Any:
        if isinstance(row, (list, tuple)) and len(row) == 2:
            return [_METRE._entry(row[0]), self._entry(row[1])]
        return self._entry(row)

    def _entry(self, value: Any) -> Any:
        return self.to_si(value) if isinstance(value, str) else value


_METRE = Unit("m")


def unit_of(field: FieldInfo) -> Unit | None:
    """Return the unit that a field of a model declares, if it does."""
    return next((entry for entry in field.metadata if isinstance(entry, Unit)), None)


@cache
def _expression(text: str, wanted: str) -> tuple[Fraction, tuple[int, ...]]:
    """Return the value in SI units and the powers of a product of units; `wanted` is for the message."""
    plain = re.sub(r"[⁻¹²³⁴]+", lambda power: "^" + power[0].translate(_RAISED), text.replace("**", "^"))
    factor, place = Fraction(1), 0
    powers: tuple[int, ...] = (0, 0, 0, 0)
    while place < len(plain):
        found = _FACTOR.match(plain, place)
        unit = _NAMED.get(found[2]) if found else None
        if found is None or unit is None:
            known = ", ".join([*_UNITS, "deg", "rpm"])
            raise not_allowed(f"in {wanted}; {text!r} is no unit (known: {known}, with prefixes n u m c d k M G)")
        power = int(found[3] or 1) * (-1 if found[1] == "/" else 1)
        factor *= unit[0] ** power
        powers = tuple(a + power * b for a, b in zip(powers, unit[1], strict=True))
        place = found.end()
    return factor, powers
