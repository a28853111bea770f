"""Commands in a pseudo-terminal, and what a person sees there: an emulator (pyte) reads the screen."""

from __future__ import annotations

import fcntl
import os
import pty
import select
import signal
import struct
import subprocess
import termios
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import pyte

#: s; what takes longer hangs
PATIENCE = 600.0


class Terminal:
    """A terminal of `columns` by `rows` characters.

    `path` is the device that a program writes to.  `raw` is everything that was written, `screens` what was to be
    seen after each piece of it (a list of lines each, with those that have scrolled out above).
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
        self._stream.feed(data)
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
    """A command that was started in a terminal of its own, with a session of its own, as a shell does it."""

    def __init__(
        self,
        words: Sequence[str],
        folder: Path,
        *,
        columns: int = 80,
        environment: Mapping[str, str] | None = None,
        stdout: Path | None = None,
    ) -> None:
        self.terminal = Terminal(columns)
        end = self.terminal.end
        with open(stdout, "wb") if stdout else open(os.dup(end), "wb") as out:
            self.process = subprocess.Popen(
                list(words),
                cwd=folder,
                env={**os.environ, "TERM": "xterm-256color", **(environment or {})},
                stdin=end,
                stdout=out,
                stderr=end,
                start_new_session=True,
                preexec_fn=_take_terminal,
            )

    def wait_for(self, condition: Callable[[Terminal], object], seconds: float = PATIENCE) -> None:
        """Read until a condition holds for the terminal; it fails if the command ends before."""
        until = time.monotonic() + seconds
        while not condition(self.terminal):
            if not self.terminal.read(0.05):
                assert self.process.poll() is None, f"ended before:\n{self.terminal.text}"
                assert time.monotonic() < until, f"waited in vain:\n{self.terminal.text}"

    def finish(self, seconds: float = PATIENCE) -> Terminal:
        """Read to the end of the command."""
        until = time.monotonic() + seconds
        while self.process.poll() is None:
            self.terminal.read(0.05)
            assert time.monotonic() < until, f"does not end:\n{self.terminal.text}"
        while self.terminal.read(0.0):
            pass
        return self.terminal

    def close(self) -> None:
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        self.terminal.close()


def _take_terminal() -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
