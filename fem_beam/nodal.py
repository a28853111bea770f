"""Nodal operators: weak forms of the beam in cubic Hermite elements, assembled by scikit-fem.

Degrees of freedom are deflection and slope node by node, so every matrix has three diagonals on
either side.  Swapping the order of integration turns the double integrals of foreshortening into weighted
slopes, and the weights keep the matrices banded.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from skfem import Basis, BilinearForm, ElementLineHermite, LinearForm, MeshLine
from skfem.helpers import d, dd, ddot, dot

from fem_beam.mesh import beam_mesh
from oblique_impact.scenario import Scenario

Array = NDArray[np.float64]

HALF_BANDWIDTH = 3
_INTEGRATION_ORDER = 6  # exact for cubic times cubic and for quadratic weights times slopes


@BilinearForm
def _mass(u, v, w):  # type: ignore[no-untyped-def]
    return w.mass * u * v


@BilinearForm
def _bending(u, v, w):  # type: ignore[no-untyped-def]
    return w.stiffness * ddot(dd(u), dd(v))


@BilinearForm
def _weighted_slopes(u, v, w):  # type: ignore[no-untyped-def]
    return w.weight * dot(d(u), d(v))


@LinearForm
def _load(v, w):  # type: ignore[no-untyped-def]
    return w.weight * v


@dataclass(frozen=True)
class NodalBeam:
    """The nodal finite-element model of a scenario's uniform beam, before boundary conditions.

    Attributes are in the notation of :class:`~oblique_impact.operators.BeamOperators`, for all
    2 (elements + 1) degrees of freedom; matrices are sparse and banded.
    """

    scenario: Scenario
    mesh: MeshLine

    @classmethod
    def from_scenario(cls, scenario: Scenario) -> NodalBeam:
        """Mesh and assemble the beam of `scenario`."""
        elements = scenario.discretization.elements
        return cls(scenario, beam_mesh(scenario.beam.length, elements, scenario.contact.point))

    @cached_property
    def basis(self) -> Basis:
        """The Hermite basis on the mesh."""
        return Basis(self.mesh, ElementLineHermite(), intorder=_INTEGRATION_ORDER)

    @property
    def nodes(self) -> Array:
        """Node coordinates (m), ascending."""
        return np.asarray(self.mesh.p[0])

    @property
    def mass_per_length(self) -> float:
        """kg/m."""
        return self.scenario.beam.density * self.scenario.beam.area

    @property
    def bending_stiffness(self) -> float:
        """E I (N m^2)."""
        return self.scenario.beam.youngs_modulus * self.scenario.beam.second_moment

    @cached_property
    def M1(self) -> csr_array:
        """Mass, int m Phi^T Phi."""
        return csr_array(_mass.assemble(self.basis, mass=self.mass_per_length))

    @cached_property
    def K(self) -> csr_array:
        """Bending stiffness, int E I Phi''^T Phi''."""
        return csr_array(_bending.assemble(self.basis, stiffness=self.bending_stiffness))

    @cached_property
    def C(self) -> csr_array:
        """Centrifugal geometric stiffness per unit spin rate squared."""
        m, r, length = self.mass_per_length, self.scenario.root.hub_radius, self.scenario.beam.length
        x = self._points
        return self._slopes(m * (r * (length - x) + 0.5 * (length**2 - x**2)))

    @cached_property
    def D(self) -> csr_array:
        """Gravity geometric stiffness per unit g."""
        m, length = self.mass_per_length, self.scenario.beam.length
        return self._slopes(m * (length - self._points))

    @cached_property
    def contact_shortening(self) -> csr_array:
        """H(x_F): the node at the contact point makes the integral one over whole elements."""
        point = self.scenario.contact.point
        return self._slopes(np.where(self._points < point, 1.0, 0.0))

    @cached_property
    def S(self) -> Array:
        """Coupling to the rigid rotation, int m (r + x) Phi."""
        m, r = self.mass_per_length, self.scenario.root.hub_radius
        return np.asarray(_load.assemble(self.basis, weight=m * (r + self._points)))

    @cached_property
    def P(self) -> Array:
        """Load, int m Phi."""
        m = self.mass_per_length
        return np.asarray(_load.assemble(self.basis, weight=m))

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
        """Matrix G with K = G^T G: weighted curvatures at two Gauss points per element.

        The square root has half the condition exponent of K, so frequencies and reduced stiffness
        taken from it keep their digits on fine meshes.
        """
        widths = np.diff(self.nodes)
        middle = 0.5 * (self.nodes[1:] + self.nodes[:-1])
        offset = 0.5 * widths / np.sqrt(3.0)
        points = np.stack([middle - offset, middle + offset], axis=1).ravel()
        weights = np.sqrt(self.bending_stiffness * np.repeat(0.5 * widths, 2))
        return csr_array(self.evaluate(points)[2].multiply(weights[:, None]))

    def free_dofs(self, root: str) -> NDArray[np.int64]:
        """Degrees of freedom left by the root: "clamped" removes deflection and slope, "hinged" the deflection."""
        return np.arange(2 if root == "clamped" else 1, self.basis.N)

    @property
    def _points(self) -> Array:
        """Quadrature points (m), shape (elements, points per element)."""
        return np.asarray(self.basis.global_coordinates()[0], dtype=float)

    def _slopes(self, weight: Array) -> csr_array:
        return csr_array(_weighted_slopes.assemble(self.basis, weight=weight))


def banded(matrix: csr_array) -> Array:
    """Upper banded storage (4, n) of a symmetric nodal matrix, as ``scipy.linalg.solveh_banded`` takes it."""
    n = matrix.shape[0]
    storage = np.zeros((HALF_BANDWIDTH + 1, n))
    for k in range(HALF_BANDWIDTH + 1):
        storage[HALF_BANDWIDTH - k, k:] = matrix.diagonal(k)
    return storage
