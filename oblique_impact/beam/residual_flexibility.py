"""Residual flexibility: static compliance of the truncated modes of a reduced beam.

MacNeal, Computers & Structures 1 (1971) 581-601; Craig and Chang (1977) for bodies with rigid motion: the static
compliance of the whole beam at the contact point, under a unit load that the inertia of the frame's rigid motion
(of beam and hub) balances, less that of the shapes that are kept.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.sparse import issparse

from oblique_impact.beam.axis import polynomials_on
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import Array, BeamOperators, gauss_rule
from oblique_impact.contact.compliance import STATIC

_CELLS, _GAUSS_POINTS = 64, 6
_DEGREE = 11  # of polynomials on the panels
_NEXT = 1e-9  # of the length: nearer edges are one
_ROUNDING = 1e-9  # of the whole compliance: a residual below it is the rounding of a difference


def static_flexibility(sections: Sections, point: float, clamped: bool) -> Array:
    """Return deflection and rotation at x = `point` (m) under a unit force and a unit moment there, (2, 2).

    That is int M_i M_k/(E I) with the bending moments M of the two loads (m/N, 1/N; 1/N, 1/(N m)).  A clamped
    beam carries a load to its root, and a clamp with the spring k turns by the moment there over k.  One that is
    free to turn, on a pin or with its hub, is accelerated: the inertia forces m (r + x) a of this turning, and
    J_k a of hub and point masses, balance the load, and the deflection is the one in the mean-axis frame.  Uniform
    beam with the force at its end: L^3/(3 E I), and on a pin 2 L^3/(105 E I).
    """
    edges = np.union1d(np.linspace(0.0, sections.length, _CELLS + 1), [*sections.kinks, point])
    x, w = gauss_rule(edges, _GAUSS_POINTS)
    moments = np.stack([np.maximum(point - x, 0.0), np.where(x < point, 1.0, 0.0)])
    if not clamped:
        moments -= _balance(sections, np.array([sections.hub_radius + point, 1.0]), x)
    found = (moments * (w / sections.bending_stiffness(x))) @ moments.T
    if clamped and sections.clamp_stiffness > 0.0:
        found += np.outer([point, 1.0], [point, 1.0]) / sections.clamp_stiffness
    return np.asarray(found)


def _balance(sections: Sections, loads: Array, x: Array) -> Array:
    """Bending moments (loads, points) at x of the inertia that balances loads of given moments about the root."""
    return np.asarray(np.multiply.outer(loads / sections.whole_inertia, sections.outer_inertia_moment(x)))


def residual_flexibility(operators: BeamOperators, clamped: bool, place: float | None = None) -> Array:
    """Return the flexibility (2, 2) of deflection and rotation that the modes leave out at a place (m).

    By default that of the contact point.  Zero if they represent the whole deflection.
    """
    place, along = operators.contact_point if place is None else place, operators.along
    if place == operators.contact_point:
        shapes = np.stack([operators.contact_shape, operators.contact_slope])
    else:
        assert along is not None
        shapes = np.stack(along.at(place)[:2])
    stiffness = operators.stiffness.toarray() if issparse(operators.K) else operators.stiffness
    whole = static_flexibility(operators.sections, place, clamped)
    left = np.asarray(whole - shapes @ np.linalg.solve(stiffness, shapes.T))
    return left if left[0, 0] > _ROUNDING * whole[0, 0] else np.zeros((2, 2))


class FlexibilityAlong(NamedTuple):
    """Flexibility that the modes leave out between any two places, see `oblique_impact.contact.compliance`.

    Polynomials of functions of a place on panels: three static ones, and others f_k with the weights w_k of
    f_k(x) f_k(y).
    """

    edges: Array  # (panels + 1,) m
    coefficients: Array  # (panels, degree + 1, 3 + p)
    weights: Array  # (p,)

    @classmethod
    def at(cls, place: float, flexibility: Array) -> FlexibilityAlong:
        """Return that of one place (m) alone, of its deflection and rotation (2, 2)."""
        weights, vectors = np.linalg.eigh(flexibility)
        coefficients = np.zeros((1, 2, STATIC + 2))
        coefficients[0, 0, STATIC:], coefficients[0, 1, STATIC:] = vectors
        return cls(np.array([place - 1.0, place + 1.0]), coefficients, weights)


def flexibility_along(operators: BeamOperators, clamped: bool, place: float | None = None) -> FlexibilityAlong:
    """Return the flexibility of deflections that the modes leave out between any two places, and of rotations.

    With a load at x <= y, m(s) = (r + s) times the mass per length and b(s) the moment at s of m beyond it, J the
    inertia with the hub's,

        int M_x M_y/(E I) = x y a_0(x) - (x + y) a_1(x) + a_2(x) - (r + x) c(y) - (r + y) c(x) + (r + x)(r + y) d

    with a_k(x) = int_0^x s^k/(E I) ds, c(x) = int_0^x (x - s) b/(E I J) ds, d = int b^2/(E I J^2) ds; of a clamped
    beam c and d are zero, and a clamp with the spring k, a hinge at s = 0, adds 1/k to a_0.
    """
    sections, along = operators.sections, operators.along
    assert along is not None
    inertia = sections.whole_inertia
    cells = np.linspace(0.0, sections.length, _CELLS + 1)
    edges = np.union1d(cells, np.concatenate([along.edges, sections.kinks]))
    edges = edges[np.append(True, np.diff(edges) > _NEXT * sections.length)]
    edges[-1] = sections.length

    def integrands(s: Array) -> Array:
        bent = 1.0 / sections.bending_stiffness(s)
        held = np.zeros_like(s) if clamped else sections.outer_inertia_moment(s) / inertia
        return np.asarray(np.stack([bent, bent * s, bent * s * s, bent * held, bent * held * s, bent * held**2]))

    matrix = -np.linalg.inv(operators.stiffness)
    hinge = 1.0 / sections.clamp_stiffness if clamped and sections.clamp_stiffness > 0.0 else 0.0
    size = 0 if clamped else 2
    weights = np.zeros((size + operators.size, size + operators.size))
    arm, scale = sections.hub_radius + sections.length, 1.0
    if not clamped:
        _, _, _, b0, b1, d = _integrals(integrands, edges, edges[-1:])[:, 0].tolist()
        scale = float(np.sqrt((sections.length * b0 - b1) / arm))  # r + x and c(x) of one size, lest digits cancel
        weights[:2, :2] = [[d / scale**2, -1.0], [-1.0, 0.0]]
    weights[size:, size:] = 0.5 * (matrix + matrix.T)
    values, vectors = np.linalg.eigh(weights)

    def functions(x: Array) -> Array:
        a0, a1, a2, b0, b1, _ = _integrals(integrands, edges, x)
        moved = [] if clamped else [scale * (sections.hub_radius + x), (x * b0 - b1) / scale]
        shapes = np.concatenate([np.array(moved).reshape(size, x.size), along.derivative(x, 0).T])
        return np.concatenate([[a0 + hinge, a1, a2], vectors.T @ shapes]).T

    return FlexibilityAlong(edges, polynomials_on(functions, edges, _DEGREE), values)


def _integrals(integrands: Callable[[Array], Array], edges: Array, x: Array) -> Array:
    """Return integrals (m, points) of m functions from 0 to places x (points,) on panels of these edges."""
    nodes, weights = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
    panel = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, edges.size - 2)

    def between(a: Array, b: Array) -> Array:
        half, middle = 0.5 * (b - a)[:, None], 0.5 * (a + b)[:, None]
        values = integrands((middle + half * nodes).ravel()).reshape(-1, a.size, nodes.size)
        return np.asarray((values * (half * weights)).sum(axis=2))

    whole = np.cumsum(between(edges[:-1], edges[1:]), axis=1)
    before = np.concatenate([np.zeros_like(whole[:, :1]), whole], axis=1)
    return np.asarray(before[:, panel] + between(edges[panel], x))
