"""An independent formulation: a plane, geometrically exact beam in absolute coordinates.

`simulate`         a scenario with this beam, as a history: `discretization.method = "absolute"`
`ExactBeam`        elements, strains, energies, forces
`ElasticSections`  stiffnesses and inertias
`advance`          a step in time, `equilibrium` a state of rest
`exact_problem`    a scenario as a problem for the loop of all methods
`spectrum`         refuses: frequencies are those of the other discretizations, or about an equilibrium
"""

from __future__ import annotations

from typing import NoReturn

from oblique_impact.errors import InputError
from oblique_impact.fem_beam.exact.elastic_sections import ElasticSections
from oblique_impact.fem_beam.exact.exact_beam import ExactBeam, Stage
from oblique_impact.fem_beam.exact.exact_history import simulate
from oblique_impact.fem_beam.exact.exact_run import exact_problem
from oblique_impact.fem_beam.exact.step import advance, equilibrium
from oblique_impact.scenario.scenario import Scenario

__all__ = [
    "ElasticSections",
    "ExactBeam",
    "Stage",
    "advance",
    "equilibrium",
    "exact_problem",
    "simulate",
    "spectrum",
]


def spectrum(scenario: Scenario) -> NoReturn:
    """Raise InputError: this beam is marched, not linearized."""
    words = 'has no natural frequencies of its own; use "fem" or "modal", or --closed about its equilibrium'
    raise InputError(f'discretization.method = "absolute": {words}')
