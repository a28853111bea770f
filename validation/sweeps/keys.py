"""What can be swept: the keys of a scenario, their units, and whether a value suits a key by itself."""

from __future__ import annotations

import math
from functools import cache
from typing import Annotated, Any

from pydantic import create_model
from pydantic.fields import FieldInfo

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import did_you_mean, short
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.section import Section
from oblique_impact.scenario.sections import ParametersSection
from oblique_impact.scenario.units import unit_of

_WITHOUT_SECTION = ""


@cache
def _sections() -> dict[str, type[Section]]:
    """Models of the sections by name; the keys that belong to none are a section without a name."""
    sections: dict[str, type[Section]] = {}
    single: dict[str, Any] = {}
    for name, field in Scenario.model_fields.items():
        annotation = field.annotation
        if annotation is ParametersSection:
            continue  # its keys are those of the parts
        if isinstance(annotation, type) and issubclass(annotation, Section):
            sections[name] = annotation
        else:
            single[name] = (Annotated[annotation, *field.metadata], field.default)
    sections[_WITHOUT_SECTION] = create_model("Single", __base__=Section, **single)
    return sections


@cache
def known_keys() -> tuple[str, ...]:
    """Return all keys of a scenario, "section.key" or "key", in the order of the scenario file."""
    return tuple(
        f"{section}.{key}" if section else key
        for section, model in sorted(_sections().items(), key=lambda item: item[0] != _WITHOUT_SECTION)
        for key in model.model_fields
    )


def _of_own_part(key: str) -> bool:
    """Whether this is a number of a user-defined part, parameters.PART.NAME."""
    home, *rest = key.split(".")
    return (
        home == "parameters"
        and len(rest) == 2
        and rest[0] in ParametersSection.model_fields
        and rest[1].isidentifier()
    )


def check_key(key: str, where: str) -> None:
    """Raise InputError, in one line that begins with `where`, if a scenario has no such key."""
    if key in known_keys() or _of_own_part(key):
        return
    section, dot, _ = key.rpartition(".")
    inside = [k for k in known_keys() if dot and k.startswith(f"{section}.")]
    sections = ", ".join(name for name in _sections() if name)
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
    if _of_own_part(key):
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise InputError(f"{where}: {key} = {short(value)}: should be a finite number")
        return float(value)
    section, _, name = key.rpartition(".")
    model = _sections()[section]
    try:
        found = getattr(model.model_validate({name: value}), name)
    except InputError as error:
        raise InputError(f"{where}: {f'{section}.{error}' if section else error}") from None
    return found


def kind(key: str) -> type:
    """Return the type of a key's values: float, int, bool or str; tuple if it takes nothing but lists."""
    if _of_own_part(key):
        return float
    annotation = _field(key).annotation
    if annotation in (int, bool, float):
        return annotation  # type: ignore[return-value]
    if annotation is None or str(annotation).startswith("tuple"):
        return tuple
    return float if "float" in str(annotation) else str


def unit(key: str) -> str:
    """Return the SI unit of a key, "1" for numbers without one, "" for words and switches."""
    if _of_own_part(key):
        return ""  # the part knows
    declared = unit_of(_field(key))
    if declared is not None:
        return declared.shown
    return "1" if kind(key) in (int, float) else ""


def _field(key: str) -> FieldInfo:
    section, _, name = key.rpartition(".")
    return _sections()[section].model_fields[name]
