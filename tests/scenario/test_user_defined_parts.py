"""The package of examples/own_parts, installed beside the program as a user would install it."""

import json
import os
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from oblique_impact import History, InputError, Scenario

ROOT = Path(__file__).parents[2]
SOURCE = ROOT / "examples" / "own_parts"


#: several commands by one process: it imports and loads kernels once
SEVERAL = """
import json, sys
from oblique_impact.command_line.application import main
for words in json.loads(sys.argv[1]):
    try:
        main(words)
    except SystemExit as ended:
        assert not ended.code, words
"""


@pytest.fixture(scope="module")
def python(tmp_path_factory):
    """Install the package into a folder of its own; returns a Python that sees it."""
    folder = tmp_path_factory.mktemp("own")
    copied = shutil.copytree(SOURCE, folder / "source")
    options = ("--quiet", "--no-deps", "--no-build-isolation", "--no-index")
    install = [sys.executable, "-m", "pip", "install", *options, "--target", folder / "site", copied]
    subprocess.run(install, check=True, capture_output=True, timeout=120)
    path = os.pathsep.join(filter(None, [str(folder / "site"), os.environ.get("PYTHONPATH")]))

    def call(*words):
        done = subprocess.run(
            [sys.executable, *map(str, words)],
            capture_output=True,
            text=True,
            timeout=300,
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": path},
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    return call


@pytest.fixture(scope="module")
def results(python, tmp_path_factory):
    """Run three scenarios with user-defined parts and their checks; returns the folder and what was said."""
    folder = tmp_path_factory.mktemp("results")
    # two contacts; in flight the steps of the example, 2e-5 s, find the same
    short = ("--set", "end_time=0.22", "--set", "solver.free_step=1e-4")
    impact = ("--set", "contact.impact=speed-dependent", "--set", "parameters.impact.restitution=0.5")
    commands = [
        ("run", SOURCE / "scenario.toml", "--out", folder / "own", *short),
        ("run", SOURCE / "scenario.toml", "--out", folder / "event", *short, "--set", "solver.scheme=event"),
        ("run", "paper", "--out", folder / "impact", *impact),
        ("validate", "--only", "own", "--out", folder / "checks"),
    ]
    return folder, python("-c", SEVERAL, json.dumps([[str(word) for word in words] for words in commands]))


def test_all_parts_run_in_one_scenario(results):
    own, exact = (json.loads((results[0] / name / "summary.json").read_text()) for name in ("own", "event"))
    assert own["outcome"] == "completed"
    assert own["macro_collisions"][0]["contacts"] == 2
    assert own["macro_collisions"][0]["peak_force"] > 100.0
    assert abs(own["energy"]["unaccounted"]) < 1e-5
    for entry in ("lost_friction", "lost_damping", "supplied"):
        assert own["energy"][entry] == pytest.approx(exact["energy"][entry], rel=1e-4)
    resolved = tomllib.loads((results[0] / "own" / "scenario.toml").read_text(encoding="utf-8"))
    assert len(resolved["parameters"]) == 3


def test_an_own_impact_law_runs_by_changes_alone(results):
    assert json.loads((results[0] / "impact" / "summary.json").read_text())["energy"]["lost_impact"] > 1.0


def test_own_checks_run_with_validate(results):
    folder, said = results
    assert "1 check, 1 measurement: all pass" in said
    assert "own.hertz-depth" in (folder / "checks" / "results.csv").read_text(encoding="utf-8")


@pytest.mark.slow
def test_numbers_of_own_parts_can_be_swept_in_parallel(python, tmp_path):
    pq = pytest.importorskip("pyarrow.parquet")
    file = tmp_path / "sweep.toml"
    file.write_text(
        'scenario = "paper"\nquantities = ["energy_lost"]\n[changes]\n"end_time" = 0.4\n'
        '"contact.normal" = "hertz"\n[[axes]]\nkey = "parameters.normal.damping"\nvalues = [0.0, 0.1, 0.3]\n',
        encoding="utf-8",
    )
    python("-m", "oblique_impact", "sweep", file, "--out", tmp_path / "out", "--workers", "2")
    table = pq.read_table(tmp_path / "out" / "results.parquet")
    assert table["outcome"].to_pylist() == ["completed"] * 3
    lost = table["energy_lost"].to_pylist()
    assert lost[0] < lost[1] < lost[2]


def test_without_the_package_its_scenario_is_refused_in_one_line():
    with pytest.raises(InputError, match="should be") as refused:
        Scenario.load(str(SOURCE / "scenario.toml"))
    assert "\n" not in str(refused.value)


@pytest.mark.slow
def test_a_history_of_own_parts_loads_without_them(python, tmp_path):
    python("-m", "oblique_impact", "run", SOURCE / "scenario.toml", "--out", tmp_path)
    assert History.load(tmp_path)["lambda_n"].max() > 100.0
