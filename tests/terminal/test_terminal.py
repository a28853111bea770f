"""What happens while a command runs: a terminal gets another size, an interrupt comes, something is compiled."""

from __future__ import annotations

import io
import os
import re
import signal
import subprocess
import sys
from types import SimpleNamespace
from typing import NamedTuple

import pytest
from rich.console import Console

from oblique_impact.command_line.bars import Bar, counting_columns, digits_of, run_columns
from oblique_impact.kernels.compiling import announce, compilations
from oblique_impact.kernels.jit import kernel
from oblique_impact.validation.parallel import map_parallel
from tests.terminal import reading

LONG = [
    "oblique-impact",
    "run",
    "paper",
    "--set",
    "end_time=500",
    "--set",
    "solver.output_interval=0.1",
    "--out",
    "out",
]
SHORT = ["oblique-impact", "run", "paper", "--set", "end_time=0.33", "--out", "out"]


def shows_events(terminal):
    return re.search(r"of 500 s, [1-9]\d* events", terminal.text)


def test_a_terminal_that_is_resized(start):
    """The next bar fits; nothing is left of the last one, and the cursor is where it was."""
    command = start(LONG, columns=120, every_state=False)  # else one is under way while the size changes
    command.wait_for(shows_events)
    for columns in (80, 40, 100):
        command.terminal.resize(columns)
        seen = len(command.terminal.screens)
        form = reading.NARROW_RUN if columns < 60 else reading.RUN
        command.wait_for(
            lambda terminal, seen=seen, form=form: any(
                re.search(form, line) for screen in terminal.screens[seen + 2 :] for line in screen
            )
        )
    command.terminal.press(b"\x03")
    terminal = command.finish()
    reading.check_ended_well(command, "interrupted", 130)
    assert all(len(line) < 100 for line in terminal.lines)


def test_ctrl_c_takes_the_bar_away_and_keeps_the_results(start, tmp_path):
    command = start(LONG)
    command.wait_for(shows_events)
    command.terminal.press(b"\x03")
    terminal = command.finish()
    reading.check_ended_well(command, "interrupted", 130)
    assert "results: out" in terminal.text
    assert (tmp_path / "out" / "history.nc").exists()


@pytest.fixture
def nothing_compiled(tmp_path):
    return {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}


def test_what_is_compiled_is_said_meanwhile(start, nothing_compiled):
    """Before the march, in the bar and above it; an interrupt then ends the bar too."""
    command = start(SHORT, real=True, environment=nothing_compiled)
    command.wait_for(
        lambda terminal: (
            re.search(r"━ compiling kernel \d, the [a-z ]+ 0:00:0[1-9]", terminal.text)
            and terminal.text.startswith("oblique-impact: compiling kernel 1, the contact forces for a beam")
        )
    )
    command.terminal.press(b"\x03")
    terminal = command.finish()
    reading.check_ended_well(command, "interrupted", 130)
    assert not reading.saw(terminal, reading.RUN)
    reading.check_words_are_whole(terminal, 80)
    reading.check_bars_stay_in_one_line(terminal)


