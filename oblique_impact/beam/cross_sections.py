"""Cross-sections along the beam, and the exact integrals of mass that the operators need."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from oblique_impact.errors import InputError
from oblique_impact.scenario.model import PointMass
from oblique_impact.scenario.shapes import DEGREE, rows_of, value_at
from oblique_impact.scenario.tables import Table

if TYPE_CHECKING:
    from oblique_impact.scenario.scenario import Scenario
    from oblique_impact.scenario.sections import BeamSection, RootSection

Array = NDArray[np.float64]

#: 1/s^2; bounds of E I/(m L^4): its square and more occur in the computation, and must be floating-point numbers
FREQUENCY_SQUARES = (1e-60, 1e60)
_GAUSS = 12  # points between two rows of a table: 1e-12 where the area changes by a factor of four


@dataclass(frozen=True)
class Profile:
    """A piecewise linear function of x on [0, length]."""

    x: Array  # (rows,) m, ascending from 0 to the length
    values: Array  # (rows,)

    @classmethod
    def of(cls, value: float | Table, length: float) -> Profile:
        """Take a number, or the rows of a table."""
        if isinstance(value, tuple):
            rows = np.array(value, dtype=float)
            return cls(rows[:, 0].copy(), rows[:, 1].copy())
        return cls(np.array([0.0, length]), np.array([value, value], dtype=float))

    def __call__(self, x: Array | float) -> Array:
        """Values at x (m), of the shape of x."""
        return np.asarray(np.interp(x, self.x, self.values))


@dataclass(frozen=True)
class ShapedProfile(Profile):
    """A property of a shape whose sizes are linear between the rows: a polynomial of x there."""

    function: Callable[[Array | float], Array]

    def __call__(self, x: Array | float) -> Array:
        """Values at x (m), of the shape of x."""
        return np.asarray(self.function(x))


@dataclass(frozen=True)
class Sections:
    """Cross-sections, material, point masses, hub and clamp of a beam, in SI units.

    With the mass per length m(x) = rho A(x), point masses M_k at x_k and r = hub_radius, swapping the order of
    integration in C and D (theory, Sec. 1) leaves the weights

        outer_mass(x)   = int_x^L m dxi + sum of M_k for x_k >= x
        outer_moment(x) = int_x^L m (r + xi) dxi + sum of M_k (r + x_k) for x_k >= x

    All integrals are exact: m (r + x)^2 is at most cubic between two rows of the table, where Simpson's
    rule makes no error.  Of a shape with sizes over x it is quartic, which Boole's rule integrates without one.
    """

    length: float
    hub_radius: float
    density: float
    youngs_modulus: float
    area: Profile
    second_moment: Profile
    masses: tuple[PointMass, ...] = ()  # by place, ascending
    outer_fibre: Profile | None = None  # m, None: circular sections of the given area
    degree: int = 1  # of E I in x between two kinks
    hub_inertia: float = 0.0  # kg m^2, of a hub that turns freely
    clamp_stiffness: float = 0.0  # N m/rad, of a clamp that yields between a drive and the root; 0: it is rigid

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> Sections:
        """Return the cross-sections of the beam of `scenario`: the same object for equal beams on equal roots."""
        return _sections_of(scenario.beam, scenario.root, scenario.point_masses)

    @cached_property
    def kinks(self) -> Array:
        """Places (m) inside the span where m or E I changes its slope or a point mass sits, ascending."""
        of_masses = self.places[self.places < self.length]
        return np.unique(np.concatenate([self.area.x[1:-1], self.second_moment.x[1:-1], of_masses]))

    @cached_property
    def places(self) -> Array:
        """Places (m) of the point masses, (k,)."""
        return np.array([point.place for point in self.masses])

    @cached_property
    def point_masses(self) -> Array:
        """Point masses (kg), (k,)."""
        return np.array([point.mass for point in self.masses])

    @cached_property
    def point_inertias(self) -> Array:
        """Moments of inertia (kg m^2) of the point masses about their own centres, (k,)."""
        return np.array([point.inertia for point in self.masses])

    def mass_per_length(self, x: Array | float) -> Array:
        """Return rho A(x) in kg/m, of the shape of x."""
        return self.density * self.area(x)

    def bending_stiffness(self, x: Array | float) -> Array:
        """Return E I(x) in N m^2, of the shape of x."""
        return self.youngs_modulus * self.second_moment(x)

    def fibre_distance(self, x: Array | float) -> Array:
        """Distance (m) of the outer fibre from the axis, of the shape of x; sqrt(A/pi) if none is given."""
        return np.sqrt(self.area(x) / np.pi) if self.outer_fibre is None else self.outer_fibre(x)

    def axial_flexibility(self, x: Array | float) -> Array:
        """Return int_0^x ds/(E A) (m/N), of the shape of x: static flexibility along the axis from the root to x.

        Gauss's rule between x and the rows of a table: exact of uniform beams.
        """
        place, edges = np.asarray(x, dtype=float), self.area.x
        nodes, weights = np.polynomial.legendre.leggauss(_GAUSS)
        total = np.zeros(place.shape)
        for a, b in pairwise(edges):
            half = 0.5 * (np.clip(place, a, b) - a)
            at = a + half[..., None] * (1.0 + nodes)
            total += half * (weights / (self.youngs_modulus * self.area(at))).sum(axis=-1)
        return total

    def outer_mass(self, x: Array | float) -> Array:
        """Mass (kg) outside of x, of the shape of x; a point mass at x is outside."""
        return self._outer(x, 0) + self._beyond(x, self.point_masses)

    def outer_moment(self, x: Array | float) -> Array:
        """First moment (kg m) about the axis of rotation of the mass outside of x, of the shape of x."""
        return self._outer(x, 1) + self._beyond(x, self.point_masses * (self.hub_radius + self.places))

    def outer_inertia_moment(self, x: Array | float) -> Array:
        """Return int_x^L m (r + xi) (xi - x) dxi (kg m^2): moment about x of the inertia outside of it.

        That of an angular acceleration of 1 rad/s^2; point masses turn besides about their own centres.
        """
        r, place = self.hub_radius, np.asarray(x, dtype=float)
        own = self._outer(place, 2) - (r + place) * self._outer(place, 1)
        arms = self.places - place[..., None]
        points = self._beyond(place, self.point_masses * (r + self.places) * arms + self.point_inertias)
        return np.asarray(own + points)

    @cached_property
    def own_mass(self) -> float:
        """Mass (kg) of the beam without point masses."""
        return float(self._outer(0.0, 0))

    @cached_property
    def mass(self) -> float:
        """Total mass (kg)."""
        return float(self.outer_mass(0.0))

    @cached_property
    def static_moment(self) -> float:
        """Sm = int m (r + x) (kg m), with point masses."""
        return float(self.outer_moment(0.0))

    @cached_property
    def inertia(self) -> float:
        """J = int m (r + x)^2 (kg m^2), with point masses as points, without the hub."""
        squares = self.point_masses * (self.hub_radius + self.places) ** 2
        return float(self._outer(0.0, 2) + self._beyond(0.0, squares))

    @cached_property
    def whole_inertia(self) -> float:
        """J with the inertia of the hub and that of point masses about their own centres (kg m^2)."""
        return self.inertia + self.hub_inertia + float(self.point_inertias.sum())

    def _beyond(self, x: Array | float, values: Array) -> Array:
        """Sum of values (k,) or (..., k) of the point masses at x and outside of it, of the shape of x."""
        outside = np.asarray(x, dtype=float)[..., None] <= self.places
        return np.asarray(np.where(outside, values, 0.0).sum(axis=-1))

    def _outer(self, x: Array | float, power: int) -> Array:
        """Int_x^L m (r + xi)^power dxi, summed from the tip inwards so that it keeps its digits there."""
        edges = self.area.x
        pieces = self._integral(edges[:-1], edges[1:], power)
        beyond = np.append(np.cumsum(pieces[::-1])[::-1], 0.0)
        place = np.asarray(x, dtype=float)
        piece = np.clip(np.searchsorted(edges, place, side="right") - 1, 0, edges.size - 2)
        return np.asarray(self._integral(place, edges[piece + 1], power) + beyond[piece + 1])

    def _integral(self, a: Array, b: Array, power: int) -> Array:
        """Exact integral of m (r + xi)^power over [a, b] inside one piece of the table."""
        once = self._simpson(a, b, power)
        if self.degree == 1:
            return once
        middle = 0.5 * (a + b)
        twice = self._simpson(a, middle, power) + self._simpson(middle, b, power)
        return twice + (twice - once) / 15.0

    def _simpson(self, a: Array, b: Array, power: int) -> Array:
        """Integral of m (r + xi)^power over [a, b] by Simpson's rule."""
        middle = 0.5 * (a + b)
        left, centre, right = (self.mass_per_length(s) * (self.hub_radius + s) ** power for s in (a, middle, b))
        return np.asarray((b - a) / 6.0 * (left + 4.0 * centre + right))


