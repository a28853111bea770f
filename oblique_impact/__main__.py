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
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)
    from oblique_impact.command_line.cli import main as command_line
    from oblique_impact.command_line.interrupts import EXIT_CODE, leave_now

    # of numbers that leave their range tell the results, by an outcome with a name
    warnings.simplefilter("ignore", RuntimeWarning)
    try:
        command_line()
    except SystemExit as end:
        if end.code == EXIT_CODE:
            leave_now(EXIT_CODE)  # the interpreter's cleaning up takes its time
        raise
    finally:
        # ... and is nothing to be interrupted
        signal.signal(signal.SIGINT, signal.SIG_IGN)


if __name__ == "__main__":
    main()
