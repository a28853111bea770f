"""Rules between keys of a scenario: which exclude each other, what has to fit together."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from operator import attrgetter
from typing import Any, NamedTuple

from oblique_impact.errors import InputError
from oblique_impact.scenario.materials import GIVEN
from oblique_impact.scenario.messages import short
from oblique_impact.scenario.sections import MAX_MODES, PARTS, ScenarioKeys
from oblique_impact.scenario.shapes import FOLLOWING, SHAPES, SIZES, misfit

MAX_STEPS = 1_000_000_000
MAX_VALUES = 500_000_000

#: a start this close to the slope (relative to the beam's length) touches it
TOUCHING = 1e-12
#: a node of a given mesh this close to a place (relative to the beam's length) is there
ON_NODE = 1e-9


class Rule(NamedTuple):
    """Keys that are refused, each by itself, where they do not fit the others.

    `keys` are separated by spaces.  `allowed` is the text of the error and of the documentation: `{s.section.key}`
    in it is a value of the scenario, `{found}` what `found` returns.  The functions get the scenario and the value
    of the key.
    """

    keys: str
    allowed: str
    refuses: Callable[[ScenarioKeys, Any], bool]
    found: Callable[[ScenarioKeys, Any], Any] = lambda s, value: None


def check(scenario: ScenarioKeys) -> None:
    """Raise ValueError, in one line, for the first key that a rule refuses."""
    _build_parts(scenario)
    for rule in RULES:
        for key in rule.keys.split():
            value = attrgetter(key)(scenario)
            if rule.refuses(scenario, value):
                allowed = rule.allowed.format(s=scenario, found=rule.found(scenario, value))
                raise ValueError(f"{key} = {short(value)}: {allowed}")


def coordinates(s: ScenarioKeys) -> int:
    """Count the generalized coordinates, the angle of the frame among them."""
    d = s.discretization
    return 1 + (6 * d.elements if s.is_absolute else d.modes or 2 * d.elements)


def _values_per_sample(s: ScenarioKeys) -> int:
    """Count the numbers of one sample in memory: states and accelerations, results at 33 stations, scalars."""
    return 3 * coordinates(s) + 8 * 33 + 60


def _starts_beyond(s: ScenarioKeys) -> bool:
    """Whether the contact point starts beyond the ends of the slope."""
    return bool(s.slope.extent) and not s.slope.extent[0] <= s.initial_slip <= s.slope.extent[1]


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


def _sizes(s: ScenarioKeys) -> tuple[str, ...]:
    """Return the names of the sizes of the cross-section's shape."""
    shape = SHAPES.get(s.beam.section.shape)
    return shape.sizes if shape else ()


def _is_modal(s: ScenarioKeys) -> bool:
    return s.discretization.method == "modal"


def _has_mesh(s: ScenarioKeys) -> bool:
    return s.discretization.method in ("fem", "absolute")


def _root_is_moved(s: ScenarioKeys) -> bool:
    """Whether the root turns as prescribed, or stands off the axis."""
    return s.root.kind == "driven" or s.root.hub_radius > 0.0


_ROOT = (
    Rule(
        "root.inertia root.torque",
        'only with root.kind = "hub" (it is "{s.root.kind}")',
        lambda s, value: value != 0.0 and s.root.kind != "hub",
    ),
    Rule(
        "root.spin_rate root.spin_up_time root.profile",
        'only with root.kind = "driven" (it is "{s.root.kind}")',
        lambda s, value: value not in (0.0, "hold") and s.root.kind != "driven",
    ),
    Rule(
        "root.hub_radius",
        'a pin has radius 0; use root.kind = "hub" or "driven"',
        lambda s, radius: radius > 0.0 and s.root.kind == "pin",
    ),
    Rule(
        "root.spin_up_time",
        "should be greater than 0 for a spin-up",
        lambda s, time: s.root.profile == "spin-up" and not time > 0.0,
    ),
    Rule(
        "root.spin_rate root.spin_up_time",
        "the numbers of this profile are in parameters.profile",
        lambda s, value: value != 0.0 and s.part("profile") is not None,
    ),
    Rule(
        "initial.angular_velocity",
        "a driven root prescribes its own speed; leave it 0",
        lambda s, speed: s.root.kind == "driven" and speed not in (0.0, s.initial_angular_velocity),
    ),
)

