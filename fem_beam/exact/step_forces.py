"""Internal forces of the exact beam over a step, whose work is the change of its strain energy, exactly.

The strain exp(-i phi) r' is a product, and for differences and means over the step the rule of products is

    Delta(a b) = mean(a) Delta(b) + Delta(a) mean(b)

So with the mean resultants n = N + i Q and M of both ends the force mean(exp(i phi)) n belongs to r', the moment
n . (Delta exp(-i phi)/Delta phi) mean(r') to phi, and M to phi'.  Kernels work element by element and point by
point; the three nodes of an element e have the unknowns 6 e to 6 e + 8.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from oblique_impact.kernels.band_rows import BANDWIDTH
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array

#: unknowns of a node: x, y, phi
NODE = 3
#: rotations within a step below which the divided difference is a series: the quotient would lose digits
_SMALL = 1e-2
#: `BeamData.sections`: axial, shear and bending stiffness, weight of the point
AXIAL, SHEAR, BENDING, WEIGHT = range(4)
# a state at a Gauss point: x', y', phi', cosine and sine of phi, phi, extension, shear
X_SLOPE, Y_SLOPE, CURVATURE, COSINE, SINE, ROTATION, EXTENSION, SHEARING = range(8)
FIELDS = 8


class BeamData(NamedTuple):
    """The discretized beam, as kernels read it; constant during a run."""

    x: Array  # (n,) m, of the nodes
    shapes: Array  # (elements, 2, 3) values of the three nodes' functions at Gauss points
    slopes: Array  # (elements, 2, 3) 1/m, their derivatives
    sections: Array  # (elements, 2, 4) at Gauss points, see above
    mass: Array  # (n, 5) kg: entries (i, i - 2) to (i, i + 2), of x and of y
    rotary: Array  # (n, 5) kg m^2, of phi


@inlined
def divided_difference(turn0: complex, turn1: complex, step: float) -> tuple[complex, complex]:
    """(exp(i phi1) - exp(i phi0))/(phi1 - phi0), and its derivative by phi1; `step` is phi1 - phi0."""
    if abs(step) >= _SMALL:
        quotient = (turn1 - turn0) / step
        return quotient, (1j * turn1 - quotient) / step
    square = step * step
    # 2 sin(step/2)/step with its derivative; cos(step/2) turns the mean into exp(i (phi0 + phi1)/2)
    ratio, rate = 1.0 - square / 24.0 + square * square / 1920.0, step * (square / 480.0 - 1.0 / 12.0)
    middle = 0.5j * (turn0 + turn1) / (1.0 - square / 8.0 + square * square / 384.0)
    return middle * ratio, middle * (0.5j * ratio + rate)


@jitable
def take_fields(beam: BeamData, q: Array, fields: Array) -> None:
    """Put the state at all Gauss points into `fields` (elements, 2, 8)."""
    for e in range(fields.shape[0]):
        k = 2 * NODE * e
        for g in range(2):
            h, d, f = beam.shapes[e, g], beam.slopes[e, g], fields[e, g]
            x = d[0] * q[k] + d[1] * q[k + 3] + d[2] * q[k + 6]
            y = d[0] * q[k + 1] + d[1] * q[k + 4] + d[2] * q[k + 7]
            phi = h[0] * q[k + 2] + h[1] * q[k + 5] + h[2] * q[k + 8]
            c, s = np.cos(phi), np.sin(phi)
            f[X_SLOPE], f[Y_SLOPE], f[COSINE], f[SINE], f[ROTATION] = x, y, c, s, phi
            f[CURVATURE] = d[0] * q[k + 2] + d[1] * q[k + 5] + d[2] * q[k + 8]
            f[EXTENSION], f[SHEARING] = c * x + s * y - 1.0, c * y - s * x


@inlined
def mean_resultants(s: Array, f0: Array, f1: Array, relaxation: float) -> tuple[complex, float]:
    """Force N + i Q (N) and moment (N m) of a step at a Gauss point between two states.

    Kelvin-Voigt damping gives them `relaxation` times those of the change of the strains besides.
    """
    before, after = 0.5 - relaxation, 0.5 + relaxation
    axial = s[AXIAL] * (before * f0[EXTENSION] + after * f1[EXTENSION])
    shear = s[SHEAR] * (before * f0[SHEARING] + after * f1[SHEARING])
    return complex(axial, shear), s[BENDING] * (before * f0[CURVATURE] + after * f1[CURVATURE])


class StepMeans(NamedTuple):
    """Means of a step at a Gauss point, of which its forces are products."""

    turn: complex  # of exp(i phi)
    slope: complex  # of r'
    quotient: complex  # of exp(i phi) over phi, see `divided_difference`
    rate: complex  # its derivative by phi at the end
    force: complex  # N + i Q (N)
    moment: float  # N m


@inlined
def means_of(s: Array, f0: Array, f1: Array, relaxation: float) -> StepMeans:
    """Return the means of a step at a Gauss point between two states."""
    turn0, turn1 = complex(f0[COSINE], f0[SINE]), complex(f1[COSINE], f1[SINE])
    quotient, rate = divided_difference(turn0, turn1, f1[ROTATION] - f0[ROTATION])
    force, moment = mean_resultants(s, f0, f1, relaxation)
    slope = complex(0.5 * (f0[X_SLOPE] + f1[X_SLOPE]), 0.5 * (f0[Y_SLOPE] + f1[Y_SLOPE]))
    return StepMeans(0.5 * (turn0 + turn1), slope, quotient, rate, force, moment)


@jitable
def add_forces(beam: BeamData, begun: Array, ended: Array, relaxation: float, forces: Array) -> None:
    """Add the internal forces of a step between two states at Gauss points to `forces` (3 n,)."""
    for e in range(begun.shape[0]):
        k = 2 * NODE * e
        for g in range(2):
            s = beam.sections[e, g]
            mean = means_of(s, begun[e, g], ended[e, g], relaxation)
            force, pushed = s[WEIGHT] * mean.turn * mean.force, mean.force * mean.quotient
            turning = s[WEIGHT] * (pushed.real * mean.slope.real + pushed.imag * mean.slope.imag)
            bending = s[WEIGHT] * mean.moment
            for a in range(3):
                h, d = beam.shapes[e, g, a], beam.slopes[e, g, a]
                forces[k + 3 * a] += d * force.real
                forces[k + 3 * a + 1] += d * force.imag
                forces[k + 3 * a + 2] += h * turning + d * bending


@jitable
def add_tangent(beam: BeamData, begun: Array, ended: Array, relaxation: float, rows: Array) -> None:
    """Add the derivatives of these forces by the end of the step to a band matrix by rows (3 n + 8, 17)."""
    share = 0.5 + relaxation
    for e in range(begun.shape[0]):
        k = 2 * NODE * e
        for g in range(2):
            f1, s = ended[e, g], beam.sections[e, g]
            mean, turn, w = means_of(s, begun[e, g], f1, relaxation), complex(f1[COSINE], f1[SINE]), s[WEIGHT]
            back = turn.conjugate()
            # derivatives of the strain by x', y' and phi, then of the resultants, forces and moment
            by_phi = -1j * back * complex(f1[X_SLOPE], f1[Y_SLOPE])
            n_x = share * complex(s[AXIAL] * back.real, s[SHEAR] * back.imag)
            n_y = share * complex(-s[AXIAL] * back.imag, s[SHEAR] * back.real)
            n_phi = share * complex(s[AXIAL] * by_phi.real, s[SHEAR] * by_phi.imag)
            f_x, f_y = w * mean.turn * n_x, w * mean.turn * n_y
            f_phi = w * (mean.turn * n_phi + 0.5j * turn * mean.force)
            along, pushed = mean.slope.conjugate(), mean.force * mean.quotient
            m_x = w * ((n_x * mean.quotient * along).real + 0.5 * pushed.real)
            m_y = w * ((n_y * mean.quotient * along).real + 0.5 * pushed.imag)
            m_phi = w * ((n_phi * mean.quotient + mean.force * mean.rate) * along).real
            bending = w * share * s[BENDING]
            for a in range(3):
                ha, da, i = beam.shapes[e, g, a], beam.slopes[e, g, a], k + 3 * a
                for b in range(3):
                    hb, db, j = beam.shapes[e, g, b], beam.slopes[e, g, b], 3 * (b - a) + BANDWIDTH
                    dd, dh, hd = da * db, da * hb, ha * db
                    rows[i, j] += dd * f_x.real
                    rows[i, j + 1] += dd * f_y.real
                    rows[i, j + 2] += dh * f_phi.real
                    rows[i + 1, j - 1] += dd * f_x.imag
                    rows[i + 1, j] += dd * f_y.imag
                    rows[i + 1, j + 1] += dh * f_phi.imag
                    rows[i + 2, j - 2] += hd * m_x
                    rows[i + 2, j - 1] += hd * m_y
                    rows[i + 2, j] += ha * hb * m_phi + dd * bending


@jitable
def add_inertia(beam: BeamData, factor: float, x: Array, product: Array) -> None:
    """Add `factor` times the product of the mass matrix with x (3 n,) to `product` (3 n,)."""
    n = beam.x.shape[0]
    for i in range(n):
        for j in range(max(0, i - 2), min(n, i + 3)):
            mass, rotary = factor * beam.mass[i, j - i + 2], factor * beam.rotary[i, j - i + 2]
            product[3 * i] += mass * x[3 * j]
            product[3 * i + 1] += mass * x[3 * j + 1]
            product[3 * i + 2] += rotary * x[3 * j + 2]


@jitable
def set_to_inertia(beam: BeamData, factor: float, rows: Array) -> None:
    """Set a band matrix by rows (3 n, 17) to `factor` times the mass matrix."""
    rows[:, :] = 0.0
    for i in range(beam.x.shape[0]):
        for j in range(5):
            at, mass = BANDWIDTH + 3 * (j - 2), factor * beam.mass[i, j]
            rows[3 * i, at], rows[3 * i + 1, at] = mass, mass
            rows[3 * i + 2, at] = factor * beam.rotary[i, j]


@jitable
def damping_loss(beam: BeamData, begun: Array, ended: Array, relaxation: float) -> float:
    """Energy (J) that Kelvin-Voigt damping takes in a step between two states at Gauss points."""
    lost = 0.0
    for e in range(begun.shape[0]):
        for g in range(2):
            f0, f1, s = begun[e, g], ended[e, g], beam.sections[e, g]
            extended, sheared = f1[EXTENSION] - f0[EXTENSION], f1[SHEARING] - f0[SHEARING]
            bent = f1[CURVATURE] - f0[CURVATURE]
            density = s[AXIAL] * extended**2 + s[SHEAR] * sheared**2 + s[BENDING] * bent**2
            lost += s[WEIGHT] * density
    return relaxation * lost
