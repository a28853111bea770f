"""Whether the numbers of an impact mean anything: shadow runs from initial angles that differ by next to nothing.

Each shadow starts at another angle, theta_0 + d with |d| of a hundred-millionth and a millionth of a radian;
nothing that one could measure.  By how much a time t of the run differs is its growth:

    growth = max |t(theta_0 + d) - t(theta_0)| / (|d| T),   T the time of the first touch-down

A macro-collision whose start has a growth of at most 10 is predictable; from 1000 on it is not: rounding moves it.
That is said of a model as it stands: a coarse one may be predictable and far from its limit, which `refine` shows.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.files import writing
from oblique_impact.history.provenance import named_in
from oblique_impact.progress import OnProgress, Progress, silent
from oblique_impact.scenario.scenario import Scenario, require_scenario
from validation.measuring import Row, Task, measure_each
from validation.parallel import check_limits
from validation.refinement.study import open_journal

Array = NDArray[np.float64]

PREDICTABLE, SENSITIVE, UNPREDICTABLE, UNKNOWN = "predictable", "sensitive", "not predictable", "no verdict"
#: growths that part the verdicts
SMALL, LARGE = 10.0, 1e3
#: rad
PERTURBATIONS = (1e-8, 1e-6)
SHADOWS = 4
_MOST_SHADOWS = 1000
_MOST_EVENTS = 400  # whose times are followed


@dataclass(frozen=True)
class Case:
    """A scenario whose predictability is asked for, with a name and words for the report."""

    name: str
    scenario: Scenario
    text: str = ""


@dataclass(frozen=True)
class Collision:
    """What the shadows say of one macro-collision.

    Attributes
    ----------
    number : int
        From 1.
    start, impulse : float
        Of the unperturbed run (s, N s).
    contacts : tuple of int
        The fewest and the most among the runs.
    spread : tuple of float
        Largest difference of the start (s), by perturbation.
    impulse_spread : tuple of float
        Largest difference of the impulse (N s), by perturbation.
    growth : float
        Of the start; infinite if a shadow does not have this macro-collision.
    verdict : str
        "predictable", "sensitive", "not predictable" or "no verdict".
    """

    number: int
    start: float
    impulse: float
    contacts: tuple[int, int]
    spread: tuple[float, ...]
    impulse_spread: tuple[float, ...]
    growth: float
    verdict: str


@dataclass(frozen=True)
class CaseResult:
    """Shadows of one case.

    Attributes
    ----------
    offsets : ndarray, shape (shadows,)
        Of the initial angle (rad).
    events : ndarray, shape (events,)
        Times of the unperturbed run (s).
    shadows : ndarray, shape (shadows, events)
        The same of the shadows; NaN where one has fewer.
    unit_time : float
        T (s).
    """

    case: Case
    perturbations: tuple[float, ...]
    offsets: Array
    events: Array
    shadows: Array
    collisions: tuple[Collision, ...]
    unit_time: float
    rows: tuple[Row, ...]

    @property
    def growth(self) -> Array:
        """Growth of each event's time, (events,); infinite where a shadow does not have it."""
        shifts = np.abs(self.shadows - self.events) / (np.abs(self.offsets)[:, None] * self.unit_time)
        return np.asarray(np.max(np.where(np.isfinite(shifts), shifts, np.inf), axis=0))

    @property
    def horizon(self) -> float:
        """Time (s) of the last event before the first one that is not predictable; infinite if all are."""
        lost = np.flatnonzero(self.growth >= LARGE)
        if not lost.size:
            return math.inf
        return float(self.events[lost[0] - 1]) if lost[0] else 0.0


@dataclass(frozen=True)
class Predictability:
    """A predictability study; `report` is its page, if one was written."""

    name: str
    cases: tuple[CaseResult, ...]
    seconds: float
    report: Path | None = None


