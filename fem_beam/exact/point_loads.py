"""Forces at places of the exact beam over a step, whose work is force times displacement, exactly.

A force acts on the material point r(x) of the axis, which the three nodes of an element carry by their functions.
One that is fixed in space is that at the middle of the step.  One across the beam turns with its section at x, and
has the direction i mean(exp(i phi)) of both ends of the step, the mean that internal forces have.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.beam.point_forces import PointForces, force_value
from oblique_impact.fem_beam.exact.step_forces import NODE
from oblique_impact.kernels.band_rows import BANDWIDTH
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array

# a force in a step: the first node of its element, the values of the functions of the three nodes, its components
# (N) in space, and that across the beam
FIRST, SHAPE, FIXED_X, FIXED_Y, ACROSS = 0, 1, 4, 5, 6
COLUMNS = 7


class PlacedForces(NamedTuple):
    """Forces on the beam with the nodes that carry them."""

    each: PointForces
    first: NDArray[np.int64]  # (k,) nodes
    shapes: Array  # (k, 3)


@jitable
def take_point_forces(placed: PlacedForces | None, t: float, forces: Array) -> None:
    """Put the forces at an instant (s) into `forces` (k, 7); the compiler drops this of a beam without any."""
    if placed is None:
        return
    for i in range(forces.shape[0]):
        value, of = force_value(placed.each, i, t), placed.each.each[i]
        forces[i, FIRST] = placed.first[i]
        for a in range(3):
            forces[i, SHAPE + a] = placed.shapes[i, a]
        forces[i, FIXED_X] = 0.0 if of.follows else value * np.cos(of.angle)
        forces[i, FIXED_Y] = 0.0 if of.follows else value * np.sin(of.angle)
        forces[i, ACROSS] = value if of.follows else 0.0


@jitable
def _turn(force: Array, q: Array) -> complex:
    """exp(i phi) of the section that a force acts on."""
    j, phi = NODE * int(force[FIRST]) + 2, 0.0
    for a in range(3):
        phi += force[SHAPE + a] * q[j + NODE * a]
    return complex(np.cos(phi), np.sin(phi))


@jitable
def _mean_of(force: Array, q0: Array, q1: Array) -> complex:
    """Mean (N) of a force in a step from q0 to q1."""
    if force[ACROSS] == 0.0:
        return complex(force[FIXED_X], force[FIXED_Y])
    return 0.5j * float(force[ACROSS]) * (_turn(force, q0) + _turn(force, q1))


@jitable
def point_force(force: Array, q: Array) -> complex:
    """Force (N), x + i y, on a beam with the nodal values q (3 n,)."""
    return _mean_of(force, q, q)


@jitable
def add_point_forces(forces: Array, q0: Array, q1: Array, generalized: Array) -> None:
    """Add the mean forces of a step from q0 to q1 to `generalized` (3 n,)."""
    for i in range(forces.shape[0]):
        mean, j = _mean_of(forces[i], q0, q1), NODE * int(forces[i, FIRST])
        for a in range(3):
            generalized[j + NODE * a] += forces[i, SHAPE + a] * mean.real
            generalized[j + NODE * a + 1] += forces[i, SHAPE + a] * mean.imag


@jitable
def subtract_point_tangent(forces: Array, q1: Array, rows: Array) -> None:
    """Subtract the derivatives of these forces by the end of the step from a band matrix by rows (3 n + 8, 17)."""
    for i in range(forces.shape[0]):
        if forces[i, ACROSS] == 0.0:
            continue
        turned, j = -0.5 * forces[i, ACROSS] * _turn(forces[i], q1), NODE * int(forces[i, FIRST])
        for a in range(3):
            for b in range(3):
                share = forces[i, SHAPE + a] * forces[i, SHAPE + b]
                column = NODE * (b - a) + 2 + BANDWIDTH
                rows[j + NODE * a, column] -= share * turned.real
                rows[j + NODE * a + 1, column - 1] -= share * turned.imag
