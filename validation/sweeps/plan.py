"""A sweep file, read and checked: everything that can be refused is refused here, before anything runs."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Annotated, Any

import tomli_w
from pydantic import Field

from oblique_impact.errors import InputError
from oblique_impact.files import read_text
from oblique_impact.scenario.messages import did_you_mean, short
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.section import Section
from oblique_impact.scenario.toml import parse_toml
from oblique_impact.validation.journal import fingerprint_of
from oblique_impact.validation.measuring import Task
from oblique_impact.validation.quantities import Quantity, default_quantities, quantity
from oblique_impact.validation.sweeps.design import (
    MAX_RUNS,
    AxisSection,
    Block,
    Design,
    HypercubeSection,
    TableSection,
    axis_block,
    sampled_block,
    table_block,
)
from oblique_impact.validation.sweeps.keys import check_key, coerce


class SweepFile(Section):
    """A sweep file; all blocks (axes, table, Latin hypercube, Sobol sequence) are combined with each other."""

    title: str = ""
    description: str = ""
    scenario: str = "paper"
    changes: dict[str, Any] = Field(default_factory=dict)
    quantities: Annotated[list[str], Field(min_length=1)] | None = None
    histories: bool = False
    axes: Annotated[list[AxisSection], Field(min_length=1)] | None = None
    table: TableSection | None = None
    latin_hypercube: HypercubeSection | None = None
    sobol: HypercubeSection | None = None


@dataclass(frozen=True)
class Plan:
    """A sweep that can run.

    Attributes
    ----------
    file : SweepFile
        As it was written.
    base : Scenario
        The scenario that is changed.
    changes : dict
        Values of keys that hold for all runs.
    design : Design
        What changes from run to run.
    quantities : tuple of Quantity
        What each run is asked for.
    impossible : int
        Number of runs whose values do not fit together; they become rows that say why.
    fault : str
        Why the first of them is not possible.
    """

    file: SweepFile
    base: Scenario
    changes: dict[str, Any]
    design: Design
    quantities: tuple[Quantity, ...]
    impossible: int = 0
    fault: str = ""

    def task(self, run: int, timeout: float | None = None, scratch: str | None = None) -> Task:
        """Return the run of a number, from 0."""
        values = dict(zip(self.design.keys, self.design.values(run), strict=True))
        names = tuple(q.name for q in self.quantities)
        return Task(run, self.base, names, {**self.changes, **values}, self.file.histories, timeout, scratch)

    @cached_property
    def fingerprint(self) -> str:
        """Hash of all that decides about the rows: the same for two sweeps with the same results."""
        decisive = {
            "scenario": self.base.model_dump(mode="json"),
            "changes": self.changes,
            "blocks": [[block.keys, block.rows] for block in self.design.blocks],
            "quantities": [q.name for q in self.quantities],
            "histories": self.file.histories,
        }
        return fingerprint_of(decisive)

    def to_toml(self) -> str:
        """Return the sweep file of this plan; its scenario lies beside it as scenario.toml."""
        data = self.file.model_dump(mode="json", exclude_none=True) | {"scenario": "scenario.toml"}
        return tomli_w.dumps({**data, "quantities": [q.name for q in self.quantities]})


def shipped_names() -> list[str]:
    """Return the names of the shipped studies."""
    return sorted(p.name[:-5] for p in _studies().iterdir() if p.name.endswith(".toml"))


def load_plan(source: str | os.PathLike[str], base: Scenario | None = None) -> Plan:
    """Read a shipped study by name, or a sweep file by path; `base` takes the place of its scenario.

    Raises
    ------
    InputError
        In one line that names the key, its value and what is allowed.
    """
    source = os.fspath(source)
    if source in shipped_names():
        return make_plan((_studies() / f"{source}.toml").read_text(encoding="utf-8"), base=base)
    path = Path(source)
    if not _is_file(path):
        known = shipped_names()
        words = f"neither a file nor a shipped study ({', '.join(known)}){did_you_mean(source, known)}"
        raise InputError(f"sweep = {short(source)}: {words}")
    try:
        text = read_text(path)
    except (OSError, ValueError) as error:
        raise InputError(f"sweep = {short(source)}: cannot be read: {short(str(error))}") from None
    return make_plan(text, path.parent, base, source)


def make_plan(text: str, folder: Path = Path(), base: Scenario | None = None, name: str = "sweep file") -> Plan:
    """Check a sweep file's text; a scenario that is a file is looked for beside it, in `folder`.

    Raises InputError with the `name` of the file and the line.
    """
    data = parse_toml(text, name)
    try:
        return plan_of(SweepFile.from_dict(data), folder, base)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def plan_of(file: SweepFile, folder: Path = Path(), base: Scenario | None = None) -> Plan:
    """Check a sweep; `base` takes the place of the scenario that it names.

    Raises InputError.
    """
    base = base or _base(file.scenario, folder)
    changes = _flat(file.changes)
    for key, value in changes.items():
        check_key(key, "changes")
        changes[key] = coerce(key, value, "changes")
    _count(file)
    design = Design(tuple(_blocks(file)))
    keys = [*changes, *design.keys]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"sweep file: {key} is set twice; once in changes, or in one of the blocks")
    plan = Plan(file, base, changes, design, ())
    first, impossible, fault = _check_runs(plan)
    return Plan(file, base, changes, design, _quantities(plan, first), impossible, fault)


def _studies() -> Any:
    return resources.files("oblique_impact.validation.sweeps") / "studies"


def _base(source: str, folder: Path) -> Scenario:
    """Load a built-in scenario, or a file beside the sweep file."""
    beside = folder / source
    return Scenario.load(str(beside) if source.endswith(".toml") and _is_file(beside) else source)


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name too long, or one with a null character
        return False


def _flat(changes: dict[str, Any]) -> dict[str, Any]:
    """Return {"section.key": value} for nested sections; a quoted "section.key" is taken as well."""
    flat: dict[str, Any] = {}
    for name, value in changes.items():
        inner = {f"{name}.{key}": v for key, v in value.items()} if isinstance(value, dict) else {name: value}
        for key in inner:
            if key in flat:
                raise InputError(f"changes = {short(key)}: given twice")
        flat.update(inner)
    return flat


def _count(file: SweepFile) -> None:
    """Refuse too many runs, or none, before they are made."""
    sizes = [axis.count or len(axis.values or ()) for axis in file.axes or ()]
    sizes += [len(file.table.rows)] if file.table else []
    sizes += [cube.samples for cube in (file.latin_hypercube, file.sobol) if cube]
    if not sizes:
        raise InputError("sweep file: nothing to sweep over; give [[axes]], [table], [latin_hypercube] or [sobol]")
    if math.prod(sizes) > MAX_RUNS:
        product = " x ".join(str(size) for size in sizes)
        raise InputError(f"sweep file: {product} = {short(math.prod(sizes))} runs; at most {MAX_RUNS} are allowed")


def _blocks(file: SweepFile) -> list[Block]:
    blocks = [axis_block(axis, f"axes.{number}") for number, axis in enumerate(file.axes or ())]
    blocks += [table_block(file.table)] if file.table else []
    cubes = {"latin_hypercube": file.latin_hypercube, "sobol": file.sobol}
    return [*blocks, *(sampled_block(cube, name) for name, cube in cubes.items() if cube)]


def _check_runs(plan: Plan) -> tuple[Scenario, int, str]:
    """Make every scenario once; returns the first possible one, the number of impossible ones and why."""
    first, impossible, fault = None, 0, ""
    for run in range(plan.design.size):
        try:
            scenario = plan.task(run).scenario()
            first = first or scenario
        except InputError as error:
            impossible, fault = impossible + 1, fault or f"run {run + 1}: {error}"
    if first is None:
        raise InputError(fault if plan.design.size == 1 else f"{fault} (and no other run is possible)")
    return first, impossible, fault


def _quantities(plan: Plan, scenario: Scenario) -> tuple[Quantity, ...]:
    """Look up the quantities by name; times are bounded by the longest run."""
    ends = [scenario.end_time]
    for block in plan.design.blocks:
        if "end_time" in block.keys:
            place = block.keys.index("end_time")
            ends += [row[place] for row in block.rows]
    names = dict.fromkeys(plan.file.quantities or default_quantities(scenario))
    try:
        return tuple(quantity(name, max(ends)) for name in names)
    except InputError as error:
        raise InputError(f"quantities: {str(error).removeprefix('--quantity ')}") from None
