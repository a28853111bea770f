"""One step in time, and equilibrium at rest, by Newton's method.

A step of the length h from (q0, v0) to (q1, v1) is the mid-point rule for the inertia,

    M (v1 - v0)/h = f        q1 - q0 = h (v1 + v0)/2

with internal forces whose work is the change of the strain energy
(:meth:`~oblique_impact.fem_beam.exact.exact_beam.ExactBeam.step_forces`), so that

    T(v1) + V(q1) - T(v0) - V(q0) = work of the other forces on q1 - q0

holds whatever the length of the step (Simo and Tarnow 1992; Gonzalez 2000).  Momentum is conserved likewise,
angular momentum up to h^2, as the mean of a rotation and its divided difference belong to different points of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import LinAlgError

from oblique_impact.fem_beam.exact.elastic_sections import Array
from oblique_impact.fem_beam.exact.exact_beam import ExactBeam, Stage, solve
from oblique_impact.fem_beam.exact.stop import ClosedContact

#: Newton's iterations of a step; it takes two or three
MOST_ITERATIONS = 12
#: increments, relative to the length and to 1 rad, at which the iterations end: the next would be their square
CONVERGED = 1e-10
#: of the largest, a singular value of the equations of contacts that is rounding
_REDUNDANT = 1e-11


class NotConvergedError(ArithmeticError):
    """Newton's iterations did not converge."""


class SolvedStep(NamedTuple):
    """Result of a step."""

    stage: Stage  # at its end
    reactions: Array  # (contacts,) N, mean forces that keep sticking contacts where they are, 0 of others
    # (contacts,) N, those that would keep their slip velocity as it is: a slip velocity that is left over from the
    # step before, as little as it may be, takes a large force to reverse in a very short step
    keeping: Array
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
    contacts: Sequence[ClosedContact] = (),
    tolerance: float = CONVERGED,
) -> SolvedStep:
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
    contacts : sequence of ClosedContact
        Closed contacts with elastic obstacles.
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
    increments, begun = [], beam.step_start(q0)
    for _ in range(MOST_ITERATIONS):
        q1 = q0 + move
        internal = beam.step_forces(begun, q1, relaxation)
        pushed = [_Pushed(contact, q0, q1, length) for contact in contacts]
        outer = load + sum(contact.load for contact in pushed)
        residual = inertia * (beam.M @ (move - length * v0)) + internal.forces - outer
        band = inertia * beam.mass_band + internal.tangent
        try:
            change, reactions, keeping = _solve_with_contacts(pushed, move, length * v0, band, -residual, count)
        except LinAlgError:
            break
        move = move + change
        increments.append(float(np.max(np.abs(change / beam.scale))))
        if not np.isfinite(increments[-1]):
            break
        if increments[-1] < tolerance:
            stage = Stage(q0 + move, 2.0 / length * move - v0)
            outer = outer + sum(r * contact.tangential for r, contact in zip(reactions, pushed, strict=True))
            on_held = (inertia * (beam.M @ (move - length * v0)) + internal.forces - outer)[:count]
            return SolvedStep(stage, reactions, keeping, on_held, tuple(increments))
    raise NotConvergedError(f"increments {', '.join(f'{i:.1e}' for i in increments)}")


class _Pushed:
    """A contact in an iteration: its rows (3 n,) of gap and slip, its load (3 n,) and direction (3 n,).

    `rate` (N/m) and `drag` (N/m) are the changes of normal force and friction by the last gap and by the slide.
    """

    def __init__(self, contact: ClosedContact, q0: Array, q1: Array, length: float) -> None:
        gaps, slips, self.normal, self.tangential = contact.touching.rows(q0, q1)
        force, self.rate = contact.normal_force(gaps, slips, length)
        friction = contact.friction(float(self.tangential @ (q1 - q0)) / length)
        self.direction = self.normal + friction * self.tangential if friction else self.normal
        self.drag = force * contact.slope / length
        self.load = force * self.direction + contact.end_push(gaps, slips) * self.tangential
        self.sticks = contact.sticks


def _solve_with_contacts(
    pushed: Sequence[_Pushed], move: Array, drift: Array, band: Array, right: Array, count: int
) -> tuple[Array, Array, Array]:
    """Return one increment (3 n,), and forces (contacts,) that keep sticking points where they are, or at `drift`.

    Besides, these forces and the changes of normal forces and friction are unknown.  A place that slides along the
    beam couples elements that no band holds; so each of them has its response, and they follow from equations of
    their own.  Mean rows stand in for derivatives by the end of a step: they differ by what the beam turns in it.
    """
    sticking = [i for i, contact in enumerate(pushed) if contact.sticks]
    held_by = np.zeros((len(pushed), 2))
    if not pushed:
        return solve(band, right, count), held_by[:, 0], held_by[:, 1]
    held = [pushed[i].tangential for i in sticking]
    # normal forces and friction: direction of each, and the row that times the change (3 n,) is its change
    forces = [(contact.direction, contact.rate * contact.normal) for contact in pushed]
    forces += [(contact.tangential, contact.drag * contact.tangential) for contact in pushed if contact.drag]
    m, columns = len(forces), [right, *(direction for direction, _ in forces), *held]
    free, *responses = solve(band, np.stack(columns, axis=1), count).T
    # force: a - (its row) . change = 0;  stick: (slip's row) . (move + change) = 0
    rows = np.array([*(row for _, row in forces), *held])
    right, matrix = np.stack(2 * [rows @ free], axis=1), -rows @ np.stack(responses, axis=1)
    right[m:] += rows[m:] @ np.stack([move, move - drift], axis=1)
    matrix[range(m), range(m)] += 1.0
    scale = np.abs(np.diag(matrix))
    # points that hold the same place share its force
    found = np.linalg.lstsq(matrix / scale[:, None], right / scale[:, None], rcond=_REDUNDANT)[0]
    held_by[sticking] = found[m:]
    return free + found[:, 0] @ np.array(responses), held_by[:, 0], held_by[:, 1]


def equilibrium(beam: ExactBeam, q: Array, load: Array, held: int) -> Array:
    """Return nodal values at rest under dead loads (3 n,).

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

    Raises
    ------
    NotConvergedError
        If Newton's iterations do not converge: put the load on in steps.
    """
    increments: list[float] = []
    for _ in range(5 * MOST_ITERATIONS):
        internal = beam.static_forces(q)
        change = solve(internal.tangent, load - internal.forces, held)
        q = q + change
        increments.append(float(np.max(np.abs(change / beam.scale))))
        if increments[-1] < CONVERGED:
            return q
        if not np.isfinite(increments[-1]):
            break
    raise NotConvergedError(f"increments {', '.join(f'{i:.1e}' for i in increments[-5:])}")
