"""The program `oblique-impact`; also ``python -m oblique_impact``."""

from __future__ import annotations

import gc
import os
import signal
import sys
import warnings

from oblique_impact.machine import THREADS, collect_rarely

_INTERRUPTED = 130


def main() -> None:
    """Run the command line; Ctrl-C, `kill` and a closed terminal end it with one line and exit code 130."""
    collect_rarely()
    for name in THREADS:  # before anything loads NumPy
        os.environ.setdefault(name, "1")
    for name in ("SIGTERM", "SIGHUP"):  # any request to end is treated as Ctrl-C
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None and signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, signal.default_int_handler)
    # overflow ends a run with a named outcome
    warnings.simplefilter("ignore", RuntimeWarning)
    try:
        from oblique_impact.command_line.application import main as command_line

        command_line()
    except KeyboardInterrupt:  # while the command line is loaded
        os.write(2, b"oblique-impact: interrupted\n")
        sys.exit(_INTERRUPTED)
    finally:
        # freeing objects one by one would take half a second
        gc.freeze()


if __name__ == "__main__":
    main()
