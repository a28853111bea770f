"""How far the small-deflection model of the floating frame is off: read from a map against an exact beam.

The map (the page "Absolute coordinates" of the documentation, ``oblique-impact refine --study small-deflection``)
holds the model against a geometrically exact beam.  Its errors grow with the square of the deflection.
"""

from __future__ import annotations

from oblique_impact.scenario.scenario import Scenario

#: relative error of the deflection over the square of the largest deflection over the length: pinned or held root
#: (hub, driven), frame, full kinetics or not.  On a pin the tip is 3.7 times as far from the root's tangent as
#: from the mean axis (first hinged mode), and the map is of the latter.
_ERRORS = {
    ("pinned", "mean-axis", False): 27.0,
    ("pinned", "mean-axis", True): 16.0,
    ("pinned", "tangent", False): 140.0 / 3.7**2,
    ("pinned", "tangent", True): 75.0 / 3.7**2,
    ("held", "tangent", False): 0.35,
    ("held", "tangent", True): 3.6,
}
#: relative error that is worth a warning
NOTICEABLE = 0.1


def deflection_error(scenario: Scenario, deflection: float) -> float:
    """Return the estimated relative error of the largest deflection (m) of a run, within two elastic periods.

    Zeroth-order kinetics are worse than this at any spin rate.  The mean axis of a held root counts as its
    tangent.
    """
    held = scenario.root.kind == "driven" or (scenario.root.kind == "hub" and scenario.root.inertia > 0.0)
    d = scenario.discretization
    key = ("held", "tangent") if held else ("pinned", d.frame)
    return _ERRORS[*key, d.kinetics == "full"] * (deflection / scenario.beam.length) ** 2


def deflection_warnings(scenario: Scenario, deflection: float) -> list[str]:
    """Say where small deflections are no longer small; `deflection` is the largest one of a run (m)."""
    error = deflection_error(scenario, deflection)
    if error <= NOTICEABLE:
        return []
    share = deflection / scenario.beam.length
    off = f"by about {100.0 * error:.0f} % of it" if error < 1.0 else "by more than itself"
    return [
        f"largest deflection {deflection:.3g} m, {100.0 * share:.2g} % of the length: the small-deflection model "
        f'is off {off} within two elastic periods; discretization.method = "absolute" is exact'
    ]
