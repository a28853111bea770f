"""How far the small-deflection model of the floating frame is off: estimates measured against the exact beam.

The floating frame bends linearly and knows the shortening to the second order, so that its errors grow with the
square of the deflection w over the length L:

    |dw|/w = (c_held + c_free f) (w/L)^2 + c_spin f Omega T w/L,    f = 1/(1 + 20 J_hub/J_beam)

f says how freely the root turns: 1 on a pin, 0 where it is driven, in between as the inertia of the hub makes it.
Where it is free, frame and deflection move at rates of one size, and with a spin Omega the kinetic energy has
cubic terms.  T = sqrt(3 J_beam L/(E I)) is the unit of time of the beam: the first frequencies of a uniform one
are 3.52/T with a held and 15.4/T with a pinned root.  The numbers were fitted to random loads, spins and hubs, and
tried on others (`benchmarks/small_deflection.py`, and the page "Absolute coordinates" of the documentation).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.kernels.workspace import Array
from oblique_impact.scenario.scenario import Scenario

#: a hub with this part of the beam's inertia leaves the root half of its freedom
_HALF_FREE = 0.05
#: c_held: bending without its geometric stiffening is too soft; what first-order kinetics drop makes up for most
#: of that, and for nearly all where no load but the root's own turning bends the beam
_HELD_FULL, _HELD_FIRST, _HELD_TURNING = 2.4, 0.9, 0.3
#: frame, first-order kinetics -> c_free, c_spin: on a pin the deflection from the tangent is 3.7 times that from
#: the mean axis, and in the tangent frame first-order kinetics leave a free root hardly any inertia
_FREE = {
    ("tangent", True): (1.5, 0.26),
    ("tangent", False): (1.5, 0.03),
    ("mean-axis", True): (12.0, 0.13),
    ("mean-axis", False): (6.0, 0.065),
}
#: without the shortening a spin has no centrifugal stiffness, whatever the deflection: error over (Omega T)^2
_ZEROTH = 0.25
#: error of the largest contact force over (w/L)^2, w from the tangent: a cantilever bent at its end (elastica)
_FORCE = 1.0
#: deflection of the tip from the tangent over that from the mean axis, first hinged mode
_FROM_TANGENT = 3.7
#: relative error that is worth a warning
NOTICEABLE = 0.1


def root_freedom(scenario: Scenario) -> float:
    """Return how freely the root turns: from 0, driven, to 1, on a pin or with a hub without inertia."""
    root = scenario.root
    if root.kind == "driven":
        return 0.0
    hub = root.inertia if root.kind == "hub" else 0.0
    return 1.0 / (1.0 + hub / (_HALF_FREE * Sections.from_scenario(scenario).inertia))


def deflection_error(scenario: Scenario, deflection: float, spin: float = 0.0) -> float:
    """Return the estimated relative error of the deflection, within two elastic periods.

    Parameters
    ----------
    scenario : Scenario
        Its root, frame, kinetics and loads decide.
    deflection : float
        Largest deflection (m) of a run, from the axis of its frame.
    spin : float
        Largest angular velocity (rad/s) of beam and hub as a whole.
    """
    d, share, free = scenario.discretization, deflection / scenario.beam.length, root_freedom(scenario)
    sections = Sections.from_scenario(scenario)
    unit = math.sqrt(3.0 * sections.inertia * sections.length / float(sections.bending_stiffness(0.0)))
    first = d.kinetics == "first-order"
    held = _HELD_FULL
    if first:
        held = _HELD_FIRST if scenario.gravity > 0.0 or scenario.contact.enabled else _HELD_TURNING
    of_square, of_spin = _FREE[d.frame, first]
    error = (held + of_square * free) * share**2 + of_spin * free * spin * unit * share
    return error + (_ZEROTH * (spin * unit) ** 2 if d.kinetics == "zeroth-order" else 0.0)


def contact_force_error(scenario: Scenario, deflection: float) -> float:
    """Return the estimated relative error of the largest contact force; that of the impulse is half of it.

    `deflection` is the largest one (m) of a run, from the axis of its frame.
    """
    mean = scenario.discretization.frame == "mean-axis"
    ratio = 1.0 + (_FROM_TANGENT - 1.0) * root_freedom(scenario) if mean else 1.0
    return _FORCE * (ratio * deflection / scenario.beam.length) ** 2


def largest_motion(beam: Beam, variables: Mapping[str, Array]) -> tuple[float, float]:
    """Return the largest deflection (m) of a run, and the largest spin (rad/s) of beam and hub as a whole."""
    deflection, spin = variables["uy"], variables["theta_dot"]
    if beam.scenario.discretization.frame == "tangent" and beam.scenario.root.kind != "driven":
        # angular momentum over inertia; the mean axis turns at this rate
        o = beam.operators
        spin = spin + variables["qd"][:, 1:] @ o.S / (o.J + beam.hub_inertia)
    return float(np.abs(deflection).max()), float(np.abs(spin).max())


def deflection_warnings(
    scenario: Scenario, deflection: float, spin: float = 0.0, touched: bool = True
) -> list[str]:
    """Say where small deflections are no longer small.

    `deflection` (m) and `spin` (rad/s) are the largest ones of a run, `touched` says whether there was a contact.
    """
    of_deflection = deflection_error(scenario, deflection, spin)
    of_force = contact_force_error(scenario, deflection) if touched and scenario.contact.enabled else 0.0
    if max(of_deflection, of_force) <= NOTICEABLE:
        return []
    off = f"{_off(of_deflection)} in deflection within two elastic periods"
    if of_force > 0.0:
        off += f" and {_off(of_force)} in the largest contact force"
    share, d = deflection / scenario.beam.length, scenario.discretization
    return [
        f"largest deflection {deflection:.3g} m, {100.0 * share:.2g} % of the length, {_root(scenario)}: the "
        f"small-deflection model ({d.kinetics} kinetics, {d.frame} frame) is off {off}; "
        'discretization.method = "absolute" is exact (on elastic stops)'
    ]


def _off(error: float) -> str:
    return f"by about {100.0 * error:.2g} %" if error < 1.0 else "by more than itself"


def _root(scenario: Scenario) -> str:
    root = scenario.root
    if root.kind == "hub":
        ratio = root.inertia / Sections.from_scenario(scenario).inertia
        return f"with a hub of {ratio:.2g} times the beam's inertia"
    return "on a pin" if root.kind == "pin" else "at a driven root"
