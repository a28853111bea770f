"""Unique, ascending times of samples.

At a jump a history has two samples.  The left one stands at the time of the event, the right one at the next
larger floating-point number, so that each time names one sample: xarray's `.sel` and `.interp` and ParaView's
time steps need that.  Several events at one instant stand at consecutive numbers.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def ascending(times: Array) -> Array:
    """Return times (samples,) in s, in which repeated ones are moved to the next larger number."""
    found = np.array(times, dtype=float)
    for k in np.flatnonzero(np.diff(found) <= 0.0) + 1:
        # a time that is moved may equal the next one
        while k < found.size and found[k] <= found[k - 1]:
            found[k] = np.nextafter(found[k - 1], np.inf)
            k += 1
    return found


def jumps(times: Array) -> NDArray[np.bool_]:
    """Return a mask (samples - 1,): True at the left side of a jump."""
    return np.asarray(times[1:] == np.nextafter(times[:-1], np.inf))


def sides(times: Array) -> NDArray[np.int64]:
    """Return -1 for samples left of a jump, 1 for those right of it, 0 elsewhere, (samples,)."""
    jump = jumps(times)
    return np.where(np.append(False, jump), 1, np.where(np.append(jump, False), -1, 0))


def pieces(times: Array) -> list[NDArray[np.intp]]:
    """Return the indices of the samples between jumps, an array for each smooth piece."""
    return list(np.split(np.arange(times.size), np.flatnonzero(jumps(times)) + 1))


def last_sample(times: Array, at: ArrayLike) -> NDArray[np.intp]:
    """Return the index of the last sample at or before instants `at` (s), the right-hand one at a jump.

    It is -1 for instants before the first sample.
    """
    k = np.asarray(np.searchsorted(times, at, side="right") - 1)
    while True:
        following = np.minimum(k + 1, times.size - 1)
        beside = (k >= 0) & (times[following] == np.nextafter(times[k], np.inf))
        if not beside.any():
            return k
        k = np.where(beside, following, k)


def first_sample(times: Array, at: ArrayLike) -> NDArray[np.intp]:
    """Return the index of the first sample at or after instants `at` (s), the left-hand one at an event."""
    return np.asarray(np.searchsorted(times, at, side="left"))
