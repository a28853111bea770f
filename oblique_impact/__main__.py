"""The program `oblique-impact`; also ``python -m oblique_impact``."""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys
import warnings
from types import FrameType

from oblique_impact.interrupts import SIGNALS
from oblique_impact.machine import THREADS, collect_rarely

_INTERRUPTED = 130


def _leave(number: int, frame: FrameType | None) -> None:
    os.write(2, b"oblique-impact: interrupted\n")
    os._exit(_INTERRUPTED)


def _open_closed_streams() -> None:
    """Open the null device in place of closed standard streams: the next file would take their numbers."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w" if number else "r"))  # noqa: SIM115


def _end(code: list[int]) -> None:
    """End with a code, if there is one; else Python ends by the signal if that came within an `exec`."""
    if code:
        sys.stdout.flush()
        os._exit(code[0])


def main() -> None:
    """Run the command line; an interrupt is one line at any time, even while it is loaded or ends."""
    _open_closed_streams()
    handled = signal.getsignal(signal.SIGINT) is signal.default_int_handler  # not where a shell has it ignored
    if handled:
        signal.signal(signal.SIGINT, _leave)
    collect_rarely()
    atexit.register(_end, code := list[int]())  # the last one of all that are called at the end
    for name in THREADS:  # before anything loads NumPy
        os.environ.setdefault(name, "1")
    from oblique_impact.command_line.application import main as command_line

    # numbers that leave their range end a run with a named outcome
    warnings.simplefilter("ignore", RuntimeWarning)
    if handled:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in SIGNALS:  # any request to end is treated as Ctrl-C
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)
    try:
        command_line()
    except SystemExit as stop:
        if stop.code == _INTERRUPTED:
            code.append(_INTERRUPTED)
        raise
    finally:
        # an interrupt while the interpreter ends would print a traceback
        for number in SIGNALS:
            signal.signal(number, signal.SIG_IGN)
        # nor would the interpreter give back half a million objects one by one: that took half a second of two
        gc.freeze()


if __name__ == "__main__":
    main()
