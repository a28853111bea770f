"""Progress of a call with many parts."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple


class Progress(NamedTuple):
    """Argument of `on_progress`: called first with 0 of the total, then after each part."""

    done: int
    total: int
    last: str = ""  # name of the part that was done last


OnProgress = Callable[[Progress], None]


def silent(progress: Progress) -> None:
    """Ignore progress: the default of calls from Python."""
