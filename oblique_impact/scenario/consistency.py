"""Consistency of the keys of different sections of a scenario."""

from __future__ import annotations

from typing import TYPE_CHECKING

from oblique_impact.scenario.messages import refused
from oblique_impact.scenario.sections import DiscretizationSection

if TYPE_CHECKING:
    from oblique_impact.scenario.scenario import Scenario

MAX_STEPS = 1_000_000_000
MAX_VALUES = 500_000_000

#: initial gap (over the beam's length) below which the beam touches the slope
TOUCHING = 1e-12
#: distance (over the beam's length) at which a node of a given mesh is at a point
ON_NODE = 1e-9
#: least distance of the contact point from the root, over the length: its lever arm
_LEAST_POINT = 1e-3


def check(scenario: Scenario) -> None:
    """Raise InputError, in one line, for the first keys that are inconsistent."""
    # each may rely on those before it
    _check_root(scenario)
    _check_beam(scenario)
    _check_contact_point(scenario)
    _check_massless_point(scenario)
    _check_nodal_model(scenario)
    _check_exact_beam(scenario)
    _check_discretization(scenario)
    _check_solver(scenario)


def coordinates(discretization: DiscretizationSection) -> int:
    """Return the number of generalized coordinates, the angle of the frame included."""
    d = discretization
    return 1 + (6 * d.elements if d.method == "absolute" else d.modes or 2 * d.elements)


def _check_root(s: Scenario) -> None:
    speed = s.initial.angular_velocity
    if s.root.kind == "driven" and speed not in (0.0, s.initial_angular_velocity):
        raise refused("initial.angular_velocity", speed, "a driven root prescribes its own speed; leave it 0")


def _check_beam(s: Scenario) -> None:
    if s.discretization.method == "modal":
        uniform = 'the modal method knows uniform beams only; discretization.method = "fem" takes'
        for name, table in s.beam.tables().items():
            if name != "outer_fibre":  # of stresses alone
                raise refused(f"beam.{name}", table, f"{uniform} tables")
        if s.beam.tip_mass > 0.0:
            raise refused("beam.tip_mass", s.beam.tip_mass, f"{uniform} a tip mass")


def _check_contact_point(s: Scenario) -> None:
    point, length = s.contact.point, s.beam.length
    if point > length:
        raise refused("contact.point", point, f"should be on the beam, at most beam.length = {length}")
    if point < _LEAST_POINT * length:
        least = f"should be at least {_LEAST_POINT} beam.length = {_LEAST_POINT * length}"
        raise refused("contact.point", point, least)
    extent = s.slope.extent
    beyond = bool(extent) and not extent[0] <= s.initial_slip <= extent[1]
    if s.contact.enabled and s.initial_gap < -TOUCHING * length and not beyond:
        below = f"the contact point starts {-s.initial_gap:.6g} m below the slope; the gap should be at least 0"
        raise refused("initial.angle", s.initial.angle, below)


def _check_massless_point(s: Scenario) -> None:
    if s.contact.point_inertia == "kept":
        return
    without = 'contact.point_inertia = "none"'
    if s.beam.tip_mass > 0.0 and s.contact.point == s.beam.length:
        words = 'should be "kept": beam.tip_mass is the inertia of this contact point'
        raise refused("contact.point_inertia", s.contact.point_inertia, words)
    if s.solver.scheme == "fixed-step":
        words = f'should be "event" or "generalized-alpha" with {without}'
        raise refused("solver.scheme", s.solver.scheme, words)
    if s.discretization.is_nodal and s.contact.point != s.beam.length:
        words = f"should be beam.length in the full nodal model with {without}"
        raise refused("contact.point", s.contact.point, words)


