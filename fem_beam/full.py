"""The nodal model without reduction: banded operators in the free degrees of freedom."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array, eye_array, lil_array

from oblique_impact.beam.axis import ShapeFunctions
from oblique_impact.beam.operators import BeamOperators
from oblique_impact.fem_beam.nodal import NodalBeam
from oblique_impact.fem_beam.reduction import project
from oblique_impact.scenario.scenario import Scenario


def build_nodal(scenario: Scenario) -> BeamOperators:
    """Discretize the beam of `scenario` by Hermite elements, pinned at the root; nothing is reduced.

    With `contact.point_inertia = "none"` the deflection of the contact point, the beam's end, follows the other
    degrees of freedom statically, without inertia of its own; translations and rotations, so mass, static moment
    and inertia, are kept exactly.
    """
    nodal = NodalBeam.from_scenario(scenario)
    free = nodal.free_dofs("hinged")
    kept, left_out = csr_array(eye_array(nodal.basis.N))[:, free], 0.0
    K, rigid = csr_array(nodal.K[free][:, free]), nodal.rigid_rotation[free]
    if scenario.contact.point_inertia == "none":
        static, left_out = _without_inertia(K, free.size - 2)
        others = np.delete(np.arange(free.size), free.size - 2)
        kept, K, rigid = csr_array(kept @ static), csr_array(static.T @ (K @ static)), rigid[others]
    operators = project(nodal, kept)
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


def _without_inertia(K: csr_array, point: int) -> tuple[csr_array, float]:
    """Return the static response (n, n - 1) to all degrees of freedom but `point`, and 1/K_pp (m/N)."""
    row, others = K[[point]].toarray()[0], np.delete(np.arange(K.shape[0]), point)
    response = lil_array((K.shape[0], K.shape[0] - 1))
    response[others, np.arange(others.size)] = 1.0
    coupled = np.flatnonzero(row[others])
    response[point, coupled] = -row[others][coupled] / row[point]
    return csr_array(response), 1.0 / float(row[point])
