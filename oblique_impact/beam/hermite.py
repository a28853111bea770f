"""The axis of the bent beam in all nodes of a mesh: cubics on elements, n deflections and slopes of nodes.

The coordinates are deflection and slope in the floating frame, node by node.  The beam is shortened by the slopes
of all elements before a place; what these give is summed once for all places.  On an element z goes from -1 to 1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from oblique_impact.beam.axis import AxisPoint, SectionMotion, panel_of
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import SCRATCH_A, SCRATCH_B, SHORTENING_PRODUCT, Array

Four = tuple[float, float, float, float]


class _Mesh(NamedTuple):
    """Nodes of a mesh, and integrals up to them of the slopes of the bent axis, see `Shapes.bend`."""

    edges: Array  # (elements + 1,) m, ascending from 0
    squares: Array  # (elements + 1,) of u_y'^2 (m)
    rates: Array  # (elements + 1,) of u_y' u_y'^.
    turns: Array  # (elements + 1,) of u_y'^.^2
    product: Array  # (n + 1,) H B of the whole beam, behind the entry of theta


@inlined
def _cubic(s: HermiteShapes, element: int, B: Array) -> Four:
    """Coefficients of the deflection (m) on an element over powers of z."""
    half, k = 0.5 * (s.edges[element + 1] - s.edges[element]), 2 * element
    first, last, steep, steeper = B[k], B[k + 2], half * B[k + 1], half * B[k + 3]
    return (
        0.5 * (first + last) + 0.25 * (steep - steeper),
        0.75 * (last - first) - 0.25 * (steep + steeper),
        0.25 * (steeper - steep),
        0.25 * (first - last) + 0.25 * (steep + steeper),
    )


@inlined
def _shape(which: int, half: float) -> Four:
    """Coefficients of a shape function of an element: deflection and slope at its start, then at its end."""
    if which == 0:
        return 0.5, -0.75, 0.0, 0.25
    if which == 1:
        return 0.25 * half, -0.25 * half, -0.25 * half, 0.25 * half
    if which == 2:
        return 0.5, 0.75, 0.0, -0.25
    return -0.25 * half, -0.25 * half, 0.25 * half, 0.25 * half


@inlined
def _value(p: Four, z: float) -> float:
    return p[0] + z * (p[1] + z * (p[2] + z * p[3]))


@inlined
def _rate(p: Four, z: float) -> float:
    """Evaluate the derivative over z."""
    return p[1] + z * (2.0 * p[2] + z * 3.0 * p[3])


@inlined
def _overlap(p: Four, r: Four, z: float) -> float:
    """Integral from -1 to z of the product of two derivatives over z."""
    a, b, c = p[1] * r[1], 2.0 * (p[1] * r[2] + p[2] * r[1]), 3.0 * (p[1] * r[3] + p[3] * r[1]) + 4.0 * p[2] * r[2]
    d, e = 6.0 * (p[2] * r[3] + p[3] * r[2]), 9.0 * p[3] * r[3]
    b, c, d, e = b / 2.0, c * (1.0 / 3.0), d / 4.0, e * (1.0 / 5.0)  # products are quicker than quotients
    return z * (a + z * (b + z * (c + z * (d + z * e)))) + a - b + c - d + e


@inlined
def _whole(s: HermiteShapes, element: int, B: Array) -> Four:
    """Integrals over an element of u_y' times the derivatives of its four shape functions, see `_shape`."""
    length, k = s.edges[element + 1] - s.edges[element], 2 * element
    fall, steep, steeper = B[k] - B[k + 2], length * B[k + 1], length * B[k + 3]
    force = (1.2 * fall + 0.1 * (steep + steeper)) / length
    first, last = 3.0 * fall + 4.0 * steep - steeper, 3.0 * fall - steep + 4.0 * steeper
    return force, first * (1.0 / 30.0), -force, last * (1.0 / 30.0)


@inlined
def _times(f: Four, element: int, B: Array) -> float:
    """Product with deflections and slopes of the ends of an element."""
    k = 2 * element
    return float(f[0] * (B[k] - B[k + 2]) + f[1] * B[k + 1] + f[3] * B[k + 3])


