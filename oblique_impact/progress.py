"""Progress of a run, and of a call with many parts."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from oblique_impact.contact.state import State


class Status(NamedTuple):
    """Time and state of a run, for a progress display."""

    time: float
    end_time: float
    state: State
    events: int
    notice: str = ""  # a line that stays, of what is known of the run by now


class Progress(NamedTuple):
    """Argument of `on_progress`: called first with 0 of the total, then after each part."""

    done: int
    total: int
    last: str = ""  # name of the part that was done last


OnProgress = Callable[[Progress], None]


def silent(progress: Progress) -> None:
    """Ignore progress: the default of calls from Python."""
