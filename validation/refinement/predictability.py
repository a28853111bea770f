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
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.scenario.scenario import Scenario, require_scenario
from validation.measuring import FAILURES, Row, Task
from validation.parallel import check_limits
from validation.refinement.study import measure_rows
from validation.report.provenance import UNNAMED, call_text, scenario_text

Array = NDArray[np.float64]

PREDICTABLE, SENSITIVE, UNPREDICTABLE, UNKNOWN = "predictable", "sensitive", "not predictable", "no verdict"
#: growths that part the verdicts
SMALL, LARGE = 10.0, 1e3
#: rad
PERTURBATIONS = (1e-8, 1e-6)
SHADOWS = 4
_MOST_SHADOWS = 1000
#: whose times are followed
_MOST_COLLISIONS, _MOST_EVENTS = 20, 400


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
        Of the start; infinite if the physics stopped a shadow before it, NaN without shadows.
    lower_bound : bool
        Whether `growth` is no more than a lower bound, as a shadow came to its end before this macro-collision.
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
    lower_bound: bool
    verdict: str


@dataclass(frozen=True)
class CaseResult:
    """Shadows of one case.

    Attributes
    ----------
    offsets : ndarray, shape (shadows,)
        Of the initial angle (rad).
    amplitudes : ndarray, shape (shadows,)
        Perturbation (rad) to which each shadow belongs: the smallest that its offset does not exceed.
    events : ndarray, shape (events,)
        Times of the unperturbed run (s).
    shadows : ndarray, shape (shadows, events)
        The same of the shadows; NaN where one has fewer.
    growth : ndarray, shape (events,)
        Of each event's time, bounds and infinities as for a `Collision`.
    unit_time : float
        T (s).
    rows : tuple of Row
        Of the unperturbed run and the shadows.
    failed : tuple of (float, Row)
        Offsets and rows of the shadows that failed; nothing else here knows of them.
    """

    case: Case
    perturbations: tuple[float, ...]
    offsets: Array
    amplitudes: Array
    events: Array
    shadows: Array
    growth: Array
    collisions: tuple[Collision, ...]
    unit_time: float
    rows: tuple[Row, ...]
    failed: tuple[tuple[float, Row], ...]

    @property
    def horizon(self) -> float:
        """Time (s) of the last event before the first one that is not predictable; infinite if all are."""
        if not self.offsets.size:
            return math.nan
        lost = np.flatnonzero(self.growth >= LARGE)
        if not lost.size:
            return math.inf
        return float(self.events[lost[0] - 1]) if lost[0] else 0.0

    @property
    def remarks(self) -> list[str]:
        """Say why there are no collisions, and which shadows are left out."""
        row, said = self.rows[0], []
        if row["outcome"] in FAILURES:
            said.append(f"the unperturbed run failed: {row['outcome']}: {row['message']}")
        elif not self.collisions:
            words = ": ".join(filter(None, (row["outcome"], row["message"])))
            said.append(f"no contact until {row['stopped_at']:.6g} s: {words}")
        return said + [
            f"shadow at {offset:g} rad left out: {row['outcome']}: {row['message']}" for offset, row in self.failed
        ]


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
    name: str = UNNAMED,
    command: str | None = None,
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
        Runs per perturbation d, evenly from -d to d without 0; from 0 to d where -d lies below the slope.
    out : path, optional
        Folder for report.html, results.json and results.csv, where an interrupted study goes on.
    scheduler, workers, timeout, on_progress
        As for :func:`validation.refine`.
    name, command : str
        What the scenario is called, and how to repeat the study (default: this call), for the report.

    Returns
    -------
    Predictability
        Growth of each event's time and a verdict per macro-collision.

    Raises
    ------
    InputError
        In one line if a perturbation or the number of shadows is not possible, or there is no contact.

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
    repeat = command or call_text(
        "predictability",
        [scenario_text(name) if isinstance(scenario, Scenario) else "cases"],
        perturbations=None if tuple(perturbations) == PERTURBATIONS else list(perturbations),
        shadows=None if shadows == SHADOWS else shadows,
        out=None if out is None else os.fspath(out),
        scheduler=scheduler,
        workers=workers,
        timeout=timeout,
    )
    started = time.perf_counter()
    wanted = [_offsets(case.scenario, perturbations, shadows) for case in cases]
    runs = [
        (case.name, shadow)
        for case, offsets in zip(cases, wanted, strict=True)
        for shadow in _scenarios(case.scenario, offsets)
    ]
    names = _names()
    tasks = [Task(n, shadow, names, timeout=timeout, label=label) for n, (label, shadow) in enumerate(runs)]
    with nullcontext() if out is None else writing(out) as folder:
        rows = iter(measure_rows(tasks, folder, on_progress, workers, scheduler))
        found = tuple(
            judge(case, tuple(perturbations), offsets, list(islice(rows, 1 + len(offsets))))
            for case, offsets in zip(cases, wanted, strict=True)
        )
        result = Predictability(name, found, time.perf_counter() - started)
        return result if folder is None else replace(result, report=write_predictability(folder, result, repeat))


