"""A sweep file, read and checked: everything that can be refused is refused here, before anything runs."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Annotated, Any, Literal

import tomli_w
from pydantic import Field

from oblique_impact.errors import InputError
from oblique_impact.files import read_text
from oblique_impact.history.provenance import NUMERIC_PACKAGES, named_in, part_digests, part_keys, source_digest
from oblique_impact.scenario.messages import did_you_mean, short
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.section import Section
from oblique_impact.scenario.toml import parse_toml, with_line
from validation.refinement.quantities import Quantity, default_quantities, quantity
from validation.sweeps.design import Block, Design, Dimension, between, latin_hypercube, spread
from validation.sweeps.keys import check_key, coerce, kind

MAX_RUNS = 100_000
#: packages whose source decides about the rows of a sweep
SOURCE = (*NUMERIC_PACKAGES, "validation")

#: two numbers, or texts with a unit
Range = Annotated[tuple[Any, Any], Field(strict=False)]
Spacing = Literal["linear", "log"]
Keys = Annotated[list[str], Field(min_length=1)]
Values = Annotated[list[Any], Field(min_length=1, max_length=MAX_RUNS)]


class AxisSection(Section):
    """One axis: `key` (or `keys` that take the same value) with `values`, or with `range` and `count`."""

    key: str | None = None
    keys: Keys | None = None
    values: Values | None = None
    range: Range | None = None
    count: Annotated[int, Field(ge=2, le=MAX_RUNS)] | None = None
    spacing: Spacing | None = None


class SampledSection(Section):
    """One direction of a Latin hypercube."""

    key: str | None = None
    keys: Keys | None = None
    range: Range
    spacing: Spacing = "linear"


class HypercubeSection(Section):
    """A Latin hypercube: `samples` points, the same ones for the same `seed`."""

    samples: Annotated[int, Field(ge=1, le=MAX_RUNS)]
    seed: Annotated[int, Field(ge=0, lt=2**63)]
    axes: Annotated[list[SampledSection], Field(min_length=1)]


class TableSection(Section):
    """Rows of values for `keys`."""

    keys: Keys
    rows: Annotated[list[Annotated[list[Any], Field(min_length=1)]], Field(min_length=1, max_length=MAX_RUNS)]


class SweepFile(Section):
    """A sweep file; all blocks (axes, table, Latin hypercube) are combined with each other."""

    title: str = ""
    description: str = ""
    scenario: str = "paper"
    changes: dict[str, Any] = Field(default_factory=dict)
    quantities: Annotated[list[str], Field(min_length=1)] | None = None
    histories: bool = False
    axes: Annotated[list[AxisSection], Field(min_length=1)] | None = None
    table: TableSection | None = None
    latin_hypercube: HypercubeSection | None = None


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
    impossible: int
    fault: str

    @cached_property
    def fingerprint(self) -> str:
        """Hash of all that decides about the rows: the same for two sweeps with the same results."""
        resolved = {
            "source": source_digest(SOURCE),
            "user_defined": part_digests(self.named_parts()),
            "scenario": self.base.model_dump(mode="json"),
            "changes": self.changes,
            "blocks": [[block.keys, block.rows] for block in self.design.blocks],
            "quantities": [q.name for q in self.quantities],
            "histories": self.file.histories,
        }
        return hashlib.sha256(json.dumps(resolved, sort_keys=True).encode()).hexdigest()[:16]

    def named_parts(self) -> list[tuple[str, str]]:
        """Return the keys that may name a user-defined part, with all names that any of the runs gives them."""
        columns = {key: [value] for key, value in self.changes.items()}
        for block in self.design.blocks:
            columns |= dict(zip(block.keys, map(list, zip(*block.rows, strict=True)), strict=True))
        named = [(key, name) for key in part_keys() for name in columns.get(key, ())]
        return [*named_in(self.base), *named]

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
        raise with_line(error, text, name) from None


def plan_of(file: SweepFile, folder: Path = Path(), base: Scenario | None = None) -> Plan:
    """Check a sweep; `base` takes the place of the scenario that it names.

    Raises InputError.
    """
    if not (file.axes or file.table or file.latin_hypercube):
        raise InputError("sweep file: nothing to sweep over; give [[axes]], [table] or [latin_hypercube]")
    base = base or _base(file.scenario, folder)
    changes = _flat(file.changes)
    for key, value in changes.items():
        check_key(key, "changes")
        changes[key] = coerce(key, value, "changes")
    _count(file)
    design = Design(tuple(_blocks(file)))
    _check_distinct([*changes, *design.keys])
    first, impossible, fault = _check_runs(base, changes, design)
    return Plan(file, base, changes, design, _quantities(file, first, design, changes), impossible, fault)


def changed(base: Scenario, changes: dict[str, Any], keys: Iterable[str], values: Iterable[Any]) -> Scenario:
    """Return the scenario of a run; raises InputError if its values do not fit together."""
    every = {**changes, **dict(zip(keys, values, strict=True))}
    return base.replace(**{key.replace(".", "__"): value for key, value in every.items()})


def _studies() -> Any:
    return resources.files("validation.sweeps") / "studies"


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
    """Refuse too many runs before they are made."""
    sizes = [axis.count or len(axis.values or ()) for axis in file.axes or ()]
    sizes += [len(file.table.rows)] if file.table else []
    sizes += [file.latin_hypercube.samples] if file.latin_hypercube else []
    total = math.prod(sizes)
    if total > MAX_RUNS:
        product = " x ".join(str(size) for size in sizes)
        raise InputError(f"sweep file: {product} = {short(total)} runs; at most {MAX_RUNS} are allowed")


def _blocks(file: SweepFile) -> Iterable[Block]:
    for number, axis in enumerate(file.axes or ()):
        yield _axis_block(axis, f"axes.{number}")
    if file.table:
        yield _table_block(file.table)
    if file.latin_hypercube:
        yield _hypercube_block(file.latin_hypercube)


def _axis_block(axis: AxisSection, where: str) -> Block:
    keys = _keys(axis, where)
    if (axis.values is None) == (axis.range is None):
        both = "not both" if axis.values is not None else "one of them is needed"
        raise InputError(f"{where}: takes values, or range with count; {both}")
    if axis.values is not None:
        for name in ("count", "spacing"):
            given = getattr(axis, name)
            if given is not None:
                raise InputError(f"{where}.{name} = {short(given)}: only with range, not with values")
        values, where = list(axis.values), f"{where}.values"
    else:
        assert axis.range is not None
        if axis.count is None:
            raise InputError(f"{where}.count: missing; how many values from {axis.range[0]} to {axis.range[1]}?")
        ends = _check_range(keys, axis.range, axis.spacing or "linear", where)
        values, where = spread(*ends, axis.count, axis.spacing or "linear"), f"{where}.range"
        if kind(keys[0]) is int:
            values = [_whole(value, keys[0], where) for value in values]
    rows = tuple(tuple(coerce(key, value, where) for key in keys) for value in values)
    return Block((Dimension(keys, axis.spacing or "linear"),), rows, grid=True)


def _table_block(table: TableSection) -> Block:
    for number, key in enumerate(table.keys):
        check_key(key, f"table.keys.{number}")
    for number, row in enumerate(table.rows):
        if len(row) != len(table.keys):
            raise InputError(f"table.rows.{number} = {short(row)}: should have one value a key, {len(table.keys)}")
    rows = tuple(
        tuple(coerce(key, value, f"table.rows.{number}") for key, value in zip(table.keys, row, strict=True))
        for number, row in enumerate(table.rows)
    )
    return Block(tuple(Dimension((key,)) for key in table.keys), rows, grid=False)


def _hypercube_block(cube: HypercubeSection) -> Block:
    dimensions, columns = [], []
    points = latin_hypercube(cube.samples, len(cube.axes), cube.seed)
    for number, axis in enumerate(cube.axes):
        where = f"latin_hypercube.axes.{number}"
        keys = _keys(axis, where)
        start, stop = _check_range(keys, axis.range, axis.spacing, where)
        if kind(keys[0]) is int:
            low, high = (_whole(value, keys[0], f"{where}.range") for value in sorted((start, stop)))
            values: list[Any] = [min(low + int(p[number] * (high - low + 1)), high) for p in points]
        else:
            values = [between(start, stop, p[number], axis.spacing) for p in points]
        dimensions.append(Dimension(keys, axis.spacing))
        columns += [[coerce(key, value, f"{where}.range") for value in values] for key in keys]
    return Block(tuple(dimensions), tuple(zip(*columns, strict=True)), grid=False)


def _keys(axis: AxisSection | SampledSection, where: str) -> tuple[str, ...]:
    if (axis.key is None) == (axis.keys is None):
        raise InputError(f"{where}: takes key, or keys that have the same value; exactly one of them")
    if axis.key is not None:
        check_key(axis.key, f"{where}.key")
        return (axis.key,)
    for number, key in enumerate(axis.keys or ()):
        check_key(key, f"{where}.keys.{number}")
    return tuple(axis.keys or ())


def _check_range(keys: tuple[str, ...], given: tuple[Any, Any], spacing: str, where: str) -> tuple[float, float]:
    """Return the two ends of a range as numbers in SI units."""
    kinds = {kind(key) for key in keys}
    if not kinds <= {float, int} or len(kinds) > 1:
        words = "keys that are all floats or all integers" if len(keys) > 1 else "keys with numbers; use values"
        raise InputError(f"{where}.range = {short(list(given))}: {', '.join(keys)}: ranges are for {words}")
    ends = _end(keys, given[0], f"{where}.range.0"), _end(keys, given[1], f"{where}.range.1")
    if ends[0] == ends[1]:
        raise InputError(f"{where}.range = {short(list(ends))}: the two ends should differ")
    if spacing == "log" and not (ends[0] > 0.0 and ends[1] > 0.0):
        raise InputError(f"{where}.range = {short(list(ends))}: both should be greater than 0 for log spacing")
    return ends


def _end(keys: tuple[str, ...], given: Any, where: str) -> float:
    """Return an end of a range, a number or a text with a unit that all keys take."""
    if isinstance(given, str):
        first, *_ = [float(coerce(key, given, where)) for key in keys]
        return first
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not abs(given) <= 1e30:
        raise InputError(f"{where} = {short(given)}: should be a finite number, or a text with a unit")
    return float(given)


def _whole(value: float, key: str, where: str) -> int:
    nearest = round(value)
    if abs(value - nearest) > 1e-9 * max(1.0, abs(value)):
        raise InputError(f"{where}: {key} = {value:.6g}: should be a whole number; change count, or use values")
    return nearest


def _check_distinct(keys: list[str]) -> None:
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"sweep file: {key} is set twice; once in changes, axes, table or latin_hypercube")


def _check_runs(base: Scenario, changes: dict[str, Any], design: Design) -> tuple[Scenario, int, str]:
    """Make every scenario once; returns the first possible one, the number of impossible ones and why."""
    first, impossible, fault = None, 0, ""
    for run in range(design.size):
        try:
            scenario = changed(base, changes, design.keys, design.values(run))
            first = first or scenario
        except InputError as error:
            impossible, fault = impossible + 1, fault or f"run {run}: {error}"
    if first is None:
        raise InputError(fault if design.size == 1 else f"{fault} (and no other run is possible)")
    return first, impossible, fault


def _quantities(
    file: SweepFile, scenario: Scenario, design: Design, changes: dict[str, Any]
) -> tuple[Quantity, ...]:
    """Look up the quantities by name; times are bounded by the longest run."""
    ends = [scenario.end_time]
    for block in design.blocks:
        if "end_time" in block.keys:
            place = block.keys.index("end_time")
            ends += [row[place] for row in block.rows]
    names = dict.fromkeys(file.quantities or default_quantities(scenario))
    try:
        return tuple(quantity(name, max(ends)) for name in names)
    except InputError as error:
        raise InputError(f"quantities: {str(error).removeprefix('--quantity ')}") from None
