"""Nodal operators: weak forms of the beam in cubic Hermite elements, assembled by scikit-fem.

Degrees of freedom are deflection and slope node by node, so every matrix has three diagonals on
either side.  Swapping the order of integration turns the double integrals of foreshortening into weighted
slopes, and the weights keep the matrices banded.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from skfem import Basis, BilinearForm, LinearForm, MeshLine
from skfem.helpers import d, dd, ddot, dot

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import gauss_rule, merge_points
from oblique_impact.fem_beam.element import LocalHermite
from oblique_impact.fem_beam.mesh import mesh_of
from oblique_impact.scenario.scenario import Scenario

Array = NDArray[np.float64]
Weight = Callable[[Array], Array]

#: exact for a linear mass times two cubics, and for the cubic weight of C times two slopes
_INTEGRATION_ORDER = 7
#: of sizes over x: m of degree 2, weights of C of degree 4
_INTEGRATION_ORDER_OF_SHAPES = 9


@BilinearForm
def _mass(u, v, w):  # type: ignore[no-untyped-def]
    return w.weight * u * v


@BilinearForm
def _bending(u, v, w):  # type: ignore[no-untyped-def]
    return w.weight * ddot(dd(u), dd(v))


@BilinearForm
def _weighted_slopes(u, v, w):  # type: ignore[no-untyped-def]
    return w.weight * dot(d(u), d(v))


@LinearForm
def _load(v, w):  # type: ignore[no-untyped-def]
    return w.weight * v


@dataclass(frozen=True)
class NodalBeam:
    """The nodal finite-element model of a scenario's beam, before boundary conditions.

    Attributes are in the notation of :class:`~oblique_impact.beam.operators.BeamOperators`, for all
    2 (elements + 1) degrees of freedom; matrices are sparse and banded.  The integrals are exact for
    piecewise linear m and E I, and for shapes whose sizes are, wherever their kinks lie: an element with kinks
    inside gets a rule for each piece.
    """

    scenario: Scenario
    mesh: MeshLine
    sections: Sections

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> NodalBeam:
        """Mesh and assemble the beam of `scenario`."""
        sections = Sections.from_scenario(scenario)
        return cls(scenario, mesh_of(scenario, sections), sections)

    @cached_property
    def basis(self) -> Basis:
        """The Hermite basis on the mesh."""
        return Basis(self.mesh, LocalHermite(), intorder=self._order)

    @property
    def _order(self) -> int:
        """Degree up to which elements are integrated exactly."""
        return _INTEGRATION_ORDER if self.sections.degree == 1 else _INTEGRATION_ORDER_OF_SHAPES

    @property
    def nodes(self) -> Array:
        """Node coordinates (m), ascending."""
        return np.asarray(self.mesh.p[0])

    @cached_property
    def edges(self) -> Array:
        """Ends (m) of the pieces on which m and E I are linear and the shape functions cubic, ascending.

        Point masses are at ends, as the weights of C and D jump there, and forces.
        """
        return merge_points(self.nodes, np.union1d(self.sections.kinks, self.scenario.inner_forces))

    @cached_property
    def M1(self) -> csr_array:
        """Mass, int m Phi^T Phi + sum M_k Phi(x_k)^T Phi(x_k)."""
        own = csr_array(self._assemble(_mass, self.sections.mass_per_length))
        return _with_squares(own, self.evaluate(self.sections.places)[0], self.sections.point_masses)

    @property
    def whole_mass(self) -> csr_array:
        """M1 with the inertias of hub and point masses at the slopes where they turn."""
        n, s = self.basis.N, self.sections
        with_hub = self.M1 + csr_array(([s.hub_inertia], ([1], [1])), shape=(n, n))
        return _with_squares(with_hub, self.evaluate(s.places)[1], s.point_inertias)

    @property
    def stiffness(self) -> csr_array:
        """K with the spring of a clamp that yields at the slope of the root."""
        n = self.basis.N
        return self.K + csr_array(([self.sections.clamp_stiffness], ([1], [1])), shape=(n, n))

    @cached_property
    def K(self) -> csr_array:
        """Bending stiffness, int E I Phi''^T Phi''."""
        return csr_array(self._assemble(_bending, self.sections.bending_stiffness))

    @cached_property
    def C(self) -> csr_array:
        """Centrifugal geometric stiffness per unit spin rate squared."""
        return csr_array(self._assemble(_weighted_slopes, self.sections.outer_moment))

    @cached_property
    def D(self) -> csr_array:
        """Gravity geometric stiffness per unit g."""
        return csr_array(self._assemble(_weighted_slopes, self.sections.outer_mass))

    @cached_property
    def contact_shortening(self) -> csr_array:
        """H(x_F): the node at the contact point makes the integral one over whole elements."""
        point = self.scenario.contact.point
        return csr_array(self._assemble(_weighted_slopes, lambda x: np.where(x < point, 1.0, 0.0)))

    @cached_property
    def S(self) -> Array:
        """Coupling to the rigid rotation, int m (r + x) Phi + sum M_k (r + x_k) Phi(x_k)."""
        s = self.sections
        load = self._assemble(_load, lambda x: s.mass_per_length(x) * (s.hub_radius + x))
        return np.asarray(load + (s.point_masses * (s.hub_radius + s.places)) @ self.evaluate(s.places)[0])

    @cached_property
    def P(self) -> Array:
        """Load, int m Phi + sum M_k Phi(x_k)."""
        s = self.sections
        load = self._assemble(_load, s.mass_per_length)
        return np.asarray(load + s.point_masses @ self.evaluate(s.places)[0])

    @cached_property
    def rigid_rotation(self) -> Array:
        """Nodal values of the function x, which the elements hold exactly."""
        vector = np.zeros(self.basis.N)
        vector[0::2] = self.nodes
        vector[1::2] = 1.0
        return vector

    def evaluate(self, x: Array) -> tuple[csr_array, csr_array, csr_array]:
        """Shape functions, slopes and curvatures at points x (m) as sparse (points, 2 nodes) matrices."""
        points = np.atleast_1d(np.asarray(x, dtype=float))
        cells = np.clip(np.searchsorted(self.nodes, points, side="right") - 1, 0, self.mesh.nelements - 1)
        widths = np.diff(self.nodes)
        local = ((points - self.nodes[cells]) / widths[cells])[None, :, None]
        rows = np.arange(points.size)
        tables: list[list[Array]] = [[], [], []]
        for i in range(self.basis.Nbfun):
            field = self.basis.elem.gbasis(self.basis.mapping, local, i, tind=cells)[0]
            for table, values in zip(tables, (field, field.grad, field.hess), strict=True):
                table.append(np.asarray(values).reshape(-1))
        columns = self.basis.element_dofs[:, cells]
        where = (np.tile(rows, self.basis.Nbfun), columns.ravel())
        shape = (points.size, self.basis.N)
        value, slope, curvature = (csr_array((np.concatenate(t), where), shape=shape) for t in tables)
        return value, slope, curvature

    def curvature_factor(self) -> csr_array:
        """Matrix G with K = G^T G: weighted curvatures at two Gauss points per piece, at four for shapes over x.

        Exact for a linear E I (of shapes: one of degree 4) times two linear curvatures.  The square root has
        half the condition exponent of K, so frequencies and reduced stiffness taken from it keep their digits on
        fine meshes.
        """
        if self.sections.degree == 1:
            half, middle = 0.5 * np.diff(self.edges), 0.5 * (self.edges[1:] + self.edges[:-1])
            offset = half / np.sqrt(3.0)
            points, shares = np.stack([middle - offset, middle + offset], axis=1).ravel(), np.repeat(half, 2)
        else:
            points, shares = gauss_rule(self.edges, self.sections.degree // 2 + 2)
        weights = np.sqrt(self.sections.bending_stiffness(points) * shares)
        return csr_array(self.evaluate(points)[2].multiply(weights[:, None]))

    def free_dofs(self, root: str) -> NDArray[np.int64]:
        """Degrees of freedom left by the root: "clamped" removes deflection and slope, "hinged" the deflection."""
        return np.arange(2 if root == "clamped" else 1, self.basis.N)

    @cached_property
    def _bases(self) -> list[Basis]:
        """One basis for all elements that lie in one piece of the tables, one more for each that does not."""
        middles = 0.5 * (self.edges[1:] + self.edges[:-1])
        cells = np.searchsorted(self.nodes, middles) - 1
        split, pieces = np.unique(cells, return_counts=True)
        split = split[pieces > 1]
        if split.size == 0:
            return [self.basis]
        whole = np.setdiff1d(np.arange(self.mesh.nelements), split)
        bases = [Basis(self.mesh, LocalHermite(), elements=whole, intorder=self._order)] if whole.size else []
        z, w = np.polynomial.legendre.leggauss((self._order + 1) // 2)
        for cell in split:
            a, b = self.nodes[cell : cell + 2]
            ends = (np.union1d(self.edges[:-1][cells == cell], b) - a) / (b - a)
            half = 0.5 * np.diff(ends)[:, None]
            rule = (ends[:-1, None] + half * (1.0 + z)).ravel()[None], (half * w).ravel()
            bases.append(Basis(self.mesh, LocalHermite(), elements=np.array([cell]), quadrature=rule))
        return bases

    def _assemble(self, form: BilinearForm | LinearForm, weight: Weight) -> Any:
        """Integrate a form with a weight given as a function of x."""
        parts = []
        for basis in self._bases:
            points = np.asarray(basis.global_coordinates()[0], dtype=float)
            parts.append(form.assemble(basis, weight=np.asarray(weight(points))))
        return sum(parts[1:], start=parts[0])


def _with_squares(matrix: csr_array, rows: csr_array, weights: Array) -> csr_array:
    """Add sum of weights (k,) times products of the rows (k, n) to a matrix (n, n)."""
    return matrix if not weights.any() else csr_array(matrix + rows.T @ rows.multiply(weights[:, None]))
