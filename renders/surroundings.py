"""What stands still around a beam: the slope, the ground, and what all pictures draw of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.renders.geometry import BeamGeometry

Array = NDArray[np.float64]

#: over the length: how close a beam comes to what is drawn of an unbounded slope, and the room beyond that
_NEAR, _ROOM = 0.005, 0.12
#: over the beam's reach: what lies farther from the pin is not drawn
_SEEN = 1.2
#: over the length: depth of the slope, below its lower end or, of one steeper than 60 degrees, across it
_BELOW, _ACROSS = 0.06, 0.1
#: half of the depth of slope and pin out of the plane: over the radius of the beam, over half of its width
_DEEP, _WIDE = 5.0, 1.3
FOOT = 6.5  # depth of the pin's foot below the axis, over the radius of the beam there
#: how far the ground reaches beyond what stands on it, over the length; half of its depth over that of the slope
_BEYOND, _WIDER = 0.06, 2.2
_SAMPLES = 2000  # of a run that are looked at


class DrawnSlope(NamedTuple):
    """The slope as pictures show it."""

    ends: tuple[float, float]  # m along the slope from `slope.origin`
    outline: Array  # (4, 2), m; the surface from its first end to its last one, and back through the solid


class Ground(NamedTuple):
    """A level rectangle at a height `y` (m), from `first` to `last` (m) and so far to both sides of the beam."""

    y: float
    first: float
    last: float
    half_depth: float


def drawn_slope(geometry: BeamGeometry) -> DrawnSlope | None:
    """Return what is drawn of the slope of a run; None without contact, or if it is out of the beam's reach.

    Where contact is on the beam's axis the surface lies half its depth, that at the contact point, below the line
    that the axis touches; else it is that line. The ends are those of the scenario; an unbounded slope is drawn as
    far as any part of the beam comes near or below it. The deformation factor changes nothing of it.
    """
    scenario, slope = geometry.scenario, geometry.scenario.slope
    if not scenario.contact.enabled:
        return None
    length, reach = scenario.beam.length, _SEEN * (scenario.beam.length + scenario.root.hub_radius)
    tangent, normal = geometry.slope_axes
    pin = -float(np.dot(slope.origin, tangent))
    ends = slope.extent or _ends_of(geometry, pin, reach)
    first, last = np.clip(ends, pin - reach, pin + reach)
    if not first < last:
        return None
    top = np.array(slope.origin) + np.outer([first, last], tangent) - geometry.slope_depth * normal
    if tangent[0] < 0.5:
        bottom = top - _ACROSS * length * normal
    else:
        bottom = np.stack([top[:, 0], np.full(2, top[:, 1].min() - _BELOW * length)], axis=1)
    return DrawnSlope((float(first), float(last)), np.concatenate([top, bottom[::-1]]))


def _ends_of(geometry: BeamGeometry, pin: float, reach: float) -> tuple[float, float]:
    """Return the stretch (m along the slope) near or below which the axis comes in the run, with some room."""
    length = geometry.scenario.beam.length
    places = _looked_at(geometry) - np.array(geometry.scenario.slope.origin)
    along, height = (places @ geometry.slope_axes.T).T
    seen = (np.abs(along - pin) < reach) & (np.abs(height) < reach)
    if not seen.any():
        return pin, pin
    near = along[seen & (height <= max(height[seen].min(), 0.0) + _NEAR * length)]
    return float(near.min()) - _ROOM * length, float(near.max()) + _ROOM * length


def _looked_at(geometry: BeamGeometry) -> Array:
    """Return places (n, 2) of the axis in the run."""
    samples = np.unique(np.linspace(0, geometry.times.size - 1, _SAMPLES).astype(np.int64))
    return geometry.stations_at(samples).reshape(-1, 2)


def depth_of(geometry: BeamGeometry) -> float:
    """Return half of the depth (m) of the drawn slope, out of the plane of motion."""
    return max(_DEEP * geometry.touch_radius, _WIDE * geometry.half_width)


def ground_of(geometries: Sequence[BeamGeometry], slope: DrawnSlope | None) -> Ground | None:
    """Return the ground under some runs: at the lowest point of slope and pin.

    None where no gravity tells which way is down, without a slope, and where a beam would come below it.
    """
    first = geometries[0]
    if slope is None or first.scenario.gravity == 0.0:
        return None
    length = first.scenario.beam.length
    foot = max(FOOT * float(first.radii[0]), first.scenario.root.hub_radius)
    y = min(float(slope.outline[:, 1].min()), -foot)
    places = np.concatenate([_looked_at(geometry) for geometry in geometries])
    reached = places[np.all(np.abs(places) < 1e3 * length, axis=1)]
    if reached[:, 1].min() < y:
        return None
    x = np.concatenate([slope.outline[:, 0], reached[:, 0], [-foot, foot]])
    room = _BEYOND * length
    return Ground(y, float(x.min()) - room, float(x.max()) + room, _WIDER * depth_of(first))
