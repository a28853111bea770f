"""The full nodal beam in its total transverse coordinates: banded mass, forces, contact rows.

W = x theta + B are the nodal deflections and slopes seen from the root's inertial axis turned to nothing:
rigid rotation and elastic deflection in one vector, with W_0 = 0 as the only boundary condition.  M, S = M x and
J = x.S are those of beam and hub, whose inertia M has at the slope of the root.  In the mean-axis frame, S.B = 0,
they split again by theta = S.W/J, B = W - x theta.  First-order kinetics reads

    (M + kappa S S^T) W'' + Cd W' + K W = f + d_n lambda_n + d_tau lambda_tau,   kappa = B^T N B / J^2
    f = f_B + S (Q_theta - x.f_B)/J,     f_B = theta'^2 N W - g (cos theta P - sin theta D B)
    Q_theta = -2 theta' B^T N B' - g (Sm cos theta - 1/2 cos theta B^T D B - sin theta P.B)
    d = D_B + S (D_theta - x.D_B)/J

with N = M1 - C of the beam alone, because N x = 0 and K x = 0.  Everything is banded but for rank one, so a step
costs O(n).

Where nodes have no inertia (:class:`MeanVelocities`) M is singular: what it does not see of the velocities is a
matter of choice, and not marched.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from oblique_impact.beam.axis import Met, meet
from oblique_impact.beam.hermite import HermiteShapes
from oblique_impact.beam.shaking import Shaking, base_acceleration, direction_in_frame, weight_in_frame
from oblique_impact.contact.sides_and_pegs import take_rows
from oblique_impact.contact.state import DIRECTION, FREE, RESPONSE, Candidate, Contacts
from oblique_impact.kernels.banded import (
    HALF_BANDWIDTH,
    band_multiply,
    factor_band,
    solve_band,
    solve_band_columns,
)
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import (
    ACROSS,
    ACROSS_TURNED,
    ALONG,
    ALONG_TURNED,
    EFFECTIVE_SLOTS,
    FORCES,
    FREE_ACCELERATION,
    INCREMENT,
    RANK_ONE,
    RESIDUAL,
    SCRATCH_A,
    SCRATCH_B,
    SCRATCH_C,
    SHORTENING_PRODUCT,
    VECTORS,
    Array,
    Evaluation,
    Workspace,
    copy,
    dot,
)

# NodalModel.bands: mass with the hub's, stiffness, N = M1 - C, gravity stiffness D
MASS_BAND, STIFFNESS_BAND, SPIN_BAND, GRAVITY_BAND = range(4)
# NodalModel.vectors: S, P, the rigid rotation x, D x, M^-1 S
COUPLING, LOAD, RIGID, GRAVITY_RIGID, MASS_RESPONSE = range(5)
_LANES = 4
# `Workspace.matrices` of a banded system: columns to solve in, then the factors of effective matrices
COLUMNS, FIRST_EFFECTIVE = 0, 1
Three = tuple[Array, Array, Array]


class NodalPlaces(NamedTuple):
    """Places at which the beam can touch obstacles, and its state in the floating frame: all m nodal values."""

    mesh: HermiteShapes
    each: Any  # (places,) records of `oblique_impact.beam.axis.PLACE`
    q: Array  # (m + 1,) theta and B
    qd: Array  # (m + 1,)
    vectors: Array  # (23, m + 1) see `Workspace`
    condensed: Array | None  # (n,) the last deflection by n = m - 1 coordinates, of which it is none; else n = m


class MeanVelocities(NamedTuple):
    """Means b_e of the velocities on elements, all that has inertia, and motions r_e of these means alone.

    b_e r_e = 1, b_e r_f = 0; both are over deflection and slope at the start and at the end of each element.
    """

    means: Array  # (elements, 4)
    motions: Array  # (elements, 4)
    hub: bool  # whether the slope of the root has the inertia of a hub


#: what is one number of a nodal beam on a pin or a hub of radius 0
NODAL_NUMBERS = np.dtype(
    [
        ("inertia", float),  # J (kg m^2), with the hub's
        ("static_moment", float),  # Sm (kg m)
        ("gravity", float),
        ("torque", float),  # on the hub (N m)
        ("kelvin_voigt", float),  # s
        ("mass_proportional", float),  # 1/s
    ],
    align=True,
)


class _NodalData(NamedTuple):
    """A nodal beam with n free degrees of freedom, constant during a run."""

    numbers: Any  # a record of `NODAL_NUMBERS`
    bands: Array  # (4, 4, n) diagonals 0..3: bands[b, k, i] is the entry (i, i + k)
    mass_factor: Array  # (n + 3, 4) of the mass matrix
    vectors: Array  # (5, n)
    places: NodalPlaces
    massless: MeanVelocities | None = None  # of a mesh whose nodes have no inertia
    shaking: Shaking | None = None  # of the base


@jitable
def _frame(model: NodalModel, q: Array, qd: Array) -> tuple[float, float]:
    """Angle and angular velocity of the mean-axis frame, S.W/J and S.W'/J."""
    theta, spin = 0.0, 0.0
    for i in range(q.shape[0]):
        theta += model.vectors[COUPLING, i] * q[i]
        spin += model.vectors[COUPLING, i] * qd[i]
    return theta / model.numbers.inertia, spin / model.numbers.inertia


