"""The beam in its floating frame: mass matrix, forces, contact rows, energies.

Generalized coordinates q = [theta, B].  Kinetic energy in three orders (`zeroth-order` is the
first-order model with the foreshortening operators C, D and H set to zero); equations of motion
after Yuan et al. 2016, Eq. 10, with a hub of radius r and inertia J_h, and a driven root.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba.core import types
from numba.extending import overload

from oblique_impact.kernels import system as protocol
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.pointers import call_1
from oblique_impact.kernels.system import (
    ACCELERATION,
    DAMPING_POWER,
    DRIVEN_FORCE,
    DRIVEN_ROW,
    FORCES,
    GAP,
    GAP_BIAS,
    GAP_RATE,
    MASS,
    NORMAL_ROW,
    OWN_A,
    OWN_B,
    SLIP,
    SLIP_BIAS,
    SLIP_RATE,
    TANGENT_ROW,
    Array,
    Work,
)

PIN, HUB, DRIVEN = 0, 1, 2
HOLD, CONSTANT_SPEED, SPIN_UP = 0, 1, 2


# BeamModel.matrices: elastic mass with the hub's share, M1 - C of the beam alone, stiffness, damping,
# gravity stiffness D, H at the contact point
ELASTIC_MASS, SPIN_STIFFNESS, STIFFNESS, DAMPING, GRAVITY_STIFFNESS, CONTACT_SHORTENING = range(6)
# BeamModel.vectors: S with the hub's share, P, slope of the root, shape functions at the contact point
COUPLING, LOAD, ROOT_SLOPE, CONTACT_SHAPE = range(4)


class BeamModel(NamedTuple):
    """A discretized beam with root, gravity, damping and slope, packed for the compiled kernels.

    Few arrays with named rows, because compiled code hands every array on by value.
    """

    matrices: Array  # (6, n, n)
    vectors: Array  # (4, n)
    full: bool  # exact kinetic energy by quadrature
    quad_points: Array  # (2, nq) r + x (m) and mass (kg)         (full only, else empty)
    quad_shapes: Array  # (nq, n)
    quad_shortening: Array  # (nq, n, n) H(x)
    inertia: float  # J and the hub's (kg m^2)
    static_moment: float  # Sm (kg m)
    gravity: float
    root: int
    hub_inertia: float
    torque: float
    profile: int  # HOLD, CONSTANT_SPEED, SPIN_UP, or the address of the acceleration of a motion of one's own
    spin_rate: float
    spin_up_time: float
    contact_radius: float  # r + x_F (m)
    slope_angle: float
    normal_offset: float  # c_n (m)
    tangential_offset: float  # c_t (m)


@jitable
def multiply(matrices: Array, which: int, vector: Array, vectors: Array, row: int) -> None:
    """matrices[which] times `vector` (n,) into vectors[row, 1:]."""
    n = vector.shape[0]
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += matrices[which, i, j] * vector[j]
        vectors[row, i + 1] = total


@jitable
def contract(vectors: Array, row: int, vector: Array) -> float:
    """vectors[row, 1:] times `vector` (n,)."""
    total = 0.0
    for i in range(vector.shape[0]):
        total += vectors[row, i + 1] * vector[i]
    return total


@jitable
def project(vectors: Array, row: int, vector: Array) -> float:
    """vectors[row] times `vector` (n,)."""
    total = 0.0
    for i in range(vector.shape[0]):
        total += vectors[row, i] * vector[i]
    return total


@jitable
def drive(model: BeamModel, t: float) -> tuple[float, float, float]:
    """Angle since the start, speed and acceleration of a built-in base motion (rad, rad/s, rad/s^2).

    Spin-up: speed (w/T) (t - T/(2 pi) sin(2 pi t/T)) up to T (Simo and Vu-Quoc 1986), then w.
    """
    w, period = model.spin_rate, model.spin_up_time
    if model.profile == HOLD:
        return 0.0, 0.0, 0.0
    if model.profile == CONSTANT_SPEED:
        return w * t, w, 0.0
    if t >= period:
        return w * (t - 0.5 * period), w, 0.0
    phase = 2.0 * np.pi * t / period
    lag = period / (2.0 * np.pi)
    angle = w / period * (0.5 * t * t + lag * lag * (np.cos(phase) - 1.0))
    return angle, w / period * (t - lag * np.sin(phase)), w / period * (1.0 - np.cos(phase))


@jitable
def drive_acceleration(model: BeamModel, t: float) -> float:
    """Acceleration (rad/s^2) of a driven root."""
    if model.profile > SPIN_UP:
        return float(call_1(model.profile, t))
    return drive(model, t)[2]


@jitable
def _apply_forces(model: BeamModel, theta: float, B: Array, Bd: Array, work: Work) -> None:
    """Add gravity with its geometric stiffness, elasticity, damping and the hub's torque to the forces."""
    v, g, c, s = work.vectors, model.gravity, np.cos(theta), np.sin(theta)
    multiply(model.matrices, GRAVITY_STIFFNESS, B, v, OWN_A)
    moment = c * (model.static_moment - 0.5 * contract(v, OWN_A, B)) - s * project(model.vectors, LOAD, B)
    v[FORCES, 0] += model.torque - g * moment
    for i in range(B.shape[0]):
        v[FORCES, i + 1] -= g * (c * model.vectors[LOAD, i] - s * v[OWN_A, i + 1])
        v[FORCES, i + 1] += model.torque * model.vectors[ROOT_SLOPE, i]
    multiply(model.matrices, STIFFNESS, B, v, OWN_A)
    multiply(model.matrices, DAMPING, Bd, v, OWN_B)
    for i in range(B.shape[0]):
        v[FORCES, i + 1] -= v[OWN_A, i + 1] + v[OWN_B, i + 1]
    work.scalars[DAMPING_POWER] = contract(v, OWN_B, Bd)


