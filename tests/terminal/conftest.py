"""Commands in terminals, started quickly: one process has imported everything, and one short run is shared."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from tests.terminal.emulator import Command, Real, Warm

ROOT = Path(__file__).parents[2]

if sys.platform == "win32":
    collect_ignore_glob = ["test_*"]


@pytest.fixture(scope="session")
def warm():
    """What starts programs in no time."""
    program = Warm(ROOT)
    yield program
    program.close()


@pytest.fixture
def start(warm, tmp_path):
    """Start a command in a terminal: `start(words, columns=80, real=False, ...)`; it is gone at the end."""
    started = []

    def call(words, *, real=False, **options):
        started.append(Command(Real() if real else warm, words, tmp_path, **options))
        return started[-1]

    yield call
    for command in started:
        command.close()


@pytest.fixture(scope="session")
def short_run(run, tmp_path_factory):
    """The folder of a short run of the paper's case with few samples."""
    folder = tmp_path_factory.mktemp("runs") / "paper"
    run("paper", "end_time=0.35", "solver.output_interval=5e-3").save(folder)
    return folder
