"""Export histories as time series: the call `export`."""

from __future__ import annotations

import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, cast

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, prepare_folder
from oblique_impact.history.history import History, require_history
from oblique_impact.history.sample_times import jumps
from oblique_impact.progress import OnProgress, Progress, silent
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style
from oblique_impact.scenario.messages import one_of

Format = Literal["pvd", "xdmf", "csv"]

FRAMES = 1000  # of an export that asks for nothing else, besides those at events
#: formats, and what reads them
READERS = {
    "pvd": "ParaView, PyVista",
    "xdmf": 'ParaView (choose "Xdmf3 Reader S"), PyVista, meshio',
    "csv": "pandas, spreadsheets",
}


@dataclass(frozen=True)
class Exported:
    """A time series on disk."""

    file: Path  # what a reader opens
    format: Format
    samples: int  # that became frames,
    of: int  # of so many
    span: tuple[float, float]  # first and last time (s)
    factor: float  # by which the bending is magnified; 1 for true shapes


def export(
    history: History,
    out: str | os.PathLike[str],
    *,
    format: Format | None = None,
    every: int | None = None,
    between: tuple[float, float] | None = None,
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
    target, format = _target(Path(out), format)
    samples = chosen_samples(history, 1 if format == "csv" and every is None else every, between)
    story = story_of([history], Style(deformation=deformation))
    write = {"pvd": writers.write_pvd, "xdmf": writers.write_xdmf, "csv": writers.write_csv}[format]
    prepare_folder(target.parent)
    on_progress(Progress(0, samples.size))
    try:
        with tempfile.TemporaryDirectory(prefix=".export.", dir=target.parent) as folder:
            with np.errstate(over="ignore", invalid="ignore"):  # runs that blew up hold numbers of any size
                made = write(
                    story, samples, Path(folder), target.stem, lambda n: on_progress(Progress(n, samples.size))
                )
            for path in made:  # what is opened last: so it never lists what is not there
                place = target.parent / path.name
                if place.is_dir():
                    shutil.rmtree(place)
                os.replace(path, place)
    except OSError as error:
        raise cannot_write(target, error) from None
    times = history["time"].values
    first, last = times[samples[[0, -1]]].tolist()
    return Exported(target, format, samples.size, times.size, (first, last), story.factor)


def _target(out: Path, format: str | None) -> tuple[Path, Format]:
    """Return the file to write and its format.

    Raises InputError if the format is unknown or contradicts the suffix, or if something is in the way.
    """
    format = format or out.suffix.lower().removeprefix(".")
    if format not in READERS:
        raise InputError(f"--format {format or 'missing'}: {one_of(format, READERS)}")
    if out.suffix and out.suffix.lower() != f".{format}":
        raise InputError(f"--out {out}: should end in .{format} for --format {format}, or have no suffix")
    target = out if out.suffix else Path(f"{out}.{format}")
    if format == "xdmf" and ":" in target.name:
        raise InputError(f"--out {target}: a colon ends the name of a file in XDMF: choose another name")
    # a folder that an earlier export made is replaced, another one is not
    frames = target.with_suffix("")
    try:
        taken = target.is_dir() or (
            format == "pvd" and frames.is_dir() and any(path.suffix != ".vtp" for path in frames.iterdir())
        )
    except OSError as error:  # a name that is too long
        raise cannot_write(target, error) from None
    if taken:
        raise InputError(f"--out {target}: the folder {frames} holds other files: choose another name")
    numbers = target.with_suffix(".h5")
    if format == "xdmf" and numbers.exists() and not target.exists():
        raise InputError(f"--out {target}: {numbers} is in the way and not of an export: choose another name")
    return target, cast(Format, format)


def chosen_samples(
    history: History, every: int | None = None, between: tuple[float, float] | None = None
) -> NDArray[np.int64]:
    """Return the numbers of the samples that become frames, ascending; see `export`.

    Samples whose shape is not finite (the last ones of a run that diverged) are left out.  Raises InputError if no
    sample is left.
    """
    first, last = between or (-np.inf, np.inf)
    if every is not None and every < 1:
        raise InputError(f"--every {every}: should be at least 1")
    if not first < last:
        raise InputError(f"--between {first:g},{last:g}: should be two times in s, the first one earlier")
    time = np.asarray(history["time"].values, dtype=float)
    side = sides(time)
    # both sides of a jump are of one instant: a span that ends at an event keeps both
    instant = np.where(side > 0, np.roll(time, 1), time)
    shapes = [history[name].values.reshape(time.size, -1) for name in ("theta", "ux", "uy")]
    wanted = np.isfinite(np.concatenate(shapes, axis=1)).all(axis=1) & (instant >= first) & (instant <= last)
    if not wanted.any():
        raise InputError(f"history: no sample is left; it covers {time[0]:g} to {time[-1]:g} s")
    chosen = np.isin(time, [event.time for event in history.events]) | (side != 0)
    chosen[-1] = True
    if every is not None:
        chosen[::every] = True
    else:
        left = np.flatnonzero(wanted)
        if left.size > FRAMES:
            left = left[np.searchsorted(time[left], np.linspace(time[left[0]], time[left[-1]], FRAMES))]
        chosen[left] = True
    return np.flatnonzero(wanted & chosen)


def sides(time: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return -1 for samples left of a jump, 1 for those right of it, 0 elsewhere."""
    jump = jumps(time)
    right, left = np.append(False, jump), np.append(jump, False)
    return np.where(right, 1, np.where(left, -1, 0))
