"""Ctrl-C during a run comes where the run lets it: what is kept then is a state that the motion was in."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

from oblique_impact.kernels.compiling import is_preparing

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def hold_interrupts() -> Iterator[Callable[[], None]]:
    """Hold an interrupt that comes in the block until the function that this yields is called, or to the end.

    While kernels are compiled it comes at once, and so does a second one.  Handlers other than Python's own stay;
    Python's own, if it is put back in the block, is replaced at the next call.
    """
    usual, held = signal.default_int_handler, list[int]()
    mine = _SIGNALS if threading.current_thread() is threading.main_thread() else ()

    def hold(number: int, frame: FrameType | None) -> None:
        if held or is_preparing():
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
