"""Consistency of the keys of different sections of a scenario."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

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


def coordinates(discretization: DiscretizationSection) -> int:
    """Return the number of generalized coordinates, the angle of the frame included."""
    d = discretization
    return 1 + (6 * d.elements if d.method == "absolute" else d.modes or 2 * d.elements)


def conflicts(s: Scenario) -> Iterator[tuple[str, str]]:
    """Yield each key that does not fit the others, with what is allowed; each may rely on those before it."""
    if s.root.kind == "driven" and s.initial.angular_velocity not in (0.0, s.initial_angular_velocity):
        yield "initial.angular_velocity", "a driven root prescribes its own speed; leave it 0"
    if s.discretization.method == "modal":
        uniform = 'the modal method knows uniform beams only; discretization.method = "fem" takes'
        for name in s.beam.tables():
            if name != "outer_fibre":  # of stresses alone
                yield f"beam.{name}", f"{uniform} tables"
        if s.beam.tip_mass > 0.0:
            yield "beam.tip_mass", f"{uniform} a tip mass"
    yield from _of_contact_anywhere(s) if s.contact.where == "anywhere" else _of_one_contact(s)
    yield from _of_contact_point(s)
    if s.contact.point_inertia == "none":
        yield from _of_massless_point(s)
    if s.is_nodal:
        yield from _of_nodal_model(s)
    if s.is_absolute:
        yield from _of_exact_beam(s)
    elif s.solver.scheme == "energy-consistent":
        yield "solver.scheme", 'only with discretization.method = "absolute"'
    yield from _of_discretization(s)
    yield from _of_solver(s)


def _of_one_contact(s: Scenario) -> Iterator[tuple[str, str]]:
    needed = 'only with contact.where = "anywhere"'
    if s.obstacles:
        yield "obstacles", needed
    if s.contact.grid != 1:
        yield "contact.grid", needed
    if not s.slope.enabled:
        yield "slope.enabled", f"{needed}; contact.enabled = false is free motion"


def _of_contact_anywhere(s: Scenario) -> Iterator[tuple[str, str]]:
    anywhere, d = 'with contact.where = "anywhere"', s.discretization
    if s.contact.restitution > 0.0:
        yield "contact.restitution", f"should be 0 {anywhere}: the impacts of several contacts are plastic"
    if s.contact.impact != "newton":
        yield "contact.impact", f'should be "newton" {anywhere}'
    if s.contact.point_inertia != "kept":
        yield "contact.point_inertia", f'should be "kept" {anywhere}'
    if not s.contact.shortening:
        yield "contact.shortening", f"should be true {anywhere}"
    if d.kinetics == "zeroth-order":
        yield "discretization.kinetics", f'should be "first-order" or "full" {anywhere}'
    if s.is_nodal:
        yield "discretization.modes", f"should be at least 1 {anywhere}"
    if s.is_absolute:
        yield "discretization.method", f'should be "modal" or "fem" {anywhere}'
    elif s.solver.scheme != "event" and not s.is_nodal:
        yield "solver.scheme", f'should be "event" {anywhere}'
    depths = {s.beam.fibre_distance(s.beam.length * part / 16) for part in range(17)}
    if s.contact.surface == "section" and max(depths) - min(depths) > 1e-12 * max(depths):
        yield "contact.surface", f'should be "axis" {anywhere} and a depth of the beam that changes along it'
    if s.contact.enabled and not s.sides and not s.obstacle_points:
        yield "obstacles", "none, and no slope: give an obstacle, or contact.enabled = false"
    if s.contact.enabled:
        yield from _of_obstacles_at_the_start(s)


def _of_obstacles_at_the_start(s: Scenario) -> Iterator[tuple[str, str]]:
    """Yield obstacles that the undeformed beam passes through."""
    angle, small = s.initial.angle, TOUCHING * s.beam.length
    depth = s.beam.fibre_distance(s.beam.length) if s.contact.surface == "section" else 0.0
    for side in s.sides:
        height, along = side.offsets
        c, sine = math.cos(angle - side.angle), math.sin(angle - side.angle)
        for place in s.beam_points:
            reach = s.root.hub_radius + place
            gap, slip = reach * sine - depth * abs(c) - height, reach * c - along
            if gap < -small and (not side.extent or side.extent[0] <= slip <= side.extent[1]):
                name = _key_of(side.obstacle)
                where = f"inside of this obstacle at {place:.6g} m of its length"
                yield name, f"the beam starts {-gap:.6g} m {where}; the gap should be at least 0"
    for point in s.obstacle_points:
        along, across = _in_frame(point.x, point.y, angle)
        beyond = max(s.root.hub_radius - along, along - s.root.hub_radius - s.beam.length, 0.0)
        distance = math.hypot(across, beyond) - point.radius - depth
        astride = beyond == 0.0 and abs(across) < small  # nothing says on which side the beam is
        if distance < -small or astride:
            name = _key_of(point.obstacle)
            yield (
                name,
                f"the beam starts on the point ({point.x:.6g}, {point.y:.6g}) m of this obstacle, or inside of it",
            )


def _in_frame(x: float, y: float, angle: float) -> tuple[float, float]:
    """Place of a point along a line through the origin, and its distance to the left of it (m)."""
    return x * math.cos(angle) + y * math.sin(angle), y * math.cos(angle) - x * math.sin(angle)


def _key_of(obstacle: int) -> str:
    return "slope.origin" if obstacle == 0 else f"obstacles.{obstacle}.origin"


def _of_contact_point(s: Scenario) -> Iterator[tuple[str, str]]:
    point, length, extent = s.contact.point, s.beam.length, s.slope.extent
    if point > length:
        yield "contact.point", f"should be on the beam, at most beam.length = {length}"
    if point < _LEAST_POINT * length:
        yield "contact.point", f"should be at least {_LEAST_POINT} beam.length = {_LEAST_POINT * length}"
    beyond = bool(extent) and not extent[0] <= s.initial_slip <= extent[1]
    if s.contact.where == "anywhere":
        return
    if s.contact.enabled and s.initial_gap < -TOUCHING * length and not beyond:
        below = f"the contact point starts {-s.initial_gap:.6g} m below the slope"
        yield "initial.angle", f"{below}; the gap should be at least 0"


def _of_massless_point(s: Scenario) -> Iterator[tuple[str, str]]:
    without = 'with contact.point_inertia = "none"'
    if s.beam.tip_mass > 0.0 and s.contact.point == s.beam.length:
        yield "contact.point_inertia", 'should be "kept": beam.tip_mass is the inertia of this contact point'
    if s.solver.scheme == "fixed-step":
        yield "solver.scheme", f'should be "event" or "generalized-alpha" {without}'
    if s.is_nodal and s.contact.point != s.beam.length:
        yield "contact.point", f"should be beam.length in the full nodal model {without}"


def _of_nodal_model(s: Scenario) -> Iterator[tuple[str, str]]:
    nodal, instead = "the full nodal model", "or keep modes: discretization.modes >= 1"
    if s.root.is_moved:
        yield "discretization.modes", f"{nodal} is for a pin or a hub of radius 0; keep modes"
    if s.solver.scheme != "generalized-alpha":
        marched = f'{nodal} (discretization.modes = 0) is marched by "generalized-alpha" only'
        yield "solver.scheme", f"{marched}; leave this key out, {instead}"
    if s.beam.modal_damping_ratio > 0.0:
        yield "beam.modal_damping_ratio", f"{nodal} has no modes to damp; use beam.kelvin_voigt, {instead}"


def _of_exact_beam(s: Scenario) -> Iterator[tuple[str, str]]:
    exact = "the beam in absolute coordinates"
    if s.contact.enabled and s.contact.normal != "spring":
        yield (
            "contact.normal",
            f'{exact} meets an elastic stop only: contact.normal = "spring", as stiff as need be',
        )
    if s.contact.friction == "modified-coulomb":
        yield "contact.friction", f'{exact} takes "frictionless" or "hybrid"'
    if not s.contact.shortening:
        yield "contact.shortening", f"{exact} has no contact point without its shortening; leave this key out"
    for name in ("mass_proportional", "modal_damping_ratio"):
        if getattr(s.beam, name) > 0.0:
            without = "has no frame or modes that would move without it"
            yield f"beam.{name}", f"{exact} {without}; use beam.kelvin_voigt"
    if s.root.kind == "hub" and s.root.hub_radius > 0.0:
        words = f"{exact} turns with a hub of radius 0; a driven root may have a radius"
        yield "root.hub_radius", f'{words}; discretization.method = "fem" takes it'
    if s.solver.scheme != "energy-consistent":
        yield "solver.scheme", f'{exact} is marched by "energy-consistent" only, which is the default'


def _of_discretization(s: Scenario) -> Iterator[tuple[str, str]]:
    d, length, point = s.discretization, s.beam.length, s.contact.point
    if d.frame == "mean-axis" and s.root.is_moved:
        frame = "the mean-axis frame is for a pin or a hub of radius 0"
        yield "discretization.frame", f'{frame}; use "tangent" for this root'
    if d.method != "modal" and d.elements < 2 and point < length:
        yield "discretization.elements", "should be at least 2 with a contact point inside the span"
    if d.nodes and (d.nodes[0] != 0.0 or abs(d.nodes[-1] - length) > ON_NODE * length):
        yield "discretization.nodes", f"should go from 0 to beam.length = {length}, not to {d.nodes[-1]}"
    if d.nodes and min(abs(x - point) for x in d.nodes) > ON_NODE * length:
        yield "discretization.nodes", f"none of them is at contact.point = {point}; the contact needs one there"


def _of_solver(s: Scenario) -> Iterator[tuple[str, str]]:
    samples = s.end_time / s.solver.output_interval
    # numbers of one sample in memory: states and accelerations, results at 33 stations, scalars
    values = 3 * coordinates(s.discretization) + 8 * 33 + 60
    if samples * values > MAX_VALUES:
        words = f"gives {samples:.3g} samples of {values} values"
        yield "solver.output_interval", f"{words}; at most {MAX_VALUES} values fit into a history"
    for name in ("free_step", "contact_step"):
        if s.solver.scheme != "event" and s.end_time / getattr(s.solver, name) > MAX_STEPS:
            yield f"solver.{name}", f"gives more than {MAX_STEPS} steps"
