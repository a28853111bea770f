"""Estimated errors of the small-deflection model of the floating frame, fitted to the exact beam.

In the floating frame bending is linear and the shortening of second order, so that errors grow with the
square of the deflection w over the length L:

    |dw|/w = (c_held + c_free f + c_torque/j) (w/L)^2 + c_spin f Omega T w/L,    f = 1/(1 + 10 j)^2

j is the inertia of the hub over that of the beam.  f says how freely the root turns: 1 on a pin, 0 where it is
driven; 1 + 10 j is the modal mass of the first hinged mode with its hub.  Where the root is free, frame and
deflection move at rates of one size, and with a spin Omega the kinetic energy has cubic terms, which first-order
kinetics drop.  T = sqrt(3 J_beam L/(E I)) is the unit of time of the beam: the first frequencies of a uniform one
are 3.52/T with a held and 15.4/T with a pinned root.

In the tangent frame first-order kinetics also take B^T (C - M1) B from the inertia about the root, which full
kinetics give back in other terms, and with it an angular momentum, whose rate is a moment on the root that is not
there.  The root vibrates under it with the modal inertia J_beam (0.1 + j), and the deflection from its tangent is
off by as much.  So in place of c_spin there is, where 1 + 2.7 j is that inertia times the first frequency over a
pin's,

    c_lost max |theta_dot B^T (C - M1) B| T L/((1 + 2.7 j) J_beam w)

A torque on the hub makes this momentum grow steadily, and what counts is the hub's own inertia less what is taken
(c_torque).  The numbers were fitted to random loads, spins and hubs, and tried on others
(the page "Absolute coordinates" of the documentation, whose numbers are kept in docs/small-deflection*.json).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.kernels.workspace import Array
from oblique_impact.scenario.scenario import Scenario

#: slope of the first hinged mode at the root, squared, times the beam's inertia over its modal mass
_MODAL = 10.0
#: c_held: bending without its geometric stiffening is too soft.  The terms that first-order kinetics drop
#: compensate most of that, and more where the beam turns under its load, at 2/T or faster
_HELD_FULL, _HELD_FIRST, _HELD_TURNING, _TURNING = 2.4, 0.9, 0.3, 2.0
#: frame, first-order kinetics -> c_free, c_torque, c_spin: w is measured in the frame, see `_FROM_TANGENT`
_FREE = {
    ("tangent", True): (0.0, 0.042, 0.26),
    ("tangent", False): (1.0, 0.0, 0.035),
    ("mean-axis", True): (11.5, 0.14, 0.09),
    ("mean-axis", False): (6.0, 0.0, 0.05),
}
#: c_lost, and the hub's part in modal inertia times first frequency; errors were 0.8 to 2.7 times the term without
#: c_lost, which is chosen for rather a false alarm than none
_LOST, _HEAVIER = 1.7, 2.7
#: inertia about the root of a beam without a hub that six clamped modes leave, over its own
_LEFT = 2e-4
#: without the shortening a spin has no centrifugal stiffness, whatever the deflection: error over (Omega T)^2
_ZEROTH = 0.25
#: error of the largest contact force over (w/L)^2, w from the tangent: a cantilever bent at its end (elastica).
#: It is bent all along; one that lies on an obstacle with its outer part is bent as much by less, and its largest
#: slope over the cantilever's, 1.5 w/L, says how much
_FORCE, _SLOPE = 1.0, 1.5
#: deflection of the tip from the tangent over that from the mean axis, first hinged mode; and the hub's inertia
#: over the beam's that takes half of what is above 1
_FROM_TANGENT, _HALF = 3.7, 0.4
#: relative error that gives a warning
NOTICEABLE = 0.1


class LargestMotion(NamedTuple):
    """Largest deflection (m), from the axis of the frame, and rates of a run that decide how exact it is.

    `spin` (rad/s) is the angular velocity of beam and hub as a whole, `lost_momentum` (kg m^2/s) the angular
    momentum theta_dot B^T (C - M1) B that first-order kinetics leave out in the tangent frame; 0 in other models.
    `turn` (rad) is the largest angle between a section and that of the root.
    """

    deflection: float
    spin: float = 0.0
    lost_momentum: float = 0.0
    turn: float = 0.0


def root_freedom(scenario: Scenario) -> float:
    """Return the factor f of a root that turns freely: 0 if driven, 1 on a pin or with a hub without inertia."""
    return 0.0 if scenario.root.kind == "driven" else (1.0 + _MODAL * _hub(scenario)) ** -2


def _hub(scenario: Scenario) -> float:
    """Inertia of the hub over that of the beam."""
    root = scenario.root
    return root.inertia / Sections.from_scenario(scenario).inertia if root.kind == "hub" else 0.0


def deflection_error(scenario: Scenario, motion: LargestMotion) -> float:
    """Return the estimated relative error of the deflection, within two elastic periods.

    Root, frame, kinetics and loads of the scenario decide, and the motion of the run.
    """
    deflection, spin, lost_momentum, _ = motion
    d, share, free = scenario.discretization, deflection / scenario.beam.length, root_freedom(scenario)
    sections = Sections.from_scenario(scenario)
    unit = math.sqrt(3.0 * sections.inertia * sections.length / float(sections.bending_stiffness(0.0)))
    first = d.kinetics == "first-order"
    held = _HELD_FULL
    if first:
        held = _HELD_TURNING + (_HELD_FIRST - _HELD_TURNING) / (1.0 + (spin * unit / _TURNING) ** 2)
    of_root, of_torque, of_spin = _FREE[d.frame, first]
    pushed = scenario.root.kind == "hub" and scenario.root.torque != 0.0
    if pushed:
        held += of_torque / (_hub(scenario) + _LEFT)
    error = (held + of_root * free) * share**2
    if pushed or lost_momentum == 0.0:
        error += of_spin * free * spin * unit * share
    else:
        error += _LOST * lost_momentum * unit / ((1.0 + _HEAVIER * _hub(scenario)) * sections.inertia * share)
    return error + (_ZEROTH * (spin * unit) ** 2 if d.kinetics == "zeroth-order" else 0.0)


def contact_force_error(scenario: Scenario, motion: LargestMotion) -> float:
    """Return the estimated relative error of the largest contact force; that of the impulse is half of it.

    The largest slope of the run decides at a driven root, where it asks for more than the deflection.
    """
    mean = scenario.discretization.frame == "mean-axis"
    ratio = 1.0 + (_FROM_TANGENT - 1.0) / (1.0 + _hub(scenario) / _HALF) if mean else 1.0
    share = ratio * motion.deflection / scenario.beam.length
    if scenario.root.kind == "driven":
        share = max(share, motion.turn / _SLOPE)
    return _FORCE * share**2


def largest_motion(beam: Beam, variables: Mapping[str, Array]) -> LargestMotion:
    """Return what the estimates need of a run, from its variables `uy`, `theta_dot`, `q` and `qd`."""
    discretization, o = beam.scenario.discretization, beam.operators
    spin, lost = variables["theta_dot"], np.zeros(1)
    if discretization.frame == "tangent" and beam.scenario.root.kind != "driven":
        B, Bd = variables["q"][:, 1:], variables["qd"][:, 1:]
        if discretization.kinetics == "first-order":
            lost = spin * np.einsum("si,si->s", B @ (o.C - o.M1), B)
        # angular momentum over inertia; the mean axis turns at this rate
        spin = spin + Bd @ o.coupling / o.inertia
    slopes = variables["q"][:, 1:] @ o.stations.slopes.T
    found = variables["uy"], spin, lost, slopes - slopes[:, :1]
    return LargestMotion(*(float(np.abs(values).max()) for values in found))


def deflection_warnings(beam: Beam, variables: Mapping[str, Array]) -> list[str]:
    """Return a warning if the deflection of a run is too large for the model."""
    s, motion = beam.scenario, largest_motion(beam, variables)
    deflection = motion.deflection
    of_deflection, of_force = deflection_error(s, motion), 0.0
    if s.contact.enabled and np.any(variables["state"] > 0):
        of_force = contact_force_error(s, motion)
    if max(of_deflection, of_force) <= NOTICEABLE:
        return []

    def off(error: float) -> str:
        return f"by about {100.0 * error:.2g} %" if error < 1.0 else "by more than itself"

    words = f"{off(of_deflection)} in deflection within two elastic periods"
    if of_force > 0.0:
        words += f" and {off(of_force)} in the largest contact force"
    hub = f"with a hub of {_hub(s):.2g} times the beam's inertia"
    root = {"pin": "on a pin", "driven": "at a driven root", "hub": hub}[s.root.kind]
    share, d = deflection / s.beam.length, s.discretization
    return [
        f"largest deflection {deflection:.3g} m, {100.0 * share:.2g} % of the length, {root}: the "
        f"small-deflection model ({d.kinetics} kinetics, {d.frame} frame) is off {words}; "
        'discretization.method = "absolute" is exact'
    ]
