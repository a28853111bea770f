"""The ground on which slope and pin stand."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.slope import DrawnSlope

Array = NDArray[np.float64]

#: half of the depth of slope and pin, over the radius of the beam; over half of the width of a wide one
DEPTH, _WIDE = 5.0, 1.3
#: depth of the pin's foot below the axis, over the radius of the beam there
FOOT = 6.5
#: over the length of the beam: how far the ground reaches beyond all that stands on it or moves above it
_BEYOND = 0.06
_WIDER = 2.2  # half of its depth over that of slope or pin
_SAMPLES = 200  # of a run that are looked at


class Ground(NamedTuple):
    """A level rectangle at a height `y` (m), from `first` to `last` (m) and so far to both sides of the beam."""

    y: float
    first: float
    last: float
    half_depth: float


def depth_of(geometry: BeamGeometry) -> float:
    """Half of the depth (m) of the drawn slope, out of the plane of motion."""
    return max(DEPTH * geometry.touch_radius, _WIDE * geometry.half_width)


def ground_of(geometries: Sequence[BeamGeometry], slope: DrawnSlope | None) -> Ground | None:
    """Return the ground under some runs: at the lowest point of slope and pin.

    None where no gravity tells which way is down, without a slope, and where a beam would come below it.
    """
    first = geometries[0]
    if slope is None or first.scenario.gravity == 0.0:
        return None
    corners, length = slope.outline, first.scenario.beam.length
    foot = max(FOOT * float(first.radii[0]), first.scenario.root.hub_radius)
    y = min(float(corners[:, 1].min()), -foot)
    places = []
    for geometry in geometries:
        samples = np.unique(np.linspace(0, geometry.times.size - 1, _SAMPLES).astype(np.int64))
        found = geometry.stations_of(samples).reshape(-1, 2)
        places.append(found[np.all(np.abs(found) < 1e3 * length, axis=1)])
    reached = np.concatenate(places)
    if reached[:, 1].min() < y:
        return None
    x = np.concatenate([corners[:, 0], reached[:, 0], [-foot, foot]])
    depth = _WIDER * depth_of(first)
    return Ground(y, float(x.min()) - _BEYOND * length, float(x.max()) + _BEYOND * length, depth)
