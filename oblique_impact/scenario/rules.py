"""Rules between keys of a scenario: which follow others, which exclude each other, what has to fit together.

Each rule yields the keys that it refuses and what is allowed; the reference of the documentation is
made from them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import short
from oblique_impact.scenario.sections import MAX_MODES, PARTS, ScenarioKeys

MAX_STEPS = 1_000_000_000
MAX_VALUES = 500_000_000

#: a start this close to the slope (relative to the beam's length) touches it
TOUCHING = 1e-12
#: a node of a given mesh this close to a place (relative to the beam's length) is there
ON_NODE = 1e-9


#: keys that follow others as long as they are not given; a resolved file lists their values in this table too
TABLE = "derived"
DERIVED: dict[str, Callable[[ScenarioKeys], Any]] = {
    "contact.point": lambda s: s.beam.length,
    "discretization.frame": lambda s: "mean-axis" if s.is_nodal else "tangent",
    "solver.scheme": lambda s: "generalized-alpha" if s.is_nodal else "event",
}
Refusals = Iterator[tuple[str, str]]


def derived_values(scenario: ScenarioKeys) -> dict[str, Any]:
    """Return the values, by "section.key", that were not given and follow other keys."""
    found = {}
    for name, follow in DERIVED.items():
        section, key = name.split(".")
        if key not in getattr(scenario, section).model_fields_set:
            found[name] = follow(scenario)
    return found


def derive(scenario: ScenarioKeys) -> None:
    """Fill in the keys that were not given and follow others; they go on counting as not given."""
    for name, value in derived_values(scenario).items():
        section, key = name.split(".")
        old = getattr(scenario, section)
        new = old.model_construct(old.model_fields_set, **{**old.__dict__, key: value})
        object.__setattr__(scenario, section, new)


def drop_derived_values(data: dict[str, Any]) -> None:
    """Take out of a file's data what its table of derived values lists: it follows other keys again.

    A value that is not the listed one was changed by hand since, and stays.  Raises InputError.
    """
    listed = data.pop(TABLE, {})
    if not isinstance(listed, dict) or not listed.keys() <= DERIVED.keys():
        raise InputError(f"{TABLE} = {short(listed)}: should be a table of {', '.join(DERIVED)}")
    for name, value in listed.items():
        section, key = name.split(".")
        inner = data.get(section)
        if isinstance(inner, dict) and key in inner and inner[key] == value:
            del inner[key]


def check(scenario: ScenarioKeys) -> None:
    """Raise ValueError, in one line, for the first key that a rule refuses."""
    _build_parts(scenario)
    for rule in RULES:
        for name, allowed in rule(scenario):
            section, key = name.split(".")
            raise ValueError(f"{name} = {short(getattr(getattr(scenario, section), key))}: {allowed}")


def _check_root(s: ScenarioKeys) -> Refusals:
    root, kind = s.root, s.root.kind
    only = {"inertia": "hub", "torque": "hub", "spin_rate": "driven", "spin_up_time": "driven"}
    for key, needed in only.items():
        if getattr(root, key) != 0.0 and kind != needed:
            yield f"root.{key}", f'only with root.kind = "{needed}" (it is "{kind}")'
    if root.profile != "hold" and kind != "driven":
        yield "root.profile", f'only with root.kind = "driven" (it is "{kind}")'
    if root.hub_radius > 0.0 and kind == "pin":
        yield "root.hub_radius", 'a pin has radius 0; use root.kind = "hub" or "driven"'
    if root.profile == "spin-up" and not root.spin_up_time > 0.0:
        yield "root.spin_up_time", "should be greater than 0 for a spin-up"
    if s.part("profile") is not None:
        for key in ("spin_rate", "spin_up_time"):
            if getattr(root, key) != 0.0:
                yield f"root.{key}", "the numbers of this profile are in parameters.profile"
    speed = s.initial.angular_velocity
    if kind == "driven" and speed not in (0.0, s.initial_angular_velocity):
        yield "initial.angular_velocity", "a driven root prescribes its own speed; leave it 0"


def _check_beam(s: ScenarioKeys) -> Refusals:
    beam, modal = s.beam, s.discretization.method == "modal"
    uniform = 'the modal method knows uniform beams only; discretization.method = "fem" takes'
    for key in ("area", "second_moment"):
        table = getattr(beam, key)
        if not isinstance(table, tuple):
            continue
        if table[-1][0] != beam.length:
            end = f"{beam.length}, not at {table[-1][0]}"
            yield f"beam.{key}", f"should end at x = beam.length = {end}; a new length needs new tables"
        if modal:
            yield f"beam.{key}", f"{uniform} tables"
    if modal and beam.tip_mass > 0.0:
        yield "beam.tip_mass", f"{uniform} a tip mass"
    if modal and s.discretization.grading != 1.0:
        yield "discretization.grading", 'the modal method has no mesh; use 1.0, or discretization.method = "fem"'


def _check_contact(s: ScenarioKeys) -> Refusals:
    contact, length = s.contact, s.beam.length
    if contact.normal != "rigid" and contact.restitution > 0.0:
        yield "contact.restitution", "only with a rigid stop; a spring has contact.damping"
    if contact.normal != "rigid" and contact.impact != "newton":
        yield "contact.impact", 'only with contact.normal = "rigid": others have no impacts'
    if contact.point > length:
        yield "contact.point", f"should be on the beam, at most beam.length = {length}"
    if contact.point < 1e-3 * length:
        yield "contact.point", f"should be at least 0.001 beam.length = {1e-3 * length}"
    if contact.mu_static < contact.mu_kinetic:
        yield "contact.mu_static", f"should be at least contact.mu_kinetic = {contact.mu_kinetic}"
    v0, v1 = contact.regularization
    if not v0 < v1:
        yield "contact.regularization", "should be [v0, v1] in m/s with v0 less than v1"
    if contact.enabled and s.initial_gap < -TOUCHING * length:
        yield (
            "initial.angle",
            f"the contact point starts {-s.initial_gap:.6g} m below the slope; the gap should be at least 0",
        )


def _check_massless(s: ScenarioKeys) -> Refusals:
    """Refuse what does not go with a contact point without inertia."""
    contact, beam, none = s.contact, s.beam, 'contact.point_inertia = "none"'
    if contact.point_inertia != "none":
        return
    if beam.tip_mass > 0.0 and contact.point == beam.length:
        yield "contact.point_inertia", 'should be "kept": beam.tip_mass is the inertia of this contact point'
    if contact.restitution > 0.0 or contact.impact != "newton":
        yield (
            "contact.point_inertia",
            'should be "kept" with contact.restitution or contact.impact: "none" has no impacts',
        )
    if s.solver.scheme == "fixed-step":
        yield "solver.scheme", f'should be "event" or "generalized-alpha" with {none}'
    if s.is_nodal and contact.point != beam.length:
        yield "contact.point", f"should be beam.length in the full nodal model with {none}"


def _check_slope(s: ScenarioKeys) -> Refusals:
    extent = s.slope.extent
    if extent and not (len(extent) == 2 and extent[0] < extent[1]):
        yield "slope.extent", "should be [first, last] in m with first less than last, or [] without ends"


def _check_discretization(s: ScenarioKeys) -> Refusals:
    d, root = s.discretization, s.root
    if d.frame == "mean-axis" and (root.kind == "driven" or root.hub_radius > 0.0):
        yield (
            "discretization.frame",
            'the mean-axis frame is for a pin or a hub of radius 0; use "tangent" for this root',
        )
    if d.method == "modal" and d.modes < 1:
        yield "discretization.modes", f"should be 1 to {MAX_MODES} for the modal method"
    if d.method == "fem":
        if s.contact.point < s.beam.length and d.elements < 2:
            yield "discretization.elements", "should be at least 2 with a contact point inside the span"
        if d.modes > 2 * d.elements:
            yield "discretization.modes", f"should be at most the {2 * d.elements} modes of the mesh"


def _check_nodes(s: ScenarioKeys) -> Refusals:
    d, length, point = s.discretization, s.beam.length, s.contact.point
    if d.mesh:
        yield "discretization.mesh", "is read with a scenario file or by --set; give discretization.nodes"
    if not d.nodes:
        return
    if d.method != "fem":
        yield "discretization.nodes", 'only with discretization.method = "fem"'
    if d.elements != len(d.nodes) - 1:
        yield "discretization.elements", f"the mesh has {len(d.nodes) - 1} elements; leave this key out"
    if d.grading != 1.0:
        yield "discretization.grading", "the mesh is graded as it is; leave this key out"
    if d.nodes[0] != 0.0 or abs(d.nodes[-1] - length) > ON_NODE * length:
        yield "discretization.nodes", f"should go from 0 to beam.length = {length}, not to {d.nodes[-1]}"
    if any(b <= a for a, b in pairwise(d.nodes)):
        yield "discretization.nodes", "should ascend"
    if min(abs(x - point) for x in d.nodes) > ON_NODE * length:
        yield "discretization.nodes", f"none of them is at contact.point = {point}; the contact needs one there"


def _check_nodal(s: ScenarioKeys) -> Refusals:
    """Refuse what the full nodal model, which generalized-alpha marches in the mean-axis frame, does not take."""
    if not s.is_nodal:
        return
    d, root = s.discretization, s.root
    full, instead = "the full nodal model (discretization.modes = 0)", "or keep modes: discretization.modes >= 1"
    if root.kind == "driven" or root.hub_radius > 0.0:
        yield "discretization.modes", "the full nodal model is for a pin or a hub of radius 0; keep modes"
    if s.solver.scheme != "generalized-alpha":
        yield "solver.scheme", f'{full} is marched by "generalized-alpha" only; leave this key out, {instead}'
    if d.frame != "mean-axis":
        yield (
            "discretization.frame",
            f'{full} is marched in the "mean-axis" frame only; leave this key out, {instead}',
        )
    if d.kinetics != "first-order":
        yield "discretization.kinetics", f'the full nodal model is "first-order"; {instead}'
    if s.beam.modal_damping_ratio > 0.0:
        yield (
            "beam.modal_damping_ratio",
            f"the full nodal model has no modes to damp; use beam.kelvin_voigt, {instead}",
        )


def _check_solver(s: ScenarioKeys) -> Refusals:
    v = s.solver
    if s.end_time / v.output_interval * _values_per_sample(s) > MAX_VALUES:
        many = f"{s.end_time / v.output_interval:.3g} samples of {_values_per_sample(s)} values"
        yield "solver.output_interval", f"gives {many}; at most {MAX_VALUES} values fit into a history"
    if v.scheme != "event":
        for key in ("free_step", "contact_step"):
            if s.end_time / getattr(v, key) > MAX_STEPS:
                yield f"solver.{key}", f"gives more than {MAX_STEPS} steps"


def _values_per_sample(s: ScenarioKeys) -> int:
    """Count the numbers of one sample in memory: states and accelerations, results at 33 stations, scalars."""
    d = s.discretization
    shapes = d.modes or 2 * d.elements
    return 3 * (shapes + 1) + 8 * 33 + 60


def _build_parts(s: ScenarioKeys) -> None:
    """Build the user-defined parts: what they do not take is refused before anything runs."""
    for key, section in PARTS.items():
        name, numbers = getattr(getattr(s, section), key), dict(getattr(s.parameters, key))
        try:
            part = s.part(key)
            if part is not None:
                part.check(s.end_time)
        except InputError as error:
            raise ValueError(f"{section}.{key}: {error}") from None
        if part is None and numbers:
            words = f'only with a user-defined {section}.{key} (it is "{name}")'
            raise ValueError(f"parameters.{key} = {short(numbers)}: {words}")


RULES: tuple[Callable[[ScenarioKeys], Refusals], ...] = (
    _check_root,
    _check_beam,
    _check_slope,
    _check_contact,
    _check_massless,
    _check_nodal,
    _check_discretization,
    _check_nodes,
    _check_solver,
)
