"""The beam in three dimensions: one off-screen window whose meshes are moved from frame to frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, cast

import numpy as np
import pyvista as pv
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

from oblique_impact.renders.backdrop import COLOUR, Backdrop, darken, lay, picture_of, reduced
from oblique_impact.renders.beam3d import CAMERAS, SUPERSAMPLING, Beam3D, contact_force, stroke
from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.ground import depth_of
from oblique_impact.renders.offscreen import prepare
from oblique_impact.renders.scale_bar import ScaleBar, scale_bar
from oblique_impact.renders.scenery import footprint, pin, slab, slope_wedge, stand
from oblique_impact.renders.shadow import (
    Footprint,
    Part,
    Pixels,
    Shadow,
    Surface,
    part_of,
    shadow_around,
    shadow_on,
)
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import Style, Theme

Array = NDArray[np.float64]

_ARROW = 0.16  # length of the largest force's arrow, over that of the beam
_CLOSE = 12.0  # height of a picture close to the contact point, over the radius of the beam there
_CLOSE_ARROW = 0.36  # length of the largest force's arrow there, over that height
_BACK = 0  # the buffer that VTK draws into
_SOLID: dict[str, Any] = {"ambient": 0.45, "diffuse": 0.6, "specular": 0.0}
_AROUND = 4  # thin lines: how far lines and edges reach beyond their points
_EMPTY = "#00ff00"  # where nothing moves in a picture of what moves: a colour that neither beam nor path has
_EMPTY_PIXEL = np.frombuffer(b"\x00\xff\x00\x00", np.uint32)[0]
_MARK = 3.0  # pixels: radius of the point of contact, in a picture of 720 pixels


class _Arrow(NamedTuple):
    """A force on the beam in pixels of the window: its point of contact, and the arrow's corners if it is seen."""

    to: Array  # (2,)
    corners: Array | None  # (7, 2)
    unit: float
    colour: str

    @property
    def places(self) -> Array:
        """Points (n, 2) between which it is drawn."""
        mark = self.to + 2.0 * _MARK * self.unit * np.array([(-1.0, -1.0), (1.0, 1.0)])
        return mark if self.corners is None else np.concatenate([mark, self.corners])

    def draw(self, picture: Image.Image, origin: tuple[int, int], theme: Theme) -> None:
        """Draw it and the point of contact into the part of the window that begins at some pixel."""
        pen, to = ImageDraw.Draw(picture), self.to - origin
        if self.corners is not None:
            corners = [tuple(p) for p in [*(self.corners - origin), self.corners[0] - origin]]
            pen.polygon(corners, fill=self.colour)
            pen.line(corners, fill=theme.background, width=round(0.8 * self.unit))
        box = (*(to - _MARK * self.unit).tolist(), *(to + _MARK * self.unit).tolist())
        pen.ellipse(box, fill=theme.background, outline=theme.ink, width=round(self.unit))


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
        self._window = cast(Any, self.plotter.render_window)
        # supersampling smooths the edges; VTK's own samples besides would cost ten times as much
        self._window.SetMultiSamples(0)
        self._window.SwapBuffersOff()  # what is drawn is read where it is drawn
        self._bytes: Any = vtkUnsignedCharArray()
        shown = [story.geometries[n].true if close else story.geometries[n] for n in numbers]
        self._beams = [Beam3D(self.plotter, g, story, self._style, n) for n, g in enumerate(shown)]
        # actors of what stands still: in its colours, and in that of an empty picture
        self._still: list[pv.Actor] = []
        self._hiding: list[pv.Actor] = []
        self._surfaces: list[Surface] = []
        self._footprints: list[Footprint] = []
        solids = self._add_scenery(shown[0], story)
        self._backdrop: Backdrop | None = None
        self._aim(solids, span)
        # by a camera that does not move
        self._seen = [] if close else [part_of(surface, self.project, size) for surface in self._surfaces]
        self._around: Shadow | None = None  # of what stands on the ground
        if self._seen and self._seen[0]:
            self._around = shadow_around(self._footprints, shown[0].touch_radius, self._seen[0])

    def _add_scenery(self, geometry: BeamGeometry, story: Story) -> list[pv.PolyData]:
        """Add pin and slope, and the ground on which they stand; returns the solids."""
        theme, slope = self._theme, story.slope
        ground = story.ground if self._style.ground else None
        solids = [pin(geometry), *([slope_wedge(geometry, slope)] if slope else [])]
        blocks = [self._block(solid, theme.slope, theme.slope_edge) for solid in solids[1:]]
        if ground:
            stands = [block for block in (stand(solid, ground) for solid in solids) if block]
            blocks += [self._block(solid, theme.slope, theme.slope_edge) for solid in stands]
            self._footprints = [f for f in (footprint(solid, ground) for solid in (*solids, *stands)) if f]
            solids += [*stands, slab(ground)]
            blocks.append(self._block(solids[-1], theme.ground, theme.line))
            top = blocks[-1][0].cell_data["tone"][_top_of(solids[-1], np.array([0.0, 1.0]))]
            ends = np.array([(ground.first, ground.y), (ground.last, ground.y)])
            self._surfaces.append(Surface.of(ends, ground.half_depth, np.asarray(top)))
            if slope:
                top = blocks[0][0].cell_data["tone"][_top_of(solids[1], geometry.slope_axes[1])]
                self._surfaces.append(Surface.of(slope.outline[:2], depth_of(geometry), np.asarray(top)))
        self._add_still(solids[0], blocks, hides=len(blocks) - bool(ground))
        return solids

    def _block(self, solid: pv.PolyData, colour: str, edge: str) -> tuple[pv.PolyData, pv.PolyData]:
        """Return a solid with plane faces in their colours, and its edges in theirs."""
        faces, edges = solid.copy(), pv.PolyData(solid.extract_feature_edges(20.0))
        # VTK takes half of the time of a frame to light plane faces pixel by pixel
        faces.cell_data["tone"] = self._lit(solid, colour)
        edges.clear_data()
        edges.cell_data["tone"] = np.tile(np.frombuffer(bytes.fromhex(edge[1:]), np.uint8), (edges.n_cells, 1))
        return faces, edges

    def _add_still(
        self, solid: pv.PolyData, blocks: Sequence[tuple[pv.PolyData, pv.PolyData]], hides: int
    ) -> None:
        """Add what stands still: the pin, and blocks, the first few of which something that moves may be behind.

        An actor takes time in every frame: there are as few as may be.
        """
        look: dict[str, Any] = {"line_width": stroke(self._style), "lighting": False, "culling": "back"}
        self._still.append(self.plotter.add_mesh(solid, color=self._theme.pin, **_SOLID))
        for meshes in zip(*blocks, strict=True):
            self._still.append(self.plotter.add_mesh(_joined(meshes), scalars="tone", rgb=True, **look))
        if not self._close:
            look |= {"color": _EMPTY}
            if hides:
                parts = [mesh for block in blocks[:hides] for mesh in block]
                self._hiding.append(self.plotter.add_mesh(_joined(parts).copy(), **look))
            look["culling"] = None
            self._hiding.append(self.plotter.add_mesh(solid.copy(), **look))
            for actor in self._hiding:
                actor.visibility = False

    def _lit(self, solid: pv.PolyData, colour: str) -> NDArray[np.uint8]:
        """Return the colours (faces, 3) of plane faces that do not shine, lit as VTK lights them.

        The lights are far away and so is the eye, so that a face has one colour: its ambient part and, from each
        light, a diffuse one with the cosine of the angle between normal and light.
        """
        eye = CAMERAS[self._style.camera] / np.linalg.norm(CAMERAS[self._style.camera])
        right = np.cross([0.0, 1.0, 0.0], eye) / np.linalg.norm(np.cross([0.0, 1.0, 0.0], eye))
        facing = np.asarray(solid.face_normals) @ np.stack([right, np.cross(eye, right), eye], axis=1)
        light = np.full((solid.n_cells, 3), _SOLID["ambient"])
        for lamp in self.plotter.renderer.GetLights():
            at = np.array([0.0, 0.0, 1.0])  # of the one at the eye
            if lamp.LightTypeIsCameraLight():
                at = np.subtract(lamp.GetPosition(), lamp.GetFocalPoint())
            cosine = np.maximum(facing @ at / np.linalg.norm(at), 0.0)
            light += _SOLID["diffuse"] * lamp.GetIntensity() * np.outer(cosine, lamp.GetDiffuseColor())
        own = np.frombuffer(bytes.fromhex(colour[1:]), np.uint8)
        return np.asarray(np.round(np.minimum(light * own, 255.0)).astype(np.uint8))

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
        camera = self.plotter.camera  # VTK's own calls: PyVista's would look for the bounds of everything
        camera.SetFocalPoint(*focus)
        camera.SetPosition(*(np.asarray(focus) + 10.0 * self._eye))
        camera.SetViewUp(*self._up)
        camera.SetClippingRange(1.0, 30.0)

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
            below = np.append(0.5 * geometry.touch_radius * geometry.slope_axes[1], 0.0)
            self._look_at(geometry.contact_place(geometry.index(time)) - below)
        backdrop = None if self._close else self._backdrop_now()
        arrows = self._arrows(time) if self._style.arrow else []
        shadows = self._shadows(time)
        left, top, right, bottom = box = self._touched(arrows) if backdrop else (0, 0, *self._window.GetSize())
        pixels = self._read(left, top, right, bottom)
        if backdrop is None:
            large = self._with_shadows(pixels, shadows)
        else:
            strips = backdrop.shaded(shadows)
            empty = pixels & COLOUR == _EMPTY_PIXEL
            pixels = np.where(empty, backdrop.pixels[top:bottom, left:right], pixels)
            for strip in strips:
                lay(strip, pixels, box, empty)
            large = picture_of(pixels)
        for arrow in arrows:
            arrow.draw(large, (left, top), self._theme)
        if backdrop is None:
            return reduced(large)
        whole = backdrop.picture.copy()
        for place, part in strips:
            if not (left <= place[0] and top <= place[1] and right >= place[2] and bottom >= place[3]):
                whole.paste(reduced(part), (place[0] // SUPERSAMPLING, place[1] // SUPERSAMPLING))
        whole.paste(reduced(large), (left // SUPERSAMPLING, top // SUPERSAMPLING))
        return whole

    def _shadows(self, time: float) -> list[Shadow | None]:
        """Return the shadows of the beams on each surface."""
        if not self._surfaces:
            return []
        casters = [beam.caster(time) for beam in self._beams]
        found = []
        for n, surface in enumerate(self._surfaces):

            def see(ends: tuple[float, float], reach: float, n: int = n, on: Surface = surface) -> Part | None:
                return part_of(on, self.project, self.size, ends, reach) if self._close else self._seen[n]

            found.append(shadow_on(surface, casters, see))
        return found

    def _with_shadows(self, pixels: Pixels, shadows: Sequence[Shadow | None]) -> Image.Image:
        """Return the picture of a whole window with shadows on it."""
        pixels = np.ascontiguousarray(pixels)  # its rows are upside down in VTK: this copies them
        for shadow, surface in zip(shadows, self._surfaces, strict=True):
            if shadow:
                left, top, right, bottom = (SUPERSAMPLING * edge for edge in shadow.box)
                part = pixels[top:bottom, left:right]
                darken(part, part & COLOUR == surface.tones[0] & COLOUR, shadow, surface)
        return picture_of(pixels)

    def _backdrop_now(self) -> Backdrop:
        """Return what does not move from frame to frame; it is drawn anew when the earlier positions are others.

        From then on the window shows what moves alone: what stands still hides it in the colour of an empty
        picture.
        """
        newest = [beam.newest for beam in self._beams]
        if self._backdrop is None or self._backdrop.newest != newest:
            self._show(still=True)
            pixels = self._read(0, 0, *self._window.GetSize()).copy()
            self._backdrop = Backdrop(newest, pixels, self._surfaces, self._around)
            self._show(still=False)
        return self._backdrop

    def _show(self, still: bool) -> None:
        """Let the window show what stands still, or what moves."""
        cast(Any, self.plotter).set_background(self._theme.background if still else _EMPTY)
        for actors, shown in ((self._still, still), (self._hiding, not still)):
            for actor in actors:
                actor.visibility = shown
        for beam in self._beams:
            beam.show_ghosts(still)
            beam.show_moving(not still)

    def _read(self, left: int, top: int, right: int, bottom: int) -> Pixels:
        """Draw, and return a part of the window, (rows from the top, columns).

        It is read as VTK draws it, four bytes for each pixel: VTK takes seven times as long to make it three.
        """
        self._window.Render()
        height = self._window.GetSize()[1]
        box = (left, height - bottom, right - 1, height - 1 - top)
        self._window.GetRGBACharPixelData(*box, _BACK, self._bytes)
        pixels = np.frombuffer(memoryview(self._bytes), np.uint32)
        return np.asarray(pixels.reshape(bottom - top, right - left)[::-1])

    def _touched(self, arrows: Sequence[_Arrow]) -> tuple[int, int, int, int]:
        """Return the part of the window (left, top, right, bottom) outside of which nothing moves."""
        size, around = self._window.GetSize(), _AROUND * stroke(self._style)
        points = [SUPERSAMPLING * self.project(beam.moving_points()) for beam in self._beams]
        places = np.concatenate([*points, *(arrow.places for arrow in arrows)])
        if not np.all(np.isfinite(places)):
            return (0, 0, *size)
        ends = np.stack([places.min(axis=0) - around, places.max(axis=0) + around])
        (left, top), (right, bottom) = SUPERSAMPLING * np.clip(ends / SUPERSAMPLING, 0, self.size).astype(int)
        return (
            int(left),
            int(top),
            max(int(right), int(left) + SUPERSAMPLING),
            max(int(bottom), int(top) + SUPERSAMPLING),
        )

    def _arrows(self, time: float) -> list[_Arrow]:
        """Where forces are marked; an arrow ends just before the point of contact, outside of the beam."""
        found = []
        unit = SUPERSAMPLING * max(1.0, min(self.size[1] / 480.0, 3.0))
        for beam in self._beams:
            acting = beam.force_at(time)
            if acting is None:
                continue
            place, force = acting
            to = SUPERSAMPLING * self.project(place[None])[0]
            along = np.array([force @ self._right[:2], -force @ self._up[:2]])
            # foreshortened like everything else that does not lie across the line of sight
            length = SUPERSAMPLING * self._longest * float(np.linalg.norm(along) / np.sqrt(np.linalg.norm(force)))
            along /= np.linalg.norm(along)
            seen = length > 6.0 * unit
            corners = arrow_outline(to - (_MARK + 2.5) * unit * along, along, length, unit) if seen else None
            found.append(_Arrow(to, corners, unit, beam.colour))
        return found

    def project(self, points: Array) -> Array:
        """Pixels (n, 2), from the left and from the top, at which points (n, 3) are drawn."""
        camera = self.plotter.camera
        offset = (np.asarray(points) - np.asarray(camera.focal_point)) * 0.5 * self.size[1] / camera.parallel_scale
        across, up = offset @ self._right, offset @ self._up
        return np.stack([0.5 * self.size[0] + across, 0.5 * self.size[1] - up], axis=1)

    def scale_bar(self, longest: float) -> ScaleBar:
        """Return a bar of a round length, level in the plane of motion, and not longer than some pixels."""
        origin, along = self.project(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
        return scale_bar(along - origin, longest)

    def close(self) -> None:
        """Free the window."""
        self.plotter.close()


def _joined(meshes: Sequence[pv.PolyData]) -> pv.PolyData:
    """Return several meshes as one."""
    return meshes[0].append_polydata(*meshes[1:]) if len(meshes) > 1 else meshes[0]


def _top_of(solid: pv.PolyData, up: Array) -> int:
    """Return the number of the face that looks most in a direction (2,)."""
    return int(np.argmax(np.asarray(solid.face_normals)[:, :2] @ up))


def arrow_outline(tip: Array, along: Array, length: float, unit: float) -> Array:
    """Return the corners (7, 2) of an arrow in pixels, of a length with its head; `along` is its direction."""
    head = min(13.0 * unit, 0.6 * length)
    shaft, wide = min(2.0 * unit, 0.18 * head), 0.42 * head
    back = np.array([length, head, head, 0.0, head, head, length])[:, None]
    aside = np.array([shaft, shaft, wide, 0.0, -wide, -shaft, -shaft])[:, None]
    return np.asarray(tip - back * along + aside * np.array([-along[1], along[0]]))
