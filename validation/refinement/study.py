"""Run a study: every level of every ladder measured, then the verdict on each quantity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

from oblique_impact.errors import Outcome
from oblique_impact.progress import OnProgress, Progress
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.journal import Journal, fingerprint_of
from oblique_impact.validation.measuring import Row, Task, measure_each, same_warnings
from oblique_impact.validation.quantities import Quantity, default_quantities, natural_scale, quantity
from oblique_impact.validation.refinement.convergence import NO_VERDICT, Analysis, analyse
from oblique_impact.validation.refinement.ladders import AXES, Axis, Ladder, Study, fixed_modes, sizes

#: the run that measures the noise takes this part of the tolerance, within what a scenario allows
_TIGHTER, _TIGHTEST = 0.1, 1e-13
#: rows of a study that is not finished, in the folder of its report
ROWS = "refine-rows.jsonl"


@dataclass(frozen=True)
class QuantityResult:
    """Values of one quantity over the levels of a ladder, and what they say.

    `without_limit` says why it has no limit as modes or elements are added, "" if it has.
    """

    quantity: Quantity
    declared: float | None
    scale: float
    values: tuple[float, ...]
    gaps: tuple[str, ...]
    analysis: Analysis
    without_limit: str = ""


@dataclass(frozen=True)
class LadderResult:
    """A ladder with its runs, coarse to fine; `base` is what is refined, `remark` is about the sizes."""

    ladder: Ladder
    axis: Axis
    base: Scenario
    scenarios: tuple[Scenario, ...]
    sizes: tuple[float, ...]
    remark: str
    runs: tuple[Row, ...]
    results: tuple[QuantityResult, ...]

    def quantity(self, name: str) -> QuantityResult:
        """Return the result of one quantity by name; raises KeyError."""
        for item in self.results:
            if item.quantity.name == name:
                return item
        raise KeyError(name)

    @property
    def remarks(self) -> list[str]:
        """Sentences about the ladder: what has no limit over modes, uneven events, warnings with their levels."""
        fixed, said = fixed_modes(self.axis, self.scenarios[-1]), []
        lost = [item for item in self.results if item.without_limit]
        if fixed and lost:
            names = ", ".join(item.quantity.name for item in lost)
            said.append(
                f"{names}: no limit as modes or elements are added ({lost[0].without_limit}); "
                f"what has converged{fixed} has done so at this number of modes or elements alone"
            )
        said += [self.uneven] if self.uneven else []
        runs = zip(self.ladder.levels, self.runs, strict=True)
        found = same_warnings((f"{level:g}", run["warnings"]) for level, run in runs)
        return said + [f"warning ({self.axis.label} {', '.join(levels)}): {text}" for text, levels in found]

    @property
    def uneven(self) -> str:
        """Say that levels have different numbers of events, "" if they have not."""
        counts = [run["events"] for run in self.runs if run["outcome"] == Outcome.COMPLETED.label]
        if len(set(counts)) < 2:
            return ""
        return (
            f"the number of events differs from level to level ({', '.join(map(str, counts))}); what comes after "
            "the first event that some level lacks is not the same motion, whatever its verdict"
        )


@dataclass(frozen=True, repr=False)
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
        Wall time (s): with those of the runs, the only numbers that change from time to time.
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

    def __repr__(self) -> str:
        """Say in a line each what was found: for a prompt or a notebook."""
        lines = [f"<StudyResult: {', '.join(found.ladder.name for found in self.ladders)}; {self.seconds:.1f} s>"]
        for found in self.ladders:
            lines += [f"  {item.quantity.name}: {item.analysis.words}" for item in found.results]
        return "\n".join(lines)


@dataclass(frozen=True)
class LadderPlan:
    """A ladder that can run: the scenarios of its levels, and the finest once more to measure its noise."""

    ladder: Ladder
    quantities: tuple[Quantity, ...]
    base: Scenario
    scenarios: tuple[Scenario, ...]
    noisy: Scenario | None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the quantities."""
        return tuple(q.name for q in self.quantities)

    @property
    def all(self) -> tuple[Scenario, ...]:
        """Return everything that is simulated."""
        return (*self.scenarios, self.noisy) if self.noisy else self.scenarios


def plan_ladder(ladder: Ladder, changes: Sequence[str] = (), quantities: Sequence[str] = ()) -> LadderPlan:
    """Make the scenarios of a ladder, with further changes, "section.key=value", and in place of its quantities.

    Raises InputError, in one line, if a level or a quantity is not possible.
    """
    base = ladder.base or Scenario.load(ladder.scenario, [*ladder.changes, *changes])
    names = tuple(dict.fromkeys(quantities or ladder.quantities or default_quantities(base)))
    chosen = tuple(quantity(name, base.end_time) for name in names)
    levels = tuple(AXES[ladder.axis].apply(base, level) for level in ladder.levels)
    noisy, solver = None, levels[-1].solver
    if ladder.axis != "tolerances" and solver.scheme != "fixed-step":
        noisy = levels[-1].replace(solver__tolerance=max(_TIGHTER * solver.tolerance, _TIGHTEST))
    return LadderPlan(ladder, chosen, base, levels, noisy)


