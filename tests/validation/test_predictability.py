"""Shadow runs: growths, verdicts and the report, on cases whose predictability is known."""

import csv
import json
import math

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from oblique_impact import InputError, Scenario
from oblique_impact.command_line import application as cli
from oblique_impact.renders.style import SERIES
from oblique_impact.validation import predictability
from oblique_impact.validation.measuring import CRASHED, ERROR, INVALID, TIMEOUT, failed
from oblique_impact.validation.quantities import quantity
from oblique_impact.validation.refinement import predictability_report
from oblique_impact.validation.refinement.growth import (
    PREDICTABLE,
    SENSITIVE,
    UNKNOWN,
    UNPREDICTABLE,
    Case,
    Predictability,
    judge,
    verdict_of,
)
from oblique_impact.validation.refinement.predictability import lines
from oblique_impact.validation.refinement.shipped import predictability_cases

# as many modes as forces on the stop take, so that the run warns of nothing
BASE = ("discretization.frame=mean-axis", "discretization.modes=8", "solver.output_interval=1e-2")
SOFT = Scenario.builtin("paper", [*BASE, "contact.normal=spring", "contact.friction=frictionless", "end_time=0.9"])


@pytest.fixture(scope="module")
def soft(tmp_path_factory):
    return predictability(SOFT, shadows=2, workers=1, out=tmp_path_factory.mktemp("soft"))


def row(number, starts, impulses=(), contacts=(), outcome="completed", end=3.0):
    """A run until `end` with macro-collisions and as many events."""
    found = failed(number, outcome, "")
    found["stopped_at"] = end
    for n, start in enumerate(starts, start=1):
        found["values"][f"start:{n}"] = found["values"][f"event:{n}"] = start
        found["values"][f"collision_impulse:{n}"] = impulses[n - 1] if impulses else 1.0
        found["values"][f"collision_contacts:{n}"] = contacts[n - 1] if contacts else 3.0
    return found


def test_an_elastic_stop_is_predictable(soft):
    """A soft stop: what an angle changes is carried along, about 0.8 s/rad at the second collision."""
    (case,) = soft.cases
    first, second = case.collisions
    assert first.verdict == second.verdict == PREDICTABLE
    rate = second.growth * case.unit_time  # s/rad
    assert 0.5 < rate < 1.0
    # a linear change: a hundred times the angle, a hundred times the difference
    assert second.spread[1] == pytest.approx(100.0 * second.spread[0], rel=0.05)
    assert math.isinf(case.horizon)
    assert case.growth.shape == case.events.shape == case.shadows.shape[1:]


def test_growth_and_verdict_of_given_rows():
    """Differences of 2e-8 s by 1e-8 rad after a first touch at 0.5 s: growth 4; of 1e-5 s: 2000."""
    case = Case("given", SOFT)
    offsets, perturbations = np.array([-1e-8, 1e-8, 1e-6]), (1e-8, 1e-6)
    rows = [
        row(0, (0.5, 1.0, 2.0)),
        row(1, (0.5, 1.0 - 2e-8, 2.0)),
        row(2, (0.5, 1.0, 2.0 + 1e-5)),
        row(3, (0.5, 1.0)),
    ]
    found = judge(case, perturbations, offsets, rows)
    first, second, third = found.collisions
    assert first.growth == 0.0
    assert second.growth == pytest.approx(4.0)
    assert second.spread == pytest.approx((2e-8, 0.0), abs=1e-15)
    assert second.verdict == PREDICTABLE
    assert third.growth == pytest.approx(2e6)  # the third shadow lacks it until 3 s: 1 s later or more
    assert third.lower_bound
    assert third.verdict == UNPREDICTABLE
    assert not second.lower_bound
    assert found.horizon == 1.0
    assert found.amplitudes.tolist() == [1e-8, 1e-8, 1e-6]
    assert "growth at least 2e+06: not predictable" in lines(Predictability("given", (found,), 0.0))[3]
    two = judge(case, perturbations[:1], offsets[:2], rows[:3])
    assert two.collisions[2].growth == pytest.approx(2000.0)


def test_shadows_have_the_colour_of_their_perturbation(monkeypatch, tmp_path):
    """The smaller one in the first colour, in both panels; a bound is marked as one."""
    figures = []
    monkeypatch.setattr(predictability_report, "to_svg", lambda figure: figures.append(figure) or "<svg/>")
    rows = [row(0, (0.5, 2.0)), row(1, (0.5, 2.0 - 1e-7)), row(2, (0.5, 2.0 + 1e-5)), row(3, (0.5,))]
    found = judge(Case("given", SOFT), (1e-6, 1e-8), np.array([-1e-8, 1e-6, 5e-7]), rows)
    page = predictability_report.write_predictability(tmp_path, Predictability("given", (found,), 0.0), "")
    left, right, *_ = figures[-1].axes
    assert [line.get_color() for line in left.lines[:3]] == [SERIES[0], SERIES[1], SERIES[1]]
    assert [line.get_label() for line in left.lines[3:]] == [
        f"initial angle ± {d} rad" for d in ("1e-08", "1e-06")
    ]
    shades = [tuple(lines.get_colors()[0]) for lines in right.collections]
    assert shades == [to_rgba(c) for c in ("black", SERIES[0], SERIES[1], SERIES[1])]
    assert "≥ 4 × 10⁶" in page.read_text()


