"""Run many scenarios and measure them into one pandas frame, which is kept on disk and resumed."""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pandas as pd

from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import prepare_folder, save_all, save_whole
from oblique_impact.history.history import History
from oblique_impact.history.provenance import source_digest
from oblique_impact.kernels.compiling import clock
from oblique_impact.progress import OnProgress, Progress, Status, silent
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.studies.parallel import SOURCE, Crash, check_limits, compute_each
from oblique_impact.validation.studies.periodic import MotionState, PeriodicSection, steady_state
from oblique_impact.validation.studies.quantities import VARIABLES, GapError, not_determined, quantity

#: the frame of a study in its folder
TABLE = "results.parquet"
#: s between two writes of the frame while runs are under way
_SAVE_EVERY = 2.0
#: runs that go on from each other and are handed out together: many, lest some processes wait for others; few,
#: lest an interrupt loses much
_PIECE = 10

#: outcomes of rows besides those of the physics
FAILURES = INVALID, ERROR, CRASHED, TIMEOUT = "invalid", "error", "crashed", "timeout"

#: what a first macro-collision can be, from the least to the most; "stopped" by another cause than Painleve
REGIMES = ("no contact", "slip", "reversal", "stick", "painleve", "stopped")

#: columns of every study besides its labels and quantities: value of a run that failed, unit, meaning
COLUMNS: dict[str, tuple[Any, str, str]] = {
    "regime": ("", "", f"first macro-collision: {', '.join(REGIMES)}"),
    "outcome": ("", "", "how the run ended"),
    "message": ("", "", "why, if it did not reach its end time"),
    "gaps": ("", "", "why quantities are missing, a line each"),
    "warnings": ("", "", "warnings of the run, a line each"),
    "undetermined": ("", "", "quantities that have no limit over modes or elements, and why, a line each"),
    "stopped_at": (math.nan, "s", "time that the run reached"),
    "steps": (0, "1", "steps"),
    "events": (0, "1", "events"),
    "energy": (math.nan, "J", "the larger of initial and final energy"),
    "wall_time": (0.0, "s", "wall time of the run; the only column that differs from time to time"),
}
#: columns of periodic responses besides: lists of numbers, as JSON
SAMPLES, STATE, SECTION, SPECTRUM = "samples", "state", "section", "spectrum"
#: and numbers
LEAST, LARGEST = "least", "largest"


@dataclass(frozen=True)
class StudyRun:
    """One run of a study."""

    #: entries of its row that tell it from others
    labels: Mapping[str, Any]
    #: None if it is not possible, for the reason `fault`
    scenario: Scenario | None
    #: what is measured
    quantities: tuple[str, ...]
    fault: str = ""
    #: measure the steady state on a shaken base, not the run itself
    periodic: PeriodicSection | None = None
    #: seek the steady state from the end of the run before it in the study, not from rest
    continued: bool = False

    @property
    def key(self) -> str:
        """Hash of all that decides about its row."""
        scenario = "" if self.scenario is None else self.scenario.model_dump_json()
        decisive = [scenario, self.quantities, self.fault, source_digest(SOURCE)]
        return _hash([*decisive, self.periodic.model_dump()] if self.periodic else decisive)


class OutOfTimeError(Exception):
    """Raised in a run that takes longer than it may."""


