"""Consistency of the keys of different sections of a scenario."""

from __future__ import annotations

import cmath
from collections.abc import Iterator

from oblique_impact.scenario.model import ON_NODE, ScenarioModel
from oblique_impact.scenario.sections import DiscretizationSection

MAX_STEPS = 1_000_000_000
MAX_VALUES = 500_000_000

#: initial gap (over the beam's length) below which the beam touches the slope
TOUCHING = 1e-12
#: least distance of the contact point from the root, over the length: its lever arm
_LEAST_POINT = 1e-3


def coordinates(discretization: DiscretizationSection) -> int:
    """Return the number of generalized coordinates, the angle of the frame included."""
    d = discretization
    return 1 + (6 * d.elements if d.method == "absolute" else d.modes or 2 * d.elements)


def conflicts(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    """Yield each key that does not fit the others, with what is allowed; each may rely on those before it."""
    if s.discretization.method == "modal":
        uniform = 'the modal method knows uniform beams only; discretization.method = "fem" takes'
        for name in s.beam.tables():
            if name != "outer_fibre":  # of stresses alone
                yield f"beam.{name}", f"{uniform} tables"
    if s.root.is_free and not s.is_absolute:
        yield "root.kind", '"free" is of the beam in absolute coordinates: discretization.method = "absolute"'
    yield from _of_loads(s)
    yield from _of_contact_point(s)
    if s.initial.state != "undeformed":
        yield from _of_rest(s)
    yield from _of_rigid_stop(s)
    yield from _of_many_contacts(s) if s.contact.where == "anywhere" else _of_one_contact(s)
    if s.contact.point_inertia == "none":
        yield from _of_massless_point(s)
    if s.contact.axial_flexibility:
        yield from _of_axial_flexibility(s)
    if s.is_nodal:
        yield from _of_nodal_model(s)
    if s.is_absolute:
        yield from _of_exact_beam(s)
    if s.solver.scheme == "time-stepping":
        yield from _of_time_stepping(s)
    yield from _of_discretization(s)
    yield from _of_solver(s)


def _of_loads(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    for items in ("masses", "forces"):
        for number, item in enumerate(getattr(s, items), start=1):
            if item.place > s.beam.length:
                yield f"{items}.{number}.place", f"should be on the beam, at most beam.length = {s.beam.length}"


def _of_contact_point(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    point, length = s.contact.point, s.beam.length
    if point > length:
        yield "contact.point", f"should be on the beam, at most beam.length = {length}"
    if point < _LEAST_POINT * length:
        yield "contact.point", f"should be at least {_LEAST_POINT} beam.length = {_LEAST_POINT * length}"


def _of_rest(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    length = s.beam.length
    if s.initial.place > length:
        yield "initial.place", f"should be on the beam, at most beam.length = {length}"
    if s.root.kind == "driven" and s.root.profile == "constant-speed" and s.root.spin_rate != 0.0:
        yield "initial.state", 'should be "undeformed" of a root that turns at t = 0: it is not at rest'
    if s.root.is_free:
        yield "initial.state", 'should be "undeformed" of a beam that nothing holds'


def _of_rigid_stop(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    c, scheme = s.contact, s.solver.scheme
    if not c.enabled or c.normal != "rigid":
        return
    marched = '"time-stepping"' if s.is_nodal else '"event" or "time-stepping"'
    if scheme == "generalized-alpha" and c.point_inertia == "kept":
        yield "solver.scheme", f'should be {marched} with a rigid stop; "generalized-alpha" takes elastic ones'
    elif scheme in ("fixed-step", "generalized-alpha") and c.where == "anywhere":
        yield "solver.scheme", f'should be {marched} with contact.where = "anywhere" and a rigid stop'


def _of_one_contact(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    if not s.slope.enabled:
        only = 'false only with contact.where = "anywhere"'
        yield "slope.enabled", f"{only}; contact.enabled = false is free motion"
    beyond = not s.slope_side.is_beside(s.initial_slip)
    inside = s.contact.enabled and s.initial.state == "undeformed"  # a beam at rest is bent away from it
    if inside and s.initial_gap < -TOUCHING * s.beam.length and not beyond:
        below = f"the contact point starts {-s.initial_gap:.6g} m below the slope"
        yield "initial.angle", f"{below}; the gap should be at least 0"


def _of_many_contacts(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    several = 'with contact.where = "anywhere"'
    if not s.contact.shortening:
        yield "contact.shortening", f"should be true {several}"
    if s.contact.surface == "section" and _is_tapered(s):
        yield "contact.surface", f'should be "axis" {several} and a depth that changes along the beam'
    if s.contact.enabled:
        if not s.slope.enabled and not s.obstacles:
            nothing = "there is neither a slope nor an obstacle; for free motion"
            yield "contact.enabled", f"{nothing} write contact.enabled = false"
        yield from _of_undeformed_beam(s)


def _is_tapered(s: ScenarioModel) -> bool:
    """Return whether the distance of the outer fibre changes; between rows of tables it is monotonic."""
    rows = {x for table in s.beam.tables().values() for x, _ in table}
    depths = [s.beam.fibre_distance(x) for x in sorted(rows)] or [0.0]
    return max(depths) - min(depths) > TOUCHING * s.beam.length


def _of_undeformed_beam(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    """Yield obstacles that the undeformed beam overlaps at t = 0, or that lie on its axis."""
    preloaded = s.initial.state != "undeformed"  # a beam at rest is bent away from them
    radius, angle, touching = s.root.hub_radius, s.initial.angle, TOUCHING * s.beam.length
    yield from _of_outlines(s)
    for side in [each for each in s.sides if each.obstacle not in s.outlines]:
        key, name = _named(side.obstacle)
        for x in s.beam_points:
            gap, along = side.gap_and_place(radius + x, angle, s.half_depth, s.root_axis)
            if gap < -touching and not preloaded and side.lengthened(s.cell_on(side, x)).is_beside(along):
                below = f"the beam's point at {x:.6g} m starts {-gap:.6g} m below {name}"
                yield key, f"{below}; the gap should be at least 0"
    for point in s.obstacle_points:
        key, name = _named(point.obstacle)
        distance = point.distance(radius, radius + s.beam.length, angle, s.root_axis)
        what = f"an end of {name}" if point.corner else name
        least = point.radius + s.half_depth
        if distance < least - touching and not (preloaded and point.obstacle not in s.outlines):
            yield (
                key,
                f"{what} is {distance:.6g} m from the beam's axis at t = 0; should be at least {least:.6g} m",
            )
        elif distance <= touching:
            yield key, f"{what} lies on the beam's axis at t = 0, which does not say on which side of it it is"


def _of_outlines(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    """Yield outlines that the undeformed beam is inside of or crosses; at rest none says where it is bent."""
    touching, along = TOUCHING * s.beam.length, cmath.exp(1j * s.initial.angle)
    root = s.root_axis + s.root.hub_radius * along
    for number, outline in s.outlines.items():
        gaps = outline.distance([root + x * along for x in s.beam_points]) - s.half_depth
        for x, gap in zip(s.beam_points, gaps.tolist(), strict=True):
            if gap < -touching:
                inside = f"the beam's point at {x:.6g} m starts {-gap:.6g} m inside of obstacle {number}"
                yield f"obstacles.{number}.points", f"{inside}; the gap should be at least 0"
        share = outline.crossing(root, root + s.beam.length * along)
        if share is not None:
            at = f"the beam crosses obstacle {number} at {share * s.beam.length:.6g} m along it at t = 0"
            yield f"obstacles.{number}.points", f"{at}; it should be on its left"


def _named(obstacle: int) -> tuple[str, str]:
    """Return the key to name in an error about an obstacle, and what to call it."""
    return (f"obstacles.{obstacle}.origin", f"obstacle {obstacle}") if obstacle else ("initial.angle", "the slope")


def _of_massless_point(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    without = 'with contact.point_inertia = "none"'
    named = "beam.tip_mass" if s.beam.tip_mass > 0.0 else "one of [[masses]]"
    if s.contact.point in [point.place for point in s.point_masses]:
        yield "contact.point_inertia", f'should be "kept": {named} is the inertia of this contact point'
    everywhere = s.contact.where == "anywhere" or s.solver.scheme == "time-stepping"
    if s.is_nodal and everywhere and s.point_masses:
        yield "contact.point_inertia", f'should be "kept": {named} is the inertia of a node'
    condenses = s.contact.where == "point" and s.solver.scheme != "time-stepping"
    if s.is_nodal and s.contact.point != s.beam.length and condenses:
        yield "contact.point", f"should be beam.length in the full nodal model {without}"


def _of_axial_flexibility(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    c, behind = s.contact, "with contact.axial_flexibility"
    if s.is_absolute:
        yield "contact.axial_flexibility", "the beam in absolute coordinates stretches itself; leave this key out"
    if c.friction != "hybrid":
        yield "contact.friction", f'should be "hybrid" {behind}'
    rigid = c.normal == "rigid" and c.point_inertia == "kept"
    if rigid and s.solver.scheme not in ("event", "time-stepping"):
        marched = 'a rigid stop takes it with solver.scheme = "event" or "time-stepping"'
        yield "contact.normal", f'should be "spring" {behind}; {marched}'
    if c.impact == "routh" and s.solver.scheme == "event":
        yield "contact.impact", f'should be "newton" {behind}: its spring does not move in an impact'
    yields = c.point_inertia == "none" or (c.normal == "spring" and c.residual_flexibility and not s.is_nodal)
    damped = c.damping > 0.0 or c.linear_damping > 0.0 or (yields and s.beam.kelvin_voigt > 0.0)
    if damped and s.solver.scheme in ("fixed-step", "generalized-alpha"):
        located = 'the end of slip over a damped stop is found by solver.scheme = "event" or "time-stepping"'
        yield "contact.axial_flexibility", f"{located}; others take stops without damping"
    if s.solver.scheme == "fixed-step" and s.solver.stick != "projection":
        yield "solver.stick", f'should be "projection" {behind}'


def _of_nodal_model(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    nodal, instead = "the full nodal model", "or keep modes: discretization.modes >= 1"
    if s.discretization.frame == "tangent" and not s.root.is_moved:
        light = "the end of an element alone would have to carry the tangent frame of a free root"
        yield "discretization.frame", f'should be "mean-axis" in {nodal}: {light}'
    if s.solver.scheme not in ("generalized-alpha", "time-stepping"):
        by = '"generalized-alpha" or "time-stepping"'
        marched = f"{nodal} (discretization.modes = 0) is marched by {by} only"
        yield "solver.scheme", f"{marched}; leave this key out, {instead}"
    if s.beam.modal_damping_ratio > 0.0:
        yield "beam.modal_damping_ratio", f"{nodal} has no modes to damp; use beam.kelvin_voigt, {instead}"


def _of_time_stepping(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    where = 'with solver.scheme = "time-stepping"'
    if s.contact.enabled and s.contact.impact != "newton":
        yield "contact.impact", f'should be "newton" {where}, which decides all contacts of a step together'


def _of_exact_beam(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    exact = "the beam in absolute coordinates"
    if s.contact.enabled and s.contact.point_inertia == "none":
        yield "contact.point_inertia", f'should be "kept": all places of {exact} have inertia'
    if not s.contact.shortening:
        yield "contact.shortening", f"{exact} has no contact point without its shortening; leave this key out"
    for name in ("mass_proportional", "modal_damping_ratio"):
        if getattr(s.beam, name) > 0.0:
            without = "has no frame or modes that would move without it"
            yield f"beam.{name}", f"{exact} {without}; use beam.kelvin_voigt"
    if s.solver.scheme != "time-stepping":
        yield "solver.scheme", f'{exact} is marched by "time-stepping" only, which is the default'


def _of_discretization(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    d, length, point = s.discretization, s.beam.length, s.contact.point
    if d.frame == "mean-axis" and s.root.is_moved:
        frame = "the mean-axis frame is for a pin or a hub of radius 0"
        yield "discretization.frame", f'{frame}; use "tangent" for this root'
    pieces = len(s.fixed_places)
    if d.method != "modal" and d.elements < pieces:
        why = f"contact.grid = {s.contact.grid}" if s.contact_nodes else "a contact point inside the span"
        yield "discretization.elements", f"should be at least {pieces} with {why}"
    if d.nodes and (d.nodes[0] != 0.0 or abs(d.nodes[-1] - length) > ON_NODE * length):
        yield "discretization.nodes", f"should go from 0 to beam.length = {length}, not to {d.nodes[-1]}"
    for place in {point: None} | dict.fromkeys(s.contact_nodes):
        if d.nodes and min(abs(x - place) for x in d.nodes) > ON_NODE * length:
            where = f"contact.point = {point}" if place == point else f"{place:.6g} m, an end of contact.grid"
            yield "discretization.nodes", f"none of them is at {where}; the contact needs one there"


def _of_solver(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    samples = s.end_time / s.solver.output_interval
    # numbers of one sample in memory: states and accelerations, results at 33 stations, scalars
    values = 3 * coordinates(s.discretization) + 8 * 33 + 60
    if samples * values > MAX_VALUES:
        words = f"gives {samples:.3g} samples of {values} values"
        yield "solver.output_interval", f"{words}; at most {MAX_VALUES} values fit into a history"
    for name in ("free_step", "contact_step"):
        if s.solver.scheme != "event" and s.end_time / getattr(s.solver, name) > MAX_STEPS:
            yield f"solver.{name}", f"gives more than {MAX_STEPS} steps"
