"""Runs with perturbed initial angles: growths, verdicts, report, on cases whose predictability is known."""

import csv
import json
import math

import numpy as np
import pandas as pd
import pytest

from oblique_impact import InputError, Scenario
from oblique_impact.validation import predictability
from oblique_impact.validation.studies.measure import failed
from oblique_impact.validation.studies.predictability import (
    PREDICTABLE,
    SENSITIVE,
    UNKNOWN,
    UNPREDICTABLE,
    Case,
    Predictability,
    judge,
    lines,
    report,
    verdict_of,
)

# as many modes as forces on the stop take, so that the run warns of nothing
BASE = ("discretization.frame=mean-axis", "discretization.modes=8", "solver.output_interval=1e-2")
SOFT = Scenario.builtin("paper", [*BASE, "contact.normal=spring", "contact.friction=frictionless", "end_time=0.9"])


@pytest.fixture(scope="module")
def soft(tmp_path_factory):
    return predictability(SOFT, shadows=2, workers=1, out=tmp_path_factory.mktemp("soft"))


def row(offset, starts, outcome="completed", end=3.0, message=""):
    """A run until `end` with macro-collisions and as many events."""
    found = failed(outcome, message) | {"offset": offset, "stopped_at": end}
    for n, start in enumerate(starts, start=1):
        found |= {f"start:{n}": start, f"event:{n}": start, f"collision_impulse:{n}": 1.0}
        found[f"collision_contacts:{n}"] = 3.0
    return found


def judged(*rows, perturbations=(1e-8,)):
    return judge(Case("given", SOFT), perturbations, pd.DataFrame(rows))


def verdicts(found):
    return found.collisions["verdict"].tolist()


def test_an_elastic_stop_is_predictable(soft):
    """A soft stop: what an angle changes is carried along, about 0.8 s/rad at the second collision."""
    (case,) = soft.cases
    assert verdicts(case) == [PREDICTABLE, PREDICTABLE]
    second = case.collisions.iloc[1]
    rate = second.growth * case.unit_time  # s/rad
    assert 0.5 < rate < 1.0
    # a linear change: a hundred times the angle, a hundred times the difference
    assert second["start_by_1e-06"] == pytest.approx(100.0 * second["start_by_1e-08"], rel=0.05)
    assert (case.events["growth"] < 10.0).all()


def test_growth_and_verdict_of_given_rows():
    """Differences of 2e-8 s by 1e-8 rad after a first touch at 0.5 s: growth 4; of 1e-5 s: 2000."""
    rows = [
        row(0.0, (0.5, 1.0, 2.0)),
        row(-1e-8, (0.5, 1.0 - 2e-8, 2.0)),
        row(1e-8, (0.5, 1.0, 2.0 + 1e-5)),
        row(1e-6, (0.5, 1.0)),
    ]
    found = judged(*rows, perturbations=(1e-8, 1e-6))
    first, second, third = found.collisions.itertuples()
    assert first.growth == 0.0
    assert second.growth == pytest.approx(4.0)
    assert found.collisions["start_by_1e-08"][1] == pytest.approx(2e-8, abs=1e-15)
    assert found.collisions["start_by_1e-06"][1] == 0.0
    assert second.verdict == PREDICTABLE
    assert third.growth == pytest.approx(2e6)  # the third lacks it until 3 s: 1 s later or more
    assert (second.lower_bound, third.lower_bound) == (False, True)
    assert third.verdict == UNPREDICTABLE
    assert "growth at least 2e+06: not predictable" in lines(Predictability("given", (found,), 0.0))[3]
    assert judged(*rows[:3]).collisions["growth"][2] == pytest.approx(2000.0)


@pytest.mark.parametrize(
    ("outcome", "end", "growth", "verdict"),
    [
        ("completed", 2.0 + 1e-8, 2.0, UNKNOWN),  # at least 2: that says nothing
        ("completed", 2.0 + 1e-5, 2000.0, UNPREDICTABLE),
        ("painleve", 2.0 + 1e-8, math.inf, UNPREDICTABLE),
    ],
)
def test_a_run_that_ends_before_a_collision_bounds_its_growth(outcome, end, growth, verdict):
    """At end_time nothing went wrong: what is left of the run is the least difference."""
    last = row(1e-8, (0.5,), outcome=outcome, end=end)
    found = judged(row(0.0, (0.5, 2.0), end=end), row(-1e-8, (0.5, 2.0)), last)
    collision = found.collisions.iloc[1]
    assert collision.growth == pytest.approx(growth, rel=1e-6)
    assert collision.verdict == verdict
    assert collision.lower_bound == (outcome == "completed")
    assert found.events["growth"][1] == collision.growth


