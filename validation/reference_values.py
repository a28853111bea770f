"""Reference values of closed forms, published benchmarks and other programs, with their sources.

The table is `reference_values.toml`; all is in SI units but the frequencies of its items 1 and 2.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from importlib.resources import files
from typing import Any, NamedTuple


class ReferenceValue(NamedTuple):
    """One reference: its value(s) and where they come from."""

    value: Any
    source: str


def _read() -> Iterator[tuple[str, ReferenceValue]]:
    """Yield the references by their ids; `entries` have a source in common, and their own keys behind its id."""
    text = files("oblique_impact.validation").joinpath("reference_values.toml").read_text("utf-8")
    for id, entry in tomllib.loads(text).items():
        where = entry.pop("source")
        for key, value in entry.get("entries", {}).items():
            yield f"{id}-{key}", ReferenceValue(value, where.format(key=key))
        if "pairs" in entry:
            yield id, ReferenceValue(dict(entry["pairs"]), where)
        elif "entries" not in entry:
            yield id, ReferenceValue(entry.get("value", entry), where)


REFERENCES = dict(_read())
VALUES: dict[str, Any] = {id: reference.value for id, reference in REFERENCES.items()}


def source(item: str) -> str:
    """Return where a reference comes from."""
    return REFERENCES[item].source
