"""Refinement: levels, declared orders, verdicts of real runs, report and command."""

from __future__ import annotations

import csv
import html
import json
import re

import numpy as np
import pytest

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.validation import refine
from oblique_impact.validation.report import readable
from oblique_impact.validation.studies.convergence import CONVERGED, NO_VERDICT, NOT_DETERMINED
from oblique_impact.validation.studies.quantities import quantity
from oblique_impact.validation.studies.refinement import declared_orders, sizes_of
from oblique_impact.validation.studies.series import AXES, RefinementSeries, Study, load_study
from tests import STUDIES
from tests.refusals import refused_in_one_line

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
    runs = RefinementSeries("a", base, "modes", (1.0, 2.0, 3.0), ("impulse",)).runs()
    assert [run.labels["axis"] for run in runs] == ["modes"] * 3 + ["noise"]
    assert runs[-1].scenario.solver.tolerance == pytest.approx(tighter, rel=1e-12)
    assert runs[-1].scenario.discretization.modes == 3


def test_what_samples_miss_of_an_extreme_is_noise():
    """The largest moment at the root of a strip that vibrates, from ten samples a period."""
    strip = Scenario.builtin("shaken", ["end_time=0.1", "solver.output_interval=8e-3", "contact.enabled=false"])
    found = refine(strip, modes=[2, 3, 4], quantities=["peak:moment"], workers=1)
    dense = strip.replace(discretization__modes=4, solver__output_interval=1e-5)
    true = quantity("peak:moment").measure(simulate(dense))
    row = found.frame.loc["peak:moment"]
    assert row["uncertainty"] >= 0.9 * abs(row["value"] - true) > 1e-3 * true


def test_orders_are_declared_only_where_they_hold():
    names = ("impulse", "peak_force", "max:moment", "contacts")
    assert declared_orders("elements", PAPER, names) == {"impulse": 4.0}
    assert declared_orders("modes", PAPER, names) == {}
    assert declared_orders("steps", PAPER.replace(solver__scheme="time-stepping"), names) == {}
    implicit = PAPER.replace(solver__scheme="generalized-alpha", contact__normal="spring")
    assert declared_orders("steps", implicit, names) == {"impulse": 2.0}


@pytest.mark.parametrize("name", ["elements", "steps", "remedies", "rigid-stop", "anywhere"])
def test_every_study_of_the_documentation_can_be_planned(name):
    study = load_study(STUDIES / f"{name}.toml")
    assert study.name == name
    assert study.title
    assert study.description
    for series in study.series:
        assert len(series.runs()) >= 3
        assert set(series.declared) <= set(series.quantities)


def test_beams_just_above_the_table_have_fallen_there():
    """Speeds of the study: weight m g, inertia m L²/3 about the pin; a tenth of speeds, places and gravity."""
    bases = {series.name: series.base for series in load_study(STUDIES / "anywhere.toml").series}
    for case, reach in (("slap", 1.0), ("edge", 0.61)):
        full, scaled = bases[f"{case}, plastic, elements"], bases[f"slow {case}, no inertia"]
        straight, slow = (bases[f"{way} {case}, plastic"].initial for way in ("straight", "slow"))
        low = -0.99 * 0.02 / reach  # sine of the angle
        speed = np.sqrt(3.0 * full.gravity / full.beam.length * (np.sin(full.initial.angle) - low))
        assert (straight.angle, straight.angular_velocity) == pytest.approx((np.arcsin(low), -speed), rel=1e-12)
        assert slow.angle == pytest.approx(np.arcsin(0.1 * low), rel=1e-12)
        assert slow.angular_velocity == pytest.approx(-0.1 * speed, rel=1e-12)
        assert scaled.gravity == pytest.approx(0.1 * full.gravity, rel=1e-12)
        assert scaled.obstacles[0].origin[1] == pytest.approx(0.1 * full.obstacles[0].origin[1], rel=1e-12)
        assert scaled.obstacles[0].extent == full.obstacles[0].extent


