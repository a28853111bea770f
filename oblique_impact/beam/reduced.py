"""A scenario's beam: its model for the kernels, its energies, and the results along it."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from oblique_impact.beam.base_motion import BaseMotion, base_motion_of
from oblique_impact.beam.floating_frame import (
    CONTACT_SHAPE,
    CONTACT_SHORTENING,
    COUPLING,
    DAMPING,
    DRIVEN,
    ELASTIC_MASS,
    GRAVITY_STIFFNESS,
    HUB,
    LOAD,
    PIN,
    ROOT_SLOPE,
    SPIN_STIFFNESS,
    STIFFNESS,
    BeamModel,
)
from oblique_impact.beam.operators import Array, BeamOperators, cumulative
from oblique_impact.beam.residual_flexibility import residual_compliance
from oblique_impact.contact.state import Residual
from oblique_impact.scenario.scenario import Scenario

_ROOTS = {"pin": PIN, "hub": HUB, "driven": DRIVEN}


class Energies(NamedTuple):
    """Energies (J), each of shape (samples,)."""

    kinetic: Array
    elastic: Array
    gravity: Array


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

    @property
    def mass(self) -> float:
        """Mass (kg), that of the tip included."""
        return self.operators.sections.mass

    @cached_property
    def motion(self) -> BaseMotion:
        """How a driven root turns."""
        motion: BaseMotion = self.scenario.part("profile") or base_motion_of(self.scenario.root)
        return motion

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times (s) at which the root's motion is not smooth."""
        return self.motion.breakpoints

    @cached_property
    def model(self) -> BeamModel:
        """Everything the kernels need."""
        s, o = self.scenario, self.operators
        kinetics = s.discretization.kinetics
        kept = 0.0 if kinetics == "zeroth-order" else 1.0
        full = kinetics == "full"
        hub = s.root.inertia if s.root.kind == "hub" else 0.0
        (x, y), angle = s.slope.origin, s.slope.angle
        n = o.size
        drive, parameters = self.motion.acceleration
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
        return BeamModel(
            matrices=_contiguous(np.stack([matrices[k] for k in sorted(matrices)])),
            vectors=_contiguous(np.stack([vectors[k] for k in sorted(vectors)])),
            full=full,
            quad_points=_contiguous(self._mass_points() if full else np.zeros((2, 0))),
            quad_shapes=_contiguous(self._with_tip(o.stations.quadrature.values) if full else np.zeros((0, n))),
            quad_shortening=_contiguous(self._shortening_table() if full else np.zeros((0, n, n))),
            inertia=o.J + hub,
            static_moment=o.Sm,
            gravity=s.gravity,
            root=_ROOTS[s.root.kind],
            hub_inertia=hub,
            torque=s.root.torque if s.root.kind == "hub" else 0.0,
            drive=drive,
            drive_parameters=parameters,
            contact_radius=o.hub_radius + o.contact_point,
            slope_angle=angle,
            normal_offset=float(-x * np.sin(angle) + y * np.cos(angle)),
            tangential_offset=float(x * np.cos(angle) + y * np.sin(angle)),
        )

    def _mass_points(self) -> Array:
        """Arms r + x (m) and masses (kg) of the quadrature, (2, nq); a tip mass is one more point."""
        table, sections = self.operators.stations.quadrature, self.operators.sections
        points = np.stack([table.points, sections.mass_per_length(table.points) * table.weights])
        if sections.tip_mass > 0.0:
            points = np.append(points, [[sections.length], [sections.tip_mass]], axis=1)
        points[0] += sections.hub_radius
        return points

    def _with_tip(self, values: Array) -> Array:
        """Append the tip's shape functions (1, n) to those of the quadrature if there is a tip mass."""
        if self.operators.sections.tip_mass == 0.0:
            return values
        return np.append(values, self.operators.stations.values[-1:], axis=0)

    def _shortening_table(self) -> Array:
        """H at the points of mass, (nq, n, n)."""
        slopes = self.operators.stations.quadrature.slopes
        return self._integrals(np.einsum("ki,kj->kij", slopes, slopes))

    def _integrals(self, integrand: Array) -> Array:
        """Integrals from the root to the points of mass, the tip included; (quadrature, ...) -> (nq, ...)."""
        table = self.operators.stations.quadrature
        inner = cumulative(table, integrand)
        if self.operators.sections.tip_mass == 0.0:
            return inner
        return np.append(inner, np.tensordot(table.weights, integrand, axes=1)[None], axis=0)

    @cached_property
    def residual_compliance(self) -> float:
        """Compliance (m/N) of the modes that are left out at the contact point, transverse to the beam."""
        return residual_compliance(self.operators, clamped=self.scenario.discretization.frame == "tangent")

    def residual(self, q: Array) -> Residual:
        """Return what the coordinates leave out of the contact point at q (n + 1,)."""
        s = self.scenario
        if not s.contact.residual_flexibility:
            return Residual()
        tilt = float(q[0]) - s.slope.angle
        compliance = self.residual_compliance * np.cos(tilt) ** 2
        massless = s.contact.point_inertia == "none" and s.contact.normal == "rigid"
        return Residual(float(compliance), s.beam.kelvin_voigt, float(np.tan(tilt)) if massless else 0.0)

    def initial_state(self) -> tuple[Array, Array]:
        """Return q and q' (n + 1,) at t = 0: the undeformed beam at its initial angle and speed."""
        q, qd = np.zeros(self.size), np.zeros(self.size)
        q[0] = self.scenario.initial.angle
        qd[0] = self.scenario.initial_angular_velocity
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
        ux = -0.5 * self._integrals(slope**2).T
        ux_rate = -self._integrals(slope * slope_rate).T
        values = self._with_tip(table.values).T
        uy, uy_rate = q[:, 1:] @ values, qd[:, 1:] @ values
        axial = ux_rate - spin * uy
        transverse = uy_rate + spin * (m.quad_points[0] + ux)
        hub = m.hub_inertia * (qd[:, 0] + qd[:, 1:] @ m.vectors[ROOT_SLOPE]) ** 2
        return np.asarray(0.5 * (axial**2 + transverse**2) @ m.quad_points[1] + 0.5 * hub)

    @property
    def foreshortening(self) -> float:
        """1, or 0 in zeroth-order kinetics, which leave the foreshortening out."""
        return 0.0 if self.scenario.discretization.kinetics == "zeroth-order" else 1.0


def _contiguous(values: Array) -> Array:
    return np.ascontiguousarray(values, dtype=np.float64)


def _quadratic(left: Array, matrix: Array, right: Array) -> Array:
    """Row-wise left^T matrix right."""
    return np.asarray(np.einsum("si,si->s", left @ matrix, right))
