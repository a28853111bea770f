"""The beam in three dimensions: one off-screen window whose meshes are moved from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from renders.geometry import BeamGeometry
from renders.offscreen import prepare
from renders.scenery import pin, slope_wedge
from renders.story import Story
from renders.style import COLOUR_MAP, Style

Array = NDArray[np.float64]

#: the window is drawn twice as large and reduced: smooth edges at a moderate price
SUPERSAMPLING = 2
_GHOST_STRENGTH = (0.36, 0.25, 0.15)  # newest first
_TRACE_POINTS = 600
_ARROW = 0.16  # length of the largest force's arrow, over that of the beam
_CLOSE = 12.0  # height of a picture close to the contact point, over the radius of the beam there
_CLOSE_ARROW = 0.36  # length of the largest force's arrow there, over that height
_MARK = 3.0  # pixels: radius of the point of contact, in a picture of 720 pixels

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
        surface = geometry.surface(0)
        self._mesh = pv.PolyData(surface.points, geometry.faces)
        self._mesh.point_data["Normals"] = surface.normals
        self._mesh.point_data.active_normals_name = "Normals"
        options: dict[str, Any] = {"ambient": 0.38, "diffuse": 0.65, "specular": 0.06, "specular_power": 30.0}
        if self._shown:
            self._mesh.point_data["shown"] = surface.arrays[self._shown]
            limit = story.colours.limit
            options |= {"scalars": "shown", "cmap": COLOUR_MAP, "clim": (-limit, limit), "show_scalar_bar": False}
            options["interpolate_before_map"] = True
        else:
            options["color"] = self.colour
        plotter.add_mesh(self._mesh, **options).prop.interpolation = "Phong"
        self._ghosts = []
        for strength in _GHOST_STRENGTH if style.ghosts else ():
            ghost = pv.PolyData(surface.points, geometry.faces)
            # mixed with the background instead of transparent, which would take half of the time of a frame
            colour = mixed(theme.ghost, theme.background, strength)
            self._ghosts.append((ghost, plotter.add_mesh(ghost, color=colour, lighting=False)))
        self._trace = None
        if style.trace:
            colour = self.colour if story.overlay else theme.trace
            self._trace = self._path()
            plotter.add_mesh(self._trace, color=colour, line_width=2 * SUPERSAMPLING, lighting=False)
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
        surface = self.geometry.surface(k)
        self._mesh.points = surface.points + np.array([0.0, 0.0, self._depth])
        self._mesh.point_data["Normals"] = surface.normals
        if self._shown:
            self._mesh.point_data["shown"] = np.nan_to_num(surface.arrays[self._shown])
        self._move_ghosts(time)
        if self._trace is not None:
            shown = self._whole.copy()
            shown[self._trace_times > time, :2] = self.geometry.contact_point(k)
            self._trace.points = shown

    def _move_ghosts(self, time: float) -> None:
        """Earlier positions at fixed instants, the last few of them."""
        times = self.geometry.times
        step = float(times[-1] - times[0]) / 12.0
        newest = int(np.floor((time - times[0]) / step - 0.25))
        for n, (mesh, actor) in enumerate(self._ghosts):
            instant = newest - n
            actor.visibility = instant >= 0
            if instant >= 0:
                surface = self.geometry.surface(self.geometry.index(times[0] + instant * step))
                # away from the camera, where it covers nothing and is seen at the same place
                mesh.points = surface.points - 4.0 * (n + 1) * self.geometry.radii.max() * self._eye

    def force_at(self, time: float) -> tuple[Array, Array] | None:
        """Return the point of contact on the slope (3,) and the force on the beam there over its peak (2,).

        None where there is no force.
        """
        k = self.geometry.index(time)
        force = contact_force(self.geometry, k)
        if np.linalg.norm(force) <= 1e-3 * self.geometry.peak_force:
            return None
        return self.geometry.contact_place(k), force / self.geometry.peak_force


class View:
    """A window with beams, slope and pin, seen by a fixed camera or, `close`, one that follows the contact point.

    It shows the runs of these `numbers` in a picture of some size (pixels), in the style of the story if no other
    is given.  The positions in the `span` of time (s; default the whole run) fit, with `room` (pixels) for text at
    the top and for the colour bar at the bottom.
    """

    def __init__(
        self,
        story: Story,
        numbers: Sequence[int],
        size: tuple[int, int],
        *,
        style: Style | None = None,
        close: bool = False,
        span: tuple[float, float] | None = None,
        room: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        prepare()
        self.size, self._close, self._room = size, close, room
        self._style = style or story.style
        self._theme = self._style.colours
        self.plotter = pv.Plotter(
            off_screen=True, window_size=[SUPERSAMPLING * n for n in size], lighting="light kit"
        )
        cast(Any, self.plotter).set_background(self._theme.background)
        # supersampling smooths the edges; VTK's own samples besides would cost ten times as much
        cast(Any, self.plotter.render_window).SetMultiSamples(0)
        shown = [story.geometries[n].true if close else story.geometries[n] for n in numbers]
        self._beams = [Beam3D(self.plotter, g, story, self._style, n) for n, g in enumerate(shown)]
        solids = [pin(shown[0])]
        self.plotter.add_mesh(solids[0], color=self._theme.pin, ambient=0.45, diffuse=0.6, specular=0.0)
        if story.slope:
            solids.append(slope_wedge(shown[0], story.slope))
            self.plotter.add_mesh(solids[1], color=self._theme.slope, ambient=0.45, diffuse=0.6, specular=0.0)
            edges = solids[1].extract_feature_edges(20.0)
            self.plotter.add_mesh(edges, color=self._theme.slope_edge, line_width=SUPERSAMPLING, lighting=False)
        self._aim(solids, span)

    def _aim(self, solids: Sequence[pv.PolyData], span: tuple[float, float] | None) -> None:
        """Place the camera so that everything of the runs fits between text and colour bar."""
        eye = CAMERAS[self._style.camera] / np.linalg.norm(CAMERAS[self._style.camera])
        right = np.cross([0.0, 1.0, 0.0], eye)
        right /= np.linalg.norm(right)
        up = np.cross(eye, right)
        self._eye, self._up, self._right = eye, up, right
        geometry, (width, height) = self._beams[0].geometry, self.size
        if self._close:
            focus, pixel = np.zeros(3), _CLOSE * geometry.touch_radius / height
            self._longest = _CLOSE_ARROW * height
        else:
            places = self._extent(solids, span)
            across, high = places @ right, places @ up
            top, bottom = (pixels + 0.03 * height for pixels in self._room)
            free = max(height - top - bottom, 0.25 * height)
            pixel = max(float(np.ptp(high)) / free, float(np.ptp(across)) / (0.93 * width))
            middle = 0.5 * (high.max() + high.min()) + 0.5 * (top - bottom) * pixel
            focus = 0.5 * (across.max() + across.min()) * right + middle * up
            self._longest = _ARROW * geometry.scenario.beam.length / pixel
        self.plotter.camera.parallel_projection = True
        self.plotter.camera.parallel_scale = 0.5 * pixel * height
        self._look_at(focus)

    def _look_at(self, focus: Array) -> None:
        camera = self.plotter.camera
        camera.focal_point = focus
        camera.position = np.asarray(focus) + 10.0 * self._eye
        camera.up = self._up
        camera.clipping_range = (1.0, 30.0)

    def _extent(self, solids: Sequence[pv.PolyData], span: tuple[float, float] | None) -> Array:
        """Points that have to be seen: axes through the runs, pin and slope, arrows of the largest force."""
        found = [np.asarray(solid.points) for solid in solids]
        for geometry in (beam.geometry for beam in self._beams):
            first, last = span or (geometry.times[0], geometry.times[-1])
            found += [geometry.centreline(geometry.index(t))[::8] for t in np.linspace(first, last, 60)]
            k = int(np.argmax(np.nan_to_num(geometry.history["lambda_n"].values)))
            force = np.append(contact_force(geometry, k), 0.0)
            if self._style.arrow and np.any(force):
                length = _ARROW * geometry.scenario.beam.length
                found.append(geometry.contact_place(k)[None] - length * force / np.linalg.norm(force))
        return np.concatenate(found)

    def draw(self, time: float) -> Image.Image:
        """Return the picture of a physical time (s)."""
        for beam in self._beams:
            beam.move(time)
        if self._close:
            geometry = self._beams[0].geometry
            point = geometry.contact_point(geometry.index(time))
            self._look_at(np.append(point - 1.5 * geometry.touch_radius * geometry.slope_axes[1], 0.0))
        self.plotter.render()
        picture = self.plotter.screenshot(return_img=True, transparent_background=False)
        drawn = Image.fromarray(np.asarray(picture)[..., :3])
        for beam in self._beams if self._style.arrow else ():
            self._draw_force(ImageDraw.Draw(drawn), beam, time)
        return drawn.reduce(SUPERSAMPLING)

    def _draw_force(self, pen: ImageDraw.ImageDraw, beam: Beam3D, time: float) -> None:
        """Mark the point of contact; the arrow of the force ends just before it, outside of the beam."""
        found = beam.force_at(time)
        if found is None:
            return
        place, force = found
        unit = SUPERSAMPLING * max(1.0, min(self.size[1] / 480.0, 3.0))
        to = SUPERSAMPLING * self.project(place[None])[0]
        along = np.array([force @ self._right[:2], -force @ self._up[:2]])
        # foreshortened like everything else that does not lie across the line of sight
        length = SUPERSAMPLING * self._longest * float(np.linalg.norm(along) / np.sqrt(np.linalg.norm(force)))
        along /= np.linalg.norm(along)
        if length > 6.0 * unit:
            shape = arrow_outline(to - (_MARK + 2.5) * unit * along, along, length, unit)
            corners = [tuple(p) for p in [*shape, shape[0]]]
            pen.polygon(corners, fill=beam.colour)
            pen.line(corners, fill=self._theme.background, width=round(0.8 * unit))
        box = (*(to - _MARK * unit).tolist(), *(to + _MARK * unit).tolist())
        pen.ellipse(box, fill=self._theme.background, outline=self._theme.ink, width=round(unit))

    def project(self, points: Array) -> Array:
        """Pixels (n, 2), from the left and from the top, at which points (n, 3) are drawn."""
        camera = self.plotter.camera
        offset = (np.asarray(points) - np.asarray(camera.focal_point)) * 0.5 * self.size[1] / camera.parallel_scale
        across, up = offset @ self._right, offset @ self._up
        return np.stack([0.5 * self.size[0] + across, 0.5 * self.size[1] - up], axis=1)

    def close(self) -> None:
        """Free the window."""
        self.plotter.close()


def mixed(colour: str, background: str, part: float) -> str:
    """Return a colour with so large a part of it over the background (#rrggbb)."""
    pairs = zip(*(bytes.fromhex(c[1:]) for c in (colour, background)), strict=True)
    return "#" + "".join(f"{round(part * a + (1.0 - part) * b):02x}" for a, b in pairs)


def arrow_outline(tip: Array, along: Array, length: float, unit: float) -> Array:
    """Return the corners (7, 2) of an arrow in pixels, of a length with its head; `along` is its direction."""
    head = min(13.0 * unit, 0.6 * length)
    shaft, wide = min(2.0 * unit, 0.18 * head), 0.42 * head
    back = np.array([length, head, head, 0.0, head, head, length])[:, None]
    aside = np.array([shaft, shaft, wide, 0.0, -wide, -shaft, -shaft])[:, None]
    return np.asarray(tip - back * along + aside * np.array([-along[1], along[0]]))


def contact_force(geometry: BeamGeometry, k: float) -> Array:
    """Force (2,) of the slope on the beam in the inertial frame (N)."""
    return np.asarray(np.nan_to_num(sum(geometry.contact_forces(k))))
