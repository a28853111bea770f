"""Refinement as a call, `refine`."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from typing import Literal

import tomli_w

from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import writing
from oblique_impact.progress import OnProgress, silent
from oblique_impact.scenario.scenario import Scenario, require_scenario
from oblique_impact.validation.parallel import check_limits
from oblique_impact.validation.quantities import default_quantities
from oblique_impact.validation.refinement.convergence import CONVERGED, CONVERGING
from oblique_impact.validation.refinement.ladders import (
    AXES,
    Ladder,
    Study,
    check_levels,
    declared_orders,
    levels_by_axis,
)
from oblique_impact.validation.refinement.report import write_study
from oblique_impact.validation.refinement.shipped import STUDIES, shipped_study
from oblique_impact.validation.refinement.study import LadderResult, StudyResult, judge, measure, plan_ladder
from oblique_impact.validation.report.provenance import UNNAMED, call_text, scenario_text

ShippedStudy = Literal["elements", "steps", "remedies", "grading", "rigid-stop"]


def refine(
    scenario: Scenario | None = None,
    *,
    elements: Sequence[int] | None = None,
    modes: Sequence[int] | None = None,
    steps: Sequence[float] | None = None,
    tolerances: Sequence[float] | None = None,
    stiffness: Sequence[float] | None = None,
    quantities: Sequence[str] = (),
    study: ShippedStudy | Study | None = None,
    changes: Mapping[str, object] | Sequence[str] = (),
    within: float | None = None,
    out: str | os.PathLike[str] | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    timeout: float | None = None,
    name: str = UNNAMED,
    command: str | None = None,
    on_progress: OnProgress = silent,
) -> StudyResult:
    """Refine elements, modes, steps or tolerances, and judge what converges.

    Parameters
    ----------
    scenario : Scenario, optional
        What is refined; a study brings its own.
    elements, modes : sequence of int, optional
        Levels, ascending; of these and the next three exactly one is given, with at least three levels.
    steps : sequence of float, optional
        Free steps (s), descending; contact steps keep their ratio to them.
    tolerances : sequence of float, optional
        Tolerances of the event scheme, descending.
    stiffness : sequence of float, optional
        Of an elastic stop (N/m), ascending: towards the rigid one.
    quantities : sequence of str
        Names as in :mod:`~oblique_impact.validation.quantities`, e.g. "impulse", "tip_y@0.5"; empty: the
        usual ones.
    study : str or Study, optional
        A shipped study by name, or a user-defined one, in place of a scenario and levels.
    changes : mapping or sequence of str
        For every ladder of a shipped study: {"section.key": value}, or "section.key=value" as on the command line.
    within : float, optional
        Relative uncertainty at which a quantity counts as converged, between 0 and 1; default: 1e-3, or the
        study's own.
    out : path, optional
        Folder for report.html, results.json and results.csv, where an interrupted study goes on; without it
        nothing is written.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers are used.
    workers : int, optional
        Parallel processes; default: the cores.  With one, everything runs in this process.
    timeout : float, optional
        Wall time (s) that a run may take; one that takes longer has the outcome "timeout".
    name : str
        What the scenario is called in the report.
    command : str, optional
        How to repeat the study, for the report; default: this call.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` before the first and after each run.

    Returns
    -------
    StudyResult
        Values, observed orders, limits and verdicts; `quantity` finds those of one quantity.

    Raises
    ------
    InputError
        In one line, before anything runs, if levels, quantities, changes or the folder are not possible.

    Examples
    --------
    >>> from oblique_impact import Scenario
    >>> from validation import refine
    >>> swing = Scenario.builtin("paper").replace(end_time=0.1, discretization__frame="mean-axis")
    >>> result = refine(swing, elements=[4, 8, 16], quantities=["theta@end"], workers=1)
    >>> result.quantity("theta@end").analysis.verdict
    'converged'
    """
    given = levels_by_axis(elements, modes, steps, stiffness, tolerances)
    chosen = {axis: tuple(map(float, levels)) for axis, levels in given.items()}
    check_limits(scheduler, workers, timeout)
    if within is not None and not (math.isfinite(within) and 0.0 < within < 1.0):
        raise InputError(f"--within {within}: should be between 0 and 1, relative to the value")
    if study is None:
        if changes:
            raise InputError("changes: are for a shipped study; scenario.replace changes a scenario")
        described = _own(scenario, name, chosen, quantities)
    else:
        described = _shipped(study, scenario, chosen)
    repeat = command or call_text(
        "refine",
        [] if study else [scenario_text(name)],
        study=described.name if study else None,
        **{axis: [int(level) if level.is_integer() else level for level in chosen[axis]] for axis in chosen},
        quantities=list(quantities),
        changes=changes,
        within=within,
        out=None if out is None else os.fspath(out),
        scheduler=scheduler,
        workers=workers,
        timeout=timeout,
    )
    started = time.perf_counter()
    # everything that can be refused is refused before a folder appears
    plans = [plan_ladder(ladder, _words(changes), quantities) for ladder in described.ladders]
    tolerance = described.tolerance if within is None else within
    with nullcontext() if out is None else writing(out) as folder:
        rows = measure(plans, folder, on_progress, workers, scheduler, timeout)
        ladders = tuple(judge(*pair, tolerance) for pair in zip(plans, rows, strict=True))
        result = StudyResult(described, tolerance, ladders, time.perf_counter() - started)
        return result if folder is None else replace(result, report=write_study(folder, result, repeat))


def _words(changes: Mapping[str, object] | Sequence[str]) -> list[str]:
    """Return changes as "section.key=value"."""
    if not isinstance(changes, Mapping):
        return list(changes)
    try:
        values = {key: tomli_w.dumps({"value": value}).partition("=")[2].strip() for key, value in changes.items()}
    except TypeError as error:
        raise InputError(f"changes: {error}") from None
    return [f"{key}={value}" for key, value in values.items()]


def _shipped(study: str | Study, scenario: Scenario | None, chosen: Mapping[str, Sequence[float]]) -> Study:
    name = study if isinstance(study, str) else study.name
    for axis in chosen:
        raise InputError(f"--{axis} together with --study {name}: a shipped study has its own levels")
    if scenario is not None:
        raise InputError(f"scenario together with --study {name}: a shipped study has its own")
    return shipped_study(study) if isinstance(study, str) else study


def _own(
    scenario: Scenario | None, name: str, chosen: Mapping[str, tuple[float, ...]], quantities: Sequence[str]
) -> Study:
    """Describe the user's own ladder."""
    options = ", ".join(f"--{axis}" for axis in AXES)
    if not chosen:
        raise InputError(f"refine: give one of {options} with levels, or --study with one of {', '.join(STUDIES)}")
    if len(chosen) > 1:
        raise InputError(f"--{' together with --'.join(chosen)}: refine one at a time, the others with --set")
    if scenario is None:
        raise InputError("refine: a scenario is needed besides levels")
    require_scenario(scenario, "refine")
    ((axis, levels),) = chosen.items()
    check_levels(axis, levels)
    names = tuple(quantities) or default_quantities(scenario)
    title = f"{axis} of {name}"
    declared = declared_orders(axis, AXES[axis].apply(scenario, levels[-1]), names)
    ladder = Ladder(title, name, (), axis, levels, names, declared, base=scenario)
    return Study(
        title.replace(" ", "-"),
        title,
        f"The scenario over {AXES[axis].label}, from coarse to fine; everything else stays as it is.",
        (ladder,),
    )


def lines(result: StudyResult) -> list[str]:
    """Return what a study found in lines, for a terminal."""
    return [line for ladder in result.ladders for line in _ladder_lines(ladder)]


def _ladder_lines(result: LadderResult) -> list[str]:
    lines = [f"{result.ladder.name}:"]
    for level, run in zip(result.ladder.levels, result.runs, strict=True):
        if run["outcome"] != Outcome.COMPLETED.label:
            words = f"{run['outcome']} at t = {run['stopped_at']:.6g} s" if run["steps"] else run["message"]
            lines.append(f"  {result.axis.label} {level:g}: {words}")
    for item in result.results:
        a, unit = item.analysis, item.quantity.unit.removeprefix("1")
        value, digits = a.rounded(item.values[-1])
        shown = f"{value:.{digits}g}"
        if a.verdict in (CONVERGED, CONVERGING):
            shown += f" +- {a.uncertainty:.2g}"
        shown = item.gaps[-1] or f"{shown} {unit}"
        lines.append(f"  {item.quantity.name:24} {shown:32} {a.words} ({a.reason})")
    return [*lines, *(f"  {remark}" for remark in result.remarks)]