def test_what_is_compiled_in_the_dark_is_one_line(nothing_compiled, tmp_path):
    """Where standard error is no terminal, whatever the environment says."""
    process = subprocess.Popen(
        [sys.executable, "-m", "oblique_impact", *SHORT[1:]],
        cwd=tmp_path,
        env={**os.environ, **nothing_compiled, "FORCE_COLOR": "1", "TTY_COMPATIBLE": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stderr
    first = process.stderr.readline()
    process.send_signal(signal.SIGTERM)
    out, rest = process.communicate(timeout=60)
    assert (
        first == b"oblique-impact: compiling kernel 1, the contact forces for a beam in modes (once, up to 15 s)\n"
    )
    assert (out, rest) == (b"", b"oblique-impact: interrupted\n")


def test_a_piped_run_is_clean_even_if_colours_are_forced(cli, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    for name in ("FORCE_COLOR", "TTY_COMPATIBLE"):
        monkeypatch.setenv(name, "1")
    code, out, err = cli(*SHORT[1:])
    assert code == 0
    assert not re.search(r"[^\n -~]", out + err), (out, err)
    assert out.startswith("completed: t = 0.33 s")
    assert all(line.startswith("oblique-impact: compiling ") for line in err.splitlines()), err


def test_a_reader_that_has_gone_is_no_traceback():
    """As of `| head`: the command has done what it was asked to."""
    reader, writer = os.pipe()
    os.close(reader)
    words = ["modes", "spin-up", "--speeds", "0,1"]
    done = subprocess.run([sys.executable, "-m", "oblique_impact", *words], stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize("width", [40, 50, 59, 60, 70, 80, 99, 109, 110, 120, 200])
def test_the_longest_bars_fit_into_any_width(width):
    """The longest words that occur; the last column of the terminal stays free."""
    console = Console(file=io.StringIO(), width=width, color_system=None)
    text, short = "t = 0.123456 of 0.123456 s, 9999 events", "0.12346/0.33 s 999 events"
    bars = [
        (Bar(console, run_columns, state="STICK", text=text, short=short), 1.0),
        (Bar(console, counting_columns("export"), last="small-systems.bouncing-ball"), 10_000),
        (Bar(console, counting_columns("sweep", "runs"), last="run 99999"), 100_000),
    ]
    for bar, total in bars:
        bar.set_fields(total=total, completed=0.75 * total)
        console.print(bar.get_renderable())
    lines = console.file.getvalue().splitlines()
    assert len(lines) == len(bars), lines
    assert all(len(line.rstrip()) < width for line in lines), lines
    assert all(re.search(rf"{reading.TIME}", line) for line in lines), lines
    assert [str(total) in line for (_, total), line in zip(bars, lines, strict=True)] == [False, True, True], lines


@pytest.mark.parametrize(("end", "digits"), [(0.33, 5), (1.0, 4), (9.9, 4), (12.5, 3), (1e5, 0)])
def test_times_are_told_so_that_the_last_one_has_five_digits(end, digits):
    assert digits_of(end) == digits


@pytest.mark.parametrize(("each", "text"), [(2.5, "2.5 runs/s"), (0.5, "30.0 runs/min"), (None, "– runs/s")])
def test_slow_runs_are_counted_by_the_minute(each, text):
    task = SimpleNamespace(finished_speed=None, speed=each)
    _, _, _, rate, *_ = counting_columns("sweep", "runs")(120)
    assert rate.render(task).plain == text


class Packed(NamedTuple):
    """A system as kernels compile it; its type is that of its number."""

    number: float


def cube(system):
    return system.number**3


class Other(Packed):
    """Another class of packed systems: kernels are told apart by the class."""

    __slots__ = ()


def test_a_kernel_is_told_once_for_each_class_of_systems(tmp_path, monkeypatch):
    """That it was compiled for others does not help: the nodal beam has a compilation of its own."""
    monkeypatch.setattr("oblique_impact.kernels.jit.cache_folder", lambda: tmp_path)
    told = []
    with compilations(told.append):
        compiled = kernel("the cube")(cube)
        assert told == []
        for argument, kind, count in ((2, Packed, 1), (3, Packed, 1), (2.0, Other, 2), (3.0, Other, 2)):
            assert compiled(kind(argument)) == argument**3
            assert told == ["the cube"] * count
        again = kernel("the cube")(cube)  # from the cache
        assert again(Packed(2)) == 8
        assert told == ["the cube"] * 2
    kernel("another")(cube)(Packed(1j))
    assert len(told) == 2


def test_processes_tell_what_they_compile():
    told, parts = [], ["part 1", "part 2", "part 3"]
    with compilations(told.append):
        assert map_parallel(announce, parts, workers=2) == [None] * 3
    assert sorted(told) == parts


@pytest.mark.slow
@pytest.mark.parametrize(
    "words",
    [
        "validate --only small-systems --only springs --workers 2 --out out",
        "refine paper --elements 4,8,16 --set end_time=0.33 --quantity energy_final --workers 2 --out out",
        "sweep small.toml --workers 2 --out out",
        "run elastic-stop --set end_time=0.33 --out out",
    ],
    ids=lambda words: words.split()[0],
)
def test_all_that_is_compiled_is_said_once_above_the_bar(start, nothing_compiled, tmp_path, words):
    from tests.terminal.forms import SWEEP

    (tmp_path / "small.toml").write_text(SWEEP, encoding="utf-8")
    command = start(["oblique-impact", *words.split()], real=True, environment=nothing_compiled)
    terminal = command.finish()
    reading.check_ended_well(command, r"(report|results): out")
    reading.check_bars_stay_in_one_line(terminal)
    assert terminal.text.count("compiling kernel 1, the contact forces") == 1
