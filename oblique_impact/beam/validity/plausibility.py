"""Implausible values of a scenario, mostly wrong units."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.frequencies import lowest_elastic_frequency
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.sections import BaseSection, ForceSection

#: Pa; from rubber to diamond
MODULI = (1e6, 1.3e12)
#: Pa; range of common materials, to guess the unit that was meant
_COMMON = (1e9, 1.3e12)
#: kg/m^3; from plastic foam to more than osmium
DENSITIES = (20.0, 3e4)
#: radius of gyration over length, above which Euler-Bernoulli theory does not hold
MAX_GYRATION = 0.2
#: (beta L)^2 of the first mode of a clamped beam
_FIRST_MODE = 3.5160
#: damping ratio of the first bending mode: metal beams have below 0.01, bolted structures up to this
MAX_DAMPING = 0.05
#: of w^2/L, by which the end of a cantilever that a force bends by w comes nearer to its root
_FORESHORTENING = 0.6
#: sine of an angle, or acceleration (m/s^2), that is rounding
_ALONG = 1e-9
#: steps of a period of base or force: with fewer the second-order error of its impulses is above 1 %
SHAKING_STEPS = 18


@lru_cache(maxsize=8)  # the command line tells them before the run
def implausible_values(scenario: Scenario) -> tuple[str, ...]:
    """Return a line for each implausible value, beginning with its key; none for plausible scenarios."""
    with np.errstate(all="ignore"):
        sections = Sections.from_scenario(scenario)
        return (
            *_material(scenario),
            *_shape(scenario, sections),
            *_damping(scenario),
            *_slope_and_step(scenario, sections),
            *_shaken_along(scenario),
            *_missed_by_the_end(scenario),
        )


def _material(s: Scenario) -> Iterator[str]:
    modulus, density = s.beam.youngs_modulus, s.beam.density
    if not MODULI[0] <= modulus <= MODULI[1]:
        meant = next((unit for unit in (1e6, 1e9) if _COMMON[0] <= modulus * unit <= _COMMON[1]), None)
        guess = f'; did you mean "{modulus * meant / 1e9:g} GPa"?' if meant else ""
        compared = "softer than rubber" if modulus < MODULI[0] else "stiffer than diamond"
        yield f"beam.youngs_modulus: {modulus:g} Pa is {compared}{guess}"
    if not DENSITIES[0] <= density <= DENSITIES[1]:
        guess = f'; did you mean "{density:g} g/cm^3"?' if 0.2 <= density < DENSITIES[0] else ""
        compared = "lighter than foam" if density < DENSITIES[0] else "denser than metal"
        yield f"beam.density: {density:g} kg/m^3 is {compared}{guess}"


def _shape(s: Scenario, sections: Sections) -> Iterator[str]:
    length = s.beam.length
    stiffness = np.min(sections.bending_stiffness(sections.second_moment.x))
    # m g L^4/(8 E I) of the beam, M g x^2 (3 L - x)/(6 E I) at the tip of a point mass at x
    places = sections.places / length
    of_masses = float(sections.point_masses @ (places**2 * (3.0 - places) / 6.0))
    sag = s.gravity * length**3 * (sections.own_mass / 8.0 + of_masses) / stiffness
    if not sag < 0.5 * length:
        bend = f"a beam of {length:g} m would bend by {sag:.3g} m under its own weight"
        yield f"beam.length: {bend}; are the units right?"
    x = np.union1d(sections.area.x, sections.second_moment.x)
    if sections.outer_fibre is not None:
        x = np.union1d(x, sections.outer_fibre.x)
    radii = np.sqrt(sections.second_moment(x) / sections.area(x))
    radius = float(np.max(radii))
    gyration = f"the radius of gyration, sqrt(I/A) = {radius:.3g} m"
    if not radius <= MAX_GYRATION * length:
        more = f"is more than a fifth of beam.length = {length:g} m: Euler-Bernoulli theory does not hold"
        yield f"beam.second_moment: {gyration}, {more}"
    fibres = sections.fibre_distance(x)
    worst = int(np.argmin(fibres / radii))
    if sections.outer_fibre is not None and fibres[worst] < radii[worst] * (1.0 - 1e-9):
        there = f"the radius of gyration, sqrt(I/A) = {radii[worst]:.3g} m"
        yield f"beam.outer_fibre: {fibres[worst]:g} m is less than {there}: no section is like that"


def _damping(s: Scenario) -> Iterator[str]:
    beam, frequency = s.beam, lowest_elastic_frequency(s)
    if not 0.0 < frequency < math.inf:
        return
    ratios = {
        "kelvin_voigt": (0.5 * beam.kelvin_voigt * frequency, f"{beam.kelvin_voigt:g} s"),
        "mass_proportional": (0.5 * beam.mass_proportional / frequency, f"{beam.mass_proportional:g} 1/s"),
        "modal_damping_ratio": (beam.modal_damping_ratio, f"{beam.modal_damping_ratio:g}"),
    }
    for key, (ratio, value) in ratios.items():
        if ratio > MAX_DAMPING:
            share = f"{100.0 * ratio:.3g} % of critical damping in the first bending mode ({frequency:.4g} rad/s)"
            yield f"beam.{key}: {value} is {share}, motion and impulses depend on it; metal beams have below 1 %"


def _slope_and_step(s: Scenario, sections: Sections) -> Iterator[str]:
    angle, step = s.slope.angle, s.solver.free_step
    if s.contact.enabled and abs(angle) > math.pi:
        degrees = f"{math.degrees(angle):.0f} degrees"
        yield f'slope.angle: {angle:g} rad are {degrees}; did you mean "{angle:g} deg"?'
    if s.solver.scheme == "event":
        return
    # the first period of the clamped beam with its mean stiffness and mass
    stiffness = np.mean(sections.bending_stiffness(sections.second_moment.x))
    period = float(2.0 * math.pi / _FIRST_MODE * np.sqrt(sections.mass * sections.length**3 / stiffness))
    if not step <= period:
        yield f"solver.free_step: {step:g} s is longer than the beam's first period of about {period:.3g} s"
    harmonic: list[tuple[str, BaseSection | ForceSection]] = [("the base", s.base)] if s.base.is_shaken else []
    harmonic += [(f"force {number}", item) for number, item in enumerate(s.forces, start=1) if item.acts]
    for which, of in harmonic:
        fastest = max(abs(of.frequency + of.sweep_rate * t) for t in (0.0, s.end_time))
        if step * fastest * SHAKING_STEPS > 1.0:
            shown = f"a period of {which} of {1.0 / fastest:.3g} s"
            yield f"solver.free_step: {step:g} s is longer than 1/{SHAKING_STEPS} of {shown}"


def _shaken_along(s: Scenario) -> Iterator[str]:
    """Yield a base that shakes along a straight beam, which nothing bends or turns then."""
    root, start = s.root, s.initial
    at_rest = start.state == "undeformed" and start.angular_velocity == 0.0
    driven = root.torque != 0.0 or root.spin_rate != 0.0 or any(force.acts for force in s.forces)
    across = s.gravity * math.cos(start.angle), math.sin(s.base.direction - start.angle)
    if s.base.is_shaken and at_rest and not driven and max(map(abs, across)) < _ALONG:
        degrees = f"{math.degrees(start.angle - 0.5 * math.pi):.4g} deg"
        yield f'base.direction: the base shakes along the beam, which stays straight; across it is "{degrees}"'


def _missed_by_the_end(s: Scenario) -> Iterator[str]:
    """Yield pegs at the end of a held beam, which passes them by when it bends as far as that."""
    if not (s.contact.enabled and s.root.kind == "driven" and s.initial.state == "undeformed"):
        return
    length = s.beam.length
    for peg in (point for point in s.obstacle_points if not point.corner):
        seen = peg.seen_from(s.root_axis, s.initial.angle) - s.root.hub_radius
        gap = abs(seen.imag) - peg.radius - s.half_depth
        least = length - _FORESHORTENING * gap**2 / length
        if least < seen.real <= length * (1.0 + _ALONG):
            bent = f"a beam that bends to it ends at {least:.6g} m: it passes by"
            yield f"obstacles.{peg.obstacle}.origin: {seen.real:.6g} m along the beam, and {bent}"
