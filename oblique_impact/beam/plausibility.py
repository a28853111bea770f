"""Implausible values, mostly wrong units, which are named before a run."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.scenario.scenario import Scenario

#: Pa; from rubber to diamond
MODULI = (1e6, 1.3e12)
#: Pa; of what beams are made of, for a guess at the unit that was meant
_COMMON = (1e9, 1.3e12)
#: kg/m^3; from plastic foam to more than osmium
DENSITIES = (20.0, 3e4)
#: radius of gyration over length, above which Euler-Bernoulli theory does not hold
STOUT = 0.2
#: (beta L)^2 of the first mode of a clamped beam
_FIRST_MODE = 3.5160


class Rule(NamedTuple):
    """One implausible value."""

    key: str  # of the scenario; the warning begins with it
    reason: Callable[[Scenario, Sections], str]  # "" for plausible values


def _modulus(s: Scenario, sections: Sections) -> str:
    modulus = s.beam.youngs_modulus
    if MODULI[0] <= modulus <= MODULI[1]:
        return ""
    meant = next((unit for unit in (1e6, 1e9) if _COMMON[0] <= modulus * unit <= _COMMON[1]), None)
    guess = f'; did you mean "{modulus * meant / 1e9:g} GPa"?' if meant else ""
    return f"{modulus:g} Pa is {'softer than rubber' if modulus < MODULI[0] else 'stiffer than diamond'}{guess}"


def _density(s: Scenario, sections: Sections) -> str:
    density = s.beam.density
    if DENSITIES[0] <= density <= DENSITIES[1]:
        return ""
    guess = f'; did you mean "{density:g} g/cm^3"?' if 0.2 <= density < DENSITIES[0] else ""
    return f"{density:g} kg/m^3 is {'lighter than foam' if density < DENSITIES[0] else 'denser than metal'}{guess}"


def _sag(s: Scenario, sections: Sections) -> str:
    stiffness = np.min(sections.bending_stiffness(sections.second_moment.x))
    # m g L^4/(8 E I) of the beam, M g L^3/(3 E I) of the tip mass, which is in the total mass
    sag = s.gravity * sections.length**3 * (sections.mass / 8.0 + sections.tip_mass * (1 / 3 - 1 / 8)) / stiffness
    if sag < 0.5 * s.beam.length:
        return ""
    return f"a beam of {s.beam.length:g} m would bend by {sag:.3g} m under its own weight; are the units right?"


def _slenderness(s: Scenario, sections: Sections) -> str:
    radius = _gyration(sections)
    if radius <= STOUT * s.beam.length:
        return ""
    return (
        f"the radius of gyration, sqrt(I/A) = {radius:.3g} m, is more than a fifth of beam.length = "
        f"{s.beam.length:g} m: Euler-Bernoulli theory does not hold"
    )


def _fibre(s: Scenario, sections: Sections) -> str:
    fibre, least = s.beam.outer_fibre, _gyration(sections)
    if fibre == 0.0 or fibre >= least * (1.0 - 1e-9):
        return ""
    return f"{fibre:g} m is less than the radius of gyration, sqrt(I/A) = {least:.3g} m: no section is like that"


def _slope(s: Scenario, sections: Sections) -> str:
    if not s.contact.enabled or abs(s.slope.angle) <= math.pi:
        return ""
    angle = s.slope.angle
    return f'{angle:g} rad are {math.degrees(angle):.0f} degrees; did you mean "{angle:g} deg"?'


def _step(s: Scenario, sections: Sections) -> str:
    period = _period(sections)
    if s.solver.scheme == "event" or s.solver.free_step <= period:
        return ""
    return f"{s.solver.free_step:g} s is longer than the beam's first period of about {period:.3g} s"


def _period(sections: Sections) -> float:
    """Return the first period (s) of the clamped beam with its mean stiffness and mass."""
    stiffness = np.mean(sections.bending_stiffness(sections.second_moment.x))
    return float(2.0 * math.pi / _FIRST_MODE * np.sqrt(sections.mass * sections.length**3 / stiffness))


def _gyration(sections: Sections) -> float:
    """Return the largest radius of gyration (m) of the cross-sections."""
    x = np.union1d(sections.area.x, sections.second_moment.x)
    return float(np.sqrt(np.max(sections.second_moment(x) / sections.area(x))))


RULES = (
    Rule("beam.youngs_modulus", _modulus),
    Rule("beam.density", _density),
    Rule("beam.length", _sag),
    Rule("beam.second_moment", _slenderness),
    Rule("beam.outer_fibre", _fibre),
    Rule("slope.angle", _slope),
    Rule("solver.free_step", _step),
)


def doubts(scenario: Scenario) -> list[str]:
    """Return a line for each implausible value, beginning with its key; none for plausible scenarios."""
    sections = Sections.from_scenario(scenario)
    with np.errstate(all="ignore"):
        found = [(rule.key, rule.reason(scenario, sections)) for rule in RULES]
    return [f"{key}: {reason}" for key, reason in found if reason]
