"""What of an impact has a limit as modes or elements are added, and the damping that gives it one.

A rigid stop under an undamped Euler-Bernoulli beam has no limit: wave packets as strong as the first one come
back to the contact from its very beginning, and each of infinitely many contacts magnifies a difference.  Stops
that are nearly rigid share this.  Kelvin-Voigt damping eta gives a limit if the discretization resolves it: eta
omega of the highest mode at least 0.5, elements no longer than pi sqrt(eta c), c = sqrt(E I/m).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.residual_flexibility import static_compliance
from oblique_impact.scenario.scenario import Scenario

#: a stop this many times as stiff as the beam, free to turn, is at its contact point is nearly rigid: for the
#: paper's 3e7 N/m
_NEARLY_RIGID = 1e3
#: contacts within a macro-collision, above which an undamped beam is as good as on a rigid stop
_MANY_CONTACTS = 20
#: eta omega of the highest mode that resolves the damping
_RESOLVED = 0.5

#: entries of macro-collisions
_FORCE = ("peak_force",)
_ALL = ("start", "end", "contacts", "normal_impulse", "tangential_impulse", "peak_force")


def without_limit(scenario: Scenario) -> tuple[str, ...]:
    """Return the entries of macro-collisions that have no limit as modes or elements are added.

    The start of the first one always has.
    """
    if not _is_stiff(scenario):
        return ()
    if scenario.beam.kelvin_voigt == 0.0:
        return _ALL
    return _FORCE if scenario.contact.normal == "rigid" else ()


def undetermined(beam: Beam, contacts: Sequence[int]) -> list[str]:
    """Say what of the macro-collisions of a run, with so many contacts each, has no limit and what gives one."""
    s = beam.scenario
    many = max(contacts, default=0) > _MANY_CONTACTS
    if not contacts or not (_is_stiff(s) or many):
        return []
    viscosity, resolved = s.beam.kelvin_voigt, _least_viscosity(beam)
    if viscosity == 0.0:
        stop = "a rigid stop" if s.contact.normal == "rigid" else "a stop this stiff"
        if not _is_stiff(s):
            stop = f"a stop that is met {max(contacts)} times in one collision"
        return [
            f"contact.normal: {stop} under an undamped beam has no limit as modes or elements are added: times "
            "and impulses after the first touch-down are not determined; damping that this discretization "
            f"resolves, beam.kelvin_voigt = {_up(resolved)} s or more, gives it one"
        ]
    if viscosity < resolved * (1.0 - 1e-9):
        key, count = ("elements", s.discretization.elements) if s.is_nodal else ("modes", s.discretization.modes)
        needed = math.ceil(count * math.sqrt(resolved / viscosity))
        return [
            f"beam.kelvin_voigt: {viscosity:g} s is not resolved by {count} {key}: what follows the first "
            f"touch-down is not determined; take about {needed} {key}, or {_up(resolved)} s or more"
        ]
    return []


def _up(value: float) -> str:
    """Return a number in two digits, rounded up."""
    power = 10.0 ** (math.floor(math.log10(value)) - 1)
    return f"{math.ceil(value / power * (1.0 - 1e-12)) * power:.2g}"


def _is_stiff(s: Scenario) -> bool:
    if not s.contact.enabled:
        return False
    if s.contact.normal != "spring":
        return s.contact.normal == "rigid"
    compliance = static_compliance(Sections.from_scenario(s), s.contact.point, clamped=False)
    return s.contact.stiffness * compliance > _NEARLY_RIGID


def _least_viscosity(beam: Beam) -> float:
    """Kelvin-Voigt damping (s) that the discretization just resolves."""
    o, s = beam.operators, beam.scenario
    if not s.is_nodal:
        return _RESOLVED / float(o.natural_frequencies()[-1])
    sections, x = o.sections, s.contact.point
    wave = float(np.sqrt(sections.bending_stiffness(x) / sections.mass_per_length(x)))
    return o.largest_element**2 / (math.pi**2 * wave)
