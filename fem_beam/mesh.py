"""Meshes of the beam."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from skfem import MeshLine

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.scenario.scenario import Scenario

Array = NDArray[np.float64]

_CLOSEST = 0.05  # of a uniform element: kinks nearer to another node than this get none of their own
_NO_KINKS = np.zeros(0)


def beam_mesh(
    length: float,
    elements: int,
    contact_point: float,
    kinks: Array = _NO_KINKS,
    grading: float = 1.0,
    held: Sequence[float] = (),
) -> MeshLine:
    """Mesh of `elements` elements on [0, length] (m) with nodes at the contact point and at the kinks.

    Parameters
    ----------
    length, contact_point : float
        m.
    elements : int
        Number of elements, at least 2 for a contact point inside the span.
    kinks : ndarray, shape (k,)
        Places (m) inside the span where the sections or their loads are not smooth, as at point masses and
        forces.  A kink closer to another node than a
        twentieth of a uniform element gets no node, and with fewer elements than pieces only kinks
        that lie farther apart do; the integrals do not depend on it, the order of convergence does.
    grading : float
        Size of the largest element over that of the smallest.  Sizes shrink geometrically towards the contact
        point, from both sides if it is inside the span; pieces between fixed nodes make this approximate.
        1: uniform between the fixed nodes, with the elements shared out in proportion.
    held : sequence of float
        Further places (m) that are nodes; there are at least as many elements as pieces between them.
    """
    fixed = fixed_nodes(length, elements, (contact_point, *held), kinks)
    rate = 0.0
    if grading > 1.0:
        farthest = max(contact_point, length - contact_point)
        # one-sided geometric sizes h_k = h_0 q^k end at q^elements = 1 + rate farthest
        share = max(farthest / length * elements, 2.0)
        rate = (grading ** (share / (share - 1.0)) - 1.0) / farthest
        counts = _share_out(fixed, elements, contact_point, rate)
        rate = _solve_rate(fixed, counts, contact_point, rate, grading)
    else:
        counts = _share_out(fixed, elements, contact_point, rate)
    return MeshLine(_nodes(fixed, counts, contact_point, rate))


def mesh_of(scenario: Scenario, sections: Sections) -> MeshLine:
    """Return the mesh of a scenario's beam: of its nodes, if they are given, or of its number of elements."""
    d, length, point = scenario.discretization, scenario.beam.length, scenario.contact.point
    if not d.nodes:
        kinks = np.union1d(sections.kinks, scenario.inner_forces)
        return beam_mesh(length, d.elements, point, kinks, d.grading, scenario.contact_nodes)
    nodes = np.array(d.nodes)  # of a file, perhaps rounded
    for place in (length, point, *scenario.contact_nodes):
        nodes[np.argmin(np.abs(nodes - place))] = place
    return MeshLine(nodes)


def fixed_nodes(length: float, elements: int, contact_points: Sequence[float], kinks: Array) -> Array:
    """Return the places (m) that must be nodes, ascending: ends, contact points, kinks if there are elements."""
    held = np.union1d([0.0, length], contact_points)
    gap = _CLOSEST * length / elements
    while True:
        chosen: list[float] = []
        for kink in kinks:
            others = np.append(held, chosen)
            if np.min(np.abs(others - kink)) >= gap:
                chosen.append(float(kink))
        if held.size + len(chosen) - 1 <= elements or not chosen:
            return np.union1d(held, chosen)
        gap *= 1.5


def _stretch(x: Array, contact_point: float, rate: float) -> Array:
    """Integrate 1/(1 + rate |x - x_F|) from the contact point x_F to x: elements count along it."""
    distance = x - contact_point
    if rate == 0.0:
        return distance
    return np.asarray(np.sign(distance) * np.log1p(rate * np.abs(distance)) / rate)


def _share_out(fixed: Array, elements: int, contact_point: float, rate: float) -> NDArray[np.int64]:
    """Elements between neighbouring fixed nodes, in proportion and at least one; shape (pieces,)."""
    stretched = _stretch(fixed, contact_point, rate)
    places = np.round((stretched - stretched[0]) / (stretched[-1] - stretched[0]) * elements).astype(np.int64)
    pieces = np.arange(fixed.size)
    # from the left at least one each, from the right at most what leaves one for all that follow
    places = np.maximum.accumulate(places - pieces) + pieces
    places = np.minimum(places, elements - pieces[::-1])
    return np.asarray(np.diff(places))


def _nodes(fixed: Array, counts: NDArray[np.int64], contact_point: float, rate: float) -> Array:
    parts = []
    for a, b, count in zip(fixed[:-1], fixed[1:], counts, strict=True):
        if rate == 0.0:
            parts.append(a + (b - a) * np.arange(count) / count)
            continue
        ends = _stretch(np.array([a, b]), contact_point, rate)
        inner = ends[0] + (ends[1] - ends[0]) * np.arange(1, count) / count
        parts.append(np.append(a, contact_point + np.sign(inner) * np.expm1(rate * np.abs(inner)) / rate))
    return np.append(np.concatenate(parts), fixed[-1])


def _solve_rate(
    fixed: Array, counts: NDArray[np.int64], contact_point: float, guess: float, grading: float
) -> float:
    """Growth rate (1/m) that gives the wanted ratio of sizes, 0 if the fixed nodes alone give more."""

    def excess(rate: float) -> float:
        sizes = np.diff(_nodes(fixed, counts, contact_point, rate))
        return float(np.log(sizes.max() / sizes.min() / grading))

    if excess(0.0) >= 0.0:
        return 0.0

    from scipy.optimize import brentq  # takes a quarter of a second to load, for graded meshes alone

    upper = guess
    while excess(upper) < 0.0:
        upper *= 2.0
        if upper * fixed[-1] > 1e12:  # one element on either side of the contact point: nothing to grade
            return guess
    return float(brentq(excess, 0.0, upper, xtol=1e-15, rtol=1e-14))