def run_study(
    runs: Sequence[StudyRun],
    folder: str | os.PathLike[str] | None = None,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    timeout: float | None = None,
    units: Mapping[str, str] = MappingProxyType({}),
    histories: bool = False,
    exclusive: bool = False,
    on_progress: OnProgress = silent,
) -> pd.DataFrame:
    """Run what is not yet in the folder, and return the frame of all runs.

    Parameters
    ----------
    runs : sequence of StudyRun
        With the labels that make them rows.  The last ones begin first: put those that take longest there.
    folder : path, optional
        Where results.parquet is kept, from some seconds after the first run on.  A row is taken from there if
        scenario, quantities and source are the same.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers are used.
    workers : int, optional
        Parallel processes of this machine; default: the cores.  With one, everything runs in this process.
    timeout : float, optional
        Wall time (s) that a run may take; one that takes longer is a row with the outcome "timeout".
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
        A row for each run, in their order: labels, quantities (NaN where a run does not have one), `COLUMNS`; with
        units and meanings as `attrs`.

    Raises
    ------
    InputError
        In one line for a folder or a scheduler that cannot be used.
    KeyboardInterrupt
        After Ctrl-C; with a folder the finished rows are kept.
    """
    check_limits(scheduler, workers, timeout)
    path = None if folder is None else prepare_folder(folder) / TABLE
    keys = list[str]()
    for run in runs:
        keys.append(_hash([keys[-1], run.key]) if run.continued else run.key)
    rows = {key: failed(INVALID, run.fault) for run, key in zip(runs, keys, strict=True) if run.scenario is None}
    if path is not None and path.exists():
        rows |= _read(path, set(keys), exclusive)
    done, saved = sum(key in rows for key in keys), time.monotonic()
    on_progress(Progress(done, len(runs)))
    measured = partial(measure_piece, histories=histories, timeout=timeout)
    try:
        for number, found in _each(measured, runs, keys, rows, workers, scheduler):
            row, files = (failed(CRASHED, found.reason), {}) if isinstance(found, Crash) else found
            if files and path is not None:
                # before its row: a folder that is not complete has no row, and its run is repeated
                save_all(path.parent / "histories" / f"{number + 1:06d}", files)
            rows[keys[number]] = row
            if time.monotonic() - saved > _SAVE_EVERY:
                _save(_frame(runs, keys, rows, units), path)
                saved = time.monotonic()
            done += 1
            on_progress(Progress(done, len(runs), ", ".join(map(str, runs[number].labels.values()))))
    except KeyboardInterrupt:
        if path is None:
            raise
        words = f"{done} of {len(runs)} runs are kept; the same command goes on with the others"
        raise KeyboardInterrupt(words) from None
    finally:
        frame = _frame(runs, keys, rows, units)
        _save(frame, path)
    return frame


def _hash(decisive: list[Any]) -> str:
    return hashlib.sha256(json.dumps(decisive).encode()).hexdigest()[:16]


def _each(
    measured: Callable[[Sequence[tuple[StudyRun, MotionState | None]]], Any],
    runs: Sequence[StudyRun],
    keys: Sequence[str],
    rows: Mapping[str, Mapping[str, Any]],
    workers: int | None,
    scheduler: str | None,
) -> Iterator[tuple[int, Any]]:
    """Yield index and result of each run without a row, those that go on from others after these."""
    chains = list[list[int]]()  # of runs that go on from each other, those without a row
    for n, run in enumerate(runs):
        if not run.continued:
            chains.append([])
        if keys[n] not in rows:
            chains[-1].append(n)

    def before(n: int) -> MotionState | None:
        return motion_state(rows.get(keys[n - 1], {})) if runs[n].continued else None

    for start in range(0, max(map(len, chains), default=0), _PIECE):
        pieces = [chain[start : start + _PIECE] for chain in reversed(chains) if len(chain) > start]
        items = [[(runs[n], before(n)) for n in piece] for piece in pieces]
        for place, found in compute_each(measured, items, workers, scheduler):
            results = [found] * len(pieces[place]) if isinstance(found, Crash) else found
            yield from zip(pieces[place], results, strict=True)


