"""BeamOperators: the matrices and tables of a discretized beam, and how they are obtained."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, fields, replace
from functools import cache, cached_property, lru_cache
from importlib import import_module
from numbers import Number
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, cholesky, eigh, solve_triangular, svd
from scipy.sparse import csr_array, issparse

from oblique_impact.beam.axis import ShapeFunctions
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.errors import InputError
from oblique_impact.kernels.workspace import own_numbers
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.sections import ContactSection, ForceSection

#: a first square of a frequency below this part of the second is looked for alone
_FAR = 1e-4
#: nearer places (over the length) are one
_SAME_PLACE = 1e-12

Array = NDArray[np.float64]
#: a matrix of operators, (n, n) or (points, n): dense, or a `csr_array` of a nodal model
Matrix = Any


@dataclass(frozen=True)
class ShapeTable:
    """Shape functions and their slopes at the points of a composite Gauss rule over the whole span.

    Panels end where point masses are and forces act.
    """

    order: int  # points per panel
    points: Array  # (nq,) m, ascending
    weights: Array  # (nq,) m
    values: Matrix  # (nq, n) Phi
    slopes: Matrix  # (nq, n) Phi' (1/m)


@dataclass(frozen=True)
class StationTable:
    """Shape functions at the output stations; `cells[k]:cells[k+1]` are the quadrature points between two."""

    points: Array  # (ns,) m, from 0 to the length
    values: Matrix  # (ns, n)
    slopes: Matrix  # (ns, n) Phi' (1/m)
    curvatures: Matrix  # (ns, n) Phi'' (1/m^2)
    quadrature: ShapeTable
    cells: NDArray[np.int64]  # (ns,)


class Turning(NamedTuple):
    """What turns with sections of the beam: the hub with the root, and point masses that have an inertia."""

    inertias: Array  # (k,) kg m^2, the hub's first, which may be 0
    slopes: Array  # (k, n) Phi' there (1/m)


@dataclass(frozen=True)
class BeamOperators:
    """Matrices, vectors and tables of a discretized beam, in SI units.

    n shape functions Phi (row) of the arc-length label x in [0, length]; r = hub_radius.  With m(x) the
    mass per length, point masses included (theory: Sec. 1 of the documentation; H(x) = int_0^x Phi'^T Phi' dxi),
    all of the beam alone, without what turns with its sections, hub and inertias of point masses, and without the
    spring of a clamp:

        M1 = int m Phi^T Phi        K = int E I Phi''^T Phi''
        C  = int m (r + x) H        D = int m H
        S  = int m (r + x) Phi      P = int m Phi
        J  = int m (r + x)^2        Sm = int m (r + x)

    Matrices and tables are dense for a reduced model, sparse (``csr_array``) for a nodal one.
    """

    sections: Sections
    M1: Matrix
    K: Matrix
    C: Matrix
    D: Matrix
    S: Array
    P: Array
    J: float
    Sm: float
    contact_point: float  # x_F
    contact_shape: Array  # (n,) Phi(x_F)
    contact_shortening: Matrix  # (n, n) H(x_F)
    root_slope: Array  # (n,) Phi'(0)
    stations: StationTable
    rigid: Array = field(default_factory=lambda: np.zeros(0))  # (n,) the function x; of a nodal model only
    curvature_factor: Matrix = None  # (points, n) G with K = G^T G; of a nodal model
    largest_element: float = 0.0  # m, of a nodal model
    left_out: float = 0.0  # m/N, compliance of a contact point that a nodal model has condensed
    along: ShapeFunctions | None = None  # at any place, for contact anywhere along the beam
    means: Matrix = None  # (elements, n) mean deflection of each element, where nodes have no inertia

    @property
    def size(self) -> int:
        """Number n of shape functions."""
        return int(self.P.shape[0])

    @cached_property
    def turning(self) -> Turning:
        """Hub and point masses with an inertia."""
        inertias = self.sections.point_inertias
        places = self.sections.places[inertias > 0.0]
        slopes = np.vstack([self.root_slope[None], *([self.rows_at(places, 1)] if places.size else [])])
        return Turning(np.append(self.sections.hub_inertia, inertias[inertias > 0.0]), slopes)

    def rows_at(self, places: Array, order: int) -> Array:
        """Return the shape functions (order 0) or their slopes (1) at places (m), (places, n).

        Operators without `along` have them at their stations alone; raises InputError for other places.
        """
        if self.along is not None:
            return np.asarray(self.along.derivative(places, order))
        stations = self.stations
        nearest = np.abs(stations.points - places[:, None]).argmin(axis=1)
        if np.any(np.abs(stations.points[nearest] - places) > _SAME_PLACE * self.sections.length):
            where = "masses and forces need shape functions anywhere, BeamOperators.along"
            raise InputError(f"discretization: {where}")
        rows = (stations.values, stations.slopes)[order][nearest]
        return np.asarray(rows.toarray() if issparse(rows) else rows)

    @property
    def elastic_mass(self) -> Matrix:
        """M1 + sum J_k Phi'(x_k)^T Phi'(x_k) (n, n): with the hub's and what turns with other sections."""
        mass = self.M1
        for inertia, slope in zip(*self.turning, strict=True):
            mass = mass + inertia * self._squared(slope)
        return mass

    @property
    def stiffness(self) -> Matrix:
        """K + k Phi'(0)^T Phi'(0) (n, n): bending, with the spring of a clamp that yields at a driven root.

        The spring of a hub couples the elastic coordinates with its angle and is not in it.
        """
        clamp = self.sections.clamp_stiffness
        return self.K + clamp * self._squared(self.root_slope) if clamp > 0.0 else self.K

    def _squared(self, slope: Array) -> Matrix:
        """Phi'^T Phi' (n, n) of slopes (n,)."""
        row = slope[None]
        if issparse(self.M1):
            row = csr_array(row)
        return row.T @ row

    @property
    def coupling(self) -> Array:
        """S + sum J_k Phi'(x_k) (n,): coupling to the rigid rotation of beam and hub; 0 in the mean-axis frame."""
        return np.asarray(self.S + self.turning.inertias @ self.turning.slopes)

    @property
    def inertia(self) -> float:
        """J + sum J_k (kg m^2)."""
        return self.J + float(self.turning.inertias.sum())

    @cached_property
    def contact_slope(self) -> Array:
        """Slopes Phi'(x_F) (n,) of the shape functions at the contact point, one of the stations (1/m)."""
        row = self.stations.slopes[[int(np.argmin(np.abs(self.stations.points - self.contact_point)))]]
        slopes: Array = np.asarray(row.toarray() if issparse(row) else row)[0]
        return slopes

    def natural_frequencies(self) -> Array:
        """Return the angular frequencies (rad/s) of the elastic coordinates at rest, ascending.

        In the mean-axis frame those of the beam with its hub.  A nodal model has its rigid rotation among them.
        """
        if issparse(self.K):
            factor, mass = self.curvature_factor.toarray(), self.elastic_mass.toarray()
            return np.asarray(np.linalg.norm(factor @ eigenvectors(factor, mass), axis=0))
        squares = eigh(self.stiffness, self.elastic_mass, lower=False, eigvals_only=True)
        return np.asarray(np.sqrt(np.maximum(squares, 0.0)))


