"""The drawn solid of a beam: rings of points around its axis in the shape of its cross-section, and its end.

Offsets are those along the axis, across it in the plane of motion, and out of the plane (m).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.scenario.sections import BeamSection
from oblique_impact.scenario.shapes import value_at

Array = NDArray[np.float64]

SIDES = 24  # points of a ring: of a circle, or the twelve corners of an i-beam twice
_CAP = 6  # rings from the end of the beam to its pole; twice as many on the sphere of a mass


class Solid(NamedTuple):
    """Points of a beam: its rings, those of the end, the pole of the end, the centre of the root."""

    rings: NDArray[np.int64]  # (np,) the ring at whose place a point is
    offsets: Array  # (np, 3) m
    directions: Array  # (np, 3) outward normals
    faces: NDArray[np.int64]  # triangles and quadrilaterals in VTK's form (3 or 4, then points), wound outward


def has_corners(shape: str) -> bool:
    """Whether a cross-section is drawn by its corners, not round."""
    return shape in ("rectangle", "i-beam")


def solid_of(beam: BeamSection, places: Array, radii: Array, mass_radius: float, flat: bool) -> Solid:
    """Return the points of a beam with rings of `radii` (m) at `places` (m).

    It ends in a sphere of `mass_radius` (m) if this is positive, else in a plane if it is `flat`, or a hemisphere.
    """
    count = places.size
    outline, normals = _rings(beam, places, radii)
    if mass_radius > 0.0:  # a sphere begins where it comes out of the beam
        end, end_normals = _sphere(mass_radius, -np.arccos(min(radii[-1] / mass_radius, 1.0)), 2 * _CAP)
    elif flat:
        end, end_normals = _plane(outline[-1])
    else:
        end, end_normals = _sphere(radii[-1], 0.0, _CAP)
    body, body_normals = (np.insert(values, 0, 0.0, axis=2) for values in (outline, normals))
    pole = np.array([(mass_radius or (0.0 if flat else radii[-1]), 0.0, 0.0), (0.0, 0.0, 0.0)])
    outward = np.array([(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)])
    rings = count + len(end)
    return Solid(
        np.append(np.repeat(np.minimum(np.arange(rings), count - 1), SIDES), [count - 1, 0]),
        np.concatenate([body.reshape(-1, 3), end.reshape(-1, 3), pole]),
        np.concatenate([body_normals.reshape(-1, 3), end_normals.reshape(-1, 3), outward]),
        _faces(rings),
    )


def _sphere(radius: float, first: float, steps: int) -> tuple[Array, Array]:
    """Return rings of a sphere from an elevation (rad) to its pole, without both, and their normals."""
    elevation = first + (0.5 * np.pi - first) * np.arange(1, steps) / steps
    normals = np.empty((steps - 1, SIDES, 3))
    normals[:, :, 0] = np.sin(elevation)[:, None]
    normals[:, :, 1:] = np.cos(elevation)[:, None, None] * _circle()
    return radius * normals, normals


def _plane(outline: Array) -> tuple[Array, Array]:
    """Return rings of a flat end, and their normals.

    Their width shrinks to nothing and their height stays: so the end of an i-beam is filled and no more.
    """
    rings = np.zeros((_CAP - 1, SIDES, 3))
    rings[:, :, 1] = outline[:, 0]
    rings[:, :, 2] = np.linspace(1.0, 0.0, _CAP - 1)[:, None] * outline[:, 1]
    return rings, np.broadcast_to((1.0, 0.0, 0.0), rings.shape)


def _faces(rings: int) -> NDArray[np.int64]:
    """Return the faces between rings, around the pole and around the centre of the root."""
    i, j = np.arange(rings - 1)[:, None], np.arange(SIDES)[None]
    a, b = i * SIDES + j, i * SIDES + (j + 1) % SIDES
    quads = np.stack([np.full_like(a, 4), a, b, b + SIDES, a + SIDES], axis=-1).reshape(-1)
    side, last, pole = np.arange(SIDES), (rings - 1) * SIDES, rings * SIDES
    after, three = (side + 1) % SIDES, np.full(SIDES, 3)
    tip = np.stack([three, last + side, last + after, np.full(SIDES, pole)], axis=-1)
    root = np.stack([three, np.full(SIDES, pole + 1), after, side], axis=-1)
    return np.concatenate([quads, tip.reshape(-1), root.reshape(-1)])


def _circle() -> Array:
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _rings(beam: BeamSection, places: Array, radii: Array) -> tuple[Array, Array]:
    """Return the rings (rings, SIDES, 2), across the axis and out of the plane, and their normals."""
    shape = beam.section.shape
    if not has_corners(shape):
        return radii[:, None, None] * _circle(), np.broadcast_to(_circle(), (places.size, SIDES, 2))

    def half(name: str) -> Array:
        return np.asarray(0.5 * value_at(beam.section, name, places) * np.ones_like(places))

    high, wide = half("height"), half("width")
    if shape == "rectangle":
        right = [(high, wide), (-high, wide)]
    else:  # from the top flange down to the web, along it, and out to the lower flange
        inner, web = high - 2.0 * half("flange_thickness"), half("web_thickness")
        right = [(high, wide), (inner, wide), (inner, web), (-inner, web), (-inner, wide), (-high, wide)]
    corners = np.array(right + [(y, -z) for y, z in reversed(right)]).transpose(2, 0, 1)
    # points along the edges, first along the one that ends in the first corner, on top of the beam
    start = np.roll(corners, 1, axis=1)
    edges = corners - start
    per_edge = SIDES // corners.shape[1]
    points = start[:, :, None] + np.linspace(0.0, 1.0, per_edge)[:, None] * edges[:, :, None]
    normals = np.stack([edges[..., 1], -edges[..., 0]], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return points.reshape(-1, SIDES, 2), np.repeat(normals, per_edge, axis=1)
