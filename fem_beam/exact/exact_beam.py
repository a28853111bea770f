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

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, get_lapack_funcs
from scipy.sparse import csr_array, diags_array, kron
from skfem import Basis, BilinearForm, ElementLineP2, MeshLine

from oblique_impact.fem_beam.exact.elastic_sections import Array, ElasticSections

Complex = NDArray[np.complex128]

#: unknowns of a node: x, y, phi
NODE = 3
#: diagonals on either side of the main one: the three nodes of an element are coupled
BANDWIDTH = 3 * NODE - 1
#: order of the rule with two points an element, and of one that is exact for inertia that varies linearly
_REDUCED, _EXACT = 3, 5
(_solve_general_band,) = get_lapack_funcs(("gbsv",), dtype=np.float64)
#: rotations within a step below which the divided difference is a series: the quotient would lose digits
_SMALL = 1e-2


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


class StepStart(NamedTuple):
    """Quantities at the beginning of a step, at the Gauss points, for the forces of the step."""

    fields: PointFields
    turn: Complex  # exp(i phi)
    strain: Complex  # Gamma


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
    tip_mass : float
        Point mass at the last node (kg).
    hub_inertia : float
        Moment of inertia (kg m^2) that turns with the first section.
    radius : float
        Distance (m) of the root from the origin in :meth:`straight`.
    """

    def __init__(
        self,
        ends: Array,
        sections: ElasticSections,
        tip_mass: float = 0.0,
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
        self._operator = self._gradients()
        weighted = self._operator * self._weights[:, :, None, None]
        self._left = np.ascontiguousarray(weighted.reshape(ends.size - 1, -1, 3 * NODE).transpose(0, 2, 1))
        self.M = self._mass_matrix(tip_mass, hub_inertia)
        self.mass_band = bands_of(self.M)
        element = np.arange(ends.size - 1)[:, None]
        # an element's unknowns are consecutive
        self._unknowns = 2 * NODE * element + np.arange(3 * NODE)
        rows, columns = self._unknowns[:, :, None], self._unknowns[:, None, :]
        self._band_index = ((BANDWIDTH + rows - columns) * self.size + columns).ravel()
        self._force_index = self._unknowns.ravel()

    def _gradients(self) -> Array:
        """Matrix (elements, points, 4, 9) from an element's unknowns to x', y', phi', phi at its Gauss points."""
        elements, count = self.points.shape
        operator = np.zeros((elements, count, 4, 3 * NODE))
        local = self._number[self._basis.element_dofs]  # (3, elements), in scikit-fem's order
        for shape, number in zip(self._basis.basis, local, strict=True):
            value, slope = shape[0], shape[0].grad[0]
            for e in range(elements):
                first = NODE * (int(number[e]) - 2 * e)
                for row, k in ((0, 0), (1, 1), (2, 2)):
                    operator[e, :, row, first + k] = slope[e]
                operator[e, :, 3, first + 2] = value[e]
        return operator

    def _mass_matrix(self, tip_mass: float, hub_inertia: float) -> csr_array:
        exact = Basis(self._basis.mesh, ElementLineP2(), intorder=_EXACT)
        order = np.argsort(self._number)

        def scalar(weight: object) -> csr_array:
            form = BilinearForm(lambda u, v, w: weight(w.x[0]) * u * v)  # type: ignore[operator]
            return csr_array(csr_array(form.assemble(exact))[order][:, order])

        ends = np.zeros((2, self.x.size))
        ends[0, -1], ends[1, 0] = tip_mass, hub_inertia
        mass = scalar(self.sections.mass) + diags_array(ends[0])
        rotary = scalar(self.sections.rotary) + diags_array(ends[1])
        along, turning = diags_array([1.0, 1.0, 0.0]), diags_array([0.0, 0.0, 1.0])
        return csr_array(kron(mass, along) + kron(rotary, turning))

    # --- states

    def straight(self, angle: float) -> Array:
        """Nodal values (3 n,) of the undeformed beam at an angle (rad)."""
        r = np.exp(1j * angle) * (self.radius + self.x)
        return np.stack([r.real, r.imag, np.full(self.x.size, float(angle))], axis=1).ravel()

    def turning(self, q: Array, spin: float) -> Array:
        """Velocities (3 n,) of a rigid turn about the origin at `spin` (rad/s)."""
        x, y, _ = q.reshape(-1, NODE).T
        return np.stack([-spin * y, spin * x, np.full(self.x.size, float(spin))], axis=1).ravel()

    def fields(self, q: Array) -> PointFields:
        """Fields at the Gauss points, each (..., elements, 2), of nodal values (..., 3 n)."""
        found = (self._operator @ q[..., self._unknowns][..., None, :, None])[..., 0]
        return PointFields(found[..., 0] + 1j * found[..., 1], found[..., 3], found[..., 2])

    def resultants(self, q: Array, v: Array, viscosity: float = 0.0) -> Resultants:
        """Section forces at the Gauss points, each (..., elements, 2), with Kelvin-Voigt damping (s)."""
        at, rate = self.fields(q), self.fields(v)
        strain_rate = np.exp(-1j * at.rotation) * (rate.tangent - 1j * at.tangent * rate.rotation)
        bending = self._stiffness[2] * (at.curvature + viscosity * rate.curvature)
        return Resultants(self._force(strains(at) + viscosity * strain_rate), bending)

    def mean_resultants(self, q0: Array, q1: Array, relaxation: float = 0.0) -> Resultants:
        """Section forces at the Gauss points, mean of a step, each (elements, 2): as in :meth:`step_forces`."""
        return self._mean_resultants(self.step_start(q0), self.step_start(q1), relaxation)

    def _mean_resultants(self, start: StepStart, end: StepStart, relaxation: float) -> Resultants:
        strain, change = 0.5 * (start.strain + end.strain), end.strain - start.strain
        before, after = start.fields.curvature, end.fields.curvature
        bending = self._stiffness[2] * (0.5 * (before + after) + relaxation * (after - before))
        return Resultants(self._force(strain + relaxation * change), bending)

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

    def step_start(self, q: Array) -> StepStart:
        """Return the input of :meth:`step_forces` from the nodal values (3 n,) at the beginning of a step."""
        at = self.fields(q)
        turn = np.exp(1j * at.rotation)
        return StepStart(at, turn, strains(at, turn))

    def step_forces(self, q0: Array | StepStart, q1: Array, relaxation: float = 0.0) -> StepForces:
        """Return internal forces of a step from q0 to q1 whose work is the change of the strain energy, exactly.

        The strain exp(-i phi) r' is a product, and for differences and means over the step the rule of products is

            Delta(a b) = mean(a) Delta(b) + Delta(a) mean(b)

        So with the mean resultants of both ends, the force that belongs to r' is mean(exp(i phi)) n, the moment
        that belongs to phi is n . (Delta exp(-i phi)/Delta phi) mean(r'), and the one that belongs to phi' is M.

        Parameters
        ----------
        q0 : ndarray, shape (3 n,), or StepStart
            Nodal values at the beginning, or what :meth:`step_start` makes of them: it stays in all iterations.
        q1 : ndarray, shape (3 n,)
            Nodal values at the end.
        relaxation : float
            Kelvin-Voigt damping over the length of the step: the resultants gain this times those of the change of
            the strains.
        """
        start, end = q0 if isinstance(q0, StepStart) else self.step_start(q0), self.step_start(q1)
        at0, turn0, _ = start
        at1, turn1, _ = end
        mean, tangent = 0.5 * (turn0 + turn1), 0.5 * (at0.tangent + at1.tangent)
        quotient, quotient_rate = divided_difference(at0.rotation, at1.rotation)
        n, moment = self._mean_resultants(start, end, relaxation)
        force, turning = mean * n, ((n * quotient).conj() * tangent).real
        loads = np.empty((*self.points.shape, 4))
        loads[..., 0], loads[..., 1] = force.real, force.imag
        loads[..., 2], loads[..., 3] = moment, turning
        forces = self._left @ loads.reshape(len(loads), -1, 1)
        # derivatives by x', y' and phi at the end of the step, of the strain first, then of forces and moment
        share, back = 0.5 + relaxation, turn1.conj()
        dn = np.empty((3, *back.shape), dtype=complex)
        dn[0], dn[1], dn[2] = back, 1j * back, -1j * back * at1.tangent
        dn = self._force(share * dn)
        turned = (n * quotient).conj()
        df, dm = mean * dn, ((dn * quotient).conj() * tangent).real
        df[2] += 0.5j * turn1 * n
        dm[0] += 0.5 * turned.real
        dm[1] -= 0.5 * turned.imag
        dm[2] += ((n * quotient_rate).conj() * tangent).real
        D = np.zeros((*self.points.shape, 4, 4))
        for k, column in enumerate((0, 1, 3)):
            D[:, :, 0, column], D[:, :, 1, column], D[:, :, 3, column] = df[k].real, df[k].imag, dm[k]
        D[:, :, 2, 2] = share * self._stiffness[2]
        blocks = self._left @ (D @ self._operator).reshape(len(loads), -1, 3 * NODE)
        band = np.bincount(self._band_index, blocks.ravel(), (2 * BANDWIDTH + 1) * self.size)
        return StepForces(
            np.asarray(np.bincount(self._force_index, forces.ravel(), self.size), dtype=float),
            np.asarray(band.reshape(2 * BANDWIDTH + 1, self.size), dtype=float),
        )

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


def strains(fields: PointFields, turn: Complex | None = None) -> Complex:
    """Extension and shear, Gamma = exp(-i phi) r' - 1; `turn` is exp(i phi) if that is known."""
    turn = np.exp(1j * fields.rotation) if turn is None else turn
    return np.asarray(turn.conj() * fields.tangent - 1.0)


def divided_difference(phi0: Any, phi1: Any) -> tuple[Complex, Complex]:
    """Return (exp(i phi1) - exp(i phi0))/(phi1 - phi0), and its derivative by phi1."""
    step = phi1 - phi0
    small = np.abs(step) < _SMALL
    ratio, rate = 1.0 - step**2 / 24.0 + step**4 / 1920.0, -step / 12.0 + step**3 / 480.0
    if not small.all():
        safe = np.where(small, 1.0, step)
        ratio = np.where(small, ratio, 2.0 * np.sin(0.5 * safe) / safe)
        rate = np.where(small, rate, (np.cos(0.5 * step) - ratio) / safe)
    middle = 1j * np.exp(0.5j * (phi0 + phi1))
    return middle * ratio, middle * (0.5j * ratio + rate)


def bands_of(matrix: csr_array) -> Array:
    """Return a banded matrix in the storage of :func:`scipy.linalg.solve_banded`, (17, n)."""
    band = np.zeros((2 * BANDWIDTH + 1, matrix.shape[0]))
    for k in range(-BANDWIDTH, BANDWIDTH + 1):
        diagonal = matrix.diagonal(k)
        band[BANDWIDTH - k, max(0, k) :][: diagonal.size] = diagonal
    return band


def solve(band: Array, right: Array, held: int) -> Array:
    """Solve a banded system whose first `held` unknowns are 0; `right` (3 n,) or (3 n, k).

    Raises LinAlgError for a singular one.
    """
    # solve_banded by hand: for a few dozen unknowns its checks take longer than LAPACK
    rows = np.zeros((3 * BANDWIDTH + 1, band.shape[1] - held))
    rows[BANDWIDTH:] = band[:, held:]
    _, _, solution, info = _solve_general_band(BANDWIDTH, BANDWIDTH, rows, right[held:], overwrite_ab=True)
    if info > 0:
        raise LinAlgError("singular matrix")
    found = np.zeros_like(right)
    found[held:] = solution
    return found
