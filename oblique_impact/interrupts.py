"""Ctrl-C and the polite request to end: the program stops within a second and keeps what is done.

An interrupt becomes a `KeyboardInterrupt` where Python can raise one.  Two things need more than that:

* a library that compiles or solves for seconds does not notice: a thread waits for `PATIENCE`, then ends the
  process;
* a run that has got somewhere is worth more than haste: after `keep`, an interrupt waits for the next `check`,
  which the run's own loop makes several times a second, and what follows is finished: the history is written.

A second interrupt ends the process at once.  However it ends, nothing half-written and no process is left behind.
"""

from __future__ import annotations

import multiprocessing
import os
import select
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

from oblique_impact.files import discard_unfinished

#: s; so long a library may take to notice
PATIENCE = 0.6
EXIT_CODE = 130


class _Stop:
    """What is known of interrupts; one for the process."""

    asked = False
    kept = False


_stop = _Stop()


def keep() -> None:
    """Declare that there is something to keep: from here on an interrupt waits for `check`."""
    _stop.kept = True


def asked() -> bool:
    """Whether an interrupt has come."""
    return _stop.asked


def check() -> None:
    """Raise KeyboardInterrupt if an interrupt has come."""
    if _stop.asked:
        raise KeyboardInterrupt


@contextmanager
def interruptible(say: Callable[[str], None]) -> Iterator[None]:
    """Handle interrupts while the block runs; `say` gets the last words of a process that leaves in haste.

    Signals that are ignored stay so, and threads other than the main one cannot set them.
    """
    _stop.asked = _stop.kept = False
    if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "set_wakeup_fd"):
        yield
        return

    def leave() -> None:
        for child in multiprocessing.active_children():
            child.kill()
        discard_unfinished()
        say("interrupted")
        sys.stderr.flush()
        os._exit(EXIT_CODE)

    def handle(number: int, frame: FrameType | None) -> None:
        if _stop.asked:
            leave()
        _stop.asked = True
        if not _stop.kept:
            raise KeyboardInterrupt

    def mute(unraisable: Any) -> None:
        if not isinstance(unraisable.exc_value, KeyboardInterrupt):
            hook(unraisable)

    hook, sys.unraisablehook = sys.unraisablehook, mute  # one that met a destructor; the thread will see to it
    caught = [n for n in (signal.SIGINT, signal.SIGTERM) if signal.getsignal(n) is not signal.SIG_IGN]
    before: dict[int, Any] = {number: signal.signal(number, handle) for number in caught}
    try:
        with _watch(frozenset(caught), leave):
            yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        sys.unraisablehook = hook


@contextmanager
def _watch(signals: frozenset[int], leave: Callable[[], None]) -> Iterator[None]:
    """Call `leave` from a thread if one of `signals` comes and the block does not end soon; see `keep`."""
    ours, theirs = os.pipe()
    for end in (ours, theirs):
        os.set_blocking(end, False)
    done = threading.Event()

    def wait() -> None:
        while not done.is_set():
            ready, _, _ = select.select([ours], [], [])
            arrived = os.read(ours, 64) if ready else b""
            if signals.intersection(arrived) and not done.wait(PATIENCE) and not _stop.kept:
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
