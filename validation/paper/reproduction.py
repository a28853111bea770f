"""Run the paper's cases and judge its claims."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

from joblib import Parallel, delayed

from oblique_impact.history.history import History
from oblique_impact.machine import cores
from oblique_impact.progress import OnProgress, Progress, silent
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.paper.cases import (
    MODELS,
    SCHEMES,
    Combination,
    Variant,
    cases,
    combinations,
    variants,
)
from oblique_impact.validation.paper.claims import CLAIMS, VERDICTS, Judged
from oblique_impact.validation.paper.measures import (
    NAN,
    Models,
    collision_numbers,
    longest,
    macros,
    run_light,
    sticks,
)
from oblique_impact.validation.paper.sticking import StickCheck, stick_checks, threshold


@dataclass(frozen=True)
class Reproduction:
    """The paper's claims with their verdicts, and the runs behind them.

    Attributes
    ----------
    claims : sequence of Judged
        The paper's claims, each with what either scheme found and a verdict.
    runs : dict
        Histories by group/scheme/model, without what varies along the beam.
    variants, combinations : sequence of dict
        What each value of an open choice does to the first two macro-collisions; what each combination of open
        choices does to the second one and to the verdicts.
    stick : dict
        Why the hybrid models' tips could not stick, or did, by the key of the run.
    threshold : tuple
        Ratio of forces that the first reversal asks for, and what happens there with friction around it.
    seconds : float
        Wall time (s) of the simulations.
    """

    claims: Sequence[Judged]
    runs: dict[str, History]
    variants: Sequence[dict[str, Any]]
    combinations: Sequence[dict[str, Any]]
    stick: dict[str, list[StickCheck]]
    threshold: tuple[float, list[tuple[float, str]]]
    seconds: float

    @property
    def verdicts(self) -> dict[str, int]:
        """How many claims have which verdict: "reproduced", "partly", "not reproduced"."""
        return _counted([judged.verdict for judged in self.claims])

    @property
    def undiscriminating(self) -> int:
        """Number of claims that every combination of open choices reproduces."""
        return sum(not judged.discriminates for judged in self.claims)

    def models(self, group: str) -> dict[str, Models]:
        """Return the runs of the three models by scheme; the hybrid one stands for a model that was not run."""
        found = {}
        for scheme in SCHEMES:
            keys = [f"{group}/{scheme}/{model}" for model in MODELS]
            found[scheme] = Models(*(self.runs.get(key, self.runs[keys[0]]) for key in keys))
        return found


def compute(workers: int | None = None, on_progress: OnProgress = silent) -> Reproduction:
    """Run every simulation, in so many processes (default: the cores), and judge the claims."""
    started = time.perf_counter()
    named, varied, grid = cases(), variants(), combinations()
    tasks: list[Scenario | Variant | Combination] = [*named.values(), *varied, *grid]
    names = [*named, *(f"{variant.choice}: {variant.label}" for variant in varied), *map(str, grid)]
    parallel = Parallel(n_jobs=workers or cores(), batch_size=1, return_as="generator")
    found: list[Any] = []
    on_progress(Progress(0, len(tasks)))
    for name, result in zip(names, parallel(delayed(_compute)(task) for task in tasks), strict=True):
        found.append(result)
        on_progress(Progress(len(found), len(tasks), name))
    runs = dict(zip(named, found[: len(named)], strict=True))
    measured, judged = found[len(named) : -len(grid)], found[-len(grid) :]
    stick = {key: stick_checks(run) for key, run in runs.items() if key.endswith("hybrid")}
    tried = threshold(stick["paper/event/hybrid"])
    made = Reproduction([], runs, measured, judged, stick, tried, time.perf_counter() - started)
    return replace(made, claims=_judge(made))


def _compute(task: Scenario | Variant | Combination) -> Any:
    if isinstance(task, Scenario):
        return run_light(task)
    return _measure_variant(task) if isinstance(task, Variant) else _judge_combination(task)


def _measure_variant(variant: Variant) -> dict[str, Any]:
    """Return the row of a variant: what it is, and what happens in its first two macro-collisions (SI units)."""
    run = run_light(variant.scenario)
    return {
        "choice": variant.choice,
        "variant": variant.label,
        "assumed": variant.assumed,
        "scheme": str(variant.scenario.solver.scheme),
        "model": str(variant.scenario.contact.friction),
        "outcome": run.outcome.label,
        **{f"first_{name}": value for name, value in collision_numbers(run, 1).items()},
        **{f"second_{name}": value for name, value in collision_numbers(run, 2).items()},
    }


def _judge_combination(combination: Combination) -> dict[str, Any]:
    """Return the row of a combination: its second macro-collision (SI units) and the verdicts by claim."""
    models = Models(*(run_light(combination.scenario(model)) for model in MODELS))
    second = macros(models.hybrid)[1:2]
    start, duration = longest(sticks(models.hybrid, second[0])) if second else (NAN, 0.0)
    return {
        **asdict(combination),
        "outcomes": [run.outcome.label for run in models],
        "second_start": second[0].start if second else NAN,
        "second_end": second[0].end if second else NAN,
        "longest_stick_start": start,
        "longest_stick": duration,
        "verdicts": {claim.id: claim.judge(models).verdict for claim in CLAIMS if claim.case == "paper"},
    }


def _judge(made: Reproduction) -> list[Judged]:
    found = []
    for claim in CLAIMS:
        findings = {scheme: claim.judge(models) for scheme, models in made.models(claim.case).items()}
        verdicts = [row["verdicts"][claim.id] for row in made.combinations if claim.id in row["verdicts"]]
        found.append(Judged(claim, findings, _counted(verdicts) if verdicts else None))
    return found


def _counted(verdicts: Sequence[str]) -> dict[str, int]:
    return {verdict: verdicts.count(verdict) for verdict in VERDICTS}
