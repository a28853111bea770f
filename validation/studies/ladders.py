"""Ladders: one scenario over the levels of one axis, the runs of all levels, and what their values say."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import pandas as pd

from oblique_impact.errors import InputError, Outcome
from oblique_impact.marching.event import EventScheme
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.report import rounded, shown_unit
from oblique_impact.validation.studies.convergence import (
    CONVERGED,
    CONVERGING,
    NO_VERDICT,
    TOLERANCE,
    Analysis,
    analyse,
)
from oblique_impact.validation.studies.quantities import Quantity, natural_scale, quantity
from oblique_impact.validation.studies.study import Run, reasons, same_warnings

#: the run that measures the noise takes this part of the tolerance, within what a scenario allows
_TIGHTER, _TIGHTEST = 0.1, 1e-13


@dataclass(frozen=True)
class Axis:
    """One way to refine."""

    #: of its levels, with their unit
    label: str
    unit: str
    #: representative size h, with its unit
    size: str
    #: whether finer levels are larger numbers
    rising: bool
    #: takes a scenario and a level, returns the scenario of that level
    change: Callable[[Scenario, float], Scenario]
    #: in what a verdict holds that does not add modes or elements
    within: str = ""


def _steps(scenario: Scenario, level: float) -> Scenario:
    solver = scenario.solver
    if solver.scheme == "event":
        raise InputError(
            '--steps: solver.scheme = "event" chooses its steps itself; refine --tolerances, '
            "or take --set solver.scheme=fixed-step or generalized-alpha"
        )
    changed = {"solver__free_step": level}
    if scenario.contact.enabled:
        changed["solver__contact_step"] = level * (solver.contact_step / solver.free_step)
    return scenario.replace(**changed)


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


def _elements(scenario: Scenario, level: float) -> Scenario:
    changed = {"discretization__method": "fem", "discretization__elements": int(level)}
    is_given = "grid" in scenario.contact.model_fields_set
    if is_given and 1 < scenario.contact.grid == scenario.discretization.elements:
        changed["contact__grid"] = int(level)  # a place of contact on each node
    return scenario.adapted(**changed)


def _nodes_alone(scenario: Scenario, level: float) -> Scenario:
    """End sides at the last node within them, as if the places between nodes could not touch."""
    element = scenario.beam.length / level
    sides = [side.model_dump(exclude_unset=True) for side in scenario.obstacles]
    for side in sides:
        if side.get("extent"):
            side["extent"] = [side["extent"][0], element * math.floor(side["extent"][1] / element)]
    return _elements(scenario, level).replace(obstacles=sides)


#: by the name of the option, or of studies alone
AXES = {
    "elements": Axis("elements", "1", "1/elements", True, _elements),
    "modes": Axis(
        "modes", "1", "1/modes", True, lambda base, level: base.replace(discretization__modes=int(level))
    ),
    "steps": Axis("free step", "s", "free step (s)", False, _steps, " in the step"),
    "stiffness": Axis("stiffness", "N/m", "1/stiffness (m/N)", True, _stiffness, " in the stiffness"),
    "tolerances": Axis("tolerance", "1", "mean step (s)", False, _tolerances, " in the tolerance"),
    "nodes alone": Axis("elements", "1", "1/elements", True, _nodes_alone),
}


@dataclass(frozen=True)
class Ladder:
    """One scenario over the levels of one axis."""

    #: short, for tables and legends
    name: str
    #: what is refined
    base: Scenario
    #: a key of `AXES`
    axis: str
    #: from coarse to fine
    levels: tuple[float, ...]
    #: what is measured
    quantities: tuple[str, ...]
    #: order that the method declares, by quantity; those not named have none
    declared: Mapping[str, float] = field(default_factory=dict)
    #: what the scenario is called: a built-in one that it differs from, or a file
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


@dataclass(frozen=True, repr=False)
class QuantityResult:
    """One quantity over the levels of a ladder, and what its values say."""

    quantity: Quantity
    #: order that the method declares
    declared: float | None
    #: what a small value is measured by (unit of the value)
    scale: float
    #: why a level does not have it, "" if it does
    gaps: tuple[str, ...]
    analysis: Analysis
    #: why it has no limit as modes or elements are added, "" if it has
    without_limit: str = ""

    @property
    def values(self) -> list[float]:
        """Values, coarse to fine; NaN where a level does not have it."""
        return [float(value) for value in self.analysis.levels["value"]]

    @property
    def finest(self) -> str:
        """The finest value in the digits of its uncertainty, with that and the unit, or why there is none."""
        a, unit = self.analysis, shown_unit(self.quantity.unit)
        value, digits = rounded(self.values[-1], a.uncertainty)
        known = f" +- {a.uncertainty:.2g}" if a.verdict in (CONVERGED, CONVERGING) else ""
        return self.gaps[-1] or f"{value:.{digits}g}{known} {unit}".strip()

    def __repr__(self) -> str:
        """Return value, verdict and reason in a line."""
        return f"<{self.quantity.name}: {self.finest}, {self.analysis.words} ({self.analysis.reason})>"


@dataclass(frozen=True, repr=False)
class LadderResult:
    """A ladder with the frame of its levels, coarse to fine; `remark` is about the sizes h."""

    ladder: Ladder
    runs: pd.DataFrame
    sizes: tuple[float, ...]
    remark: str
    results: tuple[QuantityResult, ...]

    def __repr__(self) -> str:
        """Return a line for each quantity."""
        return "\n".join([f"<LadderResult: {self.ladder.name}>", *(f"  {item!r}" for item in self.results)])

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
            names = "; ".join(item.quantity.meaning for item in lost)
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
