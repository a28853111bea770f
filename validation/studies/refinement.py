"""Refinement: one scenario over levels of elements, modes, steps, stiffness or tolerance, and what converges."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from oblique_impact.errors import InputError, Outcome
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.progress import OnProgress, silent
from oblique_impact.scenario.scenario import Scenario, require_scenario
from oblique_impact.validation.studies.convergence import CONVERGED, CONVERGING
from oblique_impact.validation.studies.ladders import AXES, Ladder, Study, StudyResult, judge
from oblique_impact.validation.studies.quantities import default_quantities
from oblique_impact.validation.studies.refinement_report import level_frame, report, study_data
from oblique_impact.validation.studies.shipped import shipped_study
from oblique_impact.validation.studies.study import run_study

#: levels that a verdict needs, and most that are run
FEWEST, MOST = 3, 16
#: quantities that converge at no order of a method: counts, and largest values among samples
_ROUGH = ("contacts", "events", "peak_force", "unaccounted")


def refine(
    scenario: Scenario | None = None,
    *,
    elements: Sequence[int] | None = None,
    modes: Sequence[int] | None = None,
    steps: Sequence[float] | None = None,
    tolerances: Sequence[float] | None = None,
    stiffness: Sequence[float] | None = None,
    quantities: Sequence[str] = (),
    study: str | Study | None = None,
    changes: Sequence[str] = (),
    within: float | None = None,
    out: str | os.PathLike[str] | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    timeout: float | None = None,
    name: str = "scenario",
    command: str = "",
    on_progress: OnProgress = silent,
) -> StudyResult:
    """Refine elements, modes, steps, stiffness or tolerances, and judge what converges.

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
        Names as in :mod:`~oblique_impact.validation.studies.quantities`, e.g. "impulse", "tip_y@0.5"; empty: the
        usual ones.
    study : str or Study, optional
        A shipped study by name, or a user-defined one, in place of a scenario and levels.
    changes : sequence of str
        For every ladder of a study: "section.key=value" as on the command line.
    within : float, optional
        Relative uncertainty at which a quantity counts as converged, between 0 and 1; default: 1e-3, or the
        study's own.
    out : path, optional
        Folder for report.html, results.json, results.csv and results.parquet, where an interrupted study goes on;
        without it nothing is written.
    scheduler, workers, timeout, on_progress
        As for :func:`~oblique_impact.validation.studies.study.run_study`.
    name : str
        What the scenario is called in the report.
    command : str
        How to repeat the study, for the report.

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
    >>> from oblique_impact.validation import refine
    >>> swing = Scenario.builtin("paper").replace(end_time=0.1, discretization__frame="mean-axis")
    >>> result = refine(swing, elements=[4, 8, 16], quantities=["theta@end"], workers=1)
    >>> result.quantity("theta@end").analysis.verdict
    'converged'
    """
    every = zip(AXES, (elements, modes, steps, stiffness, tolerances), strict=True)
    chosen = {axis: tuple(map(float, levels)) for axis, levels in every if levels is not None}
    if within is not None and not 0.0 < within < 1.0:
        raise InputError(f"--within {within}: should be between 0 and 1, relative to the value")
    if study is None:
        if changes:
            raise InputError("changes: are for a study; scenario.replace changes a scenario")
        described = _own_study(scenario, name, chosen, quantities)
    else:
        described = shipped_study(study) if isinstance(study, str) else study
        for given in ("scenario", *(f"--{axis}" for axis in chosen))[scenario is None :]:
            raise InputError(f"{given} together with --study {described.name}: a shipped study has its own levels")
    started = time.perf_counter()
    # everything that can be refused is refused before a folder appears
    ladders = [ladder.changed(changes, quantities) for ladder in described.ladders]
    runs = [run for ladder in ladders for run in ladder.runs()]
    frame = run_study(runs, out, scheduler=scheduler, workers=workers, timeout=timeout, on_progress=on_progress)
    tolerance = described.tolerance if within is None else within
    found = tuple(judge(ladder, frame[frame["ladder"] == ladder.name], tolerance) for ladder in ladders)
    result = StudyResult(described, tolerance, found, time.perf_counter() - started)
    if out is None:
        return result
    page = report(result, command).write(Path(out), study_data(result, command), level_frame(result))
    return replace(result, report=page)


def parse_levels(axis: str, text: str) -> list[float]:
    """Read the levels of an axis from the command line: numbers separated by commas; raises InputError."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"--{axis} {text}: should be numbers separated by commas") from None


