"""The nodal model without reduction: banded operators in the free degrees of freedom."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array, eye_array, lil_array

from oblique_impact.beam.axis import ShapeFunctions
from oblique_impact.beam.operators import Array, BeamOperators, gauss_rule
from oblique_impact.fem_beam.nodal import NodalBeam
from oblique_impact.fem_beam.reduction import project
from oblique_impact.scenario.scenario import Scenario

_POINTS = 6  # of Gauss's rule: a mass of degree 8 times cubics


def build_nodal(scenario: Scenario) -> BeamOperators:
    """Discretize the beam of `scenario` by Hermite elements, pinned at the root; nothing is reduced.

    With `contact.point_inertia = "none"` the deflection of the contact point, the beam's end, follows the other
    degrees of freedom statically, without inertia of its own; translations and rotations, so mass, static moment
    and inertia, are kept exactly.  Where the whole beam can touch obstacles no node has inertia, see
    :func:`without_nodal_inertia`.
    """
    nodal = NodalBeam.from_scenario(scenario)
    free = nodal.free_dofs("hinged")
    kept, left_out = csr_array(eye_array(nodal.basis.N))[:, free], 0.0
    K, rigid = csr_array(nodal.K[free][:, free]), nodal.rigid_rotation[free]
    massless, anywhere = scenario.contact.point_inertia == "none", scenario.contact.where == "anywhere"
    if massless and not anywhere:
        static, left_out = _without_inertia(K, free.size - 2)
        others = np.delete(np.arange(free.size), free.size - 2)
        kept, K, rigid = csr_array(kept @ static), csr_array(static.T @ (K @ static)), rigid[others]
    operators = project(nodal, kept)
    if massless and anywhere:
        operators = without_nodal_inertia(nodal, operators, kept, rigid)
    # integrals with the function x are taken from the elements too: rigid rotations must cancel to the last digit
    return replace(
        operators,
        K=K,
        J=float(rigid @ operators.S),
        Sm=float(rigid @ operators.P),
        rigid=rigid,
        curvature_factor=csr_array(nodal.curvature_factor() @ kept),
        left_out=left_out,
        largest_element=float(np.max(np.diff(nodal.nodes))),
        along=ShapeFunctions(lambda x, order: (nodal.evaluate(x)[order] @ kept).toarray(), nodal.nodes, degree=3),
    )


def without_nodal_inertia(
    nodal: NodalBeam, operators: BeamOperators, kept: csr_array, rigid: Array
) -> BeamOperators:
    """Give the beam velocities that are constant on each element, its mean ones: its nodes have no inertia then.

    The mass sum_e m_e b_e^T b_e, with the mass m_e of an element and its mean b_e = int m Phi/m_e, leaves one more
    motion without inertia than there are nodes, so that all of them can rest on obstacles without impacts (Renard,
    Comput. Methods Appl. Mech. Eng. 199, 2010; Pozzolini and Salaun, ESAIM M2AN 45, 2011).  Mass and static moment
    are kept exactly, the inertia to the square of the elements; forces of spin are those of the elements.
    """
    edges = nodal.nodes
    points, weights = gauss_rule(nodal.edges, _POINTS)
    cells = np.searchsorted(edges, points) - 1
    masses = nodal.sections.mass_per_length(points) * weights
    shares = csr_array((masses, (cells, np.arange(points.size))), shape=(edges.size - 1, points.size))
    of_elements = shares.sum(axis=1)
    means = csr_array((shares @ (nodal.evaluate(points)[0] @ kept)).multiply(1.0 / of_elements[:, None]))
    mass = csr_array(means.T @ means.multiply(of_elements[:, None]))
    return replace(operators, M1=mass, C=csr_array(operators.C + mass - operators.M1), S=mass @ rigid, means=means)


def _without_inertia(K: csr_array, point: int) -> tuple[csr_array, float]:
    """Return the static response (n, n - 1) to all degrees of freedom but `point`, and 1/K_pp (m/N)."""
    row, others = K[[point]].toarray()[0], np.delete(np.arange(K.shape[0]), point)
    response = lil_array((K.shape[0], K.shape[0] - 1))
    response[others, np.arange(others.size)] = 1.0
    coupled = np.flatnonzero(row[others])
    response[point, coupled] = -row[others][coupled] / row[point]
    return csr_array(response), 1.0 / float(row[point])
