"""Residual flexibility: static compliance of the truncated modes of a reduced beam.

MacNeal, Computers & Structures 1 (1971) 581-601; Craig and Chang (1977) for bodies with rigid motion: the static
compliance of the whole beam at the contact point, under a unit load that the inertia of the frame's rigid motion
(of beam and hub) balances, less that of the shapes that are kept.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import issparse

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import Array, BeamOperators, gauss_rule

_CELLS, _GAUSS_POINTS = 64, 6
_ROUNDING = 1e-9  # of the whole compliance: a residual below it is the rounding of a difference


def static_flexibility(sections: Sections, point: float, clamped: bool) -> Array:
    """Return deflection and rotation at x = `point` (m) under a unit force and a unit moment there, (2, 2).

    That is int M_i M_k/(E I) with the bending moments M of the two loads (m/N, 1/N; 1/N, 1/(N m)).  A clamped beam
    carries a load to its root.  One that is free to turn, on a pin or with its hub, is accelerated: the inertia
    forces m (r + x) a of this turning, and J_h a of the hub, balance the load, and the deflection is the one in
    the mean-axis frame.  Uniform beam with the force at its end: L^3/(3 E I), and on a pin 2 L^3/(105 E I).
    """
    edges = np.union1d(np.linspace(0.0, sections.length, _CELLS + 1), [*sections.kinks, point])
    x, w = gauss_rule(edges, _GAUSS_POINTS)
    moments = np.stack([np.maximum(point - x, 0.0), np.where(x < point, 1.0, 0.0)])
    if not clamped:
        moments -= _balance(sections, np.array([sections.hub_radius + point, 1.0]), x)
    return np.asarray((moments * (w / sections.bending_stiffness(x))) @ moments.T)


def _balance(sections: Sections, loads: Array, x: Array) -> Array:
    """Bending moments (loads, points) at x of the inertia that balances loads of given moments about the root."""
    inertia = sections.inertia + sections.hub_inertia
    return np.asarray(np.multiply.outer(loads / inertia, sections.outer_inertia_moment(x)))


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
    stiffness = operators.K.toarray() if issparse(operators.K) else operators.K
    whole = static_flexibility(operators.sections, place, clamped)
    left = np.asarray(whole - shapes @ np.linalg.solve(stiffness, shapes.T))
    return left if left[0, 0] > _ROUNDING * whole[0, 0] else np.zeros((2, 2))


def flexibility_between(operators: BeamOperators, clamped: bool, places: Array) -> Array:
    """Return the flexibility (n, n) of deflections (m/N) at `places` (n,), m, that the modes leave out.

    An entry is the deflection at one place by a unit force at another, see :func:`static_flexibility`; the matrix
    is positive definite if the places are distinct.  Zero if the modes represent the whole deflection of any.
    """
    sections, along = operators.sections, operators.along
    assert along is not None
    edges = np.union1d(np.linspace(0.0, sections.length, _CELLS + 1), [*sections.kinks, *places])
    x, w = gauss_rule(edges, _GAUSS_POINTS)
    moments = np.maximum(places[:, None] - x, 0.0)
    if not clamped:
        moments -= _balance(sections, sections.hub_radius + places, x)
    whole = (moments * (w / sections.bending_stiffness(x))) @ moments.T
    shapes = along.derivative(places, 0)
    left = np.asarray(whole - shapes @ np.linalg.solve(operators.K, shapes.T))
    represented = np.diag(left) < _ROUNDING * np.diag(whole)
    return np.zeros_like(left) if represented.any() else left
