"""The command line as other programs call it."""

from __future__ import annotations

import csv
import json
import tomllib
from dataclasses import replace

import pytest
import xarray as xr

from oblique_impact import History, Scenario
from oblique_impact.command_line.application import main
from oblique_impact.command_line.run import summary_lines
from tests.processes import files_in


@pytest.fixture(scope="module")
def paper_run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    with pytest.raises(SystemExit) as exit_info:
        main(["run", "paper", "--out", str(folder), "--set", "end_time=0.4"])
    assert not exit_info.value.code
    return folder


def test_run_writes_exactly_its_four_files(paper_run):
    assert files_in(paper_run) == ["events.csv", "history.nc", "scenario.toml", "summary.json"]


def test_resolved_scenario_runs_again(paper_run, tmp_path, cli):
    text = (paper_run / "scenario.toml").read_text()
    assert tomllib.loads(text)["contact"]["point"] == 1.0
    assert Scenario.from_toml(text) == Scenario.builtin("paper", ["end_time=0.4"])
    code, _, _ = cli("run", str(paper_run / "scenario.toml"), "--out", str(tmp_path))
    assert code == 0
    assert (tmp_path / "events.csv").read_text() == (paper_run / "events.csv").read_text()


def test_event_table(paper_run):
    with (paper_run / "events.csv").open() as file:
        rows = list(csv.DictReader(file))
    columns = "time,kind,normal_impulse,normal_velocity,tangential_velocity,energy_loss,state"
    assert list(rows[0])[:7] == columns.split(",")
    assert (rows[0]["obstacle"], float(rows[0]["place"])) == ("0", 1.0)  # the slope, at the tip
    assert rows[0]["kind"] == "impact"
    assert float(rows[0]["time"]) == pytest.approx(0.3171473192, abs=1e-8)


def test_summary(paper_run):
    summary = json.loads((paper_run / "summary.json").read_text())
    assert summary["outcome"] == "completed"
    assert {"macro_collisions", "energy", "steps", "wall_time", "versions"} <= set(summary)
    collision = summary["macro_collisions"][0]
    assert set(collision) >= {"start", "end", "contacts", "normal_impulse", "tangential_impulse", "peak_force"}
    energy = "initial final kinetic elastic gravity lost_impact lost_friction lost_damping lost_scheme unaccounted"
    assert set(energy.split()) <= set(summary["energy"])


def test_physics_stop_exits_with_1_and_keeps_what_it_has(tmp_path, cli):
    changes = ("--set", "discretization.modes=8", "--set", "solver.tolerance=1e-8")
    code, out, err = cli("run", "paper", *changes, "--out", str(tmp_path))
    assert code == 1
    assert "mass-matrix-indefinite" in err
    assert "mean-axis" in err
    assert "full" in err
    assert json.loads((tmp_path / "summary.json").read_text())["outcome"] == "mass-matrix-indefinite"
    with xr.open_dataset(tmp_path / "history.nc") as data:
        assert 0.317 < float(data["time"][-1]) < 0.33
    assert "results" in out


BAD = {
    "contact.restitution=1.5": "contact.restitution",
    "beam.length=nan": "beam.length",
    "nonsense=1": "nonsense",
    "no-equals-sign": "no-equals-sign",
}


@pytest.mark.parametrize("change", BAD)
def test_bad_input_is_one_line_and_exit_2(tmp_path, refused, change):
    assert BAD[change] in refused("run", "paper", "--set", change, "--out", tmp_path / "never")
    assert not (tmp_path / "never").exists()


@pytest.mark.parametrize(
    "arguments", [("run", "no-such-scenario"), ("run", "--bad"), ("nonsense",), ("modes", "--speeds", "x")]
)
def test_bad_calls_are_one_line_and_exit_2(refused, arguments):
    refused(*arguments)


def test_what_a_run_prints_has_its_units(paper_run, tmp_path, capsys):
    history = History.load(paper_run)
    collision = {"start": 0.25, "end": 0.5, "contacts": 1, "normal_impulse": 1.5, "peak_force": 250.0}
    energy = {"initial": 3.0, "supplied": 0.25, "final": 2.3125, "unaccounted": 1e-9}
    energy |= {"lost_impact": 0.125, "lost_friction": 0.25, "lost_damping": 0.5, "lost_scheme": 0.0625}
    told = {
        "outcome": "completed",
        "end_time": 0.75,
        "events": 9,
        "steps": 77,
        "wall_time": 1.25,
        "macro_gap": 0.03,
    }
    summary = told | {"macro_collisions": [collision], "energy": energy, "warnings": ["mind the step"]}
    print("\n".join(summary_lines(replace(history, summary=summary), tmp_path, True)))
    assert capsys.readouterr().out.splitlines() == [
        "completed: t = 0.75 s, 9 events",
        "  collision 1: 0.250000 to 0.500000 s, 1 contact (less than 0.03 s apart), 1.5 N s, peak 250 N",
        "  energy: 3 + 0.25 supplied - 0.9375 lost = 2.3125 J",
        "  lost: impact 0.125, friction 0.25, damping 0.5, scheme 0.0625 J",
        "  unaccounted: 1.00e-09 J; 77 steps, 1.25 s",
        "  warning: mind the step",
        f"  results: {tmp_path} (those of an earlier run were replaced)",
    ]


@pytest.mark.parametrize("method", ["fem", "absolute"])
def test_a_scenario_is_checked_without_being_run(tmp_path, monkeypatch, cli, refused, method):
    monkeypatch.chdir(tmp_path)
    words = ("run", "slap", "--check", "--set", f"discretization.method={method}")
    code, out, err = cli(*words, "--set", "beam.youngs_modulus=1")
    assert (code, out) == (0, "scenario: slap: nothing refused\n")
    assert "beam.youngs_modulus" in err
    assert "starts" in refused(*words, "--set", "initial.angle=-0.5")
    assert list(tmp_path.iterdir()) == []


def test_a_run_prints_each_of_its_warnings_once(cli, tmp_path):
    """Those of implausible values before the run, the others below its results; all stand in the summary."""
    changes = ("contact.normal=spring", "beam.modal_damping_ratio=0.06", "end_time=0.32")
    options = [word for change in changes for word in ("--set", change)]
    code, out, err = cli("run", "paper", *options, "--out", tmp_path)
    warnings = json.loads((tmp_path / "summary.json").read_text())["warnings"]
    assert code == 0
    assert {line.partition(":")[0] for line in warnings} >= {"contact.stiffness", "beam.modal_damping_ratio"}
    shown = [line.partition("warning: ")[2] for line in (err + out).splitlines() if "warning: " in line]
    assert sorted(shown) == sorted(warnings)
