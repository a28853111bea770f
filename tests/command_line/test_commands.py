"""The application finds and describes its commands."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from oblique_impact.command_line import application
from oblique_impact.machine import THREADS


@pytest.fixture
def cli(capfd):
    def call(*arguments):
        with pytest.raises(SystemExit) as exit_:
            application.main(list(arguments))
        return exit_.value.code, *capfd.readouterr()

    return call


def listed(shown: str) -> list[str]:
    return [line.split()[0] for line in shown.partition("Commands:")[2].splitlines() if line.startswith("  ")]


def test_the_help_page_lists_all_commands(cli):
    assert set(listed(cli("--help")[1])) == set(application.COMMANDS)


@pytest.mark.parametrize("wanted", ["run", "render"])
def test_a_command_is_made_alone(wanted):
    assert [command.name for command in application.application(wanted).registered_commands] == [wanted]


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
