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

from oblique_impact.beam.axis import place_of, touch_peg
from oblique_impact.beam.floating_frame import touch_side
from oblique_impact.beam.hermite import HermiteShapes, axis_rates
from oblique_impact.beam.shaking import Shaking, base_acceleration, direction_in_frame, weight_in_frame
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
    EFFECTIVE_SLOTS,
    FORCES,
    FREE_ACCELERATION,
    INCREMENT,
    PRODUCT_A,
    PRODUCT_B,
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

# NodalModel.bands: mass with the hub's, stiffness, N = M1 - C, gravity stiffness D, H at the contact point
MASS_BAND, STIFFNESS_BAND, SPIN_BAND, GRAVITY_BAND, SHORTENING_BAND = range(5)
# NodalModel.vectors: S, P, the rigid rotation x, D x, H x, M^-1 S, shape functions at the contact point, their
# slopes there
COUPLING, LOAD, RIGID, GRAVITY_RIGID, SHORTENING_RIGID, MASS_RESPONSE, CONTACT_SHAPE, CONTACT_SLOPE = range(8)
_LANES = 4
# `Workspace.matrices` of a banded system: columns to solve in, then the factors of effective matrices
COLUMNS, FIRST_EFFECTIVE = 0, 1
Three = tuple[Array, Array, Array]


class NodalPlaces(NamedTuple):
    """Places at which the whole beam can touch obstacles, and its state in the floating frame."""

    shapes: HermiteShapes
    each: Any  # (places,) records of `oblique_impact.beam.axis.PLACE`
    q: Array  # (n + 1,) theta and B
    qd: Array  # (n + 1,)
    vectors: Array  # (19, n + 1) see `Workspace`


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
        # of the contact point on the slope: degrees of freedom that deflection and slope there take, x_F (m),
        # place e (m) across the beam from its axis, e again, and the slope's angle (rad) and offsets c_n and c_t
        # (m)
        ("contact_first", np.int64),
        ("contact_end", np.int64),
        ("contact_radius", float),
        ("fibre", float),
        ("fibre_turning", float),
        ("slope_angle", float),
        ("normal_offset", float),
        ("tangential_offset", float),
    ],
    align=True,
)