STUDY = """
[study]
title = "One and two modes"
axis = "modes"
levels = [1, 2, 3]
quantities = ["theta@end"]
changes = { end_time = 0.1, contact.enabled = false }
[[study.series]]
name = "as it is"
[[study.series]]
name = "longer"
levels = [2, 3, 4]
orders = { "theta@end" = 4 }
changes.end_time = 0.2
"""
BAD_STUDIES = {
    "no title": (STUDY.replace("title", "titel"), "study.title: missing"),
    "unknown key of a scenario": (STUDY.replace("end_time = 0.2", "end = 1"), 'study.series.1.changes = "end"'),
    "no such axis": (STUDY.replace('"modes"', '"mode"'), "did you mean modes"),
    "two levels": (STUDY.replace("[2, 3, 4]", "[2, 3]"), "study.series.1.levels 2,3: a verdict takes"),
    "order of what is not asked for": (STUDY.replace('"theta@end" = 4', '"tip_x@end" = 4'), "series.1.orders"),
    "a name twice": (STUDY.replace("longer", "as it is"), "series.0.name"),
    "no key of a study": (f"end_time = 1.0\n{STUDY}", "and nothing else"),
    "no effect": (STUDY.replace("end_time = 0.2", "contact.stiffness = 2"), "contact.stiffness"),
}


@pytest.mark.parametrize("case", BAD_STUDIES)
def test_a_bad_study_file_is_one_line(tmp_path, case):
    text, part = BAD_STUDIES[case]
    (tmp_path / "bad.toml").write_text(text)
    with refused_in_one_line(part):
        load_study(tmp_path / "bad.toml")


def test_the_command_runs_a_study_file_with_changes(tmp_path, cli):
    """A series takes what it does not give from the study, and both take what is changed by --set."""
    (tmp_path / "mine.toml").write_text(STUDY)
    changes = ("--set", "initial.angle=0.5", "--workers", "1", "--out", tmp_path / "out")
    code, out, _ = cli("refine", tmp_path / "mine.toml", *changes)
    assert code == 0
    assert [line.split()[0] for line in out.splitlines()[2:4]] == ["as", "longer"]
    data = json.loads((tmp_path / "out" / "results.json").read_text())
    assert (data["study"], data["title"]) == ("mine", "Refinement study: One and two modes")
    assert [one["end_time"] for one in data["scenarios"].values()] == [0.1, 0.2]
    assert {one["initial"]["angle"] for one in data["scenarios"].values()} == {0.5}
    levels = [(row["series"], row["level"]) for row in data["levels"]]
    assert levels == [("as it is", n) for n in (1.0, 2.0, 3.0)] + [("longer", n) for n in (2.0, 3.0, 4.0)]
    assert [row["declared"] for row in data["quantities"]] == [None, 4.0]


def test_a_run_the_physics_stops_is_a_row_and_not_the_end():
    rough = PAPER.replace(end_time=0.4, discretization__frame="mean-axis")
    rough = rough.replace(contact__mu_static=20.0, contact__mu_kinetic=20.0)
    result = refine(rough, modes=[1, 2, 3], quantities=["first_impact", "theta@0.35"], workers=1)
    levels = result.tables["levels"]
    assert levels["outcome"].tolist() == 2 * ["completed", "completed", "painleve"]
    assert result.frame["verdict"].tolist() == [CONVERGED, NO_VERDICT]
    assert any(line.startswith("  modes 3: painleve at t = 0.3237") for line in repr(result).splitlines())
    assert "painleve" in levels["gap"].iloc[-1]
    assert result["theta@0.35"].because == levels["gap"].iloc[-1]


@pytest.mark.parametrize(
    ("scenario", "lost"),
    [
        (RIGID, {"impulse", "collision_end", "tip_y@end", "peak_force", "peak:lambda_n"}),
        (RIGID.replace(beam__kelvin_voigt=1e-3), {"peak_force", "peak:lambda_n"}),
    ],
    ids=["undamped", "damped"],
)
def test_what_a_run_calls_not_determined_is_not_called_converged(scenario, lost):
    names = [
        "first_impact",
        "tip_y@0.3",
        "max:gap",
        "peak:gap",
        *sorted({"impulse", "collision_end", "tip_y@end"} | lost),
    ]
    result = refine(scenario, modes=[2, 3, 4], quantities=names, within=0.5, workers=1)
    frame, levels = result.frame, result.tables["levels"]["value"]
    assert set(frame.index[frame["verdict"] == NOT_DETERMINED]) == lost == set(result.failed.index)
    assert frame.loc[[*lost], "limit"].isna().all()
    # without a limit it has an uncertainty all the same: 1.25 times the larger of the last two differences
    for name in lost:
        assert frame.loc[name, "uncertainty"] == pytest.approx(
            1.25 * np.abs(np.diff(levels[name])).max(), rel=1e-12
        )
    assert frame["uncertainty"].notna().all()
    # the tip falls: its largest gap is that of the start
    assert set(frame.loc[["max:gap", "peak:gap", "first_impact"], "verdict"]) == {CONVERGED}


