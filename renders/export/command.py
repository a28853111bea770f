"""`oblique-impact export`: options, progress, messages."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from oblique_impact import interrupts
from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, only_writer
from oblique_impact.history import History
from renders.export.scene import Scene, missing_variables
from renders.export.selection import Selection
from renders.export.target import resolve
from renders.geometry import BeamGeometry

if TYPE_CHECKING:
    Write = Callable[[Scene, Path, Callable[[], None]], None]


def export_command(
    source: Path,
    out: Path,
    format: str | None,
    every: int,
    between: tuple[float, float] | None,
    around_events: float | None,
    deformation: float,
) -> Iterator[str]:
    """Write a time series and yield the lines that say what was written.

    Raises InputError with one line for everything that is wrong with the options, the history or the place.
    """
    selection = Selection(every, between, around_events)
    history = History.load(source)
    missing = missing_variables(history)
    if missing:
        raise InputError(f"{source}: has no variable {missing[0]!r}: it is not of a beam, or of another version")
    geometry = BeamGeometry(history, deformation)
    scene = Scene.of(geometry, selection.frames(history))
    target, format = resolve(out, format)
    count = scene.frames.sample.size
    try:
        # runs that blew up hold numbers of any size
        with (
            np.errstate(over="ignore", invalid="ignore"),
            only_writer(target),
            _bar(f"export {format}", count) as advance,
        ):
            _writer(format)(scene, target, advance)
    except OSError as error:
        raise cannot_write(target, error) from None
    jumps = int((scene.frames.side > 0).sum())
    shapes = "true shapes" if geometry.factor == 1.0 else "magnified shapes"
    yield (
        f"{count} of {geometry.times.size} samples, {scene.frames.time[0]:g} to {scene.frames.time[-1]:g} s, "
        f"both sides of {jumps} jumps; {shapes} (deformation factor {geometry.factor:g})"
    )
    yield f"  {format}: {target}"


def _writer(format: str) -> Write:
    """Return the writer of a format; each loads a large library, so only the one that is wanted."""
    if format == "pvd":
        from renders.export.pvd import write
    elif format == "vtkhdf":
        from renders.export.vtkhdf import write
    else:
        from renders.export.xdmf import write
    return write


@contextmanager
def _bar(title: str, total: int) -> Iterator[Callable[[], None]]:
    """Progress bar on standard error; nothing is drawn where that is not a terminal."""
    console = Console(stderr=True)
    columns = (TextColumn(title), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(title, total=total)

        def advance() -> None:
            interrupts.check()
            bar.update(task, advance=1)

        yield advance
