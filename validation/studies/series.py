"""Refinement series: one scenario over the levels of one axis; studies of several, and their files."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, Field

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import one_of, plain_text, refused
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.section import InputSection
from oblique_impact.scenario.toml import flat_keys
from oblique_impact.validation.studies.convergence import TOLERANCE
from oblique_impact.validation.studies.design import Keys, check_keys, read_toml, scenario_beside
from oblique_impact.validation.studies.quantities import default_quantities, is_of_samples, quantity
from oblique_impact.validation.studies.study import StudyRun

#: the run that measures the noise takes this part of the tolerance, within what a scenario allows, and, for
#: extremes among samples, this part of the time between them
_TIGHTER, _TIGHTEST, _DENSER = 0.1, 1e-13, 0.25


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
    #: whether levels are whole numbers
    whole: bool = False


def _steps(scenario: Scenario, level: float) -> Scenario:
    solver = scenario.solver
    if solver.scheme == "event":
        raise InputError(
            '--steps: solver.scheme = "event" chooses its steps itself; refine --tolerances, '
            "or take --set solver.scheme=fixed-step, time-stepping or, on an elastic stop, generalized-alpha"
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
    changed: dict[str, object] = {"discretization__elements": int(level)}
    if scenario.discretization.method == "modal":
        changed["discretization__method"] = "fem"
    is_given = "grid" in scenario.contact.model_fields_set
    if is_given and 1 < scenario.contact.grid == scenario.discretization.elements:
        changed["contact__grid"] = int(level)  # a place of contact on each node
    return scenario.adapted(**changed)


def _modes(scenario: Scenario, level: float) -> Scenario:
    return scenario.replace(discretization__modes=int(level))


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
    "elements": Axis("elements", "1", "1/elements", True, _elements, whole=True),
    "modes": Axis("modes", "1", "1/modes", True, _modes, whole=True),
    "steps": Axis("free step", "s", "free step (s)", False, _steps, " in the step"),
    "stiffness": Axis("stiffness", "N/m", "1/stiffness (m/N)", True, _stiffness, " in the stiffness"),
    "tolerances": Axis("tolerance", "1", "mean step (s)", False, _tolerances, " in the tolerance"),
    "nodes alone": Axis("elements", "1", "1/elements", True, _nodes_alone, whole=True),
}
#: levels that a verdict needs, and most that are run
FEWEST, MOST = 3, 16


def check_levels(axis: str, levels: Sequence[float], what: str) -> None:
    """Raise InputError that begins with `what` unless there are enough levels, each finer than the one before."""
    rising, text = AXES[axis].rising, ",".join(f"{level:g}" for level in levels)
    if not all(math.isfinite(level) and level > 0.0 for level in levels):
        raise InputError(f"{what} {text}: should be numbers above 0")
    if AXES[axis].whole and any(level % 1.0 for level in levels):
        raise InputError(f"{what} {text}: should be whole numbers")
    if not FEWEST <= len(levels) <= MOST:
        raise InputError(f"{what} {text}: a verdict takes {FEWEST} to {MOST} levels, these are {len(levels)}")
    if not all(b > a if rising else b < a for a, b in pairwise(levels)):
        order = "increase" if rising else "decrease"
        raise InputError(f"{what} {text}: should {order}, from coarse to fine")


@dataclass(frozen=True)
class RefinementSeries:
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

    def changed(self, changes: Sequence[str], quantities: Sequence[str]) -> RefinementSeries:
        """Return the series with changes "section.key=value", and other quantities if any are given."""
        base = Scenario.from_toml(self.base.to_toml(), list(changes), "") if changes else self.base
        return replace(self, base=base, quantities=tuple(dict.fromkeys(quantities)) or self.quantities)

    def runs(self) -> list[StudyRun]:
        """Return the runs: a level each, and the finest once more with a tighter tolerance to measure its noise.

        Where an extreme among samples is asked for, that run has more of them: a sample misses an extreme.
        A fixed-step run, or one over tolerances, has no noise.  Raises InputError for what is not possible.
        """
        for name in self.quantities:
            quantity(name, self.base.end_time)
        axis, finest = AXES[self.axis], self.finest
        found = [(axis.label, level, axis.change(self.base, level)) for level in self.levels]
        if self.axis != "tolerances" and finest.solver.scheme != "fixed-step":
            tighter = max(_TIGHTER * finest.solver.tolerance, _TIGHTEST)
            denser = _DENSER if any(map(is_of_samples, self.quantities)) else 1.0
            accurate = {"tolerance": tighter, "output_interval": denser * finest.solver.output_interval}
            noise = finest.replace(**{f"solver__{key}": value for key, value in accurate.items()})
            found.append(("noise", self.levels[-1], noise))
        return [
            StudyRun({"series": self.name, "axis": label, "level": level}, scenario, self.quantities)
            for label, level, scenario in found
        ]

    @property
    def within(self) -> str:
        """In what it refines at a fixed number of modes, "" if it adds modes or elements."""
        if self.axis == "elements" and self.finest.discretization.in_modes:
            return " in the mesh"
        return AXES[self.axis].within


@dataclass(frozen=True)
class Study:
    """Series that belong together, and the relative uncertainty at which a quantity counts as converged."""

    name: str
    title: str
    description: str
    series: tuple[RefinementSeries, ...]
    tolerance: float = TOLERANCE


# --- study files


class _SeriesKeys(InputSection):
    """What describes a series."""

    scenario: str = "paper"
    axis: str = ""
    levels: list[float] = Field(default_factory=list)
    quantities: Keys | None = None
    orders: dict[str, Annotated[float, Field(gt=0.0)]] = Field(default_factory=dict)
    changes: dict[str, Any] = Field(default_factory=dict)


class SeriesSection(_SeriesKeys):
    """One series of a study file: what it does not give is that of the study, whose changes hold here too."""

    name: Annotated[str, Field(min_length=1)]


class StudySection(_SeriesKeys):
    """The table `[study]` of a study file: its text, and `[[study.series]]` with what they have in common.

    `scenario` is a built-in name or a file beside this one; `axis` is "elements", "modes", "steps", "stiffness",
    "tolerances" or "nodes alone" (ends of sides at the last node within them), with `levels` from coarse to fine;
    `orders` are those that the method declares, by quantity; `tolerance` is the relative uncertainty at which a
    quantity counts as converged.
    """

    title: Annotated[str, AfterValidator(plain_text)]
    description: str = ""
    tolerance: Annotated[float, Field(gt=0.0, lt=1.0)] = TOLERANCE
    series: Annotated[list[SeriesSection], Field(min_length=1)]

    def series_of(self, own: SeriesSection, folder: Path) -> RefinementSeries:
        """Return one of its series; raises InputError."""
        common = {name: getattr(self, name) for name in ("scenario", "axis", "levels", "quantities", "orders")}
        given = own.with_defaults(**common)
        if given.axis not in AXES:
            raise refused("axis", given.axis, one_of(given.axis, AXES))
        check_levels(given.axis, given.levels, "levels")
        changes = flat_keys(self.changes) | flat_keys(own.changes)
        check_keys(changes, "changes")
        base = scenario_beside(given.scenario, folder)
        base = base.adapted(**{key.replace(".", "__"): value for key, value in changes.items()})
        names = tuple(given.quantities or default_quantities(base))
        for name in given.orders:
            if name not in names:
                raise refused("orders", name, one_of(name, names))
        return RefinementSeries(
            own.name, base, given.axis, tuple(given.levels), names, given.orders, scenario=given.scenario
        )


def is_study(source: str | os.PathLike[str]) -> bool:
    """Return whether a path is that of a TOML file with a table `[study]`."""
    try:
        return "study" in read_toml(Path(source), "study")
    except InputError:
        return False


def load_study(source: str | os.PathLike[str]) -> Study:
    """Read a study file; raises InputError, in one line that names the key, its value and what is allowed.

    Examples
    --------
    >>> load_study("docs/studies/elements.toml").series[0].levels  # doctest: +SKIP
    (32.0, 64.0, 128.0, 256.0)
    """
    path = Path(source)
    data = read_toml(path, "study")
    if set(data) != {"study"}:
        raise InputError(f"{path}: a study file has the table [study] and nothing else")
    try:
        section = StudySection.from_dict(data["study"])
        names = [own.name for own in section.series]
        series = list[RefinementSeries]()
        for number, own in enumerate(section.series):
            if names.count(own.name) > 1:
                raise refused(f"series.{number}.name", own.name, "each has its own")
            try:
                series.append(section.series_of(own, path.parent))
            except InputError as error:
                raise InputError(f"series.{number}.{error}") from None
    except InputError as error:
        raise InputError(f"{path}: study.{error}") from None
    return Study(path.stem, section.title, section.description, tuple(series), section.tolerance)
