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
#: corners of half an i-beam from its top down: part of the height, of the height between the flanges, of the width
#: and of the web's thickness
_I_BEAM = np.array([(1, 0, 1, 0), (0, 1, 1, 0), (0, 1, 0, 1), (0, -1, 0, 1), (0, -1, 1, 0), (-1, 0, 1, 0)])
_RECTANGLE = np.array([(1, 0, 1, 0), (-1, 0, 1, 0)])
_FLAT = np.array([1.0, 0.75, 0.5, 0.25, 0.0])  # of the width: rings of a flat end


class Solid(NamedTuple):
    """Points of a beam: rings, those of the end, the pole of the end, the centre of the root."""

    rings: NDArray[np.int64]  # (np,) the ring at whose place a point is
    offsets: Array  # (np, 3) m
    directions: Array  # (np, 3) outward normals


def solid_of(
    beam: BeamSection, places: Array, radii: Array, mass_radius: float, cap_rings: int, flat: bool = False
) -> Solid:
    """Return the points of a beam with rings of `radii` (m) at `places` (m), and `cap_rings` - 1 rings at its end.

    A mass at the tip is a sphere of `mass_radius` (m) there, 0 without one: then the end is a hemisphere of a
    round beam, unless it is to be `flat`, and flat of another.
    """
    outline, normals = _rings(beam, places, radii)
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    steps = np.arange(1, cap_rings) / cap_rings
    if mass_radius > 0.0 or not (flat or has_corners(beam.section.shape)):
        radius = mass_radius or radii[-1]
        # a sphere begins where it comes out of the beam
        first = -np.arccos(min(radii[-1] / radius, 1.0)) if mass_radius > 0.0 else 0.0
        elevation = first + (0.5 * np.pi - first) * steps
        along, pole = radius * np.sin(elevation), float(radius)
        end = radius * np.cos(elevation)[:, None, None] * circle
        end_normals = np.concatenate(
            [
                np.broadcast_to(np.sin(elevation)[:, None, None], (*end.shape[:2], 1)),
                np.cos(elevation)[:, None, None] * circle,
            ],
            axis=2,
        )
    else:  # what is left of the width shrinks to nothing: so an i-beam's end is filled and no more
        width = np.interp(steps, np.linspace(steps[0], steps[-1], _FLAT.size), _FLAT)
        along, pole = np.zeros(width.size), 0.0
        end = np.stack(
            [np.broadcast_to(outline[-1, :, 0], (width.size, SIDES)), width[:, None] * outline[-1, :, 1]], -1
        )
        end_normals = np.broadcast_to(np.array([1.0, 0.0, 0.0]), (*end.shape[:2], 3))
    count = places.size
    body = np.concatenate([np.zeros((count, SIDES, 1)), outline], axis=2).reshape(-1, 3)
    cap = np.concatenate([np.broadcast_to(along[:, None, None], (*end.shape[:2], 1)), end], axis=2).reshape(-1, 3)
    body_normals = np.concatenate([np.zeros((count, SIDES, 1)), normals], axis=2).reshape(-1, 3)
    rings = np.repeat(np.minimum(np.arange(count + end.shape[0]), count - 1), SIDES)
    ends = np.array([(pole, 0.0, 0.0), (0.0, 0.0, 0.0)])
    outward = np.array([(1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)])
    return Solid(
        np.append(rings, [count - 1, 0]),
        np.concatenate([body, cap, ends]),
        np.concatenate([body_normals, end_normals.reshape(-1, 3), outward]),
    )


def has_corners(shape: str) -> bool:
    """Whether a cross-section is drawn by its corners, not round."""
    return shape in _CORNERS


def _rings(beam: BeamSection, places: Array, radii: Array) -> tuple[Array, Array]:
    """Return the rings (rings, SIDES, 2), across the axis and out of the plane, and their normals."""
    corners = _CORNERS.get(beam.section.shape)
    if corners is None:
        angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
        circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        return radii[:, None, None] * circle, np.broadcast_to(circle, (places.size, SIDES, 2))
    sizes = {name: np.asarray(value_at(beam.section, name, places)) for name in ("width", "height")}
    inner, web = np.zeros(places.size), np.zeros(places.size)
    if beam.section.shape == "i-beam":
        inner = sizes["height"] - 2.0 * np.asarray(value_at(beam.section, "flange_thickness", places))
        web = np.asarray(value_at(beam.section, "web_thickness", places))
    half = np.stack(
        [
            0.5 * (np.outer(sizes["height"], corners[:, 0]) + np.outer(inner, corners[:, 1])),
            0.5 * (np.outer(sizes["width"], corners[:, 2]) + np.outer(web, corners[:, 3])),
        ],
        axis=2,
    )
    around = np.concatenate([half, half[:, ::-1] * np.array([1.0, -1.0])], axis=1)  # all corners
    return _edges(around)


def _edges(corners: Array) -> tuple[Array, Array]:
    """Return points (rings, SIDES, 2) along the edges of polygons (rings, corners, 2), with the edges' normals.

    The first edge is the one that ends in the first corner, on top of the beam.
    """
    count = SIDES // corners.shape[1]
    start, stop = np.roll(corners, 1, axis=1), corners
    part = np.linspace(0.0, 1.0, count)[:, None]
    points = start[:, :, None] + part * (stop - start)[:, :, None]
    along = stop - start
    normals = np.stack([along[..., 1], -along[..., 0]], axis=-1)
    normals = normals / np.linalg.norm(normals, axis=-1, keepdims=True)
    spread = np.broadcast_to(normals[:, :, None], points.shape)
    return points.reshape(len(corners), SIDES, 2), spread.reshape(len(corners), SIDES, 2)


#: what is drawn by its corners
_CORNERS = {"rectangle": _RECTANGLE, "i-beam": _I_BEAM}