def eigenvectors(factor: Array, mass: Array) -> Array:
    """Return the eigenvectors (n, n) of K = G^T G with `factor` G (points, n), ascending, scaled to v^T M v = 1.

    They are singular vectors of G L^-T, M = L L^T.  G has half the condition exponent of K, so modes of low
    frequency keep their digits on fine meshes.
    """
    lower = cholesky(mass, lower=True)
    scaled = solve_triangular(lower, factor.T, lower=True)
    left, _, _ = svd(scaled, full_matrices=True, lapack_driver="gesvd")
    return np.asarray(solve_triangular(lower, left, lower=True, trans="T")[:, ::-1])


@dataclass(frozen=True)
class SpinningBeam:
    """A beam that spins at a constant rate, in shape functions seen from its root, clamped or on a spring.

    A root that is free to turn moves the beam by r + x besides.  This rigid rotation has no elastic energy, and
    C (r + x) = M1 (r + x), so it is a mode at any rate Omega, and the elastic ones are orthogonal to it in the
    mass of beam and hub.  With S = M1 (r + x) and the inertia J of both (Southwell and Gough 1921; Wright et al.
    1982),

        (K + Omega^2 (C - M1)) v = omega^2 (M1 - S S^T/J) v    chordwise, in the plane of rotation
        omega_f^2 = omega^2 + Omega^2                          flapwise, out of it

    A held root has J = infinity, a pin the inertia of the beam.  Flapwise the joint is the same: a pin is a ball
    joint, and a hub tilts with its inertia, like an arm along the beam.  A hub on an axle that it cannot tilt
    vibrates flapwise like a held root.

    A hub on a spring to the ground does not spin; its angle is then one more coordinate of a beam that is held.

    Inertias of point masses are arms along the beam too: in the plane of rotation their energy of spin does not
    depend on how they are turned, out of it the spin turns them back, so that they are the same in M1 and C.
    """

    K: Array  # (n, n)
    M1: Array
    C: Array
    S: Array  # (n,)
    inertia: float  # J (kg m^2) of beam and hub about the axis; infinity of a held root

    @classmethod
    def of(cls, operators: BeamOperators, scenario: Scenario) -> SpinningBeam:
        """Take the operators of shape functions seen from the root, and how it is held."""
        o, root = operators, scenario.root
        M1, S = o.elastic_mass, o.coupling
        C = o.C + (M1 - o.M1)
        if root.kind == "driven":
            return cls(o.stiffness, M1, C, S, math.inf)
        if root.stiffness > 0.0:
            mass = np.block([[np.array([[o.inertia]]), S[None]], [S[:, None], M1]])
            return cls.at_rest(block_diag(root.stiffness, o.K), mass)
        return cls(o.K, M1, C, S, o.inertia)

    @classmethod
    def at_rest(cls, stiffness: Array, mass: Array) -> SpinningBeam:
        """Take the matrices (n, n) of a beam that does not spin, in any coordinates that are free."""
        nothing = np.zeros_like(mass)
        return cls(stiffness, mass, nothing, nothing[0], math.inf)

    def flapwise(self, spin_rate: float, count: int) -> Array:
        """First `count` flapwise angular frequencies (rad/s), ascending; of a free root the rate is the first."""
        return np.hypot(self.chordwise(spin_rate, count), spin_rate)

    def chordwise(self, spin_rate: float, count: int) -> Array:
        """First `count` chordwise angular frequencies (rad/s), ascending; of a free root 0 is the first."""
        stiffness = self.K + spin_rate**2 * (self.C - self.M1)
        mass = self.M1 - np.outer(self.S, self.S) / self.inertia
        squares = _squares(stiffness, mass)
        if squares[0] < _FAR * squares[1]:  # on a soft spring: the others lose their digits beside it
            shift = squares[1]
            squares[1:] = _squares(stiffness + shift * mass, mass)[1:] - shift
        rigid = np.zeros(0 if math.isinf(self.inertia) else 1)
        return np.append(rigid, np.sqrt(squares))[:count]


