"""Runs with perturbed initial angles: growths, verdicts, report, on cases whose predictability is known."""

import csv
import json
import math

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

from oblique_impact import Scenario
from oblique_impact.validation import predictability
from oblique_impact.validation.studies.design import load_plan
from oblique_impact.validation.studies.predictability import (
    PREDICTABLE,
    SENSITIVE,
    UNKNOWN,
    UNPREDICTABLE,
    judge,
    perturbed_runs,
    remarks_of,
    verdict_of,
)
from oblique_impact.validation.studies.study import failed
from tests import STUDIES
from tests.refusals import refused_in_one_line

# as many modes as forces on the stop take, so that the run warns of nothing
BASE = ("discretization.frame=mean-axis", "discretization.modes=8", "solver.output_interval=1e-2")
SOFT = Scenario.builtin("paper", [*BASE, "contact.normal=spring", "contact.friction=frictionless", "end_time=0.9"])
ANGLE = SOFT.initial.angle
#: what a sweep may be asked for
SOME = ("start:1", "start:2", "collision_impulse:1", "collision_contacts:1", "warnings")


def row(offset, starts, outcome="completed", end=3.0, message=""):
    """A run until `end` with macro-collisions and as many events."""
    found = failed(outcome, message) | {"initial.angle": ANGLE + offset, "stopped_at": end}
    for n, start in enumerate(starts, start=1):
        found |= {f"start:{n}": start, f"event:{n}": start, f"collision_impulse:{n}": 1.0}
        found[f"collision_contacts:{n}"] = 3.0
    return found


def judged(*rows):
    return judge(SOFT, pd.DataFrame(rows))


