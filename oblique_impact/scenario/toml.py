"""Data of a TOML file: read with errors in one line, and changed by key."""

from __future__ import annotations

import re
import tomllib
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
    """Return {"section.key": value} of nested sections."""
    flat: dict[str, Any] = {}
    for name, value in sections.items():
        flat |= flat_keys(value, f"{prefix}{name}.") if isinstance(value, dict) else {f"{prefix}{name}": value}
    return flat


def set_key(data: dict[str, Any], keys: list[str], value: Any, what: str) -> None:
    """Set the value at a path of keys; raises InputError that begins with `what` if it leads through a value."""
    target = data
    for key in keys[:-1]:
        target = target.setdefault(key, {})
        if not isinstance(target, dict):
            raise InputError(f"{what}: {key} is not a section")
    target[keys[-1]] = value


def apply_change(data: dict[str, Any], item: str) -> str:
    """Apply "section.key=value", whose value is TOML or a bare word taken as a string; returns the key."""
    path, separator, text = item.partition("=")
    keys = [part.strip() for part in path.split(".")]
    most = 3 if keys[:2] == ["beam", "section"] else 2
    if not separator or not all(keys) or len(keys) > most:
        raise InputError(f"--set {item}: expected section.key=value")
    try:
        value = tomllib.loads(f"value = {text}")["value"]
    except ValueError:
        value = text.strip()
    set_key(data, keys, value, f"--set {item}")
    return ".".join(keys)
