"""The drawn slope: where it begins and ends, and its outline. All pictures draw this one; none trims it to fit."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.renders.geometry import BeamGeometry

Array = NDArray[np.float64]

#: over the length: how close a beam comes to what is drawn of an unbounded slope, and the room beyond that
_NEAR, _ROOM = 0.005, 0.12
#: over the beam's reach: what lies farther from the pin is not drawn
_SEEN = 1.2
#: over the length: depth of the solid, below its lower end or, of a slope steeper than 60 degrees, across it
_BELOW, _ACROSS = 0.06, 0.1
_SAMPLES = 2000  # of the run that are looked at


class DrawnSlope(NamedTuple):
    """The slope as pictures show it."""

    ends: tuple[float, float]  # m along the slope from `slope.origin`
    outline: Array  # (4, 2), m; the surface from its first end to its last one, and back through the solid


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
    """Stretch (m along the slope) near or below which the axis comes in the run, with some room."""
    length = geometry.scenario.beam.length
    samples = np.unique(np.linspace(0, geometry.times.size - 1, _SAMPLES).astype(np.int64))
    places = geometry.stations_of(samples) - np.array(geometry.scenario.slope.origin)
    along, height = np.moveaxis(places @ geometry.slope_axes.T, -1, 0)
    seen = (np.abs(along - pin) < reach) & (np.abs(height) < reach)
    if not seen.any():
        return pin, pin
    near = along[seen & (height <= max(height[seen].min(), 0.0) + _NEAR * length)]
    return float(near.min()) - _ROOM * length, float(near.max()) + _ROOM * length
