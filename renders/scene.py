"""The beam in three dimensions: one PyVista window, in which each picture of a frame is a renderer of its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import numpy as np
import pyvista as pv
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from PIL import Image
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

from oblique_impact.renders.geometry import BeamGeometry, Zone
from oblique_impact.renders.layout import Box, ScaleBar, scale_bar
from oblique_impact.renders.offscreen import prepare
from oblique_impact.renders.scenery import block, pin, slab, stand
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import TEXT, Style
from oblique_impact.renders.surroundings import drawn_obstacles

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
_GHOST_TIMES = 12  # of a run, from which the last few are shown
_TRACE_POINTS = 600
_ARROW = 0.16  # length of the largest force's arrow, over that of the beam
_CLOSE = 12.0  # height of a picture close to the contact point, over the radius of the beam there
_CLOSE_ARROW = 0.36  # length of the largest force's arrow there, over that height
_WIDE = 1.5  # half width over half depth, from which on a beam is seen from its side there
_ZONE_POINTS = 32  # along the line that shows a zone of contact
_IN_FRONT = -1e6  # units of depth by which arrow and contact point are drawn in front of the slope
#: of the soft shadow of a beam
_SHADOW_STRENGTH = 0.36  # part of the light that a beam in contact takes away
_SHADOW_SPREAD = 0.12  # growth of the half width of a shadow over the height of the beam
_SHADOW_PROFILE = np.array([0.0, 0.12, 0.5, 0.88, 1.0, 0.88, 0.5, 0.12, 0.0])  # of the darkness across the strip
_SHADOW_REACH = 1.8  # half width of the strip, over that of the shadow
_SHADOW_LIFT = 0.05  # over the radius: how far the strip lies above its plane, so that it is not hidden by it
_BEAM = {"ambient": 0.38, "diffuse": 0.65, "specular": 0.06, "specular_power": 30.0}
_SOLID = {"ambient": 0.45, "diffuse": 0.6, "specular": 0.0}


class Panel(NamedTuple):
    """One picture of a frame: its place in the window (pixels) and the numbers of the runs that it shows."""

    box: Box
    runs: Sequence[int]
    close: bool = False  # whether the camera follows the contact point, without magnification


class Scene:
    """A window of some size (pixels) with panels; `draw` returns its picture at a time.

    All positions fit into the panels.  With `interactive` the window is shown on the screen, by `plotter.show`, at
    its plain size.
    """

    def __init__(
        self,
        story: Story,
        panels: Sequence[Panel],
        size: tuple[int, int],
        style: Style | None = None,
        **interactive: Any,
    ) -> None:
        prepare()
        scale = 1 if interactive else SUPERSAMPLING
        window: dict[str, Any] = {"off_screen": not interactive, **interactive}
        window["window_size"] = [scale * pixels for pixels in size]
        self.plotter = cast(Any, pv.Plotter(shape=(1, len(panels)), border=False, lighting="light kit", **window))
        if not interactive:
            self.plotter.render_window.SetMultiSamples(0)
        self._pixels = vtkUnsignedCharArray()
        self.views = []
        for number, panel in enumerate(panels):
            self.plotter.subplot(0, number)
            left, top, width, height = panel.box
            ends = left / size[0], 1.0 - (top + height) / size[1], (left + width) / size[0], 1.0 - top / size[1]
            self.plotter.renderer.SetViewport(*ends)
            self.views.append(View(self.plotter, story, panel, style or story.style, scale, bool(interactive)))
        if not interactive:
            self.plotter.show(auto_close=False)  # without which PyVista renders nothing

    def draw(self, time: float) -> NDArray[np.uint8]:
        """Return the picture of a physical time (s), (rows, columns, 4), all of it opaque."""
        for view in self.views:
            view.move(time)
        self.plotter.render()
        window = self.plotter.render_window
        wide, high = window.GetSize()
        # the pixels as they are, from the lowest row up: a screenshot copies them four times
        window.GetRGBACharPixelData(0, 0, wide - 1, high - 1, 0, self._pixels)
        large = Image.frombuffer("RGBX", (wide, high), pv.convert_array(self._pixels), "raw", "RGBX", 0, 1)
        picture = np.array(large.reduce(SUPERSAMPLING))[::-1]
        picture[..., 3] = 255
        return picture

    def close(self) -> None:
        """Free the window."""
        self.plotter.close()


class View:
    """Contents of the active renderer of a plotter: beams, slope, pin and ground."""

    def __init__(
        self, plotter: Any, story: Story, panel: Panel, style: Style, scale: int, turns: bool = False
    ) -> None:
        self._plotter, self._camera = plotter, plotter.renderer.camera
        self.style, self.theme, self.close = style, style.colours, panel.close
        self._turns = turns
        #: pixels of the window in the width of a thin line
        self.stroke = scale * max(1.0, style.resolution / 96.0 * style.letters / TEXT)
        shown = [story.geometries[n].true if panel.close else story.drawn[n] for n in panel.runs]
        #: unit vectors (3,) from the scene to the eye, and (2, 3) to the right and upward in the picture
        self.eye = CAMERAS[style.camera] / np.linalg.norm(CAMERAS[style.camera])
        if story.obstacles and np.mean([obstacle.normal[0] for obstacle in story.obstacles]) < -0.7:
            self.eye = self.eye * (-1.0, 1.0, 1.0)  # walls to the right would hide the beam
        # from close by a wide beam, or an obstacle seen from behind, would hide where they touch
        behind = any(self.eye[:2] @ obstacle.normal < 0.0 for obstacle in story.obstacles)
        if panel.close and (behind or shown[0].half_width > _WIDE * shown[0].touch_radius):
            self.eye = CAMERAS["front"]
        right = np.cross([0.0, 1.0, 0.0], self.eye)
        right /= np.linalg.norm(right)
        self.across = np.array([right, np.cross(self.eye, right)])
        plotter.set_background(self.theme.background, all_renderers=False)
        solids, planes = self._add_scenery(shown[0], story)
        self._aim(shown, panel.box, solids)
        self.beams = [BeamActor(self, g, story, n, planes) for n, g in zip(panel.runs, shown, strict=True)]

    def add(self, mesh: pv.PolyData, width: float = 1.0, **look: Any) -> Any:
        """Add a mesh; lines are as thick as the letters want."""
        return self._plotter.add_mesh(mesh, line_width=width * self.stroke, **look)

    def _add_scenery(self, geometry: BeamGeometry, story: Story) -> tuple[list[pv.PolyData], list[Array]]:
        """Add pin, slope and ground; returns the solids, and lines (2, 2) in the planes on which shadows fall."""
        theme = self.theme
        ground = story.ground if self.style.ground else None
        feet = [solid for solid in [pin(geometry)] if solid]
        for foot in feet:
            self.add(foot, color=theme.pin, **_SOLID)
        obstacles = drawn_obstacles(geometry)
        blocks = [block(geometry, obstacle) for obstacle in obstacles]
        planes = []
        if ground:
            standing = [
                *([] if geometry.clamped else feet),
                *(b for b, o in zip(blocks, obstacles, strict=True) if o.is_side and o.normal[1] > 0.0),
            ]
            blocks += [found for found in (stand(solid, ground) for solid in standing) if found]
            planes.append(np.array([(ground.first, ground.y), (ground.last, ground.y)]))
            planes += [line for o in obstacles if o.is_side and o.normal[1] > 0.0 for line in o.pieces]
        for solid in blocks:
            self._add_block(solid, theme.slope, theme.slope_edge)
        if ground:
            blocks.append(slab(ground))
            self._add_block(blocks[-1], theme.ground, theme.line)
        return [*feet, *blocks], planes

    def _add_block(self, solid: pv.PolyData, colour: str, edge: str) -> None:
        lit = solid.compute_normals(point_normals=False)  # else the faces are lit by normals with rounding errors
        if self._turns:
            self.add(lit, color=colour, culling="back", **_SOLID)
        else:
            lit.cell_data["seen"] = self._seen(np.asarray(lit.cell_data["Normals"]), colour)
            self.add(lit, scalars="seen", rgb=True, culling="back", lighting=False)
        self.add(solid.extract_feature_edges(20.0), color=edge, lighting=False)

    def _seen(self, normals: Array, colour: str) -> NDArray[np.uint8]:
        """Return the colours (faces, 3) of faces with these normals under the lights, which move with the camera.

        To light each pixel of a plane face anew, which has one colour, takes a third of the time of a frame.
        """
        axes, light = np.vstack([self.across, self.eye]), np.zeros((len(normals), 3))
        for lamp in self._plotter.renderer.lights:
            towards = np.array([0.0, 0.0, 1.0])
            if not lamp.is_headlight:  # the camera is at (0, 0, 1) and looks at the origin
                towards = np.subtract(lamp.position, lamp.focal_point)
            facing = np.maximum(normals @ axes.T @ towards / np.linalg.norm(towards), 0.0)
            light += lamp.intensity * np.outer(facing, lamp.diffuse_color.float_rgb)
        shade = np.array(to_rgb(colour)) * (_SOLID["ambient"] + _SOLID["diffuse"] * light)
        return np.asarray(np.rint(255.0 * np.minimum(shade, 1.0)), dtype=np.uint8)

    # Camera ---------------------------------------------------------------------------------------------------

    def _aim(self, shown: list[BeamGeometry], box: Box, solids: list[pv.PolyData]) -> None:
        """Place the camera so that everything of the runs fits into the box of the panel (pixels).

        `pixel` is then the length (m) of a pixel of the picture, `longest_arrow` (m) that of the largest force.
        """
        _, _, width, height = box
        focus = np.zeros(3)
        if self.close:
            self.pixel = _CLOSE * shown[0].touch_radius / height
            self.longest_arrow = _CLOSE_ARROW * height * self.pixel
        else:
            self.longest_arrow = _ARROW * shown[0].scenario.beam.length
            places = [np.asarray(solid.points) for solid in solids]
            for geometry in shown:
                times = np.linspace(geometry.times[0], geometry.times[-1], 60)
                places += [geometry.centreline(geometry.index(t)) for t in times]
                strongest = int(np.argmax(np.nan_to_num(geometry.values("lambda_n"))))
                for place, force in zip(
                    geometry.contact_places(strongest), geometry.pushes(strongest), strict=True
                ):
                    if self.style.arrow and np.any(force):
                        start = place - self.longest_arrow * force / np.linalg.norm(force)
                        places.append(np.append(start, 0.0)[None])
            seen = np.concatenate(places) @ self.across.T
            self.pixel = float(np.max(np.ptp(seen, axis=0) / (0.93 * width, 0.94 * height)))
            focus = 0.5 * (seen.min(axis=0) + seen.max(axis=0)) @ self.across
        self._camera.parallel_projection = True
        self._camera.parallel_scale = 0.5 * self.pixel * height
        self._plotter.renderer.camera_set = True  # else the first picture would be from PyVista's own place
        self.look_at(focus)

    def look_at(self, focus: Array) -> None:
        """Turn the camera to a place (3,)."""
        self._camera.SetFocalPoint(*focus)
        self._camera.SetPosition(*(focus + 10.0 * self.eye))
        self._camera.SetViewUp(*self.across[1])
        self._camera.SetClippingRange(1.0, 30.0)

    def scale_bar(self, longest: float) -> ScaleBar:
        """Return a bar of a round length, level in the plane of motion, not longer than some pixels."""
        right, up = self.across
        return scale_bar(np.array([right[0], -up[0]]) / self.pixel, longest)

    def move(self, time: float) -> None:
        """Show a physical time (s)."""
        for beam in self.beams:
            beam.move(time)
        if self.close:
            geometry = self.beams[0].geometry
            k = geometry.index(time)
            normal = geometry.contact_normals(k)[geometry.close_contact(k)]
            self.look_at(geometry.contact_place(k) - np.append(0.5 * geometry.touch_radius * normal, 0.0))


class BeamActor:
    """One beam in a view: its tube, earlier positions, the path of its contact point, the force, shadows."""

    def __init__(self, view: View, geometry: BeamGeometry, story: Story, number: int, planes: list[Array]) -> None:
        style, theme = view.style, view.theme
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
        self._hull = None
        if theme.outline:  # what is seen of a larger beam from inside
            self._edge = view.pixel * view.stroke / SUPERSAMPLING
            self._hull = self.mesh.copy()
            view.add(self._hull, color=theme.outline, culling="front", lighting=False)
            look["lighting"] = False  # each colour as it is in the scale
        self._place(0.0)
        self.actor = view.add(self.mesh, culling="back", show_scalar_bar=False, **look, **_BEAM)
        self.actor.prop.interpolation = "Phong"
        self._shadows = []
        for shadow in (Shadow(geometry, ends, number) for ends in planes):
            actor = view.add(shadow.mesh, scalars="tone", rgba=True, lighting=False)
            # it is blended all the same; VTK's pass for translucent things would take half of the time of a frame
            actor.ForceOpaqueOn()
            self._shadows.append((shadow, actor))
        self._ghosts = self._add_ghosts() if style.ghosts and not view.close else []
        self._trace = self._path() if style.trace else None
        if self._trace:
            self._whole = np.array(self._trace.points)
            view.add(self._trace, color=colour if story.overlay else theme.trace, width=2.0, lighting=False)
        contacts = len(geometry.contact_places(0)) if style.arrow else 0
        self._bands = {o: ZoneLine(view, colour) for o in geometry.zoned if style.arrow}
        self._forces = [Force(view, colour) for _ in range(contacts)]
        self._masses = [MassDisc(view, geometry, point.place) for point in geometry.inner_masses]
        applied = len(geometry.applied_forces(0)[0]) if style.arrow else 0
        self._applied = [Force(view, theme.ink) for _ in range(applied)]

    def move(self, time: float) -> None:
        """Take shapes, results and force of a physical time (s)."""
        k = self.geometry.index(time)
        self._place(k)
        if self._quantity:
            self.mesh.point_data["shown"] = np.nan_to_num(self.geometry.result(self._quantity, k)) / self._size
        for shadow, actor in self._shadows:
            actor.visibility = shadow.move(k)
        self._show_ghosts(time)
        zones = {zone.obstacle: zone for zone in self.geometry.zones(k)}
        for obstacle, band in self._bands.items():
            band.move(self.geometry, k, zones.get(obstacle))
        places, pushes = self.geometry.near_places(k), self.geometry.pushes(k)
        for force, place, push in zip(self._forces, places, pushes, strict=bool(self._forces)):
            force.move(place, push, self.geometry.peak_force)
        for disc, centre in zip(self._masses, self.geometry.masses(k), strict=True):
            disc.move(centre)
        places, pulls = self.geometry.applied_forces(k)
        for force, place, pull in zip(self._applied, places, pulls, strict=bool(self._applied)):
            force.move(place, pull, self.geometry.peak_applied)
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
        if self._hull:
            self._hull.points = points + self._edge * normals

    def _path(self) -> pv.PolyData:
        """Path of the contact point, in front of the beam, so that it is seen where it was."""
        samples = np.unique(np.linspace(0, self.geometry.times.size - 1, _TRACE_POINTS).astype(int))
        self._trace_times = self.geometry.times[samples]
        depth = 1.2 * self.geometry.half_width + self._depth
        return pv.lines_from_points(np.array([[*self.geometry.contact_point(k), depth] for k in samples]))

    def _add_ghosts(self) -> list[Any]:
        """Add the beam at fixed instants; a run that ends where it starts has no earlier positions."""
        geometry, ghosts = self.geometry, []
        times = np.linspace(geometry.times[0], geometry.times[-1], _GHOST_TIMES, endpoint=False)
        for time in times if times[-1] > times[0] else ():
            mesh = pv.PolyData(geometry.tube(geometry.index(time))[0], geometry.solid.faces)
            ghosts.append(self._view.add(mesh, lighting=False, culling="back"))
        return ghosts

    def _show_ghosts(self, time: float) -> None:
        """Show the last few of the ghosts, each a little after its instant, fainter with age."""
        times, theme = self.geometry.times, self._view.theme
        deep = max(self.geometry.half_width, float(self.geometry.radii.max()))
        newest = int(np.floor(_GHOST_TIMES * (time - times[0]) / (times[-1] - times[0] or np.inf) - 0.25))
        for number, actor in enumerate(self._ghosts):
            age = newest - number
            actor.visibility = 0 <= age < len(_GHOSTS)
            if actor.visibility:
                # an opaque mixture with the background: transparent beams would take half of the time of a frame
                part = _GHOSTS[age]
                mixture = part * np.array(to_rgb(theme.ghost)) + (1.0 - part) * np.array(to_rgb(theme.background))
                actor.prop.color = tuple(mixture)
                # away from the eye, where it covers nothing and is seen at the same place
                actor.position = -4.0 * (age + 1) * deep * self._view.eye


class ZoneLine:
    """The zone of contact with one obstacle: a line on the face of the beam that touches it."""

    def __init__(self, view: View, colour: str) -> None:
        self._mesh = pv.lines_from_points(np.zeros((_ZONE_POINTS, 3)))
        inks = ((view.theme.background, 9.0), (colour, 6.0))
        self._actors = [view.add(self._mesh, color=ink, width=width, lighting=False) for ink, width in inks]
        for depth, actor in enumerate(self._actors, start=1):
            actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
            actor.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, 0.1 * depth * _IN_FRONT)

    def move(self, geometry: BeamGeometry, k: float, zone: Zone | None) -> None:
        """Show a zone at the fractional sample k; one place alone has its force."""
        shown = zone is not None and zone.last > zone.first
        for actor in self._actors:
            actor.visibility = shown
        if zone is not None and shown:
            along = np.linspace(zone.first, zone.last, _ZONE_POINTS)
            columns = *geometry.face(k, zone.side).T, geometry.near_edge
            self._mesh.points = np.stack([np.interp(along, geometry.stations, c) for c in columns], axis=1)


class Force:
    """The force of one contact: a mark at its place and an arrow that ends there."""

    def __init__(self, view: View, colour: str) -> None:
        self._view, theme = view, view.theme
        # half of its length is its head, which has the radius 1, the shaft has 0.5
        self._arrow = pv.Arrow(tip_length=0.5, tip_radius=1.0, shaft_radius=0.5, tip_resolution=24)
        self._unit_arrow = np.array(self._arrow.points, dtype=float)
        self._marks = [pv.PolyData(np.zeros((1, 3))) for _ in range(2)]
        # all of it is drawn at one depth, where faces that look away would cover those in front of them
        self._actors = [view.add(self._arrow, color=colour, culling="back", ambient=0.6, diffuse=0.5)]
        for mark, ink, size in zip(self._marks, (theme.ink, theme.background), (8.0, 5.5), strict=True):
            point = {"render_points_as_spheres": True, "point_size": size * view.stroke}
            self._actors.append(view.add(mark, color=ink, lighting=False, **point))
        for depth, actor in enumerate(self._actors, start=1):
            actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
            actor.mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.0, depth * _IN_FRONT)
            actor.mapper.SetRelativeCoincidentTopologyPointOffsetParameter(depth * _IN_FRONT)

    def move(self, place: Array, push: Array, peak: float) -> None:
        """End the arrow just before a place (3,); its length grows with the root of the force (2,), in N."""
        size = float(np.linalg.norm(push))
        for actor in self._actors:
            actor.visibility = size > 1e-3 * peak
        if not size > 1e-3 * peak:
            return
        along = np.append(push / size, 0.0)
        across = np.array([-along[1], along[0], 0.0])
        pixel = self._view.pixel * self._view.stroke / SUPERSAMPLING
        length = self._view.longest_arrow * float(np.sqrt(size / peak))
        self._actors[0].visibility = length > 12.0 * pixel
        head = min(15.0 * pixel, 0.6 * length)
        x, y, z = self._unit_arrow.T
        thick = np.where(np.hypot(y, z) > 0.75, 0.42 * head, 2.0 * min(2.2 * pixel, 0.16 * head))
        behind = np.interp(x, (0.0, 0.5, 1.0), (length, head, 0.0)) + 6.0 * pixel
        self._arrow.points = (
            place - behind[:, None] * along + (thick * y)[:, None] * across + np.outer(thick * z, (0.0, 0.0, 1.0))
        )
        for mark in self._marks:
            mark.points = place[None]


class MassDisc:
    """A point mass inside of the span: a disc across the plane of motion, with the radius of its sphere."""

    def __init__(self, view: View, geometry: BeamGeometry, place: float) -> None:
        radius = geometry.disc(place)
        height = 2.2 * geometry.half_width
        self._mesh = pv.Cylinder(direction=(0.0, 0.0, 1.0), radius=radius, height=height, resolution=40)
        self._own = np.array(self._mesh.points)
        view.add(self._mesh, color=view.theme.pin, **_SOLID)

    def move(self, centre: Array) -> None:
        """Put its centre at a place (3,)."""
        self._mesh.points = self._own + centre


class Shadow:
    """The soft shadow of a beam under light from above: a `mesh` with colours and opacity in the array "tone".

    VTK's own shadow maps have hard edges and take longer than all the rest of a frame in software OpenGL.

    It falls on the plane across the plane of motion through the `ends` (2, 2) of a line (m).  The shadows of
    several beams, by their `number` from 0, do not lie in one plane.
    """

    def __init__(self, geometry: BeamGeometry, ends: NDArray[np.float64], number: int) -> None:
        self._geometry, self._ends = geometry, ends
        self._lift = _SHADOW_LIFT * (number + 1) * geometry.touch_radius
        # points along the beam, row by row across the strip
        self.mesh = pv.Plane(i_resolution=geometry.stations.size - 1, j_resolution=_SHADOW_PROFILE.size - 1)
        self.mesh.clear_data()
        self._tone = np.zeros((self.mesh.n_points, 4), np.uint8)
        self.mesh.point_data["tone"] = self._tone

    def move(self, k: float) -> bool:
        """Cast the shadow of the beam at the fractional sample k; returns whether there is one."""
        geometry, ((x0, y0), (x1, y1)) = self._geometry, self._ends
        axis = geometry.centreline(k)
        if not np.all(np.isfinite(axis)) or abs(y1 - y0) >= 10.0 * abs(x1 - x0):  # a plane that is almost upright
            return False
        x = np.clip(axis[:, 0], min(x0, x1), max(x0, x1))  # what lies beyond the plane is a strip of no area
        y = y0 + (x - x0) * (y1 - y0) / (x1 - x0)
        height = np.maximum(axis[:, 1] - y, 0.0)
        half = geometry.radii + _SHADOW_SPREAD * height
        from_ends = np.minimum(geometry.stations, geometry.stations[-1] - geometry.stations)
        dark = np.where(axis[:, 1] > y, _SHADOW_STRENGTH * geometry.radii / half, 0.0) * np.minimum(
            from_ends / half, 1.0
        )
        z = np.outer(np.linspace(-1.0, 1.0, _SHADOW_PROFILE.size), _SHADOW_REACH * half)
        self.mesh.points = np.stack(np.broadcast_arrays(x, y + self._lift, z), axis=-1).reshape(-1, 3)
        self._tone[:, 3] = np.round(255.0 * np.outer(_SHADOW_PROFILE, dark)).ravel()
        self.mesh.point_data["tone"] = self._tone
        return True