def test_an_elastic_stop_is_predictable_and_its_report_says_so(tmp_path):
    """A soft stop: what an angle changes is carried along, about 0.8 s/rad at the second collision."""
    case = predictability(SOFT, workers=1, out=tmp_path)
    assert case.frame["verdict"].tolist() == [PREDICTABLE, PREDICTABLE]
    second = case[2]
    assert 0.5 < second.growth * case.about["unit_time"] < 1.0  # s/rad
    # a linear change: the smallest perturbations show the same growth
    assert second.start_spread == pytest.approx(1e-8 * second.growth * case.about["unit_time"], rel=0.05)
    assert (case.tables["events"]["growth"] < 10.0).all()
    data = json.loads((tmp_path / "results.json").read_text())
    assert data["collisions"][1]["growth"] == second.growth
    parts = np.array([0.0, *1e-8 * np.array([-1.0, -0.5, 0.5, 1.0]), *1e-6 * np.array([-1.0, -0.5, 0.5, 1.0])])
    assert [run["initial.angle"] for run in data["runs"]] == (ANGLE + parts).tolist()
    with (tmp_path / "results.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [entry["verdict"] for entry in table] == ["predictable", "predictable"]
    assert float(table[1]["start"]) == second.start
    assert (tmp_path / "report.html").read_text().count("<svg") == 1
    assert repr(case).splitlines()[0].startswith("collisions: 2 predictable (")


def test_growth_and_verdict_of_given_rows():
    """Differences of 2e-8 s by 1e-8 rad after a first touch at 0.5 s: growth 4; of 1e-5 s: 2000."""
    rows = [
        row(0.0, (0.5, 1.0, 2.0)),
        row(-1e-8, (0.5, 1.0 - 2e-8, 2.0)),
        row(1e-8, (0.5, 1.0, 2.0 + 1e-5)),
        row(1e-6, (0.5, 1.0)),
    ]
    found = judged(*rows)
    first, second, third = found.collisions.itertuples()
    assert first.growth == 0.0
    assert second.growth == pytest.approx(4.0)
    assert second.start_spread == pytest.approx(2e-8, abs=1e-15)
    assert third.growth == pytest.approx(2e6)  # the last run lacks it until 3 s: 1 s later or more
    assert (second.lower_bound, third.lower_bound) == (False, True)
    assert (second.verdict, third.verdict) == (PREDICTABLE, UNPREDICTABLE)
    assert judged(*rows[:3]).collisions["growth"][3] == pytest.approx(2000.0)
    bounds = [PREDICTABLE, SENSITIVE, SENSITIVE, UNPREDICTABLE]
    assert [verdict_of(growth) for growth in (10.0, 10.1, 999.0, 1e3)] == bounds


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


def test_failed_runs_are_left_out_and_named():
    """A worker that dies, a timeout: no word about the beam; without perturbed runs there is no verdict."""
    first = row(0.0, (0.5, 1.0)) | {"warnings": "so it is"}
    lost = [row(offset, (), outcome="timeout", message="so it went") for offset in (1e-8, -1e-8)]
    found = judged(first, row(-1e-8, (0.5, 1.0 - 2e-8)), lost[0])
    assert found.collisions["verdict"].tolist() == [PREDICTABLE, PREDICTABLE]
    told = "perturbed run at 1e-08 rad left out: timeout: so it went"
    assert remarks_of(SOFT, pd.DataFrame([first, lost[0]])) == [told, "warning: so it is"]
    assert judged(first, *lost).collisions["verdict"].tolist() == [UNKNOWN, UNKNOWN]


@pytest.mark.parametrize("perturbations", [(), (0.0,)])
def test_bad_input_is_one_line(perturbations):
    with refused_in_one_line("should be"):
        predictability(SOFT, perturbations=perturbations)


def test_the_command_line(tmp_path, cli):
    changes = (*BASE, "contact.normal=spring", "contact.friction=frictionless", "end_time=0.35")
    words = [word for change in changes for word in ("--set", change)]
    code, out, _ = cli("refine", "paper", "--predictability", *words, "--out", tmp_path, "--workers", "1")
    assert code == 0
    assert "0.31714" in out
    assert "--predictability" in json.loads((tmp_path / "results.json").read_text())["command"]


def test_a_start_on_the_slope_is_perturbed_upwards_only():
    """Above it by less than a perturbation, by less than half of that, to both sides."""
    on_slope = float(np.arcsin(-0.3 * np.sin(np.pi / 10)) + np.pi / 10)
    touching = SOFT.replace(initial__angle=on_slope, end_time=0.01)
    case = predictability(touching, workers=1)
    moved = case.tables["runs"]["initial.angle"][1:] - on_slope
    np.testing.assert_allclose(moved, [0.5e-8, 1e-8, 0.5e-6, 1e-6], rtol=1e-7)
    near = touching.replace(initial__angle=on_slope + 1e-7)
    turned = np.array([run.labels["initial.angle"] for run in perturbed_runs(near, count=2)]) - near.initial.angle
    assert 0.4e-7 < turned.max() < 0.5e-7
    np.testing.assert_allclose(turned[1:] / turned.max(), [-0.01, 0.01, -1.0, 1.0], rtol=1e-6)


def test_a_peg_next_to_the_start_stays_on_its_side():
    """A stiff beam is thrown up from a peg 1 nm below it and falls back on it, as a rigid pendulum does."""
    angle, speed, at, gap = np.pi / 4, 2.0, 0.5, 1e-9
    centre = complex(at, -gap) * np.exp(1j * angle)
    peg = f"obstacles=[{{kind='point', origin=[{centre.real:.17g}, {centre.imag:.17g}], stiffness=1e4}}]"
    thrown = ("beam.youngs_modulus=1e13", "discretization.modes=1", "initial.angular_velocity=2", "end_time=0.8")
    where = ("slope.enabled=false", "contact.where=anywhere", "contact.friction=frictionless", peg)
    keys = ("contact.normal=spring", "discretization.frame=mean-axis", *thrown, *where)
    first = predictability(Scenario.builtin("paper", keys), workers=1)[1]

    def fall(turn):
        """Time (s) until a pendulum that starts from so much more (rad) is back."""
        back = lambda t, y: y[0] - angle + gap / at  # noqa: E731
        back.direction, back.terminal = -1.0, True
        rate = lambda t, y: (y[1], -14.7 * math.cos(y[0]))  # noqa: E731
        found = solve_ivp(rate, (0.0, 2.0), (angle + turn, speed), events=back, rtol=1e-12, atol=1e-14)
        return found.t_events[0][0]

    assert first.start == pytest.approx(fall(0.0), rel=1e-3)
    assert first.growth == pytest.approx((fall(1e-4) - fall(-1e-9)) / 1.00001e-4 / fall(0.0), rel=2e-2)
    assert first.verdict == PREDICTABLE


def test_the_sweep_of_the_documentation_has_the_same_runs():
    """Six stops from nine angles each, those of `refine --predictability`; a stop of its table can be judged."""
    plan = load_plan(STUDIES / "predictability.toml")
    assert plan.impossible == []
    of_stop = [run.scenario for run in plan.runs if run.labels["beam.kelvin_voigt"] == 1e-5]
    assert len(plan.runs) == 6 * len(of_stop) == 54
    assert of_stop == [run.scenario for run in perturbed_runs(of_stop[0])]
    rows = [row(angle - ANGLE, (0.5, 1.0 + 3.0 * (angle - ANGLE))) for angle in (s.initial.angle for s in of_stop)]
    frame = pd.DataFrame(rows)[["initial.angle", "outcome", "message", "stopped_at", "event:1", *SOME]]
    assert judge(of_stop[0], frame).collisions["growth"].tolist() == pytest.approx([0.0, 6.0], rel=1e-6)
