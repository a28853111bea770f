"""Units of the scenario's keys: a text such as "12 mm" becomes a number in SI units, by pint."""

from __future__ import annotations

import math
import re
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from itertools import product
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

#: units for pint: name, value, symbol, further names.  Unlike in its own list an angle has a dimension, so that
#: "5 Hz" is not taken for 5 rad/s; in fractions "12 mm" is 0.012 to the last digit
_DEFINITIONS = """
pico- = 1e-12 = p-
nano- = 1e-9 = n-
micro- = 1e-6 = u- = µ- = μ-
milli- = 1e-3 = m-
centi- = 1e-2 = c-
deci- = 1e-1 = d-
hecto- = 1e2 = h-
kilo- = 1e3 = k-
mega- = 1e6 = M-
giga- = 1e9 = G-
tera- = 1e12 = T-
pi = 3.1415926535897932384626433832795028841971693993751
meter = [length] = m = metre
gram = [mass] = g = gramme
second = [time] = s = sec
radian = [angle] = rad
degree = pi / 180 * radian = deg = °
turn = 2 * pi * radian = rev = revolution
percent = 0.01
strain = 1 = ε
minute = 60 * second = min
hour = 3600 * second = h = hr
hertz = 1 / second = Hz
rpm = turn / minute
tonne = 1e6 * gram = t
newton = kilogram * meter / second ** 2 = N
pascal = newton / meter ** 2 = Pa
bar = 1e5 * pascal
atmosphere = 101325 * pascal = atm
joule = newton * meter = J
watt = joule / second = W
standard_gravity = 9.80665 * meter / second ** 2 = g_n
kilogram_force = kilogram * standard_gravity = kgf = kilopond = kp
inch = 0.0254 * meter = in = inches
thou = inch / 1000 = mil
foot = 12 * inch = ft = feet
yard = 3 * foot = yd
pound = 453.59237 * gram = lb = lbs = lbm
ounce = pound / 16 = oz
pound_force = pound * standard_gravity = lbf
kip = 1000 * pound_force
slug = pound_force * second ** 2 / foot
psi = pound_force / inch ** 2
ksi = kip / inch ** 2
"""
_KNOWN = "m, g, s, rad, N, Pa, J, Hz, deg, rpm, min, bar, in, ft, lb, lbf, psi, with prefixes n u m c d k M G"
_NUMBER = re.compile(r"([+-]?(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d++)?+)\s*")
_LONGEST = 200  # characters of a text

# what may stand for a unit, to its last letter: pint's own parser drops "#5" and what stands behind it
_POWER = r"(?:\s*(?:\^|\*\*)\s*([+-]?\d+)|(-?\d+)|([⁺⁻]?[⁰¹²³⁴⁵⁶⁷⁸⁹]+))"
_FACTOR = re.compile(rf"([A-Za-zµμε°%]+(?:_[a-z]+)?){_POWER}?")
_BETWEEN = r"(?:\s*[*/·⋅∙]\s*|\s+)"
_PRODUCT = rf"{_FACTOR.pattern}(?:{_BETWEEN}{_FACTOR.pattern})*"
_GROUP = rf"(?:{_FACTOR.pattern}|\(\s*{_PRODUCT}\s*\))"
_UNIT = re.compile(rf"(?:1?\s*/\s*)?{_GROUP}(?:{_BETWEEN}{_GROUP})*")
_RAISED = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")