_UNIFORM = 'the modal method knows uniform beams only; discretization.method = "fem" takes'
_SIZES = " ".join(f"beam.section.{size}" for size in SIZES)


def _given(key: str, name: str) -> Callable[[ScenarioKeys, Any], bool]:
    """Whether a key of [beam] is given together with another one, which it follows."""
    return lambda s, value: bool(attrgetter(name)(s.beam)) and key in s.beam.model_fields_set


def _foreign(size: str) -> Callable[[ScenarioKeys, Any], bool]:
    return lambda s, value: value != 0.0 and size not in _sizes(s)


def _lacking(size: str) -> Callable[[ScenarioKeys, Any], bool]:
    return lambda s, value: value == 0.0 and size in _sizes(s)


_SHAPE = 'beam.section.shape = "{s.beam.section.shape}"'
_SECTION = (
    *(
        Rule(f"beam.{key}", f"follows from {_SHAPE}; give one of the two", _given(key, "section.shape"))
        for key in FOLLOWING
    ),
    *(
        Rule(
            f"beam.{key}",
            'follows from beam.material = "{s.beam.material}"; give one of the two',
            _given(key, "material"),
        )
        for key in GIVEN
    ),
    *(
        Rule(
            f"beam.section.{size}",
            f"is no size of {_SHAPE}, which takes {{found}}",
            _foreign(size),
            lambda s, value: ", ".join(_sizes(s)) or "none; name a shape",
        )
        for size in SIZES
    ),
    *(Rule(f"beam.section.{size}", f"should be greater than 0 for {_SHAPE}", _lacking(size)) for size in SIZES),
    Rule(
        "beam.section.shape",
        "these sizes are not possible: {found}",
        lambda s, shape: bool(misfit(s.beam.section)),
        lambda s, shape: misfit(s.beam.section),
    ),
)

_BEAM = (
    *_SECTION,
    Rule(
        f"{_SIZES} beam.area beam.second_moment beam.outer_fibre",
        "should end at x = beam.length = {s.beam.length}, not at {found}; a new length needs new tables",
        lambda s, table: isinstance(table, tuple) and table[-1][0] != s.beam.length,
        lambda s, table: table[-1][0],
    ),
    Rule(
        f"{_SIZES} beam.area beam.second_moment",
        f"{_UNIFORM} tables",
        lambda s, table: isinstance(table, tuple) and _is_modal(s),
    ),
    Rule("beam.tip_mass", f"{_UNIFORM} a tip mass", lambda s, mass: mass > 0.0 and _is_modal(s)),
)

_SLOPE = (
    Rule(
        "slope.extent",
        "should be [first, last] in m with first less than last, or [] without ends",
        lambda s, extent: bool(extent) and not (len(extent) == 2 and extent[0] < extent[1]),
    ),
)

_CONTACT = (
    Rule(
        "contact.restitution",
        "only with a rigid stop; a spring has contact.damping",
        lambda s, restitution: restitution > 0.0 and s.contact.normal != "rigid",
    ),
    Rule(
        "contact.impact",
        'only with contact.normal = "rigid": others have no impacts',
        lambda s, law: law != "newton" and s.contact.normal != "rigid",
    ),
    Rule(
        "contact.point",
        "should be on the beam, at most beam.length = {s.beam.length}",
        lambda s, point: point > s.beam.length,
    ),
    Rule(
        "contact.point",
        "should be at least 0.001 beam.length = {found}",
        lambda s, point: point < 1e-3 * s.beam.length,
        lambda s, point: 1e-3 * s.beam.length,
    ),
    Rule(
        "contact.mu_static",
        "should be at least contact.mu_kinetic = {s.contact.mu_kinetic}",
        lambda s, mu: mu < s.contact.mu_kinetic,
    ),
    Rule(
        "contact.regularization",
        "should be [v0, v1] in m/s with v0 less than v1",
        lambda s, speeds: not speeds[0] < speeds[1],
    ),
    Rule(
        "initial.angle",
        "the contact point starts {found:.6g} m below the slope; the gap should be at least 0",
        lambda s, angle: s.contact.enabled and s.initial_gap < -TOUCHING * s.beam.length and not _starts_beyond(s),
        lambda s, angle: -s.initial_gap,
    ),
)