@jitable
def _first_order(model: BeamModel, q: Array, qd: Array, work: Work) -> None:
    """Kinetic energy to second order in B: mass matrix and inertia forces."""
    B, Bd, spin = q[1:], qd[1:], qd[0]
    M, v = work.matrices, work.vectors
    multiply(model.matrices, SPIN_STIFFNESS, B, v, OWN_A)
    M[MASS, 0, 0] = model.inertia + contract(v, OWN_A, B)
    v[FORCES, 0] = -2.0 * spin * contract(v, OWN_A, Bd)
    for i in range(B.shape[0]):
        M[MASS, 0, i + 1] = model.vectors[COUPLING, i]
        M[MASS, i + 1, 0] = model.vectors[COUPLING, i]
        v[FORCES, i + 1] = spin * spin * v[OWN_A, i + 1]
        for j in range(B.shape[0]):
            M[MASS, i + 1, j + 1] = model.matrices[ELASTIC_MASS, i, j]


@jitable
def _full(model: BeamModel, q: Array, qd: Array, work: Work) -> None:
    """Exact kinetic energy by quadrature: a Gram matrix, positive semidefinite whatever B is."""
    B, Bd, spin = q[1:], qd[1:], qd[0]
    n = B.shape[0]
    M, v = work.matrices[MASS], work.vectors
    for i in range(n + 1):
        v[FORCES, i] = 0.0
        for j in range(i + 1):
            M[i, j] = 0.0
    for k in range(model.quad_shapes.shape[0]):
        mass = model.quad_points[1, k]
        uy, uy_rate, shortening, shortening_rate, bias = 0.0, 0.0, 0.0, 0.0, 0.0
        for i in range(n):
            HB, HBd = 0.0, 0.0
            for j in range(n):
                HB += model.quad_shortening[k, i, j] * B[j]
                HBd += model.quad_shortening[k, i, j] * Bd[j]
            shape = model.quad_shapes[k, i]
            uy += shape * B[i]
            uy_rate += shape * Bd[i]
            shortening -= 0.5 * B[i] * HB
            shortening_rate -= Bd[i] * HB
            bias -= Bd[i] * HBd
            v[OWN_A, i + 1] = -HB
            v[OWN_B, i + 1] = shape
        arm = model.quad_points[0, k] + shortening
        v[OWN_A, 0], v[OWN_B, 0] = -uy, arm
        axial = mass * (bias - 2.0 * spin * uy_rate - spin * spin * arm)
        transverse = mass * (2.0 * spin * shortening_rate - spin * spin * uy)
        for i in range(n + 1):
            v[FORCES, i] -= v[OWN_A, i] * axial + v[OWN_B, i] * transverse
            for j in range(i + 1):
                M[i, j] += mass * (v[OWN_A, i] * v[OWN_A, j] + v[OWN_B, i] * v[OWN_B, j])
    v[OWN_A, 0] = 1.0
    for i in range(n):
        v[OWN_A, i + 1] = model.vectors[ROOT_SLOPE, i]
    for i in range(n + 1):
        for j in range(i + 1):
            M[i, j] += model.hub_inertia * v[OWN_A, i] * v[OWN_A, j]
            M[j, i] = M[i, j]


