"""Bars on a terminal: one line that is never as wide as the terminal, whatever its width becomes."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rich.console import Console, RenderableType
from rich.constrain import Constrain
from rich.progress import BarColumn, ProgressColumn, Task, TextColumn, TimeRemainingColumn
from rich.progress import Progress as RichProgress
from rich.table import Column
from rich.text import Text

from oblique_impact.kernels.compiling import compilations
from oblique_impact.progress import OnProgress, Progress

if TYPE_CHECKING:
    from oblique_impact.marching.loop import Status

#: s; a terminal that cannot erase gets a new line at this interval
LINE_INTERVAL = 5.0


@contextmanager
def counting_bar(title: str, console: Console | None = None, rate: str = "") -> Iterator[OnProgress]:
    """Show a bar while the block runs, on standard error or on `console`; yields an `on_progress`.

    Nothing is drawn where that is not a terminal; what is compiled is said there too.  With `rate`, the name of
    what is counted, the bar tells how many are done in a second.
    """
    with _shown(Bar(console or Console(stderr=True), counting_columns(title, rate), last=""), "last") as bar:

        def show(progress: Progress) -> None:
            last = progress.last if progress.done < progress.total else "writing"
            bar.set_fields(completed=progress.done, total=progress.total, last=last)

        yield show


@contextmanager
def progress_bar(console: Console | None = None) -> Iterator[Callable[[Status], None]]:
    """Show a bar while the block runs, on standard error or on `console`; yields the callback for `simulate`.

    Nothing is drawn where that is not a terminal; what is compiled is said there too.
    """
    new = Bar(console or Console(stderr=True), run_columns, state="", text="preparing", short="preparing")
    with _shown(new, "text", "short") as bar:

        def show(status: Status) -> None:
            end, time = status.end_time, f"{status.time:.{digits_of(status.end_time)}f}"
            bar.set_fields(
                total=end,
                completed=status.time,
                state=status.state.name,
                text=f"t = {time} of {end:g} s, {status.events} events",
                short=f"{time}/{end:g} s {status.events} events",
            )

        yield show


@contextmanager
def _shown(bar: Bar, *fields: str) -> Iterator[Bar]:
    """Draw a bar while the block runs and take it away, whatever ends it; what is compiled stands in `fields`."""
    known: set[str] = set()

    def show_name(name: str) -> None:
        if name not in known:
            known.add(name)
            bar.write_line(f"oblique-impact: compiling {name} (once on this machine, up to 30 s)")
        bar.set_fields(**dict.fromkeys(fields, f"compiling {name}"))

    with bar, compilations(show_name):
        yield bar


class Bar(RichProgress):
    """A bar of one task that vanishes at its end, drawn where `console` is a terminal.

    Parameters
    ----------
    console : Console
        Where to draw.  Nothing is written if its file is no terminal, whatever FORCE_COLOR says.
    columns : callable
        Columns for a number of characters; it is asked each time the bar is drawn.
    **fields
        Of the task, at first.

    Notes
    -----
    Terminals that cannot move their cursor get a plain line every few seconds.
    """

    def __init__(
        self, console: Console, columns: Callable[[int], Sequence[ProgressColumn]], **fields: Any
    ) -> None:
        terminal = console.file.isatty()
        self._plain = terminal and not console.is_interactive
        self._console, self._columns = console, columns
        self._last_line = time.monotonic()
        super().__init__(console=console, transient=True, disable=self._plain or not terminal)
        self._task = self.add_task("", total=None, **fields)

    def start(self) -> None:
        """Draw from now on; the cursor stays, so that a process that is killed leaves the terminal with it."""
        super().start()
        if not self.disable:
            self.console.show_cursor(True)

    def write_line(self, line: str) -> None:
        """Write a line that stays, above the bar; to a file or a pipe too."""
        self.console.print(line, soft_wrap=True, markup=False, highlight=False)

    def set_fields(self, **fields: Any) -> None:
        """Update the task."""
        self.update(self._task, **fields)
        if self._plain and time.monotonic() - self._last_line >= LINE_INTERVAL:
            self._last_line = time.monotonic()
            self.console.print(self.get_renderable())

    def get_renderables(self) -> Iterable[RenderableType]:
        """Return the line for the present width of the terminal; the last column stays free."""
        width = self._console.width - 1  # rich calls this before it has set its console
        chosen = self._columns(width + 1)
        self.columns = tuple(column for column in chosen if not (self._plain and isinstance(column, BarColumn)))
        yield Constrain(self.make_tasks_table(self.tasks), width)


class TimeLeft(TimeRemainingColumn):
    """The time that is left, or where the total is not known the time that has passed."""

    def __init__(self, word: str = " left") -> None:
        super().__init__(table_column=Column(no_wrap=True))
        self._word = word

    def render(self, task: Task) -> Text:
        """Return the column's text."""
        if task.total is None:
            return Text(f"{_clock(task.elapsed)}", style="progress.elapsed")
        return super().render(task).append(self._word)