@pytest.mark.parametrize("outcome", ["invalid", "error", "crashed", "timeout"])
def test_failed_runs_are_left_out_and_named(outcome):
    """A worker that dies, a timeout: no word about the beam."""
    lost = row(1e-8, (), outcome=outcome, message="so it went")
    found = judged(row(0.0, (0.5, 1.0)) | {"warnings": "so it is"}, row(-1e-8, (0.5, 1.0 - 2e-8)), lost)
    assert verdicts(found) == [PREDICTABLE, PREDICTABLE]
    assert found.frame["offset"].tolist() == [0.0, -1e-8]
    told = f"perturbed run at 1e-08 rad left out: {outcome}: so it went"
    assert found.remarks == [told, "warning: so it is"]
    page = report(Predictability("given", (found,), 0.0), "").html()
    assert f"P{told[1:]}." in page
    assert "so it is" in page


def test_without_perturbed_runs_there_is_no_verdict():
    found = judged(row(0.0, (0.5, 1.0)), row(-1e-8, (), "timeout"), row(1e-8, (), "crashed"))
    assert verdicts(found) == [UNKNOWN, UNKNOWN]
    result = Predictability("given", (found,), 0.0)
    assert "  collision 1: starts at 0.5 s: no verdict" in lines(result)
    assert "no verdict" in report(result, "").html()


@pytest.mark.parametrize(
    ("growth", "verdict"), [(10.0, PREDICTABLE), (10.1, SENSITIVE), (999.0, SENSITIVE), (1e3, UNPREDICTABLE)]
)
def test_verdicts(growth, verdict):
    assert verdict_of(growth) == verdict


def test_report_and_numbers(soft):
    folder = soft.report.parent
    (case,) = json.loads((folder / "results.json").read_text())["cases"]
    assert case["collisions"][1]["growth"] == soft.cases[0].collisions["growth"][1]
    assert [run["offset"] for run in case["runs"]] == [0.0, -1e-8, 1e-8, -1e-6, 1e-6]
    with (folder / "results.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [entry["verdict"] for entry in table] == ["predictable", "predictable"]
    assert float(table[1]["start"]) == soft.cases[0].collisions["start"][1]
    page = soft.report.read_text()
    assert page.count("<svg") == 1
    assert "not predictable above" in page
    assert lines(soft)[1].startswith("  collision 1: starts at 0.31714")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"perturbations": ()}, "^perturbations: should be"),
        ({"perturbations": (0.0,)}, "^perturbations 0: should be"),
        ({"shadows": 1}, "^shadows 1: should be from 2"),
    ],
)
def test_bad_input_is_one_line(options, words):
    with pytest.raises(InputError, match=words) as error:
        predictability(SOFT, **options)
    assert len(str(error.value).splitlines()) == 1


def test_the_command_line(tmp_path, cli):
    changes = (*BASE, "contact.normal=spring", "contact.friction=frictionless", "end_time=0.35")
    words = [word for change in changes for word in ("--set", change)]
    code, out, _ = cli("refine", "paper", "--predictability", *words, "--out", tmp_path, "--workers", "1")
    assert code == 0
    assert "collision 1: starts at 0.31714" in out
    assert "--predictability" in json.loads((tmp_path / "results.json").read_text())["command"]


def test_a_start_on_the_slope_is_perturbed_upwards_only():
    """Evenly from 0 to d, no angle twice; a difference that fits on both sides is tried on both."""
    on_slope = float(np.arcsin(-0.3 * np.sin(np.pi / 10)) + np.pi / 10)
    touching = SOFT.replace(initial__angle=on_slope, end_time=0.01)
    (case,) = predictability(touching, shadows=2, workers=1).cases
    np.testing.assert_allclose(case.frame["offset"][1:], [0.5e-8, 1e-8, 0.5e-6, 1e-6])
    (case,) = predictability(touching.replace(initial__angle=on_slope + 1e-7), shadows=2, workers=1).cases
    np.testing.assert_allclose(case.frame["offset"][1:], [-1e-8, 1e-8, 0.5e-6, 1e-6])
