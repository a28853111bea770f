"""Commands in a pseudo-terminal, and what a person sees there: an emulator (pyte) reads the screen."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol

import pyte

#: s; what takes longer hangs
PATIENCE = 600.0
_BEFORE_A_LINE_IS_ERASED = re.compile(rb"(?=\x1b\[2K)")
#: what would tell a program about the terminal in which the tests run
_TELL_OF_TERMINALS = {"TERM", "COLUMNS", "LINES", "NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE"}


class Terminal:
    """A terminal of `columns` by `rows` characters.

    `path` is the device that a program writes to.  `raw` is everything that was written, `screens` what was to be
    seen after each piece of it and before a line was erased (a list of lines each, with those that have scrolled
    out above).
    """

    def __init__(self, columns: int = 80, rows: int = 24) -> None:
        self._ours, self.end = pty.openpty()
        self.path = os.ttyname(self.end)
        self.raw = b""
        self.screens: list[list[str]] = []
        self._screen = pyte.HistoryScreen(columns, rows, history=10_000)
        self._stream = pyte.ByteStream(self._screen)
        self.resize(columns, rows)

    def resize(self, columns: int, rows: int = 24) -> None:
        """Give the window another size; the kernel tells the programs in it."""
        fcntl.ioctl(self._ours, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        self._screen.resize(rows, columns)

    def press(self, keys: bytes) -> None:
        """Type keys."""
        os.write(self._ours, keys)

    def read(self, seconds: float) -> bool:
        """Take what is written within a time, if anything; returns whether there was something."""
        if not select.select([self._ours], [], [], seconds)[0]:
            return False
        data = os.read(self._ours, 65536)
        self.raw += data
        for piece in re.split(_BEFORE_A_LINE_IS_ERASED, data):  # a slow reader gets a bar and its end in one
            self._stream.feed(piece)
            self.screens.append(self.lines)
        return True

    @property
    def lines(self) -> list[str]:
        """What stands there now, blank lines at the end left out."""
        above = ["".join(line[x].data for x in range(self._screen.columns)) for line in self._screen.history.top]
        lines = [line.rstrip() for line in (*above, *self._screen.display)]
        while lines and not lines[-1]:
            lines.pop()
        return lines

    @property
    def text(self) -> str:
        return "\n".join(self.lines)

    @property
    def cursor_hidden(self) -> bool:
        return self._screen.cursor.hidden

    @property
    def column(self) -> int:
        """Where the cursor stands, from 0."""
        return self._screen.cursor.x

    def close(self) -> None:
        for end in (self._ours, self.end):
            with suppress(OSError):
                os.close(end)


class Command:
    """A command in a terminal of its own, with a session of its own, as a shell starts it.

    `program` knows how to start it, see `Program`; `environment` is added to that of a plain terminal.  A bar is
    drawn in `every_state`, or ten times a second as always.
    """

    def __init__(
        self,
        program: Program,
        words: Sequence[str],
        folder: Path,
        *,
        columns: int = 80,
        environment: Mapping[str, str] | None = None,
        stdout: Path | None = None,
        prepare: str = "",
        every_state: bool = True,
    ) -> None:
        self.terminal = Terminal(columns)
        self._program = program
        plain = {name: value for name, value in os.environ.items() if name not in _TELL_OF_TERMINALS}
        self.pid = program.start(
            {
                "words": list(map(str, words)),
                "folder": str(folder),
                "terminal": self.terminal.path,
                "stdout": str(stdout or ""),
                "environment": {**plain, "TERM": "xterm-256color", **(environment or {})},
                "prepare": prepare,
                "every_state": every_state,
            }
        )
        self.code: int | None = None

    @property
    def ended(self) -> bool:
        if self.code is None:
            self.code = self._program.poll()
        return self.code is not None

    def wait_for(self, condition: Callable[[Terminal], object], seconds: float = PATIENCE) -> None:
        """Read until a condition holds for the terminal; it fails if the command ends before."""
        until = time.monotonic() + seconds
        while not condition(self.terminal):
            if not self.terminal.read(0.02):
                assert not self.ended, f"ended before:\n{self.terminal.text}"
                assert time.monotonic() < until, f"waited in vain:\n{self.terminal.text}"

    def finish(self, seconds: float = PATIENCE) -> Terminal:
        """Read to the end of the command."""
        until = time.monotonic() + seconds
        while not self.ended:
            self.terminal.read(0.02)
            assert time.monotonic() < until, f"does not end:\n{self.terminal.text}"
        while self.terminal.read(0.0):
            pass
        return self.terminal

    def close(self) -> None:
        if not self.ended:
            with suppress(ProcessLookupError):
                os.killpg(self.pid, signal.SIGKILL)
            while not self.ended:
                self.terminal.read(0.02)
        self.terminal.close()


class Program(Protocol):
    """A way to start a command, one at a time: in a session and with a terminal of its own."""

    def start(self, order: dict[str, Any]) -> int:
        """Start it and return its number."""

    def poll(self) -> int | None:
        """Return its exit code if it has ended."""


class Real:
    """Starts a command as it is."""

    def start(self, order: dict[str, Any]) -> int:
        program, *arguments = order["words"]
        command = [program] if program.endswith(".py") else ["-m", program.replace("-", "_")]
        end = os.open(order["terminal"], os.O_RDWR | os.O_NOCTTY)
        out = os.open(order["stdout"], os.O_WRONLY | os.O_CREAT) if order["stdout"] else os.dup(end)
        self._process = subprocess.Popen(
            [sys.executable, *command, *arguments],
            cwd=order["folder"],
            env=order["environment"],
            stdin=end,
            stdout=out,
            stderr=end,
            start_new_session=True,
            preexec_fn=_take_terminal,
        )
        os.close(end)
        os.close(out)
        return self._process.pid

    def poll(self) -> int | None:
        return self._process.poll()


class Warm:
    """Starts a command in a process that has everything imported already, see `tests.terminal.warm`."""

    def __init__(self, root: Path) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.terminal.warm"],
            cwd=root,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            preexec_fn=_hear_interrupts,
        )

    def start(self, order: dict[str, Any]) -> int:
        assert self._process.stdin
        self._process.stdin.write(json.dumps(order) + "\n")
        self._process.stdin.flush()
        return self._answer()

    def poll(self) -> int | None:
        return self._answer() if select.select([self._process.stdout], [], [], 0.0)[0] else None

    def _answer(self) -> int:
        assert self._process.stdout
        return int(self._process.stdout.readline())

    def close(self) -> None:
        self._process.kill()
        self._process.communicate()


def _hear_interrupts() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # a shell ignores them in the background, and that is inherited


def _take_terminal() -> None:
    _hear_interrupts()
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
