"""The full nodal beam in its total transverse coordinates: banded mass, forces, contact rows.

W = x theta + B are the nodal deflections and slopes seen from the root's inertial axis turned to nothing:
rigid rotation and elastic deflection in one vector, with W_0 = 0 as the only boundary condition.  In the
mean-axis frame, S.B = 0, they split again by theta = S.W/J, B = W - x theta.  First-order kinetics reads

    (M1 + kappa S S^T) W'' + Cd W' + K W = f + d_n lambda_n + d_tau lambda_tau,   kappa = B^T N B / J^2
    f = f_B + S (Q_theta - x.f_B)/J,     f_B = theta'^2 N W - g (cos theta P - sin theta D B)
    Q_theta = -2 theta' B^T N B' - g (Sm cos theta - 1/2 cos theta B^T D B - sin theta P.B)
    d = D_B + S (D_theta - x.D_B)/J

with N = M1 - C, because N x = 0 and K x = 0.  Everything is banded but for rank one, so a step costs O(n).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba.core import types
from numba.extending import overload

from oblique_impact.kernels import dense, implicit
from oblique_impact.kernels import system as protocol
from oblique_impact.kernels.banded import HALF_BANDWIDTH, band_multiply, factor_band, solve_band
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.system import (
    CHOLESKY,
    DAMPING_POWER,
    EFFECTIVE,
    EFFECTIVE_SLOTS,
    FORCES,
    FREE_ACCELERATION,
    GAP,
    GAP_BIAS,
    GAP_RATE,
    INCREMENT,
    NORMAL_RESPONSE,
    NORMAL_ROW,
    OWN_A,
    OWN_B,
    OWN_C,
    RESIDUAL,
    SCALARS,
    SLIP,
    SLIP_BIAS,
    SLIP_RATE,
    TANGENT_RESPONSE,
    TANGENT_ROW,
    VECTORS,
    Array,
    Work,
)

# NodalModel.bands: mass with the hub's, stiffness, N = M1 - C, gravity stiffness D, H at the contact point
MASS_BAND, STIFFNESS_BAND, SPIN_BAND, GRAVITY_BAND, SHORTENING_BAND = range(5)
# NodalModel.vectors: S, P, the rigid rotation x, D x, H x
COUPLING, LOAD, RIGID, GRAVITY_RIGID, SHORTENING_RIGID = range(5)

# Work of a nodal model. Matrices (slots, n + 3, 4): factors of the mass matrix and of the effective ones by rows
# [1/D, L(i,i-1), L(i,i-2), L(i,i-3)] of L D L^T, and the right-hand sides of a solve, side by side
FACTOR_MASS, COLUMNS = CHOLESKY, 0
LANES = 4
# ... vectors: responses of S to the mass matrix and to the effective matrices
MASS_RESPONSE = VECTORS
EFFECTIVE_RESPONSE = VECTORS + 1
NODAL_VECTORS = EFFECTIVE_RESPONSE + EFFECTIVE_SLOTS
# ... scalars: kappa
RANK_ONE = SCALARS
NODAL_SCALARS = SCALARS + 1


class NodalModel(NamedTuple):
    """A nodal beam on a pin or a hub of radius 0, packed for the compiled kernels; n free degrees of freedom."""

    bands: Array  # (5, 7, n) diagonals -3..3: bands[b, 3 + k, i] is the entry (i, i + k)
    vectors: Array  # (5, n)
    inertia: float  # J of the beam (kg m^2)
    static_moment: float  # Sm (kg m)
    gravity: float
    hub_inertia: float
    torque: float  # on the hub (N m)
    kelvin_voigt: float  # s
    mass_proportional: float  # 1/s
    contact_dof: int  # deflection of the contact point
    contact_radius: float  # x_F (m)
    slope_angle: float
    normal_offset: float  # c_n (m)
    tangential_offset: float  # c_t (m)


def new_nodal_work(size: int) -> Work:
    """Allocate the scratch arrays for `size` degrees of freedom; memory is linear in it."""
    slots = EFFECTIVE + EFFECTIVE_SLOTS
    rows = size + HALF_BANDWIDTH  # zeros behind the last row, so that a solve needs no special case
    return Work(np.zeros((slots, rows, LANES)), np.zeros((NODAL_VECTORS, size)), np.zeros(NODAL_SCALARS))


@jitable
def _dot(a: Array, b: Array) -> float:
    total = 0.0
    for i in range(a.shape[0]):
        total += a[i] * b[i]
    return total


@jitable
def _frame(model: NodalModel, q: Array, qd: Array) -> tuple[float, float]:
    """Angle and angular velocity of the mean-axis frame, S.W/J and S.W'/J."""
    theta, spin = 0.0, 0.0
    for i in range(q.shape[0]):
        theta += model.vectors[COUPLING, i] * q[i]
        spin += model.vectors[COUPLING, i] * qd[i]
    return theta / model.inertia, spin / model.inertia


