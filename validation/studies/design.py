"""Sweep files: a scenario over axes, tables and samples of its keys; all combinations, in a fixed order."""

from __future__ import annotations

import itertools
import json
import math
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import resources
from operator import attrgetter
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
import tomli_w
from pydantic import Field, model_validator
from scipy.stats import qmc

from oblique_impact.errors import InputError
from oblique_impact.files import read_text
from oblique_impact.scenario.messages import did_you_mean, short
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.schema import key_schemas
from oblique_impact.scenario.section import Section
from oblique_impact.scenario.toml import flat_keys, parse_toml
from oblique_impact.scenario.units import Unit
from oblique_impact.validation.studies.quantities import Quantity, default_quantities, quantity
from oblique_impact.validation.studies.study import Run

MAX_RUNS = 100_000

#: two numbers, or texts with a unit
Range = Annotated[tuple[Any, Any], Field(strict=False)]
Spacing = Literal["linear", "log"]
Keys = Annotated[list[str], Field(min_length=1)]
Values = Annotated[list[Any], Field(min_length=1, max_length=MAX_RUNS)]


class KeysSection(Section):
    """What one direction of a sweep changes: `key`, or `keys` that take the same value."""

    key: str | None = None
    keys: Keys | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """The keys."""
        return tuple(self.keys or ()) if self.key is None else (self.key,)

    @model_validator(mode="after")
    def _check_keys(self) -> Self:
        if (self.key is None) == (self.keys is None):
            raise InputError("key: takes key, or keys that have the same value; exactly one of them")
        _check_keys(self.names, "key" if self.keys is None else "keys")
        return self


class AxisSection(KeysSection):
    """One axis: `key` or `keys` with `values`, or with `range` and `count`."""

    values: Values | None = None
    range: Range | None = None
    count: Annotated[int, Field(ge=2, le=MAX_RUNS)] | None = None
    spacing: Spacing | None = None

    @model_validator(mode="after")
    def _check_values(self) -> Self:
        if (self.values is None) == (self.range is None):
            both = "not both" if self.range is not None else "one of them is needed"
            raise InputError(f"values: takes values, or range with count; {both}")
        if self.range is None:
            for name in ("count", "spacing"):
                if getattr(self, name) is not None:
                    raise InputError(f"{name} = {short(getattr(self, name))}: only with range, not with values")
        elif self.count is None:
            raise InputError(f"count: missing; how many values from {self.range[0]} to {self.range[1]}?")
        return self


class SampledSection(KeysSection):
    """One direction of a sample."""

    range: Range
    spacing: Spacing = "linear"


class HypercubeSection(Section):
    """A sample of `samples` points of a hypercube, the same ones for the same `seed`."""

    samples: Annotated[int, Field(ge=1, le=MAX_RUNS)]
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    axes: Annotated[list[SampledSection], Field(min_length=1)]


class TableSection(Section):
    """Rows of values for `keys`."""

    keys: Keys
    rows: Annotated[list[Annotated[list[Any], Field(min_length=1)]], Field(min_length=1, max_length=MAX_RUNS)]

    @model_validator(mode="after")
    def _check(self) -> Self:
        _check_keys(self.keys, "keys")
        for number, row in enumerate(self.rows):
            if len(row) != len(self.keys):
                raise InputError(f"rows.{number} = {short(row)}: should have one value a key, {len(self.keys)}")
        return self


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
class Dimension:
    """One direction of a sweep.

    Attributes
    ----------
    keys : tuple of str
        Keys of the scenario that change together and take the same value.
    spacing : str
        "linear" or "log": how its values are spread, and its axis drawn.
    """

    keys: tuple[str, ...]
    spacing: str = "linear"

    @property
    def label(self) -> str:
        """Keys as one name."""
        return " = ".join(self.keys)

    @property
    def unit(self) -> str:
        """SI unit, "1" for numbers without one, "" for words and switches."""
        return Unit(key_schemas()[self.keys[0]].get("unit", "")).shown


@dataclass(frozen=True)
class _Block:
    """Rows of values of the keys of some dimensions; an axis of a grid, or scattered."""

    dimensions: tuple[Dimension, ...]
    rows: Sequence[Sequence[Any]]
    grid: bool

    @property
    def keys(self) -> tuple[str, ...]:
        return tuple(key for dimension in self.dimensions for key in dimension.keys)


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
    dimensions : tuple of Dimension
        What changes from run to run.
    grid : bool
        Whether it consists of axes alone.
    runs : tuple of Run
        All combinations, the last block changing fastest; "run" counts them from 1.
    """

    file: SweepFile
    base: Scenario
    changes: dict[str, Any]
    dimensions: tuple[Dimension, ...]
    grid: bool
    runs: tuple[Run, ...]

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Quantities that are measured in each run."""
        return tuple(quantity(name) for name in self.runs[0].quantities)

    @cached_property
    def impossible(self) -> list[Run]:
        """Runs whose values do not fit together; they become rows that say why."""
        return [run for run in self.runs if run.scenario is None]

    def to_toml(self) -> str:
        """Return the sweep file of this plan; its scenario lies beside it as scenario.toml."""
        data = self.file.model_dump(mode="json", exclude_none=True) | {"scenario": "scenario.toml"}
        return tomli_w.dumps({**data, "quantities": list(self.runs[0].quantities)})


