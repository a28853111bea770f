"""How far a long call is: what it tells, and bars on a terminal.  Calls from Python show nothing by themselves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from oblique_impact.command_line import interrupts
from oblique_impact.kernels.compiling import compilations

if TYPE_CHECKING:
    from rich.console import Console

    from oblique_impact.command_line.bars import Bar
    from oblique_impact.marching.loop import Status


class Progress(NamedTuple):
    """What a call that does many things tells its `on_progress`: first 0 of the total, then each as it is done."""

    done: int
    total: int
    last: str = ""  # name of what was done last


OnProgress = Callable[[Progress], None]


def silent(progress: Progress) -> None:
    """Show nothing: the default of every call from Python."""


@contextmanager
def counting_bar(title: str, console: Console | None = None, rate: str = "") -> Iterator[OnProgress]:
    """Show a bar while the block runs, on standard error or on `console`; yields an `on_progress`.

    Nothing is drawn where that is not a terminal; what is compiled is said there too.  With `rate`, the name of
    what is counted, the bar tells how many are done in a second.
    """
    from oblique_impact.command_line.bars import Bar, counting_columns

    with _shown(Bar(_console(console), counting_columns(title, rate), last=""), "last") as bar:

        def show(progress: Progress) -> None:
            interrupts.check()
            last = progress.last if progress.done < progress.total else "writing"
            bar.tell(completed=progress.done, total=progress.total, last=last)

        yield show


@contextmanager
def progress_bar(console: Console | None = None) -> Iterator[Callable[[Status], None]]:
    """Show a bar while the block runs, on standard error or on `console`; yields the callback for `simulate`.

    Nothing is drawn where that is not a terminal; what is compiled is said there too.
    """
    from oblique_impact.command_line.bars import Bar, digits_of, run_columns

    with _shown(
        Bar(_console(console), run_columns, state="", said="preparing", short="preparing"), "said", "short"
    ) as bar:

        def show(status: Status) -> None:
            end, time = status.end_time, f"{status.time:.{digits_of(status.end_time)}f}"
            bar.tell(
                total=end,
                completed=status.time,
                state=status.state.name,
                said=f"t = {time} of {end:g} s, {status.events} events",
                short=f"{time}/{end:g} s {status.events} events",
            )

        yield show


def _console(given: Console | None) -> Console:
    from rich.console import Console

    return given or Console(stderr=True)


@contextmanager
def _shown(bar: Bar, *fields: str) -> Iterator[Bar]:
    """Draw a bar while the block runs and take it away, whatever ends it; what is compiled stands in `fields`."""
    known: set[str] = set()

    def tell(name: str) -> None:
        if name not in known:
            known.add(name)
            bar.say(f"oblique-impact: compiling {name} (once on this machine, up to 30 s)")
        bar.tell(**dict.fromkeys(fields, f"compiling {name}"))

    with bar, interrupts.ends_with_us(bar), compilations(tell):
        yield bar
