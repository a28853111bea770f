"""Refinement: levels, declared orders, verdicts of real runs, report and command."""

from __future__ import annotations

import csv
import html
import json
import math
import re

import pytest

from oblique_impact import InputError, Scenario
from oblique_impact.validation import refine
from oblique_impact.validation.report import readable
from oblique_impact.validation.studies.convergence import CONVERGED, NO_VERDICT, NOT_DETERMINED
from oblique_impact.validation.studies.ladders import AXES, Ladder, Study, sizes_of
from oblique_impact.validation.studies.refinement import declared_orders, lines, report
from oblique_impact.validation.studies.shipped import STUDIES, predictability_cases, shipped_study

PAPER = Scenario.builtin("paper")
RIGID = PAPER.replace(end_time=0.335, discretization__frame="mean-axis")


def test_levels_change_what_they_are_about():
    finer = AXES["elements"].change(PAPER, 8.0).discretization
    assert (finer.method, finer.elements, finer.modes) == ("fem", 8, 2)
    assert AXES["modes"].change(PAPER, 3.0).discretization.modes == 3
    stepped = AXES["steps"].change(PAPER.replace(solver__scheme="fixed-step"), 2e-5).solver
    assert (stepped.free_step, stepped.contact_step) == (2e-5, pytest.approx(2e-7))
    assert AXES["stiffness"].change(PAPER.replace(contact__normal="spring"), 1e7).contact.stiffness == 1e7
    for axis, words in (("steps", "--tolerances"), ("stiffness", r"contact\.normal")):
        with pytest.raises(InputError, match=words):
            AXES[axis].change(PAPER, 1e-5)


def test_places_of_contact_stay_on_the_nodes():
    edge = Scenario.builtin("edge")
    finer = AXES["elements"].change(edge, 16.0)
    assert (finer.discretization.elements, finer.contact.grid) == (16, 16)
    assert AXES["elements"].change(edge.replace(contact__grid=16), 32.0).contact.grid == 16
    assert AXES["nodes alone"].change(edge, 16.0).obstacles[0].extent == (0.0, 9 / 16)


def test_a_size_is_a_step_or_one_over_a_level():
    assert sizes_of("elements", (4.0, 8.0), (0.0, 0.0))[0] == [0.25, 0.125]
    assert sizes_of("tolerances", (1e-4, 1e-6, 1e-8), (0.3, 0.2, 0.1)) == ([0.3, 0.2, 0.1], "")
    replaced, remark = sizes_of("tolerances", (1e-4, 1e-6, 1e-8), (0.2, 0.2, 0.1))
    assert replaced == pytest.approx([1e-4**0.125, 1e-6**0.125, 0.1])
    assert "mean steps" in remark


@pytest.mark.parametrize(("tolerance", "tighter"), [(1e-8, 1e-9), (5e-13, 1e-13)])
def test_noise_is_measured_at_a_tenth_of_the_tolerance(tolerance, tighter):
    """... of the finest level, and no lower than a scenario allows."""
    base = PAPER.replace(solver__tolerance=tolerance)
    runs = Ladder("a", base, "modes", (1.0, 2.0, 3.0), ("impulse",)).runs()
    assert [run.labels["axis"] for run in runs] == ["modes"] * 3 + ["noise"]
    assert runs[-1].scenario.solver.tolerance == pytest.approx(tighter, rel=1e-12)
    assert runs[-1].scenario.discretization.modes == 3


def test_orders_are_declared_only_where_they_hold():
    names = ("impulse", "peak_force", "max:moment", "contacts")
    assert declared_orders("elements", PAPER, names) == {"impulse": 4.0}
    assert declared_orders("modes", PAPER, names) == {}
    implicit = PAPER.replace(solver__scheme="generalized-alpha")
    assert declared_orders("steps", implicit, names) == {}
    assert declared_orders("steps", implicit.replace(contact__normal="spring"), names) == {"impulse": 2.0}


def test_every_shipped_study_can_be_planned():
    for name in STUDIES:
        for ladder in shipped_study(name).ladders:
            assert len(ladder.runs()) >= 3
            assert set(ladder.declared) <= set(ladder.quantities)
    assert len(predictability_cases()) == 6


def test_a_run_the_physics_stops_is_a_row_and_not_the_end():
    rough = PAPER.replace(end_time=0.4, discretization__frame="mean-axis")
    rough = rough.replace(contact__mu_static=20.0, contact__mu_kinetic=20.0)
    result = refine(rough, modes=[1, 2, 3], quantities=["first_impact", "theta@0.35"], workers=1)
    found = result.ladders[0]
    assert found.runs["outcome"].tolist() == ["completed", "completed", "painleve"]
    first, later = found.results
    assert first.analysis.verdict == CONVERGED
    assert later.analysis.verdict == NO_VERDICT
    assert any(line.startswith("  modes 3: painleve at t = 0.3237") for line in lines(result))
    table = result.to_dataframe()
    assert len(table) == 2 * 3
    assert table["gap"].iloc[-1] == later.gaps[-1]
    assert "painleve" in later.gaps[-1]


