"""Ctrl-C: gone long before the end; what is done is kept, in whole files; nothing else is left behind."""

from __future__ import annotations

import fcntl
import os
import pty
import signal
import subprocess
import sys
import termios
import time

import pytest

from oblique_impact import History
from tests.processes import COMMAND, cpu_time, files_in, interrupt, started, wait_for

FOUR = ["events.csv", "history.nc", "scenario.toml", "summary.json"]
#: longer than any of the moments
LONG = ("--set", "end_time=1000", "--set", "solver.output_interval=1e-2")


@pytest.fixture(scope="module")
def history(run, tmp_path_factory):
    return run("paper").save(tmp_path_factory.mktemp("paper"))


def check(process, said):
    assert process.returncode == 130
    lines = [line for line in said.splitlines() if not line.startswith("oblique-impact: compiling kernel ")]
    assert len(lines) == 1, said
    assert lines[0].startswith("oblique-impact: interrupted")


@pytest.mark.parametrize(
    ("number", "group"), [(signal.SIGINT, True), pytest.param(signal.SIGTERM, False, marks=pytest.mark.slow)]
)
def test_a_run_keeps_its_history(history, tmp_path, number, group):
    for seconds in (3.0, 6.0, 12.0):  # until it marches: that depends on the machine
        # what is computed has to be written within the second
        with started("run", "paper", "--out", tmp_path, *LONG) as process:
            wait_for(lambda pid=process.pid, least=seconds: cpu_time(pid) > least)
            said = interrupt(process, group=group, number=number)
        check(process, said)
        if "what was computed is kept" in said:
            break
    assert files_in(tmp_path) == FOUR
    history = History.load(tmp_path)
    assert history.summary["outcome"] == "interrupted"
    assert 0.0 < float(history["time"][-1]) < 1000.0


def test_a_run_whose_terminal_is_closed_keeps_its_history(history, tmp_path):
    """The terminal sends SIGHUP, and nothing can be written to it any more."""
    master, slave = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, "run", "paper", "--out", str(tmp_path), *LONG],
        **dict.fromkeys(("stdin", "stdout", "stderr"), slave),
        start_new_session=True,
        preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0),
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
    assert files_in(tmp_path) == FOUR
    assert History.load(tmp_path).summary["outcome"] == "interrupted"


def test_one_within_an_exec_is_an_exit_code_too(tmp_path):
    """Python would end itself by the signal, although somebody has taken the exception."""
    code = (
        "import sys\n"
        "from oblique_impact import __main__ as program\n"
        "from oblique_impact.command_line import application\n"
        "def interrupted(*arguments):\n"
        "    exec('raise KeyboardInterrupt')\n"
        "application._call = interrupted\n"
        "program.main()"
    )
    with started(command=(sys.executable, "-c", code)) as process:
        _, said = process.communicate(timeout=60.0)
    check(process, said)


#: long before they end
COMMANDS = {
    "validate": ("validate", "--workers", 2),
    "reproduce": ("reproduce", "--workers", 2),
    "refine": ("refine", "--modes", "2,4,8", "--set", "discretization.frame=mean-axis", *LONG, "--workers", 2),
    "refine alone": ("refine", "--modes", "2,3,4", *LONG, "--workers", 1),
    "sweep": ("sweep", "friction", "--workers", 2),
    "run": ("run", "paper", *LONG),
}


@pytest.mark.slow
@pytest.mark.parametrize("group", [False, True])
@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_at_many_moments(history, tmp_path, name, group):
    for number, delay in enumerate((0.3, 0.7, 1.2, 2.0, 3.5, 6.0)):
        out = tmp_path / str(number)
        with started(*COMMANDS[name], "--out", out) as process:
            time.sleep(delay)
            assert process.poll() is None
            said = interrupt(process, group=group)
        check(process, said)
        assert not [file for file in files_in(out) if ".part" in file or file.endswith(".lock")]
        if (out / "history.nc").exists():
            assert History.load(out).summary["outcome"] == "interrupted"


PICTURES = {
    "film": ("render", "a.mp4", ".part.mp4"),
    "gif": ("render", "a.gif", ".part.gif"),
    "pvd": ("export", "a.pvd", ""),
    "xdmf": ("export", "a.xdmf", ""),
}


@pytest.mark.slow
@pytest.mark.parametrize("group", [False, True])
@pytest.mark.parametrize("name", PICTURES)
def test_films_and_exports_leave_nothing(history, tmp_path, name, group):
    command, file, part = PICTURES[name]
    for number, delay in enumerate((0.0, 0.3, 1.0)):
        out = tmp_path / str(number)
        out.mkdir()
        with started(command, history, "--out", out / file) as process:
            wait_for(lambda folder=out, end=part: any(p.name.endswith(end) for p in folder.iterdir()))
            time.sleep(delay)
            said = interrupt(process, group=group)
        check(process, said)
        assert list(out.iterdir()) == []


@pytest.mark.slow
def test_while_the_kernels_are_compiled(tmp_path, monkeypatch):
    """The compiler lets nobody in while it optimizes a kernel: one line and 130, as soon as it has done so."""
    for number, delay in enumerate((0.5, 2.0, 4.0, 6.0)):
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / f"cache{number}"))
        out = tmp_path / str(number)
        with started("run", "paper", "--out", out) as process:
            wait_for(lambda folder=out: (folder / ".lock").exists())
            time.sleep(delay)
            assert process.poll() is None
            said = interrupt(process, group=False)
        assert process.returncode == 130
        assert "Traceback" not in said
        assert said.splitlines()[-1].startswith("oblique-impact: interrupted")
        assert files_in(out) in ([], FOUR)
