"""Progress bars on standard error, if that is a terminal."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from oblique_impact.kernels.compiling import compilations
from oblique_impact.progress import OnProgress
from oblique_impact.progress import Progress as Done

if TYPE_CHECKING:
    from oblique_impact.progress import Status


@contextmanager
def counting_bar(title: str, rate: str = "", note: str = "") -> Iterator[OnProgress]:
    """Show a bar while the block runs; yields an `on_progress`.

    With `rate`, the name of what is counted, the bar shows how many are done in a second.  A `note` is printed
    when the first one begins.
    """
    columns = TextColumn(title), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[text]}")
    with _drawn(Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True)) as bar:
        task = bar.add_task("", total=None, text="")

        def show(progress: Done) -> None:
            if note and progress.done == 0:
                _print(bar.console, note)
            speed = bar.tasks[0].speed
            text = f"{speed:.3g} {rate}/s" if rate and speed else progress.last
            bar.update(task, completed=progress.done, total=progress.total, text=text)

        yield show


@contextmanager
def progress_bar() -> Iterator[Callable[[Status], None]]:
    """Show a bar of one run while the block runs; yields the callback for `simulate`."""
    columns = TextColumn("{task.fields[state]:>5}"), BarColumn(), TextColumn("{task.fields[text]}")
    with _drawn(Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True)) as bar:
        task = bar.add_task("", total=None, state="", text="preparing")

        def show(status: Status) -> None:
            if status.notice:
                _print(bar.console, status.notice)
            end = status.end_time
            digits = max(0, 4 - math.floor(math.log10(end)))  # so that the end has five
            text = f"t = {status.time:.{digits}f} of {end:g} s, {status.events} events"
            bar.update(task, total=end, completed=status.time, state=status.state.name, text=text)

        yield show


@contextmanager
def _drawn(bar: Progress) -> Iterator[Progress]:
    """Draw a bar while the block runs, and print each kernel that is compiled."""
    known: list[str] = []

    def show_name(name: str) -> None:
        if name not in known:
            known.append(name)
            _print(bar.console, f"compiling kernel {len(known)}, {name} (once, up to 15 s)")

    console = bar.console
    bar.disable = not (console.file.isatty() and console.is_interactive)  # FORCE_COLOR makes no terminal of a pipe
    if not bar.disable:
        bar.start()
    try:
        with compilations(show_name):
            yield bar
    finally:
        if not bar.disable:  # older versions of rich end a bar that was not drawn with an empty line
            with suppress(OSError):  # of a terminal that is closed: results are still to be saved
                bar.stop()


def _print(console: Console, line: str) -> None:
    """Print a line that stays, above the bar."""
    with suppress(OSError):  # of a terminal that is closed: the run goes on until it hears of that
        soft_wrap = not console.file.isatty()  # else rich breaks it between words
        console.print(f"oblique-impact: {line}", soft_wrap=soft_wrap, markup=False, highlight=False)
