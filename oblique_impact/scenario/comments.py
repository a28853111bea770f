"""Comments of a scenario file: each key with its meaning, unit and range, from the JSON Schema of the sections."""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Collection, Mapping
from functools import cache
from typing import Any, Literal, get_args, get_origin

import tomlkit
from pydantic import BaseModel
from tomlkit.items import Array, Comment, Item, Trivia

from oblique_impact.scenario.section import InputSection
from oblique_impact.scenario.tables import LARGEST
from oblique_impact.scenario.units import unit_of

_SIGNS = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}
_NUMBERS = {"number": "number", "integer": "whole number"}
#: characters of a line of a file; comments are broken, longer lists have a line for each item
_WIDTH = 108


def schemas_of(model: type[BaseModel], prefix: str = "") -> dict[str, dict[str, Any]]:
    """Return the schema of each key of nested sections by "section.key", in their order.

    Numbers without a dimension have the unit "1", words and switches have none.
    """
    properties = model.model_json_schema()["properties"]
    found: dict[str, dict[str, Any]] = {}
    for name, field in model.model_fields.items():
        inner = field.annotation
        if isinstance(inner, type) and issubclass(inner, InputSection):
            found |= schemas_of(inner, f"{prefix}{name}.")
        else:
            plain = {"unit": "1"} if properties[name].get("type") in _NUMBERS else {}
            found[f"{prefix}{name}"] = {**plain, **properties[name]}
    return found


def item_models(model: type[BaseModel]) -> dict[str, type[InputSection]]:
    """Return the sections of which keys of a model are lists, by the names of these keys."""
    inner = {name: get_args(field.annotation)[:1] for name, field in model.model_fields.items()}
    return {
        name: found[0]
        for name, found in inner.items()
        if found and isinstance(found[0], type) and issubclass(found[0], InputSection)
    }


def range_text(schema: dict[str, Any]) -> str:
    """Return the range of a key as text: "number, > 0", "whole number, >= 0, <= 100", '"rigid", "spring"'."""
    if "enum" in schema:
        return ", ".join(f'"{name}"' for name in schema["enum"])
    if "anyOf" in schema:
        first, *_, last = schema["anyOf"]
        tables = ["or a table of pairs [x, value]"] if last.get("type") == "array" else []
        words = [f"{range_text(last)} or "] if "enum" in last else [""]
        return ", ".join([words[0] + range_text(first), *tables])
    if "$ref" in schema.get("items", {}):
        return "list of tables"
    if schema["type"] == "array":
        items = schema["prefixItems"][0] if "prefixItems" in schema else schema["items"]
        if items.get("type") == "array":
            return "table of pairs of numbers"
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


def first_clause(description: str) -> str:
    """Return the beginning of a meaning, which is the name of a number."""
    return re.split(r"[,:;]| [(\[]", description)[0]


def listing(model: type[BaseModel], name: str = "") -> list[str]:
    """Return a line for each key of a model as in a file: its default, its unit and what it is, or its choices."""
    lines, inner = [f"[{name}]"] if name else [], list[str]()
    for key, field in model.model_fields.items():
        kind, path = field.annotation, f"{name}.{key}".lstrip(".")
        if isinstance(kind, type) and issubclass(kind, InputSection):
            inner += ["", *listing(kind, path)]
            continue
        if get_origin(kind) is Literal:
            about = " | ".join(json.dumps(choice) for choice in get_args(kind))
        else:
            unit = unit_of(field)
            about = (f"{unit.shown}, " if unit else "") + first_clause(field.description or "")
        lines.append(f"{key} = {json.dumps(field.default)}".ljust(33) + f" # {about}")
    for key, item in item_models(model).items():
        inner += ["", *listing(item, f"[{key}]")]
    return [*lines, *inner]


def commented(model: type[BaseModel], data: dict[str, Any], given: Collection[str] | None = None) -> str:
    """Return the text of a file with the keys in `data`, of a model, each below its comment.

    If `given` says which keys ("section.key") a file needs, the others are put behind a "#".
    """
    document = tomlkit.document()
    _fill(document, data, "", given, _comments(model))
    return tomlkit.dumps(document)


@cache
def _comments(model: type[BaseModel]) -> dict[str, str]:
    """Return the comment of each key of a model by "section.key"."""
    found = {path: comment_of(key) for path, key in schemas_of(model).items()}
    for name, item in item_models(model).items():
        found |= {f"{name}.{key}": comment_of(schema) for key, schema in schemas_of(item).items()}
    return found


def _fill(
    table: Any, data: dict[str, Any], prefix: str, given: Collection[str] | None, comments: Mapping[str, str]
) -> None:
    """Add the keys of a section, then the sections in it."""
    for name, value in data.items():
        path = f"{prefix}{name}"
        if isinstance(value, dict) or _is_list_of_sections(value):
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
            _fill(inner, value, f"{prefix}{name}.", given, comments)
            table.add(name, inner)
        elif _is_list_of_sections(value):
            items = tomlkit.aot()
            for number, item in enumerate(value, start=1):
                inner = tomlkit.table()
                path = f"{prefix}{name}.{number}."
                of_item = {f"{path}{key}": comments[f"{prefix}{name}.{key}"] for key in item}
                _fill(inner, item, path, given, of_item)
                if number < len(value):
                    inner.add(tomlkit.nl())
                items.append(inner)
            table.add(tomlkit.nl())
            table.add(name, items)


def _is_list_of_sections(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(item, dict) for item in value)


def _item(value: Any) -> Item:
    item: Item = tomlkit.item(value)
    if isinstance(item, Array):
        item.multiline(len(item.as_string()) > _WIDTH)
    return item