#: what does not go with a contact point without inertia
_WITHOUT = 'contact.point_inertia = "none"'
_MASSLESS = (
    Rule(
        "contact.point_inertia",
        'should be "kept": beam.tip_mass is the inertia of this contact point',
        lambda s, inertia: inertia == "none" and s.beam.tip_mass > 0.0 and s.contact.point == s.beam.length,
    ),
    Rule(
        "contact.point_inertia",
        'should be "kept" with contact.restitution or contact.impact: "none" has no impacts',
        lambda s, inertia: inertia == "none" and (s.contact.restitution > 0.0 or s.contact.impact != "newton"),
    ),
    Rule(
        "contact.surface",
        f'should be "axis" with {_WITHOUT}: such a point gives way across the axis only',
        lambda s, surface: s.contact.point_inertia == "none" and surface != "axis",
    ),
    Rule(
        "solver.scheme",
        f'should be "event" or "generalized-alpha" with {_WITHOUT}',
        lambda s, scheme: s.contact.point_inertia == "none" and scheme == "fixed-step",
    ),
    Rule(
        "contact.point",
        f"should be beam.length in the full nodal model with {_WITHOUT}",
        lambda s, point: s.contact.point_inertia == "none" and s.is_nodal and point != s.beam.length,
    ),
)

#: what the full nodal model, which generalized-alpha marches in the mean-axis frame, does not take
_FULL, _INSTEAD = "the full nodal model", "or keep modes: discretization.modes >= 1"
_NODAL = (
    Rule(
        "discretization.modes",
        f"{_FULL} is for a pin or a hub of radius 0; keep modes",
        lambda s, modes: s.is_nodal and _root_is_moved(s),
    ),
    Rule(
        "solver.scheme",
        f"{_FULL} (discretization.modes = 0) is marched by "
        f'"generalized-alpha" only; leave this key out, {_INSTEAD}',
        lambda s, scheme: s.is_nodal and scheme != "generalized-alpha",
    ),
    Rule(
        "discretization.frame",
        f"{_FULL} (discretization.modes = 0) is marched in the "
        f'"mean-axis" frame only; leave this key out, {_INSTEAD}',
        lambda s, frame: s.is_nodal and frame != "mean-axis",
    ),
    Rule(
        "discretization.kinetics",
        f'{_FULL} is "first-order"; {_INSTEAD}',
        lambda s, kinetics: s.is_nodal and kinetics != "first-order",
    ),
    Rule(
        "beam.modal_damping_ratio",
        f"{_FULL} has no modes to damp; use beam.kelvin_voigt, {_INSTEAD}",
        lambda s, ratio: s.is_nodal and ratio > 0.0,
    ),
)

#: what the beam in absolute coordinates does not have
_EXACT, _OTHERS = "the beam in absolute coordinates", 'discretization.method = "fem" takes it'
_ABSOLUTE = (
    Rule(
        "contact.normal",
        f'{_EXACT} meets an elastic stop only: contact.normal = "spring", as stiff as need be',
        lambda s, law: s.is_absolute and s.contact.enabled and law != "spring",
    ),
    Rule(
        "contact.friction",
        f'{_EXACT} takes "frictionless" or "hybrid"',
        lambda s, law: s.is_absolute and law not in ("frictionless", "hybrid"),
    ),
    Rule(
        "contact.shortening",
        f"{_EXACT} has no contact point without its shortening; leave this key out",
        lambda s, shortening: s.is_absolute and not shortening,
    ),
    Rule(
        "beam.mass_proportional beam.modal_damping_ratio",
        f"{_EXACT} has no frame or modes that would move without it; use beam.kelvin_voigt",
        lambda s, damping: s.is_absolute and damping > 0.0,
    ),
    Rule(
        "root.hub_radius",
        f"{_EXACT} turns with a hub of radius 0; a driven root may have a radius; {_OTHERS}",
        lambda s, radius: s.is_absolute and s.root.kind == "hub" and radius > 0.0,
    ),
    Rule(
        "solver.scheme",
        f'{_EXACT} is marched by "energy-consistent" only, which is the default',
        lambda s, scheme: s.is_absolute and scheme != "energy-consistent",
    ),
    Rule(
        "solver.scheme",
        'only with discretization.method = "absolute"',
        lambda s, scheme: not s.is_absolute and scheme == "energy-consistent",
    ),
)

