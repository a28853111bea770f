"""Solids of what stands still in a picture: slope, pin, ground, and the blocks under them."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.surroundings import FOOT, DrawnSlope, Ground, depth_of

Array = NDArray[np.float64]

_STAND = 0.8  # width of what a slope stands on, over its own
_SLAB = 0.012  # thickness of the ground, over its length


def slope_wedge(geometry: BeamGeometry, slope: DrawnSlope) -> pv.PolyData:
    """Return the drawn slope as a solid."""
    return _prism(slope.outline, depth_of(geometry))


def pin(geometry: BeamGeometry) -> pv.PolyData:
    """Return the pin: two cheeks with a bolt on a foot, or a hub's disc of its radius."""
    r, hub = float(geometry.radii[0]), geometry.scenario.root.hub_radius
    side = max(r, geometry.half_width)  # of the beam between the cheeks
    bolt = pv.Cylinder(
        direction=(0.0, 0.0, 1.0),
        radius=max(0.7 * r, hub),
        height=2.6 * side if hub > 0.0 else 2.0 * side + 3.6 * r,
    ).triangulate()
    if hub > 0.0:
        return pv.PolyData(bolt)
    cheek, foot = (
        r * np.array([(-wide, low), (wide, low), (wide, high), (-wide, high)])
        for wide, low, high in ((1.6, -5.0, 1.6), (4.0, -FOOT, -5.0))
    )
    cheeks = [_prism(cheek, 0.4 * r, z) for z in (-side - 0.9 * r, side + 0.9 * r)]
    whole = pv.merge([*cheeks, _prism(foot, max(5.0 * r, side + 1.4 * r)), bolt])
    return pv.PolyData(whole.extract_surface(algorithm="dataset_surface"))


def slab(ground: Ground) -> pv.PolyData:
    """Return the ground as a thin solid, its surface at its height."""
    low = ground.y - _SLAB * (ground.last - ground.first)
    corners = np.array(
        [(ground.first, low), (ground.last, low), (ground.last, ground.y), (ground.first, ground.y)]
    )
    return _prism(corners, ground.half_depth)


def stand(solid: pv.PolyData, ground: Ground) -> pv.PolyData | None:
    """Return the block under the lowest face of a solid; None where it stands on the ground, or on an edge."""
    points = np.asarray(solid.points)
    low = float(points[:, 1].min())
    base = points[points[:, 1] < low + 1e-6 * np.ptp(points[:, 0])]
    wide, deep = np.ptp(base[:, 0]), np.ptp(base[:, 2])
    if low - ground.y < 1e-3 * wide or not wide > 0.0:
        return None
    middle, half = 0.5 * (base[:, 0].min() + base[:, 0].max()), 0.5 * _STAND * wide
    corners = np.array([(-half, ground.y), (half, ground.y), (half, low), (-half, low)]) + np.array([middle, 0.0])
    return _prism(corners, 0.5 * _STAND * deep)


def _prism(outline: Array, half_depth: float, z: float = 0.0) -> pv.PolyData:
    """Return a solid over a polygon (corners, 2), wound outward."""
    n, k = len(outline), np.arange(len(outline))
    area = np.sum(outline[:, 0] * np.roll(outline[:, 1], -1) - np.roll(outline[:, 0], -1) * outline[:, 1])
    corners = outline if area > 0.0 else outline[::-1]
    back, front = (np.column_stack([corners, np.full(n, z + d)]) for d in (-half_depth, half_depth))
    sides = np.stack([np.full(n, 4), k, (k + 1) % n, (k + 1) % n + n, k + n], axis=1).reshape(-1)
    return pv.PolyData(np.concatenate([back, front]), np.concatenate([[n], k[::-1], [n], k + n, sides]))
