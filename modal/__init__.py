"""Assumed modes: exact eigenfunctions of the uniform beam and their integrals.

`build_operators`  a scenario's beam as :class:`~oblique_impact.beam.operators.BeamOperators`
`spectrum`         frequencies of the spinning beam
`Eigenfunctions`   eigenfunctions clamped, hinged or with a hub at the root, stable for high orders
"""

from oblique_impact.modal.assembly import build_operators, spectrum
from oblique_impact.modal.eigenfunctions import (
    Eigenfunctions,
    clamped_free_roots,
    hinged_free_roots,
    hub_free_roots,
)

__all__ = [
    "Eigenfunctions",
    "build_operators",
    "clamped_free_roots",
    "hinged_free_roots",
    "hub_free_roots",
    "spectrum",
]
