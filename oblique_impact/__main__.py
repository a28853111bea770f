"""The program `oblique-impact`; also ``python -m oblique_impact``."""

from __future__ import annotations

import os
import signal
from types import FrameType


def _leave(number: int, frame: FrameType | None) -> None:
    os.write(2, b"oblique-impact: interrupted\n")
    os._exit(130)


def main() -> None:
    """Run the command line; an interrupt is one line at any time, even while it is loaded or ends."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)
    from oblique_impact.cli import main as command_line

    try:
        command_line()
    finally:
        # the rest is the interpreter's cleaning up
        signal.signal(signal.SIGINT, signal.SIG_IGN)


if __name__ == "__main__":
    main()
