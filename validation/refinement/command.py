"""`oblique-impact refine`: from the command line's words to a study and its report."""

from __future__ import annotations

import math
import shlex
from contextlib import ExitStack
from pathlib import Path

from oblique_impact.errors import InputError
from oblique_impact.files import writing
from oblique_impact.scenario import Scenario
from validation.refinement.ladders import AXES, Ladder, Study, declared_orders, parse_levels
from validation.refinement.quantities import default_quantities
from validation.refinement.report import write_study
from validation.refinement.shipped import STUDIES, shipped_study
from validation.refinement.study import LadderResult, StudyResult, run_study
from validation.report.document import number

_DEFAULT_SCENARIO = "paper"


def refine_command(
    scenario: str,
    elements: str | None,
    modes: str | None,
    steps: str | None,
    quantities: list[str] | None,
    study: str | None,
    out: Path,
    changes: list[str] | None,
    workers: int | None,
    tolerances: str | None = None,
    within: float | None = None,
) -> list[str]:
    """Run a refinement study and write its report into `out`.

    Parameters
    ----------
    scenario : str
        A built-in scenario or a file.
    elements, modes, steps, tolerances : str, optional
        Levels, separated by commas, of one of these.
    quantities : list of str, optional
        Names of quantities of interest.
    study : str, optional
        A shipped study in place of a scenario and levels.
    out : Path
        Folder.
    changes : list of str, optional
        "section.key=value".
    workers : int, optional
        Parallel processes.
    within : float, optional
        Relative uncertainty at which a quantity counts as converged.

    Returns
    -------
    list of str
        Lines to print.

    Raises
    ------
    InputError
        In one line, before anything runs.
    """
    given = {"elements": elements, "modes": modes, "steps": steps, "tolerances": tolerances}
    chosen = {axis: text for axis, text in given.items() if text is not None}
    changes, quantities = changes or [], quantities or []
    if within is not None and not (math.isfinite(within) and 0.0 < within < 1.0):
        raise InputError(f"--within {within}: should be between 0 and 1, relative to the value")
    described = (
        _shipped(study, scenario, chosen) if study is not None else _own(scenario, chosen, changes, quantities)
    )
    command = _command(scenario, chosen, quantities, study, changes, within)
    with ExitStack() as stack:
        # everything that can be refused is refused before a folder appears
        result = run_study(
            described, changes, quantities, within, workers, lambda: stack.enter_context(writing(out))
        )
        page = write_study(out, result, command)
    return [*_lines(result), f"report: {page}"]


def _shipped(name: str, scenario: str, chosen: dict[str, str]) -> Study:
    for axis in chosen:
        raise InputError(f"--{axis} together with --study {name}: a shipped study has its own levels")
    if scenario != _DEFAULT_SCENARIO:
        raise InputError(f"scenario = {scenario!r} together with --study {name}: a shipped study has its own")
    return shipped_study(name)


def _own(scenario: str, chosen: dict[str, str], changes: list[str], quantities: list[str]) -> Study:
    """Describe the user's own ladder."""
    options = ", ".join(f"--{axis}" for axis in AXES)
    if not chosen:
        raise InputError(f"refine: give one of {options} with levels, or --study with one of {', '.join(STUDIES)}")
    if len(chosen) > 1:
        raise InputError(f"--{' together with --'.join(chosen)}: refine one at a time, the others with --set")
    ((axis, text),) = chosen.items()
    levels = parse_levels(axis, text)
    loaded = Scenario.load(scenario, changes)
    names = tuple(quantities) or default_quantities(loaded)
    title = f"{axis} of {Path(scenario).name}"
    declared = declared_orders(axis, AXES[axis].apply(loaded, levels[-1]), names)
    # the changes are the study's: they are added when it runs
    ladder = Ladder(title, scenario, (), axis, levels, names, declared)
    return Study(
        title.replace(" ", "-"),
        title,
        f"The scenario over {AXES[axis].label}, from coarse to fine; everything else stays as it is.",
        (ladder,),
    )


def _command(
    scenario: str,
    chosen: dict[str, str],
    quantities: list[str],
    study: str | None,
    changes: list[str],
    within: float | None,
) -> str:
    """Return the command line that repeats the study, without the folders of this machine."""
    words = ["oblique-impact", "refine"]
    words += ["--study", study] if study is not None else [Path(scenario).name]
    words += [part for axis, text in chosen.items() for part in (f"--{axis}", text)]
    words += [part for name in quantities for part in ("--quantity", name)]
    words += [part for change in changes for part in ("--set", change)]
    words += [] if within is None else ["--within", f"{within:g}"]
    return shlex.join(words)


def _lines(result: StudyResult) -> list[str]:
    return [line for ladder in result.ladders for line in _ladder_lines(ladder)]


def _ladder_lines(result: LadderResult) -> list[str]:
    lines = [f"{result.ladder.name}:"]
    for level, run in zip(result.ladder.levels, result.runs, strict=True):
        if not run.completed:
            lines.append(f"  {result.axis.label} {number(level)}: {run.outcome} at t = {run.end_time:.6g} s")
    for item in result.results:
        unit = item.quantity.unit.removeprefix("1")
        shown = item.gaps[-1] or f"{number(item.values[-1], 9)} {unit}"
        lines.append(f"  {item.quantity.name:24} {shown:28} {item.analysis.words} ({item.analysis.reason})")
    return lines
