"""Internal forces of the exact beam over a step, whose work is the change of its strain energy, exactly.

The strain exp(-i phi) r' is a product, and for differences and means over the step the rule of products is

    Delta(a b) = mean(a) Delta(b) + Delta(a) mean(b)

Over a step with the mid-point rule a rigid body turns by the angle Delta phi whose turn

    theta = 2 tan(Delta phi/2),      Delta exp(i phi) = i theta mean(exp(i phi))

is h times its mean angular velocity.  So with the mean resultants n = N + i Q and M of both ends the force
mean(exp(i phi)) n belongs to r', the moment n . (-i mean(exp(-i phi)) mean(r')) to theta, and M to phi'.  Moments
belong to the turns of an element's nodes.  With ratios of differences, which are smooth,

    theta(x) = sum of w_a theta_a,  sum of w_a = 1         Delta phi'(x) = sum of b_a theta_a,  sum of b_a = 0

exactly: a rigid turn of the whole does no work, so that angular momentum is conserved with the energy.

Kernels work element by element and point by point; the three nodes of an element e have the unknowns 6 e to
6 e + 8.
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


@inlined
def turn_of(angle: float) -> float:
    """Return 2 tan(angle/2), h times the mean angular velocity of a step that turns by an angle (rad)."""
    square = angle * angle
    if abs(angle) < _SMALL:
        return angle * (1.0 + square / 12.0 + square * square / 120.0)
    return float(2.0 * np.tan(0.5 * angle))


@inlined
def angle_of(turn: float) -> float:
    """Angle (rad) of a turn."""
    return float(2.0 * np.arctan(0.5 * turn))


@inlined
def turn_ratio(angle: float) -> tuple[float, float]:
    """Turn over angle (rad), and its derivative by the angle."""
    square = angle * angle
    if abs(angle) < _SMALL:
        return 1.0 + square / 12.0 + square * square / 120.0, angle * (1.0 / 6.0 + square / 30.0)
    ratio = turn_of(angle) / angle
    return ratio, (1.0 + 0.25 * turn_of(angle) ** 2 - ratio) / angle


@inlined
def _cosine(angle: float) -> float:
    """Cosine of half of an angle (rad)."""
    square = angle * angle
    if abs(angle) < _SMALL:
        return 1.0 - square / 8.0 + square * square / 384.0
    return float(np.cos(0.5 * angle))


@inlined
def _chord(angle: float) -> tuple[float, float]:
    """2 sin(angle/2)/angle, and the derivative of its logarithm."""
    square = angle * angle
    if abs(angle) < _SMALL:
        return 1.0 - square / 24.0 + square * square / 1920.0, -angle * (1.0 / 12.0 + square / 720.0)
    return float(2.0 * np.sin(0.5 * angle) / angle), float(0.5 / np.tan(0.5 * angle) - 1.0 / angle)


Three = tuple[float, float, float]


@inlined
def weights_of(h: Array, d: Array, first: float, middle: float, last: float) -> tuple[Three, Three]:
    """Shares w_a and b_a (1/m) of the turns of an element's nodes at a Gauss point, with their functions there.

    The nodes turn by the angles `first`, `middle` and `last` (rad).
    """
    here = h[0] * first + h[1] * middle + h[2] * last
    own, _ = _chord(here - middle)
    chord0, _ = _chord(first - middle)
    chord2, _ = _chord(last - middle)
    c0, c1, c2 = _cosine(first) / chord0, _cosine(middle), _cosine(last) / chord2
    common = own / _cosine(here)
    w0, w2, b0, b2 = h[0] * c0 * common, h[2] * c2 * common, d[0] * c0 * c1, d[2] * c2 * c1
    return (w0, 1.0 - w0 - w2, w2), (b0, -b0 - b2, b2)


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
    quotient: complex  # of exp(i phi) over the turn
    rate: complex  # its derivative by phi at the end
    force: complex  # N + i Q (N)
    moment: float  # N m


@inlined
def means_of(s: Array, f0: Array, f1: Array, relaxation: float) -> StepMeans:
    """Return the means of a step at a Gauss point between two states."""
    turn0, turn1 = complex(f0[COSINE], f0[SINE]), complex(f1[COSINE], f1[SINE])
    turn = 0.5 * (turn0 + turn1)
    force, moment = mean_resultants(s, f0, f1, relaxation)
    slope = complex(0.5 * (f0[X_SLOPE] + f1[X_SLOPE]), 0.5 * (f0[Y_SLOPE] + f1[Y_SLOPE]))
    return StepMeans(turn, slope, 1j * turn, -0.5 * turn1, force, moment)


@jitable
def add_forces(beam: BeamData, begun: Array, ended: Array, move: Array, relaxation: float, forces: Array) -> None:
    """Add the internal forces of a step between two states at Gauss points to `forces` (3 n,).

    `move` (3 n,) is that of the nodal values.  Moments are those that belong to turns.
    """
    for e in range(begun.shape[0]):
        k = 2 * NODE * e
        for g in range(2):
            s = beam.sections[e, g]
            mean = means_of(s, begun[e, g], ended[e, g], relaxation)
            force, pushed = s[WEIGHT] * mean.turn * mean.force, mean.force * mean.quotient
            turning = s[WEIGHT] * (pushed.real * mean.slope.real + pushed.imag * mean.slope.imag)
            bending = s[WEIGHT] * mean.moment
            turns, bends = weights_of(beam.shapes[e, g], beam.slopes[e, g], move[k + 2], move[k + 5], move[k + 8])
            for a in range(3):
                d = beam.slopes[e, g, a]
                forces[k + 3 * a] += d * force.real
                forces[k + 3 * a + 1] += d * force.imag
                forces[k + 3 * a + 2] += turns[a] * turning + bends[a] * bending


@jitable
def add_tangent(beam: BeamData, begun: Array, ended: Array, move: Array, relaxation: float, rows: Array) -> None:
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
            h, d, first, middle, last = beam.shapes[e, g], beam.slopes[e, g], move[k + 2], move[k + 5], move[k + 8]
            turns, bends = weights_of(h, d, first, middle, last)
            turning = w * (pushed.real * mean.slope.real + pushed.imag * mean.slope.imag)
            _add_weights(h, (first, middle, last), turns, bends, (turning, w * mean.moment), rows[k:])
            for a in range(3):
                ha, ba, da, i = turns[a], bends[a], beam.slopes[e, g, a], k + 3 * a
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
                    rows[i + 2, j] += ha * hb * m_phi + ba * db * bending


@inlined
def _add_weights(
    h: Array, angles: Three, turns: Three, bends: Three, moments: tuple[float, float], rows: Array
) -> None:
    """Add what the derivatives of an element's weights by angles do to its moments, in its rows of the band.

    `moments` are those of theta and of phi'.
    """
    first, middle, last = angles
    here, (turning, bending) = h[0] * first + h[1] * middle + h[2] * last, moments
    _, growth = _chord(here - middle)
    _, growth0 = _chord(first - middle)
    _, growth2 = _chord(last - middle)
    # halves of the tangents of half angles, with which logarithms of cosines fall
    along, fall0, fall1, fall2 = 0.25 * turn_of(here) + growth, turn_of(first), turn_of(middle), turn_of(last)
    w0, w2, b0, b2 = turning * turns[0], turning * turns[2], bending * bends[0], bending * bends[2]
    own0, own2 = 0.25 * fall0 + growth0, 0.25 * fall2 + growth2
    # moments of the nodes 0 and 2, and of the middle less these, by the three angles
    by0 = w0 * h[0] * along - (w0 + b0) * own0, w0 * (h[1] * along - growth + growth0), w0 * h[2] * along
    by2 = w2 * h[0] * along, w2 * (h[1] * along - growth + growth2), w2 * h[2] * along - (w2 + b2) * own2
    bent0, bent2 = b0 * (growth0 - 0.25 * fall1), b2 * (growth2 - 0.25 * fall1)
    for b in range(3):
        j = BANDWIDTH + 3 * b
        one, other = by0[b] + (bent0 if b == 1 else 0.0), by2[b] + (bent2 if b == 1 else 0.0)
        rows[2, j] += one
        rows[5, j - 3] -= one + other
        rows[8, j - 6] += other


@jitable
def turn_forces(move: Array, forces: Array) -> None:
    """Make moments that belong to turns of the nodes (3 n,) into those that belong to their angles."""
    for j in range(2, forces.shape[0], NODE):
        ratio, _ = turn_ratio(move[j])
        forces[j] *= ratio


@jitable
def turn_rows(move: Array, forces: Array, rows: Array) -> None:
    """Make rows of moments, which are `forces` (3 n,), into those of moments that belong to angles."""
    for j in range(2, forces.shape[0], NODE):
        ratio, growth = turn_ratio(move[j])
        for k in range(rows.shape[1]):
            rows[j, k] *= ratio
        rows[j, BANDWIDTH] += growth * forces[j]


@jitable
def turn_inertia(move: Array, rows: Array) -> None:
    """Make columns of rotary inertia, in a band matrix of inertia by rows, of turns into those of angles."""
    n = move.shape[0]
    for j in range(2, n, NODE):
        growth = 1.0 + 0.25 * turn_of(move[j]) ** 2
        for k in range(-2, 3):
            i = j + NODE * k
            if 0 <= i < n:
                rows[i, BANDWIDTH - NODE * k] *= growth


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
