"""Which results of an impact converge under refinement, and how many modes or elements a run needs.

A rigid stop under an undamped Euler-Bernoulli beam has no limit: wave packets as strong as the first one come
back to the contact from its very beginning, and each of infinitely many contacts magnifies a difference.  Stops
that are nearly rigid share this.  Kelvin-Voigt damping eta gives a limit if the discretization resolves it: eta
omega of the highest mode at least 0.5, elements no longer than pi sqrt(eta c), c = sqrt(E I/m).

On an elastic stop everything converges, once the flexibility that modes or elements leave out of the contact
point is small against that of the stop.  One that an undamped beam meets very often in one collision magnifies
differences as well; there damping of any kind takes the wave packets away.  On one that is nearly rigid it does
not: under 0.5 % of critical by mass or 0.2 % by mode the paper's beam on 1e8 N/m is about as sensitive as without.

Time-stepping gives the impacts friction.  Where it acts along a beam that cannot stretch, as at a peg, nothing but
its foreshortening gives way to it, and the last digits of its impulses change with the step.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import eigvalsh

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam.frequencies import MAX_COUNT, lowest_elastic_frequency, natural_frequencies
from oblique_impact.beam.operators import Array, build_operators
from oblique_impact.beam.residual_flexibility import static_flexibility
from oblique_impact.contact.log import Contact
from oblique_impact.contact.state import State
from oblique_impact.scenario.messages import counted
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.sections import MAX_MODES

#: a stop this many times as stiff as the beam, free to turn, is at its contact point is nearly rigid: for the
#: paper's 3e7 N/m
_NEARLY_RIGID = 1e3
#: contacts within a macro-collision, above which an undamped beam is as good as on a rigid stop
_MANY_CONTACTS = 20
#: eta omega of the highest mode that resolves the damping
_RESOLVED = 0.5
#: damping ratio of a plain metal beam in its first bending mode, in examples and recommendations
LIGHT = 0.002
#: flexibility that is left out of the contact point over that of the stop.  Runs of the paper's beam on 1e5 to
#: 1e7 N/m (pinned, driven, on a hub; at its tip, at 0.6 m) and of a strip on 1e6 N/m with less have the largest
#: forces of 24 to 48 modes within 1.2 %, with 0.1 within 6 %, with more not within any bound.
_LEFT_OUT = 0.05
#: error of the damping by a dashpot in the clamp that gives a warning
_DASHPOT = 0.05
#: error of a frequency of a beam in modes with point masses that gives a warning
_TOO_HIGH = 0.01

_NOT_DETERMINED = "times, impulses and forces after the first touch-down are not determined"

#: entries of macro-collisions
_FORCE, _FRICTION = ("peak_force",), ("tangential_impulse",)
ALL = ("start", "end", "contacts", "normal_impulse", "tangential_impulse", "peak_force")


def unconverged_results(scenario: Scenario) -> tuple[str, ...]:
    """Return the entries of macro-collisions that do not converge with more modes or elements, or shorter steps.

    The start of the first macro-collision always converges.
    """
    stiff = is_stiff(scenario)
    if stiff and scenario.beam.kelvin_voigt == 0.0:
        return ALL
    friction = _FRICTION if _rubs_along(scenario) else ()
    return friction + _FORCE if stiff and scenario.contact.normal == "rigid" else friction


def _rubs_along(s: Scenario) -> bool:
    """Whether friction acts along a beam that cannot stretch, at its impacts too: in time-stepping."""
    stretches = s.contact.axial_flexibility or s.is_absolute
    return s.touches_anywhere and s.rubs and not stretches and s.solver.scheme == "time-stepping"


def most_meetings(
    scenario: Scenario, contacts: Sequence[Contact], macro_collisions: Sequence[Mapping[str, Any]]
) -> int:
    """Return how often stops are met in a macro-collision, at most as often as in a period of the base.

    Places of the beam that touch an obstacle at once meet it once.  Of a steady state on a shaken base all
    contacts may be one macro-collision, which has no end.
    """
    found, until = list[float](), dict[int, float]()
    for contact in sorted(contacts, key=lambda contact: contact.start):
        end = until.get(contact.obstacle, -math.inf)
        if contact.start >= end:
            found.append(contact.start)
        until[contact.obstacle] = max(end, contact.end)
    base, starts, most = scenario.base, np.array(found), len(found)
    frequencies = base.frequency, base.frequency + base.sweep_rate * scenario.end_time
    slowest = min(map(abs, frequencies)) if frequencies[0] * frequencies[1] > 0.0 else 0.0
    if base.is_shaken and not base.table and slowest > 0.0:
        most = int(np.max(np.searchsorted(starts, starts + 1.0 / slowest) - np.arange(most), initial=0))
    spans = ((starts >= m["start"]) & (starts <= m["end"]) for m in macro_collisions)
    return min(most, max((int(np.count_nonzero(span)) for span in spans), default=0))


def friction_warnings(s: Scenario, most: int) -> list[str]:
    """Return a warning if the impulses of friction have no limit; `most` as in :func:`impact_warnings`."""
    if not (most and _rubs_along(s)):
        return []
    return [
        "contact.friction: in time-stepping the tangential impulses of a beam that cannot stretch do not converge "
        "with the step; contact.axial_flexibility = true gives them a limit"
    ]


def impact_warnings(s: Scenario, most: int, beam: Beam | None = None) -> list[str]:
    """Return a warning if what follows the first touch-down has no limit, or damping is not resolved.

    `most` says how often a run meets stops in a macro-collision, see :func:`most_meetings`.  A `beam` in modes
    says how many it has.
    """
    if not most:
        return []
    damping = s.beam.kelvin_voigt
    damped = damping > 0.0 or s.beam.mass_proportional > 0.0 or s.beam.modal_damping_ratio > 0.0
    if not (is_stiff(s) or (most > _MANY_CONTACTS and not damped)):
        return []
    if damping > 0.0:
        if damping >= _resolved_damping(s, beam) * (1.0 - 1e-9):
            return []
        return [
            f"beam.kelvin_voigt: {damping:g} s is not resolved by {_resolution(s)}: {_NOT_DETERMINED}; "
            f"it takes {_size_to_resolve(s, beam, damping)}"
        ]
    under = "under a beam without Kelvin-Voigt damping"
    if s.contact.normal == "rigid":
        cause = f"a rigid stop {under} has no limit as modes or elements are added"
    else:
        stop = "a stop this stiff" if is_stiff(s) else f"a stop that is met {most} times in one collision"
        cause = f"{stop} {under} magnifies small differences like a rigid one, which has no limit"
    text = f"contact.normal: {cause}: {_NOT_DETERMINED}; give the beam the damping that it has, beam.kelvin_voigt"
    frequency = lowest_elastic_frequency(s)
    if frequency > 0.0:
        light = light_damping(s)
        share = f"{50.0 * light * frequency:.2g} % of critical in its first bending mode"
        text += f" ({light:g} s is {share} and takes {_size_to_resolve(s, beam, light)})"
    return [text if s.contact.normal != "rigid" else f'{text}, or contact.normal = "spring", an elastic stop']


def outline_warnings(scenario: Scenario, variables: Mapping[str, Array]) -> list[str]:
    """Return a warning for each elastic outline whose corners add up their stiffness.

    A straight beam touches a part of an outline without hollows at two corners at most, the ends of a piece.  If
    more are pressed in at once, there are more with shorter chords, and the force has no limit in them.
    """
    warnings = list[str]()
    for number, item in enumerate(scenario.obstacles, start=1):
        if item.outline is None or item.bedding or scenario.contact.normal == "rigid":
            continue
        own = variables["contact_obstacle"] == number
        closed = (variables["contact_state"][:, own] != State.FREE).sum(axis=1)
        k = int(np.argmax(closed))
        if closed[k] > 2 * item.outline.parts:
            warnings.append(
                f"obstacle {number} is touched at {closed[k]} places at once at t = {variables['time'][k]:.6g} s, "
                "whose stiffnesses add up: the force depends on how many points the outline has; give it longer "
                f"chords than the stretch that is pressed in, or a bed, obstacles.{number}.bedding"
            )
    return warnings


def mass_warnings(scenario: Scenario) -> list[str]:
    """Return a warning if point masses make frequencies of a beam in modes too high, which do not know them.

    They are compared with those of elements, and with those of the beam without point masses in the same modes.
    """
    s = scenario
    if s.discretization.method != "modal" or not s.point_masses:
        return []
    errors = _too_high(s) / _too_high(s.adapted(masses=[], beam__tip_mass=0.0)) - 1.0
    near = int(np.count_nonzero(errors <= _TOO_HIGH))
    if near == errors.size:
        return []
    key = "masses" if s.masses else "beam.tip_mass"
    return [
        f"{key}: modes of the beam without point masses leave out how these bend it: {near} of {errors.size} "
        f"frequencies are less than 1 % too high, the first one is {100.0 * errors[0]:.2g} %; take more modes, or "
        'discretization.method = "fem", whose modes know point masses'
    ]


def clamp_warnings(scenario: Scenario) -> list[str]:
    """Return a warning if a dashpot in a clamp is strong against what modes leave out of the root's flexibility.

    The clamp's spring carries a moment at the root alone: 1/k is all of the flexibility there.  What is left out
    stands in series with the dashpot, of which it takes a part once the dashpot holds as much as the spring.
    """
    s, k, d = scenario, scenario.root.stiffness, scenario.root.damping
    if s.root.kind != "driven" or not s.discretization.in_modes or d == 0.0 or k == 0.0:
        return []
    o = build_operators(s)
    rate = math.sqrt(eigvalsh(o.stiffness, o.elastic_mass, subset_by_index=(0, 0))[0])
    left_out = 1.0 / k - float(o.root_slope @ np.linalg.solve(o.stiffness, o.root_slope))
    error = d * rate * left_out * min(1.0, d * rate / k)
    if error <= _DASHPOT:
        return []
    return [
        f"root.damping: with {counted(o.root_slope.size, 'mode')} the dashpot of the clamp damps the first "
        f"vibration by some {100.0 * error:.2g} % too much, higher ones more: they leave out how it holds the "
        'root; take more modes, or all nodes of a mesh (discretization.method = "fem", discretization.modes = 0)'
    ]


def _too_high(s: Scenario) -> Array:
    """Frequencies (n,) of n modes over those of the beam itself, both without a spring of the hub."""
    o, held = build_operators(s), s.root.kind == "driven"
    mass = o.elastic_mass if held else o.elastic_mass - np.outer(o.coupling, o.coupling) / o.inertia
    found = np.sqrt(eigvalsh(o.stiffness, mass))
    free = s if held or s.root.stiffness == 0.0 else s.adapted(root__stiffness=0.0)
    # of a root that is free to turn the first one is the rotation itself
    rigid = 0 if held else 1
    exact = natural_frequencies(free, count=min(found.size + rigid, MAX_COUNT)).chordwise[0, rigid:]
    return np.asarray(found[: exact.size] / exact)


def truncation_warnings(beam: Beam, variables: Mapping[str, Array]) -> list[str]:
    """Return a warning if the truncated flexibility of the beam is not small against that of an elastic stop.

    The place and the stop are those of the largest force of the run; the stiffness is the secant one there.
    """
    s, top = beam.scenario, _largest_force(beam.scenario, variables)
    converges = s.beam.kelvin_voigt > 0.0 or not is_stiff(s)
    if not top.depth > 0.0 or not converges:
        return []
    stiffness = top.force / top.depth
    if s.is_nodal:  # the longest element by itself, h^3/(12 E I)
        bending = float(beam.operators.sections.bending_stiffness(top.place))
        compliance = float(beam.operators.largest_element**3 / (12.0 * bending))
    else:
        compliance = beam.residual_compliance_at(top.place)
    left = stiffness * compliance
    if not left > _LEFT_OUT:
        return []
    if s.is_nodal:
        needed = _more_elements(s, (left / _LEFT_OUT) ** (1 / 3))
    else:
        # the flexibility left out falls with the third power of the number of modes
        estimate = math.ceil(s.discretization.modes * (left / _LEFT_OUT) ** (1 / 3))
        needed = _modes(s, modes_for_stop(s, stiffness, int(0.8 * estimate), top.place) or estimate)
        if not s.contact.residual_flexibility:
            needed += ", with contact.residual_flexibility = true"
    share = f"{left:.2g} times" if left >= 1.0 else f"{100.0 * left:.2g} % of"
    return [
        f"{top.key}: the flexibility that {_resolution(s)} leave out {top.where} is {share} that of "
        f"the stop: contact forces are not those of the beam; forces within 2 % take {needed}"
    ]


class _Peak(NamedTuple):
    """The largest force of a run."""

    force: float  # N
    depth: float  # m, of the stop
    place: float  # m along the beam
    key: str  # of the scenario, that the stop has its stiffness from
    where: str  # on the beam


def _largest_force(s: Scenario, variables: Mapping[str, Array]) -> _Peak:
    """Return the largest contact force of a run."""
    key = "contact.stiffness" if s.contact.normal == "spring" else "contact.normal"
    forces = np.nan_to_num(variables["contact_lambda_n"])
    k, i = (int(at) for at in np.unravel_index(np.argmax(forces), forces.shape))
    obstacle = int(variables["contact_obstacle"][i])
    # the variable `depth` is that of the stop alone, but of the deepest of all
    depth = min(float(np.nan_to_num(variables["depth"][k])), -float(variables["contact_gap"][k, i]))
    place = float(np.clip(variables["contact_place"][k, i], 0.0, s.beam.length))
    if obstacle:
        key = f"obstacles.{obstacle}.{'bedding' if s.obstacles[obstacle - 1].bedding else 'stiffness'}"
    alone = forces.shape[1] == 1 and place == s.contact.point
    where = "of the contact point" if alone else f"at x = {place:.3g} m"
    return _Peak(float(forces[k, i]), depth, place, key, where)


def light_damping(s: Scenario) -> float:
    """Return the Kelvin-Voigt damping (s) of a plain metal beam, in two digits; 0 without a bending frequency.

    That of the beam without the spring of its root, which this does not damp.
    """
    frequency = lowest_elastic_frequency(s.adapted(root__stiffness=0.0) if s.root.stiffness > 0.0 else s)
    return float(f"{2.0 * LIGHT / frequency:.2g}") if frequency > 0.0 else 0.0


@lru_cache(maxsize=8)
def is_stiff(s: Scenario) -> bool:
    """Whether a stop is rigid or nearly so: results have a limit only with internal damping."""
    if not s.contact.enabled:
        return False
    if s.contact.normal != "spring":
        return s.contact.normal == "rigid"
    sections = Sections.from_scenario(s)
    return any(
        stiffness * static_flexibility(sections, place, clamped=False)[0, 0] > _NEARLY_RIGID
        for stiffness, place in elastic_stops(s)
    )


def elastic_stops(s: Scenario) -> list[tuple[float, float]]:
    """Return the stiffness (N/m) of each stop, and the place (m) where the undeformed beam can meet it.

    A bedding counts as if all of it under the beam were at each place.
    """
    if s.contact.where == "point":
        return [(s.contact.stiffness, s.contact.point)]
    found = [
        (side.bedding * s.beam.length if side.bedding else side.stiffness, x)
        for side in s.sides
        for x in s.beam_points
    ]
    found += [(point.stiffness, math.hypot(point.x, point.y) - s.root.hub_radius) for point in s.obstacle_points]
    return [(stiffness, x) for stiffness, x in found if 0.0 <= x <= s.beam.length]


def _resolution(s: Scenario) -> str:
    """Return the number of modes or elements of a scenario as text."""
    how = s.discretization
    return counted(how.modes, "mode") if how.in_modes else counted(how.elements, "element")


def _more_elements(s: Scenario, factor: float) -> str:
    return f"about {math.ceil(s.discretization.elements * factor)} elements"


def _resolved_damping(s: Scenario, beam: Beam | None) -> float:
    """Kelvin-Voigt damping (s) that the discretization just resolves."""
    if beam is not None and s.discretization.in_modes:
        return _RESOLVED / float(beam.operators.natural_frequencies()[-1])
    from oblique_impact.fem_beam.mesh import mesh_of  # which is built on `beam`

    sections, point = Sections.from_scenario(s), s.contact.point
    longest = float(np.max(np.diff(np.sort(mesh_of(s, sections).p[0]))))
    stiffness, mass = sections.bending_stiffness(point), sections.mass_per_length(point)
    return longest**2 / (math.pi**2 * float(np.sqrt(stiffness / mass)))


def _size_to_resolve(s: Scenario, beam: Beam | None, damping: float) -> str:
    """Return how many modes or elements resolve a Kelvin-Voigt damping (s), as text."""
    if s.discretization.in_modes:
        return _modes(s, modes_to_resolve_damping(s, damping))
    return _more_elements(s, math.sqrt(_resolved_damping(s, beam) / damping))


def modes_to_resolve_damping(s: Scenario, damping: float) -> int:
    """Return the number of modes that resolve a Kelvin-Voigt damping (s).

    High frequencies are those of the WKB approximation, omega_n = ((n + 1/4) pi)^2/(int (m/(E I))^(1/4) dx)^2
    of a hinged and n - 1/2 of a clamped beam; n - 3/4 of one on the spring of its clamp, which has a lower mode.
    """
    sections = Sections.from_scenario(s)
    x = np.linspace(0.0, sections.length, 1025)
    slowness = (sections.mass_per_length(x) / sections.bending_stiffness(x)) ** 0.25
    turns = float(np.trapezoid(slowness, x)) * math.sqrt(_RESOLVED / damping) / math.pi
    held = 0.75 if sections.clamp_stiffness > 0.0 else 0.5
    return math.ceil(turns + (-0.25 if frame_for_many_modes(s) == "mean-axis" else held))


def modes_for_stop(s: Scenario, stiffness: float, least: int = 2, place: float | None = None) -> int | None:
    """Return how many modes, at least `least`, a stop of this stiffness (N/m) at a place (m) needs.

    By default that is the contact point.  With them the truncated flexibility is at most `_LEFT_OUT` of that of
    the stop.  None if no number suffices.
    """
    d, place = s.discretization, s.contact.point if place is None else place
    # the higher half of the modes of a mesh is inaccurate
    for count in range(max(least, 1), 1 + min(MAX_MODES, d.elements if d.method == "fem" else MAX_MODES)):
        other = s.adapted(discretization__modes=count, discretization__frame=frame_for_many_modes(s))
        if stiffness * Beam(other, build_operators(other)).residual_compliance_at(place) <= _LEFT_OUT:
            return count
    return None


def frame_for_many_modes(s: Scenario) -> str:
    """Return the floating frame for many modes.

    It is the mean axis where the root turns freely, because first-order kinetics in the tangent frame allow few
    modes there.  A root at a hub's radius has no mean-axis frame.
    """
    return s.discretization.frame if s.root.is_moved else "mean-axis"


def _modes(s: Scenario, count: int) -> str:
    """Return a number of modes as text, with the frame and the elements that so many need."""
    frame, d = frame_for_many_modes(s), s.discretization
    if count > MAX_MODES:
        nodal = ', or the full nodal model (discretization.method = "fem", discretization.modes = 0)'
        return f"more than {MAX_MODES} modes{nodal if frame == 'mean-axis' else ''}"
    words = f"about {count} modes"
    if d.method == "fem" and count > d.elements:
        words += " of as many elements"
    return words if frame == d.frame else f'{words} with discretization.frame = "{frame}"'