class _NodalData(NamedTuple):
    """A nodal beam with n free degrees of freedom, constant during a run."""

    numbers: Any  # a record of `NODAL_NUMBERS`
    bands: Array  # (5, 4, n) diagonals 0..3: bands[b, k, i] is the entry (i, i + k)
    mass_factor: Array  # (n + 3, 4) of the mass matrix
    vectors: Array  # (8, n)
    places: NodalPlaces | None = None  # in the place of the contact point on the slope: the whole beam
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
def _touch_point(
    model: NodalModel,
    q: Array,
    qd: Array,
    rows: bool,
    w: Workspace,
    at: Candidate,
    normal_row: Array,
    tangential_row: Array,
) -> None:
    """Gap, slip and rates of the contact point, with `rows` biases and the rows D_B + S (D_theta - x.D_B)/J."""
    v, u, n = w.vectors, model.vectors, model.numbers
    e, turning, scratch_a, HB = n.fibre, n.fibre_turning, v[SCRATCH_A], v[SCRATCH_C]
    shape, slope = u[CONTACT_SHAPE], u[CONTACT_SLOPE]
    theta, spin = _frame(model, q, qd)
    band_multiply(model.bands, SHORTENING_BAND, q, HB)
    rigid, bent, bending = 0.0, 0.0, 0.0
    for i in range(q.shape[0]):
        HB[i] -= theta * u[SHORTENING_RIGID, i]
        rigid += HB[i] * u[RIGID, i]
        bent += HB[i] * q[i]
        bending += HB[i] * qd[i]
    place, speed, phi, phi_rate = 0.0, 0.0, -theta, -spin
    for i in range(n.contact_first, n.contact_end):
        place += shape[i] * q[i]
        speed += shape[i] * qd[i]
        phi += slope[i] * q[i]
        phi_rate += slope[i] * qd[i]
    x = n.contact_radius - 0.5 * (bent - theta * rigid) - e * phi
    y = place - n.contact_radius * theta + (e - 0.5 * turning * phi * phi)
    x_rate = -(bending - spin * rigid) - e * phi_rate
    y_rate = speed - n.contact_radius * spin - turning * phi * phi_rate
    angle = theta - n.slope_angle
    c, s = np.cos(angle), np.sin(angle)
    # -dx/dB and dy/dB of the contact point by the rigid rotation x
    along, across = rigid + e, n.contact_radius - turning * phi
    normal = (x * c - y * s + s * along - c * across) / n.inertia
    tangential = (-x * s - y * c + c * along + s * across) / n.inertia
    momentum = n.inertia * spin  # S.W'
    gap_rate, slip_rate = normal * momentum - s * bending, tangential * momentum - c * bending
    lengthwise, crosswise = e * (phi_rate + spin), turning * phi * (phi_rate + spin)
    gap_rate -= s * lengthwise + c * crosswise
    slip_rate -= c * lengthwise - s * crosswise
    if rows:
        for i in range(q.shape[0]):
            normal_row[i] = -s * HB[i] + normal * u[COUPLING, i]
            tangential_row[i] = -c * HB[i] + tangential * u[COUPLING, i]
        for i in range(n.contact_first, n.contact_end):
            normal_row[i] += c * (shape[i] - turning * phi * slope[i]) - s * e * slope[i]
            tangential_row[i] -= s * (shape[i] - turning * phi * slope[i]) + c * e * slope[i]
    square, turned, curved = spin * spin, turning * phi_rate * phi_rate, 0.0  # B'^T H B'
    at.gap, at.slip = x * s + y * c - n.normal_offset, x * c - y * s - n.tangential_offset
    at.gap_rate, at.slip_rate = gap_rate + c * speed, slip_rate - s * speed
    if rows:
        band_multiply(model.bands, SHORTENING_BAND, qd, scratch_a)
        curved = dot(scratch_a, qd) - 2.0 * spin * dot(u[SHORTENING_RIGID], qd)
        curved += spin * spin * dot(u[SHORTENING_RIGID], u[RIGID])
        at.gap_bias = 2.0 * spin * (c * x_rate - s * y_rate) - square * (s * x + c * y) - s * curved - c * turned
        at.slip_bias = -2.0 * spin * (s * x_rate + c * y_rate) - square * (c * x - s * y) - c * curved + s * turned


@jitable
def _take_state(places: NodalPlaces | None, model: NodalModel, q: Array, qd: Array) -> None:
    """Take the state into the floating frame, where the rows of places are known; of a model that has any."""
    if places is None:
        return
    frame, frame_qd = places.q, places.qd
    frame[0], frame_qd[0] = _frame(model, q, qd)
    for j in range(q.shape[0]):
        frame[j + 1] = q[j] - frame[0] * model.vectors[RIGID, j]
        frame_qd[j + 1] = qd[j] - frame_qd[0] * model.vectors[RIGID, j]
    places.shapes.bend(frame[1:], frame_qd[1:])


