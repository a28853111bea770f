"""Clearance of the whole beam from the slope and the other obstacles, at its stations.

Distances are those of the axis, positive on the free side; pictures draw the surface half the beam's depth lower.
With `contact.surface = "section"` they are those of the beam's face that looks at the obstacle.  Points are
complex numbers here, z = x + i y (m).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from oblique_impact.beam.bent_beam import BentBeam
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import Array
from oblique_impact.contact.state import State
from oblique_impact.scenario.scenario import Scenario

Points = NDArray[np.complex128]

#: difference of distances, over the length, that is rounding: of equal ones the first instant counts
EQUAL = 1e-9


def clearance_along(
    scenario: Scenario,
    sections: Sections,
    bent: BentBeam,
    variables: Mapping[str, Any],
    on_side: Sequence[bool] = (),
) -> dict[str, NDArray[Any]]:
    """Return the smallest signed distance from the obstacles over the stations, its place, the nearest obstacle.

    Below a side it is negative, and from a peg where the axis, or the face, is inside of it.  A peg or a corner
    that lies between two stations is as far from the beam as the gap of its contact says, which also knows on
    which side of it the axis is.

    Parameters
    ----------
    scenario : Scenario
        With its obstacles.
    sections : Sections
        Cross-sections of its beam.
    bent : BentBeam
        The beam at its stations.
    variables : mapping of str to ndarray
        `station` of a history, and the variables of its contacts.
    on_side : sequence of bool, shape (contacts,)
        Whether each contact is a point of the beam on a side, not a point of an obstacle on the beam.

    Returns
    -------
    dict of str to ndarray, each of shape (samples,)
        The variables `clearance` and `clearance_at` (m), NaN where the motion is, and `clearance_obstacle`: the
        slope is 0.
    """
    x, axis = variables["station"], bent.point()
    depth = sections.fibre_distance(x) if scenario.contact.surface == "section" else 0.0
    found = list[tuple[int, Array, Array]]()
    for number, outline in scenario.outlines.items():
        found.append((number, outline.distance(axis) - depth, x))
    for side in [each for each in scenario.sides if each.obstacle not in scenario.outlines]:
        face = bent.point(side.facing(scenario.initial.angle) * depth)
        found.append((side.obstacle, _from_side(side.extent, side.slip_and_gap(face)), x))
    for point in scenario.obstacle_points:
        if not point.corner:  # which belongs to its side
            away = np.abs(axis - (point.x + 1j * point.y))
            found.append((point.obstacle, away - point.radius - depth, x))
    for i in np.flatnonzero(np.logical_not(on_side)):
        gap, place = variables["contact_gap"][:, i], variables["contact_place"][:, i]
        beside = (gap > -EQUAL * sections.length) & (place >= 0.0) & (place <= sections.length)
        known = beside | (variables["contact_state"][:, i] != State.FREE)
        found.append((variables["contact_obstacle"][i], np.where(known, gap, np.inf)[:, None], place[:, None]))
    distances = np.concatenate([distance for _, distance, _ in found], axis=1)
    places = np.concatenate([np.broadcast_to(place, distance.shape) for _, distance, place in found], axis=1)
    obstacles = np.concatenate([np.full(distance.shape[1], number) for number, distance, _ in found])
    nearest = np.argmin(np.nan_to_num(distances, nan=np.inf, posinf=np.inf), axis=1)
    samples = np.arange(nearest.size)
    found_at = {"clearance": distances[samples, nearest], "clearance_at": places[samples, nearest]}
    return found_at | {"clearance_obstacle": obstacles[nearest]}


def _from_side(extent: tuple[float, ...], z: Points) -> Array:
    """Distance (m) of points from a side, z = slip + i gap; beyond its ends that from the nearer."""
    if not extent:
        return z.imag
    beyond = np.maximum(extent[0] - z.real, z.real - extent[1])
    return np.where(beyond > 0.0, np.hypot(beyond, z.imag), z.imag)


def closest(variables: Mapping[str, Array], length: float) -> dict[str, float] | None:
    """Return the smallest distance (m) of a run from the obstacles, its place x (m) and its first time (s).

    Negative below the slope; with the nearest obstacle.  None if contact is disabled.
    """
    distance = np.asarray(variables.get("clearance", np.nan))
    if not np.isfinite(distance).any():
        return None
    first = int(np.argmax(distance <= np.nanmin(distance) + EQUAL * length))
    found = {"distance": distance, "x": variables["clearance_at"], "time": variables["time"]}
    found["obstacle"] = variables["clearance_obstacle"]
    return {name: values[first].item() for name, values in found.items()}
