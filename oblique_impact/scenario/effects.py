"""Which keys of a scenario act: one that is given, and not with its default value, must not be without effect."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from oblique_impact.scenario.model import ScenarioModel
from oblique_impact.scenario.section import InputSection


class Rule(NamedTuple):
    """Keys of one section, when they act, and what is said where they do not."""

    section: str
    #: their names, separated by spaces
    keys: str
    acts: Callable[[ScenarioModel], bool]
    words: str


class ItemRule(NamedTuple):
    """A key of the items of a list of sections, when it acts in a scenario, and what is said where it does not."""

    key: str
    acts: Callable[[ScenarioModel, Any], bool]
    words: str


_SPRING = 'a rigid stop has none; only with contact.normal = "spring"'
_RIGID = 'an elastic stop has no impacts; only with contact.normal = "rigid"'
_FREE = "contact.enabled = false is free motion; leave this key out"
_ONLY_ANYWHERE = 'only with contact.where = "anywhere"'
_MESH = 'the modal method has no mesh; only with discretization.method = "fem" or "absolute"'
_MODES = "only for a beam in modes: discretization.modes >= 1"

#: of several rules about a key the first that does not hold is said
RULES = (
    Rule("root", "inertia torque", lambda s: s.root.kind == "hub", 'only with root.kind = "hub"'),
    Rule(
        "root",
        "stiffness damping",
        lambda s: s.root.kind not in ("pin", "free"),
        'nothing resists its turning; only with root.kind = "hub" or "driven"',
    ),
    Rule(
        "root",
        "damping",
        lambda s: s.root.kind != "driven" or s.root.stiffness > 0.0,
        "a rigid clamp does not turn: only with root.stiffness",
    ),
    Rule(
        "root",
        "profile spin_rate spin_up_time",
        lambda s: s.root.kind == "driven",
        'only with root.kind = "driven"',
    ),
    Rule("root", "spin_rate", lambda s: s.root.profile != "hold", 'root.profile = "hold" does not turn'),
    Rule("root", "spin_up_time", lambda s: s.root.profile == "spin-up", 'only with root.profile = "spin-up"'),
    Rule(
        "initial", "angular_velocity", lambda s: s.root.kind != "driven", "a driven root prescribes its own speed"
    ),
    Rule(
        "initial",
        "angular_velocity",
        lambda s: s.initial.state == "undeformed",
        'a beam at rest does not turn; only with initial.state = "undeformed"',
    ),
    Rule("initial", "position velocity", lambda s: s.root.is_free, 'only with root.kind = "free"'),
    Rule(
        "initial", "place deflection force", lambda s: s.initial.state == "plucked", 'only with state = "plucked"'
    ),
    Rule("base", "frequency sweep_rate", lambda s: s.base.acceleration != 0.0, "only with base.acceleration"),
    Rule("base", "direction", lambda s: s.base.is_shaken, "only with base.acceleration or base.table"),
    Rule("slope", "enabled extent", lambda s: s.contact.enabled, _FREE),
    Rule("slope", "origin angle extent", lambda s: s.slope.enabled, "there is no slope: slope.enabled = false"),
    Rule(
        "contact",
        "grid normal stiffness damping linear_damping impact restitution point_inertia residual_flexibility "
        "friction axial_flexibility mu_static mu_kinetic regularization",
        lambda s: s.contact.enabled,
        _FREE,
    ),
    Rule("contact", "grid", lambda s: s.contact.where == "anywhere", _ONLY_ANYWHERE),
    Rule(
        "contact",
        "grid",
        lambda s: bool(s.sides),
        "there is no side; pegs and corners touch the beam at any place",
    ),
    Rule(
        "contact",
        "point",
        lambda s: s.contact.where == "point",
        'the beam is touched at any place; only with contact.where = "point"',
    ),
    Rule("contact", "stiffness damping linear_damping", lambda s: s.contact.normal == "spring", _SPRING),
    Rule(
        "contact",
        "stiffness",
        lambda s: s.takes_contact_stiffness,
        "each obstacle has a stiffness or a bedding of its own",
    ),
    Rule(
        "contact", "restitution", lambda s: s.contact.normal == "rigid", f"{_RIGID} (a spring has contact.damping)"
    ),
    Rule("contact", "impact", lambda s: s.contact.normal == "rigid", _RIGID),
    Rule(
        "contact",
        "point_inertia",
        lambda s: s.contact.normal == "rigid" or s.is_nodal,
        "behind an elastic stop the modes have a residual flexibility without inertia already",
    ),
    Rule(
        "contact",
        "residual_flexibility",
        lambda s: s.contact.normal == "spring",
        _SPRING,
    ),
    Rule("contact", "residual_flexibility", lambda s: s.discretization.in_modes, _MODES),
    Rule(
        "contact",
        "shortening",
        lambda s: s.discretization.kinetics != "zeroth-order",
        'discretization.kinetics = "zeroth-order" knows no foreshortening',
    ),
    Rule(
        "contact", "mu_static", lambda s: s.contact.friction == "hybrid", 'only with contact.friction = "hybrid"'
    ),
    Rule(
        "contact",
        "mu_kinetic",
        lambda s: s.contact.friction != "frictionless",
        'only with contact.friction = "hybrid" or "modified-coulomb"',
    ),
    Rule(
        "contact",
        "regularization",
        lambda s: s.contact.friction == "modified-coulomb",
        'only with contact.friction = "modified-coulomb"',
    ),
    Rule("", "obstacles", lambda s: s.contact.where == "anywhere", _ONLY_ANYWHERE),
    Rule("", "obstacles", lambda s: s.contact.enabled, _FREE),
    Rule("discretization", "nodes elements grading", lambda s: s.discretization.method != "modal", _MESH),
    Rule(
        "discretization",
        "grading",
        lambda s: s.discretization.elements > len(s.fixed_places),
        "each node has its place: the contact point, the tip, and the ends of the parts of contact.grid",
    ),
    Rule(
        "discretization",
        "kinetics modes",
        lambda s: not s.is_absolute,
        'the beam in absolute coordinates has none; only with discretization.method = "modal" or "fem"',
    ),
    Rule(
        "solver",
        "tolerance",
        lambda s: s.solver.scheme != "fixed-step",
        'solver.scheme = "fixed-step" has no tolerance; refine free_step and contact_step',
    ),
    Rule(
        "solver",
        "free_step contact_step",
        lambda s: s.solver.scheme != "event",
        'solver.scheme = "event" chooses its steps by solver.tolerance',
    ),
    Rule("solver", "contact_step baumgarte baumgarte_form stick", lambda s: s.contact.enabled, _FREE),
    Rule(
        "solver",
        "rho_infinity",
        lambda s: s.solver.scheme == "generalized-alpha",
        'only with solver.scheme = "generalized-alpha"',
    ),
    Rule(
        "solver",
        "baumgarte baumgarte_form",
        lambda s: s.solver.scheme in ("event", "fixed-step"),
        'only with solver.scheme = "event" or "fixed-step"',
    ),
    Rule(
        "solver",
        "baumgarte baumgarte_form",
        lambda s: s.holds_constraints,
        "an elastic contact has no constraint; only on a rigid stop, or where hybrid friction sticks",
    ),
    Rule("solver", "stick", lambda s: s.solver.scheme == "fixed-step", 'only with solver.scheme = "fixed-step"'),
    Rule("solver", "stick", lambda s: s.contact.friction == "hybrid", 'only with contact.friction = "hybrid"'),
)
OBSTACLE_RULES = (
    ItemRule("angle", lambda s, o: o.kind != "point", 'only with kind = "side" or "polyline"'),
    ItemRule("extent", lambda s, o: o.kind == "side", 'only with kind = "side"'),
    ItemRule("bedding", lambda s, o: o.kind != "point", 'only with kind = "side" or "polyline"'),
    ItemRule("points", lambda s, o: o.kind == "polyline", 'only with kind = "polyline"'),
    ItemRule("radius", lambda s, o: o.kind == "point", 'only with kind = "point"'),
    ItemRule("stiffness", lambda s, o: s.contact.normal == "spring", _SPRING),
    ItemRule("stiffness", lambda s, o: o.bedding == 0.0, "bedding stands in its place; leave one of the two out"),
    ItemRule("bedding", lambda s, o: s.contact.normal == "spring", _SPRING),
)
MASS_RULES = (
    ItemRule("place", lambda s, m: m.has_inertia, "it is the place of nothing; only with mass or inertia"),
)
FORCE_RULES = (
    ItemRule("place", lambda s, f: f.acts, "it is the place of nothing; only with force or table"),
    ItemRule("direction", lambda s, f: f.acts, "only with force or table"),
    ItemRule("frequency", lambda s, f: f.force != 0.0, "only with force"),
    ItemRule("sweep_rate", lambda s, f: f.force != 0.0, "only with force"),
)
ITEM_RULES = {"obstacles": OBSTACLE_RULES, "masses": MASS_RULES, "forces": FORCE_RULES}


def without_effect(s: ScenarioModel) -> Iterator[tuple[str, str]]:
    """Yield each key that is given and not with its default value, but does not act, with what it takes to act."""
    for key in s.given():
        if s.value_of(key) != s.default_of(key) and (words := idle(s, key)):
            yield key, words


def idle(s: ScenarioModel, name: str) -> str:
    """Return why a key "section.key" has no effect in a scenario, and what it would act with; "" if it acts."""
    section, _, key = name.rpartition(".")
    items, _, number = section.partition(".")
    if number.isdigit():
        item: InputSection = s.value_of(section)
        words = (rule.words for rule in ITEM_RULES[items] if rule.key == key and not rule.acts(s, item))
    else:
        of = (rule for rule in RULES if rule.section == section and key in rule.keys.split())
        words = (rule.words for rule in of if not rule.acts(s))
    return next((f"has no effect: {found}" for found in words), "")
