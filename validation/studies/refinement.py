"""Refinement: one scenario over levels of elements, modes, steps, stiffness or tolerance, and what converges."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

import pandas as pd

from oblique_impact.errors import InputError, Outcome
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.progress import OnProgress, silent
from oblique_impact.scenario.scenario import Scenario, require_scenario
from oblique_impact.validation.studies.convergence import (
    CONVERGED,
    CONVERGING,
    NO_VERDICT,
    TOLERANCE,
    Analysis,
    analyse,
)
from oblique_impact.validation.studies.quantities import Quantity, default_quantities, natural_scale, quantity
from oblique_impact.validation.studies.study import Run, reasons, run_study, same_warnings

#: levels that a verdict needs, and most that are run
FEWEST, MOST = 3, 16
#: the run that measures the noise takes this part of the tolerance, within what a scenario allows
_TIGHTER, _TIGHTEST = 0.1, 1e-13
#: quantities that converge at no order of a method: counts, and largest values among samples
_ROUGH = ("contacts", "events", "peak_force", "unaccounted")


@dataclass(frozen=True)
class Axis:
    """One way to refine.

    Attributes
    ----------
    label, unit : str
        Of its levels.
    size : str
        Representative size h, with its unit.
    rising : bool
        Whether finer levels are larger numbers.
    change : callable
        Takes a scenario and a level, returns the scenario of that level.
    within : str
        In what a verdict holds that does not add modes or elements.
    """

    label: str
    unit: str
    size: str
    rising: bool
    change: Callable[[Scenario, float], Scenario]
    within: str = ""

    @property
    def whole(self) -> bool:
        """Whether its levels are counts."""
        return self.rising and self.unit == "1"

    @property
    def numbers(self) -> str:
        """Allowed levels, in words for messages."""
        return f"{'whole numbers from 1' if self.whole else 'numbers above 0'} separated by commas"


def _steps(scenario: Scenario, level: float) -> Scenario:
    solver = scenario.solver
    if solver.scheme == "event":
        raise InputError(
            '--steps: solver.scheme = "event" chooses its steps itself; refine --tolerances, '
            "or take --set solver.scheme=fixed-step or generalized-alpha"
        )
    contact_step = level * (solver.contact_step / solver.free_step)
    return scenario.replace(solver__free_step=level, solver__contact_step=contact_step)


def _stiffness(scenario: Scenario, level: float) -> Scenario:
    if scenario.contact.normal != "spring":
        raise InputError(f'--stiffness: contact.normal = "{scenario.contact.normal}"; refine that of a "spring"')
    return scenario.replace(contact__stiffness=level)


def _tolerances(scenario: Scenario, level: float) -> Scenario:
    if scenario.solver.scheme != "event":
        raise InputError(
            f'--tolerances: solver.scheme = "{scenario.solver.scheme}" has steps of given length; refine --steps'
        )
    return scenario.replace(solver__tolerance=level)


#: by the name of the option
AXES = {
    "elements": Axis(
        "elements",
        "1",
        "1/elements",
        True,
        lambda base, level: base.replace(discretization__method="fem", discretization__elements=int(level)),
    ),
    "modes": Axis(
        "modes", "1", "1/modes", True, lambda base, level: base.replace(discretization__modes=int(level))
    ),
    "steps": Axis("free step", "s", "free step (s)", False, _steps, " in the step"),
    "stiffness": Axis("stiffness", "N/m", "1/stiffness (m/N)", True, _stiffness, " in the stiffness"),
    "tolerances": Axis("tolerance", "1", "mean step (s)", False, _tolerances, " in the tolerance"),
}


@dataclass(frozen=True)
class Ladder:
    """One scenario over the levels of one axis.

    Attributes
    ----------
    name : str
        Short, for tables and legends.
    base : Scenario
        What is refined.
    axis : str
        A key of `AXES`.
    levels : tuple of float
        From coarse to fine.
    quantities : tuple of str
        What is measured.
    declared : mapping
        Order that the method declares, by quantity; those not named have none.
    text : str
        What this ladder shows, for the report.
    scenario : str
        What the scenario is called: a built-in one that it differs from, or a file.
    """

    name: str
    base: Scenario
    axis: str
    levels: tuple[float, ...]
    quantities: tuple[str, ...]
    declared: Mapping[str, float] = field(default_factory=dict)
    text: str = ""
    scenario: str = "paper"

    @property
    def finest(self) -> Scenario:
        """Scenario of the last level."""
        return AXES[self.axis].change(self.base, self.levels[-1])

    def changed(self, changes: Sequence[str], quantities: Sequence[str]) -> Ladder:
        """Return the ladder with changes "section.key=value", and other quantities if any are given."""
        base = Scenario.from_toml(self.base.to_toml(), list(changes), "") if changes else self.base
        return replace(self, base=base, quantities=tuple(dict.fromkeys(quantities)) or self.quantities)

    def runs(self) -> list[Run]:
        """Return the runs: a level each, and the finest once more with a tighter tolerance to measure its noise.

        A fixed-step run, or one over tolerances, has no noise.  Raises InputError for what is not possible.
        """
        for name in self.quantities:
            quantity(name, self.base.end_time)
        axis, finest = AXES[self.axis], self.finest
        found = [(axis.label, level, axis.change(self.base, level)) for level in self.levels]
        if self.axis != "tolerances" and finest.solver.scheme != "fixed-step":
            tighter = max(_TIGHTER * finest.solver.tolerance, _TIGHTEST)
            found.append(("noise", self.levels[-1], finest.replace(solver__tolerance=tighter)))
        return [
            Run({"ladder": self.name, "axis": label, "level": level}, scenario, self.quantities)
            for label, level, scenario in found
        ]

    @property
    def within(self) -> str:
        """In what it refines at a fixed number of modes, "" if it adds modes or elements."""
        if self.axis == "elements" and self.finest.discretization.modes > 0:
            return " in the mesh"
        return AXES[self.axis].within


@dataclass(frozen=True)
class Study:
    """Ladders that belong together, and the relative uncertainty at which a quantity counts as converged."""

    name: str
    title: str
    text: str
    ladders: tuple[Ladder, ...]
    tolerance: float = TOLERANCE


@dataclass(frozen=True)
class QuantityResult:
    """One quantity over the levels of a ladder, and what its values say.

    Attributes
    ----------
    declared : float or None
        Order that the method declares.
    scale : float
        What a small value is measured by (unit of the value).
    gaps : tuple of str
        Why a level does not have it, "" if it does.
    without_limit : str
        Why it has no limit as modes or elements are added, "" if it has.
    """

    quantity: Quantity
    declared: float | None
    scale: float
    gaps: tuple[str, ...]
    analysis: Analysis
    without_limit: str = ""

    @property
    def values(self) -> list[float]:
        """Values, coarse to fine; NaN where a level does not have it."""
        return [float(value) for value in self.analysis.levels["value"]]


@dataclass(frozen=True)
class LadderResult:
    """A ladder with the frame of its levels, coarse to fine; `remark` is about the sizes h."""

    ladder: Ladder
    runs: pd.DataFrame
    sizes: tuple[float, ...]
    remark: str
    results: tuple[QuantityResult, ...]

    @property
    def axis(self) -> Axis:
        """Axis of the refinement: elements, modes, steps, stiffness or tolerance."""
        return AXES[self.ladder.axis]

    def quantity(self, name: str) -> QuantityResult:
        """Return the result of one quantity by name; raises KeyError."""
        return {item.quantity.name: item for item in self.results}[name]

    @property
    def remarks(self) -> list[str]:
        """Sentences about the ladder: what has no limit over modes, uneven events, warnings with their levels."""
        remarks = []
        lost = [item for item in self.results if item.without_limit]
        if self.ladder.within and lost:
            names = ", ".join(item.quantity.name for item in lost)
            remarks.append(
                f"{names}: no limit as modes or elements are added ({lost[0].without_limit}); "
                f"what has converged{self.ladder.within} has done so at this number of modes or elements alone"
            )
        counts = self.runs["events"][self.runs["outcome"] == Outcome.COMPLETED.label].tolist()
        if len(set(counts)) > 1:
            remarks.append(
                f"the number of events differs from level to level ({', '.join(map(str, counts))}); what comes "
                "after the first event that some level lacks is not the same motion, whatever its verdict"
            )
        labels = (f"{level:g}" for level in self.ladder.levels)
        found = same_warnings(zip(labels, self.runs["warnings"], strict=True))
        return remarks + [f"warning ({self.axis.label} {', '.join(levels)}): {text}" for text, levels in found]


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
        """Return a line for each quantity: for a prompt or a notebook."""
        lines = [f"<StudyResult: {', '.join(found.ladder.name for found in self.ladders)}; {self.seconds:.1f} s>"]
        for found in self.ladders:
            lines += [f"  {item.quantity.name}: {item.analysis.words}" for item in found.results]
        return "\n".join(lines)


def sizes_of(axis: str, levels: Sequence[float], mean_steps: Sequence[float]) -> tuple[list[float], str]:
    """Return the sizes h of the levels, and a remark if they are not what the axis promises.

    The size that goes with a tolerance is the mean step (s) the run took.  If these do not fall, as with loose
    tolerances whose steps are cut by stability, the root of the tolerance to the scheme's order takes its place.
    """
    if AXES[axis].rising:
        return [1.0 / level for level in levels], ""
    if axis == "steps":
        return list(levels), ""
    if all(b < a for a, b in pairwise(mean_steps)):
        return list(mean_steps), ""
    remark = f"The mean steps do not fall from level to level; tolerance^(1/{EventScheme.order}) is the size."
    return [level ** (1.0 / EventScheme.order) for level in levels], remark


def judge(ladder: Ladder, frame: pd.DataFrame, tolerance: float) -> LadderResult:
    """Judge every quantity of a ladder by the frame of its runs."""
    count = len(ladder.levels)
    runs, noisy = frame.iloc[:count], frame.iloc[count:]
    h, remark = sizes_of(ladder.axis, ladder.levels, (runs["stopped_at"] / runs["steps"].clip(lower=1)).tolist())
    finest, finest_scenario = runs.iloc[-1], ladder.finest
    lost, results = reasons(finest["undetermined"]), []
    for name in ladder.quantities:
        q, values, noise = quantity(name), runs[name].tolist(), 0.0
        # a run that failed has nothing but its message
        gaps = tuple(
            "" if math.isfinite(row[name]) else reasons(row["gaps"]).get(name, row["message"])
            for row in runs.to_dict("records")
        )
        if len(noisy) and math.isfinite(values[-1]):
            other = float(noisy[name].iloc[0])
            noise = abs(other - values[-1]) if math.isfinite(other) else math.inf
        scale = natural_scale(q.unit, finest_scenario, finest["energy"])
        declared, without_limit = ladder.declared.get(name), lost.get(name, "")
        analysis = analyse(h, values, tolerance=tolerance, scale=scale, noise=noise, declared=declared)
        analysis = replace(analysis, within=ladder.within)
        if without_limit and not ladder.within and analysis.verdict != NO_VERDICT:
            analysis = analysis.undetermined(without_limit)
        results.append(QuantityResult(q, declared, scale, gaps, analysis, without_limit))
    return LadderResult(ladder, runs, tuple(h), remark, tuple(results))


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
    from oblique_impact.validation.studies.refinement_report import level_frame, report, study_data
    from oblique_impact.validation.studies.shipped import shipped_study

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
        raise InputError(f"--{axis} {text}: should be {AXES[axis].numbers}") from None


def check_levels(axis: str, levels: Sequence[float]) -> None:
    """Raise InputError unless there are enough levels, each finer than the one before."""
    kind, text = AXES[axis], ",".join(f"{level:g}" for level in levels)
    if not all(math.isfinite(v) and (v >= 1.0 and v == int(v) if kind.whole else v > 0.0) for v in levels):
        raise InputError(f"--{axis} {text}: should be {kind.numbers}")
    if not FEWEST <= len(levels) <= MOST:
        raise InputError(f"--{axis} {text}: a verdict takes {FEWEST} to {MOST} levels, these are {len(levels)}")
    if not all(b > a if kind.rising else b < a for a, b in pairwise(levels)):
        order = "increase" if kind.rising else "decrease"
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
