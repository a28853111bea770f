"""Scenario files: values that follow other keys, changes by "section.key=value", the line of a fault."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from typing import TYPE_CHECKING, Any

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import short
from oblique_impact.scenario.toml import line_of, parse_toml

if TYPE_CHECKING:
    from oblique_impact.scenario.scenario import Scenario

#: keys that follow others as long as they are not given; a resolved file lists their values in this table too
TABLE = "derived"
DERIVED: dict[str, Callable[[Scenario], Any]] = {
    "contact.point": lambda s: s.beam.length,
    "discretization.frame": lambda s: "mean-axis" if s.is_nodal else "tangent",
    "solver.scheme": lambda s: "generalized-alpha" if s.is_nodal else "event",
}
_BEGINNING = re.compile(r"([\w-]+(?:\.[\w-]+)*)(?: =|:)")


def derive(scenario: Scenario) -> None:
    """Fill in the keys that were not given and follow others; they go on counting as not given."""
    for name, value in DERIVED.items():
        section, _, key = name.partition(".")
        old = getattr(scenario, section)
        if key not in old.model_fields_set:
            new = old.model_construct(old.model_fields_set, **{**old.__dict__, key: value(scenario)})
            object.__setattr__(scenario, section, new)


def derived(scenario: Scenario) -> dict[str, Any]:
    """Return the values, by "section.key", that were not given and follow other keys."""
    found = {}
    for name in DERIVED:
        section, _, key = name.partition(".")
        part = getattr(scenario, section)
        if key not in part.model_fields_set:
            found[name] = getattr(part, key)
    return found


def release(data: dict[str, Any]) -> None:
    """Take out of a file's data what its table of derived values lists: it follows other keys again.

    A value that is not the listed one was changed by hand since, and stays.  Raises InputError.
    """
    listed = data.pop(TABLE, {})
    if not isinstance(listed, dict) or not listed.keys() <= DERIVED.keys():
        raise InputError(f"{TABLE} = {short(listed)}: should be a table of {', '.join(DERIVED)}")
    for name, value in listed.items():
        section, _, key = name.partition(".")
        inner = data.get(section)
        if isinstance(inner, dict) and key in inner and inner[key] == value:
            del inner[key]


def apply_change(data: dict[str, Any], item: str) -> str:
    """Apply "section.key=value" or "parameters.part.name=value"; it is TOML, or a bare word taken as a string.

    Returns the key.
    """
    path, separator, text = item.partition("=")
    keys = [part.strip() for part in path.split(".")]
    if not separator or not all(keys) or len(keys) > (3 if keys[0] == "parameters" else 2):
        raise InputError(f"--set {item}: expected section.key=value")
    try:
        parsed = parse_toml(f"value = {text}", "--set")
    except InputError:
        parsed = {}
    value = parsed["value"] if parsed.keys() == {"value"} else text.strip()
    put(data, keys, value, f"--set {item}")
    return ".".join(keys)


def put(data: dict[str, Any], keys: list[str], value: Any, what: str) -> None:
    """Set the value at a path of keys; raises InputError that begins with `what` if it leads through a value."""
    target = data
    for key in keys[:-1]:
        target = target.setdefault(key, {})
        if not isinstance(target, dict):
            raise InputError(f"{what}: {key} is not a section")
    target[keys[-1]] = value


def at_line(error: InputError, text: str, name: str, changed: Collection[str] = ()) -> InputError:
    """Return a fault with the file's name and the line of its key; `changed` keys are not those of the file."""
    key = _BEGINNING.match(str(error))
    if not name or key is None or key[1] in changed:
        return error
    line = line_of(key[1], text)
    return error if line is None else InputError(f"{name}, line {line}: {error}")
