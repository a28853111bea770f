"""The beam in its floating frame: mass matrix, forces, contact rows, energies.

Generalized coordinates q = [theta, B].  Kinetic energy in three orders (`zeroth-order` is the
first-order model with the foreshortening operators C, D and H set to zero); equations of motion
after Yuan et al. 2016, Eq. 10, with a hub of radius r and inertia J_h, and a driven root.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.beam.axis import Met, Places, SectionMotion, meet, point_of
from oblique_impact.beam.base_motion import drive_acceleration
from oblique_impact.beam.point_forces import PointForces, force_in_frame
from oblique_impact.beam.shaking import (
    Shaking,
    base_acceleration,
    direction_in_frame,
    stands_still,
    weight_in_frame,
)
from oblique_impact.contact.sides_and_pegs import (
    Directions,
    Heading,
    PointMotion,
    heading_of,
    meet_side,
    take_rows,
)
from oblique_impact.contact.state import DIRECTION, FREE, RESPONSE, Candidate, Contacts
from oblique_impact.kernels.contacts import ContactArrays
from oblique_impact.kernels.dense import DenseAlgebra, multiply
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.laws import Law
from oblique_impact.kernels.workspace import (
    ACROSS,
    ACROSS_TURNED,
    ALONG,
    ALONG_TURNED,
    DAMPING_PRODUCT,
    FORCES,
    FREE_ACCELERATION,
    GRAVITY_PRODUCT,
    MASS,
    SCRATCH_A,
    SCRATCH_B,
    SHORTENING_PRODUCT,
    SPIN_PRODUCT,
    STIFFNESS_PRODUCT,
    SUPPLY,
    Array,
    Evaluation,
    Workspace,
    dot,
    new_workspace,
)

PIN, HUB, DRIVEN = 0, 1, 2

# BeamModel.matrices: elastic mass with what turns with sections, M1 - C of the beam alone, stiffness, damping,
# gravity stiffness D, inverse of the elastic mass matrix
ELASTIC_MASS, SPIN_STIFFNESS, STIFFNESS, DAMPING, GRAVITY_STIFFNESS, MASS_INVERSE = range(6)
# BeamModel.vectors: S with what turns with sections, P, slope of the root, elastic accelerations by a unit one of
# theta (of a driven root 0: theta is prescribed)
COUPLING, LOAD, ROOT_SLOPE, FOLLOWING = range(4)

#: what is one number of a beam with its root
BEAM_NUMBERS = np.dtype(
    [
        ("root", np.int64),
        ("inertia", float),  # J with what turns with sections, as the hub (kg m^2)
        ("static_moment", float),  # Sm (kg m)
        ("gravity", float),
        ("hub_radius", float),
        ("torque", float),
        ("spin_rate", float),  # rad/s, at the end of the spin-up of a driven root
        ("spin_up_time", float),
    ],
    align=True,
)


class Quadrature(NamedTuple):
    """Points of the beam for the exact kinetic energy."""

    points: Array  # (2, nq) r + x (m) and mass (kg)
    shapes: Array  # (nq, n)
    shortening: Array  # (nq, n, n) H(x)
    inertias: Array  # (k,) kg m^2, that turn with sections: of the hub and of point masses
    turning: Array  # (k, n + 1) their rates of turning by theta' and B'


class GroundSpring(NamedTuple):
    """Spring and dashpot between a hub and the ground, in all coordinates [theta, B].

    The hub turns by theta + Phi'(0).B.  The damping matrix holds damping by mode too: on a spring the swing is a
    mode like the others.
    """

    stiffness: Array  # (n + 1, n + 1); (0, 0) of a beam without
    damping: Array  # (n + 1, n + 1)
    angle: float  # rad, at which the spring is unstrained


NO_GROUND = GroundSpring(np.zeros((0, 0)), np.zeros((0, 0)), 0.0)


class Loads(NamedTuple):
    """Forces on the beam and the places where they act."""

    forces: PointForces
    places: Places


class _BeamData(NamedTuple):
    """A discretized beam with root, gravity, damping and places of contact; constant during a run."""

    numbers: Any  # a record of `BEAM_NUMBERS`
    matrices: Array  # (6, n, n)
    vectors: Array  # (4, n)
    places: Places
    shaking: Shaking  # of the base
    loads: Loads  # forces on the beam
    ground: GroundSpring
    drive: Law | None = None  # acceleration (rad/s^2) of a driven root over time, in the place of a spin-up
    quadrature: Quadrature | None = None  # of exact kinetic energy alone


@inlined
def _contract(v: Array, x: Array) -> float:
    """v[1:] times x (n,)."""
    total = 0.0
    for i in range(x.shape[0]):
        total += v[i + 1] * x[i]
    return total


@inlined
def _take_products(model: BeamModel, B: Array, Bd: Array, w: Workspace) -> None:
    """Put the products of the model's matrices into their rows.

    All in one loop: each of these short sums by itself would wait for its last addition.
    """
    matrices, v = model.matrices, w.vectors
    for i in range(B.shape[0]):
        a, b, c, e = 0.0, 0.0, 0.0, 0.0
        for j in range(B.shape[0]):
            x, rate = B[j], Bd[j]
            a += matrices[SPIN_STIFFNESS, i, j] * x
            b += matrices[GRAVITY_STIFFNESS, i, j] * x
            c += matrices[STIFFNESS, i, j] * x
            e += matrices[DAMPING, i, j] * rate
        v[SPIN_PRODUCT, i + 1], v[GRAVITY_PRODUCT, i + 1] = a, b
        v[STIFFNESS_PRODUCT, i + 1], v[DAMPING_PRODUCT, i + 1] = c, e


@inlined
def _apply_forces(model: BeamModel, t: float, theta: float, B: Array, Bd: Array, w: Workspace) -> float:
    """Add gravity with its geometric stiffness, elasticity, damping, hub torque; the power (W) of damping."""
    v = w.vectors
    numbers = model.numbers
    g, c, s = weight_in_frame(model.shaking, numbers.gravity, t, theta)
    forces, heavy, stiff, damped = v[FORCES], v[GRAVITY_PRODUCT], v[STIFFNESS_PRODUCT], v[DAMPING_PRODUCT]
    moment = c * (numbers.static_moment - 0.5 * _contract(heavy, B)) - s * dot(model.vectors[LOAD], B)
    forces[0] += numbers.torque - g * moment
    for i in range(B.shape[0]):
        weight = g * (c * model.vectors[LOAD, i] - s * heavy[i + 1])
        forces[i + 1] += numbers.torque * model.vectors[ROOT_SLOPE, i] - weight - (stiff[i + 1] + damped[i + 1])
    return _contract(damped, Bd)


@jitable
def _apply_ground(ground: GroundSpring, q: Array, qd: Array, v: Array) -> float:
    """Add spring and dashpot of a hub; the power (W) of the dashpot."""
    if ground.stiffness.shape[0] == 0:
        return 0.0
    forces, power = v[FORCES], 0.0
    for i in range(q.shape[0]):
        spring, drag = -ground.stiffness[i, 0] * ground.angle, 0.0
        for j in range(q.shape[0]):
            spring += ground.stiffness[i, j] * q[j]
            drag += ground.damping[i, j] * qd[j]
        forces[i] -= spring + drag
        power += drag * qd[i]
    return power


@jitable
def _shaking_power(model: BeamModel, t: float, q: Array, qd: Array, v: Array) -> float:
    """Power (W) of the inertia force on the beam by a shaken base."""
    shaking = model.shaking
    if stands_still(shaking):
        return 0.0
    B, Bd, heavy = q[1:], qd[1:], v[GRAVITY_PRODUCT]
    along, across = direction_in_frame(shaking, np.cos(q[0]), np.sin(q[0]))
    # first moments of mass along x and y of the frame, and their rates in it
    mx, my = model.numbers.static_moment - 0.5 * _contract(heavy, B), dot(model.vectors[LOAD], B)
    mx_rate, my_rate = -_contract(heavy, Bd), dot(model.vectors[LOAD], Bd)
    momentum: float = along * (mx_rate - qd[0] * my) + across * (my_rate + qd[0] * mx)
    return -base_acceleration(shaking, t) * momentum


@inlined
def _first_order(model: BeamModel, q: Array, qd: Array, w: Workspace) -> None:
    """Kinetic energy to second order in B: inertia forces, the rows of the mass matrix that are not constant."""
    B, Bd, spin = q[1:], qd[1:], qd[0]
    M, v = w.matrices[MASS], w.vectors
    forces, product = v[FORCES], v[SPIN_PRODUCT]
    M[0, 0] = model.numbers.inertia + _contract(product, B)
    forces[0] = -2.0 * spin * _contract(product, Bd)
    for i in range(B.shape[0]):
        M[0, i + 1] = model.vectors[COUPLING, i]
        M[i + 1, 0] = model.vectors[COUPLING, i]
        forces[i + 1] = spin * spin * product[i + 1]


@jitable
def _full(model: BeamModel, quadrature: Any, q: Array, qd: Array, w: Workspace) -> None:
    """Exact kinetic energy by quadrature: a Gram matrix, positive semidefinite whatever B is."""
    B, Bd, spin = q[1:], qd[1:], qd[0]
    n = B.shape[0]
    M, v = w.matrices[MASS], w.vectors
    forces, axial_row, transverse_row = v[FORCES], v[SCRATCH_A], v[SCRATCH_B]
    points, shapes, lengthwise = quadrature.points, quadrature.shapes, quadrature.shortening
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
    inertias, turning = quadrature.inertias, quadrature.turning
    for i in range(n + 1):
        for j in range(i + 1):
            for k in range(inertias.shape[0]):
                M[i, j] += inertias[k] * turning[k, i] * turning[k, j]
            M[j, i] = M[i, j]


@inlined
def _motion_of(shape: Array, slope: Array, HB: Array, bending: float, B: Array, Bd: Array) -> SectionMotion:
    """Motion of a section with these shape functions and slopes, H B behind the entry of theta and B'^T H B'."""
    shortened, shortened_rate, u_y, u_y_rate, phi, phi_rate = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(B.shape[0]):
        shortened += HB[i + 1] * B[i]
        shortened_rate += HB[i + 1] * Bd[i]
        u_y += shape[i] * B[i]
        u_y_rate += shape[i] * Bd[i]
        phi += slope[i] * B[i]
        phi_rate += slope[i] * Bd[i]
    return SectionMotion(-0.5 * shortened, u_y, phi, -shortened_rate, u_y_rate, phi_rate, -bending)


@inlined
def _take_point_rows(
    place: Any, shape: Array, slope: Array, HB: Array, phi: float, point: PointMotion, v: Array
) -> None:
    """Rows (2, n + 1) of a point of the beam in the frame, see `oblique_impact.beam.axis.point_of`."""
    e, kept, leaning = place.fibre, place.shortening, place.turning * phi
    v[ALONG, 0], v[ACROSS, 0] = -point.y, point.x
    for i in range(shape.shape[0]):
        v[ALONG, i + 1] = -(kept * HB[i + 1] + e * slope[i])
        v[ACROSS, i + 1] = shape[i] - leaning * slope[i]


@inlined
def _point_in_place(
    model: BeamModel, place: Any, table: Array, q: Array, qd: Array, v: Array
) -> tuple[PointMotion, float]:
    """Motion of a point of the beam, whose shape functions are in a table, and the slope there; takes its rows."""
    B, Bd = q[1:], qd[1:]
    HB, bending, n = v[SHORTENING_PRODUCT], 0.0, q.shape[0] - 1
    for j in range(n):
        before, rate = 0.0, 0.0
        for k in range(n):
            before += table[j, k] * B[k]
            rate += table[j, k] * Bd[k]
        HB[j + 1] = before
        bending += Bd[j] * rate
    shape, slope = table[n], table[n + 1]
    motion = _motion_of(shape, slope, HB, bending, B, Bd)
    point = point_of(place, model.numbers.hub_radius + place.x, motion, qd[0])
    _take_point_rows(place, shape, slope, HB, motion.slope, point, v)
    return point, motion.slope


@inlined
def _meet_in_place(
    model: BeamModel, i: int, q: Array, qd: Array, heading: Heading, v: Array, c: Candidate
) -> Directions:
    """Meet a side with a point of the beam."""
    place = model.places.each[i]
    point, _ = _point_in_place(model, place, model.places.tables[i], q, qd, v)
    return meet_side(place, heading, point, c)


@jitable
def _apply_loads(model: BeamModel, t: float, q: Array, qd: Array, v: Array) -> float:
    """Add the forces on the beam; their power (W)."""
    loads, forces, power = model.loads, v[FORCES], 0.0
    places = loads.places
    for k in range(len(places.each)):
        point, slope = _point_in_place(model, places.each[k], places.tables[k], q, qd, v)
        along, across = force_in_frame(loads.forces, k, t, q[0], slope)
        for i in range(q.shape[0]):
            forces[i] += along * v[ALONG, i] + across * v[ACROSS, i]
        power += along * point.x_rate + across * point.y_rate
    return power


@inlined
def take_moving_rows(shapes: Any, place: Any, met: Met, B: Array, v: Array) -> None:
    """Rows (4, n + 1) of a point on the axis and of the derivatives along it, where it has met an obstacle."""
    phi, kept, shape, slope = met.axis.slope, place.shortening, v[SCRATCH_A, 1:], v[SCRATCH_B, 1:]
    shapes.take_shapes(met.axis, B, v)
    _take_point_rows(place, shape, slope, v[SHORTENING_PRODUCT], phi, met.point, v)
    v[ALONG_TURNED, 0], v[ACROSS_TURNED, 0] = -phi, 1.0 - 0.5 * kept * phi * phi
    for j in range(B.shape[0]):
        v[ALONG_TURNED, j + 1], v[ACROSS_TURNED, j + 1] = -kept * phi * slope[j], slope[j]


@jitable
def _meet_moving(
    shapes: Any, model: BeamModel, i: int, q: Array, qd: Array, v: Array, rows: bool, c: Candidate
) -> Directions:
    """Meet a peg, at a place that moves along the beam; the compiler drops this of a beam without pegs."""
    if shapes is None:
        return Directions(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    place = model.places.each[i]
    met = meet(shapes, model.numbers.hub_radius, place, q, qd, heading_of(q[0]), c)
    if rows:
        take_moving_rows(shapes, place, met, q[1:], v)
    return met.directions


@jitable
def touch_beam(
    model: BeamModel,
    i: int,
    t: float,
    q: Array,
    qd: Array,
    w: Workspace,
    c: Candidate,
    rows: Array,
) -> None:
    """Gap, slip, their rates and biases of one place of contact, and its rows."""
    v = w.vectors
    if model.places.each[i].on_side:
        directions = _meet_in_place(model, i, q, qd, heading_of(q[0]), v, c)
        take_angle(c, q[0], qd[0], rows)
    else:
        directions = _meet_moving(model.places.shapes, model, i, q, qd, v, True, c)
    take_rows(directions, v, rows)
    if model.numbers.root == DRIVEN:
        take_prescribed(_driven(model, t), model.places.each[i].on_side, c, rows)


@inlined
def take_prescribed(acceleration: float, on_side: bool, c: Candidate, rows: Array) -> None:
    """Take the first coordinate, whose acceleration (rad/s^2) is prescribed, from the rows to the biases."""
    c.gap_bias += rows[0, 0] * acceleration
    c.slip_bias += rows[1, 0] * acceleration
    c.shift_bias = acceleration if on_side else 0.0
    for k in range(rows.shape[0]):
        rows[k, 0] = 0.0


@inlined
def take_angle(c: Candidate, theta: float, spin: float, rows: Array) -> None:
    """Take the angle (rad) of the frame and its row, if it is asked for, as the shift of a contact on a side."""
    c.shift, c.shift_rate = theta, spin
    if rows.shape[0] > 2:
        for j in range(rows.shape[1]):
            rows[2, j] = 0.0
        rows[2, 0] = 1.0


@jitable
def take_beam_state(model: BeamModel, t: float, q: Array, qd: Array, w: Workspace) -> None:
    """Do nothing: each place is evaluated from the coordinates."""


@jitable
def measure_beam(model: BeamModel, t: float, q: Array, qd: Array, w: Workspace, contacts: Contacts) -> None:
    """Gap, slip and gap rate of every place of contact."""
    heading = heading_of(q[0])
    for i in range(len(contacts.each)):
        if model.places.each[i].on_side:
            c = contacts.each[i]
            _meet_in_place(model, i, q, qd, heading, w.vectors, c)
            c.shift, c.shift_rate = q[0], qd[0]
        else:
            _meet_moving(model.places.shapes, model, i, q, qd, w.vectors, False, contacts.each[i])


@jitable
def set_massless_beam(model: BeamModel, mean: Array, v: Array) -> None:
    """Do nothing: all coordinates have inertia."""


@inlined
def _driven(model: BeamModel, t: float) -> float:
    """Angular acceleration (rad/s^2) of a driven root at t (s)."""
    return drive_acceleration(model.drive, model.numbers.spin_rate, model.numbers.spin_up_time, t)


@jitable
def _prescribe(model: BeamModel, acceleration: float, spin: float, w: Workspace) -> float:
    """Replace the row of theta by the prescribed acceleration; power (W) of the driver at q'' = 0.

    The rest of its power, supply . q'', and that of the contact force follow from the rows that are replaced.
    """
    M, v = w.matrices[MASS], w.vectors
    forces, supply = v[FORCES], v[SUPPLY]
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
    """Fill mass matrix and forces of the beam at (t, q, q')."""
    _take_products(model, q[1:], qd[1:], w)
    _first_order(model, q, qd, w)
    return _evaluate(model, t, q, qd, w)


@jitable
def evaluate_full_beam(model: BeamModel, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
    """Fill mass matrix and forces of the beam with exact kinetic energy at (t, q, q')."""
    _take_products(model, q[1:], qd[1:], w)
    _full(model, model.quadrature, q, qd, w)
    return _evaluate(model, t, q, qd, w)


@inlined
def _evaluate(model: BeamModel, t: float, q: Array, qd: Array, w: Workspace) -> Evaluation:
    """Add what does not depend on the order of the kinetic energy."""
    v, numbers = w.vectors, model.numbers
    damping = _apply_forces(model, t, q[0], q[1:], qd[1:], w) + _apply_ground(model.ground, q, qd, v)
    supplied = _shaking_power(model, t, q, qd, v)
    supplied += _apply_loads(model, t, q, qd, v)
    if numbers.root == HUB:
        supplied += numbers.torque * (qd[0] + dot(model.vectors[ROOT_SLOPE], qd[1:]))
    if numbers.root == DRIVEN:
        supplied += _prescribe(model, _driven(model, t), qd[0], w)
    return Evaluation(damping, supplied, 0.0)


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
def solve_beam_mass(
    model: BeamModel, rank_one: float, w: Workspace, contacts: ContactArrays, closed: bool
) -> bool:
    """Acceleration without contact force and, with `closed`, M^-1 D^T of the closed contacts.

    False if M is not positive definite.
    """
    v, M, following, rows = w.vectors, w.matrices[MASS], model.vectors[FOLLOWING], contacts.rows
    pivot = M[0, 0]
    for i in range(following.shape[0]):
        pivot += following[i] * M[0, i + 1]
    if not pivot > 0.0:
        return False
    _solve(model, pivot, v[FORCES], v[FREE_ACCELERATION])
    if closed:
        for i in range(len(contacts.each)):
            if contacts.each[i].state != FREE:
                for side in range(2):
                    _solve(model, pivot, rows[DIRECTION, i, side], rows[RESPONSE, i, side])
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
    _add_ground(model.ground, velocity, position, target)


@jitable
def _add_ground(ground: GroundSpring, velocity: float, position: float, target: Array) -> None:
    """Add velocity * damping matrix + position * stiffness matrix of spring and dashpot of a hub."""
    for i in range(ground.stiffness.shape[0]):
        for j in range(ground.stiffness.shape[1]):
            target[i, j] += velocity * ground.damping[i, j] + position * ground.stiffness[i, j]


@jitable
def beam_damping(model: BeamModel, t: float, q: Array, qd: Array, w: Workspace) -> float:
    """Power (W) of the damping matrix at the velocities q'."""
    rates, product = qd[1:], w.vectors[SCRATCH_B, 1:]
    multiply(model.matrices[DAMPING], rates, product)
    return float(dot(product, rates)) + _ground_damping(model.ground, qd, w.vectors[SCRATCH_B])


@jitable
def _ground_damping(ground: GroundSpring, qd: Array, product: Array) -> float:
    """Power (W) of the dashpot of a hub."""
    if ground.damping.shape[0] == 0:
        return 0.0
    multiply(ground.damping, qd, product)
    return float(dot(product, qd))


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
        work.matrices[MASS, 1:, 1:] = self.matrices[ELASTIC_MASS]
        return work


class FullBeamModel(BeamModel):
    """The beam with exact kinetic energy, by quadrature: a class of its own, so that others compile without it."""

    __slots__ = ()
    described = "a beam in modes with full kinetics"

    evaluate = evaluate_full_beam
    solve_mass = DenseAlgebra.solve_mass
