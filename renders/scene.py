"""The beam in three dimensions: one off-screen window whose meshes are moved from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import one_of
from renders.geometry import BeamGeometry
from renders.offscreen import prepare
from renders.scenery import pin, slope_wedge
from renders.themes import Theme

Array = NDArray[np.float64]

#: the window is drawn twice as large and reduced: smooth edges at a moderate price
SUPERSAMPLING = 2
GHOSTS = 3
_GHOST_STRENGTH = (0.36, 0.25, 0.15)
_TRACE_POINTS = 600
_ARROW = 0.16  # length of the largest force's arrow, over that of the beam
_CLOSE_ARROW = 0.36  # the same close to the contact point, over the height of the picture
_MARK = 3.0  # pixels: radius of the point of contact, in a picture of 720 pixels

#: where the camera looks from: direction of the eye, and the part of the height that text and colour bar need
CAMERAS = {
    "oblique": np.array([0.22, 0.30, 1.0]),
    "front": np.array([0.0, 0.0, 1.0]),
    "above": np.array([0.15, 0.9, 1.0]),
}


@dataclass(frozen=True)
class Look:
    """What a view shows besides beam, slope and pin."""

    quantity: str = "bending_stress"
    camera: str = "oblique"
    ghosts: bool = True
    trace: bool = True
    arrow: bool = True
    plain: bool = False  # beams in one colour each instead of a quantity

    def __post_init__(self) -> None:
        if self.camera not in CAMERAS:
            raise InputError(f"--camera {self.camera}: {one_of(self.camera, CAMERAS)}")


class Beam3D:
    """One beam in a window, with its ghosts and trace."""

    def __init__(
        self,
        plotter: pv.Plotter,
        geometry: BeamGeometry,
        theme: Theme,
        look: Look,
        limit: float,
        number: int,
    ) -> None:
        self.geometry, self.look = geometry, look
        self.colour = theme.series[number] if look.plain else theme.arrow
        colour = theme.series[number]
        # beams in one place are not to show through each other
        self._depth = -0.02 * number * geometry.radii.max()
        surface = geometry.surface(0)
        self.mesh = pv.PolyData(surface.points, geometry.faces)
        self.mesh.point_data["Normals"] = surface.normals
        self.mesh.point_data.active_normals_name = "Normals"
        options: dict[str, Any] = {"ambient": 0.38, "diffuse": 0.65, "specular": 0.06, "specular_power": 30.0}
        if look.plain:
            actor = plotter.add_mesh(self.mesh, color=colour, **options)
        else:
            self.mesh.point_data["shown"] = surface.arrays[look.quantity]
            options |= {"scalars": "shown", "cmap": theme.colour_map, "clim": (-limit, limit)}
            actor = plotter.add_mesh(self.mesh, show_scalar_bar=False, interpolate_before_map=True, **options)
        actor.prop.interpolation = "Phong"
        self._ghosts = [self._ghost(plotter, theme, n) for n in range(GHOSTS)] if look.ghosts else []
        self._trace = self._add_trace(plotter, theme, colour) if look.trace else None
        self.peak_force = _peak_force(geometry)

    def _ghost(self, plotter: pv.Plotter, theme: Theme, n: int) -> tuple[pv.PolyData, pv.Actor]:
        mesh = pv.PolyData(self.geometry.surface(0).points, self.geometry.faces)
        # mixed with the background instead of transparent, which would take half of the time of a frame
        actor = plotter.add_mesh(
            mesh, color=mixed(theme.ghost, theme.background, _GHOST_STRENGTH[n]), lighting=False
        )
        return mesh, actor

    def _add_trace(self, plotter: pv.Plotter, theme: Theme, colour: str) -> pv.PolyData:
        samples = np.unique(np.linspace(0, self.geometry.times.size - 1, _TRACE_POINTS).astype(int))
        self._trace_times = self.geometry.times[samples]
        path = np.array([self.geometry.contact_point(k) for k in samples])
        # in front of the beam, so that it is seen where it was
        depth = np.full((len(path), 1), 1.2 * self.geometry.radii.max() + self._depth)
        self._path = np.concatenate([path, depth], axis=1)
        mesh = pv.lines_from_points(self._path)
        plotter.add_mesh(
            mesh, color=colour if self.look.plain else theme.trace, line_width=2 * SUPERSAMPLING, lighting=False
        )
        return pv.PolyData(mesh)

    def move(self, time: float) -> None:
        """Take the shapes of a physical time (s)."""
        k = self.geometry.index(time)
        surface = self.geometry.surface(k)
        self.mesh.points = surface.points + np.array([0.0, 0.0, self._depth])
        self.mesh.point_data["Normals"] = surface.normals
        if not self.look.plain:
            self.mesh.point_data["shown"] = np.nan_to_num(surface.arrays[self.look.quantity])
        self._move_ghosts(time)
        if self._trace is not None:
            shown = self._path.copy()
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
                eye = CAMERAS[self.look.camera] / np.linalg.norm(CAMERAS[self.look.camera])
                mesh.points = surface.points - 4.0 * (n + 1) * self.geometry.radii.max() * eye

    def force_at(self, time: float) -> tuple[Array, Array] | None:
        """Return the point of contact on the slope (3,) and the force on the beam there over its peak (2,).

        None where there is no force.
        """
        k = self.geometry.index(time)
        force = contact_force(self.geometry, k) / self.peak_force
        if np.linalg.norm(force) < 1e-3:
            return None
        return contact_place(self.geometry, k), force


class View:
    """A window with beams, slope and pin, seen by a fixed camera or one that follows the contact point.

    Parameters
    ----------
    geometries : sequence of BeamGeometry
        All in one picture.
    size : tuple of int
        Width and height (pixels) of the picture.
    theme, look
        Colours, and what is shown.
    limit : float
        Largest value of the colour map.
    close : float, optional
        Follow the contact point with a picture so many diameters of the beam high.
    span : tuple, optional
        Times (s) of the positions that have to fit; default the whole run.
    room : tuple of float
        Pixels at the top for text, and at the bottom for the colour bar.
    """

    def __init__(
        self,
        geometries: Sequence[BeamGeometry],
        size: tuple[int, int],
        theme: Theme,
        look: Look,
        limit: float,
        close: float | None = None,
        span: tuple[float, float] | None = None,
        room: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        prepare()
        self.size, self._close, self._theme, self._look, self._room = size, close, theme, look, room
        window = [SUPERSAMPLING * n for n in size]
        self.plotter = pv.Plotter(off_screen=True, window_size=window, lighting="light kit")
        cast(Any, self.plotter).set_background(theme.background)
        # supersampling smooths the edges; VTK's own samples besides would cost ten times as much
        cast(Any, self.plotter.render_window).SetMultiSamples(0)
        self.beams = [
            Beam3D(self.plotter, geometry, theme, look, limit, n) for n, geometry in enumerate(geometries)
        ]
        wedge = slope_wedge(geometries[0])
        if wedge is not None:
            self._add_solid(wedge, theme.slope, theme.slope_edge)
        self._add_solid(pin(geometries[0]), theme.pin, None)
        self._aim(geometries, wedge, span)

    def _add_solid(self, mesh: pv.PolyData, colour: str, edge: str | None) -> None:
        self.plotter.add_mesh(mesh, color=colour, ambient=0.45, diffuse=0.6, specular=0.0)
        if edge:
            lines = mesh.extract_feature_edges(20.0)
            self.plotter.add_mesh(lines, color=edge, line_width=SUPERSAMPLING, lighting=False)

    def _aim(
        self, geometries: Sequence[BeamGeometry], wedge: pv.PolyData | None, span: tuple[float, float] | None
    ) -> None:
        """Place the camera so that everything of the runs fits between text and colour bar."""
        eye = CAMERAS[self._look.camera] / np.linalg.norm(CAMERAS[self._look.camera])
        right = np.cross([0.0, 1.0, 0.0], eye)
        right /= np.linalg.norm(right)
        up = np.cross(eye, right)
        self._eye, self._up, self._right = eye, up, right
        places = self._extent(geometries, wedge, span)
        across, high = places @ right, places @ up
        width, height = self.size
        top, bottom = (pixels + 0.03 * height for pixels in self._room)
        free = max(height - top - bottom, 0.25 * height)
        pixel = max(float(np.ptp(high)) / free, float(np.ptp(across)) / (0.93 * width))
        middle = (
            0.5 * (across.max() + across.min()),
            0.5 * (high.max() + high.min()) + 0.5 * (top - bottom) * pixel,
        )
        if self._close is not None:
            pixel = self._close * 2.0 * geometries[0].radii[-1] / height
        self._look_at(middle[0] * right + middle[1] * up)
        self.plotter.camera.parallel_projection = True
        self.plotter.camera.parallel_scale = 0.5 * pixel * height
        self._longest = self._arrow_length(geometries[0]) / pixel

    def _arrow_length(self, geometry: BeamGeometry) -> float:
        """Length (m) of the arrow of the largest force."""
        if self._close is not None:
            return float(_CLOSE_ARROW * self._close * 2.0 * geometry.radii[-1])
        return _ARROW * geometry.scenario.beam.length

    def _look_at(self, focus: Array) -> None:
        camera = self.plotter.camera
        camera.focal_point = focus
        camera.position = np.asarray(focus) + 10.0 * self._eye
        camera.up = self._up
        camera.clipping_range = (1.0, 30.0)

    def _extent(
        self, geometries: Sequence[BeamGeometry], wedge: pv.PolyData | None, span: tuple[float, float] | None
    ) -> Array:
        """Points that have to be seen: axes through the runs, pin and slope, arrows of the largest force."""
        found = [np.asarray(pin(geometries[0]).points)]
        if wedge is not None:
            found.append(np.asarray(wedge.points))
        for geometry in geometries:
            first, last = span or (geometry.times[0], geometry.times[-1])
            found += [geometry.centreline(geometry.index(t))[::8] for t in np.linspace(first, last, 60)]
            force = np.nan_to_num(geometry.history["lambda_n"].values)
            if self._look.arrow and force.max() > 0.0:
                k = int(np.argmax(force))
                along = np.append(contact_force(geometry, k), 0.0)
                tail = contact_place(geometry, k) - self._arrow_length(geometry) * along / np.linalg.norm(along)
                found.append(tail[None])
        return np.concatenate(found)

    def draw(self, time: float) -> Image.Image:
        """Return the picture of a physical time (s)."""
        for beam in self.beams:
            beam.move(time)
        if self._close is not None:
            geometry = self.beams[0].geometry
            angle = geometry.scenario.slope.angle
            normal = np.array([-np.sin(angle), np.cos(angle)])
            point = geometry.contact_point(geometry.index(time)) - 1.5 * geometry.radii[-1] * normal
            self._look_at(np.append(point, 0.0))
        self.plotter.render()
        picture = self.plotter.screenshot(return_img=True, transparent_background=False)
        drawn = Image.fromarray(np.asarray(picture)[..., :3])
        if self._look.arrow:
            for beam in self.beams:
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
        size = float(np.linalg.norm(force))
        # foreshortened like everything else that does not lie across the line of sight
        length = SUPERSAMPLING * self._longest * float(np.linalg.norm(along)) / np.sqrt(size)
        along /= np.linalg.norm(along)
        if length > 6.0 * unit:
            shape = arrow_outline(to - (_MARK + 2.5) * unit * along, along, length, unit)
            pen.polygon([tuple(p) for p in shape], fill=beam.colour)
            pen.line([tuple(p) for p in [*shape, shape[0]]], fill=self._theme.background, width=round(0.8 * unit))
        low, high = to - _MARK * unit, to + _MARK * unit
        pen.ellipse(
            (*low.tolist(), *high.tolist()),
            fill=self._theme.background,
            outline=self._theme.ink,
            width=round(unit),
        )

    def project(self, points: Array) -> Array:
        """Pixels (n, 2), from the left and from the top, at which points (n, 3) are drawn."""
        camera = self.plotter.camera
        offset = np.asarray(points) - np.asarray(camera.focal_point)
        unit = 0.5 * self.size[1] / camera.parallel_scale
        return np.stack(
            [0.5 * self.size[0] + unit * offset @ self._right, 0.5 * self.size[1] - unit * offset @ self._up],
            axis=1,
        )

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
    across = np.array([-along[1], along[0]])
    back = [
        (length, shaft),
        (head, shaft),
        (head, wide),
        (0.0, 0.0),
        (head, -wide),
        (head, -shaft),
        (length, -shaft),
    ]
    return np.array([tip - a * along + b * across for a, b in back])


def contact_place(geometry: BeamGeometry, k: float) -> Array:
    """Return where the beam touches the drawn slope (3,), one radius below the contact point on its axis."""
    angle = geometry.scenario.slope.angle
    normal = np.array([-np.sin(angle), np.cos(angle)])
    at = int(np.argmin(np.abs(geometry.places - geometry.scenario.contact.point)))
    return np.append(geometry.contact_point(k) - geometry.radii[at] * normal, 0.0)


def contact_force(geometry: BeamGeometry, k: float) -> Array:
    """Force (2,) of the slope on the beam in the inertial frame (N)."""
    return np.asarray(np.nan_to_num(sum(geometry.contact_forces(k))))


def _peak_force(geometry: BeamGeometry) -> float:
    """Largest contact force of the run (N), 1 if there is none."""
    normal, tangential = (np.nan_to_num(geometry.history[name].values) for name in ("lambda_n", "lambda_tau"))
    return float(np.hypot(normal, tangential).max()) or 1.0