@jitable
def take_nodal_state(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> None:
    """Take the state in which places are touched and measured."""
    _take_state(model.places, model, q, qd)


@jitable
def _touch_place(
    places: NodalPlaces, model: NodalModel, i: int, w: Workspace, c: Candidate, normal: Array, tangential: Array
) -> None:
    """Gap, slip, rates and biases of one of several places, with the rows D_B + S (D_theta - x.D_B)/J."""
    frame, frame_qd, v, place = places.q, places.qd, places.vectors, places.each[i]
    B, Bd, own_normal, own_tangential = frame[1:], frame_qd[1:], v[PRODUCT_A], v[PRODUCT_B]
    if place.on_side:
        axis = places.shapes.bent_axis(place.x, B)
        bending, _ = places.shapes.take_shapes(axis, B, Bd, v)
        shape, slope, HB = v[SCRATCH_A, 1:], v[SCRATCH_B, 1:], v[SHORTENING_PRODUCT]
        touch_side(place, 0.0, shape, slope, HB, bending, frame, frame_qd, c, own_normal, own_tangential)
    else:
        touch_peg(places.shapes, 0.0, place, frame, frame_qd, v, c, own_normal, own_tangential)
    _turn_row(model, own_normal, normal)
    _turn_row(model, own_tangential, tangential)
    c.gap_rate, c.slip_rate = dot(own_normal, frame_qd), dot(own_tangential, frame_qd)


@jitable
def _turn_row(model: NodalModel, row: Array, target: Array) -> None:
    """Turn a row (n + 1,) over theta and B into one over W."""
    share = row[0]
    for i in range(target.shape[0]):
        share -= model.vectors[RIGID, i] * row[i + 1]
    share /= model.numbers.inertia
    for i in range(target.shape[0]):
        target[i] = row[i + 1] + share * model.vectors[COUPLING, i]


@jitable
def _touch(
    places: NodalPlaces | None,
    model: NodalModel,
    i: int,
    q: Array,
    qd: Array,
    w: Workspace,
    c: Candidate,
    normal: Array,
    tangential: Array,
) -> None:
    """Touch the contact point or one of several places; the compiler drops one of the two branches."""
    if places is None:
        _touch_point(model, q, qd, True, w, c, normal, tangential)
    else:
        _touch_place(places, model, i, w, c, normal, tangential)


@jitable
def touch_nodal(
    model: NodalModel,
    i: int,
    t: float,
    q: Array,
    qd: Array,
    w: Workspace,
    c: Candidate,
    normal: Array,
    tangential: Array,
) -> None:
    """Gap, slip, their rates and biases of one place of contact in the state taken last, and its rows."""
    _touch(model.places, model, i, q, qd, w, c, normal, tangential)


@jitable
def _measure_peg(places: NodalPlaces, peg: Any, cosine: float, sine: float, c: Candidate) -> None:
    """Gap, slip and gap rate of a peg as in `touch_peg`, at cosine and sine of the frame's angle."""
    spin, B, Bd = places.qd[0], places.q[1:], places.qd[1:]
    X, Y = peg.x * cosine + peg.y * sine, peg.y * cosine - peg.x * sine
    x, axis = place_of(places.shapes, 0.0, X, Y, B)
    u_x_rate, u_y_rate, _ = axis_rates(places.shapes, axis, B, Bd)
    steep = 1.0 - 0.5 * axis.slope * axis.slope
    stretch = np.sqrt(steep * steep + axis.slope * axis.slope)
    nx, ny = -peg.side * axis.slope / stretch, peg.side * steep / stretch
    rx, ry = x + axis.u_x, axis.u_y
    c.gap, c.slip = nx * (rx - X) + ny * (ry - Y) - peg.distance, -x
    c.gap_rate = nx * (u_x_rate - spin * ry) + ny * (u_y_rate + spin * rx)


@jitable
def _measure_side(places: NodalPlaces, place: Any, at: Candidate) -> None:
    """Gap, slip and gap rate of a place of the beam against a side, as in `touch_side`."""
    spin, B, Bd, fibre, angle = places.qd[0], places.q[1:], places.qd[1:], place.fibre, places.q[0] - place.angle
    axis = places.shapes.bent_axis(place.x, B)
    u_x_rate, u_y_rate, slope_rate = axis_rates(places.shapes, axis, B, Bd)
    c, s = np.cos(angle), np.sin(angle)
    x = place.x + axis.u_x - fibre * axis.slope
    y = axis.u_y + (fibre - 0.5 * place.turning * axis.slope * axis.slope)
    x_rate = u_x_rate - fibre * slope_rate - spin * y
    y_rate = u_y_rate - place.turning * axis.slope * slope_rate + spin * x
    at.gap, at.slip = x * s + y * c - place.normal_offset, x * c - y * s - place.tangential_offset
    at.gap_rate = s * x_rate + c * y_rate


@jitable
def _measure(
    places: NodalPlaces | None, model: NodalModel, q: Array, qd: Array, w: Workspace, contacts: Contacts
) -> None:
    """Measure the contact point or all places, each in O(1); the compiler drops one of the two branches."""
    if places is None:
        _touch_point(model, q, qd, False, w, contacts.each[0], w.vectors[SCRATCH_A], w.vectors[SCRATCH_A])
    else:
        cosine, sine = np.cos(places.q[0]), np.sin(places.q[0])
        for i in range(len(contacts.each)):
            if places.each[i].on_side:
                _measure_side(places, places.each[i], contacts.each[i])
            else:
                _measure_peg(places, places.each[i], cosine, sine, contacts.each[i])


@jitable
def measure_nodal(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace, contacts: Contacts) -> None:
    """Gap, slip and gap rate of every place of contact."""
    _take_state(model.places, model, q, qd)
    _measure(model.places, model, q, qd, w, contacts)


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