@jitable
def _kinematics(model: NodalModel, q: Array, qd: Array, work: Work) -> tuple[float, float, float, float, float]:
    """Gap, slip and contact rows; returns x_P, y_P, their rates without spin, and the contact angle."""
    v, k, u = work.vectors, work.scalars, model.vectors
    theta, spin = _frame(model, q, qd)
    band_multiply(model.bands, SHORTENING_BAND, q, v, OWN_C)
    rigid, bent, bending = 0.0, 0.0, 0.0
    for i in range(q.shape[0]):
        v[OWN_C, i] -= theta * u[SHORTENING_RIGID, i]  # H B
        rigid += v[OWN_C, i] * u[RIGID, i]
        bent += v[OWN_C, i] * q[i]
        bending += v[OWN_C, i] * qd[i]
    x = model.contact_radius - 0.5 * (bent - theta * rigid)
    y = q[model.contact_dof] - model.contact_radius * theta
    x_rate = -(bending - spin * rigid)
    y_rate = qd[model.contact_dof] - model.contact_radius * spin
    angle = theta - model.slope_angle
    c, s = np.cos(angle), np.sin(angle)
    k[GAP] = x * s + y * c - model.normal_offset
    k[SLIP] = x * c - y * s - model.tangential_offset
    # rows in W: D_B + S (D_theta - x.D_B)/J
    normal = (x * c - y * s + s * rigid - c * model.contact_radius) / model.inertia
    tangential = (-x * s - y * c + c * rigid + s * model.contact_radius) / model.inertia
    gap_rate, slip_rate = 0.0, 0.0
    for i in range(q.shape[0]):
        v[NORMAL_ROW, i] = -s * v[OWN_C, i] + normal * u[COUPLING, i]
        v[TANGENT_ROW, i] = -c * v[OWN_C, i] + tangential * u[COUPLING, i]
        gap_rate += v[NORMAL_ROW, i] * qd[i]
        slip_rate += v[TANGENT_ROW, i] * qd[i]
    v[NORMAL_ROW, model.contact_dof] += c
    v[TANGENT_ROW, model.contact_dof] -= s
    k[GAP_RATE] = gap_rate + c * qd[model.contact_dof]
    k[SLIP_RATE] = slip_rate - s * qd[model.contact_dof]
    return x, y, x_rate, y_rate, angle


@jitable
def _biases(
    model: NodalModel, qd: Array, work: Work, x: float, y: float, x_rate: float, y_rate: float, angle: float
) -> None:
    """Z'' - D W'' of gap and slip."""
    v, k, u = work.vectors, work.scalars, model.vectors
    spin = _dot(u[COUPLING], qd) / model.inertia
    band_multiply(model.bands, SHORTENING_BAND, qd, v, OWN_A)
    bend = _dot(v[OWN_A], qd) - 2.0 * spin * _dot(u[SHORTENING_RIGID], qd)
    bend += spin * spin * _dot(u[SHORTENING_RIGID], u[RIGID])  # B'^T H B'
    c, s, square = np.cos(angle), np.sin(angle), spin * spin
    k[GAP_BIAS] = 2.0 * spin * (c * x_rate - s * y_rate) - square * (s * x + c * y) - s * bend
    k[SLIP_BIAS] = -2.0 * spin * (s * x_rate + c * y_rate) - square * (c * x - s * y) - c * bend


