"""One step in time, and equilibrium at rest, by Newton's method.

A step of the length h from (q0, v0) to (q1, v1) is the mid-point rule for the inertia,

    M (v1 - v0)/h = f        q1 - q0 = h (v1 + v0)/2

with internal forces whose work is the change of the strain energy
(:meth:`~oblique_impact.fem_beam.exact.beam.ExactBeam.step_forces`), so that

    T(v1) + V(q1) - T(v0) - V(q0) = work of the other forces on q1 - q0

holds whatever the length of the step (Simo and Tarnow 1992; Gonzalez 2000).  Momentum is conserved likewise,
angular momentum up to h^2, as the mean of a rotation and its divided difference belong to different points of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError

from oblique_impact.fem_beam.exact.beam import NODE, ExactBeam, Stage, solve
from oblique_impact.fem_beam.exact.sections import Array
from oblique_impact.fem_beam.exact.stop import Contact

#: Newton's iterations of a step; it takes two or three
MOST_ITERATIONS = 12
#: increments, relative to the length and to 1 rad, at which the iterations end: the next would be their square
CONVERGED = 1e-10


class NotConvergedError(ArithmeticError):
    """Newton's iterations did not converge."""


class Step(NamedTuple):
    """Result of a step."""

    stage: Stage  # at its end
    reaction: float  # N, mean force that keeps a sticking contact where it is
    held: Array  # (held,) mean forces on the unknowns that are prescribed
    increments: tuple[float, ...]  # of Newton's iterations, relative


def advance(
    beam: ExactBeam,
    start: Stage,
    length: float,
    load: Array,
    *,
    held: Array,
    viscosity: float = 0.0,
    contact: Contact | None = None,
    tolerance: float = CONVERGED,
) -> Step:
    """Return the step of the given length (s).

    Parameters
    ----------
    beam : ExactBeam
        The beam.
    start : Stage
        At the beginning of the step.
    length : float
        s.
    load : ndarray, shape (3 n,)
        Mean forces from outside.
    held : ndarray, shape (held,)
        Values at the end of the step of the first unknowns, which are prescribed.
    viscosity : float
        Kelvin-Voigt damping (s).
    contact : Contact, optional
        With the elastic stop.
    tolerance : float
        Increment at which the iterations end, relative to the length and to 1 rad.

    Raises
    ------
    NotConvergedError
        If Newton's iterations do not converge.
    """
    q0, v0, count = start.q, start.v, held.size
    inertia, relaxation = 2.0 / length**2, viscosity / length
    move = length * v0  # the unknowns: increments keep more digits than places
    move[:count] = held - q0[:count]
    reaction, increments, begun = 0.0, [], beam.step_start(q0)
    for _ in range(MOST_ITERATIONS):
        q1 = q0 + move
        internal = beam.step_forces(begun, q1, relaxation)
        residual = inertia * (beam.M @ (move - length * v0)) + internal.forces - load
        band = inertia * beam.mass_band + internal.tangent
        try:
            if contact is None:
                change = solve(band, -residual, count)
            else:
                change, reaction = _with_contact(contact, q0, q1, length, residual, band, count)
        except LinAlgError:
            break
        move = move + change
        increments.append(float(np.max(np.abs(change / beam.scale))))
        if not np.isfinite(increments[-1]):
            break
        if increments[-1] < tolerance:
            stage = Stage(q0 + move, 2.0 / length * move - v0)
            on_held = (inertia * (beam.M @ (move - length * v0)) + internal.forces - load)[:count]
            return Step(stage, reaction, on_held, tuple(increments))
    raise NotConvergedError(f"increments {', '.join(f'{i:.1e}' for i in increments)}")


def _with_contact(
    contact: Contact, q0: Array, q1: Array, length: float, residual: Array, band: Array, count: int
) -> tuple[Array, float]:
    """One iteration with the contact forces, and the force that keeps the slip of a sticking point zero."""
    at = slice(NODE * contact.slope.node, NODE * (contact.slope.node + 1))
    q0, q1 = q0[at], q1[at]
    force, tangent = contact.forces(q0, q1, length)
    residual[at] -= force
    half = band.shape[0] // 2
    for i in range(NODE):
        for j in range(NODE):
            band[half + i - j, at.start + j] -= tangent[i, j]
    if not contact.sticks:
        return solve(band, -residual, count), 0.0
    along, row = contact.slope.tangent, np.zeros_like(residual)
    mean, last = contact.slope.mean_rows(along, q0, q1)[0], contact.slope.rows(along, q1)
    row[at] = mean
    free, unit = solve(band, np.stack([-residual, row], axis=1), count).T
    reaction = float(-(mean @ (q1 - q0) + last @ free[at]) / (last @ unit[at]))
    return free + reaction * unit, reaction


def equilibrium(
    beam: ExactBeam, q: Array, load: Array, held: int, tolerance: float = CONVERGED
) -> tuple[Array, tuple[float, ...]]:
    """Return nodal values at rest under dead loads (3 n,), and the increments of Newton's iterations.

    Parameters
    ----------
    beam : ExactBeam
        The beam.
    q : ndarray, shape (3 n,)
        Where the iterations start; the first `held` unknowns stay.
    load : ndarray, shape (3 n,)
        Forces (N) and moments (N m).
    held : int
        2 for a pin, 3 for a clamped root.
    tolerance : float
        Increment at which the iterations end, relative to the length.

    Raises
    ------
    NotConvergedError
        If they do not converge: put the load on in steps.
    """
    increments: list[float] = []
    for _ in range(5 * MOST_ITERATIONS):
        internal = beam.static_forces(q)
        change = solve(internal.tangent, load - internal.forces, held)
        q = q + change
        increments.append(float(np.max(np.abs(change / beam.scale))))
        if increments[-1] < tolerance:
            return q, tuple(increments)
        if not np.isfinite(increments[-1]):
            break
    raise NotConvergedError(f"increments {', '.join(f'{i:.1e}' for i in increments[-5:])}")
