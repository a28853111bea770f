"""What can be swept: the keys of a scenario, their units, and whether a value suits a key by itself."""

from __future__ import annotations

from functools import cache
from typing import Any

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import did_you_mean, short
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.schema import key_schemas
from oblique_impact.scenario.units import Unit

_KINDS = {"number": float, "integer": int, "boolean": bool, "string": str, "array": tuple}


@cache
def known_keys() -> tuple[str, ...]:
    """Return all keys of a scenario, "section.key" or "key", in the order of the scenario file."""
    return tuple(key_schemas())


def check_key(key: str, where: str) -> None:
    """Raise InputError, in one line that begins with `where`, if a scenario has no such key."""
    if key in known_keys():
        return
    section, dot, _ = key.rpartition(".")
    inside = [k for k in known_keys() if dot and k.startswith(f"{section}.")]
    sections = ", ".join(dict.fromkeys(k.partition(".")[0] for k in known_keys() if "." in k))
    words = ", ".join(inside) or f"{', '.join(k for k in known_keys() if '.' not in k)}, SECTION.KEY of {sections}"
    meant = did_you_mean(key, known_keys())
    raise InputError(f"{where} = {short(key)}: not a key of a scenario; known here: {words}{meant}")


def coerce(key: str, value: Any, where: str) -> Any:
    """Return a value as the scenario takes it (whole numbers become floats where it has floats).

    Raises
    ------
    InputError
        If no scenario could have this value, whatever its other keys are.
    """
    try:
        return Scenario.value_of(key, value)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None


def kind(key: str) -> type:
    """Return the type of a key's values: float, int, bool or str; tuple if it takes nothing but lists."""
    schema = key_schemas()[key]
    return _KINDS[schema.get("anyOf", [schema])[0]["type"]]


def unit(key: str) -> str:
    """Return the SI unit of a key, "1" for numbers without one, "" for words and switches."""
    return Unit(key_schemas()[key].get("unit", "")).shown