def _check_nodal_model(s: Scenario) -> None:
    if not s.is_nodal:
        return
    nodal, instead = "the full nodal model", "or keep modes: discretization.modes >= 1"
    if s.root.is_moved:
        words = f"{nodal} is for a pin or a hub of radius 0; keep modes"
        raise refused("discretization.modes", s.discretization.modes, words)
    if s.solver.scheme != "generalized-alpha":
        marched = f'{nodal} (discretization.modes = 0) is marched by "generalized-alpha" only'
        raise refused("solver.scheme", s.solver.scheme, f"{marched}; leave this key out, {instead}")
    if s.beam.modal_damping_ratio > 0.0:
        words = f"{nodal} has no modes to damp; use beam.kelvin_voigt, {instead}"
        raise refused("beam.modal_damping_ratio", s.beam.modal_damping_ratio, words)


def _check_exact_beam(s: Scenario) -> None:
    scheme = s.solver.scheme
    if not s.is_absolute:
        if scheme == "energy-consistent":
            raise refused("solver.scheme", scheme, 'only with discretization.method = "absolute"')
        return
    exact = "the beam in absolute coordinates"
    if s.contact.enabled and s.contact.normal != "spring":
        words = f'{exact} meets an elastic stop only: contact.normal = "spring", as stiff as need be'
        raise refused("contact.normal", s.contact.normal, words)
    if s.contact.friction == "modified-coulomb":
        raise refused("contact.friction", s.contact.friction, f'{exact} takes "frictionless" or "hybrid"')
    if not s.contact.shortening:
        words = f"{exact} has no contact point without its shortening; leave this key out"
        raise refused("contact.shortening", s.contact.shortening, words)
    for name in ("mass_proportional", "modal_damping_ratio"):
        damping = getattr(s.beam, name)
        if damping > 0.0:
            words = f"{exact} has no frame or modes that would move without it; use beam.kelvin_voigt"
            raise refused(f"beam.{name}", damping, words)
    if s.root.kind == "hub" and s.root.hub_radius > 0.0:
        words = f"{exact} turns with a hub of radius 0; a driven root may have a radius"
        others = 'discretization.method = "fem" takes it'
        raise refused("root.hub_radius", s.root.hub_radius, f"{words}; {others}")
    if scheme != "energy-consistent":
        words = f'{exact} is marched by "energy-consistent" only, which is the default'
        raise refused("solver.scheme", scheme, words)


def _check_discretization(s: Scenario) -> None:
    d, length, point = s.discretization, s.beam.length, s.contact.point
    if d.frame == "mean-axis" and s.root.is_moved:
        words = 'the mean-axis frame is for a pin or a hub of radius 0; use "tangent" for this root'
        raise refused("discretization.frame", d.frame, words)
    if d.method != "modal" and d.elements < 2 and point < length:
        words = "should be at least 2 with a contact point inside the span"
        raise refused("discretization.elements", d.elements, words)
    if d.nodes and (d.nodes[0] != 0.0 or abs(d.nodes[-1] - length) > ON_NODE * length):
        words = f"should go from 0 to beam.length = {length}, not to {d.nodes[-1]}"
        raise refused("discretization.nodes", d.nodes, words)
    if d.nodes and min(abs(x - point) for x in d.nodes) > ON_NODE * length:
        words = f"none of them is at contact.point = {point}; the contact needs one there"
        raise refused("discretization.nodes", d.nodes, words)


def _check_solver(s: Scenario) -> None:
    interval = s.solver.output_interval
    # numbers of one sample in memory: states and accelerations, results at 33 stations, scalars
    values = 3 * coordinates(s.discretization) + 8 * 33 + 60
    if s.end_time / interval * values > MAX_VALUES:
        words = f"gives {s.end_time / interval:.3g} samples of {values} values"
        raise refused(
            "solver.output_interval", interval, f"{words}; at most {MAX_VALUES} values fit into a history"
        )
    for name in ("free_step", "contact_step"):
        step = getattr(s.solver, name)
        if s.solver.scheme != "event" and s.end_time / step > MAX_STEPS:
            raise refused(f"solver.{name}", step, f"gives more than {MAX_STEPS} steps")
