"""A warning is where the number is: in Python's warnings, where a history is shown, once in each command."""

from __future__ import annotations

import importlib
import json
import os
import pkgutil
import subprocess
import warnings
from html import unescape

import pytest

import oblique_impact
from oblique_impact import Scenario, SimulationWarning, simulate, simulate_system
from oblique_impact.renders import export
from oblique_impact.validation import SweepFile, compare, predictability, refine, sweep
from tests.processes import COMMAND
from tests.systems import Block

#: a spring under much damping: warnings of stiffness and of damping; the second has characters of HTML
WARNED = ("contact.normal=spring", "beam.modal_damping_ratio=0.06", "end_time=0.02")
NEAR = ("initial.angle=0.2214", "initial.angular_velocity=-3.786")


@pytest.fixture(scope="module")
def history(run):
    return run("paper", *NEAR, *WARNED)


@pytest.fixture(scope="module")
def texts(history):
    found = history.summary["warnings"]
    assert len(found) >= 2
    return found


def test_simulate_gives_each_warning_at_the_line_that_calls_it(texts):
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        simulate(Scenario.builtin("paper", [*NEAR, *WARNED]))
    assert [str(warning.message) for warning in given] == texts
    assert {(warning.category, warning.filename) for warning in given} == {(SimulationWarning, __file__)}


def test_a_warning_can_be_made_an_error_and_one_that_is_left_out_changes_nothing(history):
    scenario = Scenario.builtin("paper", [*NEAR, *WARNED])
    with warnings.catch_warnings():
        warnings.simplefilter("error", SimulationWarning)
        with pytest.raises(SimulationWarning, match=r"beam\.modal_damping_ratio: 0\.06 is 6 %"):
            simulate(scenario)
        warnings.simplefilter("ignore", SimulationWarning)
        assert simulate(scenario).events == history.events


def test_what_nothing_stands_against_gives_none():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate(Scenario.builtin("paper", ["contact.enabled=false", "end_time=0.01"]))
        simulate_system(Block(lambda t, q, qd: (0.0, -9.8)), [0.0, 1.0], [0.0, 0.0], 0.1)


def test_a_history_shows_them(history, texts):
    lines, page = repr(history).splitlines(), unescape(history._repr_html_())
    assert [line.partition("warning")[2].strip() for line in lines if line.startswith("  warning")] == texts
    assert all(text in page for text in texts)
    assert all("<" not in part.partition("</li>")[0] for part in history._repr_html_().split("<li>")[1:])


def test_results_of_studies_show_them(history, texts, tmp_path):
    """At a prompt too, not on their pages alone."""
    scenario = history.scenario
    assert all(text in repr(compare(history, history)) for text in texts)
    plan = SweepFile(
        scenario="paper",
        quantities=["impulse"],
        changes={"initial.angle": 0.2214, "initial.angular_velocity": -3.786}
        | {"contact.normal": "spring", "beam.modal_damping_ratio": 0.06, "end_time": 0.02},
        axes=[{"key": "contact.mu_kinetic", "values": [0.1, 0.2]}],
    )
    assert all(text in repr(sweep(plan, tmp_path / "sweep", workers=1)) for text in texts[:1])
    found = refine(scenario, modes=[1, 2, 3], quantities=["theta@end"], workers=1)
    assert "warning (modes 1, 2, 3): beam.modal_damping_ratio" in repr(found)
    found = predictability(scenario, perturbations=[1e-6], workers=1, out=tmp_path / "perturbed")
    assert texts[0] in repr(found)
    data = json.loads((tmp_path / "perturbed" / "results.json").read_text())
    assert data["runs"][0]["warnings"].splitlines() == texts


def test_the_table_of_an_export_has_no_place_for_them_but_the_command_says_them(history, texts, tmp_path, cli):
    folder = history.save(tmp_path / "run")
    code, out, _ = cli("export", folder, "--out", tmp_path / "table.csv")
    assert code == 0
    assert [line.partition("warning: ")[2] for line in out.splitlines() if "warning: " in line] == texts
    code, out, _ = cli("export", folder, "--out", tmp_path / "beam.pvd", "--every", 1000, "--json")
    assert json.loads(out)["warnings"] == texts
    assert export(history, tmp_path / "again.csv").samples == history.data.sizes["time"]


# Commands -------------------------------------------------------------------------------------------------------


REFINE = "refine paper --set end_time=0.33 --modes 1,2,3 --quantity impulse --workers 2"


def test_a_command_leaves_them_to_its_own_output(run, tmp_path):
    """Python's form of them is on no stream, of no process of it."""
    run("paper", "end_time=0.33")  # the kernels are compiled
    done = subprocess.run(
        [*COMMAND, *REFINE.split(), "--out", str(tmp_path)],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONWARNINGS": "always::UserWarning"},
    )
    assert done.returncode == 0, done.stderr
    assert "SimulationWarning" not in done.stdout + done.stderr
    assert (done.stdout + done.stderr).count("no limit as modes or elements are added: times") == 1


def test_what_runs_many_scenarios_does_not_warn_of_each():
    """Validation, renders and commands compute histories without Python's warnings; users simulate with them."""
    for package in ("validation", "renders", "command_line"):
        parent = importlib.import_module(f"oblique_impact.{package}")
        for found in pkgutil.walk_packages(parent.__path__, f"{parent.__name__}."):
            module = importlib.import_module(found.name)
            assert getattr(module, "simulate", None) is not oblique_impact.simulate, found.name
