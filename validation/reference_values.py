"""ReferenceValue values of closed forms, published benchmarks and other programs, with their sources.

The table is `reference_values.toml`; all is in SI units but the frequencies of its items 1 and 2.
"""

from __future__ import annotations

import tomllib
from importlib.resources import files
from typing import Any, NamedTuple


class ReferenceValue(NamedTuple):
    """One reference: its value(s) and where they come from."""

    value: Any
    source: str


def _reference(source: str, **values: Any) -> ReferenceValue:
    if "pairs" in values:
        return ReferenceValue(dict(values["pairs"]), source)
    return ReferenceValue(values.get("value", values), source)


_TABLE = tomllib.loads(files("oblique_impact.validation").joinpath("reference_values.toml").read_text("utf-8"))
REFERENCES = {id: _reference(**entry) for id, entry in _TABLE.items()}
VALUES: dict[str, Any] = {id: reference.value for id, reference in REFERENCES.items()}


def source(item: str) -> str:
    """Return where a reference comes from."""
    return REFERENCES[item].source
