"""Run a study: every level of every ladder in parallel, then the verdict on each quantity."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from oblique_impact.errors import Outcome
from oblique_impact.progress import OnProgress, silent
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import simulate
from validation.parallel import map_parallel, told
from validation.refinement.convergence import Analysis, analyse
from validation.refinement.ladders import AXES, Axis, Ladder, Study, sizes
from validation.refinement.quantities import GapError, Quantity, default_quantities, natural_scale, quantity

#: the run that measures the noise takes this part of the tolerance, within what a scenario allows
_TIGHTER, _TIGHTEST = 0.1, 1e-13


@dataclass(frozen=True)
class Task:
    """One run: its scenario and what it is asked for."""

    scenario: Scenario
    quantities: tuple[str, ...]
    label: str


@dataclass(frozen=True)
class RunResult:
    """What a study keeps of a run; `gaps` says why a quantity is missing, `energy` (J) is the run's scale."""

    values: dict[str, float]
    gaps: dict[str, str]
    outcome: str
    sentence: str
    end_time: float
    steps: int
    events: int
    energy: float
    seconds: float

    @property
    def mean_step(self) -> float:
        """Mean length of the steps (s)."""
        return self.end_time / max(self.steps, 1)

    @property
    def completed(self) -> bool:
        """Whether the run reached its end time."""
        return self.outcome == Outcome.COMPLETED.label


@dataclass(frozen=True)
class QuantityResult:
    """Values of one quantity over the levels of a ladder, and what they say."""

    quantity: Quantity
    declared: float | None
    scale: float
    values: tuple[float, ...]
    gaps: tuple[str, ...]
    analysis: Analysis


@dataclass(frozen=True)
class LadderResult:
    """A ladder with its runs, coarse to fine."""

    ladder: Ladder
    axis: Axis
    scenarios: tuple[Scenario, ...]
    sizes: tuple[float, ...]
    remark: str
    runs: tuple[RunResult, ...]
    results: tuple[QuantityResult, ...]

    def quantity(self, name: str) -> QuantityResult:
        """Return the result of one quantity by name; raises KeyError."""
        for item in self.results:
            if item.quantity.name == name:
                return item
        raise KeyError(name)


@dataclass(frozen=True)
class StudyResult:
    """A study with everything it found.

    Attributes
    ----------
    study : Study
        What was refined.
    tolerance : float
        Relative uncertainty at which a quantity counts as converged.
    ladders : tuple of LadderResult
        With runs and verdicts.
    seconds : float
        Wall time (s): the only number that changes from run to run.
    report : Path or None
        The page, if one was written.
    """

    study: Study
    tolerance: float
    ladders: tuple[LadderResult, ...]
    seconds: float
    report: Path | None = None

    def quantity(self, name: str, ladder: int = 0) -> QuantityResult:
        """Return the result of a quantity on a ladder (by number from 0); raises KeyError."""
        return self.ladders[ladder].quantity(name)


def run_task(task: Task) -> RunResult:
    """Simulate and measure; runs in a process of its own."""
    started = time.perf_counter()
    history = simulate(task.scenario)
    values, gaps = {}, {}
    for name in task.quantities:
        try:
            values[name] = quantity(name).measure(history)
        except GapError as gap:
            values[name], gaps[name] = math.nan, str(gap)
    summary = history.summary
    return RunResult(
        values,
        gaps,
        summary["outcome"],
        summary["message"],
        float(summary["end_time"]),
        int(summary["steps"]),
        int(summary["events"]),
        max(abs(float(summary["energy"][key])) for key in ("initial", "final")),
        time.perf_counter() - started,
    )


@dataclass(frozen=True)
class _Plan:
    ladder: Ladder
    quantities: tuple[Quantity, ...]
    scenarios: tuple[Scenario, ...]
    noisy: Scenario | None


