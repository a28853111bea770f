"""Soft shadows of a beam: strips of mesh on the ground and on the slope, darkest below the axis.

VTK's own shadow maps have hard edges and take longer than all the rest of a frame in software OpenGL.
"""

from __future__ import annotations

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from oblique_impact.renders.geometry import BeamGeometry

_STRENGTH = 0.36  # part of the light that a beam in contact takes away
_SPREAD = 0.12  # growth of the half width of a shadow over the height of the beam
_PROFILE = np.array([0.0, 0.12, 0.5, 0.88, 1.0, 0.88, 0.5, 0.12, 0.0])  # of the darkness across the strip
_REACH = 1.8  # half width of the strip, over that of the shadow
_LIFT = 0.05  # over the radius: how far the strip lies above its plane, so that it is not hidden by it


class Shadow:
    """The shadow of a beam under light from above: a `mesh` with colours and opacity in the array "tone".

    It falls on the plane across the plane of motion through the `ends` (2, 2) of a line (m).  The shadows of
    several beams, by their `number` from 0, do not lie in one plane.
    """

    def __init__(self, geometry: BeamGeometry, ends: NDArray[np.float64], number: int) -> None:
        self._geometry, self._ends = geometry, ends
        self._lift = _LIFT * (number + 1) * geometry.touch_radius
        # points along the beam, row by row across the strip
        self.mesh = pv.Plane(i_resolution=geometry.stations.size - 1, j_resolution=_PROFILE.size - 1)
        self.mesh.clear_data()
        self._tone = np.zeros((self.mesh.n_points, 4), np.uint8)
        self.mesh.point_data["tone"] = self._tone

    def move(self, k: float) -> bool:
        """Fall from the beam at the fractional sample k; returns whether there is a shadow."""
        geometry, ((x0, y0), (x1, y1)) = self._geometry, self._ends
        axis = geometry.centreline(k)
        if not np.all(np.isfinite(axis)) or abs(y1 - y0) >= 10.0 * abs(x1 - x0):  # a plane that is almost upright
            return False
        x = np.clip(axis[:, 0], min(x0, x1), max(x0, x1))  # what lies beyond the plane is a strip of no area
        y = y0 + (x - x0) * (y1 - y0) / (x1 - x0)
        height = np.maximum(axis[:, 1] - y, 0.0)
        half = geometry.radii + _SPREAD * height
        from_ends = np.minimum(geometry.stations, geometry.stations[-1] - geometry.stations)
        dark = np.where(axis[:, 1] > y, _STRENGTH * geometry.radii / half, 0.0) * np.minimum(from_ends / half, 1.0)
        z = np.outer(np.linspace(-1.0, 1.0, _PROFILE.size), _REACH * half)
        self.mesh.points = np.stack(np.broadcast_arrays(x, y + self._lift, z), axis=-1).reshape(-1, 3)
        self._tone[:, 3] = np.round(255.0 * np.outer(_PROFILE, dark)).ravel()
        self.mesh.point_data["tone"] = self._tone
        return True
