"""The program `oblique-impact`; also ``python -m oblique_impact``."""

from __future__ import annotations

import atexit
import os
import signal
import sys
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
    from oblique_impact.command_line.interrupts import raise_interrupt

    # of numbers that leave their range tell the results, by an outcome with a name
    warnings.simplefilter("ignore", RuntimeWarning)
    if heard:
        signal.signal(signal.SIGINT, raise_interrupt)
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:  # the polite request to end is treated as Ctrl-C
        signal.signal(signal.SIGTERM, raise_interrupt)
    try:
        command_line()
    except SystemExit as end:
        if end.code == 130:
            # Python would end itself by the signal, in place of this code, if it came where text was executed
            atexit._run_exitfuncs()  # multiprocessing gives its semaphores back
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(130)
        raise
    finally:
        # the interpreter's cleaning up is nothing to be interrupted
        signal.signal(signal.SIGINT, signal.SIG_IGN)


if __name__ == "__main__":
    main()
