"""A progress bar with rate and remaining time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from oblique_impact.progress import OnProgress


class RateColumn(ProgressColumn):
    """Runs per second, or per minute if there are few."""

    def render(self, task: Task) -> Text:
        """Return the column's text."""
        speed = task.finished_speed or task.speed
        if not speed:
            return Text("– runs/s")
        return Text(f"{speed:.1f} runs/s" if speed >= 1.0 else f"{60.0 * speed:.1f} runs/min")


@contextmanager
def sweep_bar(console: Console | None = None) -> Iterator[OnProgress]:
    """Show a bar with the rate of the new runs; yields an `on_progress`.

    Nothing is drawn where standard error is not a terminal.
    """
    console = console or Console(stderr=True)
    columns = (
        TextColumn("sweep"),
        BarColumn(),
        MofNCompleteColumn(),
        RateColumn(),
        TimeElapsedColumn(),
        TextColumn("remaining"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("sweep", total=None)
        # runs that were there before are no part of the rate
        yield lambda p: bar.update(task, total=p.total, completed=p.done)
