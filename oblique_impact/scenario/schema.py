"""The JSON Schema of a scenario file, made from the models: each key with unit, range, default and meaning."""

from __future__ import annotations

import json
import math
import os
import re
from collections.abc import Collection
from functools import cache, reduce
from pathlib import Path
from typing import Any

from pydantic.fields import FieldInfo

from oblique_impact import installed
from oblique_impact.files import cannot_write, prepare_folder, write_text
from oblique_impact.scenario.derived import DERIVED, TABLE
from oblique_impact.scenario.section import Section
from oblique_impact.scenario.sections import ScenarioKeys
from oblique_impact.scenario.tables import LARGEST
from oblique_impact.scenario.toml import toml_entry
from oblique_impact.scenario.units import unit_of
from oblique_impact.scenario.user_defined import Choice

#: a number and its unit, as far as a pattern tells: "12 mm", "1e3 kg/m^3", "2 1/s"
_TEXT = {"type": "string", "pattern": r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?\s*(1\s*/\s*)?[A-Za-zµμ°]"}
_SIGNS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}
_NUMBERS = {"number": "number", "integer": "whole number"}


def scenario_schema(out: str | os.PathLike[str] | None = None) -> dict[str, Any]:
    """Return the JSON Schema (draft 7) of scenario files, for editors that complete and check them.

    Each key has its meaning, the range or the words that it takes, its default, and its SI unit (`unit`, "1" for
    numbers without one); user-defined parts are those that are installed.  The rules between keys are not in it:
    they are checked when a scenario is read.

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
    >>> scenario_schema()["properties"]["beam"]["properties"]["density"]["unit"]
    'kg/m^3'
    """
    found = _section_schema(ScenarioKeys)
    for schema in _keys_of(found).values():
        schema["description"] = comment_of(schema)  # what editors show at a key
    derived = {name: {"description": "of a resolved file: follows other keys"} for name in DERIVED}
    found["properties"][TABLE] = {"type": "object", "properties": derived, "additionalProperties": False}
    found |= {"title": "oblique-impact", "description": "A scenario: what to simulate, in SI units."}
    found = {"$schema": "http://json-schema.org/draft-07/schema#", **found}
    if out is not None:
        path = Path(out)
        prepare_folder(path.parent)
        try:
            write_text(path, f"{json.dumps(found, indent=2, ensure_ascii=False)}\n")
        except OSError as error:
            raise cannot_write(path, error) from None
    return found


@cache
def key_schemas() -> dict[str, dict[str, Any]]:
    """Return the schema of each key by "section.key", in the order of a scenario file."""
    return _keys_of(_section_schema(ScenarioKeys))


def _keys_of(scenario: dict[str, Any]) -> dict[str, dict[str, Any]]:
    found: dict[str, dict[str, Any]] = {}
    for name, schema in scenario["properties"].items():
        found |= (
            {f"{name}.{key}": s for key, s in _keys_of(schema).items()}
            if "properties" in schema
            else {name: schema}
        )
    return found


def words_of(schema: dict[str, Any]) -> str:
    """Return what a key takes in words: "number, > 0", "whole number, >= 0, <= 100", '"rigid", "spring"'."""
    if "enum" in schema:
        return ", ".join(f'"{name}"' for name in schema["enum"])
    if "anyOf" in schema:
        tables = ["or a table of pairs [x, value]"] if schema["anyOf"][-1]["type"] == "array" else []
        return ", ".join([words_of(schema["anyOf"][0]), *tables])
    if schema["type"] == "array":
        count = "two" if schema.get("maxItems") == 2 else "list of"
        return f"{count} {words_of(schema['items']).replace('number', 'numbers', 1)}"
    plain = {"boolean": "true, false", "string": "text", "object": "table of numbers by name"}
    if schema["type"] in plain:
        return plain[schema["type"]]
    limits = {sign: schema[key] for key, sign in _SIGNS.items() if key in schema}
    bounds = [f"{sign} {limit:.10g}" for sign, limit in limits.items() if abs(limit) < LARGEST]
    return ", ".join([_NUMBERS[schema["type"]], *bounds])


def comment_of(schema: dict[str, Any]) -> str:
    """Return the meaning of a key with its unit and what it takes, for a comment in a file."""
    words, unit = words_of(schema), schema.get("unit", "1")
    if unit != "1":
        words = re.sub("numbers?", rf"\g<0> in {unit}", words, count=1)
    return f"{schema['description']} ({words})"


def commented(data: dict[str, Any], given: Collection[str] | None = None) -> str:
    """Return the text of a file with the keys in `data`, each below its comment.

    If `given` says which keys ("section.key") a file needs, the others are put behind a "#".
    """
    lines, present = [], ""
    for path in key_schemas():
        section, _, key = path.rpartition(".")
        home = reduce(lambda inside, part: inside.get(part, {}), section.split("."), data) if section else data
        if key not in home:
            continue
        if section != present:
            lines.append(f"\n[{section}]")
            present = section
        text = toml_entry(key, home[key])
        if given is not None and path not in given:
            text = re.sub("^", "#", text, flags=re.MULTILINE)
        lines += [_comments()[path], text]
    return "\n".join([*lines, ""])


@cache
def _comments() -> dict[str, str]:
    return {path: f"# {comment_of(schema)}" for path, schema in key_schemas().items()}


def _section_schema(model: type[Section]) -> dict[str, Any]:
    keys = model.model_json_schema()["properties"]
    properties = {}
    for name, field in model.model_fields.items():
        inner = field.annotation
        if isinstance(inner, type) and issubclass(inner, Section):
            properties[name] = _section_schema(inner)
        else:
            properties[name] = _key_schema(keys[name], field)
    words = " ".join((model.__doc__ or "").split())
    return {"type": "object", "description": words, "properties": properties, "additionalProperties": False}


def _key_schema(plain: dict[str, Any], field: FieldInfo) -> dict[str, Any]:
    """Return pydantic's schema of a key with its unit, the names of user-defined parts, and texts with a unit."""
    found = {name: plain.pop(name) for name in ("title", "description", "default")}
    if isinstance(field.default, float) and math.isnan(field.default):
        del found["default"]  # it follows other keys
    elif plain.get("type") == "object":
        found["default"] = {}
    for entry in field.metadata:
        if isinstance(entry, Choice):
            plain["enum"] = list(dict.fromkeys([*entry.built_in, *sorted(installed.installed(entry.kind))]))
    unit = unit_of(field)
    if unit is not None:
        return {**found, "unit": unit.symbol, **_with_texts(plain)}
    return {**found, **({"unit": "1"} if plain["type"] in _NUMBERS else {}), **plain}


def _with_texts(schema: dict[str, Any]) -> dict[str, Any]:
    """Let numbers in a schema be texts with a unit as well."""
    if "anyOf" in schema:
        number, table = schema["anyOf"]
        return {"anyOf": [number, _TEXT, _with_texts(table)]}
    if schema["type"] == "number":
        return {"anyOf": [schema, _TEXT]}
    items = schema.pop("prefixItems", [schema.get("items")])[0]  # those of a pair are alike
    return {**schema, "items": _with_texts(items)}
