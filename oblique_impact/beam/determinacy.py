"""Which results of an impact converge as modes or elements are added, and how many a run needs.

A rigid stop under an undamped Euler-Bernoulli beam has no limit: wave packets as strong as the first one come
back to the contact from its very beginning, and each of infinitely many contacts magnifies a difference.  Stops
that are nearly rigid share this.  Kelvin-Voigt damping eta gives a limit if the discretization resolves it: eta
omega of the highest mode at least 0.5, elements no longer than pi sqrt(eta c), c = sqrt(E I/m).

On an elastic stop everything converges, once the flexibility that modes or elements leave out of the contact
point is small against that of the stop.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.frequencies import lowest_elastic_frequency
from oblique_impact.beam.operators import Array, build_operators
from oblique_impact.beam.residual_flexibility import static_compliance
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.sections import MAX_MODES

#: a stop this many times as stiff as the beam, free to turn, is at its contact point is nearly rigid: for the
#: paper's 3e7 N/m
_NEARLY_RIGID = 1e3
#: contacts within a macro-collision, above which an undamped beam is as good as on a rigid stop
_MANY_CONTACTS = 20
#: eta omega of the highest mode that resolves the damping
_RESOLVED = 0.5
#: part of critical in the first bending mode, of a plain metal beam: the damping of examples and recommendations
LIGHT = 0.002
#: flexibility that is left out of the contact point over that of the stop.  Runs of the paper's beam on 1e5 to
#: 1e7 N/m (pinned, driven, on a hub; at its tip, at 0.6 m) and of a strip on 1e6 N/m with less have the largest
#: forces of 24 to 48 modes within 1.2 %, with 0.1 within 6 %, with more not within any bound.
_LEFT_OUT = 0.05

#: entries of macro-collisions
_FORCE = ("peak_force",)
_ALL = ("start", "end", "contacts", "normal_impulse", "tangential_impulse", "peak_force")


def without_limit(scenario: Scenario) -> tuple[str, ...]:
    """Return the entries of macro-collisions that have no limit as modes or elements are added.

    The start of the first one always has.
    """
    if not is_stiff(scenario):
        return ()
    if scenario.beam.kelvin_voigt == 0.0:
        return _ALL
    return _FORCE if scenario.contact.normal == "rigid" else ()


def undetermined(beam: Beam, contacts: Sequence[int]) -> list[str]:
    """Return warnings about results without a limit; `contacts` counts those of each macro-collision."""
    s = beam.scenario
    many = max(contacts, default=0) > _MANY_CONTACTS
    if not contacts or not (is_stiff(s) or many):
        return []
    viscosity = s.beam.kelvin_voigt
    if viscosity > 0.0:
        if viscosity >= _least_viscosity(beam) * (1.0 - 1e-9):
            return []
        return [
            f"beam.kelvin_voigt: {viscosity:g} s is not resolved by {_size(s)}: times, impulses and forces after "
            f"the first touch-down are not determined; it takes {_resolving(beam, viscosity)}"
        ]
    under = "under a beam without Kelvin-Voigt damping"
    if s.contact.normal == "rigid":
        cause = f"a rigid stop {under} has no limit as modes or elements are added"
    else:
        stop = "a stop this stiff" if is_stiff(s) else f"a stop that is met {max(contacts)} times in one collision"
        cause = f"{stop} {under} magnifies small differences like a rigid one, which has no limit"
    said = (
        f"contact.normal: {cause}: times, impulses and forces after the first touch-down are not determined; "
        "give the beam the damping that it has, beam.kelvin_voigt"
    )
    frequency = lowest_elastic_frequency(s)
    if frequency > 0.0:
        light = light_damping(s)
        share = f"{50.0 * light * frequency:.2g} % of critical in its first bending mode"
        said += f" ({light:g} s is {share} and takes {_resolving(beam, light)})"
    return [said if s.contact.normal != "rigid" else f'{said}, or contact.normal = "spring", an elastic stop']


def truncated(beam: Beam, variables: Mapping[str, Array]) -> list[str]:
    """Return a warning if an elastic stop is not softer than what the discretization leaves out of the beam.

    The stiffness of the stop is that at the largest force of the run.
    """
    force, depth = np.nan_to_num(variables["lambda_n"]), np.nan_to_num(variables["depth"])
    top = int(np.argmax(force))
    if not depth[top] > 0.0 or _has_no_limit(beam.scenario):
        return []
    s, stiffness = beam.scenario, float(force[top] / depth[top])
    left = stiffness * (_element_compliance(beam) if s.is_nodal else beam.residual_compliance)
    if not left > _LEFT_OUT:
        return []
    if s.is_nodal:
        needed = f"about {_more_elements(s, (left / _LEFT_OUT) ** (1 / 3))}"
    else:
        needed = _leaving(beam, stiffness, left)
        if not s.contact.residual_flexibility:
            needed += ", with contact.residual_flexibility = true"
    share = f"{left:.2g} times" if left >= 1.0 else f"{100.0 * left:.2g} % of"
    key = "contact.stiffness" if s.contact.normal == "spring" else "contact.normal"
    return [
        f"{key}: the flexibility that {_size(s)} leave out of the contact point is {share} that of "
        f"the stop: contact forces are not those of the beam; forces within 2 % take {needed}"
    ]


def light_damping(s: Scenario) -> float:
    """Return the Kelvin-Voigt damping (s) of a plain metal beam, in two digits; 0 if nothing bends."""
    frequency = lowest_elastic_frequency(s)
    return float(f"{2.0 * LIGHT / frequency:.2g}") if frequency > 0.0 else 0.0


def _has_no_limit(s: Scenario) -> bool:
    """Whether no number of modes or elements gives the forces of an elastic stop."""
    return s.beam.kelvin_voigt == 0.0 and is_stiff(s)


def is_stiff(s: Scenario) -> bool:
    """Whether a stop is rigid or nearly so: results have a limit only with internal damping."""
    if not s.contact.enabled:
        return False
    if s.contact.normal != "spring":
        return s.contact.normal == "rigid"
    compliance = static_compliance(Sections.from_scenario(s), s.contact.point, clamped=False)
    return s.contact.stiffness * compliance > _NEARLY_RIGID


def _size(s: Scenario) -> str:
    """Return the number of modes or elements of a scenario in words."""
    return f"{s.discretization.elements} elements" if s.is_nodal else f"{s.discretization.modes} modes"


def _more_elements(s: Scenario, factor: float) -> str:
    return f"{math.ceil(s.discretization.elements * factor)} elements"


def _least_viscosity(beam: Beam) -> float:
    """Kelvin-Voigt damping (s) that the discretization just resolves."""
    o, s = beam.operators, beam.scenario
    if not s.is_nodal:
        return _RESOLVED / float(o.natural_frequencies()[-1])
    return o.largest_element**2 / (math.pi**2 * _wave(o.sections, s.contact.point))


def _wave(sections: Sections, x: float) -> float:
    """Return sqrt(E I/m) (m^2/s) at a place (m)."""
    return float(np.sqrt(sections.bending_stiffness(x) / sections.mass_per_length(x)))


def _element_compliance(beam: Beam) -> float:
    """Compliance (m/N) of the longest element of a nodal model by itself, h^3/(12 E I)."""
    sections, x = beam.operators.sections, beam.scenario.contact.point
    return float(beam.operators.largest_element**3 / (12.0 * sections.bending_stiffness(x)))


def _resolving(beam: Beam, viscosity: float) -> str:
    """Return how many modes or elements resolve a Kelvin-Voigt damping (s), in words."""
    s = beam.scenario
    if s.is_nodal:
        factor = math.sqrt(_least_viscosity(beam) / viscosity)
        return f"about {_more_elements(s, factor)}"
    return _modes(s, modes_that_resolve(s, viscosity))


def modes_that_resolve(s: Scenario, viscosity: float) -> int:
    """Return the number of modes that resolve a Kelvin-Voigt damping (s).

    High frequencies are those of the WKB approximation, omega_n = ((n + 1/4) pi)^2/(int (m/(E I))^(1/4) dx)^2
    of a hinged and n - 1/2 of a clamped beam.
    """
    sections = Sections.from_scenario(s)
    x = np.linspace(0.0, sections.length, 1025)
    slowness = (sections.mass_per_length(x) / sections.bending_stiffness(x)) ** 0.25
    turns = float(np.trapezoid(slowness, x)) * math.sqrt(_RESOLVED / viscosity) / math.pi
    return math.ceil(turns - (0.25 if frame_of_many(s) == "mean-axis" else -0.5))


def _leaving(beam: Beam, stiffness: float, left: float) -> str:
    """Return how many modes leave out no more than `_LEFT_OUT` of a stop's flexibility, in words.

    `left` is what they leave out now; it falls with the third power of their number.
    """
    estimate = math.ceil(beam.scenario.discretization.modes * (left / _LEFT_OUT) ** (1.0 / 3.0))
    return _modes(beam.scenario, modes_for_stop(beam.scenario, stiffness, int(0.8 * estimate)) or estimate)


def modes_for_stop(s: Scenario, stiffness: float, least: int = 2) -> int | None:
    """Return the number of modes, at least `least`, that a stop of this stiffness (N/m) needs.

    So many leave out no more than `_LEFT_OUT` of its flexibility.  None if no number does.
    """
    d = s.discretization
    # of elements the higher half of the modes is poor
    for count in range(max(least, 1), 1 + min(MAX_MODES, d.elements if d.method == "fem" else MAX_MODES)):
        other = s.replace(discretization__modes=count, discretization__frame=frame_of_many(s))
        if stiffness * Beam(other, build_operators(other)).residual_compliance <= _LEFT_OUT:
            return count
    return None


def frame_of_many(s: Scenario) -> str:
    """Return the floating frame for many modes.

    Of a root that turns freely it is the mean axis: first-order kinetics in its tangent frame bear few modes.  A
    root at a hub's radius has no mean-axis frame.
    """
    free = s.root.kind != "driven" and s.root.hub_radius == 0.0
    return "mean-axis" if free else s.discretization.frame


def _modes(s: Scenario, count: int) -> str:
    """Return a number of modes in words, with the frame and the elements that so many need."""
    frame, d = frame_of_many(s), s.discretization
    if count > MAX_MODES:
        nodal = ', or the full nodal model (discretization.method = "fem", discretization.modes = 0)'
        return f"more than {MAX_MODES} modes{nodal if frame == 'mean-axis' else ''}"
    words = f"about {count} modes"
    if d.method == "fem" and count > d.elements:
        words += " of as many elements"
    return words if frame == d.frame else f'{words} with discretization.frame = "{frame}"'
