"""What Ctrl-C does around compiled code, which does not know of Python's exceptions."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from types import FrameType

from oblique_impact.command_line.printing import print_note
from oblique_impact.errors import Outcome

#: s; an interrupt that comes at the wrong place is tried again after so long, before the next kernel is called
_AGAIN = 1e-5
#: where numba looks up the class of a named tuple, and the constructor
_CALLED_BY_KERNELS = (os.path.join("numba", "core", "serialize.py"), "<string>")


def raise_interrupt(number: int, frame: FrameType | None) -> None:
    """Handle a signal by KeyboardInterrupt, a moment later where numba makes the named tuple of a kernel.

    It looks the class up and calls its constructor, which is text that Python executes, and does not ask whether
    that has failed: an exception there is a segmentation fault.
    """
    place = frame
    while place is not None and place.f_code is raise_interrupt.__code__:  # the second try came during the first
        place = place.f_back
    inside = place is not None and place.f_code.co_filename.endswith(_CALLED_BY_KERNELS)
    if inside and hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, raise_interrupt)
        signal.setitimer(signal.ITIMER_REAL, _AGAIN)
        return
    signal.default_int_handler(number, frame)


@contextmanager
def ending_at_once(*stacks: ExitStack) -> Iterator[ExitStack]:
    """Let an interrupt close the stacks and end the process, in the block or until the yielded one is closed.

    The compiler calls back into Python too, and an exception that is raised there is lost.
    """

    def leave(number: int, frame: FrameType | None) -> None:
        for stack in stacks:
            stack.close()
        print_note("interrupted")
        os._exit(Outcome.INTERRUPTED.exit_code)

    with ExitStack() as restore:
        for number in (signal.SIGINT, signal.SIGTERM):
            # not where they are ignored, nor in a program that has its own handler
            if signal.getsignal(number) is raise_interrupt:
                restore.callback(signal.signal, number, signal.signal(number, leave))
        yield restore
