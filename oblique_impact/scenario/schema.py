"""The JSON Schema of scenario files, by pydantic: meaning, unit and range of each key."""

from __future__ import annotations

import json
import os
from functools import cache
from pathlib import Path
from typing import Any

from oblique_impact.files import save_text
from oblique_impact.scenario.comments import first_clause, item_models, schemas_of
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.units import Unit

#: what an item of a list of sections is called
_ITEMS = {"obstacles": "obstacle", "masses": "mass", "forces": "force"}


def scenario_schema(out: str | os.PathLike[str] | None = None) -> dict[str, Any]:
    """Return the JSON Schema of scenario files, for editors that complete and check them.

    Each key has its meaning, its range or its choices, its default, and its SI unit (`unit`).  The schema does not
    say which keys exclude each other: that is checked when a scenario is read.

    Parameters
    ----------
    out : str or path, optional
        A file to write it to.

    Returns
    -------
    dict
        The schema, of plain values.

    Raises
    ------
    InputError
        If the file cannot be written.

    Examples
    --------
    >>> scenario_schema()["$defs"]["BeamSection"]["properties"]["density"]["unit"]
    'kg/m^3'
    """
    found = {"$schema": "https://json-schema.org/draft/2020-12/schema", **Scenario.model_json_schema()}
    for model in (found, *found["$defs"].values()):
        for schema in model["properties"].values():
            if "unit" in schema:
                schema["description"] += f" ({schema['unit']})"  # what editors show at a key
    if out is not None:
        save_text(Path(out), f"{json.dumps(found, indent=2, ensure_ascii=False)}\n")
    return found


@cache
def key_schemas() -> dict[str, dict[str, Any]]:
    """Return the schema of each key by "section.key", in the order of a scenario file.

    Numbers without a dimension have the unit "1", words and switches have none.
    """
    return schemas_of(Scenario)


def schema_of(name: str) -> dict[str, Any] | None:
    """Return the schema of a key, of an item ("obstacles.1.radius") too; None if there is no such key."""
    section, number, key = [*name.split("."), "", ""][:3]
    if section in item_models(Scenario) and number.isdecimal() and int(number) > 0:
        return schemas_of(item_models(Scenario)[section]).get(key)
    return key_schemas().get(name)


def unit_of_key(name: str) -> str:
    """Return the SI unit of a key: "1" of numbers without one, "" of words and switches."""
    return Unit((schema_of(name) or {}).get("unit", "")).shown


def label_of(name: str) -> str:
    """Return the name of a key on axes and in tables: the first clause of what a number means, else the key.

    >>> label_of("contact.mu_static"), label_of("contact.friction"), label_of("obstacles.1.radius")
    ('static coefficient of friction', 'contact friction', 'radius of the peg, obstacle 1')
    """
    schema, parts = schema_of(name) or {}, name.split(".")
    of = f", {_ITEMS[parts[0]]} {parts[1]}" if parts[0] in _ITEMS and len(parts) > 1 else ""
    if "unit" in schema:
        return first_clause(schema["description"]) + of
    return " ".join(parts[2:] if of else parts).replace("_", " ") + of