OFFSETS = np.array([-1e-8, 1e-8])


@pytest.mark.parametrize(
    ("outcome", "end", "growth", "verdict"),
    [
        ("completed", 2.0 + 1e-8, 2.0, UNKNOWN),  # at least 2: that says nothing
        ("completed", 2.0 + 1e-6, 200.0, UNKNOWN),
        ("completed", 2.0 + 1e-5, 2000.0, UNPREDICTABLE),
        ("painleve", 2.0 + 1e-8, math.inf, UNPREDICTABLE),
    ],
)
def test_a_shadow_that_ends_before_a_collision_bounds_its_growth(outcome, end, growth, verdict):
    """At end_time nothing went wrong: what is left of the run is the least difference."""
    rows = [row(0, (0.5, 2.0), end=end), row(1, (0.5, 2.0)), row(2, (0.5,), outcome=outcome, end=end)]
    found = judge(Case("given", SOFT), (1e-8,), OFFSETS, rows)
    last = found.collisions[1]
    assert last.growth == pytest.approx(growth, rel=1e-6)
    assert last.verdict == verdict
    assert last.lower_bound == (outcome == "completed")
    assert found.growth[1] == last.growth


@pytest.mark.parametrize("outcome", [INVALID, ERROR, CRASHED, TIMEOUT])
def test_failed_shadows_are_left_out_and_named(tmp_path, outcome):
    """A worker that dies, a timeout: no word about the beam."""
    rows = [row(0, (0.5, 1.0)), row(1, (0.5, 1.0 - 2e-8)), failed(2, outcome, "so it went")]
    found = judge(Case("given", SOFT), (1e-8,), OFFSETS, rows)
    assert [c.verdict for c in found.collisions] == [PREDICTABLE, PREDICTABLE]
    assert found.offsets.tolist() == [-1e-8]
    result = Predictability("given", (found,), 0.0)
    said = f"shadow at 1e-08 rad left out: {outcome}: so it went"
    assert f"  {said}" in lines(result)
    assert f"S{said[1:]}." in predictability_report.write_predictability(tmp_path, result, "").read_text()
    (case,) = json.loads((tmp_path / "results.json").read_text())["cases"]
    assert case["failed"] == [{"offset": 1e-8, "outcome": outcome, "message": "so it went"}]


def test_what_the_run_warns_of_is_said(tmp_path):
    rows = [row(0, (0.5, 1.0)) | {"warnings": ["so it is"]}, row(1, (0.5, 1.0)), row(2, (0.5, 1.0))]
    result = Predictability("given", (judge(Case("given", SOFT), (1e-8,), OFFSETS, rows),), 0.0)
    assert any("so it is" in line for line in lines(result))
    assert "so it is" in predictability_report.write_predictability(tmp_path, result, "").read_text()


def test_without_shadows_there_is_no_verdict(tmp_path):
    rows = [row(0, (0.5, 1.0)), failed(1, TIMEOUT, "too long"), failed(2, CRASHED, "gone")]
    found = judge(Case("given", SOFT), (1e-8,), OFFSETS, rows)
    assert [c.verdict for c in found.collisions] == [UNKNOWN, UNKNOWN]
    assert math.isnan(found.horizon)
    result = Predictability("given", (found,), 0.0)
    assert "  collision 1: starts at 0.5 s: no verdict" in lines(result)
    assert "no verdict" in predictability_report.write_predictability(tmp_path, result, "").read_text()


def test_an_unperturbed_run_that_failed_is_called_so():
    found = judge(Case("given", SOFT), (1e-8,), OFFSETS, [failed(0, TIMEOUT, "too long"), row(1, ()), row(2, ())])
    assert lines(Predictability("given", (found,), 0.0))[1:] == ["  the unperturbed run failed: timeout: too long"]


def test_a_run_without_a_contact_says_how_far_it_came():
    found = judge(Case("given", SOFT), (1e-8,), OFFSETS, [row(0, (), end=0.25), row(1, ()), row(2, ())])
    assert lines(Predictability("given", (found,), 0.0))[1:] == ["  no contact until 0.25 s: completed"]


