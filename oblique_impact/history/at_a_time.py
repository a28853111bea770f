"""Values of a history at one time, between samples and at jumps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from oblique_impact.errors import InputError
from oblique_impact.history.sample_times import jumps

if TYPE_CHECKING:
    from xarray import Dataset

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
}


def samples_beside(times: Array, time: float, side: Side) -> tuple[int, int]:
    """Return the samples before and after a time (s), the same twice where there is one; those of a jump's side.

    Raises InputError for a time outside of the samples.
    """
    if not times[0] <= time <= times[-1]:
        raise InputError(f"time = {time}: should be from {times[0]:g} to {times[-1]:g} s")
    after = int(np.searchsorted(times, time))
    if times[after] != time:
        return after - 1, after
    beside = jumps(times)
    while side == "right" and after < beside.size and beside[after]:
        after += 1
    while side == "left" and after > 0 and beside[after - 1]:
        after -= 1
    return after, after


def value_at(times: Array, values: Array, rates: Array | None, time: float, side: Side = "right") -> Array:
    """Return values (samples, ...) at a time (s): by a cubic, never across a jump.

    With `rates` it is Hermite's; else that through up to two samples on either side.
    """
    from scipy.interpolate import BarycentricInterpolator, CubicHermiteSpline

    left, right = samples_beside(times, time, side)
    if left == right:
        return np.asarray(values[left])
    if rates is not None:
        ends = slice(left, right + 1)
        return np.asarray(CubicHermiteSpline(times[ends], values[ends], rates[ends])(time))
    beside = jumps(times)
    first = left - 1 if left > 0 and not beside[left - 1] else left
    last = right + 1 if right + 1 < times.size and not beside[right] else right
    around = slice(first, last + 1)
    # its weights are rounded by the order of the points, which it shuffles
    return np.asarray(BarycentricInterpolator(times[around], values[around], rng=0)(time))


def dataset_at(data: Dataset, time: float, side: Side) -> Dataset:
    """Return all variables of a history's data at a time (s); states are those of the sample before."""
    times = data["time"].values
    found = data.isel(time=samples_beside(times, time, side)[0]).assign_coords(time=time)
    for name, array in data.data_vars.items():
        if array.dims[:1] == ("time",) and array.dtype.kind == "f":
            rates = data[RATES[str(name)]].values if RATES.get(str(name)) in data else None
            found[name] = (array.dims[1:], value_at(times, array.values, rates, time, side), array.attrs)
    return found
