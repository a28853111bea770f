"""Two courses of time side by side: which instants belong together, a common clock, differences between curves."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Places = list[tuple[int | None, int | None]]

#: entries of the table of the alignment; longer logs than this allows are aligned by their kinds alone
MOST_CELLS = 10_000_000
#: times (s) are the same within this part of the span
SAME = 1e-12


def align(
    left: Sequence[float],
    right: Sequence[float],
    left_kinds: Sequence[Hashable],
    right_kinds: Sequence[Hashable],
    max_shift: float = np.inf,
) -> Places:
    """Pair two sequences of instants in order: as many pairs as possible, and of these the closest in time.

    Parameters
    ----------
    left, right : sequence of float
        Times (s), ascending.
    left_kinds, right_kinds : sequence
        Only instants of one kind make a pair.
    max_shift : float
        Instants further apart (s) are not a pair.

    Returns
    -------
    list of tuple
        Indices (left, right) in the order of time, None where one has no partner: the longest common subsequence
        with the smallest sum of time differences.
    """
    if len(left) * len(right) > MOST_CELLS:
        return _by_kind(left_kinds, right_kinds)
    numbers = {kind: n for n, kind in enumerate(dict.fromkeys([*left_kinds, *right_kinds]))}
    a, b = (np.array([numbers[k] for k in kinds], dtype=int) for kinds in (left_kinds, right_kinds))
    apart = np.abs(np.subtract.outer(np.asarray(left, dtype=float), np.asarray(right, dtype=float)))
    largest = float(np.max(apart, initial=0.0)) or 1.0
    # all time differences together count less than one pair
    gain = 1.0 - apart / largest / (2.0 * max(1, min(a.size, b.size)))
    gain[(a[:, None] != b[None, :]) | (apart > max_shift)] = -np.inf
    score = np.zeros((a.size + 1, b.size + 1))
    for i in range(a.size):
        score[i + 1, 1:] = np.maximum.accumulate(np.maximum(score[i, 1:], score[i, :-1] + gain[i]))
    return _in_order(_trace(score, gain), left, right)


def _by_kind(left: Sequence[Hashable], right: Sequence[Hashable]) -> Places:
    places: Places = []
    for tag, i1, i2, j1, j2 in SequenceMatcher(None, left, right, autojunk=False).get_opcodes():
        if tag == "equal":
            places += zip(range(i1, i2), range(j1, j2), strict=True)
        else:
            places += [(i, None) for i in range(i1, i2)]
            places += [(None, j) for j in range(j1, j2)]
    return places


def _trace(score: Array, gain: Array) -> list[tuple[int, int]]:
    """Read the pairs off the table, first to last."""
    pairs = []
    i, j = gain.shape
    while i and j:
        if score[i, j] == score[i - 1, j]:
            i -= 1
        elif score[i, j] == score[i, j - 1]:
            j -= 1
        else:
            i, j = i - 1, j - 1
            pairs.append((i, j))
    return pairs[::-1]


def _in_order(pairs: Sequence[tuple[int, int]], left: Sequence[float], right: Sequence[float]) -> Places:
    """Put those without a partner between the pairs, by time."""
    places: Places = []
    i = j = 0
    for stop_i, stop_j in [*pairs, (len(left), len(right))]:
        alone: Places = [*((k, None) for k in range(i, stop_i)), *((None, k) for k in range(j, stop_j))]
        places += sorted(alone, key=lambda p: left[p[0]] if p[0] is not None else right[p[1] or 0])
        if stop_i < len(left) and stop_j < len(right):
            places.append((stop_i, stop_j))
        i, j = stop_i + 1, stop_j + 1
    return places


@dataclass(frozen=True)
class Clock:
    """A common time of two histories: the mean of both times at the instants they share, linear in between.

    Attributes
    ----------
    left, right : ndarray, shape (knots,)
        Times (s) of the shared instants in either history, both strictly ascending.  Before the first and after
        the last one the two times differ as much as there; without any they are the same.
    """

    left: Array
    right: Array

    def of_left(self, times: Array) -> Array:
        """Return common times (s) of times of the left history."""
        return self._common(times, self.left)

    def of_right(self, times: Array) -> Array:
        """Return common times (s) of times of the right history."""
        return self._common(times, self.right)

    def _common(self, times: Array, own: Array) -> Array:
        if not own.size:
            return np.asarray(times, dtype=float)
        mean = 0.5 * (self.left + self.right)
        inside = np.interp(times, own, mean)
        before, after = times - own[0] + mean[0], times - own[-1] + mean[-1]
        return np.asarray(np.where(times < own[0], before, np.where(times > own[-1], after, inside)))


def clock(pairs: Sequence[tuple[float, float]], span: float) -> Clock:
    """Return the clock with those of `pairs` (left and right time, s) that ascend on both sides."""
    kept: list[tuple[float, float]] = []
    for left, right in pairs:
        if not kept or min(left - kept[-1][0], right - kept[-1][1]) > SAME * span:
            kept.append((left, right))
    knots = np.array(kept, dtype=float).reshape(-1, 2)
    return Clock(knots[:, 0].copy(), knots[:, 1].copy())


class Deviation(NamedTuple):
    """How far two courses are apart, right minus left, in the unit of the variable.

    `rms` is the root of the mean square over time (and along the beam); `largest` the difference of largest
    magnitude, with its sign; `at` the time (s) of that.
    """

    rms: float
    largest: float
    at: float


class Sampling:
    """Limits of piecewise linear courses from both sides at the instants of a grid.

    Parameters
    ----------
    times : ndarray, shape (samples,)
        Strictly ascending.
    grid : ndarray, shape (intervals + 1,)
        Strictly ascending, within the times; holds all of them that lie between its ends.
    """

    def __init__(self, times: Array, grid: Array) -> None:
        self._starts = _weights(times, grid[:-1], "right")
        self._ends = _weights(times, grid[1:], "left")

    def __call__(self, values: Array) -> tuple[Array, Array]:
        """Return the values (intervals, ...) just after the start and just before the end of each interval."""
        return _taken(values, *self._starts), _taken(values, *self._ends)


def _weights(times: Array, at: Array, side: str) -> tuple[NDArray[np.int64], Array]:
    """Sample before each instant and the part of the way to the next one, on one side of the jumps."""
    if side == "right":
        k = np.searchsorted(times, at, side="right") - 1
    else:
        k = np.searchsorted(times, at, side="left") - 1
    k = np.clip(k, 0, times.size - 2)
    width = times[k + 1] - times[k]
    part = np.divide(at - times[k], width, out=np.zeros(at.shape), where=width > 0.0)
    return k, np.clip(part, 0.0, 1.0)


def _taken(values: Array, k: NDArray[np.int64], part: Array) -> Array:
    part = part.reshape(-1, *(1,) * (values.ndim - 1))
    first, second = values[k], values[k + 1]
    # a sample that is hit is taken as it is: its neighbour may not be finite
    with np.errstate(invalid="ignore"):
        between = first + part * (second - first)
    return np.asarray(np.where(part == 0.0, first, np.where(part == 1.0, second, between)))


def deviation(
    grid: Array, left: tuple[Array, Array], right: tuple[Array, Array], weights: Array | None = None
) -> Deviation:
    """Measure the difference of two courses that are linear in each interval of a grid; integrals are exact.

    Parameters
    ----------
    grid : ndarray, shape (intervals + 1,)
        Times (s).
    left, right : tuple of ndarray, shape (intervals,) or (intervals, points)
        Values just after the start and just before the end of each interval.
    weights : ndarray, shape (points,), optional
        Parts of the mean along the beam, of sum 1.
    """
    with np.errstate(invalid="ignore"):
        starts, ends = (_apart(a, b) for a, b in zip(left, right, strict=True))
    if not starts.size:
        return Deviation(0.0, 0.0, float(grid[0]))
    if starts.ndim == 1:
        starts, ends = starts[:, None], ends[:, None]
    share = np.full(starts.shape[1], 1.0 / starts.shape[1]) if weights is None else weights
    with np.errstate(invalid="ignore"):
        inside = starts**2 + starts * ends + ends**2
    # infinite at one end alone
    squares = np.where(np.isnan(inside), np.inf, inside) @ share / 3.0
    rms = float(np.sqrt(np.diff(grid) @ squares / (grid[-1] - grid[0])))
    both = np.concatenate([starts, ends])
    row, column = np.unravel_index(int(np.argmax(np.abs(both))), both.shape)
    instants = np.concatenate([grid[:-1], grid[1:]])
    return Deviation(rms, float(both[row, column]), float(instants[row]))


def _apart(left: Array, right: Array) -> Array:
    """Right minus left; 0 where neither is finite, infinite where one of them is not."""
    wild = ~np.isfinite(left), ~np.isfinite(right)
    apart = np.where(wild[0] & wild[1], 0.0, right - left)
    return np.asarray(np.where(wild[0] ^ wild[1], np.inf, apart))
