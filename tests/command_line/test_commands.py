"""Every command: help, --version, completion, and --json, one object on standard output and nothing else."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from importlib.metadata import version

import numpy as np
import pytest

from oblique_impact import Scenario, natural_frequencies
from oblique_impact.beam.frequencies import Frequencies
from oblique_impact.command_line import modes
from oblique_impact.command_line.application import COMMANDS
from oblique_impact.machine import THREADS
from tests.processes import python


def test_the_help_page_lists_all_commands(cli):
    code, page, _ = cli("--help")
    listed = [line.split()[0] for line in page.partition("Commands:")[2].splitlines() if line.startswith("  ")]
    assert code == 0
    assert set(listed) >= set(COMMANDS)
    for name in COMMANDS:
        assert "--version" in cli(name, "--help")[1]


@pytest.mark.parametrize("words", [(), *([name] for name in COMMANDS)])
def test_the_version_everywhere(cli, words):
    assert cli(*words, "--version") == (0, f"oblique-impact {version('oblique-impact')}\n", "")


def completed(words: str, count: int) -> set[str]:
    """Return the completions of `words` that the program offers to a bash."""
    asked = {"_OBLIQUE_IMPACT_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(count)}
    command = [sys.executable, "-m", "oblique_impact"]
    done = subprocess.run(command, env={**os.environ, **asked}, capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_what_a_shell_is_told():
    assert completed("oblique-impact re", 1) == {"render", "refine", "reproduce"}
    assert completed("oblique-impact run t", 2) == {"tapered", "two-pegs"}
    keys = {"contact.mu_static=", "contact.mu_kinetic="}
    assert completed("oblique-impact run paper --set contact.mu", 4) == keys


def test_help_imports_no_numerics():
    code = (
        "import sys; from oblique_impact.command_line.application import application; application(); "
        "print([m for m in ('numba', 'scipy', 'matplotlib', 'pyvista', 'pint', 'lmfit') if m in sys.modules])"
    )
    assert python(code).stdout.strip() == "[]"


def test_a_run_loads_no_integrators_of_scipy():
    code = (
        "import sys, oblique_impact as o; o.simulate(o.Scenario.builtin('paper', ['end_time=1e-3'])); "
        "print([m for m in ('integrate', 'interpolate', 'optimize') if f'scipy.{m}' in sys.modules])"
    )
    assert python(code).stdout.strip() == "[]"


@pytest.mark.parametrize("threads", ["", "2"])
def test_linear_algebra_has_one_thread_unless_somebody_wants_more(threads, monkeypatch):
    """Threads only wait for each other with matrices as small as here: a third of the time of a run was that."""
    code = (
        "import os, sys\n"
        "from oblique_impact import __main__ as program, machine\n"
        "sys.argv[1:] = ['--version']\n"
        "try: program.main()\n"
        "except SystemExit: print(*(os.environ.get(name) for name in machine.THREADS))"
    )
    for name in THREADS:
        monkeypatch.delenv(name, raising=False)
    done = python(code, **dict.fromkeys(THREADS if threads else (), threads))
    assert done.stdout.splitlines()[-1].split() == [threads or "1"] * len(THREADS)


# --- --json


@pytest.fixture
def object_of(cli):
    """Call a command with --json: its object, while standard output holds nothing else."""

    def call(*words, code=0):
        found, out, err = cli(*words, "--json")
        assert found == code, err
        assert out.count("\n") == 1
        data = json.loads(out, parse_constant=lambda text: pytest.fail(f"{text} is no JSON"))
        assert isinstance(data, dict)
        return data

    return call


@pytest.fixture(scope="module")
def paper(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "paper"
    run("paper", "end_time=0.35", "solver.output_interval=5e-3").save(folder)
    return folder


def test_init_and_run_print_what_they_write(object_of, tmp_path):
    assert object_of("init", tmp_path / "a.toml") == {"file": str(tmp_path / "a.toml"), "from": "paper"}
    found = object_of("run", "paper", "--set", "end_time=0.02", "--out", tmp_path)
    assert found.pop("results") == str(tmp_path)
    assert found == json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))


def test_modes_prints_rad_per_second_and_hertz(object_of):
    found = object_of("modes", "spin-up", "--speeds", "0,6", "--count", "3")
    assert found == natural_frequencies(Scenario.builtin("spin-up"), [0.0, 6.0], 3).to_dict()
    assert found["flapwise_hz"][1][2] == pytest.approx(found["flapwise"][1][2] / (2.0 * math.pi), rel=1e-15)
    pinned = object_of("modes", "paper", "--speeds", "0,1,2")
    assert pinned["speeds"] == [0.0, 1.0, 2.0]
    assert all(row == sorted(row) for name in ("flapwise", "chordwise") for row in pinned[name])
    # hinged: the rigid entries are the spin rate flapwise and 0 chordwise
    assert [row[0] for row in pinned["flapwise"]] == [0.0, 1.0, 2.0]
    assert [row[0] for row in pinned["chordwise"]] == [0.0, 0.0, 0.0]


def test_what_modes_prints_has_its_units():
    found = Frequencies(np.array([0.0, 6.0]), np.array([[1.0], [2.0]]), np.array([[3.0], [4.0]]))
    lines = [" ".join(line.split()) for line in modes._lines(found)]
    assert lines[:3] == ["flapwise (rad/s, below in Hz)", "at 0 rad/s: 1.000000", "Hz: 0.159155"]
    assert lines[8:] == ["at 6 rad/s: 4.000000", "Hz: 0.636620"]


def test_validate_refine_and_sweep_print_what_they_write(object_of, tmp_path):
    checks = object_of("validate", "--only", "statics.own-weight", "--workers", "1", "--out", tmp_path / "v")
    assert {check["verdict"] for check in checks["checks"]} == {"pass"}
    short = ["--set", "end_time=0.02", "--workers", "1", "--out", tmp_path / "r"]
    found = object_of("refine", "paper", "--modes", "1,2,3", "--quantity", "theta@end", *short)
    written = json.loads((tmp_path / "r" / "results.json").read_text(encoding="utf-8"))
    assert found == written | {"results": str(tmp_path / "r")}
    text = (
        'scenario = "paper"\nquantities = ["energy_lost"]\nchanges = {end_time = 0.02}\n'
        'axes = [{key = "gravity", values = [9.0, 9.8]}]\n'
    )
    (tmp_path / "s.toml").write_text(text, encoding="utf-8")
    swept = object_of("sweep", tmp_path / "s.toml", "--workers", "1", "--out", tmp_path / "s")
    assert [row["gravity"] for row in swept["runs"]] == [9.0, 9.8]


def test_compare_render_and_export_print_what_they_write(object_of, paper, tmp_path):
    assert object_of("compare", paper, paper, "--out", tmp_path / "a.json")["largest_shift"] == 0.0
    assert object_of("render", paper, "--out", tmp_path / "a.png")["file"] == str(tmp_path / "a.png")
    assert object_of("export", paper, "--format", "pvd", "--out", tmp_path / "b", "--every", "20")["samples"] > 2
