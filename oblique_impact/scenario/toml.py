"""TOML text from any source: read in bounded time, errors in one line with its number, changed keys."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection
from functools import lru_cache
from typing import Any

import tomli_w

from oblique_impact.errors import InputError

_MOST_PARTS = 20
_PART = r"""(?:"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+'|[\w-]++)"""
#: tomllib takes time with the square of the parts of a key
_LONG_KEY = re.compile(rf"(?:^|[{{,\[])[ \t]*+{_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{_MOST_PARTS}}}", re.MULTILINE)
_LINE = re.compile(r"(.*) \(at line (\d+), column (\d+)\)", re.DOTALL)
_KEY = rf"{_PART}(?:[ \t]*+\.[ \t]*+{_PART})*+"
_HEADER = re.compile(rf"[ \t]*+(\[\[?)[ \t]*+({_KEY})[ \t]*+\]\]?[ \t]*+(?:#.*)?")
_ERROR_KEY = re.compile(r"([\w-]+(?:\.[\w-]+)*)(?: =|:)")
_WIDTH = 100
_ENTRY = re.compile(rf"[ \t]*+({_KEY})[ \t]*+=")


def parse_toml(text: str, what: str) -> dict[str, Any]:
    """Parse a file's text; `what` it is begins the one line of an InputError."""
    if _LONG_KEY.search(text):
        raise InputError(f"{what}: a key of more than {_MOST_PARTS} parts; keys have two")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        line = _LINE.fullmatch(str(error))
        where, message = (f", line {line[2]}", f"{line[1]} (column {line[3]})") if line else ("", error)
        raise InputError(f"{what}{where}: not valid TOML: {message}") from None
    except RecursionError:
        raise InputError(f"{what}: nested too deeply; sections have one level") from None
    except ValueError as error:  # integers of thousands of digits
        raise InputError(f"{what}: {error}") from None


def toml_entry(key: str, value: Any) -> str:
    """Return "key = value" in TOML; lists and tables stand in one line, long lists in a line for each item."""
    text = f"{key} = {_inline(value)}"
    if len(text) <= _WIDTH or not isinstance(value, list | tuple):
        return text
    return "\n".join([f"{key} = [", *(f"    {_inline(item)}," for item in value), "]"])


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{name} = {_inline(item)}" for name, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_inline, value)) + "]"
    if type(value) in (int, float):  # what follows writes them alike, and takes a while
        return repr(value)
    return _written(value)


@lru_cache(maxsize=256, typed=True)
def _written(value: Any) -> str:
    return tomli_w.dumps({"x": value}).partition(" = ")[2].rstrip()


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
    """Apply "section.key=value" or "parameters.part.name=value"; it is TOML, or a bare word taken as a string.

    Returns the key.
    """
    path, separator, text = item.partition("=")
    keys = [part.strip() for part in path.split(".")]
    most = 3 if keys[0] == "parameters" or keys[:2] == ["beam", "section"] else 2
    if not separator or not all(keys) or len(keys) > most:
        raise InputError(f"--set {item}: expected section.key=value")
    try:
        parsed = parse_toml(f"value = {text}", "--set")
    except InputError:
        parsed = {}
    value = parsed["value"] if parsed.keys() == {"value"} else text.strip()
    set_key(data, keys, value, f"--set {item}")
    return ".".join(keys)


def with_line(error: InputError, text: str, name: str, changed: Collection[str] = ()) -> InputError:
    """Return an error with the file's name and the line of its key; `changed` keys are not those of the file."""
    key = _ERROR_KEY.match(str(error))
    line = line_of(key[1], text) if name and key and key[1] not in changed else None
    return error if line is None else InputError(f"{name}, line {line}: {error}")


def line_of(key: str, text: str) -> int | None:
    """Return the number of the line of a valid file that gives `key`, or the table or list it stands in.

    Keys are as errors name them, "section.key"; entries of lists have their number, "axes.0.key".
    """
    wanted = key.split(".")
    table: list[str] = []
    lists: dict[tuple[str, ...], int] = {}
    best, found = 0, None
    for number, line in enumerate(text.split("\n"), start=1):
        if header := _HEADER.fullmatch(line.rstrip("\r")):
            path = table = _parts(header[2])
            if header[1] == "[[":
                lists[tuple(path)] = lists.get(tuple(path), -1) + 1
                path = table = [*path, str(lists[tuple(path)])]
        elif entry := _ENTRY.match(line):
            path = [*table, *_parts(entry[1])]
        else:
            continue
        same = min(len(path), len(wanted))
        if same > best and path[:same] == wanted[:same]:
            best, found = same, number
    return found


def _parts(key: str) -> list[str]:
    return [part.strip("\"'") for part in re.findall(_PART, key)]
