"""Recommended settings for a user's beam: discretization, floating frame, number of modes, light damping."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from oblique_impact.beam.cross_sections import Sections, check_numbers
from oblique_impact.beam.frequencies import lowest_elastic_frequency
from oblique_impact.beam.validity.limits import (
    LIGHT,
    elastic_stops,
    frame_for_many_modes,
    is_stiff,
    light_damping,
    modes_for_stop,
    modes_to_resolve_damping,
)
from oblique_impact.errors import InputError
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.sections import MAX_MODES

#: modes of a beam whose stop needs no more
_LEAST = 6
#: of E I/L, a clamp that lowers the first frequency of a uniform beam by 1 %
_STIFF = 200.0


def recommended(scenario: Scenario, kept: Collection[str] = ()) -> tuple[Scenario, list[str]]:
    """Return a scenario with recommended discretization and damping for its beam and stop, and the reasons.

    Assumed modes where the sections are uniform, else those of finite elements; as many as the stop needs; the
    floating frame that allows so many; the damping of a plain metal beam where none is given.

    Parameters
    ----------
    scenario : Scenario
        Beam, root and contact.
    kept : collection of str
        Keys ("section.key") that stay as they are.

    Returns
    -------
    tuple of Scenario and list of str
        The scenario and a line for each setting.

    Raises
    ------
    InputError
        For a beam whose frequencies floating-point numbers cannot hold, and one that nothing holds.
    """
    if scenario.root.is_free:
        raise InputError('--recommended: modes are recommended, which know no root.kind = "free"; leave this out')
    check_numbers(Sections.from_scenario(scenario))
    beam, contact = scenario.beam, scenario.contact
    tapered = any(isinstance(value, tuple) for value in (beam.area, beam.second_moment))
    varies, what = tapered or bool(scenario.point_masses), "sections vary" if tapered else "there are point masses"
    frame = frame_for_many_modes(scenario)
    damped = beam.kelvin_voigt
    if not (contact.enabled and is_stiff(scenario)):  # which Kelvin-Voigt damping alone gives a limit
        damped = damped or beam.modal_damping_ratio or beam.mass_proportional
    light = light_damping(scenario)
    share = f"{100.0 * LIGHT:g} % of critical in the first bending mode, as of a plain metal beam; measure yours"
    wanted: dict[str, tuple[Any, str]] = {
        "discretization.method": ("fem", what) if varies else ("modal", "the sections are uniform"),
        "discretization.frame": (frame, _FRAMES[frame]),
        "discretization.kinetics": ("first-order", "enough for small deflections"),
        "beam.kelvin_voigt": (beam.kelvin_voigt, "as given") if damped else (light, share),
        "solver.scheme": ("event", "transitions are located"),
    }
    wanted = {key: value for key, value in wanted.items() if key not in kept}
    values = {key: value for key, (value, _) in wanted.items()}
    if "discretization.modes" not in kept:  # with many elements: the higher half of their modes is inaccurate
        values["discretization.modes"] = _LEAST
        if values.get("discretization.method", scenario.discretization.method) == "fem":
            values["discretization.elements"] = max(MAX_MODES, scenario.discretization.elements)
    found = _with(scenario, values)
    if "discretization.modes" not in kept:
        count, why = _LEAST, "few are enough"
        if contact.enabled and is_stiff(found) and found.beam.kelvin_voigt > 0.0:
            count, why = modes_to_resolve_damping(found, found.beam.kelvin_voigt), "resolve the damping"
        if contact.enabled and contact.normal == "spring":
            counts = (modes_for_stop(found, k, _LEAST, place) for k, place in elastic_stops(found))
            needed = max((count or MAX_MODES + 1 for count in counts), default=_LEAST)
            if needed >= count:
                count, why = needed, "leave out little of the stop's flexibility"
        if count > MAX_MODES:
            why = 'the most; more are needed: take discretization.method = "fem" and modes = 0, all of its nodes'
        wanted["discretization.modes"] = max(_LEAST, min(count, MAX_MODES)), why
        found = _with(found, {"discretization.modes": wanted["discretization.modes"][0]})
    reasons = [f"{key} = {value}: {why}" for key, (value, why) in wanted.items()]
    return found, reasons + ([_of_clamp(scenario)] if scenario.root.kind == "driven" else [])


def _of_clamp(scenario: Scenario) -> str:
    """Say by how much the clamp of a root that is held or driven lowers the first frequency.

    That of a uniform beam falls by the part 2 E I/(k L) where the spring k is stiff.
    """
    sections, given = Sections.from_scenario(scenario), scenario.root.stiffness
    stiffness = given or float(f"{_STIFF * float(sections.bending_stiffness(0.0)) / sections.length:.2g}")
    yielding, rigid = (
        lowest_elastic_frequency(scenario.adapted(root__stiffness=k, root__damping=0.0)) for k in (stiffness, 0.0)
    )
    lower = f"{100.0 * (1.0 - yielding / rigid):.2g} %"
    if given:
        return f"root.stiffness = {given:g}: its clamp yields, which lowers the first frequency by {lower}"
    return f"root.stiffness = 0: a rigid clamp; one of {stiffness:g} N m/rad lowers the first frequency by {lower}"


def _with(scenario: Scenario, values: dict[str, Any]) -> Scenario:
    return scenario.adapted(**{key.replace(".", "__"): value for key, value in values.items()})


_FRAMES = {
    "mean-axis": "allows any number of modes with first-order kinetics",
    "tangent": "of a root that is driven or at a hub's radius",
}
