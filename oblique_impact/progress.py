"""A progress bar for long runs: simulated time, contact state, number of events."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

if TYPE_CHECKING:
    from oblique_impact.marching import Status


@contextmanager
def progress_bar(console: Console) -> Iterator[Callable[[Status], None]]:
    """Show a bar while the block runs; yields the callback for `simulate`.

    Nothing is drawn where `console` is not a terminal.
    """
    columns = (
        TextColumn("{task.fields[state]:>5}"),
        BarColumn(),
        TextColumn("t = {task.completed:.4f} of {task.total:g} s, {task.fields[events]} events"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("run", total=None, state="", events=0)

        def show(status: Status) -> None:
            bar.update(
                task,
                total=status.end_time,
                completed=status.time,
                state=status.state.name,
                events=status.events,
            )

        yield show