def _cases(scenario: Scenario | Sequence[Case], name: str) -> list[Case]:
    if isinstance(scenario, Sequence):
        return list(scenario)
    require_scenario(scenario, "predictability")
    return [Case(name, scenario)]


def _check(perturbations: Sequence[float], shadows: int) -> None:
    if not perturbations or not all(0.0 < d <= 0.1 for d in perturbations):
        given = "".join(f" {d:g}" for d in perturbations)
        raise InputError(f"perturbations{given}: should be angles in rad, above 0 and at most 0.1")
    if not 2 <= shadows <= _MOST_SHADOWS:
        raise InputError(f"shadows {shadows}: should be from 2 to {_MOST_SHADOWS}")


def _offsets(scenario: Scenario, perturbations: Sequence[float], shadows: int) -> Array:
    """Return the offsets of the shadows (rad), on one side only where the other one lies below the slope."""
    if not scenario.contact.enabled:
        raise InputError("contact.enabled = false: without contact there is nothing to predict")
    below, above = shadows // 2, shadows - shadows // 2
    both = np.concatenate([np.arange(-below, 0) / below, np.arange(1, above + 1) / above])
    one = np.arange(1, shadows + 1) / shadows
    start = scenario.initial.angle
    return np.concatenate(
        [
            d
            * (one if not _possible(scenario, start - d) else -one if not _possible(scenario, start + d) else both)
            for d in perturbations
        ]
    )


def _possible(scenario: Scenario, angle: float) -> bool:
    try:
        scenario.replace(initial__angle=angle)
    except InputError:
        return False
    return True


def _scenarios(scenario: Scenario, offsets: Array) -> list[Scenario]:
    return [scenario, *(scenario.replace(initial__angle=scenario.initial.angle + float(d)) for d in offsets)]


def _names() -> tuple[str, ...]:
    kinds = {"start": _MOST_COLLISIONS, "collision_impulse": _MOST_COLLISIONS}
    kinds |= {"collision_contacts": _MOST_COLLISIONS, "event": _MOST_EVENTS}
    return tuple(f"{kind}:{n}" for kind, most in kinds.items() for n in range(1, most + 1))


