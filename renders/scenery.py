"""Solids of what stands still in a picture: slope, pin, ground, and the blocks under them."""

from __future__ import annotations

import numpy as np
import pyvista as pv

from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.surroundings import FOOT, DrawnObstacle, Ground, depth_of

_STAND = 0.8  # width of what a slope stands on, over its own
_SLAB = 0.012  # thickness of the ground, over its length


def block(geometry: BeamGeometry, obstacle: DrawnObstacle) -> pv.PolyData:
    """Return a drawn obstacle as a solid, wound outward."""
    outline, n = obstacle.outline, len(obstacle.outline)
    x, y = outline.T
    if np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) < 0.0:
        outline = outline[::-1]  # counter-clockwise
    back, front = (np.insert(outline, 2, z, axis=1) for z in (-depth_of(geometry), depth_of(geometry)))
    sides = [(k, (k + 1) % n, (k + 1) % n + n, k + n) for k in range(n)]
    faces = [range(n)[::-1], range(n, 2 * n), *sides]
    return pv.PolyData(np.concatenate([back, front]), np.concatenate([[len(face), *face] for face in faces]))


def pin(geometry: BeamGeometry) -> pv.PolyData | None:
    """Return the pin (two cheeks with a bolt on a foot), a hub's disc, or the wall of a clamped beam.

    None of a beam that nothing holds.
    """
    if geometry.scenario.root.is_free:
        return None
    r, hub = float(geometry.radii[0]), geometry.scenario.root.hub_radius
    side = max(r, geometry.half_width)  # of the beam between the cheeks
    if geometry.clamped and hub == 0.0:
        wall = _box(-FOOT * r, 0.0, -FOOT * r, FOOT * r, side + 1.4 * r)
        return pv.PolyData(wall.rotate_z(np.degrees(geometry.values("theta")[0])).triangulate())
    height = 2.6 * side if hub > 0.0 else 2.0 * side + 3.6 * r
    bolt = pv.Cylinder(direction=(0.0, 0.0, 1.0), radius=max(0.7 * r, hub), height=height).triangulate()
    if hub > 0.0:
        return pv.PolyData(bolt)
    cheeks = [_box(-1.6 * r, 1.6 * r, -5.0 * r, 1.6 * r, 0.4 * r, z) for z in (-side - 0.9 * r, side + 0.9 * r)]
    foot = _box(-4.0 * r, 4.0 * r, -FOOT * r, -5.0 * r, max(5.0 * r, side + 1.4 * r))
    return pv.PolyData(pv.merge([*cheeks, foot, bolt]).extract_surface(algorithm="dataset_surface"))


def slab(ground: Ground) -> pv.PolyData:
    """Return the ground as a thin solid, its surface at its height."""
    low = ground.y - _SLAB * (ground.last - ground.first)
    return _box(ground.first, ground.last, low, ground.y, ground.half_depth)


def stand(solid: pv.PolyData, ground: Ground) -> pv.PolyData | None:
    """Return the block under the lowest face of a solid; None where it stands on the ground, or on an edge."""
    points = np.asarray(solid.points)
    low = float(points[:, 1].min())
    base = points[points[:, 1] < low + 1e-6 * np.ptp(points[:, 0])]
    wide, _, deep = np.ptp(base, axis=0)
    if low - ground.y < 1e-3 * wide or not wide > 0.0:
        return None
    middle, half = 0.5 * (base[:, 0].min() + base[:, 0].max()), 0.5 * _STAND * wide
    return _box(middle - half, middle + half, ground.y, low, 0.5 * _STAND * deep)


def _box(first: float, last: float, low: float, high: float, half_depth: float, z: float = 0.0) -> pv.PolyData:
    """Return a box between two places x and two heights, around the plane of motion or a place z."""
    return pv.Box((first, last, low, high, z - half_depth, z + half_depth))
