"""Two histories of one beam with their difference magnified, to see what is too small to be seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from oblique_impact.errors import InputError
from oblique_impact.history.history import History

#: what is magnified: where the beam is
_PLACES = ("theta", "ux", "uy")


def magnify_difference(first: History, second: History, factor: float) -> History:
    """Return `second` with its beam drawn at `first` plus `factor` times their difference.

    Both are taken at the times of the second one; everything but the position stays as it is.
    Raises InputError if the two do not have the same stations or the factor is not positive and finite.
    """
    if not 0.0 < factor < np.inf:
        raise InputError(f"--magnify-difference {factor}: should be a positive number")
    stations = [np.asarray(history["station"].values) for history in (first, second)]
    if stations[0].shape != stations[1].shape or not np.allclose(stations[0], stations[1]):
        raise InputError("--magnify-difference: the two histories should have the same output stations")
    time = np.asarray(second["time"].values)
    changed = {}
    for name in _PLACES:
        mine, theirs = second[name], _at(first, name, time)
        changed[name] = mine.copy(data=theirs + factor * (np.asarray(mine.values) - theirs))
    return replace(second, data=second.data.assign(changed))


def _at(history: History, name: str, time: np.ndarray) -> np.ndarray:
    """Values of a variable at other times, linearly between samples."""
    own, values = np.asarray(history["time"].values), np.asarray(history[name].values)
    k = np.clip(np.searchsorted(own, time, side="right") - 1, 0, own.size - 2)
    width = own[k + 1] - own[k]
    part = np.divide(np.clip(time, own[0], own[-1]) - own[k], width, out=np.zeros_like(time), where=width > 0.0)
    part = part.reshape(-1, *(1,) * (values.ndim - 1))
    return np.asarray(values[k] + part * (values[k + 1] - values[k]))
