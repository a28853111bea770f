"""Contact places without inertia on a beam in modes: the flexibility between them that the modes leave out.

The modes above the last one follow without inertia.  With the forces f (n,) on the beam at n places, across it,
the viscosity eta over the stiffness and the residual flexibility G (n, n), they deflect by z = G s with

    s + eta s' = f

(one place: `oblique_impact.contact.state.Residual`).  Over a time step from s0 to s1, with the mean force f,

    a s1 + (1 - a) s0 = f,    a = max(1/2 + eta/h, 1)

which is the mid-point rule where the step resolves the relaxation, and else s1 = f.  The work f.(z1 - z0) of a
step raises the energy s.G s/2; of the rest, (a - 1/2) ds.G ds, the part eta/h ds.G ds is the damping's.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array

_NOTHING = 1e-30  # N: what has relaxed to less is zero, so that no step computes with subnormal numbers


class Yielding(NamedTuple):
    """Deflections of n places without inertia; n is 0 for a mesh, whose own nodes have no inertia."""

    flexibility: Array  # (n, n) m/N
    viscosity: float  # s
    angles: Array  # (n,) rad, of sides
    facing: Array  # (n,) side of an obstacle point on which the beam is, see `oblique_impact.beam.axis.Peg`; or 0
    across: Array  # (n, 2) derivatives of gap and slip by the deflection
    pressed: Array  # (n,) N, s at the start of a step
    after: Array  # (n,) N, at its end
    deflections: Array  # (n,) m, z at the start of a step
    moved: Array  # (n,) m, z1 - z0

    @classmethod
    def new(cls, flexibility: Array, viscosity: float, angles: Array, facing: Array) -> Yielding:
        """Allocate the arrays of n places at rest."""
        n = len(angles)
        rest = (np.zeros(n) for _ in range(4))
        return cls(np.ascontiguousarray(flexibility), viscosity, angles.copy(), facing, np.zeros((n, 2)), *rest)

    def at_rest(self) -> Yielding:
        """Return a copy for a run, without deflections."""
        return Yielding.new(self.flexibility, self.viscosity, self.angles, self.facing)


@inlined
def weight_of_end(y: Yielding, h: float) -> float:
    """Return a, the weight of the end of a step of length h (s)."""
    return max(0.5 + y.viscosity / h, 1.0)


@jitable
def turn_places(y: Yielding, theta: float) -> None:
    """Take the directions of gap and slip at the angle theta of the frame, with which obstacle points turn."""
    for i in range(y.across.shape[0]):
        if y.facing[i] != 0.0:
            y.across[i, 0], y.across[i, 1] = y.facing[i], 0.0
        else:
            y.across[i, 0], y.across[i, 1] = np.cos(theta - y.angles[i]), -np.sin(theta - y.angles[i])


@jitable
def push_places(y: Yielding, h: float, impulses: Array, closed: NDArray[np.int64], m: int) -> None:
    """Take the deflections at the end of a step with the impulses (2 m,), N s, of the m `closed` places."""
    a, n = weight_of_end(y, h), y.pressed.shape[0]
    if n == 0:
        return
    for i in range(n):
        y.after[i] = (a - 1.0) / a * y.pressed[i]
    for k in range(m):
        i = closed[k]
        force = y.across[i, 0] * impulses[2 * k] + y.across[i, 1] * impulses[2 * k + 1]
        y.after[i] += force / (a * h)
    for i in range(n):
        y.moved[i] = -y.deflections[i]
    for j in range(n):
        if y.after[j] != 0.0:
            for i in range(n):
                y.moved[i] += y.flexibility[i, j] * y.after[j]


@jitable
def end_step(y: Yielding, h: float) -> tuple[float, float]:
    """Begin the next step; returns the energy (J) that damping and scheme have taken in the last one."""
    change = 0.0
    for i in range(y.pressed.shape[0]):
        change += (y.after[i] - y.pressed[i]) * y.moved[i]
    for i in range(y.pressed.shape[0]):
        y.deflections[i] += y.moved[i]
        y.pressed[i] = y.after[i] if abs(y.after[i]) > _NOTHING else 0.0
    return y.viscosity / h * change, (weight_of_end(y, h) - 0.5 - y.viscosity / h) * change