class TimePassed(ProgressColumn):
    """The time that has passed."""

    def render(self, task: Task) -> Text:
        """Return the column's text."""
        return Text("" if task.total is None else f"after {_clock(task.elapsed)}", style="progress.elapsed")


class Count(ProgressColumn):
    """How many are done, of how many."""

    def render(self, task: Task) -> Text:
        """Return the column's text."""
        return Text("" if task.total is None else f"{task.completed:.0f}/{task.total:.0f}", "progress.download")


class Rate(ProgressColumn):
    """How many are done in a second, or in a minute if there are few."""

    def __init__(self, unit: str) -> None:
        super().__init__()
        self._unit = unit

    def render(self, task: Task) -> Text:
        """Return the column's text."""
        speed = task.finished_speed or task.speed
        if not speed:
            return Text(f"– {self._unit}/s")
        return Text(f"{speed:.1f} {self._unit}/s" if speed >= 1.0 else f"{60.0 * speed:.1f} {self._unit}/min")


def run_columns(width: int) -> Sequence[ProgressColumn]:
    """Return the columns for one run: state, simulated time, events, time left."""
    if width < 60:
        return [_text("{task.fields[state]:>5}"), _text("{task.fields[short]}"), TimeLeft("")]
    columns = [
        _text("{task.fields[state]:>5}"),
        BarColumn(max(4, min(40, width - 60))),
        _text("{task.fields[text]}"),
        TimeLeft(),
    ]
    return [*columns, TimePassed()] if width >= 110 else columns


def counting_columns(title: str, rate: str = "") -> Callable[[int], Sequence[ProgressColumn]]:
    """Return the columns for a call that does many things, and how fast if these have a name, `rate`."""

    def columns(width: int) -> Sequence[ProgressColumn]:
        rates = [Rate(rate)] if rate else []
        if width < 60:
            return [_text(title), Count(), TimeLeft("")]
        bar = max(4, min(40, width - 60))
        # what stands to the left of it, at its widest
        room = width - len(title) - bar - len("100000/100000 99:59:59 left") - 6 - (14 if rate else 0)
        if width < 110:
            return [_text(title), BarColumn(bar), Count(), *rates, TimeLeft(), _text("{task.fields[last]}", room)]
        last = _text("{task.fields[last]}", room - len("after 9:59:59 "))
        return [_text(title), BarColumn(bar), Count(), *rates, TimeLeft(), TimePassed(), last]

    return columns


def digits_of(end: float) -> int:
    """Return the decimals with which times up to `end` (s) are told: so that `end` has five digits."""
    return max(0, 4 - math.floor(math.log10(end)))


def _text(form: str, room: int | None = None) -> TextColumn:
    return TextColumn(form, markup=False, table_column=Column(no_wrap=True, overflow="ellipsis", max_width=room))


def _clock(seconds: float | None) -> str:
    minutes, rest = divmod(int(seconds or 0.0), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{rest:02d}"
