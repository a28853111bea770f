"""Meaning, unit and range of the keys of a scenario, by pydantic's JSON Schema: for editors and for comments."""

from __future__ import annotations

import json
import os
import re
import textwrap
from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import Any

import tomlkit
from pydantic import BaseModel
from tomlkit.items import Array, Comment, Item, Trivia

from oblique_impact.files import cannot_write, prepare_folder, write_text
from oblique_impact.scenario.section import Section
from oblique_impact.scenario.tables import LARGEST

_SIGNS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}
_NUMBERS = {"number": "number", "integer": "whole number"}
#: characters of a line of a file; comments are broken, longer lists have a line for each item
_WIDTH = 108


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
    from oblique_impact.scenario.scenario import Scenario

    found = {"$schema": "https://json-schema.org/draft/2020-12/schema", **Scenario.model_json_schema()}
    for model in (found, *found["$defs"].values()):
        for schema in model["properties"].values():
            if "unit" in schema:
                schema["description"] += f" ({schema['unit']})"  # what editors show at a key
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
    """Return the schema of each key by "section.key", in the order of a scenario file.

    Numbers without a dimension have the unit "1", words and switches have none.
    """
    from oblique_impact.scenario.scenario import Scenario

    return _of_keys(Scenario, "")


def _of_keys(model: type[BaseModel], prefix: str) -> dict[str, dict[str, Any]]:
    properties = model.model_json_schema()["properties"]
    found: dict[str, dict[str, Any]] = {}
    for name, field in model.model_fields.items():
        inner = field.annotation
        if isinstance(inner, type) and issubclass(inner, Section):
            found |= _of_keys(inner, f"{prefix}{name}.")
        else:
            plain = {"unit": "1"} if properties[name].get("type") in _NUMBERS else {}
            found[f"{prefix}{name}"] = {**plain, **properties[name]}
    return found


def range_text(schema: dict[str, Any]) -> str:
    """Return the range of a key as text: "number, > 0", "whole number, >= 0, <= 100", '"rigid", "spring"'."""
    if "enum" in schema:
        return ", ".join(f'"{name}"' for name in schema["enum"])
    if "anyOf" in schema:
        tables = ["or a table of pairs [x, value]"] if schema["anyOf"][-1]["type"] == "array" else []
        return ", ".join([range_text(schema["anyOf"][0]), *tables])
    if schema["type"] == "array":
        items = schema["prefixItems"][0] if "prefixItems" in schema else schema["items"]
        count = "two" if schema.get("maxItems") == 2 else "list of"
        return f"{count} {range_text(items).replace('number', 'numbers', 1)}"
    plain = {"boolean": "true, false", "string": "text"}
    if schema["type"] in plain:
        return plain[schema["type"]]
    limits = {sign: schema[key] for key, sign in _SIGNS.items() if key in schema}
    bounds = [f"{sign} {limit:.10g}" for sign, limit in limits.items() if abs(limit) < LARGEST]
    return ", ".join([_NUMBERS[schema["type"]], *bounds])


def comment_of(schema: dict[str, Any]) -> str:
    """Return the meaning of a key with its unit and range, for a comment in a file."""
    words = range_text(schema)
    if schema.get("unit", "1") != "1":
        words = re.sub("numbers?", rf"\g<0> in {schema['unit']}", words, count=1)
    return f"{schema['description']} ({words})"


def commented(data: dict[str, Any], given: Collection[str] | None = None) -> str:
    """Return the text of a scenario file with the keys in `data`, each below its comment.

    If `given` says which keys ("section.key") a file needs, the others are put behind a "#".
    """
    document = tomlkit.document()
    _fill(document, data, "", given)
    return tomlkit.dumps(document)


def _fill(table: Any, data: dict[str, Any], prefix: str, given: Collection[str] | None) -> None:
    """Add the keys of a section, then the sections in it."""
    comments = _comments()
    for name, value in data.items():
        path = f"{prefix}{name}"
        if isinstance(value, dict):
            continue
        for line in textwrap.wrap(comments[path], _WIDTH, subsequent_indent="  "):
            table.add(tomlkit.comment(line))
        if given is None or path in given:
            table.add(name, _item(value))
        else:
            table.add(Comment(Trivia(comment=f"#{name} = {tomlkit.item(value).as_string()}")))
    for name, value in data.items():
        if isinstance(value, dict) and value:
            table.add(tomlkit.nl())
            inner = tomlkit.table()
            _fill(inner, value, f"{prefix}{name}.", given)
            table.add(name, inner)


@cache
def _comments() -> dict[str, str]:
    return {path: comment_of(schema) for path, schema in key_schemas().items()}


def _item(value: Any) -> Item:
    item: Item = tomlkit.item(value)
    if isinstance(item, Array):
        item.multiline(len(item.as_string()) > _WIDTH)
    return item