#: what else people write for a unit, beside other cases of its letters and units without a blank between them
_MEANT = {
    '"': "in",
    "″": "in",
    "'": "ft",
    "′": "ft",
    "lb": "lbf",
    "kg": "kgf",
    "g": "g_n",
    "Hz": "rev/s",
    "rpm": "1/min",
}
#: in the schema of a file: a number and something behind it
_TEXT = {
    "type": "string",
    "pattern": r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?\s*(1?\s*/\s*)?\(?[A-Za-zµμ°]",
}


@dataclass(frozen=True)
class Unit:
    """SI unit of a key, for pydantic's ``Annotated``: texts with a unit become numbers before validation."""

    symbol: str  # as it is typed, such as "kg/m^3"
    over: str = "m"  # in tables, the unit of the first number of a row
    words: tuple[str, ...] = ()  # texts that are no numbers

    @property
    def shown(self) -> str:
        """As it is printed, such as "kg/m³"."""
        return re.sub(r"\^(\d)", lambda power: "⁰¹²³⁴⁵⁶⁷⁸⁹"[int(power[1])], self.symbol)

    def to_si(self, text: str) -> float:
        """Return the number of "12 mm" in this unit; raises ValueError that says what is allowed."""
        text = text.strip()
        found = _NUMBER.match(text)
        unit = text[found.end() :] if found else ""
        if found is None or not unit or len(text) > _LONGEST:
            example = f"{text if found and len(text) <= _LONGEST else 1} {self.symbol}"
            raise ValueError(f'a number in {self.symbol}, or a text with number and unit such as "{example}"')
        if re.match(r"[,_']?\d", unit) and not _UNIT.fullmatch(unit):
            raise ValueError(f'a number with a decimal point and without separators, as "1234.5 {self.symbol}"')
        number = float(found[1])
        if math.isinf(number):
            raise ValueError("a finite number")
        factor = _factor(unit, self.symbol)
        try:
            return float(Fraction(found[1]) * factor) if number else number
        except OverflowError:
            raise ValueError("a finite number") from None

    def convert(self, value: Any) -> Any:
        """Return a value in which texts are numbers: itself, or those of a list or a table [[x, value]]."""
        if isinstance(value, str):
            return value if value in self.words else self.to_si(value)
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
def _known() -> frozenset[str]:
    """Return the units by name and symbol, with prefixes; names also in the plural."""
    lines = [[part.strip() for part in line.split("=")] for line in _DEFINITIONS.strip().splitlines()]
    named = [[name, *others] for name, value, *others in lines if name != "pi"]
    prefixes = ["", *(name.rstrip("-") for line in named for name in line if name.endswith("-"))]
    units = [line for line in named if not line[0].endswith("-")]
    units += [[f"{line[0]}s"] for line in units]
    return frozenset(prefix + name for prefix in prefixes for line in units for name in line)


@cache
def _factor(unit: str, wanted: str) -> Fraction:
    """Return the value of a unit in another one; raises ValueError that says what may have been meant."""
    allowed = {"rad": "in rad or deg", "1": "without a unit"}.get(wanted, f"in {wanted}")
    try:
        return _value(unit, wanted)
    except ValueError:
        meant = " or ".join(f'"{other}"' for other in _meant(unit, wanted)[:2])
        hint = f"; did you mean {meant}?" if meant else ""
    if _is_unit(unit):
        raise ValueError(f"{allowed}, not in {unit}{hint}")
    raise ValueError(f"{allowed}; {unit!r} is no unit{hint or f' (known: {_KNOWN})'}")


def _is_unit(unit: str) -> bool:
    """Whether a text is a product of known units, to its last letter."""
    return bool(_UNIT.fullmatch(unit)) and all(found[1] in _known() | {"%"} for found in _FACTOR.finditer(unit))


def _value(unit: str, wanted: str) -> Fraction:
    """Return the value of a unit in another one; raises ValueError if it is none, or of another dimension."""
    from pint import DimensionalityError

    if not _is_unit(unit):
        raise ValueError(unit)

    def power(found: re.Match[str]) -> str:
        name, *powers = found.groups()
        of = "".join(filter(None, powers)).translate(_RAISED)
        return name.replace("%", "percent") + (f"^{of}" if of else "")

    powers = _FACTOR.sub(power, " ".join(re.sub("[⋅∙]", "·", unit).split()))
    if powers.startswith("/"):
        powers = f"1{powers}"
    try:
        return Fraction(_registry().Quantity(Fraction(1), powers).to(wanted).magnitude)
    except DimensionalityError:
        raise ValueError(unit) from None


def _meant(unit: str, wanted: str) -> list[str]:
    """Return the units of the wanted dimension that somebody may have meant."""
    words = re.split(r"([A-Za-zµμε°%\"'″′]+)", re.sub(r"(?<=[A-Za-z\d])[-.](?=[A-Za-z])", " ", unit))
    readings = [_readings(word) if k % 2 else [word] for k, word in enumerate(words)]
    if len(words) > 9:  # of four units
        return []
    found = []
    for parts in product(*readings):
        with suppress(ValueError):
            _value("".join(parts), wanted)
            found.append("".join(parts))
    return found


def _readings(word: str) -> list[str]:
    """Return the units that a word may mean: itself, other cases of its letters, two units in one word."""
    known = _known()
    found = [word] if word in known else []
    found += [_MEANT[word]] if word in _MEANT else []
    if not found:
        found = sorted(name for name in known if name.lower() == word.lower())
        parts = ((word[:k], word[k:]) for k in range(1, len(word)))
        found += [f"{first} {second}" for first, second in parts if first in known and second in known]
    return found or [word]


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
