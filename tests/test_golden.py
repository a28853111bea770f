"""The events of every built-in case in every scheme that takes it, held to a table while the house is redrawn.

The table says nothing about what is right: it says what a change of the house must not change.  Each number has the
tolerance that its own growth allows: the change of the number where the initial angle is turned by `TURN`, which is
ten thousand times what rounding does, is a hundred tolerances.  A table ends where that is more than `LARGEST`, or where
the kinds of events change.  ``python -m tests.test_golden`` writes it anew.
"""

from __future__ import annotations

import csv
import warnings
from collections.abc import Iterator
from pathlib import Path

import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.errors import InputError
from oblique_impact.scenario.scenario import builtin_names

TABLE = Path(__file__).with_name("golden.csv")
SCHEMES = ("event", "fixed-step", "generalized-alpha", "time-stepping")
#: rad, and the largest change of a number under it that leaves the number worth keeping (s, N s, J)
TURN, LARGEST = 1e-10, 1e-6
#: relative; below it two programs that do the same in another order differ
ROUNDING = 1e-11
NUMBERS = ("time", "normal_impulse", "tangential_impulse", "energy_loss")
ENERGIES = ("initial", "final", "lost_impact", "lost_friction", "lost_damping", "lost_scheme", "unaccounted")
COLUMNS = ("case", "scheme", "row", "kind", *NUMBERS, *(f"{name} tolerance" for name in NUMBERS))


def scenario_of(case: str, scheme: str) -> Scenario | None:
    """The case by another scheme in its standard steps; None where it is refused."""
    scenario = Scenario.builtin(case)
    if scheme == scenario.solver.scheme:
        return scenario
    data = scenario.model_dump(mode="json", exclude_unset=True)
    try:
        return Scenario.from_dict(data | {"solver": {"scheme": scheme}})
    except InputError:
        return None


def pairs() -> Iterator[tuple[str, str]]:
    """Every built-in case with every scheme that takes it."""
    for case in builtin_names():
        for scheme in SCHEMES:
            if scenario_of(case, scheme) is not None:
                yield case, scheme


def rows_of(scenario: Scenario) -> list[tuple[str, list[float]]]:
    """The kind of each event with its numbers; last the outcome with the end of the run and the sums of its events."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        history = simulate(scenario)
    rows = [
        (f"{event.kind.value} {int(event.obstacle)} {event.state.name.lower()}", [getattr(event, n) for n in NUMBERS])
        for event in history.events
    ]
    energy = history.summary["energy"]
    end = [float(history["time"][-1]), energy["final"], energy["lost_friction"], energy["lost_impact"]]
    return [*rows, (history.outcome.value, end)]


def table_of(case: str, scheme: str) -> Iterator[list[object]]:
    """The rows of one run, each number with its tolerance, as far as the run can be told beforehand."""
    scenario = scenario_of(case, scheme)
    assert scenario is not None
    turned = [scenario.replace(initial__angle=scenario.initial.angle + turn) for turn in (TURN, -TURN)]
    runs = [rows_of(scenario), *map(rows_of, turned)]
    for number, (row, *others) in enumerate(zip(*runs, strict=False)):
        kind, values = row
        changes = [max(abs(v - w) for w in column) for v, *column in zip(values, *(o[1] for o in others), strict=True)]
        if any(other[0] != kind for other in others) or max(changes) > LARGEST:
            return
        tolerances = [f"{ROUNDING * max(1.0, abs(v)) + change / 100.0:.1e}" for v, change in zip(values, changes, strict=True)]
        yield [case, scheme, number, kind, *map(repr, values), *tolerances]


def kept() -> dict[tuple[str, str], list[dict[str, str]]]:
    """The rows of the table by case and scheme."""
    found: dict[tuple[str, str], list[dict[str, str]]] = {}
    with TABLE.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            found.setdefault((row["case"], row["scheme"]), []).append(row)
    return found


def test_every_case_and_scheme_is_in_the_table():
    assert set(kept()) == set(pairs())


@pytest.mark.parametrize(("case", "scheme"), sorted(kept()) if TABLE.exists() else [])
def test_events_are_those_of_the_table(case, scheme):
    scenario = scenario_of(case, scheme)
    assert scenario is not None
    found = rows_of(scenario)
    for row in kept()[case, scheme]:
        number = int(row["row"])
        kind, values = found[number]
        assert kind == row["kind"], (case, scheme, number)
        for name, value in zip(NUMBERS, values, strict=True):
            assert value == pytest.approx(float(row[name]), rel=0, abs=float(row[f"{name} tolerance"])), (number, name)


if __name__ == "__main__":
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for case, scheme in pairs():
            writer.writerows(table_of(case, scheme))
