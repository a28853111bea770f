"""Scenarios to start from: what the list says happens, and files that explain every key."""

from __future__ import annotations

import json
import re

import pytest

from oblique_impact import Scenario, builtin_cases, natural_frequencies, simulate, start_scenario
from oblique_impact.scenario.scenario import builtin_names
from oblique_impact.scenario.schema import key_schemas
from oblique_impact.scenario.shapes import SHAPE_PROPERTIES


@pytest.mark.parametrize("case", builtin_cases(), ids=lambda case: case.name)
def test_a_run_is_as_the_list_says_and_accounts_for_its_energy(run, case):
    """Implicit schemes to the second order in the step (check `balances.implicit-ledger`)."""
    history = run(case.name)
    assert case.end_time == history.summary["end_time"]
    begins = [m["start"] for m in history.macro_collisions]
    assert begins == pytest.approx(case.collisions, abs=6e-4)
    energy, allowed = history.balance, 1e-8
    if history.scenario.solver.scheme == "generalized-alpha":
        allowed = 5e-7 * abs(energy["initial"])
    if history.scenario.solver.scheme == "time-stepping":  # whose steps in flight are long
        allowed = max(allowed, 1e-7 * abs(energy["initial"]))
    assert abs(energy["unaccounted"]) < allowed
    losses = sum(energy[f"lost_{way}"] for way in ("impact", "friction", "damping", "scheme"))
    assert abs(energy["lost_scheme"]) <= max(0.03 * losses, 1e-3 * abs(energy["initial"]))
    assert not [line for line in history.summary["warnings"] if line.startswith("solver.")]


def test_the_command_lists_them(cli):
    lines = cli("scenarios")[1].splitlines()
    assert lines[0] == "paper: 1 s, 3 macro-collisions, at 0.317, 0.676, 0.926 s"
    assert lines[1::2] == [f"    {case.happens}" for case in builtin_cases()]
    found = json.loads(cli("scenarios", "--json")[1])["scenarios"]
    assert [entry["name"] for entry in found] == builtin_names()
    assert found[0]["collisions"] == list(builtin_cases()[0].collisions)


@pytest.mark.parametrize("name", builtin_names())
def test_a_new_file_is_the_same_scenario_and_so_it_is_with_every_key_taken_in(tmp_path, name):
    file = tmp_path / "mine.toml"
    made = start_scenario(file, name)
    text = file.read_text(encoding="utf-8")
    assert made == Scenario.load(str(file)) == Scenario.builtin(name)
    followers = SHAPE_PROPERTIES if made.beam.section.shape else ()  # are refused beside a shape
    taken = re.sub(rf"^#(?!{'|'.join((*followers, '#'))})(?=\w+ = )", "", text, flags=re.MULTILINE)
    assert Scenario.from_toml(taken) == made
    for path in set(key_schemas()) - {f"beam.{name}" for name in followers}:
        assert re.search(rf"^(\[\[)?{path.rpartition('.')[2]}( = |\]\])", taken, re.MULTILINE), path
    assert max(map(len, text.splitlines())) <= 110
    # what is given stays given, what follows other keys goes on following them
    assert made.contact.model_fields_set == Scenario.builtin(name).contact.model_fields_set


def test_a_file_of_ones_own_is_taken_with_its_parameters(tmp_path):
    (tmp_path / "old.toml").write_text("end_time = 0.2\n[beam]\nlength = '500 mm'\n", encoding="utf-8")
    made = start_scenario(tmp_path / "new" / "a.toml", str(tmp_path / "old.toml"))
    assert (made.end_time, made.beam.length, made.contact.point) == (0.2, 0.5, 0.5)
    assert "contact.point" not in (tmp_path / "new" / "a.toml").read_text(encoding="utf-8")


STRIP = ("beam.material=steel", "beam.length=0.2", "beam.section.shape=rectangle", "beam.section.width=10 mm")
STRIP += ("beam.section.height=1 mm", "slope.origin=[0.06, 0]", "contact.normal=spring")


@pytest.mark.parametrize(
    ("base", "changes"),
    [
        ("paper", STRIP),
        ("paper", ("beam.material=steel", "beam.tip_mass=0.1")),
        ("paper", ("contact.normal=spring", "contact.stiffness=1e8")),
        ("paper", ("beam.modal_damping_ratio=0.01",)),  # a rigid stop needs another one
        ("tapered", ()),
    ],
)
def test_recommended_settings_keep_the_beam_and_run_without_a_warning(tmp_path, cli, base, changes):
    file = tmp_path / "own.toml"
    options = [part for change in (*changes, "end_time=0.33") for part in ("--set", change)]
    assert cli("init", file, "--from", base, "--recommended", *options)[0] == 0
    made, asked = Scenario.load(str(file)), Scenario.load(base, ["discretization.method=fem", *changes])
    assert made.discretization.frame == "mean-axis"
    assert made.beam.kelvin_voigt > 0.0
    assert made.beam == asked.beam.model_copy(update={"kelvin_voigt": made.beam.kelvin_voigt})
    assert (made.slope, made.contact) == (asked.slope, asked.contact)
    summary = simulate(made).summary
    assert summary["macro_collisions"]
    assert [line for line in summary["warnings"] if "yields" not in line] == []


def test_recommended_settings_leave_what_is_given(tmp_path, cli):
    file, given = tmp_path / "own.toml", ("discretization.modes=7", "solver.scheme=fixed-step")
    assert cli("init", file, "--recommended", "--set", given[0], "--set", given[1])[0] == 0
    made = Scenario.load(str(file))
    assert (made.discretization.modes, made.solver.scheme) == (7, "fixed-step")
    assert made.discretization.frame == "mean-axis"


def test_bad_input_is_one_line_and_a_file_that_is_there_stays(tmp_path, refused):
    assert "should end in .toml" in refused("init", tmp_path / "a.txt")
    assert "did you mean tapered?" in refused("init", tmp_path / "a.toml", "--from", "taperd")
    assert "cannot be written" in refused("init", "/proc/nowhere/a.toml")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "a.toml").write_text("end_time = 0.2\n", encoding="utf-8")
    assert "is there already" in refused("init", tmp_path / "a.toml")
    assert (tmp_path / "a.toml").read_text(encoding="utf-8") == "end_time = 0.2\n"


@pytest.mark.parametrize("stiffness", [0.0, 5000.0])
def test_recommended_settings_say_what_a_clamp_that_yields_does(tmp_path, cli, stiffness):
    """A share of the first frequency, against the frequencies of `modes`."""
    file = tmp_path / "held.toml"
    keys = ("root.kind=driven", f"root.stiffness={stiffness}")
    assert cli("init", file, "--recommended", *(f"--set={key}" for key in keys))[0] == 0
    line = next(line for line in file.read_text("utf-8").splitlines() if "lowers the first frequency" in line)
    percent = float(re.search(r"lowers the first frequency by ([\d.]+) %", line)[1])
    spring = stiffness or float(re.search(r"one of ([\d.e+]+) N m/rad", line)[1])
    rigid, yielding = (
        natural_frequencies(Scenario.builtin("paper", ["root.kind=driven", f"root.stiffness={k}"])).chordwise[0, 0]
        for k in (0.0, spring)
    )
    assert percent == pytest.approx(100.0 * (1.0 - yielding / rigid), rel=0.05)  # two digits