@jitable
def _forces(model: NodalModel, q: Array, qd: Array, work: Work) -> None:
    """Generalized forces f - K W - Cd W' and kappa."""
    v, k, u, J, g = work.vectors, work.scalars, model.vectors, model.inertia, model.gravity
    n = q.shape[0]
    theta, spin = _frame(model, q, qd)
    c, s = np.cos(theta), np.sin(theta)
    band_multiply(model.bands, SPIN_BAND, q, v, OWN_A)
    band_multiply(model.bands, GRAVITY_BAND, q, v, OWN_B)
    # K W = K B, but in W the rounding of K x would hold the beam like a spring, the stiffer the finer the mesh
    for i in range(n):
        v[OWN_C, i] = q[i] - theta * u[RIGID, i]
    band_multiply(model.bands, STIFFNESS_BAND, v[OWN_C], v, FORCES)
    lag, lagging, gravity_rigid, bent, lifted = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        v[OWN_B, i] -= theta * u[GRAVITY_RIGID, i]  # D B
        lag += v[OWN_A, i] * q[i]
        lagging += v[OWN_A, i] * qd[i]
        gravity_rigid += v[OWN_B, i] * u[RIGID, i]
        bent += v[OWN_B, i] * q[i]
        lifted += u[LOAD, i] * q[i]
    k[RANK_ONE] = lag / (J * J)
    bent -= theta * gravity_rigid  # B^T D B
    lifted -= theta * model.static_moment  # P.B
    moment = -2.0 * spin * lagging
    moment -= g * (c * (model.static_moment - 0.5 * bent) - s * lifted)
    moment += g * (c * model.static_moment - s * gravity_rigid)  # - x.f_B
    moment /= J
    square = spin * spin
    for i in range(n):
        v[FORCES, i] = (
            square * v[OWN_A, i] - g * (c * u[LOAD, i] - s * v[OWN_B, i]) + moment * u[COUPLING, i] - v[FORCES, i]
        )
    v[FORCES, 0] += model.torque  # the first free coordinate is the slope at the root
    k[DAMPING_POWER] = 0.0
    if model.kelvin_voigt > 0.0 or model.mass_proportional > 0.0:
        k[DAMPING_POWER] = _damp(model, qd, work)
        for i in range(n):
            v[FORCES, i] -= v[OWN_A, i]


@jitable
def _damp(model: NodalModel, qd: Array, work: Work) -> float:
    """Damping forces Cd W' into a row of the vectors; their power (W)."""
    v, n, power = work.vectors, qd.shape[0], 0.0
    spin = _dot(model.vectors[COUPLING], qd) / model.inertia
    band_multiply(model.bands, STIFFNESS_BAND, qd, v, OWN_A)
    band_multiply(model.bands, MASS_BAND, qd, v, OWN_B)
    v[OWN_B, 0] -= model.hub_inertia * qd[0]
    for i in range(n):
        # mass-proportional damping acts on B' only: M1 B' = M1 W' - S theta', without the hub's inertia
        v[OWN_A, i] *= model.kelvin_voigt
        v[OWN_A, i] += model.mass_proportional * (v[OWN_B, i] - spin * model.vectors[COUPLING, i])
        power += v[OWN_A, i] * qd[i]
    return power


@jitable
def damping_power_nodal(model: NodalModel, t: float, q: Array, qd: Array, work: Work) -> float:
    """Power (W) of the damping matrix at the velocities q'."""
    if model.kelvin_voigt > 0.0 or model.mass_proportional > 0.0:
        return float(_damp(model, qd, work))
    return 0.0


