"""Which runs a sweep consists of: axes, tables and samples, all combinations of them, in a fixed order."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import short
from oblique_impact.scenario.section import Section
from oblique_impact.validation.sweeps.keys import check_key, coerce, kind

MAX_RUNS = 100_000

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
    """One direction of a sample."""

    key: str | None = None
    keys: Keys | None = None
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


@dataclass(frozen=True)
class Block:
    """Rows of values of some keys, in the order of `keys`; an axis has one dimension, a table one for each key."""

    dimensions: tuple[Dimension, ...]
    rows: tuple[tuple[Any, ...], ...]
    grid: bool  # an axis of a grid, not scattered rows

    @property
    def keys(self) -> tuple[str, ...]:
        """Keys of all dimensions."""
        return tuple(key for dimension in self.dimensions for key in dimension.keys)


@dataclass(frozen=True)
class Design:
    """All combinations of the rows of several blocks; the last block changes fastest."""

    blocks: tuple[Block, ...]

    @cached_property
    def keys(self) -> tuple[str, ...]:
        """Keys that change, in the order of the values."""
        return tuple(key for block in self.blocks for key in block.keys)

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """Directions of all blocks."""
        return tuple(dimension for block in self.blocks for dimension in block.dimensions)

    @property
    def grid(self) -> bool:
        """Whether it consists of axes alone."""
        return all(block.grid for block in self.blocks)

    @cached_property
    def size(self) -> int:
        """Number of runs."""
        return math.prod(len(block.rows) for block in self.blocks)

    def values(self, run: int) -> tuple[Any, ...]:
        """Return the values of a run (from 0), in the order of `keys`."""
        parts: list[tuple[Any, ...]] = []
        for block in reversed(self.blocks):
            run, place = divmod(run, len(block.rows))
            parts.append(block.rows[place])
        return tuple(value for part in reversed(parts) for value in part)


def axis_block(axis: AxisSection, where: str) -> Block:
    """Return the values of an axis; raises InputError that begins with `where`."""
    keys, spacing = _keys(axis, where), axis.spacing or "linear"
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
        spread = np.geomspace if spacing == "log" else np.linspace
        values = spread(*_ends(keys, axis.range, spacing, where), axis.count).tolist()
        where = f"{where}.range"
        if kind(keys[0]) is int:
            values = [_whole(value, keys[0], where) for value in values]
    rows = tuple(tuple(coerce(key, value, where) for key in keys) for value in values)
    return Block((Dimension(keys, spacing),), rows, grid=True)


def table_block(table: TableSection) -> Block:
    """Return the rows of a table; raises InputError."""
    for number, key in enumerate(table.keys):
        check_key(key, f"table.keys.{number}")
    rows = []
    for number, row in enumerate(table.rows):
        where = f"table.rows.{number}"
        if len(row) != len(table.keys):
            raise InputError(f"{where} = {short(row)}: should have one value a key, {len(table.keys)}")
        rows.append(tuple(coerce(key, value, where) for key, value in zip(table.keys, row, strict=True)))
    return Block(tuple(Dimension((key,)) for key in table.keys), tuple(rows), grid=False)


def sampled_block(cube: HypercubeSection, name: str) -> Block:
    """Return the points of a sample, "latin_hypercube" or "sobol"; raises InputError.

    Of `n` slices of equal width in each direction every one holds one point of a Latin hypercube, and one of `n` =
    2^m points of a scrambled Sobol sequence, which fills boxes evenly besides (`scipy.stats.qmc`).
    """
    from scipy.stats import qmc

    generator = np.random.default_rng(cube.seed)
    if name == "latin_hypercube":
        points = qmc.LatinHypercube(len(cube.axes), seed=generator).random(cube.samples)
    elif cube.samples & (cube.samples - 1):
        raise InputError(f"sobol.samples = {cube.samples}: should be a power of 2")
    else:
        points = qmc.Sobol(len(cube.axes), seed=generator).random(cube.samples)
    dimensions, columns = [], []
    for number, (axis, parts) in enumerate(zip(cube.axes, points.T, strict=True)):
        where = f"{name}.axes.{number}"
        keys = _keys(axis, where)
        start, stop = _ends(keys, axis.range, axis.spacing, where)
        if kind(keys[0]) is int:
            low, high = (_whole(value, keys[0], f"{where}.range") for value in sorted((start, stop)))
            values = np.minimum(low + (parts * (high - low + 1)).astype(int), high)
        elif axis.spacing == "log":
            values = start * (stop / start) ** parts
        else:
            values = start + parts * (stop - start)
        dimensions.append(Dimension(keys, axis.spacing))
        columns += [[coerce(key, value, f"{where}.range") for value in values.tolist()] for key in keys]
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


def _ends(keys: Sequence[str], given: tuple[Any, Any], spacing: str, where: str) -> tuple[float, float]:
    """Return the two ends of a range as numbers in SI units."""
    kinds = {kind(key) for key in keys}
    if not kinds <= {float, int} or len(kinds) > 1:
        words = "keys that are all floats or all integers" if len(keys) > 1 else "keys with numbers; use values"
        raise InputError(f"{where}.range = {short(list(given))}: {', '.join(keys)}: ranges are for {words}")
    start, stop = (_end(keys, end, f"{where}.range.{number}") for number, end in enumerate(given))
    if start == stop:
        raise InputError(f"{where}.range = {short([start, stop])}: the two ends should differ")
    if spacing == "log" and not (start > 0.0 and stop > 0.0):
        raise InputError(f"{where}.range = {short([start, stop])}: both should be greater than 0 for log spacing")
    return start, stop


def _end(keys: Sequence[str], given: Any, where: str) -> float:
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
