"""Which runs a sweep consists of: blocks of values, all combinations of them, in a fixed order."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np


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


def spread(start: float, stop: float, count: int, spacing: str) -> list[float]:
    """Return `count` values from `start` to `stop`, both exactly; equal steps, or equal ratios for "log"."""
    fractions = [index / (count - 1) for index in range(count)]
    return [between(start, stop, fraction, spacing) for fraction in fractions]


def between(start: float, stop: float, fraction: float, spacing: str) -> float:
    """Return the value at a fraction of the way from `start` to `stop`; both ends are exact."""
    if fraction in (0.0, 1.0):
        return stop if fraction else start
    if spacing == "log":
        return float(start * (stop / start) ** fraction)
    return float(start + fraction * (stop - start))


def latin_hypercube(samples: int, dimensions: int, seed: int) -> list[list[float]]:
    """Return points of the unit cube, shape (samples, dimensions).

    Each direction is cut into `samples` slices, and every slice of every direction holds one point:
    McKay, Beckman and Conover, Technometrics 21(2), 1979, 239-245.
    """
    generator = np.random.Generator(np.random.PCG64(seed))
    columns = [generator.permutation(samples) + generator.random(samples) for _ in range(dimensions)]
    return [[float(column[row]) / samples for column in columns] for row in range(samples)]
