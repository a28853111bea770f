"""A scenario's beam: operators and data put into a model, and what can be read off a motion."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from oblique_impact.floating_frame import (
    CONSTANT_SPEED,
    CONTACT_SHAPE,
    CONTACT_SHORTENING,
    COUPLING,
    DAMPING,
    DRIVEN,
    ELASTIC_MASS,
    GRAVITY_STIFFNESS,
    HOLD,
    HUB,
    LOAD,
    PIN,
    ROOT_SLOPE,
    SPIN_STIFFNESS,
    SPIN_UP,
    STIFFNESS,
    BeamModel,
    drive,
)
from oblique_impact.operators import Array, BeamOperators, ShapeTable
from oblique_impact.scenario import Scenario

_ROOTS = {"pin": PIN, "hub": HUB, "driven": DRIVEN}
_PROFILES = {"hold": HOLD, "constant-speed": CONSTANT_SPEED, "spin-up": SPIN_UP}


class Energies(NamedTuple):
    """Energies (J), each of shape (samples,)."""

    kinetic: Array
    elastic: Array
    gravity: Array


class Fields(NamedTuple):
    """Results along the beam, each of shape (samples, stations), in the floating frame."""

    ux: Array  # m
    uy: Array  # m
    moment: Array  # N m
    axial_force: Array  # N, tension positive


@dataclass(frozen=True)
class Motion:
    """Sampled motion: times (samples,), q, q', q'' (samples, n + 1) and contact forces (samples,)."""

    time: Array
    q: Array
    qd: Array
    qdd: Array
    normal_force: Array
    tangential_force: Array


def damping_matrix(scenario: Scenario, operators: BeamOperators) -> Array:
    """Damping matrix (n, n): Kelvin-Voigt, mass-proportional, and 2 zeta omega_i on each eigenmode of (K, M1)."""
    beam = scenario.beam
    matrix = beam.kelvin_voigt * operators.K + beam.mass_proportional * operators.M1
    if beam.modal_damping_ratio > 0.0:
        squares, modes = eigh(operators.K, operators.M1)
        weighted = operators.M1 @ modes
        rates = 2.0 * beam.modal_damping_ratio * np.sqrt(np.maximum(squares, 0.0))
        matrix = matrix + (weighted * rates) @ weighted.T
    return np.ascontiguousarray(matrix)


def cumulative_weights(order: int) -> Array:
    """Weights (order, order) of int_0^{x_l} over a unit panel.

    Exact for the polynomial through the panel's Gauss points.
    """
    nodes, weights = np.polynomial.legendre.leggauss(order)
    basis = np.polynomial.legendre.legvander(nodes, order - 1)
    # Legendre coefficients from values: a_m = (2 m + 1)/2 sum_k w_k P_m(x_k) f_k
    to_coefficients = (basis * weights[:, None]).T * (np.arange(order)[:, None] + 0.5)
    columns = (np.polynomial.legendre.legint(c, lbnd=-1.0) for c in to_coefficients.T)
    return np.asarray(0.5 * np.stack([np.polynomial.legendre.legval(nodes, c) for c in columns], axis=1))


def cumulative(table: ShapeTable, integrand: Array) -> Array:
    """Integral from the root to each quadrature point; `integrand` (nq, ...) -> (nq, ...)."""
    panels = table.points.size // table.order
    rest = integrand.shape[1:]
    values = integrand.reshape(panels, table.order, -1)
    weights = table.weights.reshape(panels, table.order)
    totals = np.einsum("pk,pkm->pm", weights, values)
    start = np.concatenate([np.zeros_like(totals[:1]), np.cumsum(totals, axis=0)[:-1]])
    inside = np.einsum("lk,pkm->plm", cumulative_weights(table.order), values)
    inside *= weights.sum(axis=1)[:, None, None]
    return np.asarray((inside + start[:, None, :]).reshape(table.points.size, *rest))


