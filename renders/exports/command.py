"""Exports as a call, `export`, and as the command `oblique-impact export`."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np

from oblique_impact.command_line.progress_bars import counting_bar
from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, prepare_folder
from oblique_impact.history.history import History, require_history
from oblique_impact.progress import OnProgress, Progress, silent
from oblique_impact.renders.exports.selection import Selection, sides
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style
from oblique_impact.scenario.messages import one_of

Format = Literal["pvd", "xdmf", "csv"]

#: formats, and what reads them
READERS = {
    "pvd": "ParaView, PyVista",
    "xdmf": 'ParaView (choose "Xdmf3 Reader S"), PyVista, meshio',
    "csv": "pandas, spreadsheets",
}
_FRAME = re.compile(r"[a-z_]+_\d{6,}\.vtp")  # a file in the folder of a PVD export


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

    Or, as CSV, the variables over time as a table: a row per sample, units in the first line.

    Parameters
    ----------
    history : History
        Of a beam.
    out : path
        The file; the suffix of the format is appended if it has none.  Files appear whole or not at all.
    format : {"pvd", "xdmf", "csv"}, optional
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
    >>> from oblique_impact.renders import export
    >>> history = simulate(Scenario.builtin("paper"))
    >>> export(history, "beam", format="pvd", every=10, between=(0.3, 0.34)).file  # doctest: +SKIP
    """
    from oblique_impact.renders.exports import writers  # loads VTK

    require_history(history, "export")
    try:
        target, format = _target(Path(out), format)
    except OSError as error:  # a name that is too long
        raise cannot_write(Path(out), error) from None
    if format == "csv":
        every = every or 1
        if deformation != 1.0:
            raise InputError(f"--deformation {deformation:g}: does not apply to csv, which holds no shapes")
    samples = Selection(every, between, around_events).samples(history)
    story = story_of([history], Style(deformation=deformation))
    write = {"pvd": writers.write_pvd, "xdmf": writers.write_xdmf, "csv": writers.write_csv}[format]
    done = 0

    def advance() -> None:
        nonlocal done
        done += 1
        on_progress(Progress(done, samples.size))

    prepare_folder(target.parent)
    on_progress(Progress(0, samples.size))
    try:
        with tempfile.TemporaryDirectory(prefix=f".{target.stem[:40]}.", dir=target.parent) as folder:
            with np.errstate(over="ignore", invalid="ignore"):  # runs that blew up hold numbers of any size
                made = write(story, samples, Path(folder), target.stem, advance)
            for path in made:
                _put(path, target.parent / path.name)
    except OSError as error:
        raise cannot_write(target, error) from None
    times = history["time"].values
    span, jumps = times[samples[[0, -1]]].tolist(), int((sides(times)[samples] > 0).sum())
    return Exported(target, format, samples.size, times.size, tuple(span), jumps, story.factor)


def _target(out: Path, format: str | None) -> tuple[Path, Format]:
    """Return the file to write and its format.

    Raises InputError if the format is unknown or contradicts the suffix, or if something is in the way.
    """
    format = format or out.suffix.lower().removeprefix(".")
    if not format:
        raise InputError(f"--format: missing, and --out {out} does not tell it; {one_of(format, READERS)}")
    if format not in READERS:
        raise InputError(f"--format {format}: {one_of(format, READERS)}")
    if out.suffix and out.suffix.lower() != f".{format}":
        raise InputError(f"--out {out}: should end in .{format} for --format {format}, or have no suffix")
    target = out if out.suffix else out.parent / f"{out.name}.{format}"
    if not out.name or target.is_dir():
        raise InputError(f"--out {target}: is a folder, should be a file")
    if format == "xdmf" and ":" in target.name:
        raise InputError(f"--out {target}: a colon ends the name of a file in XDMF: choose another name")
    frames, numbers = target.with_suffix(""), target.with_suffix(".h5")
    if format == "pvd" and frames.exists() and not all(map(_FRAME.fullmatch, os.listdir(frames))):
        raise InputError(f"--out {target}: the folder {frames} holds other files: choose another name")
    if format == "xdmf" and numbers.exists() and not target.exists():
        raise InputError(f"--out {target}: {numbers} is in the way and not of an export: choose another name")
    return target, cast(Format, format)


def _put(made: Path, place: Path) -> None:
    """Move a file or a folder into its place; one of an earlier export is replaced."""
    if place.is_dir():
        shutil.rmtree(place)
    os.replace(made, place)


def export_command(
    source: Path, out: Path, format: str | None, selection: Selection, deformation: float
) -> tuple[list[str], dict[str, Any]]:
    """Read a history and export it with a progress bar; returns the lines to print, and the same as data.

    Raises InputError.
    """
    with counting_bar("export") as show:
        done = export(
            History.load(source),
            out,
            format=cast(Format, format),
            **asdict(selection),
            deformation=deformation,
            on_progress=show,
        )
    lines = [
        f"{done.samples} of {done.of} samples, {done.span[0]:g} to {done.span[1]:g} s, "
        f"both sides of {done.jumps} jumps",
        f"  {done.format}: {done.file}",
        f"  read by {READERS[done.format]}",
    ]
    if done.format != "csv":
        shapes = "true shapes" if done.factor == 1.0 else "magnified shapes"
        lines[0] += f"; {shapes} (deformation factor {done.factor:g})"
    return lines, asdict(done)
