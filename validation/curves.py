"""How far two curves are apart: at equal times, and as sets of points."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.history.sample_times import jumps

Array = NDArray[np.float64]

#: digits of the distance of two graphs
GRAPH_DIGITS = 1e-4
#: a jump is a change by more than this part of the scale between two samples next to each other
JUMP = 1e-6


class Deviation(NamedTuple):
    """How far two courses are apart, right minus left, in the unit of the variable.

    `rms` is the root of the mean square over time (and along the beam); `largest` the difference of largest
    magnitude, with its sign; `at` the time (s) of that.
    """

    rms: float
    largest: float
    at: float


class Courses:
    """Two courses of time, linear between their samples, on the union of their instants.

    Parameters
    ----------
    times : tuple of ndarray, shape (samples,)
        Instants (s) of either, strictly ascending; the sides of a jump are next to each other.  What both cover is
        compared.

    Attributes
    ----------
    grid : ndarray, shape (instants,)
        The union (s).
    """

    def __init__(self, times: tuple[Array, Array]) -> None:
        self.times = times
        start, end = max(t[0] for t in times), min(t[-1] for t in times)
        union = np.union1d(*times)
        self.grid = np.unique(np.concatenate([[start], union[(union > start) & (union < end)], [end]]))

    def deviation(self, values: Sequence[Array], weights: Array | None) -> Deviation:
        """Measure the difference of values (samples,) or (samples, points); integrals are exact.

        The mean along the beam has `weights` (points,) of sum 1.
        """
        apart = _apart(*(interpolated(t, v, self.grid) for t, v in zip(self.times, values, strict=True)))
        if self.grid.size < 2:
            return Deviation(0.0, 0.0, float(self.grid[0]))
        apart = apart.reshape(self.grid.size, -1)
        share = np.full(apart.shape[1], 1.0 / apart.shape[1]) if weights is None else weights
        with np.errstate(invalid="ignore"):
            inside = apart[:-1] ** 2 + apart[:-1] * apart[1:] + apart[1:] ** 2
        squares = np.where(np.isnan(inside), np.inf, inside) @ share / 3.0
        rms = float(np.sqrt(np.diff(self.grid) @ squares / (self.grid[-1] - self.grid[0])))
        row, column = np.unravel_index(int(np.argmax(np.abs(apart))), apart.shape)
        return Deviation(rms, float(apart[row, column]), float(self.grid[row]))

    def disagreement(self, values: Sequence[NDArray[Any]]) -> float:
        """Part of the time in which values differ that hold from their sample on to the next."""
        if self.grid.size < 2:
            return 0.0
        places = [np.searchsorted(t, self.grid[:-1], side="right") - 1 for t in self.times]
        left, right = (v[k] for v, k in zip(values, places, strict=True))
        return float(np.diff(self.grid) @ (left != right) / (self.grid[-1] - self.grid[0]))

    def hausdorff(self, values: Sequence[Array], scale: float) -> float | None:
        """Distance of the graphs of values that jump, relative to span and `scale`; None of those that do not."""
        if values[0].ndim > 1 or scale == 0.0 or not all(np.isfinite(v).all() for v in values):
            return None
        courses = list(zip(self.times, values, strict=True))
        if not any(np.any(jumps(t) & (np.abs(np.diff(v)) > JUMP * scale)) for t, v in courses):
            return None
        x = (self.grid - self.grid[0]) / (self.grid[-1] - self.grid[0])
        return graph_distance(*(np.stack([x, interpolated(t, v, self.grid) / scale], axis=1) for t, v in courses))


def interpolated(x: Array, values: Array, at: Array) -> Array:
    """Values (points, ...) at other points, linear in between; a sample that is hit is taken as it is."""
    k = np.clip(np.searchsorted(x, at, side="right") - 1, 0, x.size - 2)
    part = np.clip((at - x[k]) / (x[k + 1] - x[k]), 0.0, 1.0).reshape(-1, *(1,) * (values.ndim - 1))
    with np.errstate(invalid="ignore"):
        between = values[k] + part * (values[k + 1] - values[k])
    return np.asarray(np.where(part == 0.0, values[k], np.where(part == 1.0, values[k + 1], between)))


def _apart(left: Array, right: Array) -> Array:
    """Right minus left; 0 where neither is finite, infinite where one of them is not."""
    wild = ~np.isfinite(left), ~np.isfinite(right)
    with np.errstate(invalid="ignore"):
        apart = np.where(wild[0] & wild[1], 0.0, right - left)
    return np.asarray(np.where(wild[0] ^ wild[1], np.inf, apart))


def hausdorff_distance(a: Array, b: Array) -> float:
    """Hausdorff distance of two polylines, (points, 2) each: the right distance for curves with jumps.

    Two curves that jump at slightly different times are close as sets though not at any one time.  Distances
    are taken from the vertices of each to the segments of the other.
    """
    return max(_directed(a, b), _directed(b, a))


def _directed(points: Array, line: Array, block: int = 256) -> float:
    """Largest distance of `points` from the segments of `line`."""
    start, along = line[:-1], np.diff(line, axis=0)
    square = np.maximum(np.einsum("ij,ij->i", along, along), np.finfo(float).tiny)
    largest = 0.0
    for k in range(0, len(points), block):
        offset = points[k : k + block, None] - start[None]
        part = np.clip(np.einsum("pij,ij->pi", offset, along) / square, 0.0, 1.0)
        gap = offset - part[..., None] * along
        largest = max(largest, float(np.sqrt(np.einsum("pij,pij->pi", gap, gap).min(axis=1).max())))
    return largest


def graph_distance(a: Array, b: Array) -> float:
    """Hausdorff distance of two graphs, (points, 2) each with abscissas that do not descend.

    The same as `hausdorff_distance` but for `GRAPH_DIGITS` of itself, and much sooner: the distance along the
    ordinate, and those of other points, bound how far a point can be, so that few are searched, each near to it.
    """
    return max(_directed_graph(a, b), _directed_graph(b, a))


def _directed_graph(points: Array, line: Array) -> float:
    x, own = line[:, 0], points[:, 0]
    bound = _distance_at(points, line)
    largest = 0.0
    while True:
        k = int(np.argmax(bound))
        if bound[k] <= largest * (1.0 + GRAPH_DIGITS):
            return largest
        start = max(int(np.searchsorted(x, points[k, 0] - bound[k], side="left")) - 1, 0)
        stop = int(np.searchsorted(x, points[k, 0] + bound[k], side="right")) + 1
        start = min(start, len(line) - 2)
        found = min(float(bound[k]), _directed(points[k : k + 1], line[start : max(stop, start + 2)]))
        largest = max(largest, found)
        # no point is further from the line than this one and the way to it together; that says nothing of points
        # further away along the abscissa than the largest bound is above what was found
        way = 1.000001 * (bound[k] - found)
        near = slice(np.searchsorted(own, own[k] - way), np.searchsorted(own, own[k] + way, side="right"))
        bound[near] = np.minimum(bound[near], found + np.hypot(*(points[near] - points[k]).T))


def _distance_at(points: Array, line: Array) -> Array:
    """Distance of each point from the line at its own abscissa, or from the end of the line next to it."""
    x, y = line[:, 0], line[:, 1]
    at = np.clip(points[:, 0], x[0], x[-1])
    last = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(line) - 2)
    width = x[last + 1] - x[last]
    part = np.divide(at - x[last], width, out=np.zeros(len(at)), where=width > 0.0)
    return np.asarray(np.hypot(points[:, 0] - at, points[:, 1] - (y[last] + part * (y[last + 1] - y[last]))))
