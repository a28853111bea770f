"""What stands still in a picture: the slope as a solid wedge, and the pin."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from renders.geometry import BeamGeometry
from renders.slope import DrawnSlope

Array = NDArray[np.float64]

#: half of the depth of wedge and pin, over the radius of the beam; over half of the width of a wide one
_DEPTH, _WIDER = 5.0, 1.3


def slope_wedge(geometry: BeamGeometry, slope: DrawnSlope) -> pv.PolyData:
    """Return the drawn slope as a solid."""
    return _prism(slope.outline, max(_DEPTH * geometry.touch_radius, _WIDER * geometry.half_width))


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
        for wide, low, high in ((1.6, -5.0, 1.6), (4.0, -6.5, -5.0))
    )
    cheeks = [_prism(cheek, 0.4 * r, z) for z in (-side - 0.9 * r, side + 0.9 * r)]
    whole = pv.merge([*cheeks, _prism(foot, max(_DEPTH * r, side + 1.4 * r)), bolt])
    return pv.PolyData(whole.extract_surface(algorithm="dataset_surface"))


def _prism(outline: Array, half_depth: float, z: float = 0.0) -> pv.PolyData:
    """Return a solid over a polygon (corners, 2), wound outward."""
    n, k = len(outline), np.arange(len(outline))
    area = np.sum(outline[:, 0] * np.roll(outline[:, 1], -1) - np.roll(outline[:, 0], -1) * outline[:, 1])
    corners = outline if area > 0.0 else outline[::-1]
    back, front = (np.column_stack([corners, np.full(n, z + d)]) for d in (-half_depth, half_depth))
    sides = np.stack([np.full(n, 4), k, (k + 1) % n, (k + 1) % n + n, k + n], axis=1).reshape(-1)
    return pv.PolyData(np.concatenate([back, front]), np.concatenate([[n], k[::-1], [n], k + n, sides]))
