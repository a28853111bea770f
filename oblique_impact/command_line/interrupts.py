"""What Ctrl-C does around compiled code, in which Python's exceptions are lost."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from types import FrameType

from oblique_impact.command_line.printing import print_note
from oblique_impact.errors import Outcome


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
            # not where they are ignored, nor in a program that handles them itself
            if signal.getsignal(number) is signal.default_int_handler:
                restore.callback(signal.signal, number, signal.signal(number, leave))
        yield restore
