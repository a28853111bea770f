"""Ctrl-C and the polite request to end: the program stops within a second and keeps what is done.

Python would raise `KeyboardInterrupt` wherever it is: in the middle of an import or of a library that is not
made for it, or, while something compiles, seconds later.  So an interrupt only leaves a note.  Loops read it with
`check` and end in good order; where none does so for `PATIENCE`, a thread removes what is half-written, ends the
processes that were started, and this one.  While there is something to keep (`keep`, `keeping`) it waits for the
loop, and for what follows it: the results are written.  A second interrupt waits for nothing.
"""

from __future__ import annotations

import multiprocessing
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any, Protocol

#: s; so long a loop may take to notice
PATIENCE = 0.35
EXIT_CODE = 130
_TICK = 0.05


class Process(Protocol):
    """What is known of what ends with this process: one that was started, a bar on the terminal."""

    def kill(self) -> None:
        """End it."""


class _Stop:
    """What is known of interrupts; one for the process."""

    asked = False
    kept = False


_stop = _Stop()
_started: set[Process] = set()


def keep() -> None:
    """Declare that from here on there is something to keep."""
    _stop.kept = True


@contextmanager
def keeping() -> Iterator[None]:
    """Declare that there is something to keep while the block runs."""
    before, _stop.kept = _stop.kept, True
    try:
        yield
    finally:
        _stop.kept = before


@contextmanager
def ending_at_once() -> Iterator[None]:
    """Leave interrupts to the system while a library computes that lets no thread in, where nothing is to be kept.

    The process ends by the signal, without a word; a shell reports 130 all the same.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def check() -> None:
    """Raise KeyboardInterrupt if an interrupt has come; loops call it several times a second."""
    if _stop.asked:
        raise KeyboardInterrupt


@contextmanager
def ends_with_us(process: Process) -> Iterator[None]:
    """Name a process that is to end if this one ends while the block runs; `multiprocessing` knows its own."""
    _started.add(process)
    try:
        yield
    finally:
        _started.discard(process)


@contextmanager
def interruptible(say: Callable[[str], None]) -> Iterator[None]:
    """Handle interrupts while the block runs; `say` gets the last words of a process that leaves in haste.

    Signals that are ignored stay so.  Threads other than the main one cannot handle any.
    """
    _stop.asked = _stop.kept = False
    if threading.current_thread() is not threading.main_thread() or sys.platform == "win32":
        yield
        return

    def leave() -> None:
        end_started()
        say("interrupted")
        leave_now(EXIT_CODE)

    heard = False

    def handle(number: int, frame: FrameType | None) -> None:
        # not `asked`: the thread may have seen this very interrupt first
        nonlocal heard
        if heard:
            leave()
        heard = _stop.asked = True

    caught = [n for n in (signal.SIGINT, signal.SIGTERM) if signal.getsignal(n) is not signal.SIG_IGN]
    before: dict[int, Any] = {number: signal.signal(number, handle) for number in caught}
    try:
        with _watch(frozenset(caught), leave):
            yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        _stop.asked = _stop.kept = False  # it was this block's; loops outside of one are not to end


def end_started() -> None:
    """End all processes that were started."""
    for process in [*multiprocessing.active_children(), *_started]:
        process.kill()
    with suppress(Exception):
        # their semaphores; somebody would complain about them later
        multiprocessing.util._run_finalizers(0)  # type: ignore[attr-defined]


def leave_now(code: int) -> None:
    """End this process without unwinding; what is written to the standard streams gets out."""
    for stream in (sys.stdout, sys.stderr):
        with suppress(Exception):
            stream.flush()
    os._exit(code)


@contextmanager
def _watch(signals: frozenset[int], leave: Callable[[], None]) -> Iterator[None]:
    """Call `leave` from a thread if one of `signals` comes and the block does not end soon."""
    ours, theirs = os.pipe()
    for end in (ours, theirs):
        os.set_blocking(end, False)
    done = threading.Event()

    def wait() -> None:
        arrived = b""
        while not done.is_set() and not signals.intersection(arrived):
            select.select([ours], [], [])
            arrived = os.read(ours, 64)
        _stop.asked = _stop.asked or not done.is_set()  # the main thread may be busy elsewhere
        since = time.monotonic()
        while not done.wait(_TICK):
            if time.monotonic() - since >= PATIENCE and not _stop.kept:
                leave()

    thread = threading.Thread(target=wait, daemon=True)
    previous = signal.set_wakeup_fd(theirs, warn_on_full_buffer=False)
    thread.start()
    try:
        yield
    finally:
        done.set()
        signal.set_wakeup_fd(previous)
        with suppress(OSError):
            os.write(theirs, b"\0")
        thread.join()
        os.close(ours)
        os.close(theirs)