@pytest.mark.parametrize(
    ("growth", "verdict"), [(10.0, PREDICTABLE), (10.1, SENSITIVE), (999.0, SENSITIVE), (1e3, UNPREDICTABLE)]
)
def test_verdicts(growth, verdict):
    assert verdict_of(growth) == verdict


def test_report_and_numbers(soft):
    folder = soft.report.parent
    data = json.loads((folder / "results.json").read_text())
    assert (
        data["command"]
        == f"oblique_impact.validation.predictability(scenario, shadows=2, out={str(folder)!r}, workers=1)"
    )
    (case,) = data["cases"]
    assert case["collisions"][1]["growth"] == soft.cases[0].collisions[1].growth
    assert case["offsets"] == [-1e-8, 1e-8, -1e-6, 1e-6]
    with (folder / "results.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [entry["verdict"] for entry in table] == ["predictable", "predictable"]
    assert float(table[1]["start"]) == soft.cases[0].collisions[1].start
    page = soft.report.read_text()
    assert page.count("<svg") == 2
    assert "not predictable above" in page
    assert "rounding, a tolerance or another compiler" in page
    assert lines(soft)[1].startswith("  collision 1: starts at 0.31714")
    assert not list(folder.glob("*.jsonl"))


def test_an_interrupted_study_goes_on(tmp_path, soft):
    told = []

    def stop_after_two(progress):
        told.append(progress.done)
        if progress.done == 2 and told[0] == 0 and len(told) < 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        predictability(SOFT, shadows=2, workers=1, out=tmp_path, on_progress=stop_after_two)
    again = []
    found = predictability(SOFT, shadows=2, workers=1, out=tmp_path, on_progress=lambda p: again.append(p.done))
    assert again[0] == 2
    assert [c.start for c in found.cases[0].collisions] == [c.start for c in soft.cases[0].collisions]


def test_a_start_on_the_slope_is_perturbed_upwards_only():
    """Evenly from 0 to d, no angle twice; a difference that fits on both sides is tried on both."""
    on_slope = float(np.arcsin(-0.3 * np.sin(np.pi / 10)) + np.pi / 10)
    touching = SOFT.replace(initial__angle=on_slope, end_time=0.01)
    (case,) = predictability(touching, shadows=2, workers=1).cases
    np.testing.assert_allclose(case.offsets, [0.5e-8, 1e-8, 0.5e-6, 1e-6])
    (case,) = predictability(touching.replace(initial__angle=on_slope + 1e-7), shadows=2, workers=1).cases
    np.testing.assert_allclose(case.offsets, [-1e-8, 1e-8, 0.5e-6, 1e-6])


def test_odd_numbers_of_shadows_are_different_angles():
    (case,) = predictability(SOFT.replace(end_time=0.01), shadows=5, perturbations=(1e-6,), workers=1).cases
    np.testing.assert_allclose(case.offsets, np.array([-1, -1 / 2, 1 / 3, 2 / 3, 1]) * 1e-6)


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


def test_without_contact_there_is_nothing_to_predict():
    with pytest.raises(InputError, match=r"contact\.enabled"):
        predictability(SOFT.replace(contact__enabled=False))


def test_the_shipped_cases_go_from_soft_to_rigid():
    cases = predictability_cases()
    assert [case.scenario.contact.normal for case in cases] == ["spring"] * 4 + ["rigid"] * 2
    assert [case.scenario.beam.kelvin_voigt for case in cases] == [0.0] * 5 + [1e-5]


def test_the_command_line(tmp_path, capsys):
    changes = (*BASE, "contact.normal=spring", "contact.friction=frictionless", "end_time=0.35")
    words = [word for change in changes for word in ("--set", change)]
    with pytest.raises(SystemExit) as end:
        cli.main(["refine", "paper", "--predictability", *words, "--out", str(tmp_path), "--workers", "1"])
    assert end.value.code in (None, 0)
    shown = capsys.readouterr().out
    assert "collision 1: starts at 0.31714" in shown
    assert "predictable" in shown
    assert "--predictability" in json.loads((tmp_path / "results.json").read_text())["command"]
    with pytest.raises(SystemExit) as end:
        cli.main(["refine", "paper", "--predictability", "--elements", "4,8,16", "--out", str(tmp_path)])
    assert end.value.code == 2
    assert "--elements together with --predictability" in capsys.readouterr().err
    with pytest.raises(SystemExit) as end:
        cli.main(["refine", "--study", "elements", "--predictability", "--out", str(tmp_path)])
    assert end.value.code == 2
    assert "--study elements together with --predictability" in capsys.readouterr().err


def test_quantities_of_any_collision_and_event():
    assert quantity("start:2").unit == "s"
    assert quantity("collision_impulse:3").meaning == "normal impulse of macro-collision 3"
    for name in ("start:0", "start:", "event:x", "event:-1"):
        with pytest.raises(InputError):
            quantity(name)
