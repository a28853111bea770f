"""Exports as a call, `export`, and as the command `oblique-impact export`."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from pathlib import Path
from shlex import quote
from typing import Any, Literal, cast

import numpy as np

from oblique_impact.command_line.progress_bars import counting_bar
from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, only_writer, write_text
from oblique_impact.history.history import History, require_history
from oblique_impact.progress import OnProgress, Progress, silent
from oblique_impact.renders.exports.paraview_state import state_file, state_text
from oblique_impact.renders.exports.scene import Scene
from oblique_impact.renders.exports.selection import Integers, Selection
from oblique_impact.renders.exports.target import READERS, resolve
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style

Format = Literal["vtkhdf", "pvd", "xdmf", "csv"]

_TRIAL = 6  # frames written to learn how large one is


@dataclass(frozen=True)
class Exported:
    """A time series on disk."""

    file: Path  # what a reader opens
    format: Format
    samples: int  # that became frames,
    of: int  # of so many
    span: tuple[float, float]  # first and last time (s)
    jumps: int  # of which both sides are there
    factor: float  # by which the bending is magnified; 1 for true shapes
    state: Path | None  # Python for ParaView, which opens the file with colours and arrows; none of a table


def export(
    history: History,
    out: str | os.PathLike[str],
    *,
    format: Format | None = None,
    every: int | None = None,
    between: tuple[float, float] | None = None,
    around_events: float | None = None,
    deformation: float = 1.0,
    on_progress: OnProgress = silent,
) -> Exported:
    """Write a history as a time series for ParaView: surface, axis, contact point, slope and pin with all results.

    Or, as CSV, the variables over time as a table: a row a sample, units in the first line.

    Parameters
    ----------
    history : History
        Of a beam.
    out : path
        The file; the suffix of the format is appended if it has none.
    format : {"vtkhdf", "pvd", "xdmf", "csv"}, optional
        Default: as the suffix of `out` says.
    every : int, optional
        Every n-th sample, 1 for all; default: about 1000, evenly in time, of CSV all.  Those at events and jumps
        are all kept.
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
    return _Job.of(history, Path(out), format, selection, deformation).write(on_progress)


def export_command(
    source: Path,
    out: Path,
    format: str | None,
    selection: Selection,
    deformation: float,
    announce: Callable[[str], None],
) -> tuple[list[str], dict[str, Any]]:
    """Read a history and export it with a progress bar; returns the lines to print, and the same as data.

    What is about to be written goes to `announce` before.  Raises InputError.
    """
    job = _Job.of(History.load(source), out, format, selection, deformation)
    announce(job.forecast(thinned=selection.every is None))
    with counting_bar(f"export {job.format}") as show:
        result = job.write(show)
    shapes = "true shapes" if result.factor == 1.0 else "magnified shapes"
    what = (
        f"{result.samples} of {result.of} samples, {result.span[0]:g} to {result.span[1]:g} s, "
        f"both sides of {result.jumps} jumps"
    )
    if result.format != "csv":
        what += f"; {shapes} (deformation factor {result.factor:g})"
    lines = [what, f"  {result.format}: {result.file}", f"  read by {READERS[result.format]}"]
    if result.state:
        lines.append(f"  in ParaView with colours and arrows: paraview --script={quote(str(result.state))}")
    return lines, asdict(result)


@dataclass(frozen=True)
class _Job:
    """What to write, where, and in which format."""

    scene: Scene
    target: Path
    format: Format

    @classmethod
    def of(cls, history: History, out: Path, format: str | None, selection: Selection, deformation: float) -> _Job:
        if (format or out.suffix.lower().removeprefix(".")) == "csv":
            if deformation != 1.0:
                raise InputError(f"--deformation {deformation:g}: does not apply to csv, which holds no shapes")
            selection = replace(selection, every=selection.every or 1)
        scene = Scene.of(story_of([history], Style(deformation=deformation)), selection.frames(history))
        target, chosen = resolve(out, format)
        return cls(scene, target, cast(Format, chosen))

    def forecast(self, thinned: bool) -> str:
        """Return what is about to be written, and how large that is: measured on a few frames, spread over all."""
        count, total = self.scene.frames.sample.size, self.scene.geometry.times.size
        numbers = np.unique(np.linspace(0, count - 1, min(count, _TRIAL)).astype(int))
        try:
            one, some = self._size(numbers[:1]), self._size(numbers)
        except OSError:  # no room to try
            sizes = ["", ""]
        else:
            each = (some - one) / max(numbers.size - 1, 1)
            sizes = [_megabytes(one + (frames - 1) * each) for frames in (count, total)]
        line = f"{count} frames" + (f", about {sizes[0]}" if sizes[0] else "")
        if thinned and count < total:
            line += f" (--all: {', '.join(part for part in (f'{total} frames', sizes[1]) if part)})"
        return line

    def _size(self, numbers: Integers) -> int:
        """Size (bytes) of an export of these frames alone."""
        scene = replace(self.scene, frames=self.scene.frames.some(numbers))
        with tempfile.TemporaryDirectory() as folder:
            _write(scene, Path(folder) / self.target.name, self.format, lambda: None)
            return sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())

    def write(self, on_progress: OnProgress) -> Exported:
        frames, count = self.scene.frames, self.scene.frames.sample.size
        done = 0

        def advance() -> None:
            nonlocal done
            done += 1
            on_progress(Progress(done, count))

        on_progress(Progress(0, count))
        try:
            with only_writer(self.target):
                _write(self.scene, self.target, self.format, advance)
                state = None if self.format == "csv" else state_file(self.target)
                if state:
                    write_text(state, state_text(self.scene, self.target, self.format))
        except OSError as error:
            raise cannot_write(self.target, error) from None
        span = float(frames.time[0]), float(frames.time[-1])
        jumps, geometry = int((frames.side > 0).sum()), self.scene.geometry
        return Exported(self.target, self.format, count, geometry.times.size, span, jumps, geometry.factor, state)


def _megabytes(size: float) -> str:
    return f"{size / 1e6:.3g} MB" if size < 1e9 else f"{size / 1e9:.3g} GB"


def _write(scene: Scene, target: Path, format: Format, advance: Callable[[], None]) -> None:
    """Write a format; each writer loads a large library, so only the one that is wanted."""
    writer = import_module(f"oblique_impact.renders.exports.{format}")
    # runs that blew up hold numbers of any size
    with np.errstate(over="ignore", invalid="ignore"):
        writer.write(scene, target, advance)
