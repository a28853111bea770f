"""What stands still in a picture: the slope as a solid wedge, and the pin."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from renders.geometry import BeamGeometry
from renders.slope import drawn_slope

Array = NDArray[np.float64]

#: half of the depth of wedge and pin, over the radius of the beam
_DEPTH = 5.0


def slope_wedge(geometry: BeamGeometry) -> pv.PolyData | None:
    """Return the drawn slope as a solid; None if there is none."""
    slope = drawn_slope(geometry)
    return _prism(slope.outline, _DEPTH * geometry.touch_radius) if slope else None


def pin(geometry: BeamGeometry) -> pv.PolyData:
    """Return the pin: two cheeks with a bolt on a foot, or a hub's disc of its radius."""
    r, depth = float(geometry.radii[0]), _DEPTH * float(geometry.radii[0])
    hub = geometry.scenario.root.hub_radius
    bolt = pv.Cylinder(center=(0.0, 0.0, 0.0), direction=(0.0, 0.0, 1.0), radius=max(0.7 * r, hub), height=2.6 * r)
    if hub > 0.0:
        return _solid(bolt)
    cheeks = [
        _prism(
            np.array([(-1.6 * r, -5.0 * r), (1.6 * r, -5.0 * r), (1.6 * r, 1.6 * r), (-1.6 * r, 1.6 * r)]),
            0.4 * r,
            z,
        )
        for z in (-1.9 * r, 1.9 * r)
    ]
    foot = _prism(
        np.array([(-4.0 * r, -6.5 * r), (4.0 * r, -6.5 * r), (4.0 * r, -5.0 * r), (-4.0 * r, -5.0 * r)]), depth
    )
    long_bolt = pv.Cylinder(center=(0.0, 0.0, 0.0), direction=(0.0, 0.0, 1.0), radius=0.7 * r, height=5.6 * r)
    return _solid(pv.merge([*cheeks, foot, long_bolt.triangulate()]))


def _solid(mesh: pv.DataSet) -> pv.PolyData:
    """Return the surface of a mesh as polygons."""
    return pv.PolyData(mesh.extract_surface(algorithm="dataset_surface"))


def _prism(outline: Array, half_depth: float, z: float = 0.0) -> pv.PolyData:
    """Return a solid over a polygon (corners, 2), wound outward."""
    n = len(outline)
    area = 0.5 * float(
        np.sum(outline[:, 0] * np.roll(outline[:, 1], -1) - np.roll(outline[:, 0], -1) * outline[:, 1])
    )
    corners = outline if area > 0.0 else outline[::-1]
    back, front = (np.column_stack([corners, np.full(n, z + d)]) for d in (-half_depth, half_depth))
    k = np.arange(n)
    sides = np.stack([np.full(n, 4), k, (k + 1) % n, (k + 1) % n + n, k + n], axis=1).reshape(-1)
    faces = np.concatenate([[n], k[::-1], [n], k + n, sides])
    return pv.PolyData(np.concatenate([back, front]), faces)
