"""A progress bar with rate and remaining time."""

from __future__ import annotations

from collections.abc import Callable, Iterator
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


class RateColumn(ProgressColumn):
    """Runs per second, or per minute if there are few."""

    def render(self, task: Task) -> Text:
        """Return the column's text."""
        speed = task.finished_speed or task.speed
        if not speed:
            return Text("– runs/s")
        return Text(f"{speed:.1f} runs/s" if speed >= 1.0 else f"{60.0 * speed:.1f} runs/min")


@contextmanager
def sweep_bar(total: int, done: int, console: Console | None = None) -> Iterator[Callable[[int], None]]:
    """Show a bar over `total` runs of which `done` are done; yields a callback that takes the number of new ones.

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
        task = bar.add_task("sweep", total=total, completed=done)
        yield lambda count: bar.update(task, advance=count)
