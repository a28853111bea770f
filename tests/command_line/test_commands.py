"""Commands of other packages are found by their entry points; a broken or missing one harms no other."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.metadata import EntryPoint

import pytest

from oblique_impact.command_line import application, modes
from oblique_impact.installed import installed
from oblique_impact.machine import THREADS

GROUP = "oblique_impact.commands"


@pytest.fixture
def cli(capfd, monkeypatch):
    def call(points, *arguments):
        found = {name: EntryPoint(name, value, GROUP) for name, value in points.items()}
        for module in (application, modes):
            monkeypatch.setattr(module, "installed", lambda kind: found if kind == "commands" else {})
        with pytest.raises(SystemExit) as exit_:
            application.main(list(arguments))
        return exit_.value.code, *capfd.readouterr()

    return call


def listed(shown: str) -> list[str]:
    return [line.split()[0] for line in shown.partition("Commands:")[2].splitlines() if line.startswith("  ")]


def test_the_order_of_the_help_page():
    found = [command.name for command in application.application().registered_commands]
    assert found == [
        *("scenarios", "init", "run", "render", "modes", "refine", "compare", "sweep", "export"),
        *("validate", "reproduce", "schema"),
    ]
    assert set(found) == {"run", "modes", "schema", "init", "scenarios", *installed("commands")}


@pytest.mark.parametrize("wanted", ["run", "render"])
def test_a_command_is_made_alone(wanted, monkeypatch):
    loaded = []
    monkeypatch.setattr(application, "_load", lambda point: loaded.append(point.name) or (lambda: None))
    assert [command.name for command in application.application(wanted).registered_commands] == [wanted]
    assert loaded == [wanted] * (wanted in installed("commands"))


def test_without_other_packages_the_commands_of_the_core_remain(cli):
    code, shown, _ = cli({}, "--help")
    assert code == 0
    assert "run" in shown
    assert "validate" not in shown
    code, _, said = cli({}, "validate")
    assert code == 2
    assert said == "oblique-impact: No such command 'validate'.\n"


@pytest.mark.parametrize(
    "value", ["nowhere.commands:render", "renders.commands:nothing", "tests.command_line.broken:render"]
)
def test_a_broken_package_is_one_line_and_the_others_work(cli, value):
    points = {"render": value, "export": "renders.commands:export"}
    code, shown, said = cli(points, "--help")
    assert (code, said) == (0, "")
    assert "Not available" in shown
    assert "Write a history" in shown
    code, shown, said = cli(points, "render", "out/paper", "--out", "film.mp4")
    assert (code, shown) == (2, "")
    assert said.startswith(f"oblique-impact: render ({value}): cannot be loaded: ")
    assert said.count("\n") == 1
    assert cli(points, "modes", "--count", "2")[0] == 0


def test_other_packages_do_not_replace_the_commands_of_the_core(cli):
    assert "Simulate a scenario" in cli({"run": "renders.commands:export"}, "run", "--help")[1]


def test_modes_without_a_package_that_draws(cli, tmp_path):
    code, shown, said = cli({}, "modes", "--out", str(tmp_path / "a.png"))
    assert (code, shown) == (2, "")
    assert "no installed package draws Campbell diagrams" in said
    assert list(tmp_path.iterdir()) == []


def test_a_command_neither_looks_for_garbage_nor_clears_away_what_it_imported():
    """Both together took a fifth of the time of a run."""
    code = (
        "import gc, sys\n"
        "from oblique_impact import __main__ as program\n"
        "sys.argv[1:] = ['--version']\n"
        "try: program.main()\n"
        "except SystemExit: print(gc.get_threshold()[0], gc.get_freeze_count(), len(gc.get_objects()))"
    )
    shown = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    threshold, frozen, loose = map(int, shown.splitlines()[-1].split())
    assert threshold >= 1_000_000
    assert frozen > 100 * loose


@pytest.mark.parametrize("threads", ["", "2"])
def test_linear_algebra_has_one_thread_unless_somebody_wants_more(threads):
    """Threads only wait for each other with matrices as small as here: a third of the time of a run was that."""
    code = (
        "import os, sys\n"
        "from oblique_impact import __main__ as program, machine\n"
        "sys.argv[1:] = ['--version']\n"
        "try: program.main()\n"
        "except SystemExit: print(*(os.environ.get(name) for name in machine.THREADS))"
    )
    wanted = {**os.environ, **dict.fromkeys(THREADS, threads)}
    given = {name: value for name, value in wanted.items() if value}
    shown = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=given
    ).stdout
    assert shown.splitlines()[-1].split() == [threads or "1"] * len(THREADS)
