"""The frames of a film in order, drawn by this process and by others that it starts beside itself.

The others are plain programs that import nothing of the script that calls, and they leave with this process.  They
put their frames into a file that all map.  What one of them cannot do, this process does.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import ExitStack, suppress
from mmap import mmap
from multiprocessing.connection import Connection, Pipe, wait

from oblique_impact.machine import cores
from oblique_impact.renders.frame import Composer
from oblique_impact.renders.timeline import Timeline

#: pixels of a film, all frames together, from which on a second process saves more than it takes to start
WORTHWHILE = 100_000_000
#: processes that draw, at most: the encoder has to keep up with them
_MOST = 4
#: frames that a process is asked for at a time, and that may be drawn before the first of them is taken
_ASKED, _DRAWN = 2, 12
_PROGRAM = """
import sys
from multiprocessing.connection import Connection
connection = Connection(int(sys.argv[1]))
sys.path[:] = connection.recv()
from oblique_impact.renders.drawing import serve
serve(connection, int(sys.argv[2]))
"""


def frames_of(composer: Composer, timeline: Timeline) -> Generator[bytes, None, None]:
    """Yield the frames of a film, rows of red, green and blue; close it to end the processes that it starts."""
    width, height = composer.style.size
    count, size = timeline.times.size, 3 * width * height
    draw = _drawing(composer, timeline)
    beside = min(cores(), _MOST) - 1 if os.name == "posix" and count * width * height >= WORTHWHILE else 0
    with ExitStack() as stack:
        helpers: list[_Helper] = []
        if beside:
            file = stack.enter_context(tempfile.TemporaryFile())
            file.truncate(_DRAWN * size)
            memory = stack.enter_context(mmap(file.fileno(), 0))
            for _ in range(beside):
                helpers.append(_Helper(composer, timeline, file.fileno(), memory))
                stack.callback(helpers[-1].end)
        yield from in_order(draw, count, helpers)


def in_order(draw: Callable[[int], bytes], count: int, helpers: Sequence[_Helper]) -> Iterator[bytes]:
    """Yield frames 0 to count - 1; `draw` draws those for which no helper has time."""
    left, done = deque(range(count)), dict[int, bytes]()
    for number in range(count):
        while number not in done:
            for helper in helpers:
                done |= helper.finished()
                if not helper.alive:  # what it had is drawn by others
                    left.extendleft(sorted(helper.asked, reverse=True))
                    helper.asked.clear()
                while helper.free and left and left[0] < number + _DRAWN:
                    helper.ask(left.popleft())
            if number in done:
                break
            if left and left[0] < number + _DRAWN:
                own = left.popleft()
                done[own] = draw(own)
            else:
                wait([helper.connection for helper in helpers if helper.alive])
        yield done.pop(number)


class _Helper:
    """A process that draws frames into a file of `_DRAWN` frames, which is mapped by it and here."""

    def __init__(self, composer: Composer, timeline: Timeline, file: int, memory: mmap) -> None:
        self.asked: deque[int] = deque()
        self.alive, self._ready, self._memory = True, False, memory
        self.connection, theirs = Pipe()
        with theirs:
            numbers = (theirs.fileno(), file)
            self._process = subprocess.Popen(
                [sys.executable, "-c", _PROGRAM, *map(str, numbers)],
                pass_fds=numbers,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,  # Ctrl-C is for this process, which ends the others
            )
        self._send(sys.path)
        self._send((composer.story, timeline, composer.charts))

    @property
    def free(self) -> bool:
        """Whether it can be asked for another frame."""
        return self.alive and self._ready and len(self.asked) < _ASKED

    def ask(self, number: int) -> None:
        """Ask for a frame."""
        self.asked.append(number)
        self._send(number)

    def finished(self) -> dict[int, bytes]:
        """Return the frames that it has drawn since it was asked last."""
        found = {}
        with suppress(OSError):
            while self.alive and self.connection.poll():
                try:
                    number = self.connection.recv()
                except EOFError:
                    self.alive = False
                    break
                self._ready = True
                if number is not None:
                    self.asked.remove(number)
                    size = len(self._memory) // _DRAWN
                    found[number] = self._memory[number % _DRAWN * size : (number % _DRAWN + 1) * size]
            return found
        self.alive = False
        return found

    def _send(self, what: object) -> None:
        try:
            self.connection.send(what)
        except OSError:
            self.alive = False

    def end(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait()
        self.connection.close()


def serve(connection: Connection, file: int) -> None:
    """Draw frames for another process as long as it is there: the program of a process beside it."""
    story, timeline, charts = connection.recv()
    draw = _drawing(Composer(story, timeline, charts=charts), timeline)
    memory = mmap(file, 0)
    size = len(memory) // _DRAWN
    number = None  # it is ready
    with suppress(EOFError, ConnectionError):
        while True:
            connection.send(number)
            number = connection.recv()
            memory[number % _DRAWN * size : (number % _DRAWN + 1) * size] = draw(number)


def _drawing(composer: Composer, timeline: Timeline) -> Callable[[int], bytes]:
    """Return the function that draws the frame of a number."""
    times, rates = timeline.times, timeline.rates
    return lambda number: composer.draw(float(times[number]), float(rates[number])).tobytes()
