"""The nodal model without reduction: banded operators in the free degrees of freedom."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, eye_array

from fem_beam.nodal import NodalBeam
from fem_beam.reduction import project
from oblique_impact.beam.nodal import NodalOperators
from oblique_impact.scenario.scenario import Scenario


def build_nodal(scenario: Scenario) -> NodalOperators:
    """Discretize the beam of `scenario` by Hermite elements, pinned at the root; nothing is reduced."""
    nodal = NodalBeam.from_scenario(scenario)
    free = nodal.free_dofs("hinged")

    def kept(matrix: csr_array) -> csr_array:
        return csr_array(matrix[free][:, free])

    node = int(np.argmin(np.abs(nodal.nodes - scenario.contact.point)))
    return NodalOperators(
        M1=kept(nodal.M1),
        K=kept(nodal.K),
        C=kept(nodal.C),
        D=kept(nodal.D),
        contact_shortening=kept(nodal.contact_shortening),
        S=nodal.S[free],
        P=nodal.P[free],
        rigid=nodal.rigid_rotation[free],
        contact_dof=2 * node - 1,
        beam=project(nodal, csr_array(eye_array(nodal.basis.N))[:, free]),
    )