@lru_cache(maxsize=8)
def _sections_of(beam: BeamSection, root: RootSection, masses: tuple[PointMass, ...]) -> Sections:
    varies = beam.section.shape != "" and len(rows_of(beam.section)) > 0

    def profile(name: str) -> Profile:
        plain = Profile.of(getattr(beam, name), beam.length)
        return ShapedProfile(plain.x, plain.values, partial(value_at, beam.section, name)) if varies else plain

    return Sections(
        beam.length,
        root.hub_radius,
        beam.density,
        beam.youngs_modulus,
        profile("area"),
        profile("second_moment"),
        masses,
        profile("outer_fibre") if beam.outer_fibre else None,
        DEGREE if varies else 1,
        root.inertia if root.kind == "hub" else 0.0,
        root.stiffness if root.kind == "driven" else 0.0,
    )


def check_numbers(sections: Sections) -> None:
    """Raise InputError for a beam whose frequencies floating-point numbers cannot hold."""
    with np.errstate(all="ignore"):
        x = np.union1d(sections.area.x, sections.second_moment.x)
        masses = sections.mass_per_length(x) * np.float64(sections.length) ** 4
        squares = sections.bending_stiffness(x) / masses
    least, most = FREQUENCY_SQUARES
    if not np.all((squares >= least) & (squares <= most)):
        found = np.min(squares) if not np.min(squares) >= least else np.max(squares)
        square = "youngs_modulus * second_moment/(density * area * length^4)"
        words = f"is {found:.3g} 1/s^2, should be {least:g} to {most:g}; are the units right?"
        raise InputError(f"beam: the square of its frequency, {square}, {words}")
