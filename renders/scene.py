"""The beam in three dimensions: one PyVista window, in which each picture of a frame is a renderer of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from PIL import Image

from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.layout import Box
from oblique_impact.renders.offscreen import prepare
from oblique_impact.renders.scale_bar import ScaleBar, scale_bar
from oblique_impact.renders.scenery import pin, slab, slope_wedge, stand
from oblique_impact.renders.shadow import Plane, Shadow
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import TEXT, Style

Array = NDArray[np.float64]

#: The window is drawn twice as large and averaged: in software OpenGL VTK's multi-samples take twice as long for
#: edges that are no smoother, its supersampling (SSAA) six times as long.
SUPERSAMPLING = 2
#: direction from the scene to the eye
CAMERAS = {
    "oblique": np.array([0.22, 0.30, 1.0]),
    "front": np.array([0.0, 0.0, 1.0]),
    "above": np.array([0.15, 0.9, 1.0]),
}
_GHOSTS = (0.36, 0.25, 0.15)  # how much earlier positions differ from the background, newest first
_TRACE_POINTS = 600
_ARROW = 0.16  # length of the largest force's arrow, over that of the beam
_CLOSE = 12.0  # height of a picture close to the contact point, over the radius of the beam there
_CLOSE_ARROW = 0.36  # length of the largest force's arrow there, over that height
_IN_FRONT = -1e6  # units of depth by which arrow and contact point are drawn in front of the slope
_BEAM = {"ambient": 0.38, "diffuse": 0.65, "specular": 0.06, "specular_power": 30.0}
_SOLID = {"ambient": 0.45, "diffuse": 0.6, "specular": 0.0}


class Panel(NamedTuple):
    """One picture of a frame: where it is in the window, which runs it shows, and how.

    Attributes
    ----------
    box : tuple of int
        Left, top, width, height (pixels).
    runs : sequence of int
        Numbers of the runs.
    close : bool
        Whether the camera follows the contact point, without magnification.
    """

    box: Box
    runs: Sequence[int]
    close: bool = False


class Scene:
    """A window of some size (pixels) with panels; `draw` returns its picture at a time.

    Positions in the `span` of times (s; default the whole run) fit into the panels.  With `interactive` the window
    is shown on the screen, by `plotter.show`, at its plain size.
    """

    def __init__(
        self,
        story: Story,
        panels: Sequence[Panel],
        size: tuple[int, int],
        style: Style | None = None,
        span: tuple[float, float] | None = None,
        **interactive: Any,
    ) -> None:
        prepare()
        style = style or story.style
        scale = 1 if interactive else SUPERSAMPLING
        window: dict[str, Any] = {"off_screen": not interactive, **interactive}
        window["window_size"] = [scale * pixels for pixels in size]
        self.plotter = cast(Any, pv.Plotter(shape=(1, len(panels)), border=False, lighting="light kit", **window))
        if not interactive:
            self.plotter.render_window.SetMultiSamples(0)
        self.views = []
        for number, panel in enumerate(panels):
            self.plotter.subplot(0, number)
            left, top, width, height = panel.box
            bottom = size[1] - top - height
            self.plotter.renderer.SetViewport(
                left / size[0], bottom / size[1], (left + width) / size[0], (bottom + height) / size[1]
            )
            self.views.append(View(self.plotter, story, panel, style, scale, span))

    def draw(self, time: float) -> NDArray[np.uint8]:
        """Return the picture (rows, columns, 3) of a physical time (s)."""
        for view in self.views:
            view.move(time)
        self.plotter.render()
        large = Image.fromarray(np.asarray(self.plotter.screenshot(return_img=True)))
        return np.asarray(large.reduce(SUPERSAMPLING))

    def close(self) -> None:
        """Free the window."""
        self.plotter.close()


class View:
    """What the active renderer of a plotter shows: beams, slope, pin and ground."""

    def __init__(
        self,
        plotter: Any,
        story: Story,
        panel: Panel,
        style: Style,
        scale: int,
        span: tuple[float, float] | None = None,
    ) -> None:
        self._plotter, self._panel, self._style = plotter, panel, style
        self._theme, self._renderer = style.colours, plotter.renderer
        plotter.set_background(self._theme.background, all_renderers=False)
        self._stroke = scale * max(1.0, style.resolution / 96.0 * style.letters / TEXT)
        shown = [story.geometries[n].true if panel.close else story.geometries[n] for n in panel.runs]
        solids, planes = self._add_scenery(shown[0], story)
        self._aim(shown, solids, span)
        self.beams = []
        for number, geometry in zip(panel.runs, shown, strict=True):
            self.beams.append(_Beam(self, geometry, story, number, planes))

    @property
    def eye(self) -> Array:
        """Unit vector (3,) from the scene to the eye."""
        direction = CAMERAS[self._style.camera]
        return np.asarray(direction / np.linalg.norm(direction))

    @property
    def _across(self) -> tuple[Array, Array]:
        """Unit vectors (3,) to the right and upward in the picture."""
        right = np.cross([0.0, 1.0, 0.0], self.eye)
        right /= np.linalg.norm(right)
        return right, np.cross(self.eye, right)

    def add(self, mesh: pv.PolyData, **look: Any) -> Any:
        """Add a mesh; lines are as thick as the letters want."""
        return self._plotter.add_mesh(mesh, line_width=look.pop("width", 1.0) * self._stroke, **look)

    def _add_scenery(self, geometry: BeamGeometry, story: Story) -> tuple[list[pv.PolyData], list[Plane]]:
        """Add pin, slope and ground; returns the solids, and the planes on which shadows fall."""
        theme, slope = self._theme, story.slope
        ground = story.ground if self._style.ground else None
        solids, planes = [pin(geometry)], []
        self.add(solids[0], color=theme.pin, **_SOLID)
        if slope:
            solids.append(slope_wedge(geometry, slope))
        if ground:
            solids += [block for block in (stand(solid, ground) for solid in solids) if block]
        for solid in solids[1:]:
            self._add_block(solid, theme.slope, theme.slope_edge)
        if ground:
            solids.append(slab(ground))
            self._add_block(solids[-1], theme.ground, theme.line)
            planes.append(Plane((ground.first, ground.y), (ground.last, ground.y)))
            if slope:
                planes.append(Plane(*map(tuple, slope.outline[:2])))
        return solids, planes

    def _add_block(self, solid: pv.PolyData, colour: str, edge: str) -> None:
        lit = solid.compute_normals(point_normals=False)  # else the faces are lit by normals with rounding errors
        self.add(lit, color=colour, culling="back", **_SOLID)
        self.add(solid.extract_feature_edges(20.0), color=edge, lighting=False)

    # Camera ---------------------------------------------------------------------------------------------------

    def _aim(self, shown: list[BeamGeometry], solids: list[pv.PolyData], span: tuple[float, float] | None) -> None:
        """Place the camera so that everything of the runs fits into the panel."""
        geometry, (_, _, width, height) = shown[0], self._panel.box
        right, up = self._across
        focus = np.zeros(3)
        if self._panel.close:
            self.pixel = _CLOSE * geometry.touch_radius / height
            self.longest_arrow = _CLOSE_ARROW * height * self.pixel
        else:
            places = self._places(shown, solids, span)
            across, high = places @ right, places @ up
            self.pixel = max(float(np.ptp(high)) / (0.94 * height), float(np.ptp(across)) / (0.93 * width))
            focus = 0.5 * ((across.max() + across.min()) * right + (high.max() + high.min()) * up)
            self.longest_arrow = _ARROW * geometry.scenario.beam.length
        camera = self._renderer.camera
        camera.parallel_projection = True
        camera.parallel_scale = 0.5 * self.pixel * height
        self._renderer.camera_set = True  # else the first picture would be from PyVista's own place
        self.look_at(focus)

    def look_at(self, focus: Array) -> None:
        """Turn the camera to a place (3,)."""
        camera = self._renderer.camera
        camera.SetFocalPoint(*focus)
        camera.SetPosition(*(np.asarray(focus) + 10.0 * self.eye))
        camera.SetViewUp(*self._across[1])
        camera.SetClippingRange(1.0, 30.0)

    def _places(
        self, shown: list[BeamGeometry], solids: list[pv.PolyData], span: tuple[float, float] | None
    ) -> Array:
        """Points (n, 3) that have to be seen: axes through the runs, solids, arrows of the largest force."""
        found = [np.asarray(solid.points) for solid in solids]
        for geometry in shown:
            first, last = span or (geometry.times[0], geometry.times[-1])
            found += [geometry.centreline(geometry.index(t))[::8] for t in np.linspace(first, last, 60)]
            k = int(np.argmax(np.nan_to_num(geometry.history["lambda_n"].values)))
            force = geometry.contact_force(k)
            if self._style.arrow and np.any(force):
                length = _ARROW * geometry.scenario.beam.length
                found.append(geometry.contact_place(k)[None] - length * force / np.linalg.norm(force))
        return np.concatenate(found)

    def scale_bar(self, longest: float) -> ScaleBar:
        """Return a bar of a round length, level in the plane of motion, not longer than some pixels."""
        right, up = self._across
        return scale_bar(np.array([right[0], -up[0]]) / self.pixel, longest)

    def move(self, time: float) -> None:
        """Show a physical time (s)."""
        for beam in self.beams:
            beam.move(time)
        if self._panel.close:
            geometry = self.beams[0].geometry
            below = np.append(0.5 * geometry.touch_radius * geometry.slope_axes[1], 0.0)
            self.look_at(geometry.contact_place(geometry.index(time)) - below)


class _Beam:
    """One beam in a view: its tube, earlier positions, the path of its contact point, the force, shadows."""

    def __init__(self, view: View, geometry: BeamGeometry, story: Story, number: int, planes: list[Plane]) -> None:
        style, theme = view._style, view._theme
        self.geometry, self._view = geometry, view
        self._quantity = None if story.overlay else style.quantity
        colour = theme.series[number] if story.overlay else theme.arrow
        # beams in one place are not to show through each other
        self._depth = -0.02 * number * float(geometry.radii.max())
        self.mesh = pv.PolyData(geometry.tube(0)[0], geometry.solid.faces)
        look: dict[str, Any] = {"color": colour}
        if self._quantity:
            self._size = story.colours.unit[0]
            limit = story.colours.limit / self._size
            self.mesh.point_data["shown"] = geometry.result(self._quantity, 0)
            look = {"scalars": "shown", "cmap": theme.colour_map, "clim": (-limit, limit)}
        self._place(0.0)
        self.actor = view.add(self.mesh, culling="back", show_scalar_bar=False, **look, **_BEAM)
        self.actor.prop.interpolation = "Phong"
        self._shadows = [Shadow(view, geometry, plane, number) for plane in planes]
        self._ghosts, self._newest = [], -1
        for strength in _GHOSTS if style.ghosts and not view._panel.close else ():
            mesh = pv.PolyData(self.mesh.points, geometry.solid.faces)
            # an opaque mixture with the background: transparent beams would take half of the time of a frame
            mixture = mixed(theme.ghost, theme.background, strength)
            self._ghosts.append((mesh, view.add(mesh, color=mixture, lighting=False, culling="back")))
        self._trace = self._path() if style.trace else None
        if self._trace:
            self._whole = np.array(self._trace.points)
            colour_of_path = colour if story.overlay else theme.trace
            view.add(self._trace, color=colour_of_path, width=2.0, lighting=False)
        self._arrow, self._marks = pv.Arrow(), [pv.PolyData(np.zeros((1, 3))) for _ in range(2)]
        self._force: list[Any] = []
        if style.arrow:
            self._force.append(view.add(self._arrow, color=colour, ambient=0.6, diffuse=0.5))
            for mark, ink, size in zip(self._marks, (theme.ink, theme.background), (8.0, 5.5), strict=True):
                point = {"render_points_as_spheres": True, "point_size": size * view._stroke}
                self._force.append(view.add(mark, color=ink, lighting=False, **point))
        for depth, actor in enumerate(self._force, start=1):
            actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
            actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.0, depth * _IN_FRONT)
            actor.mapper.SetRelativeCoincidentTopologyPointOffsetParameter(depth * _IN_FRONT)

    def move(self, time: float) -> None:
        """Take shapes, results and force of a physical time (s)."""
        k = self.geometry.index(time)
        self._place(k)
        if self._quantity:
            self.mesh.point_data["shown"] = np.nan_to_num(self.geometry.result(self._quantity, k)) / self._size
        for shadow in self._shadows:
            shadow.move(k)
        self._move_ghosts(time)
        self._point_force(k)
        if self._trace:
            shown = self._whole.copy()
            shown[self._trace_times > time, :2] = self.geometry.contact_point(k)
            self._trace.points = shown

    def _place(self, k: float) -> None:
        points, normals = self.geometry.tube(k)
        points[:, 2] += self._depth
        self.mesh.points = points
        self.mesh.point_data["Normals"] = normals
        self.mesh.point_data.active_normals_name = "Normals"

    def _path(self) -> pv.PolyData:
        """Path of the contact point, in front of the beam, so that it is seen where it was."""
        samples = np.unique(np.linspace(0, self.geometry.times.size - 1, _TRACE_POINTS).astype(int))
        self._trace_times = self.geometry.times[samples]
        depth = 1.2 * self.geometry.half_width + self._depth
        return pv.lines_from_points(np.array([[*self.geometry.contact_point(k), depth] for k in samples]))

    def _move_ghosts(self, time: float) -> None:
        """Earlier positions at fixed instants, the last few of them."""
        times = self.geometry.times
        step = float(times[-1] - times[0]) / 12.0
        # a run that ends where it starts has no earlier positions
        newest = int(np.floor((time - times[0]) / step - 0.25)) if step > 0.0 else -1
        for n, (mesh, actor) in enumerate(self._ghosts):
            actor.visibility = newest - n >= 0
            if actor.visibility and newest != self._newest:
                points, _ = self.geometry.tube(self.geometry.index(times[0] + (newest - n) * step))
                # away from the eye, where it covers nothing and is seen at the same place
                mesh.points = points - 4.0 * (n + 1) * self.geometry.radii.max() * self._view.eye
        self._newest = newest

    def _point_force(self, k: float) -> None:
        """Let the arrow end just before the point of contact; its length grows with the root of the force."""
        force, peak = self.geometry.contact_force(k), self.geometry.peak_force
        size = float(np.linalg.norm(force))
        for actor in self._force:
            actor.visibility = size > 1e-3 * peak
        if not self._force or not size > 1e-3 * peak:
            return
        place, along = self.geometry.contact_place(k), force / size
        pixel = self._view.pixel * self._view._stroke / SUPERSAMPLING
        length = self._view.longest_arrow * float(np.sqrt(size / peak))
        self._force[0].visibility = length > 12.0 * pixel
        head = min(15.0 * pixel, 0.6 * length)
        self._arrow.copy_from(
            pv.Arrow(
                start=place - (length + 6.0 * pixel) * along,
                direction=along,
                scale=length,
                tip_length=head / length,
                tip_radius=0.42 * head / length,
                shaft_radius=min(2.2 * pixel, 0.16 * head) / length,
                tip_resolution=24,
            )
        )
        for mark in self._marks:
            mark.points = place[None]


def mixed(colour: str, background: str, part: float) -> str:
    """Return a colour with so large a part of it over the background (#rrggbb)."""
    pairs = zip(*(bytes.fromhex(c[1:]) for c in (colour, background)), strict=True)
    return "#" + "".join(f"{round(part * a + (1.0 - part) * b):02x}" for a, b in pairs)