def _squares(stiffness: Array, mass: Array) -> Array:
    """Squares (n,) of the angular frequencies (1/s^2), ascending, the lowest to rounding.

    Eigenvalues are good to eps of the largest: among omega^2 that exceeds the lowest on fine meshes, among
    1/omega^2 it belongs to the lowest; scaled, the stiffness is nearly the unit matrix.
    """
    scale = 1.0 / np.sqrt(np.diag(stiffness))
    scales = np.outer(scale, scale)
    flexibilities = eigh(mass * scales, stiffness * scales, eigvals_only=True)[::-1]
    return np.asarray(1.0 / np.maximum(flexibilities, np.finfo(float).tiny))


def merge_points(nodes: Array, others: Array) -> Array:
    """Union of two ascending sets of points (m), in which others within rounding of a node are that node."""
    length = nodes[-1]
    apart = np.array([np.min(np.abs(nodes - x)) > _SAME_PLACE * length for x in others], dtype=bool)
    return np.union1d(nodes, others[apart])


def gauss_rule(edges: Array, order: int) -> tuple[Array, Array]:
    """Points and weights (panels order,) of the composite Gauss rule on panels with the given edges (m)."""
    nodes, weights = np.polynomial.legendre.leggauss(order)
    half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
    return (middle + half * nodes).ravel(), (half * weights).ravel()


