"""The axis of the bent beam at any place along it, where points of the beam are, and which of them meet obstacles.

A contact that slides along the beam needs u_y = Phi(x) B and u_x = -B^T H(x) B/2 wherever it is.  Modes of finite
elements are cubics on the elements; eigenfunctions are interpolated on panels so short that polynomials of the
degree 11 hold them to rounding.  All nodes of a mesh have the cubics of :mod:`oblique_impact.beam.hermite`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from oblique_impact.contact.sides_and_pegs import (
    AxisMotion,
    Directions,
    Heading,
    PointMotion,
    centre_of,
    meet_peg,
    meet_side,
)
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


class SectionMotion(NamedTuple):
    """A cross-section of the beam and its motion in the floating frame."""

    u_x: float  # m, -B^T H B/2
    u_y: float  # m, Phi B
    slope: float  # phi = Phi' B
    u_x_rate: float  # m/s
    u_y_rate: float
    slope_rate: float  # 1/s
    u_x_bias: float  # m/s^2, -B'^T H B'


@compiled_protocol
class Shapes(Protocol):
    """Shape functions of a beam at any place along it."""

    def bend(self, B: Array, Bd: Array) -> None:
        """Take what the other methods have in common at all places in a state."""

    def bent_axis(self, x: float, B: Array) -> AxisPoint:
        """Displacements, slope and curvature of the axis at x (m)."""

    def motion_at(self, axis: AxisPoint, B: Array, Bd: Array) -> tuple[SectionMotion, float]:
        """Motion of the section at a place and rate of its curvature (1/(m s)).

        Like `take_shapes` it is for the place that `bent_axis` has had last.
        """

    def take_shapes(self, axis: AxisPoint, B: Array, v: Array) -> None:
        """Shape functions and slopes at a place, into rows of `Workspace.vectors` behind the entry of theta.

        These are `SCRATCH_A` and `SCRATCH_B`; H B goes into `SHORTENING_PRODUCT`.
        """


class _PanelData(NamedTuple):
    """Shape functions on panels, each a polynomial in z from -1 to 1; n functions."""

    edges: Array  # (panels + 1,) m, ascending from 0
    coefficients: Array  # (panels, degree + 1, n) of powers of z
    shortening: Array  # (panels + 1, n, n) H at the edges (1/m)
    nodes: Array  # (degree,) of Gauss's rule, exact for products of two slopes
    weights: Array
    # which methods overwrite: deflection around a place with its derivative over z, the same of its rate, and
    # derivatives of the deflection at the nodes before the place
    polynomials: Array  # (2, 2, degree + 1)
    slopes: Array  # (degree,)


def polynomials_on(evaluate: Callable[[Array], Array], edges: Array, degree: int) -> Array:
    """Return coefficients (panels, degree + 1, n) of powers of z, -1 to 1, of n functions of places (points,)."""
    z = np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
    half, middle = 0.5 * np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    values = evaluate((middle[:, None] + half[:, None] * z).ravel()).reshape(half.size, degree + 1, -1)
    return np.asarray(np.linalg.inv(np.vander(z, increasing=True)) @ values)


def fit_shapes(evaluate: Callable[[Array], Array], edges: Array, degree: int) -> AxisShapes:
    """Interpolate the shape functions `evaluate(x)`, (points,) -> (points, n), between the edges (m)."""
    half, coefficients = 0.5 * np.diff(edges), polynomials_on(evaluate, edges, degree)
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
        np.zeros((2, 2, degree + 1)),
        np.zeros(degree),
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
    """Coefficients of u_y = Phi B on a panel into `polynomial` (2, degree + 1), with those of its derivative."""
    for k in range(s.coefficients.shape[1]):
        total = 0.0
        for i in range(B.shape[0]):
            total += s.coefficients[panel, k, i] * B[i]
        polynomial[0, k], polynomial[1, k] = total, k * total


@inlined
def _slope_at(polynomial: Array, z: float) -> float:
    """Evaluate the derivative over z of a polynomial on a panel."""
    total = 0.0
    for k in range(polynomial.shape[1] - 1, 0, -1):
        total = total * z + polynomial[1, k]
    return total


@inlined
def _evaluate(polynomial: Array, z: float, half: float, beyond: float) -> tuple[float, float, float]:
    """Evaluate a polynomial on a panel, its slope and curvature; past an end of the beam its tangent goes on."""
    value, slope, curvature = 0.0, 0.0, 0.0
    for k in range(polynomial.shape[1] - 1, -1, -1):
        curvature = curvature * z + 2.0 * slope
        slope = slope * z + value
        value = value * z + polynomial[0, k]
    slope /= half
    return value + slope * beyond, slope, curvature / (half * half) if beyond == 0.0 else 0.0


@jitable
def _bent_axis(s: AxisShapes, x: float, B: Array) -> AxisPoint:
    """Bend the axis, see `Shapes`."""
    polynomial, panel = s.polynomials[0], panel_of(s.edges, x)
    a, half = s.edges[panel], 0.5 * (s.edges[panel + 1] - s.edges[panel])
    inside = min(max(x, s.edges[0]), s.edges[-1])
    z, beyond = (inside - a) / half - 1.0, x - inside
    _contract(s, panel, B, polynomial)
    u_y, slope, curvature = _evaluate(polynomial, z, half, beyond)
    squared = slope * slope * beyond
    for i in range(B.shape[0]):
        for j in range(B.shape[0]):
            squared += B[i] * s.shortening[panel, i, j] * B[j]
    part = 0.5 * (z + 1.0)
    for g in range(s.nodes.shape[0]):
        steep = _slope_at(polynomial, part * (s.nodes[g] + 1.0) - 1.0)
        s.slopes[g] = steep
        squared += s.weights[g] * part * steep * steep / half
    return AxisPoint(-0.5 * squared, u_y, slope, curvature, panel, z, beyond)


@jitable
def _motion_at(s: AxisShapes, axis: AxisPoint, B: Array, Bd: Array) -> tuple[SectionMotion, float]:
    """Motion of a section, see `Shapes`."""
    rates, panel = s.polynomials[1], axis.panel
    half, part = 0.5 * (s.edges[panel + 1] - s.edges[panel]), 0.5 * (axis.z + 1.0)
    _contract(s, panel, Bd, rates)
    u_y_rate, slope_rate, curvature_rate = _evaluate(rates, axis.z, half, axis.beyond)
    shortened, squared = axis.slope * slope_rate * axis.beyond, slope_rate * slope_rate * axis.beyond
    for i in range(B.shape[0]):
        total = 0.0
        for j in range(B.shape[0]):
            total += s.shortening[panel, i, j] * Bd[j]
        shortened += B[i] * total
        squared += Bd[i] * total
    for g in range(s.nodes.shape[0]):
        weight, rate = s.weights[g] * part / half, _slope_at(rates, part * (s.nodes[g] + 1.0) - 1.0)
        shortened += weight * s.slopes[g] * rate
        squared += weight * rate * rate
    motion = SectionMotion(axis.u_x, axis.u_y, axis.slope, -shortened, u_y_rate, slope_rate, -squared)
    return motion, curvature_rate


#: a place of the beam that can touch a side (`on_side`), or a point fixed in space that can touch the beam, a peg
PLACE = np.dtype(
    [
        ("on_side", np.int64),
        ("x", float),  # m along the beam; of a peg in space
        ("y", float),  # m, of a peg
        ("cosine", float),  # of the angle of the side
        ("sine", float),
        ("normal_offset", float),  # m, of a point of the side from the root's axis, across the side
        ("tangential_offset", float),  # m, along it
        ("fibre", float),  # m across the beam from its axis, of the point that touches
        ("turning", float),  # the same, or 0 where terms of second order are left out
        ("shortening", float),  # 1, or 0 where the foreshortening is left out
        # of pegs: distance (m) from the axis at which it touches, its radius and, of the beam's face, half the
        # depth; half the depth where friction acts on the beam's face, 0 on the axis; and the side on which the
        # beam is of it, seen along the beam: 1 left, -1 right
        ("distance", float),
        ("lever", float),
        ("side", float),
    ],
    align=True,
)


def place_record(on_side: bool, numbers: Sequence[float], shortening: float = 1.0) -> Any:
    """Return a record of `PLACE`.

    `numbers` (6,) of a place of the beam are x, angle, both offsets, fibre and turning; of a peg x, y, distance,
    lever and side, and one that is 0.  `shortening` is 0 where the foreshortening is left out.
    """
    names = ("x", "angle", "normal_offset", "tangential_offset", "fibre", "turning")
    of_peg = ("x", "y", "distance", "lever", "side", "turning")
    found = dict(zip(names if on_side else of_peg, numbers, strict=True))
    angle = found.pop("angle", 0.0)
    found |= {"cosine": np.cos(angle), "sine": np.sin(angle)}
    return record_of(PLACE, found | {"on_side": on_side, "shortening": shortening})


class Places(NamedTuple):
    """Places at which the beam can touch obstacles."""

    each: Any  # (places,) records of `PLACE`
    #: of places of the beam, which stay where they are along it: H (1/m), shape functions, their slopes
    tables: Array  # (places, n + 2, n)
    shapes: AxisShapes | None  # None: there are no pegs


@jitable
def place_of(s: Any, radius: float, kept: float, X: float, Y: float, B: Array) -> tuple[float, AxisPoint]:
    """Place (m) along the beam where the normal of the axis goes through the point (X, Y) of the frame.

    The foreshortening is `kept`, 1, or left out, 0.

    Newton's method on (r(x) - c).r'(x) = 0, from the place of the undeformed beam; some four steps are usual.  A
    step that has not halved the last one, or leads out of the bracket, gives way to the middle of the bracket; the
    tangents at the ends of the beam go on for ever, so that there is one.  So steps or brackets halve until they
    are rounding; of a state that is no number the place is none.
    """
    x, low, high, last, placed = X - radius, -np.inf, np.inf, 4.0 * s.edges[-1], False
    rounding = _PLACED * (s.edges[-1] + abs(X) + abs(Y))
    while True:
        axis = s.bent_axis(x, B)
        along, across, phi = radius + x + kept * axis.u_x - X, axis.u_y - Y, axis.slope
        steep = 1.0 - 0.5 * kept * phi * phi
        value = along * steep + across * phi
        rate = steep * steep + phi * phi + (across - kept * along * phi) * axis.curvature
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
        # far beyond the beam the rounding of x is the larger one
        placed = abs(step) <= rounding or x + step == x
        x, last = x + step, abs(step)


@jitable
def _take_shapes(s: AxisShapes, axis: AxisPoint, B: Array, v: Array) -> None:
    """Take shape functions at a place, see `Shapes`."""
    shapes, slopes, HB, panel, n = v[SCRATCH_A], v[SCRATCH_B], v[SHORTENING_PRODUCT], axis.panel, B.shape[0]
    half, part = 0.5 * (s.edges[panel + 1] - s.edges[panel]), 0.5 * (axis.z + 1.0)
    for i in range(n):
        value, slope = 0.0, 0.0
        for k in range(s.coefficients.shape[1] - 1, -1, -1):
            slope = slope * axis.z + value
            value = value * axis.z + s.coefficients[panel, k, i]
        slope /= half
        shapes[i + 1], slopes[i + 1] = value + slope * axis.beyond, slope
        shortened = axis.slope * slope * axis.beyond
        for j in range(n):
            shortened += s.shortening[panel, i, j] * B[j]
        HB[i + 1] = shortened
    for g in range(s.nodes.shape[0]):
        at = part * (s.nodes[g] + 1.0) - 1.0
        steep = s.weights[g] * part / half * s.slopes[g]
        for i in range(n):
            slope = 0.0
            for k in range(s.coefficients.shape[1] - 1, 0, -1):
                slope = slope * at + k * s.coefficients[panel, k, i]
            HB[i + 1] += slope * steep


class AxisShapes(_PanelData):
    """Few shape functions, each of which spans the beam: those of modes."""

    __slots__ = ()
    bend = _bend
    bent_axis = _bent_axis
    motion_at = _motion_at
    take_shapes = _take_shapes


# --- where the points of the beam are


@inlined
def point_of(place: Any, reach: float, s: SectionMotion, spin: float) -> PointMotion:
    """Point at the height e of a cross-section, in axes of the frame that turns by `spin` (rad/s).

    The section, `reach` = r + x (m) from the root's axis of the straight beam, is turned by phi:

        x_P = r + x - B^T H B/2 - e phi,    y_P = Phi B + e (1 - phi^2/2)
    """
    e, turning, kept = place.fibre, place.turning, place.shortening
    x, y = reach + kept * s.u_x - e * s.slope, s.u_y + (e - 0.5 * turning * s.slope * s.slope)
    x_rate, y_rate = kept * s.u_x_rate - e * s.slope_rate, s.u_y_rate - turning * s.slope * s.slope_rate
    return PointMotion(
        x,
        y,
        x_rate - spin * y,
        y_rate + spin * x,
        kept * s.u_x_bias - 2.0 * spin * y_rate - spin * spin * x,
        2.0 * spin * x_rate - spin * spin * y - turning * s.slope_rate * s.slope_rate,
    )


@inlined
def axis_motion(s: SectionMotion, curvature: float, curvature_rate: float, spin: float, kept: float) -> AxisMotion:
    """Return derivatives along the axis of r, v and b at a section: r' = (1 - phi^2/2, phi).

    Where the foreshortening is not `kept`, 0 in place of 1, r' = (1, phi).
    """
    phi, steep = s.slope, 1.0 - 0.5 * kept * s.slope * s.slope
    turning = spin + kept * s.slope_rate
    return AxisMotion(
        steep,
        phi,
        -kept * phi * curvature,
        curvature,
        -phi * turning,
        spin * steep + s.slope_rate,
        -curvature * turning - kept * phi * curvature_rate,
        curvature_rate - spin * kept * phi * curvature,
        -spin * spin * steep - 2.0 * spin * s.slope_rate - kept * s.slope_rate * s.slope_rate,
        -spin * spin * phi - 2.0 * spin * kept * phi * s.slope_rate,
    )


class Met(NamedTuple):
    """A place of the axis that meets an obstacle, with the point of the beam there."""

    x: float  # m along the beam
    axis: AxisPoint
    point: PointMotion
    directions: Directions


@jitable
def meet(s: Any, radius: float, place: Any, q: Array, qd: Array, heading: Heading, c: Candidate) -> Met:
    """Gap, slip, rates and biases of a place of contact of a beam on a hub of this radius (m).

    A point of the beam stays at its place along it, the one that meets a peg moves.  The `heading` is that of the
    frame.
    """
    spin, B, Bd = qd[0], q[1:], qd[1:]
    if place.on_side:
        axis = s.bent_axis(place.x, B)
        motion, _ = s.motion_at(axis, B, Bd)
        point = point_of(place, radius + place.x, motion, spin)
        return Met(place.x, axis, point, meet_side(place, heading, point, c))
    centre = centre_of(place, heading)
    x, axis = place_of(s, radius, place.shortening, centre[0], centre[1], B)
    motion, curvature_rate = s.motion_at(axis, B, Bd)
    point = point_of(place, radius + x, motion, spin)
    along = axis_motion(motion, axis.curvature, curvature_rate, spin, place.shortening)
    return Met(x, axis, point, meet_peg(place, centre, x, point, along, c))
