"""Run many scenarios and measure them into one pandas frame, which is kept on disk and resumed."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pandas as pd

from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, prepare_folder, write_whole
from oblique_impact.history.provenance import source_digest
from oblique_impact.progress import OnProgress, Progress, silent
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.studies.measure import COLUMNS, CRASHED, INVALID, Task, failed, measure_run
from oblique_impact.validation.studies.parallel import SOURCE, Crash, check_limits, compute_each
from oblique_impact.validation.studies.quantities import quantity

#: the frame of a study in its folder
TABLE = "results.parquet"
#: s between two writes of the frame while runs are under way
_SAVE_EVERY = 2.0


@dataclass(frozen=True)
class Run:
    """One run of a study.

    Attributes
    ----------
    labels : mapping
        Entries of its row that tell it from others.
    scenario : Scenario or None
        None if it is not possible, for the reason `fault`.
    quantities : tuple of str
        What is measured.
    urgency : float
        Runs of a larger one begin earlier: those that take longest.
    """

    labels: Mapping[str, Any]
    scenario: Scenario | None
    quantities: tuple[str, ...]
    fault: str = ""
    urgency: float = 0.0


@dataclass(frozen=True)
class Limits:
    """Where and how long runs may run: processes of this machine, or a Dask scheduler; wall time (s) of each."""

    workers: int | None = None
    scheduler: str | None = None
    timeout: float | None = None

    def __post_init__(self) -> None:
        check_limits(self.scheduler, self.workers, self.timeout)


@dataclass
class _Kept:
    """Rows by key, on disk as a frame if there is a folder."""

    runs: Sequence[Run]
    keys: list[str]
    path: Path | None
    units: Mapping[str, str]
    rows: dict[str, dict[str, Any]] = field(default_factory=dict)
    saved: float = field(default_factory=time.monotonic)

    def frame(self) -> pd.DataFrame:
        """Return the rows that are there, in the order of the runs, with units and meanings as `attrs`."""
        pairs = zip(self.runs, self.keys, strict=True)
        rows = [{**run.labels, **self.rows[key], "key": key} for run, key in pairs if key in self.rows]
        names = dict.fromkeys(name for run in self.runs for name in run.quantities)
        labels = dict.fromkeys(name for run in self.runs for name in run.labels)
        found = pd.DataFrame(rows, columns=[*labels, *names, *COLUMNS, "key"])
        found = found.astype(dict.fromkeys(names, float))
        about = {name: (quantity(name).unit, quantity(name).meaning) for name in names}
        about |= {name: (unit, meaning) for name, (_, unit, meaning) in COLUMNS.items()}
        found.attrs = {
            "units": {**self.units, **{name: unit for name, (unit, _) in about.items()}},
            "meanings": {name: meaning for name, (_, meaning) in about.items()},
        }
        return found

    def save(self) -> None:
        """Write the frame, whole or not at all."""
        self.saved = time.monotonic()
        if self.path is None:
            return
        try:
            write_whole(self.path, lambda file: self.frame().to_parquet(file, index=False))
        except OSError as error:
            raise cannot_write(self.path, error) from None


def run_study(
    runs: Sequence[Run],
    folder: str | os.PathLike[str] | None = None,
    *,
    limits: Limits = Limits(),
    units: Mapping[str, str] = MappingProxyType({}),
    histories: bool = False,
    exclusive: bool = False,
    on_progress: OnProgress = silent,
) -> pd.DataFrame:
    """Run what is not yet in the folder, and return the frame of all runs.

    Parameters
    ----------
    runs : sequence of Run
        With the labels that make them rows.
    folder : path, optional
        Where results.parquet is kept, from some seconds after the first run on.  A row is taken from there if
        scenario, quantities and source are the same.
    limits : Limits
        Processes, cluster, timeout.
    units : mapping
        Units of the labels.
    histories : bool
        Keep the history of each run in histories/NUMBER, counted from 1.
    exclusive : bool
        Refuse a folder with rows that are none of these runs, rather than replace them.
    on_progress : callable
        Called with a :class:`~oblique_impact.progress.Progress` before the first and after each run.

    Returns
    -------
    DataFrame
        A row for each run, in their order: labels, quantities (NaN where a run does not have one), `COLUMNS`.

    Raises
    ------
    InputError
        In one line for a folder that cannot be used.
    KeyboardInterrupt
        After Ctrl-C; with a folder the finished rows are kept.
    """
    path = None if folder is None else prepare_folder(folder) / TABLE
    kept = _Kept(runs, [_key(run) for run in runs], path, units)
    if path is not None and path.exists():
        kept.rows = _read(path, set(kept.keys), exclusive)
    for run, key in zip(runs, kept.keys, strict=True):
        if run.scenario is None:
            kept.rows[key] = failed(INVALID, run.fault)
    left = [n for n, key in enumerate(kept.keys) if key not in kept.rows]
    left.sort(key=lambda n: -runs[n].urgency)
    done = len(runs) - len(left)
    on_progress(Progress(done, len(runs)))
    tasks = [Task(runs[n].scenario, runs[n].quantities, histories, limits.timeout) for n in left]  # type: ignore[arg-type]
    try:
        for place, found in compute_each(measure_run, tasks, limits.workers, limits.scheduler):
            number = left[place]
            row, files = (failed(CRASHED, found.reason), {}) if isinstance(found, Crash) else found
            if files and path is not None:
                _keep_history(path.parent / "histories" / f"{number + 1:06d}", files)
            kept.rows[kept.keys[number]] = row
            if time.monotonic() - kept.saved > _SAVE_EVERY:
                kept.save()
            done += 1
            on_progress(Progress(done, len(runs), ", ".join(map(str, runs[number].labels.values()))))
    except KeyboardInterrupt:
        if path is None:
            raise
        words = f"{done} of {len(runs)} runs are kept; the same command goes on with the others"
        raise KeyboardInterrupt(words) from None
    finally:
        kept.save()
    return kept.frame()


def _key(run: Run) -> str:
    """Hash of all that decides about a row."""
    scenario = "" if run.scenario is None else run.scenario.model_dump_json()
    decisive = json.dumps([scenario, run.quantities, run.fault, source_digest(SOURCE)])
    return hashlib.sha256(decisive.encode()).hexdigest()[:16]


def _read(path: Path, keys: set[str], exclusive: bool) -> dict[str, dict[str, Any]]:
    """Return the rows of a frame on disk that have these keys."""
    try:
        frame = pd.read_parquet(path)
        rows = {row["key"]: row for row in frame.to_dict("records")}
    except (OSError, ValueError, KeyError) as error:
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"{path}: not a readable table: {reason}; delete it, and its runs are repeated") from None
    if exclusive and not rows.keys() <= keys:
        raise InputError(
            f"--out {path.parent}: holds runs of another study, or of another version; choose another folder, or "
            "delete this one"
        )
    return {key: row for key, row in rows.items() if key in keys}


def _keep_history(folder: Path, files: Mapping[str, bytes]) -> None:
    partial = folder.with_name(f".{folder.name}.part")
    try:
        for old in (partial, folder):
            shutil.rmtree(old, ignore_errors=True)
        partial.mkdir(parents=True)
        for name, content in files.items():
            (partial / name).write_bytes(content)
        os.replace(partial, folder)
    except OSError as error:
        raise cannot_write(folder, error) from None
