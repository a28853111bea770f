"""Soft shadows of beams on plane surfaces, in the pixels of a picture.

The light comes from above, and from some way around: a shadow grows wider with the height of the beam over the
surface, and paler as it does.  It is drawn where a surface of one colour is seen, so that nothing that stands or
moves in front of it is darkened.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Levels = NDArray[np.uint8]
Pixels = NDArray[np.uint32]
Box = tuple[int, int, int, int]  # left, top, right, bottom
Footprint = tuple[float, float, float]  # from left to right, and so far to both sides (m)
Project = Callable[[Array], Array]  # points (n, 3) to pixels (n, 2) of a picture, from its left and top

_STRENGTH = 0.36  # part of the light that a beam in contact takes away
_SPREAD = 0.12  # growth of a shadow's half width over the height of the beam
_REACH = 1.8  # where a shadow ends, over its half width
_FLAT = 1e-3  # a surface that is seen so flat, over its size, has no shadow
_STEEP = 0.1  # the level part of a unit length along a surface on which there is one
_TABLE = 1024
_AROUND = 1.6  # width of the shadow around what stands on the ground, over the radius of a beam


class Surface(NamedTuple):
    """A plane face across the plane of motion, from `start` to `end` (2,) (m), which is seen in one colour."""

    start: Array
    end: Array
    half_depth: float
    tones: Pixels  # (256,): its pixel with ever less light

    @classmethod
    def of(cls, ends: Array, half_depth: float, colour: NDArray[np.uint8]) -> Surface:
        """Return the surface between two ends (2, 2) (m), of a colour (3,)."""
        tones = np.full((256, 4), 255, np.uint8)
        tones[:, :3] = np.round(np.outer(1.0 - np.arange(256) / 255.0, colour))
        return cls(ends[0], ends[1], half_depth, tones.view(np.uint32)[:, 0])

    def height(self, x: Array) -> Array:
        """Height (m) of the surface at places x (m)."""
        return np.asarray(
            self.start[1] + (x - self.start[0]) * (self.end[1] - self.start[1]) / (self.end[0] - self.start[0])
        )

    def points(self, x: Array, z: Array) -> Array:
        """Points (n, 3) of the surface."""
        return np.stack([x, self.height(x), z], axis=1)


class Caster(NamedTuple):
    """What throws a shadow: an axis (n, 2) and the radii (n,) around it, in m."""

    axis: Array
    radii: Array


class Shadow(NamedTuple):
    """A shadow in a picture: the box (pixels) in which it is, and the part of the light it takes, of 255."""

    box: Box
    levels: Levels  # (rows, columns) of the box


class Part(NamedTuple):
    """What a picture shows of a surface: the places (m) at the pixels of a box, and which are on the surface."""

    box: Box
    x: NDArray[np.float32]  # (rows, columns)
    z: NDArray[np.float32]
    inside: NDArray[np.bool_]


See = Callable[[tuple[float, float], float], Part | None]


def shadow_on(surface: Surface, casters: Sequence[Caster], see: See) -> Shadow | None:
    """Return the shadow of beams on a surface; None where none is seen.

    `see` returns the part of the surface that a picture shows between two places (m) and so far to both sides, or
    more of it.
    """
    along = surface.end - surface.start
    if along[0] < _STEEP * np.linalg.norm(along):
        return None
    heights = [np.maximum(c.axis[:, 1] - c.radii - surface.height(c.axis[:, 0]), 0.0) for c in casters]
    widths = [c.radii + _SPREAD * h for c, h in zip(casters, heights, strict=True)]
    reach = _REACH * max(float(w.max()) for w in widths)
    first = min(float(c.axis[:, 0].min()) for c in casters) - reach
    last = max(float(c.axis[:, 0].max()) for c in casters) + reach
    if last < surface.start[0] or first > surface.end[0]:
        return None
    seen = see((first, last), reach)
    if seen is None:
        return None
    taken = np.max([_taken(c, w, seen) for c, w in zip(casters, widths, strict=True)], axis=0)
    return Shadow(seen.box, np.round(255.0 * taken * seen.inside).astype(np.uint8))


def shadow_around(footprints: Sequence[Footprint], radius: float, seen: Part) -> Shadow:
    """Return the shadow around what stands on the ground, as wide as a beam of some radius (m) has it."""
    taken = np.zeros(seen.inside.shape)
    for left, right, half in footprints:
        aside = np.maximum(np.maximum(left - seen.x, seen.x - right), 0.0)
        away = np.hypot(aside, np.maximum(np.abs(seen.z) - half, 0.0)) / (_AROUND * radius)
        taken = np.maximum(taken, _STRENGTH * np.maximum(1.0 - away**2, 0.0) ** 2)
    return Shadow(seen.box, np.round(255.0 * taken * seen.inside).astype(np.uint8))


def _taken(caster: Caster, width: Array, seen: Part) -> Array:
    """Part of the light that one beam takes at the places of a surface, with its half widths (m)."""
    order = np.argsort(caster.axis[:, 0])
    across = caster.axis[order, 0]
    first, last = across[0], across[-1]
    # tables over x: to look up is much faster than to interpolate for every pixel
    places = np.linspace(first, last, _TABLE)
    reach = (_REACH * np.interp(places, across, width[order])) ** -2.0
    strength = _STRENGTH * np.interp(places, across, (caster.radii / width)[order])
    number = ((seen.x - first) * ((_TABLE - 1) / max(last - first, 1e-12)) + 0.5).astype(np.int32)
    number = np.clip(number, 0, _TABLE - 1)
    beyond = seen.x - np.clip(seen.x, first, last)
    away = (seen.z**2 + beyond**2) * reach.astype(np.float32)[number]
    return np.asarray(strength.astype(np.float32)[number] * np.maximum(1.0 - away, 0.0) ** 2)


def part_of(
    surface: Surface,
    project: Project,
    size: tuple[int, int],
    ends: tuple[float, float] = (-np.inf, np.inf),
    reach: float = np.inf,
) -> Part | None:
    """Return what a picture of some size (pixels) shows of a surface: all of it, or as far as it reaches (m).

    None where nothing is seen, or the surface edge on.
    """
    x0, x1 = surface.start[0], surface.end[0]
    first, last = max(ends[0], x0), min(ends[1], x1)
    origin, end, deep = project(surface.points(np.array([x0, x1, x0]), np.array([0.0, 0.0, 1.0])))
    seen = np.stack([(end - origin) / (x1 - x0), deep - origin], axis=1)
    if not first < last or abs(np.linalg.det(seen)) <= _FLAT * np.sum(seen[:, 0] ** 2):
        return None
    deep = min(reach, surface.half_depth)
    corners = project(
        surface.points(np.array([first, first, last, last]), deep * np.array([-1.0, 1.0, -1.0, 1.0]))
    )
    low, high = np.floor(corners.min(axis=0)), np.ceil(corners.max(axis=0))
    (left, top), (right, bottom) = (np.clip(edge, 0, size).astype(int).tolist() for edge in (low, high))
    if not (left < right and top < bottom):
        return None
    across, down = (
        np.arange(left, right)[None] + 0.5 - origin[0],
        np.arange(top, bottom)[:, None] + 0.5 - origin[1],
    )
    back = np.linalg.inv(seen)
    x, z = x0 + back[0, 0] * across + back[0, 1] * down, back[1, 0] * across + back[1, 1] * down
    return Part((left, top, right, bottom), x, z, (np.abs(z) <= surface.half_depth) & (x >= x0) & (x <= x1))
