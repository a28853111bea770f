"""A plane, geometrically exact beam in absolute coordinates (Reissner 1972; Simo and Vu-Quoc 1986).

A cross-section at the arc length x has the place r(x), a complex number (m), and the rotation phi(x) (rad).  In
the turned section the strains are

    Gamma = exp(-i phi) r' - 1 = epsilon + i gamma        kappa = phi'

with the extension epsilon and the shear gamma, and the resultants are linear in them: n = E A epsilon + i k_s G A
gamma, M = E I kappa.  Nothing else is approximated: places and rotations may be as large as they like, and the
mass matrix is constant.

Quadratic Lagrange elements of scikit-fem carry x, y and phi.  Strains are taken at two Gauss points an element
(reduced integration), where they do not lock (Zienkiewicz, Taylor and Too 1971); inertia is integrated exactly.
Nodal values are q = [x, y, phi, x, y, phi, ...], node by node from the root.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array, kron
from skfem import Basis, BilinearForm, ElementLineP2, MeshLine

from oblique_impact.fem_beam.exact.elastic_sections import Array, ElasticSections
from oblique_impact.fem_beam.exact.step_forces import (
    FIELDS,
    NODE,
    BeamData,
    add_forces,
    add_tangent,
    take_fields,
    turn_forces,
    turn_rows,
)
from oblique_impact.kernels.band_rows import BANDWIDTH, new_rows
from oblique_impact.kernels.jit import by_reference, kernel
from oblique_impact.scenario.model import ON_NODE, PointMass

Complex = NDArray[np.complex128]

#: order of the rule with two points an element, and of one that is exact for inertia that varies linearly
_REDUCED, _EXACT = 3, 5


class Stage(NamedTuple):
    """State at an instant: nodal values and velocities (3 n,)."""

    q: Array
    v: Array


class PointFields(NamedTuple):
    """Rotation and derivatives at points of the beam, from which strains follow."""

    tangent: Complex  # r'
    rotation: Array  # phi
    curvature: Array  # phi'


class Resultants(NamedTuple):
    """Force n = N + i Q in the turned section (N), and moment (N m)."""

    force: Complex
    moment: Array


class StepForces(NamedTuple):
    """Internal forces of a step (3 n,), and their derivatives by its end, as bands (17, 3 n)."""

    forces: Array
    tangent: Array


class ExactBeam:
    """The discretized beam.

    Parameters
    ----------
    ends : ndarray, shape (elements + 1,)
        Ends of the elements (m), ascending from 0.
    sections : ElasticSections
        Stiffnesses and inertias.
    masses : sequence of PointMass
        Point masses on the axis, which turn with the section that carries them.
    hub_inertia : float
        Moment of inertia (kg m^2) that turns with the first section.
    radius : float
        Distance (m) of the root from the origin in :meth:`straight`.
    """

    def __init__(
        self,
        ends: Array,
        sections: ElasticSections,
        masses: Sequence[PointMass] = (),
        hub_inertia: float = 0.0,
        radius: float = 0.0,
    ) -> None:
        self.sections, self.radius = sections, radius
        self._basis = Basis(MeshLine(ends), ElementLineP2(), intorder=_REDUCED)
        place = self._basis.doflocs[0]
        self._number = np.argsort(np.argsort(place))  # numbers of scikit-fem's nodes along the beam
        self.x: Array = np.sort(place)  # (n,) m, of the nodes
        self.ends = ends
        self.size = NODE * self.x.size
        # (3 n,) length or 1 rad: what increments are measured by
        self.scale: Array = np.tile([ends[-1], ends[-1], 1.0], self.x.size)
        points = np.asarray(self._basis.global_coordinates()[0])
        self.points: Array = points  # (elements, 2) m, Gauss points
        self._weights: Array = self._basis.dx
        self._stiffness = sections.axial(points), sections.shear(points), sections.bending(points)
        # the nodes of an element are consecutive, its unknowns too
        self._unknowns = 2 * NODE * np.arange(ends.size - 1)[:, None] + np.arange(3 * NODE)
        shapes, slopes = self._shapes()
        mass, rotary = self._mass_matrices(masses, hub_inertia)
        self.M = csr_array(kron(mass, diags_array([1.0, 1.0, 0.0])) + kron(rotary, diags_array([0.0, 0.0, 1.0])))
        #: the same for kernels
        self.data = BeamData(
            self.x,
            shapes,
            slopes,
            np.stack([*self._stiffness, self._weights], axis=-1),
            _diagonals(mass),
            _diagonals(rotary),
        )

    def _shapes(self) -> tuple[Array, Array]:
        """Values and derivatives (1/m) of the functions of an element's nodes at its Gauss points."""
        elements, count = self.points.shape
        shapes, slopes = np.zeros((2, elements, count, 3))
        local = self._number[self._basis.element_dofs]  # (3, elements), in scikit-fem's order
        for shape, number in zip(self._basis.basis, local, strict=True):
            for e in range(elements):
                node = int(number[e]) - 2 * e
                shapes[e, :, node], slopes[e, :, node] = shape[0][e], shape[0].grad[0][e]
        return shapes, slopes

    def row_at(self, x: float) -> tuple[int, Array]:
        """First node of the element at a place (m), and the values (3,) of its three nodes' functions there."""
        near = int(np.argmin(np.abs(self.x - x)))
        if abs(self.x[near] - x) <= ON_NODE * self.ends[-1]:
            first = min(near - near % 2, self.x.size - 3)
            return first, np.eye(3)[near - first]
        e = int(np.searchsorted(self.ends[1:-1], x))
        z = (2.0 * x - self.ends[e] - self.ends[e + 1]) / (self.ends[e + 1] - self.ends[e])
        return 2 * e, np.array([0.5 * z * (z - 1.0), 1.0 - z * z, 0.5 * z * (z + 1.0)])

    def _mass_matrices(self, masses: Sequence[PointMass], hub_inertia: float) -> tuple[csr_array, csr_array]:
        """Mass and rotary inertia over the nodes, (n, n)."""
        exact = Basis(self._basis.mesh, ElementLineP2(), intorder=_EXACT)
        order = np.argsort(self._number)

        def scalar(weight: object) -> csr_array:
            form = BilinearForm(lambda u, v, w: weight(w.x[0]) * u * v)  # type: ignore[operator]
            return csr_array(csr_array(form.assemble(exact))[order][:, order])

        rows = np.zeros((len(masses), self.x.size))
        for row, point in zip(rows, masses, strict=True):
            first, shapes = self.row_at(point.place)
            row[first : first + 3] = shapes
        points = np.array([[point.mass, point.inertia] for point in masses]).reshape(-1, 2).T
        hub = diags_array(np.append(hub_inertia, np.zeros(self.x.size - 1)))
        mass, rotary = (csr_array(rows.T * of) @ csr_array(rows) for of in points)
        return csr_array(scalar(self.sections.mass) + mass), csr_array(scalar(self.sections.rotary) + rotary + hub)

    # --- states

    def straight(self, angle: float) -> Array:
        """Nodal values (3 n,) of the undeformed beam at an angle (rad)."""
        r = np.exp(1j * angle) * (self.radius + self.x)
        return np.stack([r.real, r.imag, np.full(self.x.size, float(angle))], axis=1).ravel()

    def moved(self, q: Array, by: complex) -> Array:
        """Return nodal values (3 n,) of a beam that is moved by x + i y (m), or velocities (m/s) likewise."""
        return np.asarray(q + np.tile([by.real, by.imag, 0.0], self.x.size))

    def turning(self, q: Array, spin: float) -> Array:
        """Velocities (3 n,) of a rigid turn about the origin at `spin` (rad/s)."""
        x, y, _ = q.reshape(-1, NODE).T
        return np.stack([-spin * y, spin * x, np.full(self.x.size, float(spin))], axis=1).ravel()

    def fields(self, q: Array) -> PointFields:
        """Fields at the Gauss points, each (..., elements, 2), of nodal values (..., 3 n)."""
        x, y, phi = np.moveaxis(q[..., self._unknowns].reshape(*q.shape[:-1], -1, 3, NODE), -1, 0)
        shapes, slopes = self.data.shapes, self.data.slopes
        x, y, curvature = (np.einsum("egk,...ek->...eg", slopes, values) for values in (x, y, phi))
        return PointFields(x + 1j * y, np.einsum("egk,...ek->...eg", shapes, phi), curvature)

    def resultants(self, q: Array, v: Array, viscosity: float = 0.0) -> Resultants:
        """Section forces at the Gauss points, each (..., elements, 2), with Kelvin-Voigt damping (s)."""
        at, rate = self.fields(q), self.fields(v)
        strain_rate = np.exp(-1j * at.rotation) * (rate.tangent - 1j * at.tangent * rate.rotation)
        bending = self._stiffness[2] * (at.curvature + viscosity * rate.curvature)
        return Resultants(self._force(strains(at) + viscosity * strain_rate), bending)

    def mean_resultants(self, q0: Array, q1: Array, relaxation: Array) -> Resultants:
        """Mean section forces of steps from q0 to q1, each (..., elements, 2).

        `relaxation` is Kelvin-Voigt damping over the length of the step, as in :meth:`step_forces`, of any shape
        that goes with these.
        """
        at0, at1 = self.fields(q0), self.fields(q1)
        one, other = strains(at0), strains(at1)
        curvature = 0.5 * (at0.curvature + at1.curvature) + relaxation * (at1.curvature - at0.curvature)
        force = self._force(0.5 * (one + other) + relaxation * (other - one))
        return Resultants(force, self._stiffness[2] * curvature)

    def _force(self, strain: np.ndarray[Any, Any]) -> Complex:
        axial, shear, _ = self._stiffness
        return np.asarray(axial * strain.real + 1j * shear * strain.imag)

    # --- energies

    def kinetic_energy(self, v: Array) -> Array:
        """Kinetic energy (J), shape (...), of nodal velocities (..., 3 n)."""
        return np.asarray(0.5 * np.einsum("...i,...i->...", v, v @ self.M))

    def elastic_energy(self, q: Array) -> Array:
        """Strain energy (J), shape (...), of nodal values (..., 3 n)."""
        fields = self.fields(q)
        return np.asarray(0.5 * self._energy(strains(fields), fields.curvature))

    def _energy(self, strain: Complex, curvature: Array) -> Array:
        """Twice the strain energy (J) of strains at the Gauss points."""
        density = (self._force(strain).conj() * strain).real + self._stiffness[2] * curvature**2
        return np.asarray(np.sum(self._weights * density, axis=(-2, -1)))

    def weight(self, gravity: float) -> Array:
        """Return the forces (3 n,) of gravity (m/s^2), downwards."""
        upwards = np.zeros(self.size)
        upwards[1::NODE] = 1.0
        return np.asarray(-gravity * (self.M @ upwards))

    def angular_momentum(self, q: Array, v: Array) -> float:
        """Angular momentum (kg m^2/s) about the origin."""
        return float(self.turning(q, 1.0) @ (self.M @ v))

    # --- forces

    def step_forces(self, q0: Array, q1: Array, relaxation: float = 0.0) -> StepForces:
        """Return internal forces of a step from q0 to q1, whose work is the change of the strain energy.

        See :mod:`~oblique_impact.fem_beam.exact.step_forces`.  `relaxation` is Kelvin-Voigt damping over the
        length of the step.
        """
        fields = np.zeros((2, *self.points.shape, FIELDS))
        forces, rows = np.zeros(self.size), new_rows(self.size)
        _forces_between(self.data, q0, q1, q1 - q0, relaxation, fields, forces, rows)
        return StepForces(forces, _bands(rows[: self.size]))

    def static_forces(self, q: Array) -> StepForces:
        """Return internal forces (3 n,) at rest and their derivatives: a step of no length.

        Forces of a step are symmetric in its ends, so the derivative by one of them is half of the whole.
        """
        forces, tangent = self.step_forces(q, q)
        return StepForces(forces, 2.0 * tangent)

    def damping_loss(self, q0: Array, q1: Array, relaxation: float) -> float:
        """Energy (J) that Kelvin-Voigt damping takes within a step, with `relaxation` as in `step_forces`."""
        at0, at1 = self.fields(q0), self.fields(q1)
        return float(relaxation * self._energy(strains(at1) - strains(at0), at1.curvature - at0.curvature))


