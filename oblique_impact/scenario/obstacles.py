"""What the beam can touch, as geometry: straight sides and points."""

from __future__ import annotations

import math
from typing import NamedTuple


class Side(NamedTuple):
    """A straight side; the solid is on its right."""

    obstacle: int  # the slope is 0, the others count from 1
    origin: tuple[float, float]  # m
    angle: float  # rad
    extent: tuple[float, ...]  # m along it from its origin, where it ends; empty without ends
    stiffness: float  # N/m

    @property
    def offsets(self) -> tuple[float, float]:
        """Height of `origin` above the root's axis across the side, and its place along it (m)."""
        (x, y), c, s = self.origin, math.cos(self.angle), math.sin(self.angle)
        return y * c - x * s, x * c + y * s

    def at(self, place: float) -> tuple[float, float]:
        """Return a point of the side, `place` m along it from its origin."""
        return self.origin[0] + place * math.cos(self.angle), self.origin[1] + place * math.sin(self.angle)


class ObstaclePoint(NamedTuple):
    """A point that the beam can touch anywhere along its span: the end of a side, a corner, a peg."""

    obstacle: int
    x: float  # m
    y: float
    radius: float  # m, of a peg
    stiffness: float  # N/m
    corner: bool  # whether it is the end of a side
