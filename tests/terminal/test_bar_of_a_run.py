"""A run in a terminal, as a person starts it."""

from __future__ import annotations

import re
import sys

import pytest

from tests.terminal.emulator import Command

RUN = [sys.executable, "-m", "oblique_impact", "run", "paper", "--set", "end_time=0.33", "--out", "out"]


@pytest.fixture
def start(tmp_path):
    """Start a command in a terminal; it is gone at the end."""
    started = []

    def call(words, **options):
        started.append(Command(words, tmp_path, **options))
        return started[-1]

    yield call
    for command in started:
        command.close()


def test_a_run_shows_its_bar_and_its_results(start):
    command = start(RUN)
    terminal = command.finish()
    assert command.process.returncode == 0, terminal.text
    assert "Traceback" not in terminal.text
    bars = [line for screen in terminal.screens for line in screen if "of 0.33 s" in line]
    assert any(re.search(r"t = 0\.\d+ of 0\.33 s, \d+ events", line) for line in bars)
    assert "of 0.33 s" not in terminal.text  # it has gone at the end
    assert terminal.lines[0].startswith("completed: t = 0.33 s")
