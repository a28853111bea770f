"""What can be swept: the keys of a scenario, their units, and whether a value suits a key by itself."""

from __future__ import annotations

import math
from functools import cache
from typing import Annotated, Any

from pydantic import BaseModel, ValidationError, create_model

from oblique_impact.errors import InputError
from oblique_impact.faults import one_line, short
from oblique_impact.scenario import ParametersSection, Scenario, Section

#: SI units of the scenario's keys that have one; the others are numbers without a unit, words or switches
UNITS = {
    "end_time": "s",
    "gravity": "m/s²",
    "beam.length": "m",
    "beam.area": "m²",
    "beam.second_moment": "m⁴",
    "beam.density": "kg/m³",
    "beam.youngs_modulus": "Pa",
    "beam.kelvin_voigt": "s",
    "beam.mass_proportional": "1/s",
    "beam.tip_mass": "kg",
    "beam.outer_fibre": "m",
    "root.hub_radius": "m",
    "root.inertia": "kg m²",
    "root.torque": "N m",
    "root.spin_rate": "rad/s",
    "root.spin_up_time": "s",
    "initial.angle": "rad",
    "initial.angular_velocity": "rad/s",
    "slope.origin": "m",
    "slope.angle": "rad",
    "slope.extent": "m",
    "contact.point": "m",
    "contact.stiffness": "N/m",
    "contact.damping": "s/m",
    "contact.regularization": "m/s",
    "solver.free_step": "s",
    "solver.contact_step": "s",
    "solver.baumgarte": "1/s",
    "solver.output_interval": "s",
}
_WITHOUT_SECTION = ""


@cache
def _sections() -> dict[str, type[BaseModel]]:
    """Models of the sections by name; the keys that belong to none are a section without a name."""
    sections: dict[str, type[BaseModel]] = {}
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
    """Whether this is a number of a part of one's own, parameters.PART.NAME."""
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
    raise InputError(f"{where} = {short(key)}: not a key of a scenario; known here: {words}")


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
    except ValidationError as error:
        line = one_line(error, model)
        raise InputError(f"{where}: {f'{section}.{line}' if section else line}") from None
    return found


def kind(key: str) -> type:
    """Return the type of a key's values: float, int, bool or str; tuple if it takes nothing but lists."""
    if _of_own_part(key):
        return float
    section, _, name = key.rpartition(".")
    annotation = _sections()[section].model_fields[name].annotation
    if annotation in (int, bool, float):
        return annotation  # type: ignore[return-value]
    if annotation is None or str(annotation).startswith("tuple"):
        return tuple
    return float if "float" in str(annotation) else str


def unit(key: str) -> str:
    """Return the SI unit of a key, "1" for numbers without one, "" for words and switches."""
    if _of_own_part(key):
        return ""  # the part knows
    return UNITS.get(key, "1" if kind(key) in (int, float) else "")