def measure(
    plans: Sequence[LadderPlan],
    folder: Path | None,
    on_progress: OnProgress,
    workers: int | None = None,
    scheduler: str | None = None,
    timeout: float | None = None,
) -> list[list[Row]]:
    """Run everything, but for what an interrupted study has left in `folder`; returns the rows of each ladder."""
    runs = [(plan, level, scenario) for plan in plans for level, scenario in enumerate(plan.all)]
    tasks = [
        Task(number, scenario, plan.names, timeout=timeout, label=plan.ladder.name)
        for number, (plan, _, scenario) in enumerate(runs)
    ]
    # the finest levels take longest: first the noise runs and the last levels
    levels_left = [len(plan.scenarios) - level for plan, level, _ in runs]
    tasks.sort(key=lambda task: levels_left[task.number])
    rows = iter(measure_rows(tasks, folder, on_progress, workers, scheduler))
    return [list(islice(rows, len(plan.all))) for plan in plans]


def measure_rows(
    tasks: Sequence[Task],
    folder: Path | None,
    on_progress: OnProgress,
    workers: int | None = None,
    scheduler: str | None = None,
) -> list[Row]:
    """Run tasks in their order, but for those that an interrupted study has left; returns all by number.

    With a folder, each row is on disk as soon as it is finished, until all are there.
    """
    journal = None if folder is None else _journal(folder, tasks)
    rows = {row["run"]: row for row in journal.rows()} if journal else {}
    on_progress(Progress(len(rows), len(tasks)))
    left, labels = [task for task in tasks if task.number not in rows], {task.number: task.label for task in tasks}
    try:
        for row, _ in measure_each(left, workers, scheduler):
            rows[row["run"]] = row
            if journal:
                journal.add(row)
            on_progress(Progress(len(rows), len(tasks), labels[row["run"]]))
    except KeyboardInterrupt:
        kept = f"{len(rows)} of {len(tasks)} runs are kept; the same command goes on with the others"
        raise KeyboardInterrupt(*([kept] if journal else [])) from None
    if journal:
        journal.remove()
    return [rows[number] for number in sorted(rows)]


def _journal(folder: Path, tasks: Sequence[Task]) -> Journal:
    """Open the rows that an interrupted study of these runs may have left."""
    runs = [[task.number, task.base.model_dump(mode="json"), task.quantities] for task in tasks]
    names = {name for task in tasks for name in task.quantities}
    return Journal(folder / ROWS, fingerprint_of({"runs": runs}), len(tasks), names)


def judge(plan: LadderPlan, rows: Sequence[Row], tolerance: float) -> LadderResult:
    """Judge every quantity of a ladder by its rows."""
    ladder, runs = plan.ladder, tuple(rows[: len(plan.scenarios)])
    noisy = rows[-1] if plan.noisy else None
    h, remark = sizes(ladder.axis, ladder.levels, [run["stopped_at"] / max(run["steps"], 1) for run in runs])
    within, results = fixed_modes(AXES[ladder.axis], plan.scenarios[-1]), []
    for q in plan.quantities:
        values = tuple(run["values"].get(q.name, math.nan) for run in runs)
        # a run that failed has nothing but its message
        gaps = tuple(
            "" if not math.isnan(v) else r["gaps"].get(q.name, r["message"])
            for v, r in zip(values, runs, strict=True)
        )
        scale = natural_scale(q.unit, plan.scenarios[-1], runs[-1]["energy"])
        declared = ladder.declared.get(q.name)
        noise = _noise(values[-1], noisy, q.name)
        analysis = analyse(h, values, tolerance=tolerance, scale=scale, noise=noise, declared=declared)
        analysis = replace(analysis, within=within)
        lost = runs[-1]["undetermined"].get(q.name, "")
        if lost and not within and analysis.verdict != NO_VERDICT:
            analysis = analysis.undetermined(lost)
        results.append(QuantityResult(q, declared, scale, values, gaps, analysis, lost))
    return LadderResult(
        ladder, AXES[ladder.axis], plan.base, plan.scenarios, tuple(h), remark, runs, tuple(results)
    )


def _noise(value: float, noisy: Row | None, name: str) -> float:
    """Change of the finest value under a tighter tolerance; infinite if it gets lost."""
    if noisy is None or math.isnan(value):
        return 0.0
    other = noisy["values"].get(name, math.nan)
    return abs(other - value) if math.isfinite(other) else math.inf
