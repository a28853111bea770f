"""Two histories of one beam with their difference magnified, to see what is too small to be seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from oblique_impact.errors import InputError
from oblique_impact.history.history import History


def magnify_difference(first: History, second: History, factor: float) -> History:
    """Return `second` with its beam drawn at `first` plus `factor` times their difference.

    Both are taken at the times of the second one; everything but the position stays as it is.
    Raises InputError if the two do not have the same stations or the factor is not positive and finite.
    """
    if not 0.0 < factor < np.inf:
        raise InputError(f"--magnify-difference {factor}: should be a positive number")
    stations = [history["station"].values for history in (first, second)]
    if stations[0].shape != stations[1].shape or not np.allclose(stations[0], stations[1]):
        raise InputError("--magnify-difference: the two histories should have the same output stations")
    # linear between samples; beyond the end of the first run as at its end
    time = np.clip(second["time"].values, *first["time"].values[[0, -1]])
    theirs = first.data[["theta", "ux", "uy"]].interp(time=time)
    changed = {}
    for name in ("theta", "ux", "uy"):
        start = theirs[name].values
        changed[name] = second[name].copy(data=start + factor * (second[name].values - start))
    return replace(second, data=second.data.assign(changed))