def predictability(
    scenario: Scenario | Sequence[Case],
    *,
    perturbations: Sequence[float] = PERTURBATIONS,
    shadows: int = SHADOWS,
    out: str | os.PathLike[str] | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    timeout: float | None = None,
    name: str = "scenario",
    command: str = "",
    on_progress: OnProgress = silent,
) -> Predictability:
    """Say of each macro-collision whether its numbers are determined, by shadow runs.

    Parameters
    ----------
    scenario : Scenario or sequence of Case
        What is tried; the shipped cases are `validation.refinement.shipped.predictability_cases()`.
    perturbations : sequence of float
        Largest changes of the initial angle (rad).
    shadows : int
        Runs per perturbation d, evenly from -d to d without 0.
    out : path, optional
        Folder for report.html, results.json and results.csv, where an interrupted study goes on.
    scheduler, workers, timeout, on_progress
        As for :func:`validation.refine`.
    name, command : str
        What the scenario is called, and how to repeat the study, for the report.

    Returns
    -------
    Predictability
        Growth of each event's time and a verdict per macro-collision.

    Raises
    ------
    InputError
        In one line if a perturbation is not possible.

    Examples
    --------
    >>> from oblique_impact import Scenario
    >>> from validation import predictability
    >>> soft = Scenario.builtin("elastic-stop").replace(end_time=0.4)
    >>> predictability(soft, shadows=2, workers=1).cases[0].collisions[0].verdict
    'predictable'
    """
    from validation.refinement.predictability_report import write_predictability

    check_limits(scheduler, workers, timeout)
    cases = _cases(scenario, name)
    _check(perturbations, shadows)
    started = time.perf_counter()
    wanted = [_offsets(case.scenario, perturbations, shadows) for case in cases]
    with nullcontext() if out is None else writing(out) as folder:
        tasks = [
            Task(0, shadow, _names(), timeout=timeout)
            for case, offsets in zip(cases, wanted, strict=True)
            for shadow in _scenarios(case.scenario, offsets)
        ]
        tasks = [task._replace(number=number) for number, task in enumerate(tasks)]
        rows = _measure(tasks, folder, on_progress, workers, scheduler)
        found, first = [], 0
        for case, offsets in zip(cases, wanted, strict=True):
            count = 1 + len(offsets)
            found.append(judge(case, tuple(perturbations), offsets, rows[first : first + count]))
            first += count
        result = Predictability(name, tuple(found), time.perf_counter() - started)
        return result if folder is None else replace(result, report=write_predictability(folder, result, command))


def _cases(scenario: Scenario | Sequence[Case], name: str) -> list[Case]:
    if isinstance(scenario, Sequence):
        return list(scenario)
    require_scenario(scenario, "predictability")
    return [Case(name, scenario)]


def _check(perturbations: Sequence[float], shadows: int) -> None:
    if not perturbations or not all(0.0 < d <= 0.1 for d in perturbations):
        text = ",".join(f"{d:g}" for d in perturbations)
        raise InputError(f"--perturbations {text}: should be angles in rad, above 0 and at most 0.1")
    if not 2 <= shadows <= _MOST_SHADOWS:
        raise InputError(f"--shadows {shadows}: should be from 2 to {_MOST_SHADOWS}")


