"""Reproduce the paper's figures and claims: the call `reproduce`, behind `oblique-impact reproduce`."""

from __future__ import annotations

import os
import time
import warnings
from typing import Any

import pandas as pd

from oblique_impact.files import prepare_folder
from oblique_impact.history.history import History
from oblique_impact.progress import OnProgress, silent
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.paper.claims import CLAIMS, Reproduction, judge_claims
from oblique_impact.validation.paper.measures import (
    MODELS,
    NAN,
    Models,
    cases,
    collisions,
    combinations,
    longest,
    paper,
    run_light,
    sticks,
)
from oblique_impact.validation.paper.report import write_report
from oblique_impact.validation.studies.parallel import map_parallel

#: s of one core that the runs and figures take on a fast machine
SECONDS = 150.0


def reproduce(
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    on_progress: OnProgress = silent,
) -> Reproduction:
    """Run the paper's cases and judge its claims.

    Parameters
    ----------
    out : path, optional
        Folder for report.html, results.json, claims.csv, combinations.csv and, in figures/, figures 2 to 16;
        without it nothing is drawn or written.
    workers : int, optional
        Parallel processes; default: the cores.  With one, everything runs in this process.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` before the first and after each run.

    Returns
    -------
    Reproduction
        Claims with their verdicts, and the runs that they are judged by.

    Raises
    ------
    InputError
        In one line, before anything runs, if the folder cannot be written.

    Examples
    --------
    >>> from oblique_impact.validation import reproduce
    >>> result = reproduce(out="out/reproduce")  # doctest: +SKIP
    >>> result.verdicts  # doctest: +SKIP
    {'reproduced': 19, 'partly': 9, 'not reproduced': 3}
    """
    folder = None if out is None else prepare_folder(out)
    started = time.perf_counter()
    named, grid = cases(), combinations()
    with warnings.catch_warnings():
        # workers that hold much memory after a long run are replaced by joblib, which says so
        warnings.filterwarnings("ignore", "A worker stopped while some jobs were given")
        tasks: list[Scenario | dict[str, Any]] = [*named.values(), *grid]
        found: list[Any] = map_parallel(_compute, tasks, workers, on_progress, [*named, *map(str, grid)])
    runs: dict[str, History] = dict(zip(named, found, strict=False))
    combined = found[len(named) :]
    claims = judge_claims(runs, [row["verdicts"] for row in combined])
    result = Reproduction(claims, runs, pd.DataFrame(combined), time.perf_counter() - started)
    if folder is not None:
        write_report(result, folder)
    return result


def lines(result: Reproduction) -> list[str]:
    """Return the verdicts in lines, for a terminal."""
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in result.verdicts.items())
    shown = [f"  {claim.verdict:15s} {claim.id}" for claim in result.claims.itertuples()]
    same = f"{result.undiscriminating} of them reproduced by all combinations of what the paper leaves open"
    return [*shown, f"{len(result.claims)} claims: {verdicts}; {same}"]


def _compute(task: Scenario | dict[str, Any]) -> History | dict[str, Any]:
    """Return the run of a scenario; of a combination of choices its second macro-collision and verdicts."""
    if isinstance(task, Scenario):
        return run_light(task)
    models = Models(*(run_light(paper(model=model, **task)) for model in MODELS))
    second = next(iter(collisions(models.hybrid)[1:2]), (NAN, NAN))
    start, duration = longest(sticks(models.hybrid, second))
    return {
        **{name.rpartition("__")[2]: value for name, value in task.items()},
        "outcomes": [run.outcome.label for run in models],
        "second_start": second[0],
        "second_end": second[1],
        "longest_stick_start": start,
        "longest_stick": duration,
        "verdicts": {claim.id: claim.judge(models)[0] for claim in CLAIMS if claim.case == "paper"},
    }