@kernel("the forces of the exact beam")
def _forces_between(
    beam: BeamData, q0: Array, q1: Array, move: Array, relaxation: float, fields: Array, forces: Array, rows: Array
) -> None:
    beam = by_reference(beam)
    take_fields(beam, q0, fields[0])
    take_fields(beam, q1, fields[1])
    add_forces(beam, fields[0], fields[1], move, relaxation, forces)
    add_tangent(beam, fields[0], fields[1], move, relaxation, rows)
    turn_rows(move, forces, rows)
    turn_forces(move, forces)


def strains(fields: PointFields) -> Complex:
    """Extension and shear, Gamma = exp(-i phi) r' - 1."""
    return np.asarray(np.exp(-1j * fields.rotation) * fields.tangent - 1.0)


def _diagonals(matrix: csr_array) -> Array:
    """Entries (i, i - 2) to (i, i + 2) of a matrix over the nodes, (n, 5)."""
    found = np.zeros((matrix.shape[0], 5))
    for k in range(-2, 3):
        diagonal = matrix.diagonal(k)
        found[max(0, -k) :, k + 2][: diagonal.size] = diagonal
    return found


def _bands(rows: Array) -> Array:
    """Return a band matrix by rows in the storage of :func:`scipy.linalg.solve_banded`, (17, n)."""
    found = np.zeros((2 * BANDWIDTH + 1, len(rows)))
    for k in range(-BANDWIDTH, BANDWIDTH + 1):
        diagonal = rows[max(0, -k) : len(rows) - max(0, k), BANDWIDTH + k]
        found[BANDWIDTH - k, max(0, k) :][: diagonal.size] = diagonal
    return found