@jitable
def _contact(model: BeamModel, q: Array, qd: Array, work: Work) -> None:
    """Gap, slip, their rows and biases at the contact point (paper Eqs. 22-24 and 50)."""
    B, Bd, spin = q[1:], qd[1:], qd[0]
    v, k = work.vectors, work.scalars
    multiply(model.matrices, CONTACT_SHORTENING, B, v, OWN_A)
    multiply(model.matrices, CONTACT_SHORTENING, Bd, v, OWN_B)
    x = model.contact_radius - 0.5 * contract(v, OWN_A, B)
    y = project(model.vectors, CONTACT_SHAPE, B)
    x_rate, y_rate = -contract(v, OWN_A, Bd), project(model.vectors, CONTACT_SHAPE, Bd)
    bias = contract(v, OWN_B, Bd)
    angle = q[0] - model.slope_angle
    c, s = np.cos(angle), np.sin(angle)
    k[GAP] = x * s + y * c - model.normal_offset
    k[SLIP] = x * c - y * s - model.tangential_offset
    v[NORMAL_ROW, 0] = x * c - y * s
    v[TANGENT_ROW, 0] = -x * s - y * c
    for i in range(B.shape[0]):
        v[NORMAL_ROW, i + 1] = -s * v[OWN_A, i + 1] + c * model.vectors[CONTACT_SHAPE, i]
        v[TANGENT_ROW, i + 1] = -c * v[OWN_A, i + 1] - s * model.vectors[CONTACT_SHAPE, i]
    k[GAP_RATE] = project(v, NORMAL_ROW, qd)
    k[SLIP_RATE] = project(v, TANGENT_ROW, qd)
    square = spin * spin
    k[GAP_BIAS] = 2.0 * spin * (c * x_rate - s * y_rate) - square * (s * x + c * y) - s * bias
    k[SLIP_BIAS] = -2.0 * spin * (s * x_rate + c * y_rate) - square * (c * x - s * y) - c * bias


@jitable
def _prescribe(model: BeamModel, t: float, work: Work) -> None:
    """Replace the row of theta by the prescribed acceleration and keep it for the driver's power."""
    acceleration = drive_acceleration(model, t)
    M, v, k = work.matrices, work.vectors, work.scalars
    k[DRIVEN_FORCE] = v[FORCES, 0]
    v[FORCES, 0] = acceleration
    v[DRIVEN_ROW, 0] = M[MASS, 0, 0]
    M[MASS, 0, 0] = 1.0
    for i in range(1, v.shape[1]):
        v[DRIVEN_ROW, i] = M[MASS, 0, i]
        v[FORCES, i] -= M[MASS, i, 0] * acceleration
        M[MASS, 0, i] = 0.0
        M[MASS, i, 0] = 0.0
    k[GAP_BIAS] += v[NORMAL_ROW, 0] * acceleration
    k[SLIP_BIAS] += v[TANGENT_ROW, 0] * acceleration
    v[NORMAL_ROW, 0] = 0.0
    v[TANGENT_ROW, 0] = 0.0


@jitable
def evaluate_beam(model: BeamModel, t: float, q: Array, qd: Array, work: Work) -> None:
    """Fill `work` with mass matrix, forces and contact rows of the beam at (t, q, q')."""
    if model.full:
        _full(model, q, qd, work)
    else:
        _first_order(model, q, qd, work)
    _apply_forces(model, q[0], q[1:], qd[1:], work)
    _contact(model, q, qd, work)
    if model.root == DRIVEN:
        _prescribe(model, t, work)


@jitable
def supplied_power_beam(model: BeamModel, t: float, q: Array, qd: Array, work: Work) -> float:
    """Power (W) of the hub torque, or of the driver of a prescribed root without its contact part."""
    if model.root == HUB:
        return float(model.torque * (qd[0] + project(model.vectors, ROOT_SLOPE, qd[1:])))
    if model.root == DRIVEN:
        torque = -work.scalars[DRIVEN_FORCE]
        for i in range(qd.shape[0]):
            torque += work.vectors[DRIVEN_ROW, i] * work.vectors[ACCELERATION, i]
        return float(torque * qd[0])
    return 0.0


@jitable
def add_tangent_beam(
    model: BeamModel, t: float, q: Array, velocity: float, position: float, work: Work, slot: int
) -> None:
    """Add velocity * damping matrix + position * stiffness matrix to a slot of the matrices."""
    n = model.vectors.shape[1]
    for i in range(n):
        for j in range(n):
            work.matrices[slot, i + 1, j + 1] += (
                velocity * model.matrices[DAMPING, i, j] + position * model.matrices[STIFFNESS, i, j]
            )


@jitable
def damping_power_beam(model: BeamModel, t: float, q: Array, qd: Array, work: Work) -> float:
    """Power (W) of the damping matrix at the velocities q'."""
    multiply(model.matrices, DAMPING, qd[1:], work.vectors, OWN_B)
    return float(contract(work.vectors, OWN_B, qd[1:]))


def _is_beam(system: Any) -> bool:
    return isinstance(system, types.NamedTuple) and system.instance_class is BeamModel


@overload(protocol.evaluate, strict=False)
def _compiled_evaluate(system: Any, t: Any, q: Any, qd: Any, work: Any) -> Any:
    return evaluate_beam if _is_beam(system) else None


@overload(protocol.supplied_power, strict=False)
def _compiled_supplied_power(system: Any, t: Any, q: Any, qd: Any, work: Any) -> Any:
    return supplied_power_beam if _is_beam(system) else None


@overload(protocol.add_tangent, strict=False)
def _compiled_add_tangent(system: Any, t: Any, q: Any, velocity: Any, position: Any, work: Any, slot: Any) -> Any:
    return add_tangent_beam if _is_beam(system) else None


@overload(protocol.damping_power, strict=False)
def _compiled_damping_power(system: Any, t: Any, q: Any, qd: Any, work: Any) -> Any:
    return damping_power_beam if _is_beam(system) else None