def check_levels(axis: str, levels: Sequence[float]) -> None:
    """Raise InputError unless there are enough levels, each finer than the one before."""
    rising, text = AXES[axis].rising, ",".join(f"{level:g}" for level in levels)
    if not all(math.isfinite(level) and level > 0.0 for level in levels):
        raise InputError(f"--{axis} {text}: should be numbers above 0")
    if axis in ("elements", "modes") and any(level % 1.0 for level in levels):
        raise InputError(f"--{axis} {text}: should be whole numbers")
    if not FEWEST <= len(levels) <= MOST:
        raise InputError(f"--{axis} {text}: a verdict takes {FEWEST} to {MOST} levels, these are {len(levels)}")
    if not all(b > a if rising else b < a for a, b in pairwise(levels)):
        order = "increase" if rising else "decrease"
        raise InputError(f"--{axis} {text}: should {order}, from coarse to fine")


def lines(result: StudyResult) -> list[str]:
    """Return what a study found in lines, for a terminal."""
    found = []
    for part in result.ladders:
        found.append(f"{part.ladder.name}:")
        for run in part.runs.to_dict("records"):
            if run["outcome"] != Outcome.COMPLETED.label:
                words = f"{run['outcome']} at t = {run['stopped_at']:.6g} s" if run["steps"] else run["message"]
                found.append(f"  {part.axis.label} {run['level']:g}: {words}")
        for item in part.results:
            a, unit = item.analysis, item.quantity.unit.removeprefix("1")
            value, digits = a.rounded(item.values[-1])
            shown = f"{value:.{digits}g}"
            if a.verdict in (CONVERGED, CONVERGING):
                shown += f" +- {a.uncertainty:.2g}"
            shown = item.gaps[-1] or f"{shown} {unit}"
            found.append(f"  {item.quantity.name:24} {shown:32} {a.words} ({a.reason})")
        found += [f"  {remark}" for remark in part.remarks]
    return found


def declared_orders(axis: str, scenario: Scenario, quantities: Sequence[str]) -> dict[str, float]:
    """Return the orders that hold for any scenario, by quantity; few do.

    Frequencies of Hermite elements, and with them everything at a fixed number of modes, converge at order 4;
    generalized-alpha is of its order on motions without a rigid stop.  Forces and counts get none.
    """
    rigid = scenario.contact.enabled and scenario.contact.normal == "rigid"
    if axis == "elements" and scenario.discretization.modes > 0:
        order = 4.0
    elif axis == "steps" and scenario.solver.scheme == "generalized-alpha" and not rigid:
        order = float(GeneralizedAlphaScheme.order)
    else:
        return {}
    return {name: order for name in quantities if name not in _ROUGH and ":" not in name}


def _own_study(
    scenario: Scenario | None, name: str, chosen: Mapping[str, tuple[float, ...]], quantities: Sequence[str]
) -> Study:
    """Describe the user's own ladder."""
    if not chosen:
        options = ", ".join(f"--{axis}" for axis in AXES)
        raise InputError(f"refine: give one of {options} with levels, or --study")
    if len(chosen) > 1:
        raise InputError(f"--{' together with --'.join(chosen)}: refine one at a time, the others with --set")
    if scenario is None:
        raise InputError("refine: a scenario is needed besides levels")
    require_scenario(scenario, "refine")
    ((axis, levels),) = chosen.items()
    check_levels(axis, levels)
    names = tuple(dict.fromkeys(quantities)) or default_quantities(scenario)
    title = f"{axis} of {name}"
    declared = declared_orders(axis, AXES[axis].change(scenario, levels[-1]), names)
    ladder = Ladder(title, scenario, axis, levels, names, declared, scenario=name)
    text = f"The scenario over {AXES[axis].label}, from coarse to fine; everything else stays as it is."
    return Study(title.replace(" ", "-"), title, text, (ladder,))
