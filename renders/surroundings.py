"""Surroundings of a beam: slope, obstacles and ground, as all pictures draw them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.scenario.obstacles import ObstaclePoint, Side
from oblique_impact.scenario.polylines import Outline

Array = NDArray[np.float64]

#: over the length: how close a beam comes to what is drawn of an unbounded slope, and the room beyond that
_NEAR, _ROOM = 0.005, 0.12
#: over the beam's reach: what lies farther from the pin is not drawn
_SEEN = 1.2
#: over the length: depth of the slope, below its lower end or, of one steeper than 60 degrees, across it
_BELOW, _ACROSS = 0.06, 0.1
#: half of the depth of slope and pin out of the plane: over the radius of the beam, over half of its width
_DEEP, _WIDE = 5.0, 1.3
FOOT = 6.5  # depth of the pin's foot below the axis, over the radius of the beam there
#: how far the ground reaches beyond what stands on it, over the length; half of its depth over that of the slope
_BEYOND, _WIDER = 0.06, 2.2
#: over the length: radius that a point is drawn with; corners of the outline of a peg
_PEG, _CORNERS = 0.008, 40
_SAMPLES = 2000  # of a run that are looked at


class DrawnObstacle(NamedTuple):
    """An obstacle as pictures show it."""

    outline: (
        Array  # (n, 2), m; of a side the surface from its first end to its last one, and back through the solid
    )
    normal: Array  # (2,) out of the solid; of a peg towards the beam
    is_side: bool
    ends: tuple[float, float] = (0.0, 0.0)  # m along a side from its origin
    touched: int = 2  # points of the outline that are of the surface, of a side or an open outline

    @property
    def surface(self) -> Array:
        """The line that the beam can touch (n, 2), m: a side from end to end, or the closed outline of a solid."""
        return self.outline[: self.touched] if self.is_side else np.append(self.outline, self.outline[:1], axis=0)

    @property
    def pieces(self) -> list[Array]:
        """The straight pieces of the surface, (2, 2) each."""
        return [self.surface[k : k + 2] for k in range(len(self.surface) - 1)]


class Ground(NamedTuple):
    """A level rectangle at a height `y` (m), from `first` to `last` (m) and so far to both sides of the beam."""

    y: float
    first: float
    last: float
    half_depth: float


def drawn_obstacles(geometry: BeamGeometry) -> list[DrawnObstacle]:
    """Return what is drawn of slope and obstacles of a run; nothing of what is out of the beam's reach.

    Where contact is on the beam's axis their surfaces lie half its depth, that at the contact point, beside the
    lines and points that the axis touches.  The deformation factor changes nothing of them.
    """
    scenario = geometry.scenario
    if not scenario.contact.enabled:
        return []
    pegs = [_peg(geometry, point) for point in scenario.obstacle_points if not point.corner]
    sides = [_side(geometry, side) for side in scenario.sides if side.obstacle not in scenario.outlines]
    return [*filter(None, sides), *pegs, *(_outline(geometry, of) for of in scenario.outlines.values())]


def _outline(geometry: BeamGeometry, outline: Outline) -> DrawnObstacle:
    """Return an outline; an open one ends level below its lowest place or, of a steep one, across it."""
    places = _moved_in(outline, geometry.slope_depth)
    points = np.column_stack([places.real, places.imag])
    if outline.is_closed:
        middle = looked_at(geometry).mean(axis=0) - points.mean(axis=0)
        return DrawnObstacle(points[:-1], middle / (np.linalg.norm(middle) or 1.0), False)
    length = geometry.scenario.beam.length
    tangent = (points[-1] - points[0]) / (np.linalg.norm(points[-1] - points[0]) or 1.0)
    normal = np.array([-tangent[1], tangent[0]])
    down, deep = (np.array([0.0, 1.0]), _BELOW) if tangent[0] >= 0.5 else (normal, _ACROSS)
    low = float((points @ down).min()) - deep * length
    bottom = points[[-1, 0]] + np.outer(low - points[[-1, 0]] @ down, down)
    return DrawnObstacle(np.concatenate([points, bottom]), normal, True, touched=len(points))


def _moved_in(outline: Outline, depth: float) -> NDArray[np.complex128]:
    """Return the points of an outline (n,), x + i y, moved into the solid by a depth (m) across its sides."""
    z = outline.points
    normals = 1j * np.diff(z) / np.abs(np.diff(z))
    first, last = (normals[-1], normals[0]) if outline.is_closed else (normals[0], normals[-1])
    before, after = np.concatenate([[first], normals]), np.concatenate([normals, [last]])
    across = before + after
    return np.asarray(z - 2.0 * depth * across / np.maximum(np.abs(across) ** 2, 1.0))


def _side(geometry: BeamGeometry, side: Side) -> DrawnObstacle | None:
    """Return what is drawn of a side: as far as its ends, or as any part of the beam comes near or below it."""
    scenario = geometry.scenario
    length, reach = scenario.beam.length, _SEEN * scenario.reach
    c, s = np.cos(side.angle), np.sin(side.angle)
    tangent, normal = np.array([c, s]), np.array([-s, c])
    pin = -float(np.dot(side.origin, tangent))
    ends = side.extent or _ends_of(geometry, side, (tangent, normal), reach)
    first, last = np.clip(ends, pin - reach, pin + reach)
    if not first < last:
        return None
    top = np.array(side.origin) + np.outer([first, last], tangent) - geometry.slope_depth * normal
    if tangent[0] < 0.5:
        bottom = top - _ACROSS * length * normal
    else:
        bottom = np.stack([top[:, 0], np.full(2, top[:, 1].min() - _BELOW * length)], axis=1)
    return DrawnObstacle(np.concatenate([top, bottom[::-1]]), normal, True, (float(first), float(last)))


def _ends_of(geometry: BeamGeometry, side: Side, axes: tuple[Array, Array], reach: float) -> tuple[float, float]:
    """Return the stretch (m along a side) near or below which the axis comes in the run, with some room."""
    length, pin = geometry.scenario.beam.length, -float(np.dot(side.origin, axes[0]))
    places = looked_at(geometry) - np.array(side.origin)
    along, height = (places @ np.array(axes).T).T
    seen = (np.abs(along - pin) < reach) & (np.abs(height) < reach)
    if not seen.any():
        return pin, pin
    near = along[seen & (height <= max(height[seen].min(), 0.0) + _NEAR * length)]
    return float(near.min()) - _ROOM * length, float(near.max()) + _ROOM * length


def _peg(geometry: BeamGeometry, point: ObstaclePoint) -> DrawnObstacle:
    """Return a peg, one of a small radius for a point; it lies on the side of the beam that touches it."""
    theta = geometry.values("theta")
    centre = np.array([point.x, point.y])
    # as the beam lies when it comes nearest
    angle = float(np.arctan2(point.y, point.x))
    nearest = theta[int(np.nanargmin(np.abs(theta - angle)))]
    normal = geometry.side_of(point) * np.array([-np.sin(nearest), np.cos(nearest)])
    radius = max(point.radius, _PEG * geometry.scenario.beam.length)
    middle = centre + (point.radius - radius - geometry.slope_depth) * normal
    around = np.linspace(0.0, 2.0 * np.pi, _CORNERS, endpoint=False)
    return DrawnObstacle(middle + radius * np.stack([np.cos(around), np.sin(around)], axis=1), normal, False)


def looked_at(geometry: BeamGeometry) -> Array:
    """Return places (n, 2) of the axis in the run."""
    samples = np.unique(np.linspace(0, geometry.times.size - 1, _SAMPLES).astype(np.int64))
    return geometry.stations_at(samples).reshape(-1, 2)


def depth_of(geometry: BeamGeometry) -> float:
    """Return half of the depth (m) of the drawn slope, out of the plane of motion."""
    return max(_DEEP * geometry.touch_radius, _WIDE * geometry.half_width)


def ground_of(geometries: Sequence[BeamGeometry], obstacles: Sequence[DrawnObstacle]) -> Ground | None:
    """Return the ground under some runs: at the lowest point of slope, obstacles and pin.

    None where no gravity tells which way is down, without an obstacle, and where a beam would come below it.
    """
    first = geometries[0]
    if not obstacles or first.scenario.gravity == 0.0:
        return None
    outlines = np.concatenate([obstacle.outline for obstacle in obstacles])
    length = first.scenario.beam.length
    foot = np.zeros((0, 2))
    if not first.scenario.root.is_free:
        deep = max(FOOT * float(first.radii[0]), first.scenario.root.hub_radius)
        foot = np.array([(-deep, -deep), (deep, -deep)])
    y = float(np.concatenate([outlines, foot])[:, 1].min())
    places = np.concatenate([looked_at(geometry) for geometry in geometries])
    reached = places[np.all(np.abs(places) < 1e3 * first.scenario.reach, axis=1)]
    if reached[:, 1].min() < y:
        return None
    x = np.concatenate([outlines[:, 0], reached[:, 0], foot[:, 0]])
    room = _BEYOND * length
    return Ground(y, float(x.min()) - room, float(x.max()) + room, _WIDER * depth_of(first))
