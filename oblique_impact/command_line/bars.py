"""Bars on a terminal: one line that is never as wide as the terminal, whatever its width becomes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from rich.console import Console, RenderableType
from rich.constrain import Constrain
from rich.progress import BarColumn, ProgressColumn, Task
from rich.progress import Progress as RichProgress
from rich.table import Column
from rich.text import Text

from oblique_impact.kernels.compiling import compilations
from oblique_impact.progress import OnProgress, Progress

if TYPE_CHECKING:
    from oblique_impact.marching.loop import Status


@contextmanager
def counting_bar(
    title: str, console: Console | None = None, rate: str = "", note: str = ""
) -> Iterator[OnProgress]:
    """Show a bar while the block runs, on standard error or on `console`; yields an `on_progress`.

    Nothing is drawn where that is not a terminal; what is compiled is said there too.  With `rate`, the name of
    what is counted, the bar tells how many are done in a second.  A `note` is said when the first one begins.
    """
    with _shown(Bar(console or Console(stderr=True), counting_columns(title, rate), last=""), "last") as bar:

        def show(progress: Progress) -> None:
            if note and progress.done == 0:
                bar.write_line(f"oblique-impact: {note}")
            last = progress.last if progress.done < progress.total else "writing"
            bar.set_fields(completed=progress.done, total=progress.total, last=last)

        yield show


@contextmanager
def progress_bar(console: Console | None = None) -> Iterator[Callable[[Status], None]]:
    """Show a bar of one run, as :func:`counting_bar`; yields the callback for `simulate`."""
    new = Bar(console or Console(stderr=True), run_columns, state="", text="preparing", short="preparing")
    with _shown(new, "text", "short") as bar:

        def show(status: Status) -> None:
            if status.notice:
                bar.write_line(f"oblique-impact: {status.notice}")
            end, time = status.end_time, f"{status.time:.{digits_of(status.end_time)}f}"
            text = f"t = {time} of {end:g} s, {status.events} events"
            short = f"{time}/{end:g} s {status.events} events"
            bar.set_fields(total=end, completed=status.time, state=status.state.name, text=text, short=short)

        yield show


@contextmanager
def _shown(bar: Bar, *fields: str) -> Iterator[Bar]:
    """Draw a bar while the block runs and take it away, whatever ends it; what is compiled stands in `fields`."""
    known: dict[str, int] = {}

    def show_name(name: str) -> None:
        new = name not in known
        kernel = f"kernel {known.setdefault(name, len(known) + 1)}, {name}"
        if new:
            bar.write_line(f"oblique-impact: compiling {kernel} (once, up to 15 s)")
        short = kernel.partition(" for ")[0]  # the bar leaves room for the ^C that a terminal writes behind it
        bar.set_fields(**dict.fromkeys(fields, f"compiling {short}"))

    with bar, compilations(show_name):
        yield bar


class Bar(RichProgress):
    """A bar of one task that vanishes at its end, drawn where `console` is a terminal that can move its cursor.

    Parameters
    ----------
    console : Console
        Where to draw.  Nothing is drawn if its file is no terminal, whatever FORCE_COLOR says.
    columns : callable
        Columns for a number of characters; it is asked each time the bar is drawn.
    **fields
        Of the task, at first.
    """

    def __init__(
        self, console: Console, columns: Callable[[int], Sequence[ProgressColumn]], **fields: Any
    ) -> None:
        self._console, self._columns = console, columns
        drawn = console.file.isatty() and console.is_interactive
        super().__init__(console=console, transient=True, disable=not drawn)
        self._task = self.add_task("", total=None, **fields)

    def start(self) -> None:
        """Draw from now on; the cursor stays, so that a process that is killed leaves the terminal with it."""
        super().start()
        if not self.disable:
            self.console.show_cursor(True)

    def stop(self) -> None:
        """Take the bar away; a terminal that is closed meanwhile does not end what the bar is shown for."""
        with suppress(OSError):
            super().stop()

    def write_line(self, line: str) -> None:
        """Write a line that stays, above the bar; to a file or a pipe too."""
        whole = not self._console.file.isatty()  # else rich breaks it between words
        with suppress(OSError):
            self.console.print(line, soft_wrap=whole, markup=False, highlight=False)

    def set_fields(self, **fields: Any) -> None:
        """Update the task."""
        self.update(self._task, **fields)

    def get_renderables(self) -> Iterable[RenderableType]:
        """Return the line for the present width of the terminal; the last column stays free."""
        width = self._console.width - 1  # rich calls this before it has set its console
        self.columns = tuple(self._columns(width + 1))
        yield Constrain(self.make_tasks_table(self.tasks), width)


class Words(ProgressColumn):
    """A column with a text that follows from the task, cut off at `room` characters."""

    def __init__(self, words: Callable[[Task], str], style: str = "", room: int | None = None) -> None:
        super().__init__(Column(no_wrap=True, overflow="ellipsis", max_width=room))
        self._words, self._style = words, style

    def render(self, task: Task) -> Text:
        """Return the column's text."""
        return Text(self._words(task), self._style)


def run_columns(width: int) -> Sequence[ProgressColumn]:
    """Return the columns for one run: state, simulated time, events, time left."""
    state = Words(lambda task: f"{task.fields['state']:>5}")
    if width < 60:
        return [state, Words(lambda task: task.fields["short"]), _time_left("")]
    return [state, _blocks(width), Words(lambda task: task.fields["text"]), _time_left()]


def counting_columns(title: str, rate: str = "") -> Callable[[int], Sequence[ProgressColumn]]:
    """Return the columns for a call that does many things, and how fast if these have a name, `rate`."""

    def count(task: Task) -> str:
        return "" if task.total is None else f"{task.completed:.0f}/{task.total:.0f}"

    def speed(task: Task) -> str:
        each = task.finished_speed or task.speed
        if not each:
            return f"– {rate}/s"
        return f"{each:.1f} {rate}/s" if each >= 1.0 else f"{60.0 * each:.1f} {rate}/min"

    def columns(width: int) -> Sequence[ProgressColumn]:
        name, done = Words(lambda task: title), Words(count, "progress.download")
        if width < 60:
            return [name, done, _time_left("")]
        blocks, rates = _blocks(width), [Words(speed)] if rate else []
        # what stands to the left of it, at its widest
        taken = len(title) + int(blocks.bar_width or 0) + len("100000/100000 99:59:59 left") + (14 if rate else 0)
        last = Words(lambda task: task.fields["last"], room=width - taken - 6)
        return [name, blocks, done, *rates, _time_left(), last]

    return columns


def digits_of(end: float) -> int:
    """Return the decimals with which times up to `end` (s) are told: so that `end` has five digits."""
    return max(0, 4 - math.floor(math.log10(end)))


def _blocks(width: int) -> BarColumn:
    return BarColumn(max(4, min(40, width - 60)))


def _time_left(word: str = " left") -> Words:
    """Return the column of the time that is left, or where the total is not known of the time that has passed."""

    def words(task: Task) -> str:
        if task.total is None:
            return _clock(task.elapsed or 0.0)
        return ("-:--:--" if task.time_remaining is None else _clock(task.time_remaining)) + word

    return Words(words, "progress.remaining")


def _clock(seconds: float) -> str:
    return f"{seconds // 3600:.0f}:{seconds // 60 % 60:02.0f}:{seconds % 60 // 1:02.0f}"
