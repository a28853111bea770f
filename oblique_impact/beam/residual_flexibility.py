"""Residual flexibility: the static compliance of the modes that a reduced beam leaves out.

MacNeal, Computers & Structures 1 (1971) 581-601; Craig and Chang (1977) for bodies with rigid motion: the static
compliance of the whole beam at the contact point, under a unit load that the inertia of the frame's rigid motion
(of beam and hub) balances, less that of the shapes that are kept.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import issparse

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import Array, BeamOperators

_CELLS, _GAUSS_POINTS = 64, 6
_ROUNDING = 1e-9  # of the whole compliance: a residual below it is the rounding of a difference


def static_compliance(sections: Sections, point: float, clamped: bool) -> float:
    """Deflection (m/N) of the point at x = `point` (m) by a unit load there: int M^2/(E I), M the bending moment.

    A clamped beam carries the load to its root.  One that is free to turn, on a pin or with its hub, is
    accelerated: the inertia forces m (r + x) a of this turning, and J_h a of the hub, balance the load, and the
    deflection is the one in the mean-axis frame.  Uniform beam with the load at its end: L^3/(3 E I), and on a pin
    2 L^3/(105 E I).
    """
    edges = np.union1d(np.linspace(0.0, sections.length, _CELLS + 1), [*sections.kinks, point])
    nodes, weights = np.polynomial.legendre.leggauss(_GAUSS_POINTS)
    half, middle = 0.5 * np.diff(edges)[:, None], 0.5 * (edges[1:] + edges[:-1])[:, None]
    x, w = (middle + half * nodes).ravel(), (half * weights).ravel()
    moment = np.maximum(point - x, 0.0)
    if not clamped:
        turning = (sections.hub_radius + point) / (sections.inertia + sections.hub_inertia)
        moment -= turning * sections.outer_inertia_moment(x)
    return float(w @ (moment**2 / sections.bending_stiffness(x)))


def residual_compliance(operators: BeamOperators, clamped: bool) -> float:
    """Transverse compliance (m/N) at the contact point that the shape functions leave out; 0 if none."""
    shape: Array = operators.contact_shape
    stiffness = operators.K.toarray() if issparse(operators.K) else operators.K
    whole = static_compliance(operators.sections, operators.contact_point, clamped)
    left = whole - float(shape @ np.linalg.solve(stiffness, shape))
    return left if left > _ROUNDING * whole else 0.0
