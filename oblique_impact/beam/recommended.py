"""Settings recommended for a beam of one's own: floating frame, number of modes, a little damping."""

from __future__ import annotations

from oblique_impact.beam.determinacy import (
    LIGHT,
    frame_of_many,
    is_stiff,
    light_damping,
    modes_for_stop,
    modes_that_resolve,
)
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.sections import MAX_MODES

#: modes of a beam whose stop asks for no more
_LEAST = 6


def recommended(scenario: Scenario) -> tuple[Scenario, list[str]]:
    """Return a scenario with the discretization and damping that suit its beam and stop, and why.

    Assumed modes where the sections are uniform, else those of finite elements; as many as the stop asks for; the
    floating frame that bears so many; the damping of a plain metal beam where none is given.

    Parameters
    ----------
    scenario : Scenario
        Beam, root and contact.

    Returns
    -------
    tuple of Scenario and list of str
        The scenario and a line for each setting.
    """
    said = []
    frame = frame_of_many(scenario)
    varies = isinstance(scenario.beam.area, tuple) or isinstance(scenario.beam.second_moment, tuple)
    method = "fem" if varies or scenario.beam.tip_mass > 0.0 else "modal"
    found = scenario.replace(
        discretization__method=method,
        discretization__frame=frame,
        discretization__modes=_LEAST,
        discretization__elements=MAX_MODES if method == "fem" else scenario.discretization.elements,
        solver__scheme="event",
    )
    said.append(f"discretization.frame: {_FRAMES[frame]}")
    beam = scenario.beam
    if not (beam.kelvin_voigt or beam.modal_damping_ratio or beam.mass_proportional):
        found = found.replace(beam__kelvin_voigt=light_damping(found))
        share = f"{100.0 * LIGHT:g} % of critical in the first bending mode"
        said.append(f"beam.kelvin_voigt: {share}, as of a plain metal beam; measure yours")
    if not scenario.contact.enabled:
        return found, said
    if is_stiff(found):
        count = modes_that_resolve(found, found.beam.kelvin_voigt) if found.beam.kelvin_voigt else MAX_MODES
        why = "so many resolve the damping, without which a stop this stiff has no limit"
    else:
        count = modes_for_stop(found, found.contact.stiffness, _LEAST) or MAX_MODES
        why = "what so many leave out is stiff against the stop"
    said.append(f"discretization.modes: {why}; try more (oblique-impact refine)")
    return found.replace(discretization__modes=min(max(count, _LEAST), MAX_MODES)), said


_FRAMES = {
    "mean-axis": "the mean axis bears any number of modes with first-order kinetics",
    "tangent": "the one for a root that is driven or at a hub's radius",
}
