"""What stands still in a picture: the slope as a solid wedge, and the pin."""

from __future__ import annotations

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from renders.geometry import BeamGeometry

Array = NDArray[np.float64]

#: half of the depth of wedge and pin, over the radius of the beam
_DEPTH = 5.0


def slope_wedge(geometry: BeamGeometry) -> pv.PolyData | None:
    """Return the slope as a solid whose surface lies one beam radius below the line that the axis touches.

    It reaches as far as the contact point comes near; None if contact is switched off.
    """
    scenario = geometry.scenario
    if not scenario.contact.enabled:
        return None
    first, last = _extent(geometry)
    length, radius = scenario.beam.length, float(geometry.radii[-1])
    s, c = np.sin(scenario.slope.angle), np.cos(scenario.slope.angle)
    top = np.array([first, last])[:, None] * (c, s) + np.array(scenario.slope.origin) - radius * np.array((-s, c))
    foot = min(top[:, 1]) - 0.06 * length
    outline = np.array([top[0], top[1], (top[1, 0], foot), (top[0, 0], foot)])
    return _prism(outline, _DEPTH * radius)


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


def _extent(geometry: BeamGeometry) -> tuple[float, float]:
    """Stretch of the slope (m, along it) next to which the contact point comes, with some room."""
    length = geometry.scenario.beam.length
    gap, slip = (np.asarray(geometry.history[name].values) for name in ("gap", "slip"))
    near = slip[gap <= max(float(gap.min()), 0.0) + 0.02 * length]
    return float(near.min()) - 0.12 * length, float(near.max()) + 0.12 * length


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