def test_remarks_and_changes_are_in_lines_and_report():
    """What has converged at its number of modes alone, warnings with their levels, uneven numbers of events."""
    series = (
        RefinementSeries("tolerance", RIGID, "tolerances", (1e-6, 1e-8, 1e-10), ("first_impact", "impulse")),
        RefinementSeries("modes", PAPER.replace(end_time=0.4), "modes", (1.0, 2.0, 3.0), ("impulse",)),
    )
    result = refine(Study("a", "a", "", series), changes=["beam.length=0.9"], workers=1)
    impulse = result["impulse"].set_index("series").loc["tolerance"]
    assert (impulse.verdict, result.kinds[impulse.verdict]) == ("converged in the tolerance alone", "partly")
    no_limit = next(remark for remark in result.remarks if remark.startswith("tolerance: normal impulse"))
    assert "no limit as modes or elements are added" in no_limit
    runs = result.tables["runs"]
    counts = runs["events"][runs["axis"] == "modes"].tolist()
    uneven, warning = (remark for remark in result.remarks if remark.startswith("modes: "))
    assert f"differs from level to level ({', '.join(map(str, counts))})" in uneven
    assert warning.startswith("modes: warning (modes 1, 2, 3): contact.normal: a rigid stop")
    page, told = html.unescape(result.report().html()), repr(result).splitlines()
    assert all(f"  {remark}" in told and readable(remark[1:]) in page for remark in (no_limit, uneven, warning))
    differ = next(b for b in result.report().overview if getattr(b, "caption", "") == "Parameters that differ.")
    keys = {row[1].text: [value.text for value in row[3:]] for row in differ.cells()}
    assert keys["end_time"] == [f"{one.base.end_time:g}" for one in series]
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
    assert shown.startswith("quantities: 1 converged in the mesh (")
    names = ["levels.csv", "report.html", "results.csv", "results.json", "results.parquet", "runs.csv"]
    assert sorted(p.name for p in out.iterdir()) == names
    data = json.loads((out / "results.json").read_text())
    (impulse,) = data["quantities"]
    assert impulse["order"] == pytest.approx(4.0, abs=0.1)
    with (out / "levels.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["value"]) for row in rows] == [level["value"] for level in data["levels"]]
    assert float(rows[3]["observed_order"]) == data["levels"][3]["observed_order"]
    with (out / "results.csv").open() as file:
        (row,) = csv.DictReader(file)
    assert (row["quantity"], float(row["value"])) == ("impulse", data["levels"][3]["value"])
    (command,) = re.findall(r"<dt>command</dt><dd[^>]*><code>(.*?)</code>", (out / "report.html").read_text())
    assert command.startswith("oblique-impact refine paper --elements 8,16,32,64 ")


def test_steps_and_tolerances(tmp_path, cli):
    flight = ("--set", "contact.enabled=false", "--set", "end_time=0.2", "--workers", "1", "--out", str(tmp_path))
    fixed = ("--set", "solver.scheme=fixed-step", "--quantity", "theta@end")
    code, out, _ = cli("refine", "--steps", "4e-4,2e-4,1e-4,5e-5", *fixed, *flight)
    assert code == 0
    assert "converged in the step" in out
    assert json.loads((tmp_path / "results.json").read_text())["quantities"][0]["order"] == pytest.approx(
        4, abs=0.2
    )
    code, out, _ = cli("refine", "--tolerances", "1e-5,1e-7,1e-9", *flight, "--within", "1e-6")
    assert code == 0
    assert out.startswith("quantities: 6 converged in the tolerance (")


BAD = {
    "two axes": (("--elements", "4,8,16", "--modes", "2,4,8"), "together"),
    "no axis": ((), "--elements"),
    "not ascending": (("--modes", "2,4,3"), "should increase"),
    "unknown quantity": (("--modes", "1,2,3", "--quantity", "speed"), "first_impact"),
    "time after the end": (("--modes", "1,2,3", "--quantity", "tip_y@2"), "end_time"),
    "a study by name": (("--study", "elements"), "docs/studies/elements.toml"),
    "study and levels": ((STUDIES / "elements.toml", "--elements", "4,8,16"), "its own levels"),
    "study and bad key": ((STUDIES / "elements.toml", "--set", "beam.colour=1"), "beam.colour"),
    "too many modes": (("--modes", "1,2,200"), "discretization.modes"),
    "within nothing": (("--modes", "1,2,3", "--within", "0"), "--within"),
    "predictability and levels": (("--predictability", "--modes", "1,2,3"), "does not apply"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_exit_2(tmp_path, refused, case):
    arguments, part = BAD[case]
    assert part in refused("refine", *arguments, "--out", tmp_path / "never")
    assert not (tmp_path / "never").exists()
