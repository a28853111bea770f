"""The package of examples/own_parts, installed beside the program as a user would install it."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from oblique_impact import History, InputError, Scenario

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "examples" / "own_parts"


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """Install the package into a folder of its own; returns a command line that sees it."""
    folder = tmp_path_factory.mktemp("own")
    copied = shutil.copytree(SOURCE, folder / "source")
    install = [
        sys.executable,
        "-m",
        "pip",
        "install",
        "--quiet",
        "--no-deps",
        "--no-build-isolation",
        "--no-index",
    ]
    subprocess.run([*install, "--target", folder / "site", copied], check=True, capture_output=True, timeout=120)
    path = os.pathsep.join(filter(None, [str(folder / "site"), os.environ.get("PYTHONPATH")]))

    def command(*words):
        return subprocess.run(
            [sys.executable, "-m", "oblique_impact", *map(str, words)],
            capture_output=True,
            text=True,
            timeout=300,
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": path},
        )

    return command


def test_all_parts_run_in_one_scenario(own, tmp_path):
    done = own("run", SOURCE / "scenario.toml", "--out", tmp_path / "own")
    assert done.returncode == 0, done.stderr
    summary = json.loads((tmp_path / "own" / "summary.json").read_text(encoding="utf-8"))
    assert summary["outcome"] == "completed"
    assert summary["macro_collisions"][0]["peak_force"] > 100.0
    assert abs(summary["energy"]["unaccounted"]) < 1e-5
    other = own("run", SOURCE / "scenario.toml", "--out", tmp_path / "event", "--set", "solver.scheme=event")
    assert other.returncode == 0, other.stderr
    exact = json.loads((tmp_path / "event" / "summary.json").read_text(encoding="utf-8"))
    for entry in ("lost_friction", "lost_damping", "supplied"):
        assert summary["energy"][entry] == pytest.approx(exact["energy"][entry], rel=1e-4)
    assert (tmp_path / "own" / "scenario.toml").read_text(encoding="utf-8").count("[parameters.") == 3


def test_an_own_impact_law_runs_by_changes_alone(own, tmp_path):
    changes = ["contact.impact=speed-dependent", "parameters.impact.restitution=0.5"]
    done = own("run", "paper", "--out", tmp_path, *(word for c in changes for word in ("--set", c)))
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))["energy"]["lost_impact"] > 1.0


def test_own_checks_run_with_validate(own, tmp_path):
    done = own("validate", "--only", "own", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "1 check, 1 measurement: all pass" in done.stdout
    assert "own.hertz-depth" in (tmp_path / "results.csv").read_text(encoding="utf-8")


@pytest.mark.slow
def test_numbers_of_own_parts_can_be_swept_in_parallel(own, tmp_path):
    pq = pytest.importorskip("pyarrow.parquet")
    file = tmp_path / "sweep.toml"
    file.write_text(
        'scenario = "paper"\nquantities = ["energy_lost"]\n[changes]\n"end_time" = 0.4\n'
        '"contact.normal" = "hertz"\n[[axes]]\nkey = "parameters.normal.damping"\nvalues = [0.0, 0.1, 0.3]\n',
        encoding="utf-8",
    )
    done = own("sweep", file, "--out", tmp_path / "out", "--workers", "2")
    assert done.returncode == 0, done.stderr
    table = pq.read_table(tmp_path / "out" / "results.parquet")
    assert table["outcome"].to_pylist() == ["completed"] * 3
    lost = table["energy_lost"].to_pylist()
    assert lost[0] < lost[1] < lost[2]


def test_without_the_package_its_scenario_is_refused_in_one_line():
    with pytest.raises(InputError, match="should be") as refused:
        Scenario.load(str(SOURCE / "scenario.toml"))
    assert "\n" not in str(refused.value)


@pytest.mark.slow
def test_a_history_of_own_parts_loads_without_them(own, tmp_path):
    assert own("run", SOURCE / "scenario.toml", "--out", tmp_path).returncode == 0
    assert History.load(tmp_path)["lambda_n"].max() > 100.0
