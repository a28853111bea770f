"""Progress of a long call, as `on_progress` is told it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class Progress(NamedTuple):
    """What a call that does many things tells its `on_progress`: first 0 of the total, then each as it is done."""

    done: int
    total: int
    last: str = ""  # name of what was done last


OnProgress = Callable[[Progress], None]


def silent(progress: Progress) -> None:
    """Show nothing: the default of every call from Python."""
