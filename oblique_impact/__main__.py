"""The program `oblique-impact`; also ``python -m oblique_impact``."""

from __future__ import annotations

import os
import signal
import warnings
from types import FrameType


def _leave(number: int, frame: FrameType | None) -> None:
    os.write(2, b"oblique-impact: interrupted\n")
    os._exit(130)


def main() -> None:
    """Run the command line; an interrupt is one line at any time, even while it is loaded or ends."""
    heard = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # not where a shell has it ignored
    if heard:
        signal.signal(signal.SIGINT, _leave)
    from oblique_impact.command_line.application import main as command_line

    # of numbers that leave their range tell the results, by an outcome with a name
    warnings.simplefilter("ignore", RuntimeWarning)
    if heard:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:  # the polite request to end is treated as Ctrl-C
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        command_line()
    finally:
        # the interpreter's cleaning up is nothing to be interrupted
        signal.signal(signal.SIGINT, signal.SIG_IGN)


if __name__ == "__main__":
    main()
