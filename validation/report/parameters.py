"""The parameters of scenarios in a report: what differs between them, and what they have in common."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.schema import label_of, unit_of_key
from oblique_impact.scenario.toml import flat_keys
from oblique_impact.validation.report import Block, Cell, Section, Table, Text, number, shown_unit

#: value of a key that a scenario does not have, as of an obstacle
NOT_GIVEN = "not given"


def changed_keys(scenarios: Mapping[str, Scenario | None]) -> dict[str, tuple[Any, ...]]:
    """Return the keys that differ between scenarios, each with all values; a user-defined system has none."""
    return {key: values for key, values in _values(scenarios).items() if any(v != values[0] for v in values)}


def differing(scenarios: Mapping[str, Scenario | None]) -> Block:
    """Return the table of the keys that differ, a column for each scenario, or the sentence that none does."""
    rows = [_row(key, values) for key, values in changed_keys(scenarios).items()]
    if not rows:
        return Text("All parameters are the same.")
    return Table(["parameter", "key", "unit", *scenarios], rows, "Parameters that differ.", wide=(0,))


def parameters(scenarios: Mapping[str, Scenario | None]) -> list[Section]:
    """Return the section with the parameters that scenarios have in common; none of user-defined systems."""
    same = {key: values for key, values in _values(scenarios).items() if all(v == values[0] for v in values)}
    rows = [_row(key, values[:1]) for key, values in same.items() if values[0] not in ("", [])]
    shared = "Parameters that all have in common." if len(scenarios) > 1 else "Parameters of the scenario."
    table = Table(["parameter", "key", "unit", "value"], rows, shared, wide=(0,))
    return [Section("Parameters", [table], opened=False)] if rows else []


def _values(scenarios: Mapping[str, Scenario | None]) -> dict[str, tuple[Any, ...]]:
    """Return the values of each key in all scenarios."""
    flat = [flat_keys(one.model_dump(mode="json")) if one else {} for one in scenarios.values()]
    keys = dict.fromkeys(key for one in flat for key in one if key != "obstacles")
    return {key: tuple(one.get(key, NOT_GIVEN) for one in flat) for key in keys}


def _row(key: str, values: tuple[Any, ...]) -> list[Any]:
    return [label_of(key), Cell(key, "code"), shown_unit(unit_of_key(key)), *map(_cell, values)]


def _cell(value: Any) -> Cell:
    if isinstance(value, bool):
        text = "yes" if value else "no"
    elif isinstance(value, list):
        text = ", ".join(_cell(item).text for item in value)
    else:
        text = value if isinstance(value, str) else number(value, 10)
    return Cell(text or "–", "number")
