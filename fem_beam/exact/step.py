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

from typing import NamedTuple, Protocol

import numpy as np
from scipy.linalg import LinAlgError

from oblique_impact.fem_beam.exact.beam import NODE, ExactBeam, solve
from oblique_impact.fem_beam.exact.sections import Array

#: Newton's iterations of a step; it takes two or three
MOST_ITERATIONS = 12
#: increments, relative to the length and to 1 rad, at which the iterations end: the next would be their square
CONVERGED = 1e-10


class NotConvergedError(ArithmeticError):
    """Newton's iterations did not converge."""


class PointForces(NamedTuple):
    """Forces (N) and moment (N m) on one node, and their derivatives by its unknowns at the end of the step."""

    force: Array  # (3,)
    tangent: Array  # (3, 3)


class Held(NamedTuple):
    """A displacement of a node within a step that is kept zero: how the unknowns move it, each (3,)."""

    mean: Array  # over the step: the displacement is mean . (q1 - q0)
    last: Array  # at its end


class PointLoad(Protocol):
    """Forces on one node, as a function of its unknowns at both ends of a step."""

    @property
    def node(self) -> int:
        """The node."""

    def held(self, q0: Array, q1: Array) -> Held | None:
        """Return the displacement that is kept zero within a step, or None."""

    def forces(self, q0: Array, q1: Array, length: float) -> PointForces:
        """Return the mean forces within a step of the given length (s)."""


class Stage(NamedTuple):
    """State at an instant: nodal values and velocities (3 n,)."""

    q: Array
    v: Array


class Step(NamedTuple):
    """Result of a step."""

    stage: Stage  # at its end
    reaction: float  # N, mean force that keeps the node of a `PointLoad` where it is
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
    point: PointLoad | None = None,
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
    point : PointLoad, optional
        Contact with the elastic stop.
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
            if point is None:
                change = solve(band, -residual, count)
            else:
                change, reaction = _with_point(point, (q0, q1), length, residual, band, count)
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


def _with_point(
    point: PointLoad,
    ends: tuple[Array, Array],
    length: float,
    residual: Array,
    band: Array,
    count: int,
) -> tuple[Array, float]:
    """One iteration with the forces on a node, and with the force that keeps one of its displacements zero."""
    at = slice(NODE * point.node, NODE * (point.node + 1))
    q0, q1 = (q[at] for q in ends)
    found, held = point.forces(q0, q1, length), point.held(q0, q1)
    residual[at] -= found.force
    half = band.shape[0] // 2
    for i in range(NODE):
        for j in range(NODE):
            band[half + i - j, at.start + j] -= found.tangent[i, j]
    if held is None:
        return solve(band, -residual, count), 0.0
    row = np.zeros_like(residual)
    row[at] = held.mean
    free, unit = solve(band, np.stack([-residual, row], axis=1), count).T
    reaction = float(-(held.mean @ (q1 - q0) + held.last @ free[at]) / (held.last @ unit[at]))
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