def _offsets(scenario: Scenario, perturbations: Sequence[float], shadows: int) -> Array:
    """Return the offsets of the shadows (rad), those that start below the slope mirrored."""
    if not scenario.contact.enabled:
        raise InputError("contact.enabled = false: without contact there is nothing to predict")
    half = np.arange(1, shadows // 2 + 1) / (shadows // 2)
    parts = np.concatenate([-half[::-1], half, [0.5] if shadows % 2 else []])
    offsets = np.concatenate([d * parts for d in perturbations])
    start = scenario.initial.angle
    return np.array([d if _possible(scenario, start + d) else -d for d in offsets])


def _possible(scenario: Scenario, angle: float) -> bool:
    try:
        scenario.replace(initial__angle=angle)
    except InputError:
        return False
    return True


def _scenarios(scenario: Scenario, offsets: Array) -> list[Scenario]:
    return [scenario, *(scenario.replace(initial__angle=scenario.initial.angle + float(d)) for d in offsets)]


_MOST_COLLISIONS = 20


def _names() -> tuple[str, ...]:
    numbers = range(1, _MOST_COLLISIONS + 1)
    of_collisions = (
        f"{kind}:{n}" for n in numbers for kind in ("start", "collision_impulse", "collision_contacts")
    )
    return (*of_collisions, *(f"event:{n}" for n in range(1, _MOST_EVENTS + 1)))


def _measure(
    tasks: list[Task], folder: Path | None, on_progress: OnProgress, workers: int | None, scheduler: str | None
) -> list[Row]:
    journal = None if folder is None else open_journal(folder, tasks, named_in(tasks[0].base))
    rows = {row["run"]: row for row in journal.rows()} if journal else {}
    on_progress(Progress(len(rows), len(tasks)))
    try:
        for row, _ in measure_each([t for t in tasks if t.number not in rows], workers, scheduler):
            rows[row["run"]] = row
            if journal:
                journal.add(row)
            on_progress(Progress(len(rows), len(tasks)))
    except KeyboardInterrupt:
        kept = f"{len(rows)} of {len(tasks)} runs are kept; the same command goes on with the others"
        raise KeyboardInterrupt(*([kept] if journal else [])) from None
    if journal:
        journal.remove()
    return [rows[number] for number in range(len(tasks))]


def judge(case: Case, perturbations: tuple[float, ...], offsets: Array, rows: Sequence[Row]) -> CaseResult:
    """Judge a case by its rows, that of the unperturbed run first."""

    def column(name: str) -> Array:
        return np.array([row["values"].get(name, math.nan) for row in rows])

    events = np.array([column(f"event:{n}") for n in range(1, _MOST_EVENTS + 1)])
    events = events[np.isfinite(events[:, 0])]
    unit = float(events[0, 0]) if events.size and events[0, 0] > 0.0 else case.scenario.end_time
    levels = np.array([_level(abs(d), perturbations) for d in offsets])
    collisions = []
    for number in range(1, _MOST_COLLISIONS + 1):
        start, impulse, contacts = (
            column(f"{kind}:{number}") for kind in ("start", "collision_impulse", "collision_contacts")
        )
        if not math.isfinite(start[0]):
            break
        shifts = np.abs(start[1:] - start[0])
        growth = float(np.max(np.where(np.isfinite(shifts), shifts, np.inf) / (np.abs(offsets) * unit)))
        known = contacts[np.isfinite(contacts)]
        collisions.append(
            Collision(
                number,
                float(start[0]),
                float(impulse[0]),
                (int(known.min()), int(known.max())) if known.size else (0, 0),
                tuple(float(np.max(shifts[levels == k])) for k in range(len(perturbations))),
                tuple(
                    float(np.max(np.abs(impulse[1:] - impulse[0])[levels == k])) for k in range(len(perturbations))
                ),
                growth,
                verdict_of(growth),
            )
        )
    return CaseResult(
        case, perturbations, offsets, events[:, 0], events[:, 1:].T, tuple(collisions), unit, tuple(rows)
    )


def _level(offset: float, perturbations: Sequence[float]) -> int:
    """Return to which perturbation a shadow belongs: the smallest that it does not exceed."""
    fitting = [k for k, d in enumerate(perturbations) if offset <= d * (1.0 + 1e-9)]
    return min(fitting, key=lambda k: perturbations[k])


def verdict_of(growth: float) -> str:
    """Return the verdict on a growth."""
    if math.isnan(growth):
        return UNKNOWN
    return PREDICTABLE if growth <= SMALL else SENSITIVE if growth < LARGE else UNPREDICTABLE


def lines(result: Predictability) -> list[str]:
    """Return what a study found in lines, for a terminal."""
    found = []
    for case in result.cases:
        found.append(f"{case.case.name}:")
        if not case.collisions:
            found.append(f"  no contact until {case.rows[0]['stopped_at']:.6g} s: {case.rows[0]['outcome']}")
        found += [
            f"  collision {c.number}: starts at {c.start:.9g} s, growth {c.growth:.3g}: {c.verdict}"
            for c in case.collisions
        ]
    return found
