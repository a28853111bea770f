"""Compliance behind contact rows: what the coordinates leave out of the body, without mass.

Forces at n places move the material there, and with it gaps and slips by C lambda.  Across the body C is what the
modes above the last one deflect, its residual flexibility

    G(x, y) = int M_x M_y/(E I) ds - Phi(x) K^-1 Phi(y)^T

with the bending moments M_x of a unit force at x (see `oblique_impact.beam.residual_flexibility`).  Forces along
the body stretch its axis, by f(min(x, y)) with the static flexibility f(x) = int_0^x ds/(E A) between root and
place.

Places slide and the body turns, so that C depends on the coordinates: with the forces lambda of elastic contacts
V = lambda^T C lambda/2 is held, and V as a function of the coordinates has the generalized force

    -dV/dq at given gaps  =  lambda^T (dC/dq) lambda/2

besides lambda^T dg/dq, without which energy is made.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array

#: functions of a place that the static part of G is made of: int s^k/(E I) ds up to there for k = 0, 1, 2
STATIC = 3
#: derivatives of gap and slip of a place by its deflection and by the rotation of its section there
GAP_BY_DEFLECTION, GAP_BY_ROTATION, SLIP_BY_DEFLECTION, SLIP_BY_ROTATION = range(4)


class Compliance(NamedTuple):
    """Compliance of a body between n places of contact."""

    # --- the places
    angles: Array  # (n,) rad, of sides
    facing: Array  # (n,) side of an obstacle's point on which the body is; 0: a point of the body on a side
    fibres: Array  # (n,) m, of points of the body, across it from its axis
    places: Array  # (n,) m along the body; NaN: an obstacle's point, wherever it is
    senses: Array  # (n,) 1 where the tangent points away from the root, -1 where it points towards it
    # --- across the body
    edges: Array  # (panels + 1,) m
    coefficients: (
        Array  # (panels, degree + 1, 3 + p) of powers of z from -1 to 1: three static functions and p others
    )
    weights: Array  # (p,) G is the static part plus sum_k w_k f_k(x) f_k(y)
    viscosity: float  # s, eta: the deflection z by forces obeys z + eta z' = G s
    # --- along it
    table: Array  # (2, k) places (m, ascending) and f there (m/N), linear in between; (2, 0): it does not stretch
    # --- at an instant
    at: Array  # (n,) m, the places
    values: Array  # (n, 2, 3 + p) functions and their slopes there
    lifts: Array  # (n, 4) see above

    @classmethod
    def between(
        cls,
        places: Array,
        angles: Array,
        facing: Array,
        fibres: Array,
        senses: Array,
        across: tuple[Array, Array, Array] | None,
        viscosity: float,
        table: Array | None,
    ) -> Compliance:
        """Return the compliance between n places: `across` the body (edges, coefficients, weights), and along."""
        n = len(places)
        edges, coefficients, weights = across or (np.array([0.0, 1.0]), np.zeros((1, 1, STATIC)), np.zeros(0))
        return cls(
            angles,
            facing,
            fibres,
            places,
            senses,
            edges,
            coefficients,
            weights,
            viscosity if across else 0.0,
            np.zeros((2, 0)) if table is None else table,
            np.full(n, np.nan),
            np.zeros((n, 2, coefficients.shape[2])),
            np.zeros((n, 4)),
        )

    @property
    def bends(self) -> bool:
        """Whether the body yields across itself."""
        return bool(self.weights.size)

    def flexibility(self, i: int, x: float, j: int, y: float) -> float:
        """Return the deflection (m/N) at a place x (m) of contact i by a force at y of contact j."""
        for k, at in ((i, x), (j, y)):
            take_place(self, k, at)
        return float(flexibilities(self, i, j)[0])

    def behind(self, contact: int) -> Callable[[float], tuple[float, float]] | None:
        """Return the axial flexibility (m/N) of a contact and the sense of its tangent over its slip, or None."""
        if self.table.shape[1] == 0:
            return None
        place, sense = float(self.places[contact]), float(self.senses[contact])
        return lambda slip: (axial_flexibility(self, -slip if np.isnan(place) else place), sense)


@jitable
def take_place(y: Compliance, i: int, x: float) -> None:
    """Evaluate the functions of contact i at a place (m) along the body."""
    if y.at[i] == x:
        return
    y.at[i] = x
    panels = y.edges.shape[0] - 1
    inside, panel = min(max(x, y.edges[0]), y.edges[panels]), 0
    while panel < panels - 1 and y.edges[panel + 1] <= inside:
        panel += 1
    half = 0.5 * (y.edges[panel + 1] - y.edges[panel])
    z = (inside - y.edges[panel]) / half - 1.0
    for f in range(y.values.shape[2]):
        value, slope = 0.0, 0.0
        for k in range(y.coefficients.shape[1] - 1, -1, -1):
            slope = slope * z + value
            value = value * z + y.coefficients[panel, k, f]
        y.values[i, 0, f], y.values[i, 1, f] = value, slope / half


@inlined
def take_directions(y: Compliance, i: int, theta: float) -> None:
    """Take how contact i, of a point of the body, moves as its section does, the body at the angle theta (rad)."""
    lifts, e = y.lifts[i], y.fibres[i]
    cosine, sine = np.cos(theta - y.angles[i]), np.sin(theta - y.angles[i])
    lifts[GAP_BY_DEFLECTION], lifts[GAP_BY_ROTATION] = cosine, -e * sine
    lifts[SLIP_BY_DEFLECTION], lifts[SLIP_BY_ROTATION] = -sine, -e * cosine


@jitable
def locate(y: Compliance, i: int, shift: float) -> None:
    """Take place and directions of contact i, see `Candidate.shift`."""
    if y.facing[i] != 0.0:
        y.lifts[i, GAP_BY_DEFLECTION] = y.facing[i]
        take_place(y, i, shift)
    else:
        take_directions(y, i, shift)
        take_place(y, i, y.places[i])


@jitable
def flexibilities(y: Compliance, i: int, j: int) -> tuple[float, float, float, float]:
    """Return G (m/N) between contacts i and j, its derivatives by the place of i, by that of j, by both."""
    a, b, x, z = y.values[i], y.values[j], y.at[i], y.at[j]
    low = a if x <= z else b
    zeroth, first = low[0, 0], low[0, 1]
    g, by_x = x * z * zeroth - (x + z) * first + low[0, 2], z * zeroth - first
    by_z, by_both = x * zeroth - first, zeroth
    for k in range(y.weights.shape[0]):
        w, m = y.weights[k], STATIC + k
        g += w * a[0, m] * b[0, m]
        by_x += w * a[1, m] * b[0, m]
        by_z += w * a[0, m] * b[1, m]
        by_both += w * a[1, m] * b[1, m]
    return g, by_x, by_z, by_both


@jitable
def across(y: Compliance, i: int, of: int, j: int, by: int) -> float:
    """Return the gap (of = 0) or slip (1) of contact i by a unit force on gap or slip (by) of contact j (m/N)."""
    g, by_x, by_z, by_both = flexibilities(y, i, j)
    p, r = y.lifts[i, 2 * of], y.lifts[i, 2 * of + 1]
    u, s = y.lifts[j, 2 * by], y.lifts[j, 2 * by + 1]
    return float(p * (g * u + by_z * s) + r * (by_x * u + by_both * s))


@jitable
def across_by_shift(y: Compliance, i: int, of: int, j: int, by: int) -> float:
    """Return the derivative of what `across` returns over the shift of contact i alone."""
    g, by_x, by_z, by_both = flexibilities(y, i, j)
    u, s = y.lifts[j, 2 * by], y.lifts[j, 2 * by + 1]
    if y.facing[i] != 0.0:  # its place moves
        return float(y.lifts[i, 2 * of] * (by_x * u + by_both * s))
    # as the body turns the gap moves as the slip did, and the slip against the gap
    turned = 1.0 if of == 0 else -1.0
    p, r = turned * y.lifts[i, 2 - 2 * of], turned * y.lifts[i, 3 - 2 * of]
    return float(p * (g * u + by_z * s) + r * (by_x * u + by_both * s))


@jitable
def axial_flexibility(y: Compliance, x: float) -> float:
    """Return the axial flexibility f (m/N) between the root and a place (m)."""
    places, values = y.table[0], y.table[1]
    k = 1
    while k < places.shape[0] - 1 and places[k] < x:
        k += 1
    part = (min(max(x, 0.0), places[-1]) - places[k - 1]) / (places[k] - places[k - 1])
    return float(values[k - 1] + part * (values[k] - values[k - 1]))


@jitable
def along(y: Compliance, i: int, j: int) -> float:
    """Return the slip of contact i by a unit force on the slip of j (m/N), as the axis stretches."""
    if y.table.shape[1] == 0:
        return 0.0
    return float(y.senses[i] * y.senses[j] * axial_flexibility(y, min(y.at[i], y.at[j])))
