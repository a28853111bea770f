"""Curves that swing faster than pixels can show: a band from least to largest value, and the mean in it.

`page/envelope.js` of the player is the same in its language; the tests hold the two against each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PERIOD = 6.0  # pixels: what swings faster is drawn as a band
_TURNS = 5  # half periods in a row make a vibration


@dataclass(frozen=True)
class Band:
    """Least and largest values over a stretch of pixels.

    Attributes
    ----------
    x, low, high : ndarray, shape (n,)
        Pixels, ascending, and the values there.
    """

    x: Array
    low: Array
    high: Array


@dataclass(frozen=True)
class Drawn:
    """What stands for a curve: a line, in fast vibrations their mean, and the bands of these.

    Attributes
    ----------
    x, y : ndarray, shape (n,)
        Pixels, ascending, and values of the line.
    bands : list of Band
        One for each vibration.
    """

    x: Array
    y: Array
    bands: list[Band]


def drawn(x: Array, y: Array, swing: float) -> Drawn:
    """Return what stands for a curve.

    Parameters
    ----------
    x, y : ndarray, shape (samples,)
        Pixels, ascending, and values.
    swing : float
        Smaller changes of direction are none: about the value of a pixel.
    """
    lines, bands = [], []
    done = 0
    for a, b in fast_spans(x, y, swing):
        first, last = int(np.searchsorted(x, a)), int(np.searchsorted(x, b, side="right"))
        band, mean = _band(x[first:last], y[first:last])
        lines += [
            (x[done:first], y[done:first]),
            (np.clip(0.5 * (band.x[1:] + band.x[:-1]), x[first], x[last - 1]), mean),
        ]
        bands.append(band)
        done = last
    lines.append((x[done:], y[done:]))
    return Drawn(np.concatenate([p for p, _ in lines]), np.concatenate([v for _, v in lines]), bands)


def fast_spans(x: Array, y: Array, swing: float) -> list[tuple[float, float]]:
    """Return the intervals (pixels), apart from each other, of swings with periods shorter than `PERIOD`."""
    turns = turning_points(y, swing)
    at = x[turns]
    found: list[tuple[float, float]] = []
    for start, stop in zip(at[:-_TURNS], at[_TURNS:], strict=True):
        if stop - start > 0.5 * PERIOD * _TURNS:
            continue
        if found and start <= found[-1][1] + 1.0:
            found[-1] = (found[-1][0], float(stop))
        else:
            found.append((float(start), float(stop)))
    return [(a, b) for a, b in found if b > a]


def turning_points(y: Array, swing: float) -> list[int]:
    """Return the samples where the curve turns round, each at least `swing` away from the one before."""
    rises = np.diff(y)
    moving = np.flatnonzero(rises)
    ends = np.flatnonzero(np.diff(np.sign(rises[moving])))
    extremes = moving[ends] + 1
    turns: list[int] = []
    newest, up = 0, 0  # the extreme of the present run; its direction, unknown at first
    for k in [*extremes.tolist(), y.size - 1]:
        change = y[k] - y[newest]
        if up * change >= 0.0 and (up or abs(change) >= swing):
            up = up or int(np.sign(change))
            newest = k
        elif abs(change) >= swing:
            turns.append(newest)
            newest, up = k, int(np.sign(change))
    return turns


def _band(x: Array, y: Array) -> tuple[Band, Array]:
    """Band over the pixels of a vibration, and its mean in each of them."""
    edges = np.arange(np.floor(x[0]), np.floor(x[-1]) + 2.0)
    at_edges = np.interp(edges, x, y)
    order = np.argsort(np.concatenate([edges, x]), kind="stable")
    place, value = np.concatenate([edges, x])[order], np.concatenate([at_edges, y])[order]
    starts = np.flatnonzero(order < edges.size)
    low, high = np.empty(edges.size - 1), np.empty(edges.size - 1)
    area = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(place) * (value[1:] + value[:-1]))])
    for n, (start, stop) in enumerate(pairwise(starts)):
        low[n], high[n] = value[start : stop + 1].min(), value[start : stop + 1].max()
    near = int(PERIOD / 2)
    count = np.arange(low.size)
    left, right = np.maximum(count - near, 0), np.minimum(count + near + 1, low.size)
    mean = np.diff(area[starts])
    for _ in range(2):  # once would leave ripples of periods that do not fit
        sums = np.concatenate([[0.0], np.cumsum(mean)])
        mean = (sums[right] - sums[left]) / (right - left)
    low = np.array([low[a:b].min() for a, b in zip(left, right, strict=True)])
    high = np.array([high[a:b].max() for a, b in zip(left, right, strict=True)])
    # at an edge between two pixels the wider of both
    low = np.minimum(np.append(low, low[-1]), np.append(low[0], low))
    high = np.maximum(np.append(high, high[-1]), np.append(high[0], high))
    return Band(edges, low, high), mean
