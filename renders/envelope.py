"""Curves that swing faster than pixels can show: a band from least to largest value, and the mean in it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d, minimum_filter1d
from scipy.signal import find_peaks

Array = NDArray[np.float64]
Index = NDArray[np.int64]

PERIOD = 6.0  # pixels: what swings faster is drawn as a band
_TURNS = 5  # half periods in a row make a vibration


class Band(NamedTuple):
    """Least and largest values, (n,) each, at pixels `x`, ascending."""

    x: Array
    low: Array
    high: Array


class Drawn(NamedTuple):
    """What stands for a curve: a line (pixels, values, (n,)), in vibrations their mean, and the bands of these."""

    x: Array
    y: Array
    bands: list[Band]


def drawn(x: Array, y: Array, swing: float) -> Drawn:
    """Return what stands for a curve: pixels `x`, ascending, and values `y`, (samples,).

    Changes of direction smaller than `swing` are none: about the value of a pixel.
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
    at = x[turning_points(y, swing)]
    found: list[tuple[float, float]] = []
    for start, stop in zip(at[:-_TURNS].tolist(), at[_TURNS:].tolist(), strict=True):
        if stop - start > 0.5 * PERIOD * _TURNS:
            continue
        if found and start <= found[-1][1] + 1.0:
            start = found.pop()[0]
        found.append((start, stop))
    return [(a, b) for a, b in found if b > a]


def turning_points(y: Array, swing: float) -> Index:
    """Return the samples where the curve turns round, each at least `swing` away from the ones beside it."""
    return np.union1d(*(find_peaks(sign * y, prominence=swing)[0] for sign in (1.0, -1.0)))


def _band(x: Array, y: Array) -> tuple[Band, Array]:
    """Band over the pixels of a vibration, and its mean in each of them."""
    edges = np.arange(np.floor(x[0]), np.floor(x[-1]) + 2.0)
    order = np.argsort(np.concatenate([edges, x]), kind="stable")
    place, value = np.concatenate([edges, x])[order], np.concatenate([np.interp(edges, x, y), y])[order]
    starts = np.flatnonzero(order < edges.size)
    area = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(place) * (value[1:] + value[:-1]))])
    mean, near = np.diff(area[starts]), np.ones(2 * int(PERIOD / 2) + 1)
    inside = slice(near.size // 2, near.size // 2 + mean.size)
    count = np.convolve(np.ones_like(mean), near)[inside]
    for _ in range(2):  # once would leave ripples of periods that do not fit
        mean = np.convolve(mean, near)[inside] / count
    ends = []
    for extreme, widened in ((np.minimum, minimum_filter1d), (np.maximum, maximum_filter1d)):
        pixels = extreme(extreme.reduceat(value, starts)[:-1], value[starts[1:]])
        pixels = widened(pixels, near.size, mode="nearest")
        # at an edge between two pixels the wider of both
        ends.append(extreme(np.append(pixels, pixels[-1]), np.append(pixels[0], pixels)))
    return Band(edges, *ends), mean
