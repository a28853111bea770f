"""The numbers of "ten ways to be wrong about an impact" are those of runs, or of the page that they are from."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from oblique_impact import Scenario
from oblique_impact.beam.cross_sections import Sections
from tests.docs.test_docs_commands import lines_of

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "ten-ways.md").read_text(encoding="utf-8")
TEXT = " ".join(PAGE.split())
RIGID = ("discretization.frame=mean-axis", "contact.friction=frictionless")


def row(start: str) -> list[float]:
    """Numbers of the row of a table."""
    (cells,) = re.findall(rf"^\| {re.escape(start)} \|(.*)\|$", PAGE, re.MULTILINE)
    return [float(cell) for cell in cells.split("|")]


def words(values, form: str) -> str:
    *first, last = (format(value, form) for value in values)
    return f"{', '.join(first)} and {last}"


def test_forces_times_and_contacts_of_a_rigid_stop(run):
    histories = [run("paper", f"discretization.modes={n}", *RIGID) for n in (2, 4, 8, 16)]
    first = [history.macro_collisions[0] for history in histories]
    assert row("modes (mean-axis frame)") == [2, 4, 8, 16]
    assert row("largest force, first collision (N)") == [round(m["peak_force"]) for m in first]
    impulses = re.findall(r"^\| impulse \(N s\) \|(.*)\|$", PAGE, re.MULTILINE)[0]
    assert [float(cell) for cell in impulses.split("|")] == [round(m["normal_impulse"], 3) for m in first]
    second = [history.macro_collisions[1]["start"] for history in histories]
    assert f"starts at {words(second, '.3f')} s with 2, 4, 8 and 16 modes" in TEXT
    assert f"has {words([m['contacts'] for m in first], 'd')} contacts" in TEXT
    energy = histories[-1].summary["energy"]
    assert abs(energy["unaccounted"]) < 5e-11
    assert energy["initial"] == pytest.approx(3.01, abs=0.005)


def test_the_wrong_model_stops_by_name(run):
    history = run("paper", "discretization.modes=6")
    assert history.summary["outcome"] == "mass-matrix-indefinite"
    assert f"With six the run stops at {history.summary['end_time']:.4f} s" in TEXT


def test_stiffnesses_of_a_stop(run):
    stiffnesses = ("1e5", "1e6", "1e7", "3e7")
    first = [
        run("elastic-stop", f"contact.stiffness={k}", "end_time=0.4").macro_collisions[0] for k in stiffnesses
    ]
    table = PAGE.partition("| stiffness (N/m) |")[2]
    rows = dict(re.findall(r"^\| ([^|]+) \|(.*)\|$", table, re.MULTILINE))

    def cells(name: str) -> list[float]:
        return [float(cell) for cell in rows[name].split("|")]

    assert cells("impulse (N s)") == [round(m["normal_impulse"], 3) for m in first]
    assert cells("largest force (N)") == [round(m["peak_force"]) for m in first]
    assert cells("contacts") == [m["contacts"] for m in first]
    assert f"there is a force: {first[1]['peak_force']:.0f} N at 1e6 N/m" in TEXT


def test_fixed_steps_notice_a_contact_late(run):
    fixed, exact = (run("paper", "end_time=0.4", *scheme) for scheme in (("solver.scheme=fixed-step",), ()))
    depth = -1e3 * float(np.nanmin(fixed["gap"]))
    assert f"the tip is {depth:.2f} mm deep in the slope" in TEXT
    first = [history.events[0].time for history in (fixed, exact)]
    assert f"the impact comes at {first[0]:.4f} s instead of {first[1]:.6f} s" in TEXT
    assert abs(float(np.nanmin(exact["gap"]))) < 1e-15


def test_the_rest_of_the_beam(run):
    warnings = run("mid-span", "slope.extent=[]").summary["warnings"]
    assert any(line.startswith("passes 75 mm below the slope at x = 1 m") for line in warnings)
    assert "the tip passes 75 mm below the slope" in TEXT


def test_a_rectangle_taken_for_a_circle():
    sizes = {"width": 0.05, "height": [[0.0, 0.03], [1.0, 0.012]]}
    keys = {f"beam__section__{name}": size for name, size in sizes.items()}
    base = Scenario().replace(discretization__method="fem")
    sections = Sections.from_scenario(base.replace(beam__section__shape="rectangle", **keys))
    x = np.array([0.0, 1.0])
    root, tip = np.sqrt(sections.area(x) / np.pi) / sections.fibre_distance(x)
    assert f"{root:.2f} times too large at the root and {tip:.2f} times at the tip" in TEXT


def test_numbers_of_other_pages_stand_there():
    convergence = " ".join((DOCS / "convergence.md").read_text(encoding="utf-8").split())
    readme = " ".join((DOCS.parent / "README.md").read_text(encoding="utf-8").split())
    assert "0.097, 0.048, 0.024, 0.012 J for 16 to 128 elements" in convergence
    assert "0.097, 0.048, 0.024 and 0.012 J with 16 to 128 elements" in TEXT
    assert "0.67 to 0.72 s" in convergence
    assert "event times of modes and of 64 elements differ by 2e-10 s in the first collision" in readme
    assert "agree to 2e-10 s in all events of the first collision" in TEXT
    assert "| energy after the collision (J) | 2.32548 |" in convergence  # of 3.010 J: 0.68 J
    assert "What the collision takes in all, 0.68 J," in TEXT


def test_there_are_ten():
    assert [int(n) for n in re.findall(r"^## (\d+)\. To ", PAGE, re.MULTILINE)] == list(range(1, 11))


def verdict_of_the_second_collision(command: list[str], folder: Path, cli) -> str:
    """Run a command of the page; returns its verdict on the second macro-collision."""
    words = [*command[1 : command.index("--out")], "--out", folder]
    code, out, _ = cli(*words)
    assert code == 0
    (line,) = [line for line in out.splitlines() if "collision 2:" in line]
    return line.rpartition(": ")[2]


def predictions() -> list[list[str]]:
    return [words for words in lines_of(DOCS / "ten-ways.md") if "--predictability" in words]


def test_few_modes_are_predictable(tmp_path, cli):
    assert "the second collision of sixteen modes is predictable" in TEXT
    few, _ = predictions()
    assert verdict_of_the_second_collision(few, tmp_path, cli) == "predictable"


@pytest.mark.slow
def test_an_undamped_beam_on_a_rigid_stop_is_not_predictable(tmp_path, cli):
    """The start moves by at least 5e-3 s within a millionth of a radian."""
    _, many = predictions()
    assert verdict_of_the_second_collision(many, tmp_path, cli) == "not predictable"
    (case,) = json.loads((tmp_path / "results.json").read_text())["cases"]
    assert case["collisions"][1]["spread"][-1] > 5e-3
