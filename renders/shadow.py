"""Soft shadows of a beam: strips of mesh on the ground and on the slope, darkest below the axis.

VTK's own shadow maps have hard edges and take longer than all the rest of a frame in software OpenGL.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pyvista as pv

from oblique_impact.renders.geometry import BeamGeometry

if TYPE_CHECKING:
    from oblique_impact.renders.scene import View

_STRENGTH = 0.36  # part of the light that a beam in contact takes away
_SPREAD = 0.12  # growth of the half width of a shadow over the height of the beam
_PROFILE = np.array([0.0, 0.12, 0.5, 0.88, 1.0, 0.88, 0.5, 0.12, 0.0])  # of the darkness across the strip
_REACH = 1.8  # half width of the strip, over that of the shadow
_LIFT = 0.05  # over the radius: how far the strip lies above its plane, so that it is not hidden by it


class Plane(NamedTuple):
    """A plane across the plane of motion between two places (m)."""

    start: tuple[float, float]
    end: tuple[float, float]


class Shadow:
    """The shadow of a beam on a plane under light from above, at the time to which it is moved."""

    def __init__(self, view: View, geometry: BeamGeometry, plane: Plane, number: int) -> None:
        self._geometry, self._plane = geometry, plane
        self._lift = _LIFT * (number + 1) * geometry.touch_radius  # shadows of several beams are not in one plane
        count, wide = geometry.places.size, _PROFILE.size
        point = np.arange(count * wide).reshape(count, wide)
        corners: Any = np.stack([point[:-1, :-1], point[1:, :-1], point[1:, 1:], point[:-1, 1:]], axis=-1).reshape(
            -1, 4
        )
        self._mesh = pv.PolyData.from_regular_faces(np.zeros((count * wide, 3)), corners)
        self._mesh.point_data["tone"] = np.zeros((count * wide, 4), np.uint8)
        self._actor = view.add(self._mesh, scalars="tone", rgba=True, lighting=False)
        # it is blended all the same; VTK's pass for translucent things would take half of the time of a frame
        self._actor.ForceOpaqueOn()

    def move(self, k: float) -> None:
        """Fall from the beam at the fractional sample k."""
        (x0, y0), (x1, y1) = self._plane
        geometry, slope = self._geometry, (y1 - y0) / (x1 - x0) if x1 != x0 else np.inf
        axis = geometry.centreline(k)[:, :2]
        self._actor.visibility = bool(np.all(np.isfinite(axis)) and abs(slope) < 10.0)
        if not self._actor.visibility:
            return
        x = np.clip(axis[:, 0], min(x0, x1), max(x0, x1))  # what lies beyond the plane is a strip of no area
        y = y0 + (x - x0) * slope
        height = np.maximum(axis[:, 1] - y, 0.0)
        half = geometry.radii + _SPREAD * height
        from_ends = np.minimum(geometry.places, geometry.places[-1] - geometry.places)
        dark = np.where(axis[:, 1] > y, _STRENGTH * geometry.radii / half, 0.0) * np.minimum(from_ends / half, 1.0)
        points = np.empty((x.size, _PROFILE.size, 3))
        points[..., 0], points[..., 1] = x[:, None], y[:, None] + self._lift
        points[..., 2] = np.outer(_REACH * half, np.linspace(-1.0, 1.0, _PROFILE.size))
        self._mesh.points = points.reshape(-1, 3)
        tone = np.zeros((x.size * _PROFILE.size, 4), np.uint8)
        tone[:, 3] = np.round(255.0 * np.outer(dark, _PROFILE)).ravel()
        self._mesh.point_data["tone"] = tone
