"""The command `refine`: files, exit codes, one line for what is wrong, the same report twice."""

from __future__ import annotations

import csv
import json
import re

import pytest

FAST = (
    *("--set", "end_time=0.33"),
    *("--set", "discretization.frame=mean-axis"),
    *("--set", "contact.normal=spring"),
    *("--workers", "1"),
)
NODAL = (
    *("--set", "discretization.method=fem"),
    *("--set", "discretization.modes=0"),
    *("--set", "solver.scheme=generalized-alpha"),
    *("--set", "solver.free_step=1e-4"),
    *("--set", "solver.contact_step=1e-5"),
)


def test_a_study_of_elements_writes_three_files(tmp_path, cli):
    out = tmp_path / "elements"
    code, shown, err = cli(
        *("refine", "paper", "--elements", "8,16,32,64", *FAST),
        *("--quantity", "impulse", "--quantity", "tip_y@0.3", "--out", out),
    )
    assert (code, err) == (0, "")
    assert "converged in the mesh at order" in shown
    assert sorted(p.name for p in out.iterdir()) == ["report.html", "results.csv", "results.json"]
    data = json.loads((out / "results.json").read_text())
    assert [q["name"] for q in data["ladders"][0]["quantities"]] == ["impulse", "tip_y@0.3"]
    impulse = data["ladders"][0]["quantities"][0]
    assert impulse["order"] == pytest.approx(4.0, abs=0.1)
    with (out / "results.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 2 * 4
    assert [float(row["value"]) for row in rows[:4]] == impulse["values"]
    assert float(rows[3]["observed_order"]) == impulse["observed_orders"][3]


def test_a_report_needs_nothing_besides_itself(tmp_path, cli):
    assert cli("refine", "--modes", "1,2,3", *FAST, "--out", str(tmp_path))[0] == 0
    page = (tmp_path / "report.html").read_text()
    assert page.count("<svg") == 1
    assert re.findall(r'(?:src|href)="(?!#)([^"]*)"|url\((?!#)([^)]*)\)', page) == []
    assert "The rule." in page
    # the folder is where the reader typed it, and nowhere else
    (command,) = re.findall(r"<dt>command</dt><dd[^>]*><code>(.*?)</code>", page)
    assert command.startswith("oblique-impact refine paper --modes 1,2,3 ")
    assert command.endswith(f" --out {tmp_path} --workers 1")
    assert all(word in command for word in FAST)
    assert page.count(str(tmp_path)) == 1


def without_times(folder):
    data = json.loads((folder / "results.json").read_text())
    del data["times"], data["command"]  # which tells folder and processes
    page = re.sub(r'<dd class="time">.*?</dd>', "", (folder / "report.html").read_text())
    return data, page, (folder / "results.csv").read_text()


@pytest.mark.parametrize(
    ("case", "workers"),
    [
        (("--modes", "2,3,4"), "1"),  # a sweep in processes is quick: tests/validation/test_sweep_command.py
        pytest.param(("--modes", "2,3,4"), "2", marks=pytest.mark.slow),
        pytest.param(("--elements", "2,4,8", *NODAL), "2", marks=pytest.mark.slow),
    ],
    ids=["modal", "modal-processes", "nodal-processes"],
)
def test_two_reports_are_the_same_but_for_times(tmp_path, cli, case, workers):
    """Once in this process, and once more here or in two others."""
    for name, number in (("one", "1"), ("two", workers)):
        code, *_ = cli("refine", *case, *FAST[:-1], number, "--out", str(tmp_path / name))
        assert code == 0
    assert without_times(tmp_path / "one") == without_times(tmp_path / "two")


def test_what_the_physics_stops_is_said_and_exits_with_0(tmp_path, cli):
    rough = ("--set", "contact.mu_static=20.0", "--set", "contact.mu_kinetic=20.0", "--set", "end_time=0.4")
    mean_axis = ("--set", "discretization.frame=mean-axis", "--workers", "1", "--out", str(tmp_path))
    code, out, _ = cli("refine", "paper", "--modes", "1,2,3", *rough, *mean_axis)
    assert code == 0
    assert "modes 3: painleve at t = 0.3237" in out
    assert "no verdict" in out


def test_steps_and_tolerances(tmp_path, cli):
    flight = ("--set", "contact.enabled=false", "--set", "end_time=0.2", "--workers", "1", "--out", str(tmp_path))
    fixed = ("--set", "solver.scheme=fixed-step", "--quantity", "theta@end")
    code, out, _ = cli("refine", "--steps", "4e-4,2e-4,1e-4,5e-5", *fixed, *flight)
    assert code == 0
    assert "theta@end" in out
    code, out, _ = cli("refine", "--tolerances", "1e-5,1e-7,1e-9", *flight, "--within", "1e-6")
    assert code == 0
    assert out.count("converged") == 6


BAD = {
    "two levels": (("--elements", "4,8"), "3 to 16 levels"),
    "not increasing": (("--elements", "4,16,8"), "should increase"),
    "not a number": (("--modes", "2,four,8"), "whole numbers"),
    "two axes": (("--elements", "4,8,16", "--modes", "2,4,8"), "together"),
    "no axis": ((), "--elements"),
    "unknown quantity": (("--modes", "1,2,3", "--quantity", "speed"), "first_impact"),
    "time after the end": (("--modes", "1,2,3", "--quantity", "tip_y@2"), "end_time"),
    "unknown study": (("--study", "nonsense"), "remedies"),
    "study and levels": (("--study", "elements", "--elements", "4,8,16"), "its own levels"),
    "study and scenario": (("bouncing", "--study", "elements"), "scenario"),
    "unknown scenario": (("no-such", "--modes", "1,2,3"), "no-such"),
    "bad key": (("--modes", "1,2,3", "--set", "beam.colour=1"), "beam.colour"),
    "steps of the event scheme": (("--steps", "1e-4,1e-5,1e-6"), "--tolerances"),
    "too many modes": (("--modes", "1,2,200"), "discretization.modes"),
    "more modes than the mesh has": (
        ("--modes", "1,2,9", "--set", "discretization.method=fem", "--set", "discretization.elements=4"),
        "discretization.modes",
    ),
    "too tight": (("--tolerances", "1e-9,1e-12,1e-15"), "solver.tolerance"),
    "within nothing": (("--modes", "1,2,3", "--within", "0"), "--within"),
    "no workers": (("--modes", "1,2,3", "--workers", "0"), "--workers"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line_and_exit_2(tmp_path, refused, case):
    arguments, part = BAD[case]
    assert part in refused("refine", *arguments, "--out", tmp_path / "never")
    assert not (tmp_path / "never").exists()


@pytest.mark.slow
def test_remedies_converge_where_the_rigid_stop_does_not(tmp_path, cli):
    """Theory Sec. 6 and 7a: the numbers of the elastic stop are those of a geometrically exact code."""
    assert cli("refine", "--study", "remedies", "--workers", "2", "--out", str(tmp_path))[0] == 0
    data = json.loads((tmp_path / "results.json").read_text())
    found = {(ladder["name"], q["name"]): q for ladder in data["ladders"] for q in ladder["quantities"]}
    for name in ("peak_force", "second_impact", "contacts"):
        assert found["rigid, modes", name]["verdict"] == "not determined"
        assert found["rigid, elements", name]["verdict"] == "not determined"
        assert found["elastic stop", name]["verdict"] == "converged"
    assert found["rigid, modes", "impulse"]["values"][-1] == pytest.approx(1.87, abs=0.02)
    assert found["elastic stop", "impulse"]["limit"] == pytest.approx(2.140259, rel=1e-4)
    assert found["elastic stop", "peak_force"]["values"][-1] == pytest.approx(924.45, rel=1e-3)
    assert found["elastic stop", "second_impact"]["values"][-1] == pytest.approx(0.86535, abs=2e-4)
    assert found["Kelvin-Voigt", "second_impact"]["verdict"] == "converged"
    assert found["Kelvin-Voigt", "peak_force"]["verdict"] == "not determined"
    # the mesh of an undamped beam: what agrees from level to level is a number of the scheme
    assert found["dissipation, elements", "second_impact"]["verdict"] == "not determined"
    assert found["dissipation, steps", "second_impact"]["verdict"] in ("not converging", "not confirmed")


@pytest.mark.slow
def test_grading_pays_for_the_early_force_on_a_stiff_stop(tmp_path, cli):
    assert cli("refine", "--study", "grading", "--workers", "2", "--out", str(tmp_path))[0] == 0
    data = json.loads((tmp_path / "results.json").read_text())
    force = {ladder["name"]: ladder["quantities"][0]["values"] for ladder in data["ladders"][:3]}
    uniform, graded = force["early force, uniform"], force["early force, graded 8 : 1"]
    exact = uniform[-1]
    assert graded[-1] == pytest.approx(exact, rel=1e-5)
    for level in (1, 2):  # 8 and 16 elements
        assert abs(graded[level] - exact) < 0.2 * abs(uniform[level] - exact)
