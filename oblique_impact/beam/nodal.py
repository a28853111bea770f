"""The full nodal beam: its operators, their packing for the kernels, its energies."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array

from oblique_impact.beam.nodal_frame import (
    COUPLING,
    GRAVITY_BAND,
    GRAVITY_RIGID,
    LOAD,
    MASS_BAND,
    MASS_RESPONSE,
    RIGID,
    SHORTENING_BAND,
    SHORTENING_RIGID,
    SPIN_BAND,
    STIFFNESS_BAND,
    NodalModel,
    factored_mass,
)
from oblique_impact.beam.operators import Array, BeamOperators
from oblique_impact.beam.reduced import Energies
from oblique_impact.contact.state import Residual
from oblique_impact.kernels.banded import HALF_BANDWIDTH
from oblique_impact.scenario.scenario import Scenario


@dataclass(frozen=True)
class NodalOperators:
    """Banded operators of a beam in its n free nodal degrees of freedom: the slope at the root, then node by node.

    Notation and units as in :class:`~oblique_impact.beam.operators.BeamOperators`; `beam` holds the same operators
    as those of elastic coordinates B, for results along the beam.
    """

    M1: csr_array  # (n, n)
    K: csr_array
    C: csr_array
    D: csr_array
    contact_shortening: csr_array  # H(x_F)
    S: Array  # (n,)
    P: Array
    rigid: Array  # (n,) the function x
    contact_dof: int  # deflection at x_F
    beam: BeamOperators


class FullBeam:
    """A nodal beam on a pin, or on a hub of radius 0, in its total transverse coordinates W.

    Parameters
    ----------
    scenario : Scenario
        What to simulate; mean-axis frame, first-order kinetics.
    operators : NodalOperators
        From ``fem_beam.build_nodal``.
    """

    def __init__(self, scenario: Scenario, operators: NodalOperators) -> None:
        self.scenario, self.operators = scenario, operators

    @property
    def size(self) -> int:
        """Degrees of freedom."""
        return int(self.operators.P.size)

    @property
    def mass(self) -> float:
        """Mass (kg), that of the tip included."""
        return self.operators.beam.sections.mass

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times (s) at which the root's motion is not smooth: none, it is free."""
        return ()

    @cached_property
    def inertia(self) -> float:
        """J = int m x^2 dx (kg m^2), which the elements integrate exactly."""
        return float(self.operators.rigid @ self.operators.S)

    @cached_property
    def hub_inertia(self) -> float:
        """Kg m^2."""
        root = self.scenario.root
        return root.inertia if root.kind == "hub" else 0.0

    @cached_property
    def model(self) -> NodalModel:
        """Everything the kernels need."""
        s, o = self.scenario, self.operators
        shortening = o.contact_shortening * float(s.contact.shortening)
        bands = np.zeros((5, 2 * HALF_BANDWIDTH + 1, self.size))
        for which, matrix in (
            (MASS_BAND, o.M1),
            (STIFFNESS_BAND, o.K),
            (SPIN_BAND, o.M1 - o.C),
            (GRAVITY_BAND, o.D),
            (SHORTENING_BAND, shortening),
        ):
            bands[which] = _diagonals(matrix)
        bands[MASS_BAND, HALF_BANDWIDTH, 0] += self.hub_inertia
        vectors = np.zeros((6, self.size))
        vectors[COUPLING], vectors[LOAD], vectors[RIGID] = o.S, o.P, o.rigid
        vectors[GRAVITY_RIGID], vectors[SHORTENING_RIGID] = o.D @ o.rigid, shortening @ o.rigid
        mass_factor, vectors[MASS_RESPONSE] = factored_mass(bands, o.S)
        (x, y), angle = s.slope.origin, s.slope.angle
        return NodalModel(
            bands=bands,
            mass_factor=mass_factor,
            vectors=vectors,
            inertia=self.inertia,
            static_moment=float(o.P @ o.rigid),
            gravity=s.gravity,
            hub_inertia=self.hub_inertia,
            torque=s.root.torque if s.root.kind == "hub" else 0.0,
            kelvin_voigt=s.beam.kelvin_voigt,
            mass_proportional=s.beam.mass_proportional,
            contact_dof=o.contact_dof,
            contact_radius=s.contact.point,
            slope_angle=angle,
            normal_offset=float(-x * np.sin(angle) + y * np.cos(angle)),
            tangential_offset=float(x * np.cos(angle) + y * np.sin(angle)),
        )

    def residual(self, q: Array) -> Residual:
        """Return what the coordinates leave out of the contact point: nothing."""
        return Residual()

    def initial_state(self) -> tuple[Array, Array]:
        """Return W and W' (n,) at t = 0: the undeformed beam at its initial angle and speed."""
        initial = self.scenario.initial
        return initial.angle * self.operators.rigid, initial.angular_velocity * self.operators.rigid

    def split(self, W: Array) -> Array:
        """Angle of the mean-axis frame and elastic coordinates, [theta, B] (..., n + 1), of W (..., n)."""
        theta = W @ self.operators.S / self.inertia
        return np.concatenate([theta[..., None], W - theta[..., None] * self.operators.rigid], axis=-1)

    def energies(self, W: Array, Wd: Array) -> Energies:
        """Energies of samples W, W' (samples, n)."""
        o, g = self.operators, self.scenario.gravity
        theta, spin = W @ o.S / self.inertia, Wd @ o.S / self.inertia
        B = W - theta[:, None] * o.rigid
        lag = _quadratic(B, o.M1 - o.C)
        kinetic = 0.5 * (_quadratic(Wd, o.M1) + self.hub_inertia * Wd[:, 0] ** 2 + spin**2 * lag)
        height = np.sin(theta) * (float(o.P @ o.rigid) - 0.5 * _quadratic(B, o.D)) + np.cos(theta) * (B @ o.P)
        return Energies(kinetic, 0.5 * _quadratic(B, o.K), g * height)


def _diagonals(matrix: csr_array) -> Array:
    """Diagonals -3..3, shape (7, n); entry [3 + k, i] is that at (i, i + k)."""
    n = matrix.shape[0]
    stored = np.zeros((2 * HALF_BANDWIDTH + 1, n))
    for k in range(-HALF_BANDWIDTH, HALF_BANDWIDTH + 1):
        diagonal = matrix.diagonal(k)
        first = max(0, -k)
        stored[HALF_BANDWIDTH + k, first : first + diagonal.size] = diagonal
    return stored


def _quadratic(rows: Array, matrix: csr_array) -> Array:
    """Row-wise v^T A v."""
    return np.asarray(np.einsum("si,si->s", rows, (matrix @ rows.T).T))