@jitable
def evaluate_nodal(model: NodalModel, t: float, q: Array, qd: Array, work: Work) -> None:
    """Fill `work` with forces, contact rows and biases at (q, q')."""
    _forces(model, q, qd, work)
    x, y, x_rate, y_rate, angle = _kinematics(model, q, qd, work)
    _biases(model, qd, work, x, y, x_rate, y_rate, angle)


@jitable
def residual_nodal(
    model: NodalModel, t: float, q: Array, qd: Array, qdd: Array, contact: bool, work: Work
) -> None:
    """Take forces and the residual f - K W - Cd W' - M W'' and, with `contact`, the rows; no biases."""
    v = work.vectors
    _forces(model, q, qd, work)
    if contact:
        _kinematics(model, q, qd, work)
    mass_product_nodal(model, work, qdd, RESIDUAL)
    for i in range(q.shape[0]):
        v[RESIDUAL, i] = v[FORCES, i] - v[RESIDUAL, i]


@jitable
def approach_nodal(model: NodalModel, t: float, q: Array, qd: Array, work: Work) -> None:
    """Gap, slip, their rates and the contact rows at (q, q')."""
    _kinematics(model, q, qd, work)


@jitable
def mass_product_nodal(model: NodalModel, work: Work, x: Array, row: int) -> None:
    """(M1 + kappa S S^T) x of an evaluated model into a row of the vectors."""
    band_multiply(model.bands, MASS_BAND, x, work.vectors, row)
    share = work.scalars[RANK_ONE] * _dot(model.vectors[COUPLING], x)
    for i in range(x.shape[0]):
        work.vectors[row, i] += share * model.vectors[COUPLING, i]


@jitable
def _solve_rows(
    model: NodalModel, work: Work, slot: int, response: int, first: int, target: int, contact: bool
) -> bool:
    """Solve for a row and, with `contact`, for the contact rows; the rank-one part by Sherman and Morrison.

    False if the matrix with its rank-one part is not positive definite.
    """
    columns, v, u = work.matrices[COLUMNS], work.vectors, model.vectors
    n = v.shape[1]
    for i in range(n):
        columns[i, 0] = v[first, i]
        columns[i, 1] = v[NORMAL_ROW, i]  # of an earlier instant if there is no contact: not used
        columns[i, 2] = v[TANGENT_ROW, i]
    solve_band(work.matrices[slot], columns)
    a, b, c, own = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        a += u[COUPLING, i] * columns[i, 0]
        b += u[COUPLING, i] * columns[i, 1]
        c += u[COUPLING, i] * columns[i, 2]
        own += u[COUPLING, i] * v[response, i]
    pivot = 1.0 + work.scalars[RANK_ONE] * own
    if not pivot > 0.0:
        return False
    share = work.scalars[RANK_ONE] / pivot
    for i in range(n):
        v[target, i] = columns[i, 0] - share * a * v[response, i]
    if contact:
        for i in range(n):
            v[NORMAL_RESPONSE, i] = columns[i, 1] - share * b * v[response, i]
            v[TANGENT_RESPONSE, i] = columns[i, 2] - share * c * v[response, i]
    return True


@jitable
def _respond(model: NodalModel, work: Work, slot: int, response: int) -> None:
    """Response of S to a factored matrix into a row of the vectors."""
    columns = work.matrices[COLUMNS]
    for i in range(work.vectors.shape[1]):
        columns[i, 0], columns[i, 1], columns[i, 2] = model.vectors[COUPLING, i], 0.0, 0.0
    solve_band(work.matrices[slot], columns)
    for i in range(work.vectors.shape[1]):
        work.vectors[response, i] = columns[i, 0]


@jitable
def solve_mass_nodal(model: NodalModel, work: Work, contact: bool) -> bool:
    """Acceleration without contact force and, with `contact`, M^-1 D^T; False if M is not positive definite."""
    if work.matrices[FACTOR_MASS, 0, 0] == 0.0:  # a constant matrix is factored once
        if not factor_band(model.bands, MASS_BAND, 1.0, STIFFNESS_BAND, 0.0, work.matrices[FACTOR_MASS]):
            return False
        _respond(model, work, FACTOR_MASS, MASS_RESPONSE)
    return _solve_rows(model, work, FACTOR_MASS, MASS_RESPONSE, FORCES, FREE_ACCELERATION, contact)