def motion_state(row: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the state in which a run has ended; None if it failed."""
    if not row.get(STATE):
        return None
    q, qd = json.loads(row[STATE])
    return np.array(q), np.array(qd)


def measure_piece(
    piece: Sequence[tuple[StudyRun, MotionState | None]], histories: bool, timeout: float | None
) -> list[tuple[dict[str, Any], dict[str, bytes]]]:
    """Return rows and files of runs, see `measure_run`; one without a state goes on from the one before it."""
    found = list[tuple[dict[str, Any], dict[str, bytes]]]()
    for run, state in piece:
        before = motion_state(found[-1][0]) if found and state is None else state
        found.append(measure_run(run, before, histories, timeout))
    return found


def measure_run(
    run: StudyRun, state: MotionState | None, histories: bool, timeout: float | None
) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Simulate and measure one run, in whatever process; returns its row and the files of its history, if wanted.

    A steady state is sought from `state`.  A failure becomes a row that says so.  `timeout` (s) bounds the wall
    time but for what is compiled in it.
    """
    assert run.scenario is not None
    started, files = time.perf_counter(), dict[str, bytes]()
    try:
        with clock() as marching:

            def check_time(status: Status) -> None:
                if timeout is not None and marching.seconds > timeout:
                    raise OutOfTimeError(f"took longer than {timeout:g} s, until t = {status.time:.6g} s")

            if run.periodic:
                history = steady_state(run.scenario, state, run.periodic, check_time)
            else:
                history = simulate(run.scenario, check_time)
        row = measure(history, run.quantities)
        if histories:  # as bytes: a worker of a cluster may have no folder in common with us
            files = history.files()
    except InputError as error:
        row = failed(INVALID, str(error))
    except OutOfTimeError as error:
        row = failed(TIMEOUT, str(error))
    except Exception as error:
        row = failed(ERROR, f"{type(error).__name__}: {error}")
    row["wall_time"] = time.perf_counter() - started
    return row, files


def failed(outcome: str, message: str) -> dict[str, Any]:
    """Return the row of a failed run: the reason, and no quantities."""
    row = {name: empty for name, (empty, *_) in COLUMNS.items()}
    return row | {"outcome": outcome, "message": " ".join(message.split())[:500]}


def measure(history: History, quantities: Sequence[str]) -> dict[str, Any]:
    """Return the row of a run: the quantities, NaN where it does not have one, and `COLUMNS`."""
    row, gaps = dict[str, Any](), list[str]()
    for name in quantities:
        try:
            row[name] = float(quantity(name).measure(history))
        except GapError as gap:
            row[name] = math.nan
            gaps.append(f"{name}: {gap}")
    undetermined = not_determined(quantities, history)
    if "periodic" in history.summary:
        found = history.summary["periodic"]
        row |= {name: json.dumps(_short(found[name])) for name in (SECTION, SPECTRUM)}
        row[SAMPLES] = json.dumps(found[SAMPLES])
        row |= {name: found[name] for name in (LEAST, LARGEST)}
        row[STATE] = json.dumps([history[name].values[-1].tolist() for name in ("q", "qd")])
    return row | {
        "regime": regime(history),
        "outcome": history.outcome.label,
        "message": "" if history.outcome is Outcome.COMPLETED else history.summary["message"],
        "gaps": "\n".join(gaps),
        "warnings": "\n".join(history.summary.get("warnings", ())),
        "undetermined": "\n".join(f"{name}: {why}" for name, why in undetermined.items()),
        "stopped_at": history.end_time,
        "steps": history.steps,
        "events": len(history.events),
        "energy": max(abs(history.balance[key]) for key in ("initial", "final")),
    }


def _short(values: Any) -> Any:
    """Return numbers in lists with six digits, as a picture has them."""
    return [_short(value) for value in values] if isinstance(values, list) else float(f"{values:.6g}")


def regime(history: History) -> str:
    """Name what the first macro-collision of a run is: one of `REGIMES`.

    The strongest of what happens in it counts: stick before reversal before slip.
    """
    collisions, outcome = history.macro_collisions, history.outcome
    if outcome is not Outcome.COMPLETED:
        stop = history.end_time
        if not collisions or (len(collisions) == 1 and stop - collisions[0]["end"] < history.clustering_time):
            return "painleve" if outcome is Outcome.PAINLEVE else "stopped"
    if not collisions:
        return "no contact"
    start, end = collisions[0]["start"], collisions[0]["end"]
    inside = [event for event in history.events if start <= event.time <= end]
    if any(event.state is State.STICK for event in inside):
        return "stick"
    return "reversal" if any(event.kind is EventKind.REVERSAL for event in inside) else "slip"


def reasons(lines: str) -> dict[str, str]:
    """Return the reasons by quantity of one entry of `gaps` or `undetermined`."""
    return dict(line.split(": ", 1) for line in lines.splitlines())


def same_warnings(runs: Iterable[tuple[str, str]]) -> list[tuple[str, list[str]]]:
    """Group the warnings of labelled runs by their text: that of the first run that has it, and the labels of all.

    Texts that differ in their numbers alone are the same.
    """
    found: dict[str, tuple[str, list[str]]] = {}
    for label, warnings in runs:
        for warning in warnings.splitlines():
            kind = re.sub(r"\d[\d.e+-]*", "#", warning)
            found.setdefault(kind, (warning, []))[1].append(label)
    return list(found.values())


# --- on disk


class _Shared(dict[str, str]):
    """Texts by column that all copies share: pandas copies the attributes of a frame with each of its columns."""

    def __deepcopy__(self, memo: object) -> _Shared:
        return self


def _frame(
    runs: Sequence[StudyRun], keys: Sequence[str], rows: Mapping[str, Mapping[str, Any]], units: Mapping[str, str]
) -> pd.DataFrame:
    """Return the rows that are there, in the order of the runs, with units and meanings."""
    there = [{**rows[key], **run.labels, "key": key} for run, key in zip(runs, keys, strict=True) if key in rows]
    names = dict.fromkeys(name for run in runs for name in run.quantities)
    labels, columns = dict.fromkeys(name for run in runs for name in run.labels), COLUMNS
    if periodic := next((run.periodic for run in runs if run.periodic), None):
        unit, meaning = VARIABLES[periodic.sample]
        columns = {
            LEAST: (math.nan, unit, f"least {meaning} over the period"),
            LARGEST: (math.nan, unit, f"largest {meaning} over the period"),
            SAMPLES: ("", unit, f"{meaning} at whole periods of the drive, of one period of the response"),
            SECTION: ("", "", f"{meaning} and its rate at whole periods: of one that does not repeat many"),
            SPECTRUM: (
                "",
                unit,
                f"mean and amplitudes of the {meaning} at multiples of 1/(period of the response)",
            ),
            STATE: ("", "", "coordinates and velocities at the end, from which the next run goes on"),
        } | COLUMNS
    frame = pd.DataFrame(there, columns=[*labels, *names, *columns, "key"])
    frame = frame.astype(dict.fromkeys(names, float)).fillna(
        dict.fromkeys((SAMPLES, STATE, SECTION, SPECTRUM), "")
    )
    about = {name: (quantity(name).unit, quantity(name).meaning) for name in names}
    about |= {name: (unit, meaning) for name, (_, unit, meaning) in columns.items()}
    frame.attrs = {
        "units": _Shared({**units, **{name: unit for name, (unit, _) in about.items()}}),
        "meanings": _Shared({name: meaning for name, (_, meaning) in about.items()}),
    }
    return frame


def _save(frame: pd.DataFrame, path: Path | None) -> None:
    """Write the frame, whole or not at all, if there is a folder for it."""
    if path is not None:
        save_whole(path, lambda file: frame.to_parquet(file, index=False))


def _read(path: Path, keys: set[str], exclusive: bool) -> dict[str, dict[str, Any]]:
    """Return the rows of a frame on disk that have these keys."""
    try:
        rows = {row["key"]: row for row in pd.read_parquet(path).to_dict("records")}
    except (OSError, ValueError, KeyError) as error:
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"{path}: not a readable table: {reason}; delete it, and its runs are repeated") from None
    if exclusive and not rows.keys() <= keys:
        raise InputError(
            f"--out {path.parent}: holds runs of another study, or of another version; choose another folder, or "
            "delete this one"
        )
    return {key: row for key, row in rows.items() if key in keys}