@jitable
def _bend(s: HermiteShapes, B: Array, Bd: Array) -> None:
    """Take the integrals, see `oblique_impact.beam.axis.Shapes`."""
    s.product[1], s.product[2] = 0.0, 0.0
    for k in range(s.edges.shape[0] - 1):
        f, rate = _whole(s, k, B), _whole(s, k, Bd)
        square, mixed, turn = _times(f, k, B), _times(f, k, Bd), _times(rate, k, Bd)
        s.product[2 * k + 1] += f[0]
        s.product[2 * k + 2] += f[1]
        s.product[2 * k + 3], s.product[2 * k + 4] = f[2], f[3]
        s.squares[k + 1] = s.squares[k] + square
        s.rates[k + 1] = s.rates[k] + mixed
        s.turns[k + 1] = s.turns[k] + turn


@jitable
def _bent_axis(s: HermiteShapes, x: float, B: Array) -> AxisPoint:
    """Bend the axis, see `oblique_impact.beam.axis.Shapes`."""
    element = panel_of(s.edges, x)
    half = 0.5 * (s.edges[element + 1] - s.edges[element])
    inside = min(max(x, s.edges[0]), s.edges[-1])
    part = 1.0 / half  # one quotient for all
    z, beyond = (inside - s.edges[element]) * part - 1.0, x - inside
    p = _cubic(s, element, B)
    squared = s.squares[element] + _overlap(p, p, z) * part
    slope, curvature = _rate(p, z) * part, (2.0 * p[2] + 6.0 * p[3] * z) * part * part
    if beyond != 0.0:
        curvature = 0.0
    shortening = 0.5 * (squared + slope * slope * beyond)
    return AxisPoint(-shortening, _value(p, z) + slope * beyond, slope, curvature, element, z, beyond)


@jitable
def _motion_at(s: HermiteShapes, axis: AxisPoint, B: Array, Bd: Array) -> tuple[SectionMotion, float]:
    """Motion of a section, see `oblique_impact.beam.axis.Shapes`."""
    k, z, beyond = axis.panel, axis.z, axis.beyond
    part, p, rate = 2.0 / (s.edges[k + 1] - s.edges[k]), _cubic(s, k, B), _cubic(s, k, Bd)
    slope_rate, curvature_rate = _rate(rate, z) * part, (2.0 * rate[2] + 6.0 * rate[3] * z) * part * part
    u_x_rate = -(s.rates[k] + _overlap(p, rate, z) * part + axis.slope * slope_rate * beyond)
    u_x_bias = -(s.turns[k] + _overlap(rate, rate, z) * part + slope_rate * slope_rate * beyond)
    u_y_rate = _value(rate, z) + slope_rate * beyond
    if beyond != 0.0:
        curvature_rate = 0.0
    motion = SectionMotion(axis.u_x, axis.u_y, axis.slope, u_x_rate, u_y_rate, slope_rate, u_x_bias)
    return motion, curvature_rate


@jitable
def _take_shapes(s: HermiteShapes, axis: AxisPoint, B: Array, v: Array) -> None:
    """Take shape functions at a place, see `oblique_impact.beam.axis.Shapes`."""
    shapes, slopes, HB, k, z = v[SCRATCH_A], v[SCRATCH_B], v[SHORTENING_PRODUCT], axis.panel, axis.z
    for i in range(B.shape[0] + 1):
        shapes[i], slopes[i], HB[i] = 0.0, 0.0, 0.0
    for i in range(2 * k + 1):
        HB[i] = s.product[i]
    if k > 0:
        f = _whole(s, k - 1, B)
        HB[2 * k + 1], HB[2 * k + 2] = f[2], f[3]
    half, p = 0.5 * (s.edges[k + 1] - s.edges[k]), _cubic(s, k, B)
    for which in range(4):
        i, shape = 2 * k + 1 + which, _shape(which, half)
        slopes[i] = _rate(shape, z) / half
        shapes[i] = _value(shape, z) + slopes[i] * axis.beyond
        HB[i] += _overlap(shape, p, z) / half + axis.slope * slopes[i] * axis.beyond


class HermiteShapes(_Mesh):
    """Cubic Hermite functions on the elements of a mesh."""

    __slots__ = ()
    bend = _bend
    bent_axis = _bent_axis
    motion_at = _motion_at
    take_shapes = _take_shapes

    @classmethod
    def on(cls, edges: Array) -> HermiteShapes:
        """Return those of a straight beam between nodes (elements + 1,), m."""
        n = edges.size
        return cls(edges, np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(2 * n + 1))
