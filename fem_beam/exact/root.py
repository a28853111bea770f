"""A root that yields, and one on a hub's radius.

Between the first section and an angle a (rad), that of the ground or of a drive, a spring and a dashpot have the
moment k (phi - a) + c (phi' - a'); over a step it is taken of means and differences, so that its work is the
change of the spring's energy and the dashpot's loss.

The first node of a beam on a hub of the radius R is at R exp(i phi), so that over a step

    Delta r = R (Delta exp(i phi)/Delta phi) Delta phi

exactly: the forces on this node turn the section by the lever R (Delta exp(i phi)/Delta phi), and do no work
besides.  Its two rows and columns are put into those of the rotation, the third, and left out of the solution.
"""

from __future__ import annotations

import numpy as np

from oblique_impact.fem_beam.exact.step_forces import divided_difference
from oblique_impact.kernels.band_rows import BANDWIDTH
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array

#: radius (m) of a hub that turns freely, 0 of others; stiffness (N m/rad) and damping (N m s/rad) of the spring
#: at the root; the angle (rad) from which it is strained, at the start of a step and at its end
ARM, ROOT_STIFFNESS, ROOT_DAMPING, ANGLE_BEFORE, ANGLE_AFTER = range(5)
ROOT_NUMBERS = 5


@inlined
def levers(root: Array, phi0: float, phi1: float) -> tuple[complex, complex, complex]:
    """Move of the first node over a step by that of its rotation (m), its derivative by phi1, and dr/dphi1."""
    turn0, turn1 = complex(np.cos(phi0), np.sin(phi0)), complex(np.cos(phi1), np.sin(phi1))
    quotient, rate = divided_difference(turn0, turn1, phi1 - phi0)
    return root[ARM] * quotient, root[ARM] * rate, root[ARM] * 1j * turn1


@jitable
def bind_move(root: Array, q0: Array, move: Array) -> None:
    """Move the first node of a hub with its section over a step."""
    if root[ARM] > 0.0:
        lever, _, _ = levers(root, q0[2], q0[2] + move[2])
        move[0], move[1] = lever.real * move[2], lever.imag * move[2]


@jitable
def bind_row(root: Array, phi0: float, phi1: float, row: Array) -> None:
    """Put the entries of the first node in a row of forces, or of a gap, into that of its rotation."""
    lever, _, _ = levers(root, phi0, phi1)
    row[2] += lever.real * row[0] + lever.imag * row[1]
    row[0], row[1] = 0.0, 0.0


@jitable
def bind_matrix(root: Array, phi0: float, phi1: float, force: Array, rows: Array) -> None:
    """Put rows and columns of the first node into those of its rotation; `force` (2,) is what acts on the node."""
    if not root[ARM] > 0.0:
        return
    lever, rate, turned = levers(root, phi0, phi1)
    for i in range(BANDWIDTH + 1):
        rows[i, BANDWIDTH + 2 - i] += (
            turned.real * rows[i, BANDWIDTH - i] + turned.imag * rows[i, BANDWIDTH + 1 - i]
        )
    for j in range(2, BANDWIDTH + 1):
        rows[2, BANDWIDTH + j - 2] += lever.real * rows[0, BANDWIDTH + j] + lever.imag * rows[1, BANDWIDTH + j - 1]
    rows[2, BANDWIDTH] -= rate.real * force[0] + rate.imag * force[1]


@inlined
def root_moment(root: Array, phi0: float, phi1: float, h: float) -> float:
    """Mean moment (N m) of the spring and dashpot at the root over a step of the length h (s), on the ground."""
    twist0, twist1 = phi0 - root[ANGLE_BEFORE], phi1 - root[ANGLE_AFTER]
    return float(0.5 * root[ROOT_STIFFNESS] * (twist0 + twist1) + root[ROOT_DAMPING] * (twist1 - twist0) / h)


@inlined
def root_loss(root: Array, phi0: float, phi1: float, h: float) -> float:
    """Energy (J) that the dashpot at the root takes in a step."""
    twisted = (phi1 - root[ANGLE_AFTER]) - (phi0 - root[ANGLE_BEFORE])
    return float(root[ROOT_DAMPING] * twisted * twisted / h)


@inlined
def add_root(root: Array, phi0: float, phi1: float, h: float, change: Array) -> None:
    """Add the moment at the root to the forces on the beam (3 n,)."""
    change[2] -= root_moment(root, phi0, phi1, h)


@inlined
def stiffen_root(root: Array, h: float, rows: Array) -> None:
    """Add the derivative of this moment by the end of the step to a band matrix by rows."""
    rows[2, BANDWIDTH] += 0.5 * root[ROOT_STIFFNESS] + root[ROOT_DAMPING] / h
