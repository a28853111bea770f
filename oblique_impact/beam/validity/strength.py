"""Warnings about stresses beyond what a material bears, and pegs that are pressed in beyond their radius."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.operators import Array
from oblique_impact.contact.state import State
from oblique_impact.scenario.materials import MATERIALS
from oblique_impact.scenario.scenario import Scenario


def yield_warnings(scenario: Scenario, section_forces: Callable[[], Mapping[str, Array]]) -> list[str]:
    """Return a warning if the largest stress is beyond the strength of the material, where it has a name.

    `section_forces` computes stresses (Pa) and axial forces (N) at samples and stations.
    """
    if not scenario.beam.material:
        return []
    found, sections = section_forces(), Sections.from_scenario(scenario)
    stress = np.abs(found["bending_stress"]) + np.abs(found["axial_force"]) / sections.area(found["station"])
    k, station = np.unravel_index(np.argmax(np.nan_to_num(stress)), stress.shape)
    largest, limit = float(stress[k, station]), MATERIALS[scenario.beam.material].yield_strength
    if not largest > limit:
        return []
    where = f"at x = {found['station'][station]:.3g} m at t = {found['time'][k]:.6g} s"
    return [
        f"the stress of {1e-6 * largest:.3g} MPa {where} is beyond the {1e-6 * limit:g} MPa at which "
        f"{scenario.beam.material} of the mildest grade yields; the beam here is elastic whatever the stress"
    ]


def peg_warnings(scenario: Scenario, variables: Mapping[str, Array]) -> list[str]:
    """Return a warning for each elastic peg that is pressed in by more than its radius, beyond its centre."""
    warnings = list[str]()
    for point in scenario.obstacle_points:
        if point.corner or not point.radius:
            continue
        i = int(np.argmax(variables["contact_obstacle"] == point.obstacle))
        closed = variables["contact_state"][:, i] != State.FREE
        depth = np.where(closed, -variables["contact_gap"][:, i], 0.0)
        k = int(np.argmax(depth))
        if depth[k] > point.radius:
            warnings.append(
                f"obstacle {point.obstacle}, of radius {1e3 * point.radius:.3g} mm, is pressed in by "
                f"{1e3 * depth[k]:.3g} mm at t = {variables['time'][k]:.6g} s, beyond its centre: "
                "is its stiffness right?"
            )
    return warnings
