"""A run in words: what was simulated, for the title and the head of the page."""

from __future__ import annotations

import math

from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.sections import BeamSection
from oblique_impact.scenario.shapes import rows_of

_KINDS = {"rectangle": "rectangular beam", "circle": "circular beam", "tube": "tubular beam", "i-beam": "i-beam"}


def title_of(name: str, scenario: Scenario) -> str:
    """Return the name of a run, if it has one, with its beam and what the beam strikes or turns on."""
    if scenario.contact.enabled:
        place = f"on a slope of {math.degrees(scenario.slope.angle):.3g}°"
    else:
        place = {"pin": "on a pin", "hub": "on a hub", "driven": "on a driven root"}[scenario.root.kind]
    words = f"{beam_words(scenario.beam)} {place}"
    return f"{name}: {words}" if name else words[0].upper() + words[1:]


def beam_words(beam: BeamSection) -> str:
    """Return material, shape, length and height of a beam, and the mass at its tip, as far as it has them."""
    kind = _KINDS.get(beam.section.shape) or ("tapered beam" if isinstance(beam.area, tuple) else "beam")
    if rows_of(beam.section):
        kind = f"tapered {kind}"
    found = f"{beam.material} {kind} of {beam.length:.4g} m".strip()
    height = beam.section.diameter if beam.section.shape in ("circle", "tube") else beam.section.height
    if beam.section.shape:
        sizes = [size for _, size in height] if isinstance(height, tuple) else [height]
        least, largest = (f"{1e3 * size:.3g}" for size in (min(sizes), max(sizes)))
        found += f", {least if least == largest else f'{least} to {largest}'} mm high"
    return found + (f", {beam.tip_mass:.3g} kg at its tip," if beam.tip_mass else "")


def model_words(scenario: Scenario) -> str:
    """Return in one line how it was simulated."""
    d, c = scenario.discretization, scenario.contact
    if d.method == "modal":
        shapes = f"{d.modes} assumed modes"
    elif d.modes:
        shapes = f"{d.elements} finite elements reduced to {d.modes} modes"
    else:
        shapes = f"{d.elements} finite elements"
    if not c.enabled:
        touch = "no contact"
    else:
        elastic = f"elastic stop {c.stiffness:.3g} N/m".replace("e+0", "e")
        stop = {"rigid": "rigid stop", "spring": elastic}.get(c.normal, f"{c.normal} stop")
        coulomb = f" μ = {c.mu_kinetic:g}" if c.friction in ("hybrid", "modified-coulomb") else ""
        friction = "frictionless" if c.friction == "frictionless" else f"{c.friction} friction{coulomb}"
        touch = f"{stop}, {friction}"
    return f"{shapes}, {d.frame} frame, {d.kinetics} kinetics; {touch}; {scenario.solver.scheme} scheme"