@jitable
def take_nodal_state(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> None:
    """Take the state into the floating frame, in which places of contact are known."""
    places, rigid = model.places, model.vectors[RIGID]
    frame, frame_qd = places.q, places.qd
    frame[0], frame_qd[0] = _frame(model, q, qd)
    for j in range(q.shape[0]):
        frame[j + 1] = q[j] - frame[0] * rigid[j]
        frame_qd[j + 1] = qd[j] - frame_qd[0] * rigid[j]
    _expand(places.condensed, frame)
    _expand(places.condensed, frame_qd)
    places.mesh.bend(frame[1:], frame_qd[1:])


@jitable
def _expand(condensed: Array | None, frame: Array) -> None:
    """Insert the last deflection, which follows the other coordinates; the compiler drops this where none does."""
    if condensed is None:
        return
    n = condensed.shape[0]
    deflection = dot(condensed, frame[1 : n + 1])
    frame[n + 1] = frame[n]
    frame[n] = deflection


@jitable
def _condense(condensed: Array | None, row: Array) -> None:
    """Turn a row over all nodes into one over the coordinates, see `_expand`."""
    if condensed is None:
        return
    n = condensed.shape[0]
    share = row[n]
    row[n] = row[n + 1]
    for j in range(n):
        row[j + 1] += share * condensed[j]


@jitable
def _take_point_rows(model: NodalModel, place: Any, met: Met, v: Array) -> None:
    """Rows (2, n) over W of a point of the beam in the frame, J_B + S (J_theta - x.J_B)/J.

    Those over B are as in :mod:`~oblique_impact.beam.floating_frame`.  Elements hold the function x exactly, so
    that x.(H B) = u_y, x.Phi = x and x.Phi' = 1.
    """
    places, coupling, axis = model.places, model.vectors[COUPLING], met.axis
    own = places.vectors
    shape, slope, HB = own[SCRATCH_A, 1:], own[SCRATCH_B, 1:], own[SHORTENING_PRODUCT, 1:]
    places.mesh.take_shapes(axis, places.q[1:], own)
    for which in (SCRATCH_A, SCRATCH_B, SHORTENING_PRODUCT):
        _condense(places.condensed, own[which])
    e, kept, leaning = place.fibre, place.shortening, place.turning * axis.slope
    along = (kept * axis.u_y + e - met.point.y) / model.numbers.inertia
    across = (met.point.x - met.x + leaning) / model.numbers.inertia
    for j in range(coupling.shape[0]):
        v[ALONG, j] = along * coupling[j] - kept * HB[j] - e * slope[j]
        v[ACROSS, j] = across * coupling[j] + shape[j] - leaning * slope[j]
    if not place.on_side:
        shortened = -0.5 * axis.slope * axis.slope / model.numbers.inertia
        for j in range(coupling.shape[0]):
            v[ALONG_TURNED, j] = -axis.slope * slope[j]
            v[ACROSS_TURNED, j] = slope[j] + shortened * coupling[j]


@jitable
def touch_nodal(
    model: NodalModel, i: int, t: float, q: Array, qd: Array, w: Workspace, c: Candidate, rows: Array
) -> None:
    """Gap, slip, their rates and biases of one place of contact in the state taken last, and its rows."""
    places = model.places
    met = meet(places.mesh, 0.0, places.each[i], places.q, places.qd, c)
    _take_point_rows(model, places.each[i], met, w.vectors)
    take_rows(met.directions, w.vectors, rows)
    if places.each[i].on_side:
        c.shift, c.shift_rate = places.q[0], places.qd[0]
        if rows.shape[0] > 2:
            for j in range(rows.shape[1]):
                rows[2, j] = model.vectors[COUPLING, j] / model.numbers.inertia


@jitable
def measure_nodal(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace, contacts: Contacts) -> None:
    """Gap, slip and gap rate of every place of contact, each in O(1)."""
    places = model.places
    take_nodal_state(model, t, q, qd, w)
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        meet(places.mesh, 0.0, places.each[i], places.q, places.qd, c)
        if places.each[i].on_side:
            c.shift, c.shift_rate = places.q[0], places.qd[0]


@jitable
def _keep_means(massless: MeanVelocities | None, mean: Array, v: Array) -> None:
    """Replace `v` by `mean`, but for its means on the elements; the compiler drops this for nodes with inertia."""
    if massless is None:
        return
    b, r, n = massless.means, massless.motions, v.shape[0]
    root = v[0] - mean[0] if massless.hub else 0.0
    for j in range(n):
        v[j] -= mean[j]
    for e in range(b.shape[0]):
        share = -root * b[e, 1] if e == 0 else 0.0
        for k in range(1 if e == 0 else 0, 4):
            share += b[e, k] * v[2 * e - 1 + k]
        for k in range(1 if e == 0 else 0, 4):
            mean[2 * e - 1 + k] += r[e, k] * share
    mean[0] += root
    copy(mean, v)


@jitable
def set_massless_nodal(model: NodalModel, mean: Array, v: Array) -> None:
    """Give motions without inertia the velocities `mean`, which change; only for meshes without nodal inertia."""
    _keep_means(model.massless, mean, v)


@jitable
def _forces(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> tuple[float, float]:
    """Generalized forces f - K W - Cd W'; returns kappa and the power (W) of damping."""
    v, u, numbers, J = w.vectors, model.vectors, model.numbers, model.numbers.inertia
    forces, NW, DB, B = v[FORCES], v[SCRATCH_A], v[SCRATCH_B], v[SCRATCH_C]
    n = q.shape[0]
    theta, spin = _frame(model, q, qd)
    g, c, s = weight_in_frame(model.shaking, numbers.gravity, t, theta)
    band_multiply(model.bands, SPIN_BAND, q, NW)
    band_multiply(model.bands, GRAVITY_BAND, q, DB)
    # K W = K B, but in W the rounding of K x would hold the beam like a spring, the stiffer the finer the mesh
    for i in range(n):
        B[i] = q[i] - theta * u[RIGID, i]
    band_multiply(model.bands, STIFFNESS_BAND, B, forces)
    lag, lagging, gravity_rigid, bent, lifted = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        DB[i] -= theta * u[GRAVITY_RIGID, i]
        lag += NW[i] * q[i]
        lagging += NW[i] * qd[i]
        gravity_rigid += DB[i] * u[RIGID, i]
        bent += DB[i] * q[i]
        lifted += u[LOAD, i] * q[i]
    bent -= theta * gravity_rigid  # B^T D B
    lifted -= theta * numbers.static_moment  # P.B
    moment = -2.0 * spin * lagging
    moment -= g * (c * (numbers.static_moment - 0.5 * bent) - s * lifted)
    moment += g * (c * numbers.static_moment - s * gravity_rigid)  # - x.f_B
    moment /= J
    square = spin * spin
    for i in range(n):
        forces[i] = square * NW[i] - g * (c * u[LOAD, i] - s * DB[i]) + moment * u[COUPLING, i] - forces[i]
    forces[0] += numbers.torque  # the first free coordinate is the slope at the root
    power = 0.0
    if numbers.kelvin_voigt > 0.0 or numbers.mass_proportional > 0.0:
        power = _damp(model, qd, w)
        for i in range(n):
            forces[i] -= NW[i]
    return lag / (J * J), power


@jitable
def _supplied_power(
    shaking: Shaking | None, model: NodalModel, t: float, q: Array, qd: Array, w: Workspace
) -> float:
    """Power (W) of the torque on the hub and of the inertia force by a shaken base.

    The compiler drops the latter of a base that is not shaken.
    """
    power: float = model.numbers.torque * qd[0]
    if shaking is None:
        return power
    u, DB = model.vectors, w.vectors[SCRATCH_B]
    theta, spin = _frame(model, q, qd)
    along, across = direction_in_frame(shaking, np.cos(theta), np.sin(theta))
    band_multiply(model.bands, GRAVITY_BAND, q, DB)
    bent, bending, rigid, my, my_rate = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(q.shape[0]):
        DB[i] -= theta * u[GRAVITY_RIGID, i]
        bent += DB[i] * q[i]
        bending += DB[i] * qd[i]
        rigid += DB[i] * u[RIGID, i]
        my += u[LOAD, i] * q[i]
        my_rate += u[LOAD, i] * qd[i]
    # first moments of mass along x and y of the frame, and their rates in it
    mx, mx_rate = model.numbers.static_moment - 0.5 * (bent - theta * rigid), -(bending - spin * rigid)
    my, my_rate = my - theta * model.numbers.static_moment, my_rate - spin * model.numbers.static_moment
    momentum: float = along * (mx_rate - spin * my) + across * (my_rate + spin * mx)
    return power - base_acceleration(shaking, t) * momentum


@jitable
def _damp(model: NodalModel, qd: Array, w: Workspace) -> float:
    """Damping forces Cd W' into the row SCRATCH_A; their power (W)."""
    v, n, power = w.vectors, qd.shape[0], 0.0
    scratch_a, scratch_b = v[SCRATCH_A], v[SCRATCH_B]
    spin = dot(model.vectors[COUPLING], qd) / model.numbers.inertia
    band_multiply(model.bands, STIFFNESS_BAND, qd, scratch_a)
    band_multiply(model.bands, MASS_BAND, qd, scratch_b)
    for i in range(n):
        # mass-proportional damping acts on B' only: M B' = M W' - S theta'
        scratch_a[i] *= model.numbers.kelvin_voigt
        scratch_a[i] += model.numbers.mass_proportional * (scratch_b[i] - spin * model.vectors[COUPLING, i])
        power += scratch_a[i] * qd[i]
    return power


@jitable
def nodal_damping(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> float:
    """Power (W) of the damping matrix at the velocities q'."""
    if model.numbers.kelvin_voigt > 0.0 or model.numbers.mass_proportional > 0.0:
        return _damp(model, qd, w)
    return 0.0


@jitable
def evaluate_nodal(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
    """Fill forces at (q, q')."""
    rank_one, damping = _forces(model, t, q, qd, w)
    return Evaluation(damping, _supplied_power(model.shaking, model, t, q, qd, w), rank_one)


@jitable
def take_nodal_residual(model: NodalModel, t: float, q: Array, qd: Array, qdd: Array, w: Workspace) -> Evaluation:
    """Take forces and the residual f - K W - Cd W' - M W''."""
    forces, residual = w.vectors[FORCES], w.vectors[RESIDUAL]
    rank_one, damping = _forces(model, t, q, qd, w)
    multiply_nodal_mass(model, rank_one, w, qdd, residual)
    for i in range(q.shape[0]):
        residual[i] = forces[i] - residual[i]
    return Evaluation(damping, _supplied_power(model.shaking, model, t, q, qd, w), rank_one)


@jitable
def approach_nodal(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
    """Supplied power at (q, q')."""
    return Evaluation(0.0, _supplied_power(model.shaking, model, t, q, qd, w), 0.0)


@jitable
def multiply_nodal_mass(model: NodalModel, rank_one: float, w: Workspace, x: Array, product: Array) -> None:
    """(M + kappa S S^T) x into `product`."""
    band_multiply(model.bands, MASS_BAND, x, product)
    share = rank_one * dot(model.vectors[COUPLING], x)
    for i in range(x.shape[0]):
        product[i] += share * model.vectors[COUPLING, i]


@jitable
def _solve(model: NodalModel, rank_one: float, factors: Array, response: Array, right: Array, x: Array) -> bool:
    """Solve for a vector; the rank-one part by Sherman and Morrison with the `response` of S.

    False if the matrix with its rank-one part is not positive definite.
    """
    coupling = model.vectors[COUPLING]
    copy(right, x)
    solve_band(factors, x)
    pivot = 1.0 + rank_one * dot(coupling, response)
    if not pivot > 0.0:
        return False
    share = rank_one / pivot * dot(coupling, x)
    for i in range(x.shape[0]):
        x[i] -= share * response[i]
    return True


@jitable
def _solve_three(
    model: NodalModel, rank_one: float, factors: Array, response: Array, columns: Array, rights: Three, xs: Three
) -> bool:
    """Solve for three vectors side by side, in `columns`; see `_solve`."""
    coupling, n = model.vectors[COUPLING], response.shape[0]
    right_a, right_b, right_c = rights
    x_a, x_b, x_c = xs
    for i in range(n):
        columns[i, 0], columns[i, 1], columns[i, 2] = right_a[i], right_b[i], right_c[i]
    solve_band_columns(factors, columns)
    a, b, c, own = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        a += coupling[i] * columns[i, 0]
        b += coupling[i] * columns[i, 1]
        c += coupling[i] * columns[i, 2]
        own += coupling[i] * response[i]
    pivot = 1.0 + rank_one * own
    if not pivot > 0.0:
        return False
    share = rank_one / pivot
    for i in range(n):
        x_a[i] = columns[i, 0] - share * a * response[i]
        x_b[i] = columns[i, 1] - share * b * response[i]
        x_c[i] = columns[i, 2] - share * c * response[i]
    return True


@jitable
def _solve_contacts(
    model: NodalModel,
    rank_one: float,
    factors: Array,
    response: Array,
    right: Array,
    x: Array,
    w: Workspace,
    contacts: Contacts,
) -> bool:
    """Solve for a vector and the rows of the closed contacts, those of the first with the vector."""
    rows, first, defined = contacts.rows, True, True
    for i in range(len(contacts.each)):
        if contacts.each[i].state == FREE:
            continue
        normal, tangential = rows[DIRECTION, i, 0], rows[DIRECTION, i, 1]
        to_normal, to_tangential = rows[RESPONSE, i, 0], rows[RESPONSE, i, 1]
        lead, result = (right, x) if first else (normal, to_normal)
        rights, xs = (lead, normal, tangential), (result, to_normal, to_tangential)
        defined = _solve_three(model, rank_one, factors, response, w.matrices[COLUMNS], rights, xs)
        first = False
    return defined


@jitable
def solve_nodal_mass(model: NodalModel, rank_one: float, w: Workspace, contacts: Contacts, closed: bool) -> bool:
    """Acceleration without contact force and, with `closed`, M^-1 D^T; False if M is not positive definite."""
    v, factors, response = w.vectors, model.mass_factor, model.vectors[MASS_RESPONSE]
    if closed:
        return _solve_contacts(model, rank_one, factors, response, v[FORCES], v[FREE_ACCELERATION], w, contacts)
    return _solve(model, rank_one, factors, response, v[FORCES], v[FREE_ACCELERATION])


@jitable
def factor_nodal_effective(
    model: NodalModel, t: float, q: Array, velocity: float, position: float, w: Workspace, slot: int, stale: bool
) -> bool:
    """Factor M + velocity Cd + position K in a slot, only if the step has changed (`stale`)."""
    if not stale:
        return True
    mass = 1.0 + velocity * model.numbers.mass_proportional
    stiffness = position + velocity * model.numbers.kelvin_voigt
    factors = w.matrices[FIRST_EFFECTIVE + slot]
    if not factor_band(model.bands, MASS_BAND, mass, STIFFNESS_BAND, stiffness, factors):
        return False
    response = w.vectors[RANK_ONE + slot]
    copy(model.vectors[COUPLING], response)
    solve_band(factors, response)
    return True


@jitable
def solve_nodal_effective(
    model: NodalModel, rank_one: float, w: Workspace, slot: int, contacts: Contacts, closed: bool
) -> None:
    """S^-1 of the residual and, with `closed`, of the rows of the closed contacts."""
    v, factors, response = w.vectors, w.matrices[FIRST_EFFECTIVE + slot], w.vectors[RANK_ONE + slot]
    if closed:
        _solve_contacts(model, rank_one, factors, response, v[RESIDUAL], v[INCREMENT], w, contacts)
    else:
        _solve(model, rank_one, factors, response, v[RESIDUAL], v[INCREMENT])


@jitable
def solve_nodal_rows(
    model: NodalModel, rank_one: float, w: Workspace, slot: int, sides: int, rows: Array, responses: Array
) -> None:
    """S^-1 of the contact rows of many places, three at a time; the last ones perhaps twice."""
    last, factors = rows.shape[0] * sides - 1, w.matrices[FIRST_EFFECTIVE + slot]
    response = w.vectors[RANK_ONE + slot]
    for first in range(0, last + 1, 3):
        i, j, k = first, min(first + 1, last), min(first + 2, last)
        a, b, c = i % sides, j % sides, k % sides
        i, j, k = i // sides, j // sides, k // sides
        rights, xs = (rows[i, a], rows[j, b], rows[k, c]), (responses[i, a], responses[j, b], responses[k, c])
        _solve_three(model, rank_one, factors, response, w.matrices[COLUMNS], rights, xs)


class NodalModel(_NodalData):
    """The nodal beam as a :class:`~oblique_impact.kernels.system.System`."""

    __slots__ = ()
    described = "the full nodal model"

    evaluate = evaluate_nodal
    solve_mass = solve_nodal_mass
    take_residual = take_nodal_residual
    approach = approach_nodal
    mass_product = multiply_nodal_mass
    factor_effective = factor_nodal_effective
    solve_effective = solve_nodal_effective
    solve_rows = solve_nodal_rows
    damping_at = nodal_damping
    take_state = take_nodal_state
    touch = touch_nodal
    measure = measure_nodal
    set_massless = set_massless_nodal

    def new_workspace(self) -> Workspace:
        """Allocate the arrays of a run; memory is linear in the degrees of freedom."""
        n = self.vectors.shape[1]
        rows = n + HALF_BANDWIDTH  # zeros behind the last row, so that a solve needs no special case
        return Workspace(np.zeros((FIRST_EFFECTIVE + EFFECTIVE_SLOTS, rows, _LANES)), np.zeros((VECTORS, n)))

    def definiteness(self, rank_one: float, w: Workspace) -> float:
        """1 + kappa S.M^-1 S, which vanishes with the definiteness of the mass matrix."""
        return float(1.0 + rank_one * (self.vectors[COUPLING] @ self.vectors[MASS_RESPONSE]))


def factored_mass(bands: Array, coupling: Array) -> tuple[Array, Array]:
    """Factors of the mass matrix, (n + 3, 4) as of `factor_band`, and M^-1 S (n,).

    Raises LinAlgError if the matrix is not positive definite.
    """
    n = coupling.size
    lower = np.zeros((HALF_BANDWIDTH + 1, n))  # by diagonals: lower[k, i] is the entry (i + k, i)
    for k in range(HALF_BANDWIDTH + 1):
        lower[k, : n - k] = bands[MASS_BAND, k, : n - k]
    cholesky = cholesky_banded(lower, lower=True)
    factors = np.zeros((n + HALF_BANDWIDTH, _LANES))
    factors[:n, 0] = cholesky[0] ** -2
    for k in range(1, HALF_BANDWIDTH + 1):
        factors[k:n, k] = cholesky[k, : n - k] / cholesky[0, : n - k]
    return factors, cho_solve_banded((cholesky, True), coupling)


def mean_velocities(means: Array, hub: bool) -> MeanVelocities:
    """Return the means (elements, n) of the deflections on elements with motions of these means.

    Between two elements with the means a w + s phi and a' w + s' phi of deflection w and slope phi of their node,
    (s', -a') leaves the second where it is, (-s, a) the first.  A root with a hub's inertia does not move.
    """
    count = len(means)
    padded = np.hstack([np.zeros((count, 1)), means])  # the root has no deflection
    own = np.array([padded[e, 2 * e : 2 * e + 4] for e in range(count)])
    motions = np.zeros((count, 4))
    if not hub:
        motions[0, 1] = 0.5 / own[0, 1]
    motions[-1, 2] = 0.5 / own[-1, 2]
    for e in range(count - 1):
        a, s, after, steep = own[e, 2], own[e, 3], own[e + 1, 0], own[e + 1, 1]
        half = 0.5 / (a * steep - s * after)
        motions[e, 2:], motions[e + 1, :2] = (half * steep, -half * after), (-half * s, half * a)
    if hub:
        motions[0] *= 2.0
    return MeanVelocities(own, motions, hub)
