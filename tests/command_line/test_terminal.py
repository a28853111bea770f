"""Commands in a terminal: a bar while they run, nothing of it afterwards; what ends them keeps the results."""

from __future__ import annotations

import os
import re
import select
import signal
import sys
import time

import pytest

from oblique_impact import History
from tests.processes import files_in

if sys.platform == "win32":
    pytest.skip("there are no pseudo-terminals", allow_module_level=True)
import pty

LONG = ("run", "paper", "--set", "end_time=500", "--set", "solver.output_interval=0.1", "--out", "out")
SHOW_CURSOR, ERASE_LINE = b"\x1b[?25h", b"\x1b[2K"


class Terminal:
    """A command in a pseudo-terminal of 100 columns, and all that it has written."""

    def __init__(self, words, folder):
        self.written, self._until = b"", time.monotonic() + 120.0
        process, self._file = pty.fork()
        if process == 0:
            for number in (signal.SIGINT, signal.SIGHUP):  # a shell in the background, and `nohup`, ignore them
                signal.signal(number, signal.SIG_DFL)
            os.chdir(folder)
            os.environ.update({"TERM": "xterm-256color", "COLUMNS": "100"})
            os.execv(sys.executable, [sys.executable, "-m", "oblique_impact", *words])
        self._process = process

    def _read(self) -> bool:
        """Take what comes; False at the end."""
        assert time.monotonic() < self._until, self.written
        if select.select([self._file], [], [], 1.0)[0]:
            try:
                new = os.read(self._file, 65536)
            except OSError:  # what Linux says when the command has ended
                return False
            self.written += new
            return bool(new)
        return True

    def wait_for(self, pattern: bytes) -> None:
        """Read until something is written."""
        while not re.search(pattern, self.written):
            assert self._read(), self.written

    def press(self, key: bytes) -> None:
        """Type."""
        os.write(self._file, key)

    def kill(self) -> None:
        """Ask the command to end."""
        os.kill(self._process, signal.SIGTERM)

    def close(self) -> int:
        """Close the window; returns the exit code."""
        os.close(self._file)
        return os.waitstatus_to_exitcode(os.waitpid(self._process, 0)[1])

    def finish(self) -> int:
        """Read to the end; returns the exit code."""
        while self._read():
            pass
        return self.close()


def assert_keeps_its_history(folder):
    assert files_in(folder) == ["events.csv", "history.nc", "scenario.toml", "summary.json"]
    history = History.load(folder)
    assert history.summary["outcome"] == "interrupted"
    assert 0.0 < float(history["time"][-1]) < 500.0


def test_a_bar_shows_time_and_events_and_is_gone_at_the_end(tmp_path):
    terminal = Terminal([*LONG[:2], "--set", "end_time=1", "--out", "out"], tmp_path)
    assert terminal.finish() == 0
    assert re.search(rb"t = [\d.]+ of 1 s, \d+ events", terminal.written)
    *_, end = terminal.written.rpartition(ERASE_LINE)
    assert end.startswith(b"completed: t = 1 s")
    assert b"results: out" in end
    assert SHOW_CURSOR in terminal.written


@pytest.mark.parametrize("end", [lambda terminal: terminal.press(b"\x03"), Terminal.kill], ids=["ctrl-c", "kill"])
def test_what_ends_a_run_takes_the_bar_away_and_keeps_the_results(tmp_path, end):
    terminal = Terminal(LONG, tmp_path)
    terminal.wait_for(rb"of 500 s, [1-9]\d* events")
    end(terminal)
    assert terminal.finish() == 130
    *_, end = terminal.written.rpartition(SHOW_CURSOR)
    assert b"results: out" in end
    assert b"oblique-impact: interrupted" in end
    assert b"Traceback" not in terminal.written
    assert_keeps_its_history(tmp_path / "out")


def test_a_run_whose_terminal_is_closed_keeps_its_history(tmp_path):
    """Nothing can be written any more."""
    terminal = Terminal(LONG, tmp_path)
    terminal.wait_for(rb"of 500 s, [1-9]\d* events")
    assert terminal.close() == 130
    assert_keeps_its_history(tmp_path / "out")


def test_calls_that_count_show_how_many_are_done(run, tmp_path):
    run("paper", "end_time=0.05").save(tmp_path)
    terminal = Terminal(["export", "history.nc", "--every", "50", "--out", "beam.pvd"], tmp_path)
    assert terminal.finish() == 0
    assert re.search(rb"export.*\d+/[1-9]", terminal.written)
