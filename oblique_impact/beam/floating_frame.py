"""The beam in its floating frame: mass matrix, forces, contact rows, energies.

Generalized coordinates q = [theta, B].  Kinetic energy in three orders (`zeroth-order` is the
first-order model with the foreshortening operators C, D and H set to zero); equations of motion
after Yuan et al. 2016, Eq. 10, with a hub of radius r and inertia J_h, and a driven root.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from oblique_impact.beam.axis import (
    ContactKinematics,
    Peg,
    Places,
    PointOnSide,
    touch_peg,
)
from oblique_impact.beam.base_motion import Drive, drive_acceleration
from oblique_impact.beam.shaking import Shaking, base_acceleration, direction_in_frame, weight_in_frame
from oblique_impact.kernels.dense import DenseAlgebra, multiply
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array, Evaluation, Vectors, Workspace, dot, new_workspace

PIN, HUB, DRIVEN = 0, 1, 2

# BeamModel.matrices: elastic mass with the hub's share, M1 - C of the beam alone, stiffness, damping,
# gravity stiffness D, H at the contact point, inverse of the elastic mass matrix
ELASTIC_MASS, SPIN_STIFFNESS, STIFFNESS, DAMPING, GRAVITY_STIFFNESS, CONTACT_SHORTENING, MASS_INVERSE = range(7)
# BeamModel.vectors: S with the hub's share, P, slope of the root, shape functions at the contact point, elastic
# accelerations by a unit one of theta (of a driven root 0: theta is prescribed), slopes at the contact point
COUPLING, LOAD, ROOT_SLOPE, CONTACT_SHAPE, FOLLOWING, CONTACT_SLOPE = range(6)


class _BeamData(NamedTuple):
    """A discretized beam with root, gravity, damping and slope; constant during a run.

    Few arrays with named rows, because compiled code hands every array on by value.
    """

    matrices: Array  # (7, n, n)
    vectors: Array  # (6, n)
    quad_points: Array  # (2, nq) r + x (m) and mass (kg)         (exact kinetic energy only, else empty)
    quad_shapes: Array  # (nq, n)
    quad_shortening: Array  # (nq, n, n) H(x)
    inertia: float  # J and the hub's (kg m^2)
    static_moment: float  # Sm (kg m)
    gravity: float
    root: int
    hub_inertia: float
    torque: float
    drive: Drive  # of a driven root
    contact_radius: float  # r + x_F (m)
    fibre: float  # e, place (m) of the contact point across the beam from its axis
    fibre_turning: float  # e, or 0 where terms of second order are left out
    slope_angle: float
    normal_offset: float  # c_n (m)
    tangential_offset: float  # c_t (m)
    places: Places | None = (
        None  # in the place of the contact point on the slope: the whole beam, several obstacles
    )
    place: int = -1  # the one that `evaluate` takes as the contact, -1: none
    shaking: Shaking | None = None  # of the base


@inlined
def _contract(v: Array, x: Array) -> float:
    """v[1:] times x (n,)."""
    total = 0.0
    for i in range(x.shape[0]):
        total += v[i + 1] * x[i]
    return total


@inlined
def _take_products(model: BeamModel, B: Array, Bd: Array, w: Workspace) -> float:
    """Put the products of the model's matrices into their rows; returns B'^T H B' at the contact point.

    All in one loop: each of these short sums by itself would wait for its last addition.
    """
    matrices, v = model.matrices, w.vectors
    spin_product, gravity_product, stiffness_product = v.spin_product, v.gravity_product, v.stiffness_product
    shortening_product, damping_product = v.shortening_product, v.damping_product
    spinning, heavy, stiff, short = (
        matrices[SPIN_STIFFNESS],
        matrices[GRAVITY_STIFFNESS],
        matrices[STIFFNESS],
        matrices[CONTACT_SHORTENING],
    )
    damped, bending = matrices[DAMPING], 0.0
    for i in range(B.shape[0]):
        a, b, c, d, e, f = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(B.shape[0]):
            x, rate = B[j], Bd[j]
            a += spinning[i, j] * x
            b += heavy[i, j] * x
            c += stiff[i, j] * x
            d += short[i, j] * x
            e += damped[i, j] * rate
            f += short[i, j] * rate
        spin_product[i + 1], gravity_product[i + 1], stiffness_product[i + 1] = a, b, c
        shortening_product[i + 1], damping_product[i + 1] = d, e
        bending += f * Bd[i]
    return bending


@jitable
def _apply_forces(model: BeamModel, t: float, theta: float, B: Array, Bd: Array, w: Workspace) -> float:
    """Add gravity with its geometric stiffness, elasticity, damping, hub torque; the power (W) of damping."""
    v = w.vectors
    g, c, s = weight_in_frame(model.shaking, model.gravity, t, theta)
    forces, heavy, stiff, damped = v.forces, v.gravity_product, v.stiffness_product, v.damping_product
    moment = c * (model.static_moment - 0.5 * _contract(heavy, B)) - s * dot(model.vectors[LOAD], B)
    forces[0] += model.torque - g * moment
    for i in range(B.shape[0]):
        weight = g * (c * model.vectors[LOAD, i] - s * heavy[i + 1])
        forces[i + 1] += model.torque * model.vectors[ROOT_SLOPE, i] - weight - (stiff[i + 1] + damped[i + 1])
    return _contract(damped, Bd)


@jitable
def _shaking_power(shaking: Shaking | None, model: BeamModel, t: float, q: Array, qd: Array, v: Vectors) -> float:
    """Power (W) of the inertia force on the beam by a shaken base; the compiler drops this of one that is not."""
    if shaking is None:
        return 0.0
    B, Bd, heavy = q[1:], qd[1:], v.gravity_product
    along, across = direction_in_frame(shaking, np.cos(q[0]), np.sin(q[0]))
    # first moments of mass along x and y of the frame, and their rates in it
    mx, my = model.static_moment - 0.5 * _contract(heavy, B), dot(model.vectors[LOAD], B)
    mx_rate, my_rate = -_contract(heavy, Bd), dot(model.vectors[LOAD], Bd)
    momentum: float = along * (mx_rate - qd[0] * my) + across * (my_rate + qd[0] * mx)
    return -base_acceleration(shaking, t) * momentum


@jitable
def _first_order(model: BeamModel, q: Array, qd: Array, w: Workspace) -> None:
    """Kinetic energy to second order in B: inertia forces, the rows of the mass matrix that are not constant."""
    B, Bd, spin = q[1:], qd[1:], qd[0]
    M, v = w.mass, w.vectors
    forces, product = v.forces, v.spin_product
    M[0, 0] = model.inertia + _contract(product, B)
    forces[0] = -2.0 * spin * _contract(product, Bd)
    for i in range(B.shape[0]):
        M[0, i + 1] = model.vectors[COUPLING, i]
        M[i + 1, 0] = model.vectors[COUPLING, i]
        forces[i + 1] = spin * spin * product[i + 1]


@jitable
def _full(model: BeamModel, q: Array, qd: Array, w: Workspace) -> None:
    """Exact kinetic energy by quadrature: a Gram matrix, positive semidefinite whatever B is."""
    B, Bd, spin = q[1:], qd[1:], qd[0]
    n = B.shape[0]
    M, v = w.mass, w.vectors
    forces, axial_row, transverse_row = v.forces, v.scratch_a, v.scratch_b
    points, shapes, lengthwise = model.quad_points, model.quad_shapes, model.quad_shortening
    for i in range(n + 1):
        forces[i] = 0.0
        for j in range(i + 1):
            M[i, j] = 0.0
    for k in range(shapes.shape[0]):
        mass = points[1, k]
        uy, uy_rate, shortening, shortening_rate, bias = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(n):
            HB, HBd = 0.0, 0.0
            for j in range(n):
                HB += lengthwise[k, i, j] * B[j]
                HBd += lengthwise[k, i, j] * Bd[j]
            shape = shapes[k, i]
            uy += shape * B[i]
            uy_rate += shape * Bd[i]
            shortening -= 0.5 * B[i] * HB
            shortening_rate -= Bd[i] * HB
            bias -= Bd[i] * HBd
            axial_row[i + 1] = -HB
            transverse_row[i + 1] = shape
        arm = points[0, k] + shortening
        axial_row[0], transverse_row[0] = -uy, arm
        axial = mass * (bias - 2.0 * spin * uy_rate - spin * spin * arm)
        transverse = mass * (2.0 * spin * shortening_rate - spin * spin * uy)
        for i in range(n + 1):
            forces[i] -= axial_row[i] * axial + transverse_row[i] * transverse
            for j in range(i + 1):
                M[i, j] += mass * (axial_row[i] * axial_row[j] + transverse_row[i] * transverse_row[j])
    hub_row = axial_row
    hub_row[0] = 1.0
    for i in range(n):
        hub_row[i + 1] = model.vectors[ROOT_SLOPE, i]
    for i in range(n + 1):
        for j in range(i + 1):
            M[i, j] += model.hub_inertia * hub_row[i] * hub_row[j]
            M[j, i] = M[i, j]


@jitable
def _contact(model: BeamModel, q: Array, qd: Array, bending: float, v: Vectors) -> ContactKinematics:
    """Gap, slip and biases at the contact point, and its rows (paper Eqs. 22-24 and 50)."""
    point = PointOnSide(
        model.contact_radius,
        model.slope_angle,
        model.normal_offset,
        model.tangential_offset,
        model.fibre,
        model.fibre_turning,
    )
    return touch_side(point, model.vectors[CONTACT_SHAPE], model.vectors[CONTACT_SLOPE], q, qd, bending, v)


@jitable
def touch_side(
    point: PointOnSide, shape: Array, slope: Array, q: Array, qd: Array, bending: float, v: Vectors
) -> ContactKinematics:
    """Gap, slip, biases and rows of a place of the beam against a side; its x is counted from the axis of the hub.

    A point at the height e in the section, which is turned by phi = Phi' B, lies at

        x_P = r + x_F - B^T H B/2 - e phi,    y_P = Phi B + e (1 - phi^2/2)

    H B is in the row of its products, `bending` is B'^T H B'.
    """
    B, Bd, spin = q[1:], qd[1:], qd[0]
    e, turning = point.fibre, point.turning
    normal_row, tangential_row, HB = v.normal_row, v.tangential_row, v.shortening_product
    phi, phi_rate = dot(slope, B), dot(slope, Bd)
    x = point.x - 0.5 * _contract(HB, B) - e * phi
    y = dot(shape, B) + (e - 0.5 * turning * phi * phi)
    x_rate, y_rate = -_contract(HB, Bd) - e * phi_rate, dot(shape, Bd) - turning * phi * phi_rate
    angle = q[0] - point.angle
    c, s = np.cos(angle), np.sin(angle)
    normal_row[0] = x * c - y * s
    tangential_row[0] = -x * s - y * c
    for i in range(B.shape[0]):
        along, across = HB[i + 1] + e * slope[i], shape[i] - turning * phi * slope[i]
        normal_row[i + 1] = -s * along + c * across
        tangential_row[i + 1] = -c * along - s * across
    offsets = point.normal_offset, point.tangential_offset
    biases = bending, turning * phi_rate * phi_rate
    return kinematics(offsets, c, s, x, y, x_rate, y_rate, spin, biases)


@jitable
def _touch_place(places: Places, i: int, q: Array, qd: Array, v: Vectors) -> ContactKinematics:
    """Gap, slip, biases and rows of one of several places."""
    n = places.numbers[i]
    if not places.on_side[i]:
        return touch_peg(places.shapes, places.radius, Peg(n[0], n[1], n[2], n[3], n[4]), q, qd, v)
    B, Bd, HB, bending = q[1:], qd[1:], v.shortening_product, 0.0
    for j in range(B.shape[0]):
        before, rate = 0.0, 0.0
        for k in range(B.shape[0]):
            before += places.shortening[i, j, k] * B[k]
            rate += places.shortening[i, j, k] * Bd[k]
        HB[j + 1] = before
        bending += Bd[j] * rate
    point = PointOnSide(places.radius + n[0], n[1], n[2], n[3], n[4], n[5])
    return touch_side(point, places.values[i], places.slopes[i], q, qd, bending, v)


@jitable
def _contact_at(
    places: Places | None, model: BeamModel, q: Array, qd: Array, bending: float, v: Vectors
) -> ContactKinematics:
    """Contact on the slope or at one of several places; the compiler drops one of the two branches."""
    if places is None:
        return _contact(model, q, qd, bending, v)
    if model.place >= 0:
        return _touch_place(places, model.place, q, qd, v)
    for i in range(q.shape[0]):
        v.normal_row[i] = 0.0
        v.tangential_row[i] = 0.0
    return ContactKinematics(0.0, 0.0, 0.0, 0.0)


@jitable
def _with_rates(model: BeamModel, t: float, k: ContactKinematics, qd: Array, v: Vectors) -> Evaluation:
    """Complete a contact by its rates, and its rows and biases by the prescribed rotation of a driven root."""
    normal_row, tangential_row = v.normal_row, v.tangential_row
    gap_rate, slip_rate = dot(normal_row, qd), dot(tangential_row, qd)
    gap_bias, slip_bias = k.gap_bias, k.slip_bias
    if model.root == DRIVEN:
        acceleration = drive_acceleration(model.drive, t)
        gap_bias += normal_row[0] * acceleration
        slip_bias += tangential_row[0] * acceleration
        normal_row[0] = 0.0
        tangential_row[0] = 0.0
    return Evaluation(k.gap, k.slip, gap_rate, slip_rate, gap_bias, slip_bias, 0.0, 0.0, 0.0)


@jitable
def touch_beam(model: BeamModel, place: int, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
    """Fill the contact rows of one of several places."""
    v = w.vectors
    return _touched(model.places, model, place, t, q, qd, v)


@jitable
def take_beam_state(model: BeamModel, t: float, q: Array, qd: Array, w: Workspace) -> None:
    """Do nothing: each place is evaluated from the coordinates."""


@jitable
def measure_beam(model: BeamModel, t: float, q: Array, qd: Array, w: Workspace, found: Array) -> None:
    """Gap, slip and gap rate of every place into `found` (places, 3)."""
    for i in range(found.shape[0]):
        k = touch_beam(model, i, t, q, qd, w)
        found[i, 0], found[i, 1], found[i, 2] = k.gap, k.slip, k.gap_rate


@jitable
def set_massless_beam(model: BeamModel, mean: Array, v: Array) -> None:
    """Do nothing: all coordinates have inertia."""


@jitable
def _touched(
    places: Places | None, model: BeamModel, place: int, t: float, q: Array, qd: Array, v: Vectors
) -> Evaluation:
    """Evaluate one of several places; the compiler drops this of a model that has none."""
    if places is None:
        return Evaluation(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    return _with_rates(model, t, _touch_place(places, place, q, qd, v), qd, v)


@inlined
def kinematics(
    offsets: tuple[float, float],
    c: float,
    s: float,
    x: float,
    y: float,
    x_rate: float,
    y_rate: float,
    spin: float,
    biases: tuple[float, float],
) -> ContactKinematics:
    """Gap, slip and their biases for the contact point at (x, y) in a frame that is inclined to the slope.

    `offsets` are c_n and c_t (m), c and s cosine and sine of that angle, x_rate and y_rate velocities in the
    frame; `biases` are what its accelerations in the frame have besides q'', with the sign changed: B'^T H B' and
    e phi'^2.
    """
    square, (bending, turning) = spin * spin, biases
    return ContactKinematics(
        x * s + y * c - offsets[0],
        x * c - y * s - offsets[1],
        2.0 * spin * (c * x_rate - s * y_rate) - square * (s * x + c * y) - s * bending - c * turning,
        -2.0 * spin * (s * x_rate + c * y_rate) - square * (c * x - s * y) - c * bending + s * turning,
    )


@jitable
def _prescribe(model: BeamModel, acceleration: float, spin: float, w: Workspace) -> float:
    """Replace the row of theta by the prescribed acceleration; power (W) of the driver at q'' = 0.

    The rest of its power, supply . q'', and that of the contact force follow from the rows that are replaced.
    """
    M, v = w.mass, w.vectors
    forces, supply = v.forces, v.supply
    power: float = -forces[0] * spin
    forces[0] = acceleration
    supply[0] = M[0, 0] * spin
    M[0, 0] = 1.0
    for i in range(1, forces.shape[0]):
        supply[i] = M[0, i] * spin
        forces[i] -= M[i, 0] * acceleration
        M[0, i] = 0.0
        M[i, 0] = 0.0
    return power


@jitable
def evaluate_beam(model: BeamModel, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
    """Fill mass matrix, forces and contact rows of the beam at (t, q, q')."""
    bending = _take_products(model, q[1:], qd[1:], w)
    _first_order(model, q, qd, w)
    return _evaluate(model, t, q, qd, bending, w)


@jitable
def evaluate_full_beam(model: BeamModel, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
    """Fill mass matrix, forces and contact rows of the beam with exact kinetic energy at (t, q, q')."""
    bending = _take_products(model, q[1:], qd[1:], w)
    _full(model, q, qd, w)
    return _evaluate(model, t, q, qd, bending, w)


@jitable
def _evaluate(model: BeamModel, t: float, q: Array, qd: Array, bending: float, w: Workspace) -> Evaluation:
    """Add what does not depend on the order of the kinetic energy."""
    v = w.vectors
    damping = _apply_forces(model, t, q[0], q[1:], qd[1:], w)
    c = _with_rates(model, t, _contact_at(model.places, model, q, qd, bending, v), qd, v)
    supplied = _shaking_power(model.shaking, model, t, q, qd, v)
    if model.root == HUB:
        supplied += model.torque * (qd[0] + dot(model.vectors[ROOT_SLOPE], qd[1:]))
    if model.root == DRIVEN:
        supplied += _prescribe(model, drive_acceleration(model.drive, t), qd[0], w)
    return Evaluation(
        c.gap, c.slip, c.gap_rate, c.slip_rate, c.gap_bias, c.slip_bias, damping, supplied, c.rank_one
    )


@inlined
def _solve(model: BeamModel, pivot: float, right: Array, x: Array) -> None:
    """Solve M x = right: only the entry of theta in M, less that of the elastic part, changes with q."""
    n, inverse = x.shape[0] - 1, model.matrices[MASS_INVERSE]
    for i in range(n):
        product = 0.0
        for j in range(n):
            product += inverse[i, j] * right[j + 1]
        x[i + 1] = product
    following, total = model.vectors[FOLLOWING], right[0]
    for i in range(following.shape[0]):
        total += following[i] * right[i + 1]
    x[0] = total / pivot
    for i in range(following.shape[0]):
        x[i + 1] += following[i] * x[0]


@jitable
def solve_beam_mass(model: BeamModel, rank_one: float, w: Workspace, contact: bool) -> bool:
    """Solve for the free acceleration and, with `contact`, the responses; False if M is not positive definite."""
    v, pivot, following = w.vectors, w.mass[0, 0], model.vectors[FOLLOWING]
    for i in range(following.shape[0]):
        pivot += following[i] * w.mass[0, i + 1]
    if not pivot > 0.0:
        return False
    _solve(model, pivot, v.forces, v.free_acceleration)
    if contact:
        _solve(model, pivot, v.normal_row, v.normal_response)
        _solve(model, pivot, v.tangential_row, v.tangential_response)
    return True


@jitable
def add_beam_tangent(
    model: BeamModel, t: float, q: Array, velocity: float, position: float, target: Array
) -> None:
    """Add velocity * damping matrix + position * stiffness matrix to `target` (n + 1, n + 1)."""
    n = model.vectors.shape[1]
    for i in range(n):
        for j in range(n):
            damping, stiffness = model.matrices[DAMPING, i, j], model.matrices[STIFFNESS, i, j]
            target[i + 1, j + 1] += velocity * damping + position * stiffness


@jitable
def beam_damping(model: BeamModel, t: float, q: Array, qd: Array, w: Workspace) -> float:
    """Power (W) of the damping matrix at the velocities q'."""
    rates, product = qd[1:], w.vectors.scratch_b[1:]
    multiply(model.matrices[DAMPING], rates, product)
    return float(dot(product, rates))


class BeamModel(_BeamData, DenseAlgebra):
    """The beam in its floating frame as a :class:`~oblique_impact.kernels.system.System`."""

    __slots__ = ()
    described = "a beam in modes"

    evaluate = evaluate_beam
    solve_mass = solve_beam_mass
    add_tangent = add_beam_tangent
    damping_at = beam_damping
    take_state = take_beam_state
    touch = touch_beam
    measure = measure_beam
    set_massless = set_massless_beam

    def new_workspace(self) -> Workspace:
        """Allocate the arrays of a run; the elastic part of the mass matrix is there once and for all."""
        work = new_workspace(self.vectors.shape[1] + 1)
        work.mass[1:, 1:] = self.matrices[ELASTIC_MASS]
        return work


class FullBeamModel(BeamModel):
    """The beam with exact kinetic energy, by quadrature: a class of its own, so that others compile without it."""

    __slots__ = ()
    described = "a beam in modes with full kinetics"

    evaluate = evaluate_full_beam
    solve_mass = DenseAlgebra.solve_mass
