"""Data of a TOML file: read with errors in one line, and changed by key."""

from __future__ import annotations

import re
import tomllib
from itertools import pairwise
from typing import Any

from oblique_impact.errors import InputError

_PLACE = re.compile(r"(.*) \(at line (\d+), column (\d+)\)", re.DOTALL)


def parse_toml(text: str, what: str) -> dict[str, Any]:
    """Parse a file's text; raises InputError, in one line that begins with `what`."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        place = _PLACE.fullmatch(str(error))
        where, message = (f", line {place[2]}", f"{place[1]} (column {place[3]})") if place else ("", error)
        raise InputError(f"{what}{where}: not valid TOML: {message}") from None


def flat_keys(sections: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return {"section.key": value} of nested sections; items of a list of sections count from 1."""
    flat: dict[str, Any] = {}
    for name, value in sections.items():
        if isinstance(value, list | tuple) and value and all(isinstance(item, dict) for item in value):
            value = {str(number): item for number, item in enumerate(value, start=1)}
        flat |= flat_keys(value, f"{prefix}{name}.") if isinstance(value, dict) else {f"{prefix}{name}": value}
    return flat


def set_key(data: dict[str, Any], keys: list[str], value: Any, what: str) -> None:
    """Set the value at a path of keys; raises InputError that begins with `what` if it leads through a value.

    Items of a list of sections count from 1; the one behind the last is a new one.
    """
    target: Any = data
    for key, following in pairwise(keys):
        if isinstance(target, list):
            if not (key.isdecimal() and 1 <= int(key) <= len(target) + 1):
                raise InputError(f"{what}: {key} is none of the {len(target)} items, which count from 1")
            if int(key) > len(target):
                target.append({})
            target = target[int(key) - 1]
        else:
            target = target.setdefault(key, [] if following.isdecimal() else {})
        if not isinstance(target, dict | list):
            raise InputError(f"{what}: {key} is not a section")
    if isinstance(target, list):
        raise InputError(f"{what}: expected a key of an item, as in {keys[0]}.1.key, or the whole list")
    target[keys[-1]] = value


def drop_key(data: dict[str, Any], name: str) -> None:
    """Remove "section.key" from nested sections that hold it; items of a list of sections count from 1."""
    *sections, key = name.split(".")
    inner: Any = data
    for section in sections:
        inner = inner[int(section) - 1] if isinstance(inner, list) else inner[section]
    del inner[key]


def apply_change(data: dict[str, Any], item: str) -> str:
    """Apply "section.key=value", whose value is TOML or a bare word taken as a string; returns the key."""
    path, separator, text = item.partition("=")
    keys = [part.strip() for part in path.split(".")]
    most = 3 if keys[:2] == ["beam", "section"] or "".join(keys[1:2]).isdigit() else 2
    if not separator or not all(keys) or len(keys) > most:
        raise InputError(f"--set {item}: expected section.key=value")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except ValueError:
        value = text.strip()
    set_key(data, keys, value, f"--set {item}")
    return ".".join(keys)
