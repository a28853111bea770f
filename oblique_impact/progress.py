"""How far a long call is: what it tells, and bars on a terminal.  Calls from Python show nothing by themselves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from oblique_impact import interrupts

if TYPE_CHECKING:
    from rich.console import Console

    from oblique_impact.marching import Status


class Progress(NamedTuple):
    """What a call that does many things tells its `on_progress`: first 0 of the total, then each as it is done."""

    done: int
    total: int
    last: str = ""  # name of what was done last


OnProgress = Callable[[Progress], None]


def silent(progress: Progress) -> None:
    """Show nothing: the default of every call from Python."""


@contextmanager
def counting_bar(title: str, console: Console | None = None) -> Iterator[OnProgress]:
    """Show a bar while the block runs, on standard error or on `console`; yields an `on_progress`.

    Nothing is drawn where that is not a terminal.
    """
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.progress import Progress as Bar

    console = console or Console(stderr=True)
    columns = (
        TextColumn(title),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[last]}"),
    )
    with Bar(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(title, total=None, last="")

        def show(progress: Progress) -> None:
            interrupts.check()
            bar.update(task, completed=progress.done, total=progress.total, last=progress.last)

        yield show


@contextmanager
def progress_bar(console: Console) -> Iterator[Callable[[Status], None]]:
    """Show a bar while the block runs; yields the callback for `simulate`.

    Nothing is drawn where `console` is not a terminal.
    """
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.fields[state]:>5}"),
        BarColumn(),
        TextColumn("{task.fields[said]}"),
        TimeElapsedColumn(),
    )
    with Bar(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("run", total=None, state="", said="")

        def show(status: Status) -> None:
            bar.update(
                task,
                total=status.end_time,
                completed=status.time,
                state=status.state.name,
                said=f"t = {status.time:.4f} of {status.end_time:g} s, {status.events} events",
            )

        yield show
