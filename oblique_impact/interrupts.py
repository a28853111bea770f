"""Defer Ctrl-C, and other requests to end, so that neither a run nor a file write stops half-way."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

#: requests to end: Ctrl-C, `kill`, and a terminal that is closed, which not every system tells
SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
_urgent: list[None] = []  # an entry for each block in which interrupts come at once


@contextmanager
def interrupts_at_once() -> Iterator[None]:
    """Let interrupts come at once in the block, which takes longer than a person waits, whatever holds them."""
    _urgent.append(None)
    try:
        yield
    finally:
        _urgent.pop()


@contextmanager
def hold_interrupts(patient: bool = False) -> Iterator[Callable[[], None]]:
    """Hold an interrupt that comes in the block until the function that this yields is called, or to the end.

    A second one comes at once, unless `patient`.  Handlers other than Python's own stay; Python's own, put back in
    the block by somebody, is replaced at the next call.
    """
    usual, held = signal.default_int_handler, list[int]()
    mine = SIGNALS if threading.current_thread() is threading.main_thread() else ()

    def hold(number: int, frame: FrameType | None) -> None:
        if _urgent or (held and not patient):
            held.clear()
            raise KeyboardInterrupt
        held.append(number)

    def replace(old: object, new: Callable[[int, FrameType | None], None]) -> None:
        for number in mine:
            if signal.getsignal(number) is old:
                signal.signal(number, new)

    def let_come() -> None:
        replace(usual, hold)
        if held:
            held.clear()
            raise KeyboardInterrupt

    let_come()
    try:
        yield let_come
    finally:
        replace(hold, usual)
        if held:
            raise KeyboardInterrupt
