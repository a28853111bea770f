"""Ctrl-C, `kill` and a closed terminal: what is done is kept, in whole files; nothing else is left behind."""

from __future__ import annotations

import fcntl
import os
import pty
import signal
import subprocess
import termios

from oblique_impact import History
from tests.processes import COMMAND, cpu_time, files_in, interrupt, started, wait_for

FOUR = ["events.csv", "history.nc", "scenario.toml", "summary.json"]
LONG = ("--set", "end_time=1000", "--set", "solver.output_interval=1e-2")


def assert_keeps_its_history(folder):
    assert files_in(folder) == FOUR
    history = History.load(folder)
    assert history.summary["outcome"] == "interrupted"
    assert 0.0 < float(history["time"][-1]) < 1000.0


def test_a_run_that_is_asked_to_end_keeps_its_history(run, tmp_path):
    """By SIGTERM; SIGINT comes from the terminal's tests."""
    run("paper")  # the kernels are compiled
    for seconds in (3.0, 6.0, 12.0, 24.0, 48.0):  # until it marches: that depends on the machine
        with started("run", "paper", "--out", tmp_path, *LONG) as process:
            wait_for(lambda pid=process.pid, least=seconds: cpu_time(pid) > least)
            said = interrupt(process, group=True, number=signal.SIGTERM)
        assert process.returncode == 130
        assert said.splitlines()[-1].startswith("oblique-impact: interrupted")
        if "what was computed is kept" in said and float(History.load(tmp_path)["time"][-1]) > 0.0:
            break
    assert_keeps_its_history(tmp_path)


def take_terminal() -> None:
    """Make standard input the controlling terminal, and hear of its end: `nohup` lets programs ignore that."""
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def test_a_run_whose_terminal_is_closed_keeps_its_history(run, tmp_path):
    """The terminal sends SIGHUP, and nothing can be written to it any more."""
    run("paper")
    master, slave = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, "run", "paper", "--out", str(tmp_path), *LONG],
        **dict.fromkeys(("stdin", "stdout", "stderr"), slave),
        start_new_session=True,
        preexec_fn=take_terminal,
    )
    os.close(slave)
    try:
        shown = b""
        while b"events" not in shown:  # the bar of a run that marches
            shown += os.read(master, 10_000)
        os.close(master)
        assert process.wait(60.0) == 130
    finally:
        process.kill()
        process.wait()
    assert_keeps_its_history(tmp_path)
