"""Reproduce the paper's figures and claims: the call `reproduce`, behind `oblique-impact reproduce`."""

from __future__ import annotations

import os
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from oblique_impact.files import prepare_folder
from oblique_impact.history.history import History
from oblique_impact.progress import OnProgress, silent
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.paper import measures
from oblique_impact.validation.paper.measures import MODELS, NAN, SCHEMES, Models
from oblique_impact.validation.paper.report import write_report
from oblique_impact.validation.paper.rules import CLAIMS, PARTLY, REPRODUCED, VERDICTS
from oblique_impact.validation.studies.parallel import map_parallel

#: s of one core that the runs and figures take on a fast machine
SECONDS = 150.0


@dataclass(frozen=True)
class Reproduction:
    """The paper's claims with their verdicts, and the runs behind them.

    Attributes
    ----------
    claims : DataFrame
        A row for each claim: `id`, `place`, `paper` and `rule` in words; `verdict`, "reproduced" if by both
        schemes, "not reproduced" if by neither, else "partly"; for each scheme `verdict_...` and `ours_...`, what
        it found; how many combinations of open choices give which verdict, `combinations_...`, None for claims on
        other cases than the paper's; `discriminates`, whether some of them does not reproduce it.
    runs : dict
        Histories by group/scheme/model, without what varies along the beam.
    combinations : DataFrame
        What each combination of open choices does to the second macro-collision (SI units), and the verdict of
        each claim by its id.
    seconds : float
        Wall time (s) of the simulations.
    """

    claims: pd.DataFrame
    runs: dict[str, History]
    combinations: pd.DataFrame
    seconds: float

    @property
    def verdicts(self) -> dict[str, int]:
        """How many claims have which verdict: "reproduced", "partly", "not reproduced"."""
        found = self.claims["verdict"].tolist()
        return {verdict: found.count(verdict) for verdict in VERDICTS}

    @property
    def undiscriminating(self) -> int:
        """Number of claims that every combination of open choices reproduces."""
        return int((~self.claims["discriminates"].astype(bool)).sum())


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
    named, grid = measures.cases(), measures.combinations()
    tasks: list[Scenario | dict[str, Any]] = [*named.values(), *grid]
    with warnings.catch_warnings():
        # workers that hold much memory after a long run are replaced by joblib, which says so
        warnings.filterwarnings("ignore", "A worker stopped while some jobs were given")
        found: list[Any] = map_parallel(_compute, tasks, workers, on_progress, [*named, *map(str, grid)])
    runs: dict[str, History] = dict(zip(named, found, strict=False))
    combined = pd.DataFrame(found[len(named) :])
    result = Reproduction(judge_claims(runs, combined), runs, combined, time.perf_counter() - started)
    if folder is not None:
        write_report(result, folder)
    return result


def judge_claims(runs: Mapping[str, History], combined: pd.DataFrame) -> pd.DataFrame:
    """Judge each claim on the runs of its case; `combined` has its verdict in each combination, by its id."""
    rows = []
    for claim in CLAIMS:
        row = {name: getattr(claim, name) for name in ("id", "place", "paper", "rule")} | {"verdict": PARTLY}
        for scheme in SCHEMES:
            keys = [f"{claim.case}/{scheme}/{model}" for model in MODELS]
            # where friction is the point there is no frictionless run
            found = claim.judge(Models(*(runs.get(key, runs[keys[0]]) for key in keys)))
            suffix = scheme.replace("-", "_")
            row[f"verdict_{suffix}"], row[f"ours_{suffix}"] = found
        if row["verdict_fixed_step"] == row["verdict_event"]:
            row["verdict"] = row["verdict_event"]
        judged = list(combined.get(claim.id, []))
        for verdict in VERDICTS:
            row[f"combinations_{verdict.replace(' ', '_')}"] = judged.count(verdict) if judged else None
        row["discriminates"] = not judged or judged.count(REPRODUCED) < len(judged)
        rows.append(row)
    return pd.DataFrame(rows, dtype=object)


def lines(result: Reproduction) -> list[str]:
    """Return the verdicts in lines, for a terminal."""
    verdicts = ", ".join(f"{count} {verdict}" for verdict, count in result.verdicts.items())
    shown = [f"  {claim.verdict:15s} {claim.id}" for claim in result.claims.itertuples()]
    same = f"{result.undiscriminating} of them reproduced by all combinations of what the paper leaves open"
    return [*shown, f"{len(result.claims)} claims: {verdicts}; {same}"]


def _compute(task: Scenario | dict[str, Any]) -> History | dict[str, Any]:
    """Return the run of a scenario; of a combination of choices its second macro-collision and verdicts."""
    if isinstance(task, Scenario):
        return measures.run_light(task)
    models = Models(*(measures.run_light(measures.paper(model=model, **task)) for model in MODELS))
    second = next(iter(measures.collisions(models.hybrid)[1:2]), (NAN, NAN))
    start, duration = measures.longest(measures.sticks(models.hybrid, second))
    return {
        **{name.rpartition("__")[2]: value for name, value in task.items()},
        "second_start": second[0],
        "second_end": second[1],
        "longest_stick_start": start,
        "longest_stick": duration,
        **{claim.id: claim.judge(models)[0] for claim in CLAIMS if claim.case == "paper"},
    }