@jitable
def factor_effective_nodal(
    model: NodalModel, t: float, q: Array, velocity: float, position: float, work: Work, slot: int, stale: bool
) -> bool:
    """Factor M1 + velocity Cd + position K in a slot, only if the step has changed (`stale`)."""
    if not stale:
        return True
    mass = 1.0 + velocity * model.mass_proportional
    stiffness = position + velocity * model.kelvin_voigt
    if not factor_band(model.bands, MASS_BAND, mass, STIFFNESS_BAND, stiffness, work.matrices[EFFECTIVE + slot]):
        return False
    _respond(model, work, EFFECTIVE + slot, EFFECTIVE_RESPONSE + slot)
    return True


@jitable
def solve_effective_nodal(model: NodalModel, work: Work, slot: int, contact: bool) -> None:
    """S^-1 of the residual and, with `contact`, of the contact rows."""
    _solve_rows(model, work, EFFECTIVE + slot, EFFECTIVE_RESPONSE + slot, RESIDUAL, INCREMENT, contact)


def definiteness(model: NodalModel, work: Work) -> float:
    """1 + kappa S.M1^-1 S of a condensed model, which vanishes with the definiteness of the mass matrix."""
    return float(1.0 + work.scalars[RANK_ONE] * (model.vectors[COUPLING] @ work.vectors[MASS_RESPONSE]))


@jitable
def supplied_power_nodal(model: NodalModel, t: float, q: Array, qd: Array, work: Work) -> float:
    """Power (W) of the hub torque."""
    return float(model.torque * qd[0])


def _is_nodal(system: Any) -> bool:
    return isinstance(system, types.NamedTuple) and system.instance_class is NodalModel


@overload(protocol.evaluate, strict=False)
def _compiled_evaluate(system: Any, t: Any, q: Any, qd: Any, work: Any) -> Any:
    return evaluate_nodal if _is_nodal(system) else None


@overload(protocol.damping_power, strict=False)
def _compiled_damping_power(system: Any, t: Any, q: Any, qd: Any, work: Any) -> Any:
    return damping_power_nodal if _is_nodal(system) else None


@overload(protocol.supplied_power, strict=False)
def _compiled_supplied_power(system: Any, t: Any, q: Any, qd: Any, work: Any) -> Any:
    return supplied_power_nodal if _is_nodal(system) else None


@overload(dense.solve_mass, strict=False)
def _compiled_solve_mass(system: Any, work: Any, contact: Any) -> Any:
    return solve_mass_nodal if _is_nodal(system) else None


@overload(implicit.residual, strict=False)
def _compiled_residual(system: Any, t: Any, q: Any, qd: Any, qdd: Any, contact: Any, work: Any) -> Any:
    return residual_nodal if _is_nodal(system) else None


@overload(implicit.approach, strict=False)
def _compiled_approach(system: Any, t: Any, q: Any, qd: Any, work: Any) -> Any:
    return approach_nodal if _is_nodal(system) else None


@overload(implicit.mass_product, strict=False)
def _compiled_mass_product(system: Any, work: Any, x: Any, row: Any) -> Any:
    return mass_product_nodal if _is_nodal(system) else None


@overload(implicit.factor_effective, strict=False)
def _compiled_factor(
    system: Any, t: Any, q: Any, velocity: Any, position: Any, work: Any, slot: Any, stale: Any
) -> Any:
    return factor_effective_nodal if _is_nodal(system) else None


@overload(implicit.solve_effective, strict=False)
def _compiled_solve(system: Any, work: Any, slot: Any, contact: Any) -> Any:
    return solve_effective_nodal if _is_nodal(system) else None
