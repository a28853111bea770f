"""All warnings of a run of a beam, in one call."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.validity.integration import ambiguity_warnings, energy_warnings
from oblique_impact.beam.validity.limits import (
    ALL,
    clamp_warnings,
    friction_warnings,
    impact_warnings,
    mass_warnings,
    most_meetings,
    outline_warnings,
    truncation_warnings,
    unconverged_results,
)
from oblique_impact.beam.validity.passing import passing_warnings
from oblique_impact.beam.validity.plausibility import implausible_values
from oblique_impact.beam.validity.small_deflection import deflection_warnings
from oblique_impact.beam.validity.strength import peg_warnings, yield_warnings
from oblique_impact.contact.log import Contact
from oblique_impact.scenario.scenario import Scenario


def run_warnings(
    scenario: Scenario,
    contacts: Sequence[Contact],
    ambiguous: Sequence[float],
    variables: Mapping[str, Any],
    summary: Mapping[str, Any],
    section_forces: Callable[[], Mapping[str, Any]],
    beam: Beam | None = None,
) -> tuple[list[str], list[str]]:
    """Return the warnings of a run, and the entries of its macro-collisions that have no limit.

    Parameters
    ----------
    scenario : Scenario
        What was simulated.
    contacts : sequence of Contact
        Those that were closed.
    ambiguous : sequence of float
        Times (s) at which the contact forces were one of several solutions.
    variables : mapping of str to ndarray
        The variables of its history.
    summary : mapping
        Its macro-collisions, passages of slope ends and balance of energy.
    section_forces : callable
        Computes section forces and stresses at samples and stations.
    beam : Beam, optional
        Its model of small deflections; None of the exact beam, which bends as far as it likes.
    """
    most = most_meetings(scenario, contacts, summary["macro_collisions"])
    of_impacts = of_model = impact_warnings(scenario, most, beam)
    without_limit = ALL if of_impacts else unconverged_results(scenario)
    if beam is not None:
        of_model = [
            *deflection_warnings(beam, variables),
            *friction_warnings(scenario, most),
            *of_impacts,
            *truncation_warnings(beam, variables),
            *mass_warnings(scenario),
            *clamp_warnings(scenario),
        ]
    kinetic, elastic, gravity = (variables[f"energy_{part}"] for part in ("kinetic", "elastic", "gravity"))
    parts = float(np.max(kinetic + np.abs(elastic) + np.abs(gravity)))
    warnings = [
        *implausible_values(scenario),
        *passing_warnings(scenario, variables, summary["slope_ends"]),
        *outline_warnings(scenario, variables),
        *peg_warnings(scenario, variables),
        *yield_warnings(scenario, section_forces),
        *ambiguity_warnings(ambiguous),
        *of_model,
        *energy_warnings(summary["energy"], float(np.max(kinetic)), parts, scenario.solver.scheme),
    ]
    return warnings, list(without_limit)