def run_study(
    study: Study,
    changes: Sequence[str] = (),
    quantities: Sequence[str] = (),
    tolerance: float | None = None,
    workers: int | None = None,
    before_running: Callable[[], object] = lambda: None,
    on_progress: OnProgress = silent,
) -> StudyResult:
    """Run all levels of all ladders and judge them.

    Parameters
    ----------
    study : Study
        What to refine.
    changes : sequence of str
        "section.key=value", for every ladder.
    quantities : sequence of str
        In place of the ladders' own.
    tolerance : float
        Relative uncertainty at which a quantity counts as converged; default: the study's.
    workers : int, optional
        Parallel processes.
    before_running : callable
        Called once when nothing is left to refuse.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` before the first and after each run.

    Raises
    ------
    InputError
        In one line, before anything runs, if a level or a quantity is not possible.
    """
    started = time.perf_counter()
    tolerance = study.tolerance if tolerance is None else tolerance
    plans = [_plan(ladder, changes, quantities) for ladder in study.ladders]
    before_running()
    tasks: list[tuple[int, int, Task]] = []
    for number, plan in enumerate(plans):
        names = tuple(q.name for q in plan.quantities)
        several = [*plan.scenarios, *([plan.noisy] if plan.noisy else [])]
        for level, scenario in enumerate(several):
            tasks.append((number, level, Task(scenario, names, plan.ladder.name)))
    # the finest levels take longest: first the noise runs and the last levels
    tasks.sort(key=lambda task: len(plans[task[0]].scenarios) - task[1])
    inner = [task for *_, task in tasks]
    found = map_parallel(run_task, inner, workers, told(on_progress, [task.label for task in inner]))
    by_place = {(number, level): result for (number, level, _), result in zip(tasks, found, strict=True)}
    ladders = []
    for number, plan in enumerate(plans):
        runs = tuple(by_place[number, level] for level in range(len(plan.scenarios)))
        ladders.append(_judge(plan, runs, by_place.get((number, len(runs))), tolerance))
    return StudyResult(study, tolerance, tuple(ladders), time.perf_counter() - started)


def _plan(ladder: Ladder, changes: Sequence[str], quantities: Sequence[str]) -> _Plan:
    scenario = ladder.base or Scenario.load(ladder.scenario, [*ladder.changes, *changes])
    names = tuple(dict.fromkeys(quantities or ladder.quantities or default_quantities(scenario)))
    chosen = tuple(quantity(name, scenario.end_time) for name in names)
    axis = AXES[ladder.axis]
    levels = tuple(axis.apply(scenario, level) for level in ladder.levels)
    noisy = None
    finest = levels[-1]
    if ladder.axis != "tolerances" and finest.solver.scheme != "fixed-step":
        tighter = max(_TIGHTER * finest.solver.tolerance, _TIGHTEST)
        noisy = finest.replace(solver__tolerance=tighter)
    return _Plan(ladder, chosen, levels, noisy)


def _judge(plan: _Plan, runs: tuple[RunResult, ...], noisy: RunResult | None, tolerance: float) -> LadderResult:
    ladder = plan.ladder
    h, remark = sizes(ladder.axis, ladder.levels, [run.mean_step for run in runs])
    results = []
    for q in plan.quantities:
        values = tuple(run.values[q.name] for run in runs)
        scale = natural_scale(q.unit, plan.scenarios[-1], runs[-1].energy)
        declared = ladder.declared.get(q.name)
        analysis = analyse(
            h,
            values,
            tolerance=tolerance,
            scale=scale,
            noise=_noise(values[-1], noisy, q.name),
            declared=declared,
        )
        gaps = tuple(run.gaps.get(q.name, "") for run in runs)
        results.append(QuantityResult(q, declared, scale, values, gaps, analysis))
    return LadderResult(ladder, AXES[ladder.axis], plan.scenarios, tuple(h), remark, runs, tuple(results))


def _noise(value: float, noisy: RunResult | None, name: str) -> float:
    """Change of the finest value under a tighter tolerance; infinite if it gets lost."""
    if noisy is None or math.isnan(value):
        return 0.0
    other = noisy.values[name]
    return abs(other - value) if math.isfinite(other) else math.inf