def judge(case: Case, perturbations: tuple[float, ...], offsets: Array, rows: Sequence[Row]) -> CaseResult:
    """Judge a case by its rows, that of the unperturbed run first."""
    pairs = list(zip(offsets.tolist(), rows[1:], strict=True))
    failed = tuple(pair for pair in pairs if pair[1]["outcome"] in FAILURES)
    pairs = [pair for pair in pairs if pair[1]["outcome"] not in FAILURES]
    offsets, rows = np.array([offset for offset, _ in pairs]), (rows[0], *(row for _, row in pairs))
    amplitudes = np.array([min(d for d in perturbations if abs(offset) <= d * (1.0 + 1e-9)) for offset in offsets])
    events = _columns(rows, "event", _MOST_EVENTS)
    events = events[:, np.isfinite(events[0])]
    unit = float(events[0, 0]) if events.size and events[0, 0] > 0.0 else case.scenario.end_time
    scale = np.abs(offsets)[:, None] * unit
    collisions = _collisions(rows, scale, [amplitudes == d for d in perturbations])
    growth = _largest(_shifts(rows, events) / scale)
    return CaseResult(
        *(case, perturbations, offsets, amplitudes, events[0], events[1:], growth, collisions, unit, rows, failed)
    )


def _collisions(rows: Sequence[Row], scale: Array, groups: Sequence[NDArray[np.bool_]]) -> tuple[Collision, ...]:
    """Judge the macro-collisions: a shift by `scale` (shadows, 1) is a growth of 1; a spread for each group."""
    starts = _columns(rows, "start", _MOST_COLLISIONS)
    starts = starts[:, np.isfinite(starts[0])]
    count = starts.shape[1]
    impulses, contacts = (_columns(rows, f"collision_{kind}", count) for kind in ("impulse", "contacts"))
    shifts, changes = _shifts(rows, starts), np.abs(impulses[1:] - impulses[0])
    growth = _largest(shifts / scale)
    bounded = np.isnan(starts[1:]).any(axis=0) & np.isfinite(growth)
    found = []
    for n in range(count):
        known = contacts[np.isfinite(contacts[:, n]), n]
        found.append(
            Collision(
                n + 1,
                float(starts[0, n]),
                float(impulses[0, n]),
                (int(known.min()), int(known.max())) if known.size else (0, 0),
                tuple(float(_largest(shifts[group, n])) for group in groups),
                tuple(float(_largest(changes[group, n])) for group in groups),
                float(growth[n]),
                bool(bounded[n]),
                verdict_of(float(growth[n]), bool(bounded[n])),
            )
        )
    return tuple(found)


def _columns(rows: Sequence[Row], kind: str, most: int) -> Array:
    """Return the quantities "kind:1" to "kind:most", (runs, most); NaN where a run has fewer."""
    return np.array([[row["values"].get(f"{kind}:{n}", math.nan) for n in range(1, most + 1)] for row in rows])


def _shifts(rows: Sequence[Row], times: Array) -> Array:
    """Return how far each shadow moves the times of the first run, (shadows, n) from (runs, n).

    One that came to its end without such a time would have had it later, which is a lower bound.  One that the
    physics stopped will never have it.
    """
    ends = [row["stopped_at"] if row["outcome"] == Outcome.COMPLETED.label else math.inf for row in rows[1:]]
    least = np.array(ends)[:, None] - times[0]
    return np.asarray(np.where(np.isnan(times[1:]), least, np.abs(times[1:] - times[0])))


def _largest(values: Array) -> Array:
    """Return the largest of all shadows, NaN where there are none."""
    return np.asarray(np.max(values, axis=0) if len(values) else np.full(values.shape[1:], math.nan))


def verdict_of(growth: float, lower_bound: bool = False) -> str:
    """Return the verdict on a growth; from a lower bound only that something is not predictable."""
    if growth >= LARGE:
        return UNPREDICTABLE
    if lower_bound or math.isnan(growth):
        return UNKNOWN
    return PREDICTABLE if growth <= SMALL else SENSITIVE


def lines(result: Predictability) -> list[str]:
    """Return what a study found in lines, for a terminal."""
    found = []
    for case in result.cases:
        found += [f"{case.case.name}:", *(f"  {remark}" for remark in case.remarks)]
        for c in case.collisions:
            growth = "" if math.isnan(c.growth) else f", growth {'at least ' * c.lower_bound}{c.growth:.3g}"
            found.append(f"  collision {c.number}: starts at {c.start:.9g} s{growth}: {c.verdict}")
    return found