@pytest.mark.parametrize(
    ("scenario", "lost"),
    [
        (RIGID, {"impulse", "collision_end", "tip_y@end", "peak_force"}),
        (RIGID.replace(beam__kelvin_voigt=1e-3), {"peak_force"}),
    ],
    ids=["undamped", "damped"],
)
def test_what_a_run_calls_not_determined_is_not_called_converged(scenario, lost):
    names = ["first_impact", "tip_y@0.3", "max:gap", "impulse", "collision_end", "tip_y@end", "peak_force"]
    result = refine(scenario, modes=[2, 3, 4], quantities=names, within=0.5, workers=1)
    found = {item.quantity.name: item.analysis for item in result.ladders[0].results}
    assert {name for name in names if found[name].verdict == NOT_DETERMINED} == lost
    assert all(math.isnan(found[name].limit) for name in lost)
    # the tip falls: its largest gap is that of the start
    assert found["max:gap"].verdict == found["first_impact"].verdict == CONVERGED


def test_remarks_and_changes_are_in_lines_and_report():
    """What has converged at its number of modes alone, warnings with their levels, uneven numbers of events."""
    ladders = (
        Ladder("tolerance", RIGID, "tolerances", (1e-6, 1e-8, 1e-10), ("first_impact", "impulse")),
        Ladder("modes", PAPER.replace(end_time=0.4), "modes", (1.0, 2.0, 3.0), ("impulse",)),
    )
    result = refine(study=Study("a", "a", "", ladders), changes=["beam.length=0.9"], workers=1)
    assert "converged in the tolerance" in result.quantity("impulse").analysis.words
    no_limit = next(remark for remark in result.ladders[0].remarks if remark.startswith("normal impulse"))
    assert "no limit as modes or elements are added" in no_limit
    counts = result.ladders[1].runs["events"].tolist()
    uneven, warning = result.ladders[1].remarks
    assert f"differs from level to level ({', '.join(map(str, counts))})" in uneven
    assert warning.startswith("warning (modes 1, 2, 3): contact.normal: a rigid stop")
    page, told = html.unescape(report(result).html()), lines(result)
    assert all(f"  {remark}" in told and readable(remark[1:]) in page for remark in (no_limit, uneven, warning))
    differ = next(block for block in report(result).overview if block.caption == "Parameters that differ.")
    keys = {row[1].text: [value.text for value in row[3:]] for row in differ.cells()}
    assert keys["end_time"] == [f"{ladder.base.end_time:g}" for ladder in ladders]
    assert "beam.length" not in keys


# --- the command

FAST = (
    *("--set", "end_time=0.33"),
    *("--set", "discretization.frame=mean-axis"),
    *("--set", "contact.normal=spring"),
    *("--workers", "1"),
)


def test_a_study_of_elements_is_a_page_and_tables(tmp_path, cli):
    out = tmp_path / "elements"
    arguments = ("refine", "paper", "--elements", "8,16,32,64", *FAST, "--quantity", "impulse", "--out", out)
    code, shown, err = cli(*arguments)
    assert (code, err) == (0, "")
    assert "converged in the mesh at order" in shown
    names = ["report.html", "results.csv", "results.json", "results.parquet"]
    assert sorted(p.name for p in out.iterdir()) == names
    data = json.loads((out / "results.json").read_text())
    (impulse,) = (found["analysis"] for found in data["ladders"][0]["results"])
    assert impulse["order"] == pytest.approx(4.0, abs=0.1)
    with (out / "results.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["value"]) for row in rows] == [level["value"] for level in impulse["levels"]]
    assert float(rows[3]["observed_order"]) == impulse["levels"][3]["observed_order"]
    (command,) = re.findall(r"<dt>command</dt><dd[^>]*><code>(.*?)</code>", (out / "report.html").read_text())
    assert command.startswith("oblique-impact refine paper --elements 8,16,32,64 ")


def test_steps_and_tolerances(tmp_path, cli):
    flight = ("--set", "contact.enabled=false", "--set", "end_time=0.2", "--workers", "1", "--out", str(tmp_path))
    fixed = ("--set", "solver.scheme=fixed-step", "--quantity", "theta@end")
    code, out, _ = cli("refine", "--steps", "4e-4,2e-4,1e-4,5e-5", *fixed, *flight)
    assert code == 0
    assert "converged in the step at order 4" in out
    code, out, _ = cli("refine", "--tolerances", "1e-5,1e-7,1e-9", *flight, "--within", "1e-6")
    assert code == 0
    assert out.count("converged") == 6


BAD = {
    "two axes": (("--elements", "4,8,16", "--modes", "2,4,8"), "together"),
    "no axis": ((), "--elements"),
    "not ascending": (("--modes", "2,4,3"), "should increase"),
    "unknown quantity": (("--modes", "1,2,3", "--quantity", "speed"), "first_impact"),
    "time after the end": (("--modes", "1,2,3", "--quantity", "tip_y@2"), "end_time"),
    "unknown study": (("--study", "nonsense"), "remedies"),
    "study and levels": (("--study", "elements", "--elements", "4,8,16"), "its own levels"),
    "study and scenario": (("bouncing", "--study", "elements"), "scenario"),
    "study and bad key": (("--study", "elements", "--set", "beam.colour=1"), "beam.colour"),
    "too many modes": (("--modes", "1,2,200"), "discretization.modes"),
    "within nothing": (("--modes", "1,2,3", "--within", "0"), "--within"),
    "predictability and levels": (("--predictability", "--modes", "1,2,3"), "does not apply"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_exit_2(tmp_path, refused, case):
    arguments, part = BAD[case]
    assert part in refused("refine", *arguments, "--out", tmp_path / "never")
    assert not (tmp_path / "never").exists()
