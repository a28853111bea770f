"""Curves that swing faster than pixels can show: a band from least to largest value, and the mean in it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.ndimage import maximum_filter1d, minimum_filter1d, uniform_filter1d
from scipy.signal import find_peaks

Array = NDArray[np.float64]

PERIOD = 6.0  # pixels: what swings faster is drawn as a band
_NEAR = 8  # pixels that are looked at for a place of a band, even and more than a period
_TURNS = 5  # half periods in a row make a vibration


class Band(NamedTuple):
    """Least and largest values, (n,) each, at pixels `x`, ascending."""

    x: Array
    low: Array
    high: Array


class Drawn(NamedTuple):
    """Replacement of a curve: a line (pixels, values, (n,)), in vibrations their mean, and the bands of these."""

    x: Array
    y: Array
    bands: list[Band]


def drawn(x: Array, y: Array, swing: float) -> Drawn:
    """Return the replacement of a curve: pixels `x`, ascending, and values `y`, (samples,).

    Changes of direction smaller than `swing` are none: about the value of a pixel.
    """
    lines, bands = [], []
    done = 0
    for a, b in fast_spans(x, y, swing):
        first, last = int(np.searchsorted(x, a)), int(np.searchsorted(x, b, side="right"))
        band, mean = _band(x[first:last], y[first:last])
        lines += [(x[done:first], y[done:first]), (0.5 * (band.x[1:] + band.x[:-1]), mean)]
        bands.append(band)
        done = last
    lines.append((x[done:], y[done:]))
    return Drawn(np.concatenate([p for p, _ in lines]), np.concatenate([v for _, v in lines]), bands)


def fast_spans(x: Array, y: Array, swing: float) -> list[tuple[float, float]]:
    """Return the intervals (pixels), apart from each other, of swings with periods shorter than `PERIOD`."""
    turns = np.union1d(*(find_peaks(sign * y, prominence=swing)[0] for sign in (1.0, -1.0)))
    at = x[turns]
    found: list[tuple[float, float]] = []
    for start, stop in zip(at[:-_TURNS].tolist(), at[_TURNS:].tolist(), strict=True):
        if stop - start > 0.5 * PERIOD * _TURNS:
            continue
        if found and start <= found[-1][1] + 1.0:
            start = found.pop()[0]
        found.append((start, stop))
    return [(a, b) for a, b in found if b > a]


def _band(x: Array, y: Array) -> tuple[Band, Array]:
    """Return the band of a vibration at the edges of pixels, and its mean between two edges."""
    edges = np.linspace(x[0], x[-1], math.ceil(x[-1] - x[0]) + 1)
    mean = np.diff(np.interp(edges, x, cumulative_trapezoid(y, x, initial=0.0))) / np.diff(edges)
    for _ in range(2):  # once would leave ripples of periods that do not fit
        mean = uniform_filter1d(mean, _NEAR - 1, mode="nearest")
    starts = np.searchsorted(x, edges[:-1])
    low, high = (extreme.reduceat(y, starts) for extreme in (np.minimum, np.maximum))
    # with one pixel more an even filter lies evenly about the edges between pixels
    low = minimum_filter1d(np.append(low, low[-1]), _NEAR, mode="nearest")
    return Band(edges, low, maximum_filter1d(np.append(high, high[-1]), _NEAR, mode="nearest")), mean
