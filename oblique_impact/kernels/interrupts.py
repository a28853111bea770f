"""Ctrl-C during a run comes between two calls of compiled code.

numba takes first-class functions out of arguments by a call of Python and does not ask whether it has failed: an
interrupt there would be lost, or worse.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class _Interrupt:
    """The handler of a run: what comes in compiled code is kept until its end."""

    came = False

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Keep it or raise KeyboardInterrupt."""
        while frame is not None and frame.f_code is not _in_compiled_code.__code__:
            frame = frame.f_back
        if frame is None:
            raise KeyboardInterrupt
        self.came = True

    def is_due(self) -> bool:
        """Whether one was kept for this thread, which is asked once."""
        due = self.came and threading.current_thread() is threading.main_thread()
        self.came = self.came and not due
        return due


_interrupt = _Interrupt()


@contextmanager
def interrupts_between_calls() -> Iterator[Callable[[], None]]:
    """Let what comes in the block come between two calls; handlers other than Python's own stay.

    Yields a function that does so again, for a caller that may have put Python's own handler back.
    """
    mine, usual = threading.current_thread() is threading.main_thread(), signal.default_int_handler

    def hold() -> None:
        for number in _SIGNALS if mine else ():
            if signal.getsignal(number) is usual:
                signal.signal(number, _interrupt)

    hold()
    try:
        yield hold
    finally:
        for number in _SIGNALS if mine else ():
            if signal.getsignal(number) is _interrupt:
                signal.signal(number, usual)


def call(entry: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    """Call compiled code."""
    try:
        return _in_compiled_code(entry, arguments)
    finally:
        if _interrupt.came and _interrupt.is_due():
            raise KeyboardInterrupt


def _in_compiled_code(entry: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
    return entry(*arguments)
