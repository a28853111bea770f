"""Whether the numbers of an impact mean anything: shadow runs from initial angles that differ by next to nothing.

Each shadow starts at another angle, theta_0 + d with |d| of a hundred-millionth and a millionth of a radian;
nothing that one could measure.  What is said of them (`growth`) is said of a model as it stands: a coarse one may
be predictable and far from its limit, which `refine` shows.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from itertools import islice

import numpy as np

from oblique_impact.errors import InputError
from oblique_impact.files import writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.scenario.scenario import Scenario, require_scenario
from oblique_impact.validation.measuring import Task
from oblique_impact.validation.parallel import check_limits
from oblique_impact.validation.refinement.growth import (
    MOST_COLLISIONS,
    MOST_EVENTS,
    Array,
    Case,
    Predictability,
    judge,
)
from oblique_impact.validation.refinement.study import measure_rows
from oblique_impact.validation.report.provenance import UNNAMED, call_text, scenario_text

#: rad
PERTURBATIONS = (1e-8, 1e-6)
SHADOWS = 4
_MOST_SHADOWS = 1000


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
        What is tried; the shipped cases are `oblique_impact.validation.refinement.shipped.predictability_cases()`.
    perturbations : sequence of float
        Largest changes of the initial angle (rad).
    shadows : int
        Runs per perturbation d, evenly from -d to d without 0; from 0 to d where -d lies below the slope.
    out : path, optional
        Folder for report.html, results.json and results.csv, where an interrupted study goes on.
    scheduler, workers, timeout, on_progress
        As for :func:`oblique_impact.validation.refinement.command.refine`.
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
    from oblique_impact.validation.refinement.predictability_report import write_predictability

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
    if isinstance(scenario, Sequence) and all(isinstance(case, Case) for case in scenario):
        return list(scenario)
    return [Case(name, require_scenario(scenario, "predictability"))]


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
    kinds = {"start": MOST_COLLISIONS, "collision_impulse": MOST_COLLISIONS}
    kinds |= {"collision_contacts": MOST_COLLISIONS, "event": MOST_EVENTS}
    return tuple(f"{kind}:{n}" for kind, most in kinds.items() for n in range(1, most + 1))


def lines(result: Predictability) -> list[str]:
    """Return what a study found in lines, for a terminal."""
    found = []
    for case in result.cases:
        found += [f"{case.case.name}:", *(f"  {remark}" for remark in case.remarks)]
        for c in case.collisions:
            growth = "" if math.isnan(c.growth) else f", growth {'at least ' * c.lower_bound}{c.growth:.3g}"
            found.append(f"  collision {c.number}: starts at {c.start:.9g} s{growth}: {c.verdict}")
    return found
