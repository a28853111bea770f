"""What is refined: a ladder takes one scenario through levels of one axis, from coarse to fine."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from oblique_impact.errors import InputError
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.refinement.convergence import TOLERANCE

#: levels that a verdict needs
FEWEST, MOST = 3, 16


@dataclass(frozen=True)
class Axis:
    """One way to refine.

    Attributes
    ----------
    name : str
        Also the command line's option.
    label, unit : str
        Of the level.
    size_label : str
        Of the representative size h, with its unit.
    rising : bool
        Whether finer levels are larger numbers.
    within : str
        What else than the number of modes or elements it refines, for verdicts: " in the step".
    apply : callable
        Takes a scenario and a level, returns the scenario of that level.
    """

    name: str
    label: str
    unit: str
    size_label: str
    rising: bool
    apply: Callable[[Scenario, float], Scenario]
    within: str = ""

    @property
    def whole(self) -> bool:
        """Whether levels are whole numbers."""
        return self.rising and self.unit == "1"

    @property
    def heading(self) -> str:
        """Label and unit of the levels, for tables."""
        return self.label if self.unit == "1" else f"{self.label} ({self.unit})"


@dataclass(frozen=True)
class Ladder:
    """One scenario over the levels of one axis.

    Attributes
    ----------
    name : str
        Short, for tables and legends.
    scenario : str
        A built-in scenario or a file.
    changes : tuple of str
        "section.key=value".
    axis : str
        A key of `AXES`.
    levels : tuple of float
        From coarse to fine.
    quantities : tuple of str
        Empty: the usual ones of the scenario.
    declared : mapping
        Order that the method declares, by quantity; those not named have none.
    text : str
        What this ladder shows, for the report.
    group : str
        Ladders of one group share a table of verdicts and pictures of comparison.
    base : Scenario, optional
        The scenario itself; `scenario` is then what it is called.
    """

    name: str
    scenario: str
    changes: tuple[str, ...]
    axis: str
    levels: tuple[float, ...]
    quantities: tuple[str, ...] = ()
    declared: Mapping[str, float] = field(default_factory=dict)
    text: str = ""
    group: str = ""
    base: Scenario | None = None


@dataclass(frozen=True)
class Study:
    """Ladders that belong together, with what they are about.

    Attributes
    ----------
    tolerance : float
        Relative uncertainty at which a quantity counts as converged, unless the user says otherwise.
    compare : str
        How pictures show the ladders of a group side by side: by their "values", by "errors" (differences from the
        finest level of the group's first ladder), or not at all ("").
    """

    name: str
    title: str
    text: str
    ladders: tuple[Ladder, ...]
    tolerance: float = TOLERANCE
    compare: str = ""


def _elements(scenario: Scenario, level: float) -> Scenario:
    return scenario.replace(discretization__method="fem", discretization__elements=int(level))


def _modes(scenario: Scenario, level: float) -> Scenario:
    return scenario.replace(discretization__modes=int(level))


def _steps(scenario: Scenario, level: float) -> Scenario:
    solver = scenario.solver
    if solver.scheme == "event":
        raise InputError(
            '--steps: solver.scheme = "event" chooses its steps itself; refine --tolerances, '
            "or take --set solver.scheme=fixed-step or generalized-alpha"
        )
    contact_step = level * (solver.contact_step / solver.free_step)
    return scenario.replace(solver__free_step=level, solver__contact_step=contact_step)


def _tolerances(scenario: Scenario, level: float) -> Scenario:
    if scenario.solver.scheme != "event":
        raise InputError(
            f'--tolerances: solver.scheme = "{scenario.solver.scheme}" has steps of given length; refine --steps'
        )
    return scenario.replace(solver__tolerance=level)


def _stiffness(scenario: Scenario, level: float) -> Scenario:
    if scenario.contact.normal != "spring":
        raise InputError(f'--stiffness: contact.normal = "{scenario.contact.normal}"; refine that of a "spring"')
    return scenario.replace(contact__stiffness=level)


def fixed_modes(axis: Axis, scenario: Scenario) -> str:
    """Return in what a ladder refines at a fixed number of modes, "" if it adds modes or elements."""
    if axis.name == "elements" and scenario.discretization.modes > 0:
        return " in the mesh"
    return axis.within


AXES = {
    axis.name: axis
    for axis in (
        Axis("elements", "elements", "1", "1/elements", True, _elements),
        Axis("modes", "modes", "1", "1/modes", True, _modes),
        Axis("steps", "free step", "s", "free step (s)", False, _steps, " in the step"),
        Axis("stiffness", "stiffness", "N/m", "1/stiffness (m/N)", True, _stiffness, " in the stiffness"),
        Axis("tolerances", "tolerance", "1", "mean step (s)", False, _tolerances, " in the tolerance"),
    )
}


def levels_by_axis(elements: Any, modes: Any, steps: Any, stiffness: Any, tolerances: Any) -> dict[str, Any]:
    """Return the levels that are given, not None, by the name of their axis."""
    levels = zip(AXES, (elements, modes, steps, stiffness, tolerances), strict=True)
    return {axis: found for axis, found in levels if found is not None}


def parse_levels(axis: str, text: str) -> list[float]:
    """Read the levels of an axis from the command line: numbers separated by commas; raises InputError."""
    whole = AXES[axis].whole
    try:
        return [int(part) if whole else float(part) for part in text.split(",")]
    except ValueError:
        raise InputError(f"--{axis} {text}: should be {_numbers(axis)} separated by commas") from None


def check_levels(axis: str, levels: Sequence[float]) -> None:
    """Raise InputError unless there are enough levels, each finer than the one before."""
    rising, whole, text = AXES[axis].rising, AXES[axis].whole, ",".join(f"{level:g}" for level in levels)
    if not all(math.isfinite(v) and (v >= 1.0 and v == int(v) if whole else v > 0.0) for v in levels):
        raise InputError(f"--{axis} {text}: should be {_numbers(axis)} separated by commas")
    if not FEWEST <= len(levels) <= MOST:
        raise InputError(f"--{axis} {text}: a verdict takes {FEWEST} to {MOST} levels, these are {len(levels)}")
    if not all(b > a if rising else b < a for a, b in pairwise(levels)):
        raise InputError(f"--{axis} {text}: should {'increase' if rising else 'decrease'}, from coarse to fine")


def _numbers(axis: str) -> str:
    return "whole numbers from 1" if AXES[axis].whole else "numbers above 0"


def sizes(axis: str, levels: Sequence[float], mean_steps: Sequence[float]) -> tuple[list[float], str]:
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


def declared_orders(axis: str, scenario: Scenario, quantities: Sequence[str]) -> dict[str, float]:
    """Orders that hold for any scenario, by quantity; few do.

    Frequencies of Hermite elements, and with them everything at a fixed number of modes, converge at order 4;
    generalized-alpha is of its order on motions without a rigid stop.  Forces and counts get none.
    """
    smooth = [name for name in quantities if name not in ("contacts", "events", "peak_force", "unaccounted")]
    smooth = [name for name in smooth if ":" not in name]
    rigid = scenario.contact.enabled and scenario.contact.normal == "rigid"
    order = 0.0
    if axis == "elements" and scenario.discretization.modes > 0:
        order = 4.0
    elif axis == "steps" and scenario.solver.scheme == "generalized-alpha" and not rigid:
        order = float(GeneralizedAlphaScheme.order)
    return dict.fromkeys(smooth, order) if order else {}
