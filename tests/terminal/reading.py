"""What a screen should show: bars, results, and nothing that is left behind."""

from __future__ import annotations

import re

from tests.terminal.emulator import Command, Terminal

BLOCKS = "━╸╺"
TIME = r"(\d+:\d\d:\d\d|-:--:--)"
LEFT = rf"{TIME} left"
RUN = rf"^ ?(FREE|SLIP|STICK) [{BLOCKS}]+ +t = \d+\.\d+ of [\d.]+ s, \d+ events {LEFT}$"
NARROW_RUN = rf"^ ?(FREE|SLIP|STICK) \d+\.\d+/[\d.]+ s \d+ events {TIME}$"
# without colours the part of the bar that is still to do is blank
COUNT = rf"^[\w -]+ [{BLOCKS}]+ +(\d+)/\d+ ([\d.–]+ runs/(s|min) )?{LEFT}( |$)"
NARROW_COUNT = rf"^[\w -]+ \d+/\d+ {TIME}$"
#: nobody knows how much there is to do: blocks run through the bar, without colours beside blanks
BUSY = rf"^[\w ]+ [{BLOCKS} ]+ +\d:\d\d:\d\d$"

#: the end of what a command says
RESULTS = {
    "run": "results: out/",
    "modes": r"Campbell diagram: [\w/]*campbell\.png",
    "validate": r"\d+ checks, \d+ measurements: all pass; report: out/\w+/report\.html",
    "refine": r"report: out/[\w-]+/report\.html",
    "sweep": "results: out/friction",
    "reproduce": r"\d+ claims: .*; report: out/reproduce/report\.html",
    "compare": r"report: [\w/]+\.html",
    "render": "(picture|written): ",
    "export": r"(xdmf|pvd|csv): [\w/]+\.(xdmf|pvd|csv)\s+read by ",
    "init": r"next: oblique-impact run [\w/]+\.toml",
    "scenarios": r"with a tip mass strikes a rigid slope",
    "schema": r"schema: oblique-impact\.json",
}


def all_lines(terminal: Terminal) -> set[str]:
    """Every line that was to be seen at any moment."""
    return {line for screen in terminal.screens for line in screen}


def saw(terminal: Terminal, form: str) -> bool:
    return any(re.search(form, line) for line in all_lines(terminal))


def check_bars_stay_in_one_line(terminal: Terminal) -> None:
    """The line with the bar is the last on the screen: nothing of it went into another one."""
    for screen in terminal.screens:
        drawn = [number for number, line in enumerate(screen) if any(block in line for block in BLOCKS)]
        assert drawn in ([], [len(screen) - 1]), "\n".join(screen)


def check_ended_well(command: Command, results: str, code: int = 0) -> None:
    """The command did what it should, and left nothing but its words, unbroken."""
    terminal = command.terminal
    assert command.code == code, terminal.text
    assert "Traceback" not in terminal.text
    assert "\ufffd" not in terminal.text
    assert not terminal.cursor_hidden
    assert b"\x1b[?25l" not in terminal.raw.rpartition(b"\x1b[?25h")[2]
    assert terminal.column == 0, "the prompt of the shell would not begin a line"
    assert not any(block in terminal.text for block in BLOCKS), terminal.text
    assert " left" not in terminal.text
    end = terminal.lines[-6:]
    assert any(re.search(results, space.join(line.strip() for line in end)) for space in (" ", "")), terminal.text
    assert "" not in terminal.lines, "an empty line is left of a bar"
    notes = [line for line in terminal.lines if line.startswith("oblique-impact: ")]
    assert len(notes) == len(set(notes)), "a note is repeated"


def check_words_are_whole(terminal: Terminal, columns: int) -> None:
    """No line was broken by the terminal, at its last column; but a note is one line of any length."""
    broken = [line for line in terminal.lines if len(line) >= columns]
    assert all(line.startswith("oblique-impact: ") for line in broken), terminal.text