class Beam:
    """A discretized beam with its root, load and slope.

    Parameters
    ----------
    scenario : Scenario
        What to simulate.
    operators : BeamOperators
        The discretization's operators for the same scenario.
    """

    def __init__(self, scenario: Scenario, operators: BeamOperators) -> None:
        self.scenario = scenario
        self.operators = operators

    @property
    def size(self) -> int:
        """Degrees of freedom: theta and the elastic coordinates."""
        return self.operators.size + 1

    @cached_property
    def model(self) -> BeamModel:
        """Everything the kernels need."""
        s, o = self.scenario, self.operators
        kinetics = s.discretization.kinetics
        kept = 0.0 if kinetics == "zeroth-order" else 1.0
        full = kinetics == "full"
        hub = s.root.inertia if s.root.kind == "hub" else 0.0
        (x, y), angle = s.slope.origin, s.slope.angle
        table = o.stations.quadrature
        n = o.size
        shortening = kept if s.contact.shortening else 0.0
        matrices = {
            ELASTIC_MASS: o.M1 + hub * np.outer(o.root_slope, o.root_slope),
            SPIN_STIFFNESS: o.M1 - kept * o.C,
            STIFFNESS: o.K,
            DAMPING: damping_matrix(s, o),
            GRAVITY_STIFFNESS: kept * o.D,
            CONTACT_SHORTENING: shortening * o.contact_shortening,
        }
        vectors = {
            COUPLING: o.S + hub * o.root_slope,
            LOAD: o.P,
            ROOT_SLOPE: o.root_slope,
            CONTACT_SHAPE: o.contact_shape,
        }
        arms, masses = o.hub_radius + table.points, o.mass_per_length * table.weights
        return BeamModel(
            matrices=_own(np.stack([matrices[k] for k in sorted(matrices)])),
            vectors=_own(np.stack([vectors[k] for k in sorted(vectors)])),
            full=full,
            quad_points=_own(np.stack([arms, masses]) if full else np.zeros((2, 0))),
            quad_shapes=_own(table.values if full else np.zeros((0, n))),
            quad_shortening=_own(self._shortening_table() if full else np.zeros((0, n, n))),
            inertia=o.J + hub,
            static_moment=o.Sm,
            gravity=s.gravity,
            root=_ROOTS[s.root.kind],
            hub_inertia=hub,
            torque=s.root.torque if s.root.kind == "hub" else 0.0,
            profile=_PROFILES[s.root.profile],
            spin_rate=s.root.spin_rate,
            spin_up_time=s.root.spin_up_time,
            contact_radius=o.hub_radius + o.contact_point,
            slope_angle=angle,
            normal_offset=float(-x * np.sin(angle) + y * np.cos(angle)),
            tangential_offset=float(x * np.cos(angle) + y * np.sin(angle)),
        )

    def _shortening_table(self) -> Array:
        """H at the quadrature points, (nq, n, n)."""
        table = self.operators.stations.quadrature
        return cumulative(table, np.einsum("ki,kj->kij", table.slopes, table.slopes))

    def initial_state(self) -> tuple[Array, Array]:
        """Return q and q' (n + 1,) at t = 0: the undeformed beam at its initial angle and speed."""
        q, qd = np.zeros(self.size), np.zeros(self.size)
        q[0] = self.scenario.initial.angle
        driven = self.scenario.root.kind == "driven"
        qd[0] = drive(self.model, 0.0)[1] if driven else self.scenario.initial.angular_velocity
        return q, qd

    def energies(self, q: Array, qd: Array) -> Energies:
        """Energies of samples q, q' (samples, n + 1) in the chosen order of kinetic energy."""
        m = self.model
        theta, B = q[:, 0], q[:, 1:]
        elastic = 0.5 * _quadratic(B, m.matrices[STIFFNESS], B)
        sine, cosine = np.sin(theta), np.cos(theta)
        height = sine * (m.static_moment - 0.5 * _quadratic(B, m.matrices[GRAVITY_STIFFNESS], B))
        gravity = m.gravity * (height + cosine * (B @ m.vectors[LOAD]))
        kinetic = self._full_kinetic(q, qd) if m.full else self._first_order_kinetic(q, qd)
        return Energies(kinetic, elastic, gravity)

    def _first_order_kinetic(self, q: Array, qd: Array) -> Array:
        m = self.model
        B, Bd, spin = q[:, 1:], qd[:, 1:], qd[:, 0]
        inertia = m.inertia + _quadratic(B, m.matrices[SPIN_STIFFNESS], B)
        elastic = 0.5 * _quadratic(Bd, m.matrices[ELASTIC_MASS], Bd)
        return np.asarray(0.5 * inertia * spin**2 + spin * (Bd @ m.vectors[COUPLING]) + elastic)

    def _full_kinetic(self, q: Array, qd: Array) -> Array:
        m, table = self.model, self.operators.stations.quadrature
        spin = qd[:, :1]
        slope, slope_rate = table.slopes @ q[:, 1:].T, table.slopes @ qd[:, 1:].T
        ux = -0.5 * cumulative(table, slope**2).T
        ux_rate = -cumulative(table, slope * slope_rate).T
        uy, uy_rate = q[:, 1:] @ table.values.T, qd[:, 1:] @ table.values.T
        axial = ux_rate - spin * uy
        transverse = uy_rate + spin * (m.quad_points[0] + ux)
        hub = m.hub_inertia * (qd[:, 0] + qd[:, 1:] @ m.vectors[ROOT_SLOPE]) ** 2
        return np.asarray(0.5 * (axial**2 + transverse**2) @ m.quad_points[1] + 0.5 * hub)

    def fields(self, motion: Motion) -> Fields:
        """Displacements, bending moment and axial force at the stations for each sample.

        The axial force of an axially rigid beam is a reaction: it follows from the equilibrium of the
        accelerated outer part, N(x) = F_a [x <= x_F] - int_x^L m (a_a + g sin theta) dxi.
        """
        o, stations = self.operators, self.operators.stations
        B = motion.q[:, 1:]
        slopes = stations.quadrature.slopes @ B.T
        return Fields(
            ux=self._foreshortening * (self._inboard @ (-0.5 * slopes**2)).T,
            uy=B @ stations.values.T,
            moment=o.bending_stiffness * (B @ stations.curvatures.T),
            axial_force=self._axial_force(motion, slopes),
        )

    @property
    def _foreshortening(self) -> float:
        return 0.0 if self.scenario.discretization.kinetics == "zeroth-order" else 1.0

    @cached_property
    def _inboard(self) -> Array:
        """Weights (stations, nq) of int_0^x over the stations x."""
        table = self.operators.stations
        inside = np.arange(table.quadrature.points.size) < table.cells[:, None]
        return np.where(inside, table.quadrature.weights, 0.0)

    def _axial_force(self, motion: Motion, slopes: Array) -> Array:
        """Axial force (samples, stations); `slopes` are u_y' at the quadrature points, (nq, samples).

        The double integrals of the foreshortening's acceleration become single ones by swapping their
        order: int_x^L int_0^xi f = int_0^L f(eta) (L - max(x, eta)) d eta.
        """
        o, stations = self.operators, self.operators.stations
        table, x, length = stations.quadrature, stations.points, o.length
        theta, spin, spin_rate = motion.q[:, 0], motion.qd[:, 0], motion.qdd[:, 0]
        slope_rates, slope_accelerations = (table.slopes @ v[:, 1:].T for v in (motion.qd, motion.qdd))
        shortening = slope_rates**2 + slopes * slope_accelerations - 0.5 * (spin * slopes) ** 2
        outboard = table.weights * (length - np.maximum(x[:, None], table.points))
        acceleration = -self._foreshortening * (outboard @ shortening).T
        remaining = length - x
        acceleration -= np.outer(spin**2, o.hub_radius * remaining + 0.5 * (length**2 - x**2))
        shapes = (table.weights - self._inboard) @ table.values  # int_x^L Phi
        acceleration -= 2.0 * spin[:, None] * (motion.qd[:, 1:] @ shapes.T)
        acceleration -= spin_rate[:, None] * (motion.q[:, 1:] @ shapes.T)
        weight = np.outer(self.scenario.gravity * np.sin(theta), remaining)
        angle = theta - self.scenario.slope.angle
        push = motion.normal_force * np.sin(angle) + motion.tangential_force * np.cos(angle)
        inside = x <= o.contact_point * (1.0 + 1e-12)
        return np.asarray(push[:, None] * inside - o.mass_per_length * (acceleration + weight))


def _own(values: Array) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)


def _quadratic(left: Array, matrix: Array, right: Array) -> Array:
    """Row-wise left^T matrix right."""
    return np.asarray(np.einsum("si,si->s", left @ matrix, right))
