"""The full nodal beam in its total transverse coordinates: banded mass, forces, contact rows.

W = x theta + B are the nodal deflections and slopes seen from the root's inertial axis turned to nothing: rigid
rotation and elastic deflection in one vector.  x is the distance from the axis of rotation, with the slope 1.  The
first coordinate is the slope of the root, which a hub of radius r moves across by r times it.  Of a driven root it
is prescribed; if its clamp yields, the slope of the beam there is a coordinate of its own behind it.

M, S = M x and J = x.S are those of beam, hub and point masses, whose inertias M has at the slopes where they turn.
W splits again by
theta = a.W, B = W - x theta, with a.x = 1: a = S/J in the mean-axis frame, where S.B = 0; in the tangent frame,
which is that of a driven root too, it is the first unit vector.  First-order kinetics reads

    (M + kappa a a^T) W'' + Cd W' + K W = f + d_n lambda_n + d_tau lambda_tau,   kappa = B^T N B
    f = f_B + a (Q_theta - x.f_B),     f_B = theta'^2 N W - g (cos theta P - sin theta D B)
    Q_theta = -2 theta' B^T N B' - g (Sm cos theta - 1/2 cos theta B^T D B - sin theta P.B)
    d = D_B + a (D_theta - x.D_B)

with N = M1 - C of the beam alone, because N x = 0 and K x = 0.  Everything is banded but for rank one, so a step
costs O(n).

Where nodes have no inertia (:class:`MeanVelocities`) M is singular: what it does not see of the velocities is a
matter of choice, and not marched.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from oblique_impact.beam.axis import AxisPoint, meet, point_of
from oblique_impact.beam.base_motion import drive_acceleration
from oblique_impact.beam.floating_frame import DRIVEN, take_prescribed
from oblique_impact.beam.hermite import HermiteShapes
from oblique_impact.beam.point_forces import PointForces, force_in_frame
from oblique_impact.beam.shaking import (
    Shaking,
    base_acceleration,
    direction_in_frame,
    stands_still,
    weight_in_frame,
)
from oblique_impact.contact.sides_and_pegs import PointMotion, heading_of, take_rows
from oblique_impact.contact.state import DIRECTION, FREE, RESPONSE, Candidate, Contacts
from oblique_impact.kernels.banded import (
    HALF_BANDWIDTH,
    band_multiply,
    factor_band,
    solve_band,
    solve_band_columns,
)
from oblique_impact.kernels.dense import DenseAlgebra
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.laws import Law
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
    SUPPLY,
    VECTORS,
    Array,
    Evaluation,
    Workspace,
    copy,
    dot,
)

# NodalModel.bands: mass with the hub's, stiffness, N = M1 - C, gravity stiffness D; the first two without the
# prescribed coordinate of a driven root
MASS_BAND, STIFFNESS_BAND, SPIN_BAND, GRAVITY_BAND = range(4)
# NodalModel.vectors: S, P, the rigid rotation x, D x, a, M^-1 a; rows of mass and stiffness of the prescribed
# coordinate of a driven root, but for its own entry
COUPLING, LOAD, RIGID, GRAVITY_RIGID, FRAME, FRAME_RESPONSE, ROOT_MASS, ROOT_STIFFNESS = range(8)
_LANES = 4
# `Workspace.matrices` of a banded system: columns to solve in, then the factors of effective matrices
COLUMNS, FIRST_EFFECTIVE = 0, 1
Three = tuple[Array, Array, Array]


class NodalPlaces(NamedTuple):
    """Places at which the beam can touch obstacles, and its state in the floating frame: all m nodal values.

    They are deflection and slope node by node, those of the root included.
    """

    mesh: HermiteShapes
    each: Any  # (places,) records of `oblique_impact.beam.axis.PLACE`
    q: Array  # (m + 1,) theta and B
    qd: Array  # (m + 1,)
    vectors: Array  # (23, m + 1) see `Workspace`
    condensed: Array  # (n,) the last deflection by the n coordinates; (0,): it is one of them


class NodalLoads(NamedTuple):
    """Forces on the beam and the places where they act, with a state of their own."""

    forces: PointForces
    places: NodalPlaces


class MeanVelocities(NamedTuple):
    """Means b_e of the velocities on elements, all that has inertia, and motions r_e of these means alone.

    b_e r_e = 1, b_e r_f = 0; both are over deflection and slope at the start and at the end of each element.
    """

    means: Array  # (elements, 4); (0, 4) of nodes with inertia
    motions: Array  # (elements, 4)
    held: bool  # whether the first coordinate has an inertia of its own, or is prescribed


WITH_INERTIA = MeanVelocities(np.zeros((0, 4)), np.zeros((0, 4)), False)


#: what is one number of a nodal beam with its root
NODAL_NUMBERS = np.dtype(
    [
        ("root", np.int64),
        ("yields", np.int64),  # 1: the slope of the root is a coordinate of its own, the second one
        ("inertia", float),  # J (kg m^2), with the hub's
        ("static_moment", float),  # Sm (kg m)
        ("gravity", float),
        ("torque", float),  # on the hub (N m)
        ("kelvin_voigt", float),  # s
        ("mass_proportional", float),  # 1/s
        ("hub_radius", float),
        ("spin_rate", float),  # rad/s, at the end of the spin-up of a driven root
        ("spin_up_time", float),
        ("root_stiffness", float),  # N m/rad, of a clamp that yields
        ("root_damping", float),  # N m s/rad
        ("rest_angle", float),  # rad, of a hub at which its spring has no moment
    ],
    align=True,
)


class _NodalData(NamedTuple):
    """A nodal beam with n coordinates, constant during a run."""

    numbers: Any  # a record of `NODAL_NUMBERS`
    bands: Array  # (4, 4, n) diagonals 0..3: bands[b, k, i] is the entry (i, i + k)
    mass_factor: Array  # (n + 3, 4) of the mass matrix
    vectors: Array  # (8, n)
    places: NodalPlaces
    shaking: Shaking  # of the base
    loads: NodalLoads  # forces on the beam
    massless: MeanVelocities
    drive: Law | None = None  # acceleration (rad/s^2) of a driven root over time, in the place of a spin-up


@jitable
def _frame(model: NodalModel, q: Array, qd: Array) -> tuple[float, float]:
    """Angle and angular velocity of the frame, a.W and a.W'."""
    theta, spin = 0.0, 0.0
    for i in range(q.shape[0]):
        theta += model.vectors[FRAME, i] * q[i]
        spin += model.vectors[FRAME, i] * qd[i]
    return theta, spin