_DISCRETIZATION = (
    Rule(
        "discretization.grading",
        'the modal method has no mesh; use 1.0, or discretization.method = "fem"',
        lambda s, grading: grading != 1.0 and _is_modal(s),
    ),
    Rule(
        "discretization.frame",
        'the mean-axis frame is for a pin or a hub of radius 0; use "tangent" for this root',
        lambda s, frame: frame == "mean-axis" and _root_is_moved(s),
    ),
    Rule(
        "discretization.modes",
        f"should be 1 to {MAX_MODES} for the modal method",
        lambda s, modes: modes < 1 and _is_modal(s),
    ),
    Rule(
        "discretization.elements",
        "should be at least 2 with a contact point inside the span",
        lambda s, elements: _has_mesh(s) and elements < 2 and s.contact.point < s.beam.length,
    ),
    Rule(
        "discretization.modes",
        "should be at most the {found} modes of the mesh",
        lambda s, modes: s.discretization.method == "fem" and modes > 2 * s.discretization.elements,
        lambda s, modes: 2 * s.discretization.elements,
    ),
    Rule(
        "discretization.mesh",
        "is read with a scenario file or by --set; give discretization.nodes",
        lambda s, mesh: bool(mesh),
    ),
    Rule(
        "discretization.nodes",
        'only with discretization.method = "fem" or "absolute"',
        lambda s, nodes: bool(nodes) and not _has_mesh(s),
    ),
    Rule(
        "discretization.elements",
        "the mesh has {found} elements; leave this key out",
        lambda s, elements: bool(s.discretization.nodes) and elements != len(s.discretization.nodes) - 1,
        lambda s, elements: len(s.discretization.nodes) - 1,
    ),
    Rule(
        "discretization.grading",
        "the mesh is graded as it is; leave this key out",
        lambda s, grading: bool(s.discretization.nodes) and grading != 1.0,
    ),
    Rule(
        "discretization.nodes",
        "should go from 0 to beam.length = {s.beam.length}, not to {found}",
        lambda s, x: bool(x) and (x[0] != 0.0 or abs(x[-1] - s.beam.length) > ON_NODE * s.beam.length),
        lambda s, x: x[-1],
    ),
    Rule("discretization.nodes", "should ascend", lambda s, x: any(b <= a for a, b in pairwise(x))),
    Rule(
        "discretization.nodes",
        "none of them is at contact.point = {s.contact.point}; the contact needs one there",
        lambda s, nodes: bool(nodes) and min(abs(x - s.contact.point) for x in nodes) > ON_NODE * s.beam.length,
    ),
)

_SOLVER = (
    Rule(
        "solver.output_interval",
        f"gives {{found[0]:.3g}} samples of {{found[1]}} values; at most {MAX_VALUES} values fit into a history",
        lambda s, interval: s.end_time / interval * _values_per_sample(s) > MAX_VALUES,
        lambda s, interval: (s.end_time / interval, _values_per_sample(s)),
    ),
    Rule(
        "solver.free_step solver.contact_step",
        f"gives more than {MAX_STEPS} steps",
        lambda s, step: s.solver.scheme != "event" and s.end_time / step > MAX_STEPS,
    ),
)

#: in the order in which they are asked: each may rely on those before it
RULES: tuple[Rule, ...] = (
    *_ROOT,
    *_BEAM,
    *_SLOPE,
    *_CONTACT,
    *_MASSLESS,
    *_NODAL,
    *_ABSOLUTE,
    *_DISCRETIZATION,
    *_SOLVER,
)
