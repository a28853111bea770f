"""Shapes of cross-sections with their sizes: area, second moment of area and outer fibre from them, at every x.

The height of a section lies in the plane of motion, its width across it; the second moment is that about the
axis across the plane, through the centre (Young, Budynas, Sadegh, Roark's Formulas for Stress and Strain, 8th
edition, table A.1).  Sizes that are tables over x are linear between their rows; what follows from them is not.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

from oblique_impact.scenario.tables import Table

#: degree in x of a second moment of area between two rows of sizes; that of an area is two less
DEGREE = 4


class Shape(NamedTuple):
    """A shape: names of its sizes (m), and its properties as functions of numbers or arrays of them."""

    sizes: tuple[str, ...]
    area: Callable[..., Any]  # m^2
    second_moment: Callable[..., Any]  # m^4
    outer_fibre: Callable[..., Any]  # m


class Sized(Protocol):
    """A cross-section: the name of its shape, and its sizes as attributes."""

    @property
    def shape(self) -> str:
        """Name in `SHAPES`, or "" for none."""


def _between_flanges(height: Any, flange_thickness: Any) -> Any:
    return height - 2.0 * flange_thickness


SHAPES = {
    "rectangle": Shape(
        ("width", "height"),
        lambda width, height: width * height,
        lambda width, height: width * height**3 / 12.0,
        lambda width, height: 0.5 * height,
    ),
    "circle": Shape(
        ("diameter",),
        lambda diameter: 0.25 * math.pi * diameter**2,
        lambda diameter: math.pi / 64.0 * diameter**4,
        lambda diameter: 0.5 * diameter,
    ),
    "tube": Shape(
        ("diameter", "thickness"),
        lambda diameter, thickness: math.pi * thickness * (diameter - thickness),
        lambda diameter, thickness: math.pi / 64.0 * (diameter**4 - (diameter - 2.0 * thickness) ** 4),
        lambda diameter, thickness: 0.5 * diameter,
    ),
    "i-beam": Shape(
        ("width", "height", "flange_thickness", "web_thickness"),
        lambda width, height, flange_thickness, web_thickness: (
            2.0 * width * flange_thickness + web_thickness * _between_flanges(height, flange_thickness)
        ),
        lambda width, height, flange_thickness, web_thickness: (
            (width * height**3 - (width - web_thickness) * _between_flanges(height, flange_thickness) ** 3) / 12.0
        ),
        lambda width, height, flange_thickness, web_thickness: 0.5 * height,
    ),
}
#: sizes of a shape that are limited by a part of another one
_INSIDE = {
    "tube": (("thickness", 0.5, "diameter"),),
    "i-beam": (("flange_thickness", 0.5, "height"), ("web_thickness", 1.0, "width")),
}
#: properties of a shape, by their keys in [beam]
SHAPE_PROPERTIES = ("area", "second_moment", "outer_fibre")
SIZES = tuple(dict.fromkeys(size for shape in SHAPES.values() for size in shape.sizes))


def rows_of(section: Sized) -> list[float]:
    """Return the places (m) of the rows of all tables of sizes, ascending; none if the section is uniform."""
    tables = [getattr(section, size) for size in SIZES]
    return sorted({x for table in tables if isinstance(table, tuple) for x, _ in table})


def at_x(size: float | Table, x: Any) -> Any:
    """Return a number, or a table over x, at x (m), of the shape of x."""
    import numpy as np

    return np.interp(x, *np.array(size).T) if isinstance(size, tuple) else size + 0.0 * np.asarray(x)


def value_at(section: Sized, name: str, x: Any) -> Any:
    """Return a size, or the area, second moment or outer fibre of a section, at x (m), of the shape of x."""
    if name in SIZES:
        return at_x(getattr(section, name), x)
    shape = SHAPES[section.shape]
    return getattr(shape, name)(**{size: value_at(section, size, x) for size in shape.sizes})


def shape_property(section: Sized, name: str) -> float | Table | None:
    """Return the area, second moment or outer fibre: a number, or a table with the rows of the sizes.

    None without a shape, or if a size is missing.
    """
    shape = SHAPES.get(section.shape)
    if shape is None or any(getattr(section, size) == 0.0 for size in shape.sizes):
        return None
    rows = rows_of(section)
    if not rows:
        return float(getattr(shape, name)(**{size: getattr(section, size) for size in shape.sizes}))
    return tuple((x, float(value_at(section, name, x))) for x in rows)


def size_conflict(section: Sized) -> str:
    """Return as text which size is too large for another one, at any row; "" if none."""
    for thin, part, whole in _INSIDE.get(section.shape, ()):
        for x in rows_of(section) or [0.0]:
            if float(value_at(section, thin, x)) > part * float(value_at(section, whole, x)):
                return f"{thin} is more than {'half of ' if part < 1.0 else ''}{whole}"
    return ""