@inlined
def _take_nodal_values(model: NodalModel, places: NodalPlaces, theta: float, q: Array, frame: Array) -> None:
    """Put theta and the nodal values of B = W - x theta into `frame` (m + 1,)."""
    rigid, yields = model.vectors[RIGID], model.numbers.yields
    frame[0], frame[1] = theta, model.numbers.hub_radius * (q[0] - theta)
    for j in range(yields, q.shape[0]):
        frame[j + 2 - yields] = q[j] - theta * rigid[j]
    _expand(places.condensed, yields, frame)


@jitable
def take_nodal_state(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> None:
    """Take the state into the floating frame, in which places of contact are known."""
    _take_places(model, model.places, q, qd)


@jitable
def _take_places(model: NodalModel, places: NodalPlaces, q: Array, qd: Array) -> None:
    """Take the state into the floating frame for some places."""
    theta, spin = _frame(model, q, qd)
    _take_nodal_values(model, places, theta, q, places.q)
    _take_nodal_values(model, places, spin, qd, places.qd)
    places.mesh.bend(places.q[1:], places.qd[1:])


@jitable
def _expand(condensed: Array, yields: int, frame: Array) -> None:
    """Insert the last deflection where it follows the other coordinates."""
    if condensed.shape[0] == 0:
        return
    last, deflection = frame.shape[0] - 1, 0.0
    for j in range(condensed.shape[0]):
        deflection += condensed[j] * frame[j + 2 - yields]
    frame[last] = frame[last - 1]
    frame[last - 1] = deflection


@jitable
def _condense(condensed: Array, yields: int, row: Array) -> None:
    """Take the last deflection out of a row over the coordinates, see `_expand`."""
    if condensed.shape[0] == 0:
        return
    last = row.shape[0] - 1
    share = row[last - 1]
    row[last - 1] = row[last]
    for j in range(condensed.shape[0]):
        row[j + 2 - yields] += share * condensed[j]


@jitable
def _take_point_rows(
    model: NodalModel, places: NodalPlaces, place: Any, x: float, axis: AxisPoint, point: PointMotion, v: Array
) -> None:
    """Rows (2, n) over W of a point of the beam in the frame, J_B + a (J_theta - x.J_B).

    Those over B are as in :mod:`~oblique_impact.beam.floating_frame`.  Elements hold the function x exactly, so
    that x.(H B) = u_y, x.Phi = x and x.Phi' = 1.
    """
    along_frame, numbers, own = model.vectors[FRAME], model.numbers, places.vectors
    yields = numbers.yields
    places.mesh.take_shapes(axis, places.q[1:], own)
    for which in (SCRATCH_A, SCRATCH_B, SHORTENING_PRODUCT):
        _over_coordinates(model, own[which])
    shape, slope, HB = own[SCRATCH_A], own[SCRATCH_B], own[SHORTENING_PRODUCT]
    e, kept, leaning = place.fibre, place.shortening, place.turning * axis.slope
    along = kept * axis.u_y + e - point.y
    across = point.x - (numbers.hub_radius + x) + leaning
    for j in range(along_frame.shape[0]):
        k = j + 2 - yields
        v[ALONG, j] = along * along_frame[j] - kept * HB[k] - e * slope[k]
        v[ACROSS, j] = across * along_frame[j] + shape[k] - leaning * slope[k]
    if not place.on_side:
        shortened = -0.5 * axis.slope * axis.slope
        for j in range(along_frame.shape[0]):
            k = j + 2 - yields
            v[ALONG_TURNED, j] = -axis.slope * slope[k]
            v[ACROSS_TURNED, j] = slope[k] + shortened * along_frame[j]


@inlined
def _over_coordinates(model: NodalModel, row: Array) -> None:
    """Turn a row over the nodal values, behind the entry of theta, into one over W that starts at 2 or 1."""
    yields, lever = model.numbers.yields, model.numbers.hub_radius * row[1]
    if yields:
        row[1] = lever
    else:
        row[2] += lever
    _condense(model.places.condensed, yields, row)


@jitable
def touch_nodal(
    model: NodalModel, i: int, t: float, q: Array, qd: Array, w: Workspace, c: Candidate, rows: Array
) -> None:
    """Gap, slip, their rates and biases of one place of contact in the state taken last, and its rows."""
    places = model.places
    heading = heading_of(places.q[0])
    met = meet(places.mesh, model.numbers.hub_radius, places.each[i], places.q, places.qd, heading, c)
    _take_point_rows(model, places, places.each[i], met.x, met.axis, met.point, w.vectors)
    take_rows(met.directions, w.vectors, rows)
    if places.each[i].on_side:
        c.shift, c.shift_rate = places.q[0], places.qd[0]
        if rows.shape[0] > 2:
            for j in range(rows.shape[1]):
                rows[2, j] = model.vectors[FRAME, j]
    if model.numbers.root == DRIVEN:
        take_prescribed(_driven(model, t), places.each[i].on_side, c, rows)


@jitable
def _apply_loads(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> float:
    """Add the forces on the beam; their power (W)."""
    loads, v, power = model.loads, w.vectors, 0.0
    places = loads.places
    if len(places.each) == 0:
        return power
    _take_places(model, places, q, qd)
    for k in range(len(places.each)):
        place, B, Bd = places.each[k], places.q[1:], places.qd[1:]
        axis = places.mesh.bent_axis(place.x, B)
        motion, _ = places.mesh.motion_at(axis, B, Bd)
        point = point_of(place, model.numbers.hub_radius + place.x, motion, places.qd[0])
        _take_point_rows(model, places, place, place.x, axis, point, v)
        along, across = force_in_frame(loads.forces, k, t, places.q[0], axis.slope)
        for i in range(q.shape[0]):
            v[FORCES, i] += along * v[ALONG, i] + across * v[ACROSS, i]
        power += along * point.x_rate + across * point.y_rate
    return power


@jitable
def measure_nodal(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace, contacts: Contacts) -> None:
    """Gap, slip and gap rate of every place of contact, each in O(1)."""
    places = model.places
    take_nodal_state(model, t, q, qd, w)
    heading = heading_of(places.q[0])
    for i in range(len(contacts.each)):
        c = contacts.each[i]
        meet(places.mesh, model.numbers.hub_radius, places.each[i], places.q, places.qd, heading, c)
        if places.each[i].on_side:
            c.shift, c.shift_rate = places.q[0], places.qd[0]


@jitable
def _keep_means(massless: MeanVelocities, yields: int, mean: Array, v: Array) -> None:
    """Replace `v` by `mean`, but for its means on the elements, where nodes have no inertia."""
    if massless.means.shape[0] == 0:
        return
    b, r, n = massless.means, massless.motions, v.shape[0]
    root = v[0] - mean[0] if massless.held else 0.0
    for j in range(n):
        v[j] -= mean[j]
    for e in range(b.shape[0]):
        share, first = -root * b[e, 1] if e == yields == 0 else 0.0, 2 * e - 1 + yields
        for k in range(1 if e == 0 else 0, 4):
            share += b[e, k] * v[first + k]
        for k in range(1 if e == 0 else 0, 4):
            mean[first + k] += r[e, k] * share
    mean[0] += root
    copy(mean, v)


@jitable
def set_massless_nodal(model: NodalModel, mean: Array, v: Array) -> None:
    """Give motions without inertia the velocities `mean`, which change; only for meshes without nodal inertia."""
    _keep_means(model.massless, model.numbers.yields, mean, v)


@jitable
def _forces(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> tuple[float, float]:
    """Generalized forces f - K W - Cd W'; returns kappa and the power (W) of damping."""
    v, u, numbers = w.vectors, model.vectors, model.numbers
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
    square = spin * spin
    for i in range(n):
        forces[i] = square * NW[i] - g * (c * u[LOAD, i] - s * DB[i]) + moment * u[FRAME, i] - forces[i]
    forces[0] += numbers.torque  # the first coordinate is the slope of a hub
    if numbers.root == DRIVEN:
        forces[0] -= _of_neighbours(u[ROOT_STIFFNESS], B)
    power = 0.0
    if numbers.kelvin_voigt > 0.0 or numbers.mass_proportional > 0.0:
        power = _damp(model, qd, w)
        for i in range(n):
            forces[i] -= NW[i]
    power += _clamp(model, q, qd, forces)
    return lag, power


@inlined
def _of_neighbours(row: Array, x: Array) -> float:
    """Product with the row of the prescribed coordinate, of which the first entries alone are not zero."""
    total = 0.0
    for j in range(1, min(HALF_BANDWIDTH + 1, x.shape[0])):
        total += row[j] * x[j]
    return total


@inlined
def _clamp(model: NodalModel, q: Array, qd: Array, forces: Array) -> float:
    """Add the moment of the clamp's spring and dashpot to the forces; the power (W) of the dashpot.

    They turn a hub against the ground, and the root's section against the angle that is prescribed.
    """
    numbers, at = model.numbers, model.numbers.yields
    if not (numbers.root_stiffness > 0.0 or numbers.root_damping > 0.0):
        return 0.0
    turn, rate = q[at] - numbers.rest_angle, qd[at]
    if numbers.root == DRIVEN:
        turn, rate = q[at] - q[0], qd[at] - qd[0]
    moment = numbers.root_stiffness * turn + numbers.root_damping * rate
    forces[at] -= moment
    if numbers.root == DRIVEN:
        forces[0] += moment
    return float(numbers.root_damping * rate * rate)


@inlined
def _driven(model: NodalModel, t: float) -> float:
    """Angular acceleration (rad/s^2) of a driven root at t (s)."""
    return drive_acceleration(model.drive, model.numbers.spin_rate, model.numbers.spin_up_time, t)


@jitable
def _prescribe(model: NodalModel, t: float, spin: float, rank_one: float, w: Workspace) -> float:
    """Replace the row of the prescribed coordinate; power (W) of the driver at q'' = 0.

    The rest of its power, supply . q'', and that of the contact force follow from the row that is replaced.
    """
    v, bands, row, acceleration = w.vectors, model.bands, model.vectors[ROOT_MASS], _driven(model, t)
    forces, supply = v[FORCES], v[SUPPLY]
    power: float = -forces[0] * spin
    forces[0] = bands[MASS_BAND, 0, 0] * acceleration
    supply[0] = (row[0] + rank_one) * spin
    for j in range(1, min(HALF_BANDWIDTH + 1, row.shape[0])):
        supply[j] = row[j] * spin
        forces[j] -= row[j] * acceleration
    return power


@jitable
def _supplied_power(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> float:
    """Power (W) of the torque on the hub and of the inertia force by a shaken base."""
    power: float = model.numbers.torque * qd[0]
    shaking = model.shaking
    if stands_still(shaking):
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
    """Put the forces of the beam's own damping, Cd W', into the row SCRATCH_A; their power (W).

    They act on what is left of W' without a rotation: of a root that is free to turn without that of beam and hub
    as a whole, whatever the frame, of a driven root without its own.
    """
    v, u, numbers, power = w.vectors, model.vectors, model.numbers, 0.0
    damped, heavy, rates, driven = v[SCRATCH_A], v[SCRATCH_B], v[SCRATCH_C], numbers.root == DRIVEN
    spin = qd[0] if driven else dot(u[COUPLING], qd) / numbers.inertia
    for i in range(qd.shape[0]):
        rates[i] = qd[i] - spin * u[RIGID, i]
    band_multiply(model.bands, STIFFNESS_BAND, rates, damped)
    band_multiply(model.bands, MASS_BAND, rates, heavy)
    if driven:
        damped[0] = _of_neighbours(u[ROOT_STIFFNESS], rates)
        heavy[0] = _of_neighbours(u[ROOT_MASS], rates) - dot(u[COUPLING], rates)
    for i in range(qd.shape[0]):
        damped[i] = numbers.kelvin_voigt * damped[i] + numbers.mass_proportional * heavy[i]
        power += damped[i] * rates[i]
    return power


@jitable
def nodal_damping(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> float:
    """Power (W) of the damping matrix at the velocities q'."""
    numbers, power = model.numbers, 0.0
    if numbers.kelvin_voigt > 0.0 or numbers.mass_proportional > 0.0:
        power = _damp(model, qd, w)
    if numbers.root_damping > 0.0:
        rate = qd[numbers.yields] - qd[0] if numbers.root == DRIVEN else qd[0]
        power += numbers.root_damping * rate * rate
    return power


@jitable
def evaluate_nodal(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
    """Fill forces at (q, q')."""
    rank_one, damping = _forces(model, t, q, qd, w)
    supplied = _supplied_power(model, t, q, qd, w)
    supplied += _apply_loads(model, t, q, qd, w)
    if model.numbers.root == DRIVEN:
        supplied += _prescribe(model, t, qd[0], rank_one, w)
        rank_one = 0.0
    return Evaluation(damping, supplied, rank_one)


@jitable
def take_nodal_residual(model: NodalModel, t: float, q: Array, qd: Array, qdd: Array, w: Workspace) -> Evaluation:
    """Take forces and the residual f - K W - Cd W' - M W''."""
    forces, residual = w.vectors[FORCES], w.vectors[RESIDUAL]
    found = evaluate_nodal(model, t, q, qd, w)
    multiply_nodal_mass(model, found.rank_one, w, qdd, residual)
    for i in range(q.shape[0]):
        residual[i] = forces[i] - residual[i]
    return found


@jitable
def approach_nodal(model: NodalModel, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
    """Supplied power at (q, q')."""
    if model.numbers.root == DRIVEN or len(model.loads.places.each) > 0:
        return evaluate_nodal(model, t, q, qd, w)
    return Evaluation(0.0, _supplied_power(model, t, q, qd, w), 0.0)


@jitable
def multiply_nodal_mass(model: NodalModel, rank_one: float, w: Workspace, x: Array, product: Array) -> None:
    """(M + kappa a a^T) x into `product`."""
    band_multiply(model.bands, MASS_BAND, x, product)
    share = rank_one * dot(model.vectors[FRAME], x)
    for i in range(x.shape[0]):
        product[i] += share * model.vectors[FRAME, i]


@jitable
def _solve(model: NodalModel, rank_one: float, factors: Array, response: Array, right: Array, x: Array) -> bool:
    """Solve for a vector; the rank-one part by Sherman and Morrison with the `response` of a.

    False if the matrix with its rank-one part is not positive definite.
    """
    frame = model.vectors[FRAME]
    copy(right, x)
    solve_band(factors, x)
    pivot = 1.0 + rank_one * dot(frame, response)
    if not pivot > 0.0:
        return False
    share = rank_one / pivot * dot(frame, x)
    for i in range(x.shape[0]):
        x[i] -= share * response[i]
    return True


@jitable
def _solve_three(
    model: NodalModel, rank_one: float, factors: Array, response: Array, columns: Array, rights: Three, xs: Three
) -> bool:
    """Solve for three vectors side by side, in `columns`; see `_solve`."""
    frame, n = model.vectors[FRAME], response.shape[0]
    right_a, right_b, right_c = rights
    x_a, x_b, x_c = xs
    for i in range(n):
        columns[i, 0], columns[i, 1], columns[i, 2] = right_a[i], right_b[i], right_c[i]
    solve_band_columns(factors, columns)
    a, b, c, own = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        a += frame[i] * columns[i, 0]
        b += frame[i] * columns[i, 1]
        c += frame[i] * columns[i, 2]
        own += frame[i] * response[i]
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
    v, factors, response = w.vectors, model.mass_factor, model.vectors[FRAME_RESPONSE]
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
    numbers = model.numbers
    mass = 1.0 + velocity * numbers.mass_proportional
    stiffness = position + velocity * numbers.kelvin_voigt
    clamp = position * numbers.root_stiffness + velocity * numbers.root_damping
    factors = w.matrices[FIRST_EFFECTIVE + slot]
    if not factor_band(model.bands, MASS_BAND, mass, STIFFNESS_BAND, stiffness, numbers.yields, clamp, factors):
        return False
    response = w.vectors[RANK_ONE + slot]
    copy(model.vectors[FRAME], response)
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

    begin_step = DenseAlgebra.begin_step
    end_step = DenseAlgebra.end_step
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
        """1 + kappa a.M^-1 a, which vanishes with the definiteness of the mass matrix."""
        return float(1.0 + rank_one * (self.vectors[FRAME] @ self.vectors[FRAME_RESPONSE]))


def factored_mass(bands: Array, frame: Array) -> tuple[Array, Array]:
    """Factors of the mass matrix, (n + 3, 4) as of `factor_band`, and M^-1 a (n,).

    Raises LinAlgError if the matrix is not positive definite.
    """
    n = frame.size
    lower = np.zeros((HALF_BANDWIDTH + 1, n))  # by diagonals: lower[k, i] is the entry (i + k, i)
    for k in range(HALF_BANDWIDTH + 1):
        lower[k, : n - k] = bands[MASS_BAND, k, : n - k]
    cholesky = cholesky_banded(lower, lower=True)
    factors = np.zeros((n + HALF_BANDWIDTH, _LANES))
    factors[:n, 0] = cholesky[0] ** -2
    for k in range(1, HALF_BANDWIDTH + 1):
        factors[k:n, k] = cholesky[k, : n - k] / cholesky[0, : n - k]
    return factors, cho_solve_banded((cholesky, True), frame)


def mean_velocities(means: Array, held: bool, yields: bool) -> MeanVelocities:
    """Return the means (elements, n) of the deflections on elements with motions of these means.

    Between two elements with the means a w + s phi and a' w + s' phi of deflection w and slope phi of their node,
    (s', -a') leaves the second where it is, (-s, a) the first.  A root that is held does not move.
    """
    count, rigid = len(means), held and not yields
    # the first coordinate is the slope of the root; of a clamp that yields it moves its deflection alone
    padded = means if yields else np.hstack([np.zeros((count, 1)), means])
    own = np.array([padded[e, 2 * e : 2 * e + 4] for e in range(count)])
    motions = np.zeros((count, 4))
    if not rigid:
        motions[0, 1] = 0.5 / own[0, 1]
    motions[-1, 2] = 0.5 / own[-1, 2]
    for e in range(count - 1):
        a, s, after, steep = own[e, 2], own[e, 3], own[e + 1, 0], own[e + 1, 1]
        half = 0.5 / (a * steep - s * after)
        motions[e, 2:], motions[e + 1, :2] = (half * steep, -half * after), (-half * s, half * a)
    if rigid:
        motions[0] *= 2.0
    return MeanVelocities(own, motions, held)
