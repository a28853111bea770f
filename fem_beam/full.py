"""The nodal model without reduction: banded operators in the free degrees of freedom."""

from __future__ import annotations

from dataclasses import replace

from scipy.sparse import csr_array, eye_array

from fem_beam.nodal import NodalBeam
from fem_beam.reduction import project
from oblique_impact.beam.operators import BeamOperators
from oblique_impact.scenario.scenario import Scenario


def build_nodal(scenario: Scenario) -> BeamOperators:
    """Discretize the beam of `scenario` by Hermite elements, pinned at the root; nothing is reduced."""
    nodal = NodalBeam.from_scenario(scenario)
    free = nodal.free_dofs("hinged")
    operators = project(nodal, csr_array(eye_array(nodal.basis.N))[:, free])
    rigid = nodal.rigid_rotation[free]
    # integrals with the function x are taken from the elements too: rigid rotations must cancel to the last digit
    return replace(
        operators,
        K=csr_array(nodal.K[free][:, free]),
        J=float(rigid @ operators.S),
        Sm=float(rigid @ operators.P),
        rigid=rigid,
    )
