"""Events of every built-in case in every scheme, and the numbers of `validate`, while the house is redrawn.

The table says nothing about what is right.  Each number of a run has the tolerance that its own growth allows: a
hundredth of its change where the initial angle is turned by `TURN`, far more than rounding does.  The rows
of a run end where that change is more than `LARGEST`, or where the kinds of events change.  A number of `validate`
has a hundredth of the tolerance of its check.  ``python -m tests.test_golden`` writes the table anew.
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
from oblique_impact.validation import validate

TABLE = Path(__file__).with_name("golden.csv")
COLUMNS = ("run", "row", "what", "value", "tolerance")
SCHEMES = ("event", "fixed-step", "generalized-alpha", "time-stepping")
VALIDATE = "validate"
#: rad, and the largest change under it of a number that is worth keeping (s, N s, J)
TURN, LARGEST = 1e-10, 1e-6
ROUNDING = 1e-11  # relative; another order of sums does less

Rows = list[tuple[str, float]]


def scenarios() -> Iterator[tuple[str, Scenario]]:
    """Yield every built-in case by every scheme that takes it; by others than its own in their standard steps."""
    for case in builtin_names():
        scenario = Scenario.builtin(case)
        for scheme in SCHEMES:
            if scheme == scenario.solver.scheme:
                yield f"{case} {scheme}", scenario
                continue
            data = scenario.model_dump(mode="json", exclude_unset=True) | {"solver": {"scheme": scheme}}
            try:
                yield f"{case} {scheme}", Scenario.from_dict(data)
            except InputError:  # this scheme does not take it
                continue


def rows_of(scenario: Scenario) -> Rows:
    """The numbers of all events in turn, each with what it is; last the energies at the end."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        history = simulate(scenario)
    rows = []
    for event in history.events:
        name = f"{event.kind.value} {int(event.obstacle)} {event.state.name.lower()}"
        for number in ("time", "normal_impulse", "tangential_impulse", "energy_loss"):
            rows.append((f"{name} {number}", float(getattr(event, number))))
    rows.append((f"{history.outcome.value} time", float(history["time"][-1])))
    for number in ("final", "lost_impact", "lost_friction", "lost_damping"):
        rows.append((f"{history.outcome.value} {number}", history.summary["energy"][number]))
    return rows


def with_tolerances(scenario: Scenario) -> Iterator[tuple[str, float, float]]:
    """Yield the rows of a run with their tolerances, as far as the run can be told beforehand."""
    turned = [scenario.replace(initial__angle=scenario.initial.angle + turn) for turn in (TURN, -TURN)]
    for (what, value), *others in zip(rows_of(scenario), *map(rows_of, turned), strict=False):
        change = max(abs(other - value) for _, other in others)
        if change > LARGEST or any(name != what for name, _ in others):
            return
        yield what, value, ROUNDING * max(1.0, abs(value)) + change / 100.0


def rows_of_checks(folder: Path) -> Iterator[tuple[str, float, float]]:
    """Yield the numbers of `validate`, each with a hundredth of the tolerance of its check."""
    for result in validate(folder):
        yield f"{result.Index}: {result.quantity}", float(result.computed), float(result.tolerance) / 100.0


def kept() -> dict[str, list[tuple[str, float, float]]]:
    """The rows of the table by their runs."""
    found: dict[str, list[tuple[str, float, float]]] = {}
    with TABLE.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            found.setdefault(row["run"], []).append((row["what"], float(row["value"]), float(row["tolerance"])))
    return found


def write(folder: Path) -> None:
    """Write the table anew."""
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        groups = {run: with_tolerances(scenario) for run, scenario in scenarios()}
        for run, rows in (groups | {VALIDATE: rows_of_checks(folder)}).items():
            for number, (what, value, tolerance) in enumerate(rows):
                writer.writerow([run, number, what, repr(value), f"{tolerance:.1e}"])


@pytest.mark.parametrize("run", [pytest.param(VALIDATE, marks=pytest.mark.slow), *dict(scenarios())])
def test_the_house_gives_the_numbers_of_the_table(run, tmp_path):
    expected = kept().get(run, [])
    found = [row[:2] for row in rows_of_checks(tmp_path)] if run == VALIDATE else rows_of(dict(scenarios())[run])
    for (what, value, tolerance), (name, number) in zip(expected, found, strict=False):
        assert (name, number) == (what, pytest.approx(value, rel=0.0, abs=tolerance))
    assert len(found) >= len(expected)


if __name__ == "__main__":
    from tempfile import TemporaryDirectory

    with TemporaryDirectory() as name:
        write(Path(name))
