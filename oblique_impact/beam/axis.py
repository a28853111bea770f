"""The axis of the bent beam at any place along it: shape functions as polynomials on panels.

A contact that slides along the beam needs u_y = Phi(x) B and u_x = -B^T H(x) B/2 wherever it is.  Modes of finite
elements are cubics on the elements; eigenfunctions are interpolated on panels so short that polynomials of the
degree 11 hold them to rounding.  All nodes of a mesh have the cubics of :mod:`oblique_impact.beam.hermite`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from oblique_impact.kernels.jit import compiled_protocol, inlined, jitable
from oblique_impact.kernels.workspace import SCRATCH_A, SCRATCH_B, SHORTENING_PRODUCT, Array, record_of

if TYPE_CHECKING:
    from oblique_impact.contact.state import Candidate

_PLACED = 1e-15  # of lengths, the last step of Newton's method for a place: a few units of rounding
#: the error of a polynomial of this degree on a panel of half a wave number (rad) is 2e-16 of the function
_DEGREE, _HALF_PANEL = 11, 0.5


class AxisPoint(NamedTuple):
    """The bent axis at a place, in the frame: r = (radius + x + u_x, u_y) (m)."""

    u_x: float
    u_y: float
    slope: float  # u_y' = Phi' B
    curvature: float  # u_y'' (1/m)
    panel: int
    z: float  # place in the panel
    beyond: float  # m, how far the place is past an end of the beam, from which its tangent goes on


@compiled_protocol
class Shapes(Protocol):
    """Shape functions of a beam at any place along it."""

    def bend(self, B: Array, Bd: Array) -> None:
        """Take what the other methods have in common at all places in a state."""

    def bent_axis(self, x: float, B: Array) -> AxisPoint:
        """Displacements, slope and curvature of the axis at x (m)."""

    def take_shapes(self, axis: AxisPoint, B: Array, Bd: Array, v: Array) -> tuple[float, float]:
        """Shape functions and slopes at a place, into rows of `Workspace.vectors` behind the entry of theta.

        These are `SCRATCH_A` and `SCRATCH_B`; H B goes into `SHORTENING_PRODUCT`.
        Returns B'^T H B' and u_y'' of the velocities.
        """


class _PanelData(NamedTuple):
    """Shape functions on panels, each a polynomial in z from -1 to 1; n functions."""

    edges: Array  # (panels + 1,) m, ascending from 0
    coefficients: Array  # (panels, degree + 1, n) of powers of z
    shortening: Array  # (panels + 1, n, n) H at the edges (1/m)
    nodes: Array  # (degree,) of Gauss's rule, exact for products of two slopes
    weights: Array
    polynomial: Array  # (degree + 1,) of the deflection around a place, which methods overwrite


def fit_shapes(evaluate: Callable[[Array], Array], edges: Array, degree: int) -> AxisShapes:
    """Interpolate the shape functions `evaluate(x)`, (points,) -> (points, n), between the edges (m)."""
    z = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
    to_powers = np.linalg.inv(np.vander(z, increasing=True))
    half, middle = 0.5 * np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    values = evaluate((middle[:, None] + half[:, None] * z).ravel()).reshape(half.size, degree + 1, -1)
    coefficients = to_powers @ values
    nodes, weights = np.polynomial.legendre.leggauss(degree)
    powers = np.vander(nodes, degree, increasing=True) * np.arange(1, degree + 1)  # derivatives of z, z^2, ...
    slopes = powers @ coefficients[:, 1:] / half[:, None, None]
    parts = np.einsum("pgi,pgj,g,p->pij", slopes, slopes, weights, half)
    shortening = np.concatenate([np.zeros_like(parts[:1]), np.cumsum(parts, axis=0)])
    return AxisShapes(
        np.ascontiguousarray(edges),
        np.ascontiguousarray(coefficients),
        shortening,
        nodes,
        weights,
        np.zeros(degree + 1),
    )


@dataclass(frozen=True)
class ShapeFunctions:
    """The n shape functions of a beam at any place, and the panels on which polynomials hold them to rounding."""

    derivative: Callable[[Array, int], Array]  # of an order 0 or 1 at places (m): (points,) -> (points, n)
    edges: Array  # (panels + 1,) m
    degree: int

    @classmethod
    def smooth(
        cls, derivative: Callable[[Array, int], Array], length: float, wave_number: float
    ) -> ShapeFunctions:
        """Take smooth functions of at most this wave number (rad/m) on equal panels."""
        panels = int(np.ceil(0.5 * wave_number * length / _HALF_PANEL))
        return cls(derivative, np.linspace(0.0, length, max(panels, 2) + 1), _DEGREE)

    def at(self, x: float) -> tuple[Array, Array, Array]:
        """Return the functions and their slopes at a place (m), each (n,), and H (n, n) up to there."""
        edges = np.append(self.edges[self.edges < x], x)
        nodes, weights = np.polynomial.legendre.leggauss(self.degree)  # exact for products of two slopes
        half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
        slopes = self.derivative((middle + half * nodes).ravel(), 1)
        shortening = (slopes.T * (half * weights).ravel()) @ slopes
        place = np.array([x])
        return self.derivative(place, 0)[0], self.derivative(place, 1)[0], shortening

    def fitted(self) -> AxisShapes:
        """Return the polynomials."""
        return fit_shapes(lambda x: self.derivative(x, 0), self.edges, self.degree)


@jitable
def panel_of(edges: Array, x: float) -> int:
    """Panel that holds x; beyond the ends the nearest."""
    low, high = 0, edges.shape[0] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if x < edges[middle]:
            high = middle
        else:
            low = middle
    return low


@jitable
def _bend(s: AxisShapes, B: Array, Bd: Array) -> None:
    """Do nothing: the integrals of products of slopes up to the panels are constant."""


@jitable
def _contract(s: AxisShapes, panel: int, B: Array, polynomial: Array) -> None:
    """Coefficients of u_y = Phi B on a panel into `polynomial` (degree + 1,)."""
    for k in range(s.coefficients.shape[1]):
        total = 0.0
        for i in range(B.shape[0]):
            total += s.coefficients[panel, k, i] * B[i]
        polynomial[k] = total


@inlined
def _slope_at(s: AxisShapes, polynomial: Array, z: float) -> float:
    """Evaluate the derivative over z of a polynomial on a panel."""
    total = 0.0
    for k in range(s.coefficients.shape[1] - 1, 0, -1):
        total = total * z + k * polynomial[k]
    return total


@jitable
def _bent_axis(s: AxisShapes, x: float, B: Array) -> AxisPoint:
    """Bend the axis, see `Shapes`."""
    polynomial = s.polynomial
    panel = panel_of(s.edges, x)
    a, half = s.edges[panel], 0.5 * (s.edges[panel + 1] - s.edges[panel])
    inside = min(max(x, s.edges[0]), s.edges[-1])
    z, beyond = (inside - a) / half - 1.0, x - inside
    _contract(s, panel, B, polynomial)
    value, slope, bending = 0.0, 0.0, 0.0
    for k in range(s.coefficients.shape[1] - 1, -1, -1):
        bending = bending * z + 2.0 * slope
        slope = slope * z + value
        value = value * z + polynomial[k]
    squared = 0.0
    for i in range(B.shape[0]):
        for j in range(B.shape[0]):
            squared += B[i] * s.shortening[panel, i, j] * B[j]
    part = 0.5 * (z + 1.0)
    for g in range(s.nodes.shape[0]):
        steep = _slope_at(s, polynomial, part * (s.nodes[g] + 1.0) - 1.0)
        squared += s.weights[g] * part * steep * steep / half
    slope /= half
    if beyond != 0.0:
        bending = 0.0
    return AxisPoint(
        -0.5 * (squared + slope * slope * beyond),
        value + slope * beyond,
        slope,
        bending / (half * half),
        panel,
        z,
        beyond,
    )


#: a place of the beam that can touch a side (`on_side`), or a point fixed in space that can touch the beam, a peg
PLACE = np.dtype(
    [
        ("on_side", np.int64),
        ("x", float),  # m along the beam; of a peg in space
        ("y", float),  # m, of a peg
        ("angle", float),  # rad, of the side
        ("normal_offset", float),  # m, of a point of the side from the root's axis, across the side
        ("tangential_offset", float),  # m, along it
        ("fibre", float),  # m across the beam from its axis, of the point that touches
        ("turning", float),  # the same, or 0 where terms of second order are left out
        # of pegs: distance (m) from the axis at which it touches, its radius and, of the beam's face, half the
        # depth; half the depth where friction acts on the beam's face, 0 on the axis; and the side on which the
        # beam is of it, seen along the beam: 1 left, -1 right
        ("distance", float),
        ("lever", float),
        ("side", float),
    ],
    align=True,
)


def place_record(on_side: bool, numbers: Sequence[float]) -> Any:
    """Return a record of `PLACE`.

    `numbers` (6,) of a place of the beam are x, angle, both offsets, fibre and turning; of a peg x, y, distance,
    lever and side, and one that is not used.
    """
    names = ("x", "angle", "normal_offset", "tangential_offset", "fibre", "turning")
    of_peg = ("x", "y", "distance", "lever", "side", "turning")
    return record_of(PLACE, dict(zip(names if on_side else of_peg, numbers, strict=True)) | {"on_side": on_side})


class Places(NamedTuple):
    """Places at which the beam can touch obstacles."""

    each: Any  # (places,) records of `PLACE`
    #: of places of the beam, which stay where they are along it: H (1/m), shape functions, their slopes
    tables: Array  # (places, n + 2, n)
    shapes: AxisShapes | None  # None: there are no pegs


@jitable
def place_of(s: Any, radius: float, X: float, Y: float, B: Array) -> tuple[float, AxisPoint]:
    """Place (m) along the beam where the normal of the axis goes through the point (X, Y) of the frame.

    Newton's method on (r(x) - c).r'(x) = 0, from the place of the undeformed beam; some four steps are usual.  A
    step that has not halved the last one, or leads out of the bracket, gives way to the middle of the bracket; the
    tangents at the ends of the beam go on for ever, so that there is one.  So steps or brackets halve until they
    are rounding; of a state that is no number the place is none.
    """
    x, low, high, last, placed = X - radius, -np.inf, np.inf, 4.0 * s.edges[-1], False
    rounding = _PLACED * (s.edges[-1] + abs(X) + abs(Y))
    while True:
        axis = s.bent_axis(x, B)
        along, across, steep = radius + x + axis.u_x - X, axis.u_y - Y, 1.0 - 0.5 * axis.slope * axis.slope
        value = along * steep + across * axis.slope
        rate = steep * steep + axis.slope * axis.slope + (across - along * axis.slope) * axis.curvature
        if placed or not abs(value) < np.inf:
            return x, axis
        if value > 0.0:
            high = x
        else:
            low = x
        step = -value / rate if rate > 0.0 else np.inf
        if not (abs(step) <= 0.5 * last and low <= x + step <= high):
            away = 2.0 * last if value < 0.0 else -2.0 * last
            step = 0.5 * (low + high) - x if high - low < np.inf else away
        x, last, placed = x + step, abs(step), abs(step) <= rounding


@jitable
def _take_shapes(s: AxisShapes, axis: AxisPoint, B: Array, Bd: Array, v: Array) -> tuple[float, float]:
    """Take shape functions at a place, see `Shapes`."""
    shapes, slopes, HB, polynomial = v[SCRATCH_A], v[SCRATCH_B], v[SHORTENING_PRODUCT], s.polynomial
    panel, z, n = axis.panel, axis.z, B.shape[0]
    half, part, bending, curving = 0.5 * (s.edges[panel + 1] - s.edges[panel]), 0.5 * (z + 1.0), 0.0, 0.0
    turning = 0.0
    for i in range(n):
        value, slope, curvature = 0.0, 0.0, 0.0
        for k in range(s.coefficients.shape[1] - 1, -1, -1):
            curvature = curvature * z + 2.0 * slope
            slope = slope * z + value
            value = value * z + s.coefficients[panel, k, i]
        slope /= half
        shapes[i + 1], slopes[i + 1] = value + slope * axis.beyond, slope
        curving += curvature / (half * half) * Bd[i]
        turning += slope * Bd[i]
        before, rate = 0.0, 0.0
        for j in range(n):
            before += s.shortening[panel, i, j] * B[j]
            rate += s.shortening[panel, i, j] * Bd[j]
        HB[i + 1] = before
        bending += Bd[i] * rate
    for g in range(s.nodes.shape[0]):
        at = part * (s.nodes[g] + 1.0) - 1.0
        weight, steep, rate = s.weights[g] * part / half, _slope_at(s, polynomial, at), 0.0
        for i in range(n):
            slope = 0.0
            for k in range(s.coefficients.shape[1] - 1, 0, -1):
                slope = slope * at + k * s.coefficients[panel, k, i]
            HB[i + 1] += weight * slope * steep
            rate += slope * Bd[i]
        bending += weight * rate * rate
    if axis.beyond != 0.0:
        for i in range(n):
            HB[i + 1] += axis.slope * slopes[i + 1] * axis.beyond
        bending += turning * turning * axis.beyond
        curving = 0.0
    return bending, curving


class AxisShapes(_PanelData):
    """Few shape functions, each of which spans the beam: those of modes."""

    __slots__ = ()
    bend = _bend
    bent_axis = _bent_axis
    take_shapes = _take_shapes


@jitable
def touch_peg(
    s: Any, radius: float, peg: Any, q: Array, qd: Array, v: Array, c: Candidate, normal: Array, tangential: Array
) -> None:
    """Gap, slip, biases and rows of a fixed point against the axis of a beam on a hub of this radius (m).

    The point c meets the axis at the place x where (r - c).r' = 0.  With t = r'/|r'|, its normal n on the side of
    the beam, the velocities v = q', the turning w of t towards n and the one u of the section,

        x'     = -(Jv.r' + (r - c).J'v) / (r'.r' + (r - c).r''),    w = (n.J'v + x' n.r'')/|r'|,  u = n.J'v/|r'|
        Z_n'   = n.Jv,           Z_n''   = n.(J q'' + Jdot v) + x' n.J'v - w t.Jv
        Z_tau' = t.Jv + e u,     Z_tau'' = t.(J q'' + Jdot v) + x' t.J'v + w n.Jv + e u'

    where J = dr/dq, primes of r and J are derivatives along the beam and e is the lever of friction.  The slip is
    -x, whose rate is that of the axis where the point touches it.
    """
    theta, spin, B, Bd = q[0], qd[0], q[1:], qd[1:]
    cosine, sine = np.cos(theta), np.sin(theta)
    X, Y = peg.x * cosine + peg.y * sine, peg.y * cosine - peg.x * sine
    x, axis = place_of(s, radius, X, Y, B)
    bending, curvature_rate = s.take_shapes(axis, B, Bd, v)
    shapes, slopes, HB = v[SCRATCH_A], v[SCRATCH_B], v[SHORTENING_PRODUCT]
    phi, kappa, steep, side = axis.slope, axis.curvature, 1.0 - 0.5 * axis.slope * axis.slope, peg.side
    stretch = np.sqrt(steep * steep + phi * phi)  # |r'|, 1 but for the fourth power of the slope
    tx, ty = steep / stretch, phi / stretch
    nx, ny = -side * ty, side * tx
    rx, ry = radius + x + axis.u_x, axis.u_y
    # rows, and velocities in the frame: of displacements, slope, place and turning
    ux_rate, uy_rate, phi_rate = 0.0, 0.0, 0.0
    normal[0] = ny * rx - nx * ry
    tangential[0] = ty * rx - tx * ry + peg.lever * (ny * steep - nx * phi) / stretch
    for i in range(B.shape[0]):
        shape, slope, shortened = shapes[i + 1], slopes[i + 1], HB[i + 1]
        ux_rate -= shortened * Bd[i]
        uy_rate += shape * Bd[i]
        phi_rate += slope * Bd[i]
        normal[i + 1] = ny * shape - nx * shortened
        tangential[i + 1] = ty * shape - tx * shortened + peg.lever * (ny - nx * phi) * slope / stretch
    vx, vy = ux_rate - spin * ry, uy_rate + spin * rx  # J v
    ax, ay = -phi * (spin + phi_rate), spin * steep + phi_rate  # J' v
    away_x, away_y, rx2, ry2 = rx - X, ry - Y, -phi * kappa, kappa
    place_rate = -(vx * steep + vy * phi + away_x * ax + away_y * ay) / (
        stretch * stretch + away_x * rx2 + away_y * ry2
    )
    turning = (nx * ax + ny * ay + place_rate * (nx * rx2 + ny * ry2)) / stretch
    # accelerations without q'': J dot v and J' dot v
    fx = -spin * spin * rx - 2.0 * spin * uy_rate - bending
    fy = -spin * spin * ry + 2.0 * spin * ux_rate
    gap_bias = nx * fx + ny * fy + place_rate * (nx * ax + ny * ay) - turning * (tx * vx + ty * vy)
    slip_bias = tx * fx + ty * fy + place_rate * (tx * ax + ty * ay) + turning * (nx * vx + ny * vy)
    if peg.lever != 0.0:
        gx = -spin * spin * steep - 2.0 * spin * phi_rate - phi_rate * phi_rate
        gy = -spin * spin * phi - 2.0 * spin * phi * phi_rate
        gx += place_rate * (-kappa * (spin + phi_rate) - phi * curvature_rate)
        gy += place_rate * (curvature_rate - spin * phi * kappa)
        rate = (nx * gx + ny * gy - turning * (tx * ax + ty * ay)) / stretch
        growth = tx * (ax + place_rate * rx2) + ty * (ay + place_rate * ry2)
        slip_bias += peg.lever * (rate - (nx * ax + ny * ay) * growth / (stretch * stretch))
    c.gap, c.slip = nx * away_x + ny * away_y - peg.distance, -x
    c.gap_bias, c.slip_bias = gap_bias, slip_bias
