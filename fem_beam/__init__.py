"""Finite elements: cubic Hermite beams assembled by scikit-fem, nodal or reduced to their own modes.

`build_operators`  a scenario's beam as :class:`~oblique_impact.beam.operators.BeamOperators`
`spectrum`         frequencies of the spinning beam on the scenario's mesh
`build_nodal`      the same without reduction, as banded operators of all nodes
`NodalBeam`        the banded nodal operators
`beam_mesh`        mesh with a node at the contact point
"""

from oblique_impact.fem_beam.mesh import beam_mesh
from oblique_impact.fem_beam.nodal import NodalBeam
from oblique_impact.fem_beam.reduction import build_nodal, build_operators, spectrum

__all__ = ["NodalBeam", "beam_mesh", "build_nodal", "build_operators", "spectrum"]