@cache
def defaults() -> dict[str, Any]:
    """Return the default values of all keys of a scenario, "section.key" or "key"."""
    return flat_keys(Scenario().model_dump())


def shipped_names() -> list[str]:
    """Return the names of the shipped sweeps."""
    return sorted(p.name[:-5] for p in _shipped().iterdir() if p.name.endswith(".toml"))


def load_plan(source: str | os.PathLike[str], base: Scenario | None = None) -> Plan:
    """Read a shipped sweep by name, or a sweep file by path; `base` takes the place of its scenario.

    Raises InputError, in one line that names the key, its value and what is allowed.
    """
    source = os.fspath(source)
    if source in shipped_names():
        return make_plan((_shipped() / f"{source}.toml").read_text(encoding="utf-8"), base=base)
    path = Path(source)
    if not os.path.isfile(path):
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

    Raises InputError that begins with the `name` of the file.
    """
    data = parse_toml(text, name)
    try:
        return plan_of(SweepFile.from_dict(data), folder, base)
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def plan_of(file: SweepFile, folder: Path = Path(), base: Scenario | None = None) -> Plan:
    """Check a sweep, and make its runs; `base` takes the place of the scenario that it names.

    Raises InputError for what cannot be, or if no run is possible.
    """
    if base is None:
        beside = folder / file.scenario
        is_file = file.scenario.endswith(".toml") and os.path.isfile(beside)
        base = Scenario.load(str(beside) if is_file else file.scenario)
    changes = flat_keys(file.changes)
    _check_keys(changes, "changes")
    _check_size(file)
    blocks = [_axis(axis, f"axes.{n}", base) for n, axis in enumerate(file.axes or ())]
    if file.table:
        columns = tuple(Dimension((key,)) for key in file.table.keys)
        blocks.append(_Block(columns, file.table.rows, grid=False))
    cubes = {"latin_hypercube": file.latin_hypercube, "sobol": file.sobol}
    blocks += [_sample(cube, name, base) for name, cube in cubes.items() if cube]
    keys = [key for block in blocks for key in block.keys]
    for key in [*changes, *keys]:
        if [*changes, *keys].count(key) > 1:
            raise InputError(f"sweep file: {key} is set twice; once in changes, or in one of the blocks")
    values = [tuple(itertools.chain(*rows)) for rows in itertools.product(*(block.rows for block in blocks))]
    dimensions = tuple(dimension for block in blocks for dimension in block.dimensions)
    runs = _runs(base, changes, keys, values, file.quantities)
    return Plan(file, base, changes, dimensions, all(block.grid for block in blocks), runs)


def _runs(
    base: Scenario,
    changes: dict[str, Any],
    keys: list[str],
    values: list[tuple[Any, ...]],
    names: list[str] | None,
) -> tuple[Run, ...]:
    """Make every scenario; labels are values in SI units as the scenario holds them."""
    found: list[tuple[Scenario | None, str]] = []
    for row in values:
        changed = {**changes, **dict(zip(keys, row, strict=True))}
        try:
            found.append((base.replace(**{key.replace(".", "__"): value for key, value in changed.items()}), ""))
        except InputError as error:
            found.append((None, str(error)))
    possible = [scenario for scenario, _ in found if scenario]
    if not possible:
        raise InputError(found[0][1] + (" (and no other run is possible)" if len(found) > 1 else ""))
    longest = max(scenario.end_time for scenario in possible)
    wanted = tuple(dict.fromkeys(names or default_quantities(possible[0])))
    try:
        for name in wanted:
            quantity(name, longest)
    except InputError as error:
        raise InputError(f"quantities: {str(error).removeprefix('--quantity ')}") from None
    columns = {
        key: _column(key, [attrgetter(key)(s) if s else row[n] for (s, _), row in zip(found, values, strict=True)])
        for n, key in enumerate(keys)
    }
    return tuple(
        Run({"run": n + 1, **{key: column[n] for key, column in columns.items()}}, scenario, wanted, fault)
        for n, (scenario, fault) in enumerate(found)
    )


def _column(key: str, values: list[Any]) -> list[Any]:
    """Return the values of a key as one type: numbers, words, switches, or JSON where some are lists."""
    if any(isinstance(value, list | tuple) for value in values):
        return [json.dumps(value) for value in values]
    if isinstance(defaults()[key], str):
        return [str(value) for value in values]
    # what no scenario takes is no number
    return [math.nan if isinstance(value, str) else value for value in values]


def _check_keys(keys: Iterable[str], where: str) -> None:
    """Raise InputError for the first that is no key of a scenario."""
    known = list(defaults())
    for key in keys:
        if key not in known:
            section, dot, _ = key.rpartition(".")
            inside = [k for k in known if dot and k.startswith(f"{section}.")]
            sections = ", ".join(dict.fromkeys(k.partition(".")[0] for k in known if "." in k))
            words = (
                ", ".join(inside) or f"{', '.join(k for k in known if '.' not in k)}, SECTION.KEY of {sections}"
            )
            line = f"not a key of a scenario; known here: {words}{did_you_mean(key, known)}"
            raise InputError(f"{where} = {short(key)}: {line}")


def _check_size(file: SweepFile) -> None:
    """Refuse too many runs, or none, before they are made."""
    sizes = [axis.count or len(axis.values or ()) for axis in file.axes or ()]
    sizes += [len(file.table.rows)] if file.table else []
    sizes += [cube.samples for cube in (file.latin_hypercube, file.sobol) if cube]
    if not sizes:
        raise InputError("sweep file: nothing to sweep over; give [[axes]], [table], [latin_hypercube] or [sobol]")
    if math.prod(sizes) > MAX_RUNS:
        product = " x ".join(str(size) for size in sizes)
        raise InputError(f"sweep file: {product} = {short(math.prod(sizes))} runs; at most {MAX_RUNS} are allowed")


def _axis(axis: AxisSection, where: str, base: Scenario) -> _Block:
    keys, spacing = axis.names, axis.spacing or "linear"
    values = list(axis.values or ())
    if axis.range is not None:
        assert axis.count is not None
        spread = np.geomspace if spacing == "log" else np.linspace
        values = spread(*_ends(keys, axis.range, spacing, f"{where}.range", base), axis.count).tolist()
        if _whole(keys[0]):
            values = [_rounded(value, keys[0], f"{where}.range") for value in values]
    return _Block((Dimension(keys, spacing),), [[value] * len(keys) for value in values], grid=True)


def _sample(cube: HypercubeSection, name: str, base: Scenario) -> _Block:
    """Return the points of a Latin hypercube, or of a scrambled Sobol sequence."""
    generator = np.random.default_rng(cube.seed)
    if name == "sobol" and cube.samples & (cube.samples - 1):
        raise InputError(f"sobol.samples = {cube.samples}: should be a power of 2")
    sampler = qmc.Sobol if name == "sobol" else qmc.LatinHypercube
    points = sampler(len(cube.axes), seed=generator).random(cube.samples)
    dimensions, columns = [], []
    for number, (axis, parts) in enumerate(zip(cube.axes, points.T, strict=True)):
        where = f"{name}.axes.{number}"
        keys = axis.names
        start, stop = _ends(keys, axis.range, axis.spacing, f"{where}.range", base)
        if _whole(keys[0]):
            low, high = (_rounded(value, keys[0], f"{where}.range") for value in sorted((start, stop)))
            values = np.minimum(low + (parts * (high - low + 1)).astype(int), high)
        elif axis.spacing == "log":
            values = start * (stop / start) ** parts
        else:
            values = start + parts * (stop - start)
        dimensions.append(Dimension(keys, axis.spacing))
        columns += [values.tolist()] * len(keys)
    return _Block(tuple(dimensions), list(zip(*columns, strict=True)), grid=False)


def _ends(
    keys: Sequence[str], given: tuple[Any, Any], spacing: str, where: str, base: Scenario
) -> tuple[float, float]:
    """Return the two ends of a range as numbers in SI units."""
    kinds = {type(defaults()[key]) for key in keys}
    if kinds not in ({float}, {int}):
        words = "keys that are all floats or all integers" if len(keys) > 1 else "keys with numbers; use values"
        raise InputError(f"{where} = {short(list(given))}: {', '.join(keys)}: ranges are for {words}")
    ends = []
    for number, end in enumerate(given):
        if isinstance(end, str):  # with a unit
            end = attrgetter(keys[0])(base.replace(**{key.replace(".", "__"): end for key in keys}))
        if isinstance(end, bool) or not isinstance(end, int | float) or not abs(end) <= 1e30:
            words = "should be a finite number, or a text with a unit"
            raise InputError(f"{where}.{number} = {short(end)}: {words}")
        ends.append(float(end))
    start, stop = ends
    if start == stop:
        raise InputError(f"{where} = {short([start, stop])}: the two ends should differ")
    if spacing == "log" and not (start > 0.0 and stop > 0.0):
        raise InputError(f"{where} = {short([start, stop])}: both should be greater than 0 for log spacing")
    return start, stop


def _whole(key: str) -> bool:
    return type(defaults()[key]) is int


def _rounded(value: float, key: str, where: str) -> int:
    nearest = round(value)
    if abs(value - nearest) > 1e-9 * max(1.0, abs(value)):
        raise InputError(f"{where}: {key} = {value:.6g}: should be a whole number; change count, or use values")
    return nearest


def _shipped() -> Any:
    return resources.files("oblique_impact.validation.studies") / "sweeps"
