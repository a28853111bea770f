"""One beam in a window: its tube, its earlier positions, and the path of its contact point."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv
from numpy.typing import NDArray

from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.shadow import Caster
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import TEXT, Style

Array = NDArray[np.float64]

#: the window is drawn twice as large and reduced: smooth edges at a moderate price
SUPERSAMPLING = 2
_GHOST_STRENGTH = (0.36, 0.25, 0.15)  # newest first
_TRACE_POINTS = 600

#: where the camera looks from: direction of the eye
CAMERAS = {
    "oblique": np.array([0.22, 0.30, 1.0]),
    "front": np.array([0.0, 0.0, 1.0]),
    "above": np.array([0.15, 0.9, 1.0]),
}


class Beam3D:
    """One beam in a window, with its ghosts and trace; `number` is its place among the beams of the window."""

    def __init__(
        self, plotter: pv.Plotter, geometry: BeamGeometry, story: Story, style: Style, number: int
    ) -> None:
        theme, self._eye = style.colours, CAMERAS[style.camera] / np.linalg.norm(CAMERAS[style.camera])
        self.geometry, self._shown = geometry, None if story.overlay else style.quantity
        self.colour = theme.series[number] if story.overlay else theme.arrow
        # beams in one place are not to show through each other
        self._depth = -0.02 * number * geometry.radii.max()
        self._shadow_radii = np.append(geometry.radii[:-1], max(geometry.radii[-1], geometry.mass_radius))[::2]
        points, normals = geometry.tube(0)
        self._mesh = pv.PolyData(points, geometry.faces)
        self._mesh.point_data["Normals"] = normals
        self._mesh.point_data.active_normals_name = "Normals"
        # the tube is closed: its far side is never seen
        options: dict[str, Any] = {
            "culling": "back",
            "ambient": 0.38,
            "diffuse": 0.65,
            "specular": 0.06,
            "specular_power": 30.0,
        }
        if self._shown:
            self._mesh.point_data["shown"] = geometry.result(self._shown, 0)
            limit = story.colours.limit
            options |= {
                "scalars": "shown",
                "cmap": theme.colour_map,
                "clim": (-limit, limit),
                "show_scalar_bar": False,
            }
            options["interpolate_before_map"] = True
        else:
            options["color"] = self.colour
        self._moving = [plotter.add_mesh(self._mesh, **options)]
        self._moving[0].prop.interpolation = "Phong"
        self._ghosts = []
        self.newest: int | None = None  # number of the latest of the earlier positions that the ghosts have
        for strength in _GHOST_STRENGTH if style.ghosts else ():
            ghost = pv.PolyData(points, geometry.faces)
            # mixed with the background instead of transparent, which would take half of the time of a frame
            colour = mixed(theme.ghost, theme.background, strength)
            self._ghosts.append((ghost, plotter.add_mesh(ghost, color=colour, lighting=False, culling="back")))
        self._trace = None
        if style.trace:
            colour = self.colour if story.overlay else theme.trace
            self._trace = self._path()
            line = plotter.add_mesh(self._trace, color=colour, line_width=2.0 * stroke(style), lighting=False)
            self._moving.append(line)
            self._whole = np.array(self._trace.points)

    def _path(self) -> pv.PolyData:
        """Path of the contact point, in front of the beam, so that it is seen where it was."""
        samples = np.unique(np.linspace(0, self.geometry.times.size - 1, _TRACE_POINTS).astype(int))
        self._trace_times = self.geometry.times[samples]
        depth = 1.2 * self.geometry.half_width + self._depth
        return pv.lines_from_points(np.array([[*self.geometry.contact_point(k), depth] for k in samples]))

    def move(self, time: float) -> None:
        """Take the shapes of a physical time (s)."""
        k = self.geometry.index(time)
        points, normals = self.geometry.tube(k)
        points[:, 2] += self._depth
        self._mesh.points = points
        self._mesh.point_data["Normals"] = normals
        if self._shown:
            self._mesh.point_data["shown"] = np.nan_to_num(self.geometry.result(self._shown, k))
        self._move_ghosts(time)
        if self._trace is not None:
            shown = self._whole.copy()
            shown[self._trace_times > time, :2] = self.geometry.contact_point(k)
            self._trace.points = shown

    def _move_ghosts(self, time: float) -> None:
        """Earlier positions at fixed instants, the last few of them."""
        times = self.geometry.times
        step = float(times[-1] - times[0]) / 12.0
        # a run that ends where it starts has no earlier positions
        newest = int(np.floor((time - times[0]) / step - 0.25)) if step > 0.0 else -1
        if newest == self.newest:
            return
        self.newest = newest
        for n, (mesh, _) in enumerate(self._ghosts):
            if newest - n >= 0:
                points, _ = self.geometry.tube(self.geometry.index(times[0] + (newest - n) * step))
                # away from the camera, where it covers nothing and is seen at the same place
                mesh.points = points - 4.0 * (n + 1) * self.geometry.radii.max() * self._eye
        self.show_ghosts(True)

    def show_ghosts(self, shown: bool) -> None:
        """Show the earlier positions, those that there are by now, or none."""
        for n, (_, actor) in enumerate(self._ghosts):
            actor.visibility = shown and self.newest is not None and self.newest >= n

    def show_moving(self, shown: bool) -> None:
        """Show the beam and the path of its contact point, or neither."""
        for actor in self._moving:
            actor.visibility = shown

    def moving_points(self) -> Array:
        """Points (n, 3) between which beam and path are drawn."""
        meshes = [self._mesh, *([self._trace] if self._trace else [])]
        return np.concatenate([np.asarray(mesh.points) for mesh in meshes])

    def caster(self, time: float) -> Caster:
        """Return what throws its shadow: every other ring of the drawn beam."""
        axis = self.geometry.centreline(self.geometry.index(time))[:, :2]
        return Caster(np.ascontiguousarray(axis[::2]), self._shadow_radii)

    def force_at(self, time: float) -> tuple[Array, Array] | None:
        """Return the point of contact on the slope (3,) and the force on the beam there over its peak (2,).

        None where there is no force.
        """
        k = self.geometry.index(time)
        force = contact_force(self.geometry, k)
        if np.linalg.norm(force) <= 1e-3 * self.geometry.peak_force:
            return None
        return self.geometry.contact_place(k), force / self.geometry.peak_force


def stroke(style: Style) -> float:
    """Width (pixels of the window) of a thin line, which goes with the letters."""
    return SUPERSAMPLING * max(1.0, style.resolution / 96.0 * style.letters / TEXT)


def mixed(colour: str, background: str, part: float) -> str:
    """Return a colour with so large a part of it over the background (#rrggbb)."""
    pairs = zip(*(bytes.fromhex(c[1:]) for c in (colour, background)), strict=True)
    return "#" + "".join(f"{round(part * a + (1.0 - part) * b):02x}" for a, b in pairs)


def contact_force(geometry: BeamGeometry, k: float) -> Array:
    """Force (2,) of the slope on the beam in the inertial frame (N)."""
    return np.asarray(np.nan_to_num(sum(geometry.contact_forces(k))))
