"""Obstacles: the straight sides and the points fixed in space that the beam can touch."""

from __future__ import annotations

import cmath
import math
from typing import Any, NamedTuple


class Side(NamedTuple):
    """A straight side of an obstacle, solid on its right: its normal is (-sin(angle), cos(angle))."""

    obstacle: int  # 0 is the slope, [[obstacles]] count from 1
    origin: tuple[float, float]  # m, from the axis of the root
    angle: float  # rad, from the horizontal
    extent: tuple[float, ...]  # m along the side from `origin`, (first, last); () is unbounded
    stiffness: float  # N/m, of an elastic stop
    bedding: float = 0.0  # N/m^2, in place of the stiffness
    corners: tuple[bool, bool] = (True, True)  # whether its beginning and its end are corners that are its own
    reach: tuple[float, float] = (
        0.0,
        0.0,
    )  # m, how far it goes on into the solid before its beginning, behind its end

    @property
    def offsets(self) -> tuple[float, float]:
        """Height c_n of `origin` above the root's axis across the side, and its place c_t along it (m)."""
        (x, y), c, s = self.origin, math.cos(self.angle), math.sin(self.angle)
        return y * c - x * s, x * c + y * s

    @property
    def ends(self) -> tuple[tuple[float, float], ...]:
        """Places [x, y] (m) where the side begins and ends; none if it is unbounded."""
        (x, y), c, s = self.origin, math.cos(self.angle), math.sin(self.angle)
        return tuple((x + along * c, y + along * s) for along in self.extent)

    def slip_and_gap(self, z: Any) -> Any:
        """Return slip + i gap (m) of points z = x + i y (m): the place along the side, the height above it."""
        height, along = self.offsets
        return cmath.exp(-1j * self.angle) * z - (along + 1j * height)

    def lengthened(self, cell: tuple[float, float]) -> Side:
        """Return the side, longer by a cell that reaches along it from a place (m before it, m after it).

        And by its reach into the solid.
        """
        if not self.extent:
            return self
        (before, after), (first, last), (back, on) = cell, self.extent, self.reach
        return self._replace(extent=(first - after - back, last + before + on))

    def is_beside(self, along: float) -> bool:
        """Return whether a place along the side (m from `origin`) lies between its ends."""
        return not self.extent or self.extent[0] <= along <= self.extent[1]

    def facing(self, angle: float) -> float:
        """Return 1 or -1: the side of its axis with which a beam at `angle` (rad) to the horizontal looks here."""
        return -math.copysign(1.0, math.cos(angle - self.angle))

    def gap_and_place(
        self, reach: float, angle: float, half_depth: float = 0.0, axis: complex = 0.0
    ) -> tuple[float, float]:
        """Return gap, and place along the side from `origin` (m), of a point of a straight beam.

        The beam lies at `angle` (rad) to the horizontal, the point `reach` (m) from the axis of the root, which is
        at x + i y = `axis` (m), and `half_depth` (m) from the beam's axis, towards the side.
        """
        turned = cmath.exp(1j * angle) * complex(reach, self.facing(angle) * half_depth)
        found = self.slip_and_gap(axis + turned)
        return found.imag, found.real


class ObstaclePoint(NamedTuple):
    """A point fixed in space that the beam can touch at any place: a peg, or the end of a side."""

    obstacle: int  # 0 is the slope, [[obstacles]] count from 1
    x: float  # m, from the axis of the root
    y: float  # m
    radius: float  # m, of a peg; 0 at a corner
    stiffness: float  # N/m, of an elastic stop
    corner: bool  # whether it is the end of a side

    def seen_from(self, axis: complex, angle: float) -> complex:
        """Return its centre (m) along a straight beam at `angle` (rad) from `axis` (m), and to the left of it."""
        return cmath.exp(-1j * angle) * (complex(self.x, self.y) - axis)

    def distance(self, first: float, last: float, angle: float, axis: complex = 0.0) -> float:
        """Return the distance (m) of its centre from a straight beam between two radii (m).

        The beam lies at `angle` (rad) to the horizontal, the axis of its root is at x + i y = `axis` (m).
        """
        seen = self.seen_from(axis, angle)
        return abs(seen - min(max(seen.real, first), last))
