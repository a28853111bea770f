"""Keys of a scenario that follow others as long as they are not given."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from oblique_impact.errors import InputError
from oblique_impact.scenario.materials import GIVEN, MATERIALS
from oblique_impact.scenario.messages import short
from oblique_impact.scenario.sections import ScenarioKeys
from oblique_impact.scenario.shapes import FOLLOWING, following


def _of_section(key: str, s: ScenarioKeys) -> Any:
    return following(s.beam.section, key)


def _of_material(key: str, s: ScenarioKeys) -> Any:
    return getattr(MATERIALS[s.beam.material], key) if s.beam.material else None


#: keys that follow others as long as they are not given; a resolved file lists their values in this table too
TABLE = "derived"
DERIVED: dict[str, Callable[[ScenarioKeys], Any]] = {
    "contact.point": lambda s: s.beam.length,
    "discretization.frame": lambda s: "mean-axis" if s.is_nodal else "tangent",
    "solver.scheme": lambda s: _own_scheme(s),
    **{f"beam.{key}": partial(_of_section, key) for key in FOLLOWING},
    **{f"beam.{key}": partial(_of_material, key) for key in GIVEN},
}


def _own_scheme(s: ScenarioKeys) -> str:
    """Return the scheme of a discretization that does not name one."""
    if s.is_absolute:
        return "energy-consistent"
    return "generalized-alpha" if s.is_nodal else "event"


def derived_values(scenario: ScenarioKeys) -> dict[str, Any]:
    """Return the values, by "section.key", that were not given and follow other keys."""
    found = {}
    for name, follow in DERIVED.items():
        section, key = name.split(".")
        if key not in getattr(scenario, section).model_fields_set:
            found[name] = follow(scenario)
    return {name: value for name, value in found.items() if value is not None}


def derive(scenario: ScenarioKeys) -> None:
    """Fill in the keys that were not given and follow others; they go on counting as not given."""
    for name, value in derived_values(scenario).items():
        section, key = name.split(".")
        old = getattr(scenario, section)
        new = old.model_construct(old.model_fields_set, **{**old.__dict__, key: value})
        object.__setattr__(scenario, section, new)


def drop_derived_values(data: dict[str, Any]) -> None:
    """Take out of a file's data what its table of derived values lists: it follows other keys again.

    A value that is not the listed one was changed by hand since, and stays.  Raises InputError.
    """
    listed = data.pop(TABLE, {})
    if not isinstance(listed, dict) or not listed.keys() <= DERIVED.keys():
        raise InputError(f"{TABLE} = {short(listed)}: should be a table of {', '.join(DERIVED)}")
    for name, value in listed.items():
        section, key = name.split(".")
        inner = data.get(section)
        if isinstance(inner, dict) and key in inner and inner[key] == value:
            del inner[key]
