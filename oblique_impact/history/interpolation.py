"""Interpolation of a history between samples; values on either side of a jump."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import xarray as xr

from oblique_impact.errors import InputError
from oblique_impact.history.sample_times import first_sample, jumps, last_sample, pieces

Side = Literal["left", "right"]
Array = np.ndarray[Any, Any]

#: variables and their derivatives in time
RATES = {
    "q": "qd",
    "theta": "theta_dot",
    "gap": "gap_rate",
    "slip": "slip_rate",
    "tip_x": "tip_vx",
    "tip_y": "tip_vy",
    "ux": "ux_dot",
    "uy": "uy_dot",
    "origin_x": "origin_vx",
    "origin_y": "origin_vy",
}


def sample_before(times: Array, time: float, side: Side = "right") -> int:
    """Return the last sample at or before a time (s), at a jump that of the given side.

    Raises InputError for a time outside of the samples.
    """
    if not times[0] <= time <= times[-1]:
        raise InputError(f"time = {time}: should be from {times[0]:g} to {times[-1]:g} s")
    at_left = side == "left" and time in times
    return int(first_sample(times, time) if at_left else last_sample(times, time))


def value_at(times: Array, values: Array, rates: Array | None, time: float, side: Side = "right") -> Array:
    """Interpolate values (samples, ...) at a time (s) by a cubic, never across a jump.

    With `rates` it is Hermite's; without, that through up to two samples on either side.  Raises InputError for a
    time outside of the samples.
    """
    from scipy.interpolate import KroghInterpolator  # a fifth of a second, for which a run does not wait

    k = sample_before(times, time, side)
    if time in times:
        return np.asarray(values[k])
    if rates is not None:
        ends = [times[k], times[k], times[k + 1], times[k + 1]]
        given = np.stack([values[k], rates[k], values[k + 1], rates[k + 1]])
        return np.asarray(KroghInterpolator(ends, given)(time))
    jump = jumps(times)
    first = k - 1 if k > 0 and not jump[k - 1] else k
    last = k + 2 if k + 2 < times.size and not jump[k + 1] else k + 1
    around = slice(first, last + 1)
    return np.asarray(KroghInterpolator(times[around], values[around])(time))


def series_at(times: Array, values: Array, at: Array, rates: Array | None = None, order: int = 0) -> Array:
    """Interpolate values (samples,), or differentiate them, at many times (n,) in s, never across a jump.

    With `rates` by Hermite's cubics; without, by a cubic spline through the samples between two jumps.
    """
    from scipy.interpolate import CubicHermiteSpline, make_interp_spline

    found, sample = np.empty(at.size), last_sample(times, at)
    for piece in pieces(times):
        here = (sample >= piece[0]) & (sample <= piece[-1])
        if here.any():
            t, x = times[piece], values[piece]
            if rates is None or t.size == 1:
                curve = make_interp_spline(t, x, k=min(3, t.size - 1))
            else:
                curve = CubicHermiteSpline(t, x, rates[piece])
            found[here] = curve(at[here], order)
    return found


def dataset_at(data: xr.Dataset, time: float, side: Side = "right") -> xr.Dataset:
    """Return all variables of a history's data at a time (s); states are those of the sample before."""
    times = data["time"].values
    found = dict[str, tuple[Any, ...]]()  # put into the dataset together: one by one takes longer than all else
    for name, array in data.data_vars.items():
        if array.dims[:1] == ("time",) and array.dtype.kind == "f":
            rates = data[RATES[str(name)]].values if RATES.get(str(name)) in data else None
            found[str(name)] = (array.dims[1:], value_at(times, array.values, rates, time, side), array.attrs)
    return data.isel(time=sample_before(times, time, side)).assign_coords(time=time).assign(found)
