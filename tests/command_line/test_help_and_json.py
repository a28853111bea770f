"""Help in 80 columns, --version, completion, and --json: one object on standard output, nothing else."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
import sys
from importlib.metadata import version

import pytest

from oblique_impact import natural_frequencies
from oblique_impact.command_line.application import _command
from oblique_impact.scenario.scenario import Scenario, builtin_names

COMMANDS = sorted(_command().commands)


@pytest.fixture
def helped(cli, monkeypatch):
    """The lines of a help page in a terminal of 80 columns."""
    monkeypatch.setenv("COLUMNS", "80")
    return lambda *words: cli(*words, "--help")[1].splitlines()


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_help_cuts_no_word_and_shows_no_type_of_python(helped, command):
    lines = helped(*command.split())
    assert all(len(line) <= 80 for line in lines)
    text = "\n".join(lines)
    assert "..." not in text.replace("[ARGS]...", "").replace("}...", "").replace("(paper, ...)", "")
    assert not re.search(r"<|\bPath\b|\bstr\b|\bint\b|\bfloat\b|list\[", re.sub(r"<=?x<=?", "", text)), text
    assert "--version" in text
    if command:
        assert "--json" in text


def test_the_page_of_all_commands_tells_each_in_full(helped):
    page = " ".join(" ".join(helped()).split())
    for name, command in _command().commands.items():
        assert f" {name} {' '.join(command.help.partition(chr(10) * 2)[0].split())}" in page


@pytest.mark.parametrize("words", [["--version"], *([name, "--version"] for name in COMMANDS)])
def test_the_version_everywhere(cli, words):
    assert cli(*words) == (0, f"oblique-impact {version('oblique-impact')}\n", "")


def completed(words: str, count: int) -> set[str]:
    """What the program tells a bash that completes `words`."""
    asked = {"_OBLIQUE_IMPACT_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(count)}
    command = [sys.executable, "-m", "oblique_impact"]
    done = subprocess.run(command, env={**os.environ, **asked}, capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_what_a_shell_is_told():
    assert completed("oblique-impact re", 1) == {"render", "refine", "reproduce"}
    assert completed("oblique-impact run t", 2) == {"tapered"}
    assert completed("oblique-impact run paper --set contact.mu", 4) == {
        "contact.mu_static=",
        "contact.mu_kinetic=",
    }
    assert "--json" in completed("oblique-impact validate --", 2)


@pytest.mark.skipif(shutil.which("bash") is None, reason="there is no bash")
def test_the_completion_that_is_installed_works_in_bash(tmp_path):
    """The script for bash defines a function, which asks the program."""
    shown = {"_OBLIQUE_IMPACT_COMPLETE": "source_bash"}
    command = [sys.executable, "-m", "oblique_impact"]
    script = subprocess.run(
        command, env={**os.environ, **shown}, capture_output=True, text=True, check=True
    ).stdout
    (function,) = re.findall(r"^(_\w+)\(\) \{", script, re.MULTILINE)
    program = tmp_path / "oblique-impact"
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m oblique_impact "$@"\n', encoding="utf-8")
    program.chmod(0o755)
    asked = (
        f"COMP_WORDS=(oblique-impact run spin); COMP_CWORD=2; {function} oblique-impact; echo ${{COMPREPLY[*]}}"
    )
    done = subprocess.run(
        ["bash", "-c", f"{script}\n{asked}"],
        env={**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert (done.stdout.split(), done.stderr) == (["spin-up"], "")


@pytest.fixture
def object_of(cli):
    """Call a command with --json: its object, while standard output holds nothing else."""

    def call(*words, code=0):
        found, out, err = cli(*words, "--json")
        assert found == code, err
        assert out.count("\n") == 1
        assert "Traceback" not in err
        data = json.loads(out, parse_constant=lambda text: pytest.fail(f"{text} is no JSON"))
        assert isinstance(data, dict)
        return data

    return call


@pytest.fixture(scope="module")
def paper(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "paper"
    run("paper", "end_time=0.35", "solver.output_interval=5e-3").save(folder)
    return folder


def test_run(object_of, tmp_path):
    found = object_of("run", "paper", "--set", "end_time=0.02", "--out", tmp_path)
    assert found.pop("results") == str(tmp_path)
    assert found == json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    words = ["contact.mu_static=20", "contact.mu_kinetic=20", "discretization.modes=3", "end_time=0.33"]
    changes = [word for change in words for word in ("--set", change)]
    stopped = object_of(
        "run", "paper", "--set", "discretization.frame=mean-axis", *changes, "--out", tmp_path, code=1
    )
    assert stopped["outcome"] == "painleve"


def test_modes_in_rad_per_second_and_in_hertz(object_of, cli):
    found = object_of("modes", "spin-up", "--speeds", "0,6", "--count", "3")
    assert found == natural_frequencies(Scenario.builtin("spin-up"), [0.0, 6.0], 3).to_dict()
    assert found["flapwise_hz"][1][2] == pytest.approx(found["flapwise"][1][2] / (2.0 * math.pi), rel=1e-15)
    assert found["chordwise_hz"][0][0] == pytest.approx(found["chordwise"][0][0] / (2.0 * math.pi), rel=1e-15)
    lines = cli("modes", "spin-up", "--count", "2")[1].splitlines()
    assert lines[0] == "flapwise (rad/s, below in Hz)"
    rad, hertz = ([float(word) for word in line.rpartition(":")[2].split()] for line in lines[1:3])
    assert hertz == pytest.approx([value / (2.0 * math.pi) for value in rad], abs=1e-6)
    # of the clamped beam: 3.5160 sqrt(E I / (m L^4)), in Hz (Blevins, Formulas for natural frequency, table 8-1)
    first = 3.51601527 * math.sqrt(7e10 * 2e-7 / (3000.0 * 4e-4 * 10.0**4)) / (2.0 * math.pi)
    assert hertz[0] == pytest.approx(first, rel=1e-6)


def test_schema(object_of, tmp_path):
    found = object_of("schema", "--out", tmp_path / "a.json")
    assert found == json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))


def test_validate(object_of, tmp_path):
    found = object_of("validate", "--only", "statics.own-weight", "--workers", "1", "--out", tmp_path)
    assert {check["verdict"] for check in found["checks"]} == {"pass"}
    assert found["results"] == str(tmp_path)


def test_refine(object_of, tmp_path):
    short = ["--set", "end_time=0.02", "--workers", "1", "--out", tmp_path]
    found = object_of("refine", "paper", "--modes", "1,2,3", "--quantity", "theta@end", *short)
    written = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert found == written | {"results": str(tmp_path)}


def test_sweep(object_of, tmp_path):
    text = (
        'scenario = "paper"\nquantities = ["energy_lost"]\nchanges = {end_time = 0.02}\n'
        'axes = [{key = "gravity", values = [9.0, 9.8]}]\n'
    )
    (tmp_path / "s.toml").write_text(text, encoding="utf-8")
    found = object_of("sweep", tmp_path / "s.toml", "--workers", "1", "--out", tmp_path / "out")
    assert found["outcomes"] == {"completed": 2}
    assert [row["gravity"] for row in found["runs"]] == [9.0, 9.8]


def test_compare(object_of, paper, tmp_path):
    found = object_of("compare", paper, paper, "--out", tmp_path / "a.json")
    assert found["largest_shift"] == 0.0
    assert found == json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))


def test_render_and_export(object_of, paper, tmp_path):
    found = object_of("render", paper, "--out", tmp_path / "a.png", "--size", "320x180", "--bare")
    assert (found["file"], found["size"]) == (str(tmp_path / "a.png"), [320, 180])
    found = object_of("render", paper, "--out", tmp_path / "a.gif", "--size", "320x180", "--bare", "--frames", "2")
    assert (found["frames"], found["fps"]) == (2, 30)
    found = object_of("export", paper, "--out", tmp_path / "a.pvd", "--every", "20")
    assert (found["file"], found["format"]) == (str(tmp_path / "a.pvd"), "pvd")
    assert found["samples"] > 2


def test_every_command_is_tried():
    tried = {"scenarios", "init", "reproduce"}  # in tests/scenario/test_starting.py, tests/validation
    tried |= {"run", "modes", "schema", "validate", "refine", "sweep", "compare", "render", "export"}
    assert tried == set(COMMANDS)
    assert "paper" in builtin_names()
