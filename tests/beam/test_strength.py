"""Warnings of stresses beyond what a material bears, and of pegs that are pressed in beyond their centre."""

from __future__ import annotations

import math

import pytest

from oblique_impact import Scenario, simulate

pytestmark = pytest.mark.filterwarnings("ignore::oblique_impact.errors.SimulationWarning")
LENGTH, DIAMETER = 0.5, 0.01  # m


def held(force, **beam):
    """A round cantilever at rest under a force across its tip."""
    section = {"section": {"shape": "circle", "diameter": DIAMETER}}
    return simulate(
        Scenario.from_dict(
            {
                "end_time": 1e-3,
                "gravity": 0.0,
                "beam": {"length": LENGTH} | section | beam,
                "root": {"kind": "driven"},
                "initial": {"angle": 0.0, "state": "equilibrium"},
                "contact": {"enabled": False},
                "discretization": {"method": "fem", "modes": 3, "elements": 8},
                "forces": [{"place": LENGTH, "force": force}],
            }
        )
    ).summary["warnings"]


@pytest.mark.parametrize(("material", "strength"), [("steel", 235e6), ("copper", 69e6)])
def test_a_stress_beyond_the_yield_strength_is_warned_of(material, strength):
    force = strength * math.pi * DIAMETER**3 / 32.0 / LENGTH  # F L = stress times the section modulus
    assert not any("yields" in line for line in held(0.98 * force, material=material))
    (line,) = (line for line in held(1.02 * force, material=material) if "yields" in line)
    assert f"{1.02e-6 * strength:.3g} MPa at x = 0 m" in line
    assert not any("yields" in line for line in held(1.02 * force, density=7850.0, youngs_modulus=210e9))


@pytest.mark.parametrize(("stiffness", "warned"), [(3e3, True), (3e5, False)])
def test_a_peg_that_is_pressed_in_beyond_its_centre_is_warned_of(stiffness, warned):
    history = simulate(
        Scenario.from_dict(
            {
                "end_time": 0.35,
                "slope": {"enabled": False},
                "contact": {"where": "anywhere", "normal": "spring", "stiffness": stiffness},
                "obstacles": [{"kind": "point", "origin": [0.7, -0.1], "radius": 5e-3}],
                "initial": {"angle": 0.3},
            }
        )
    )
    assert (history["depth"].max() > 5e-3) == warned
    lines = [line for line in history.summary["warnings"] if "beyond its centre" in line]
    assert len(lines) == warned
    assert all("obstacle 1, of radius 5 mm, is pressed in by " in line for line in lines)
