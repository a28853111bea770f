"""Exports as a call, `export`, and as the command `oblique-impact export`."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, cast

import numpy as np

from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, only_writer
from oblique_impact.history import History, require_history
from oblique_impact.progress import OnProgress, Progress, counting_bar, silent
from renders.export.scene import Scene, missing_variables
from renders.export.selection import Selection
from renders.export.target import resolve
from renders.geometry import BeamGeometry

if TYPE_CHECKING:
    Write = Callable[[Scene, Path, Callable[[], None]], None]

Format = Literal["vtkhdf", "pvd", "xdmf"]


@dataclass(frozen=True)
class Exported:
    """A time series on disk.

    Attributes
    ----------
    file : Path
        What a reader opens.
    format : str
        "vtkhdf", "pvd" or "xdmf".
    samples, of : int
        How many samples of the history became frames.
    span : tuple of float
        First and last time (s).
    jumps : int
        Of how many jumps both sides are there.
    factor : float
        By which the bending is magnified; 1 for true shapes.
    """

    file: Path
    format: Format
    samples: int
    of: int
    span: tuple[float, float]
    jumps: int
    factor: float


def export(
    history: History,
    out: str | os.PathLike[str],
    *,
    format: Format | None = None,
    every: int = 1,
    between: tuple[float, float] | None = None,
    around_events: float | None = None,
    deformation: float = 1.0,
    on_progress: OnProgress = silent,
) -> Exported:
    """Write a history as a time series for ParaView: surface, axis, slope and pin with all results.

    Parameters
    ----------
    history : History
        Of a beam.
    out : path
        The file; the suffix of the format is appended if it has none.
    format : {"vtkhdf", "pvd", "xdmf"}, optional
        Default: as the suffix of `out` says.
    every : int
        Every n-th sample; those at events and jumps are all kept.
    between : tuple of float, optional
        First and last time (s).
    around_events : float, optional
        Keep only what is within so many seconds of an event.
    deformation : float
        Factor by which the bending is magnified.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` before the first and after each frame.

    Returns
    -------
    Exported
        The file and what it holds.

    Raises
    ------
    InputError
        In one line, for everything that is wrong with the options, the history or the place.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> from renders import export
    >>> history = simulate(Scenario.builtin("paper"))
    >>> export(history, "beam", format="vtkhdf", every=10, between=(0.3, 0.34)).file  # doctest: +SKIP
    """
    require_history(history, "export")
    selection = Selection(every, between, around_events)
    _check_beam(history, "history")
    geometry = BeamGeometry(history, deformation)
    scene = Scene.of(geometry, selection.frames(history))
    target, chosen = resolve(Path(out), format)
    count = scene.frames.sample.size
    done = 0

    def advance() -> None:
        nonlocal done
        done += 1
        on_progress(Progress(done, count))

    on_progress(Progress(0, count))
    try:
        # runs that blew up hold numbers of any size
        with np.errstate(over="ignore", invalid="ignore"), only_writer(target):
            _writer(chosen)(scene, target, advance)
    except OSError as error:
        raise cannot_write(target, error) from None
    time, side = scene.frames.time, scene.frames.side
    span = float(time[0]), float(time[-1])
    return Exported(
        target, cast(Format, chosen), count, geometry.times.size, span, int((side > 0).sum()), geometry.factor
    )


def export_command(
    source: Path,
    out: Path,
    format: str | None,
    every: int,
    between: tuple[float, float] | None,
    around_events: float | None,
    deformation: float,
) -> list[str]:
    """Read a history, call `export` with a progress bar; returns the lines to print.  Raises InputError."""
    Selection(every, between, around_events)  # what can be refused before reading is refused
    history = History.load(source)
    _check_beam(history, str(source))
    with counting_bar(f"export {format or out.suffix.removeprefix('.')}") as show:
        result = export(
            history,
            out,
            format=cast(Format | None, format),
            every=every,
            between=between,
            around_events=around_events,
            deformation=deformation,
            on_progress=show,
        )
    shapes = "true shapes" if result.factor == 1.0 else "magnified shapes"
    return [
        f"{result.samples} of {result.of} samples, {result.span[0]:g} to {result.span[1]:g} s, "
        f"both sides of {result.jumps} jumps; {shapes} (deformation factor {result.factor:g})",
        f"  {result.format}: {result.file}",
    ]


def _check_beam(history: History, name: str) -> None:
    missing = missing_variables(history)
    if missing:
        raise InputError(f"{name}: has no variable {missing[0]!r}: it is not of a beam, or of another version")


def _writer(format: str) -> Write:
    """Return the writer of a format; each loads a large library, so only the one that is wanted."""
    if format == "pvd":
        from renders.export.pvd import write
    elif format == "vtkhdf":
        from renders.export.vtkhdf import write
    else:
        from renders.export.xdmf import write
    return write