@cache
def cumulative_weights(order: int) -> Array:
    """Weights (order, order) of int_0^{x_l} over a unit panel.

    Exact for the polynomial through the panel's Gauss points.
    """
    nodes, weights = np.polynomial.legendre.leggauss(order)
    basis = np.polynomial.legendre.legvander(nodes, order - 1)
    # Legendre coefficients from values: a_m = (2 m + 1)/2 sum_k w_k P_m(x_k) f_k
    to_coefficients = (basis * weights[:, None]).T * (np.arange(order)[:, None] + 0.5)
    columns = (np.polynomial.legendre.legint(c, lbnd=-1.0) for c in to_coefficients.T)
    return np.asarray(0.5 * np.stack([np.polynomial.legendre.legval(nodes, c) for c in columns], axis=1))


def cumulative(table: ShapeTable, integrand: Array) -> Array:
    """Integral from the root to each quadrature point; `integrand` (nq, ...) -> (nq, ...)."""
    panels = table.points.size // table.order
    rest = integrand.shape[1:]
    values = integrand.reshape(panels, table.order, -1)
    weights = table.weights.reshape(panels, table.order)
    totals = (weights[:, None, :] @ values)[:, 0]
    start = np.concatenate([np.zeros_like(totals[:1]), np.cumsum(totals, axis=0)[:-1]])
    inside = cumulative_weights(table.order) @ values
    inside *= weights.sum(axis=1)[:, None, None]
    return np.asarray((inside + start[:, None, :]).reshape(table.points.size, *rest))


def station_points(length: float, contact_point: float) -> Array:
    """Output stations (m): 32 equal cells over the beam, and the contact point."""
    points = length * np.arange(33) / 32
    if np.min(np.abs(points - contact_point)) > 1e-9 * length:
        points = np.sort(np.append(points, contact_point))
    return points


@runtime_checkable
class Discretization(Protocol):
    """A discretization of the beam: a module or an object with this function."""

    def build_operators(self, scenario: Scenario) -> BeamOperators:
        """Return the operators of the beam of a scenario, whose section `discretization` it may read."""


#: packages of the built-in discretizations, which import this module
_PACKAGES = {"modal": "modal", "fem": "fem_beam", "absolute": "fem_beam.exact"}


def discretization(method: str) -> Any:
    """Return the package of a built-in discretization, by the name that a scenario gives it."""
    return import_module(f"oblique_impact.{_PACKAGES[method]}")


def build_operators(scenario: Scenario, user_defined: Discretization | None = None) -> BeamOperators:
    """Discretize the beam of `scenario` with the method that it names, or with a user-defined one.

    Operators of the built-in methods are cached, as runs of a study often have the same beam, and their arrays are
    read-only.  Those of a user-defined discretization are not: which keys it reads is not known here.  Raises
    InputError for arrays that are not real.
    """
    if user_defined is not None:
        operators: BeamOperators = contiguous(user_defined.build_operators(scenario))
        return operators
    # only the keys that operators depend on: equal beams are equal
    beam_alone = Scenario.model_construct(
        beam=scenario.beam,
        root=scenario.root,
        masses=scenario.masses,
        # their places alone, as nodes and ends of panels
        forces=tuple(ForceSection(place=item.place, force=1.0) for item in scenario.acting_forces),
        contact=ContactSection(point=scenario.contact.point),
        discretization=scenario.discretization,
    )
    return _cached_operators(beam_alone)


@lru_cache(maxsize=8)  # finite elements take a tenth of a second
def _cached_operators(scenario: Scenario) -> BeamOperators:
    operators: BeamOperators = discretization(scenario.discretization.method).build_operators(scenario)
    stations = operators.stations
    for part in (operators, stations, stations.quadrature):
        for value in vars(part).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
    return operators


def contiguous(operators: Any) -> Any:
    """Return operators, or a table of them, with contiguous arrays of float64 and numbers of type float.

    User-defined ones may be views or of other types, which compiled kernels do not read.  Raises InputError for
    complex numbers.
    """
    changed: dict[str, Any] = {}
    for part in fields(operators):
        value = getattr(operators, part.name)
        if isinstance(value, ShapeTable | StationTable):
            changed[part.name] = contiguous(value)
        elif isinstance(value, np.ndarray) and part.name != "cells":
            changed[part.name] = own_numbers(value, value.shape, f"discretization: {part.name}")
        elif isinstance(value, Number) and part.name != "order":
            changed[part.name] = float(value)  # type: ignore[arg-type]
    return replace(operators, **changed)
