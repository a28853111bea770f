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

SIDES = 36  # points of a ring: of a circle, or the twelve edges of an i-beam with three each
#: of a ring that shows a section with corners by the two ends of each edge, and a circle with its four extremes
_FEW = {"rectangle": 8, "i-beam": 24}
_FEW_OF_A_CIRCLE = 20
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


def few_sides(shape: str) -> int:
    """Return the number of points of a ring that show a cross-section, in a file for other programs."""
    return _FEW.get(shape, _FEW_OF_A_CIRCLE)


def solid_of(
    beam: BeamSection, places: Array, radii: Array, mass_radius: float, flat: bool, sides: int = SIDES
) -> Solid:
    """Return the points of a beam with rings of `radii` (m) at `places` (m), with so many `sides` each.

    It ends in a sphere of `mass_radius` (m) if this is positive, else in a plane if it is `flat`, or a hemisphere.
    """
    outline, normals = _rings(beam, places, radii, sides)
    radius = mass_radius or (0.0 if flat else float(radii[-1]))  # of the end
    if radius > 0.0:
        # a sphere begins where it comes out of the beam
        first, steps = (-np.arccos(min(radii[-1] / radius, 1.0)), 2 * _CAP) if mass_radius else (0.0, _CAP)
        elevation = np.linspace(first, 0.5 * np.pi, steps + 1)[1:-1, None, None]
        end_normals = np.concatenate(
            [np.broadcast_to(np.sin(elevation), (steps - 1, sides, 1)), np.cos(elevation) * _circle(sides)],
            axis=2,
        )
        end = radius * end_normals
    else:
        # rings whose width shrinks to nothing while their height stays: they fill the end of an i-beam and no more
        widths = np.linspace(1.0, 0.0, _CAP - 1)[:, None, None]
        end = np.insert(outline[-1] * np.concatenate([np.ones_like(widths), widths], axis=2), 0, 0.0, axis=2)
        end_normals = np.broadcast_to((1.0, 0.0, 0.0), end.shape)
    count = places.size + len(end)
    body, body_normals = (np.insert(values, 0, 0.0, axis=2) for values in (outline, normals))
    poles = np.array([(radius, 0.0, 0.0), (0.0, 0.0, 0.0)])
    outward = np.array([(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)])
    return Solid(
        np.append(np.repeat(np.minimum(np.arange(count), places.size - 1), sides), [places.size - 1, 0]),
        np.concatenate([body.reshape(-1, 3), end.reshape(-1, 3), poles]),
        np.concatenate([body_normals.reshape(-1, 3), end_normals.reshape(-1, 3), outward]),
        _faces(count, sides),
    )


def _faces(rings: int, sides: int) -> NDArray[np.int64]:
    """Return the faces between rings, around the pole and around the centre of the root."""
    i, side = np.arange(rings - 1)[:, None], np.arange(sides)
    after, last, pole = (side + 1) % sides, (rings - 1) * sides, rings * sides
    a, b = i * sides + side, i * sides + after
    quads = np.stack([np.full_like(a, 4), a, b, b + sides, a + sides], axis=-1)
    three = np.full(sides, 3)
    tip = np.stack([three, last + side, last + after, np.full(sides, pole)], axis=-1)
    root = np.stack([three, np.full(sides, pole + 1), after, side], axis=-1)
    return np.concatenate([quads.ravel(), tip.ravel(), root.ravel()])


def _circle(sides: int) -> Array:
    angle = 2.0 * np.pi * np.arange(sides) / sides
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _rings(beam: BeamSection, places: Array, radii: Array, sides: int) -> tuple[Array, Array]:
    """Return the rings (rings, sides, 2), across the axis and out of the plane, and their normals."""
    shape = beam.section.shape
    if not has_corners(shape):
        return radii[:, None, None] * _circle(sides), np.broadcast_to(_circle(sides), (places.size, sides, 2))

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
    per_edge = sides // corners.shape[1]
    points = start[:, :, None] + np.linspace(0.0, 1.0, per_edge)[:, None] * edges[:, :, None]
    normals = np.stack([edges[..., 1], -edges[..., 0]], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return points.reshape(-1, sides, 2), np.repeat(normals, per_edge, axis=1)
