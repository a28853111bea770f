"""Rules about several keys of a scenario: which exclude each other, and what has to fit together.

Each rule refuses one key in one line; the reference of the documentation is made from them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from oblique_impact.errors import InputError
from oblique_impact.scenario.messages import refuse as _refuse
from oblique_impact.scenario.messages import short

if TYPE_CHECKING:
    from oblique_impact.scenario.scenario import Scenario

MAX_MODES = 100
MAX_SAMPLES = 5_000_000
MAX_STEPS = 1_000_000_000
MAX_VALUES = 500_000_000

#: a start this close to the slope (relative to the beam's length) touches it
TOUCHING = 1e-12


def _check_root(s: Scenario) -> None:
    root, kind = s.root, s.root.kind
    only = {"inertia": "hub", "torque": "hub", "spin_rate": "driven", "spin_up_time": "driven"}
    for key, needed in only.items():
        if getattr(root, key) != 0.0 and kind != needed:
            _refuse(f"root.{key}", getattr(root, key), f'only with root.kind = "{needed}" (it is "{kind}")')
    if root.profile != "hold" and kind != "driven":
        _refuse("root.profile", root.profile, f'only with root.kind = "driven" (it is "{kind}")')
    if root.hub_radius > 0.0 and kind == "pin":
        _refuse("root.hub_radius", root.hub_radius, 'a pin has radius 0; use root.kind = "hub" or "driven"')
    if root.profile == "spin-up" and not root.spin_up_time > 0.0:
        _refuse("root.spin_up_time", root.spin_up_time, "should be greater than 0 for a spin-up")
    if s.part("profile") is not None:
        for key in ("spin_rate", "spin_up_time"):
            if getattr(root, key) != 0.0:
                _refuse(f"root.{key}", getattr(root, key), "the numbers of this profile are in parameters.profile")
    speed = s.initial.angular_velocity
    if kind == "driven" and speed not in (0.0, s.initial_angular_velocity):
        _refuse("initial.angular_velocity", speed, "a driven root prescribes its own speed; leave it 0")


def _check_beam(s: Scenario) -> None:
    beam, modal = s.beam, s.discretization.method == "modal"
    uniform = 'the modal method knows uniform beams only; discretization.method = "fem" takes'
    for key in ("area", "second_moment"):
        table = getattr(beam, key)
        if not isinstance(table, tuple):
            continue
        if table[-1][0] != beam.length:
            _refuse(
                f"beam.{key}",
                table,
                f"should end at x = beam.length = {beam.length}, not at {table[-1][0]}; a new length "
                "needs new tables",
            )
        if modal:
            _refuse(f"beam.{key}", table, f"{uniform} tables")
    if modal and beam.tip_mass > 0.0:
        _refuse("beam.tip_mass", beam.tip_mass, f"{uniform} a tip mass")
    if modal and s.discretization.grading != 1.0:
        _refuse(
            "discretization.grading",
            s.discretization.grading,
            'the modal method has no mesh; use 1.0, or discretization.method = "fem"',
        )


def _check_contact(s: Scenario) -> None:
    contact, length = s.contact, s.beam.length
    if contact.normal != "rigid" and contact.restitution > 0.0:
        _refuse("contact.restitution", contact.restitution, "only with a rigid stop; a spring has contact.damping")
    if contact.normal != "rigid" and contact.impact != "newton":
        _refuse("contact.impact", contact.impact, 'only with contact.normal = "rigid": others have no impacts')
    if contact.point > length:
        _refuse("contact.point", contact.point, f"should be on the beam, at most beam.length = {length}")
    if contact.point < 1e-3 * length:
        _refuse("contact.point", contact.point, f"should be at least 0.001 beam.length = {1e-3 * length}")
    if contact.mu_static < contact.mu_kinetic:
        _refuse(
            "contact.mu_static", contact.mu_static, f"should be at least contact.mu_kinetic = {contact.mu_kinetic}"
        )
    v0, v1 = contact.regularization
    if not v0 < v1:
        _refuse("contact.regularization", contact.regularization, "should be [v0, v1] in m/s with v0 less than v1")
    if contact.enabled and s.initial_gap < -TOUCHING * length:
        _refuse(
            "initial.angle",
            s.initial.angle,
            f"the contact point starts {-s.initial_gap:.6g} m below the slope; the gap should be at least 0",
        )


def _check_slope(s: Scenario) -> None:
    extent = s.slope.extent
    if extent and not (len(extent) == 2 and extent[0] < extent[1]):
        _refuse(
            "slope.extent", extent, "should be [first, last] in m with first less than last, or [] without ends"
        )


def _check_discretization(s: Scenario) -> None:
    d, root = s.discretization, s.root
    if d.frame == "mean-axis" and (root.kind == "driven" or root.hub_radius > 0.0):
        _refuse(
            "discretization.frame",
            d.frame,
            'the mean-axis frame is for a pin or a hub of radius 0; use "tangent" for this root',
        )
    if d.method == "modal" and d.modes < 1:
        _refuse("discretization.modes", d.modes, f"should be 1 to {MAX_MODES} for the modal method")
    if d.method == "fem":
        if s.contact.point < s.beam.length and d.elements < 2:
            _refuse(
                "discretization.elements", d.elements, "should be at least 2 with a contact point inside the span"
            )
        if d.modes > 2 * d.elements:
            _refuse("discretization.modes", d.modes, f"should be at most the {2 * d.elements} modes of the mesh")


def _check_nodal(s: Scenario) -> None:
    """Refuse what the full nodal model, which generalized-alpha marches in the mean-axis frame, does not take."""
    if not s.is_nodal:
        return
    d, root = s.discretization, s.root
    full, instead = "the full nodal model (discretization.modes = 0)", "or keep modes: discretization.modes >= 1"
    if root.kind == "driven" or root.hub_radius > 0.0:
        _refuse(
            "discretization.modes", d.modes, "the full nodal model is for a pin or a hub of radius 0; keep modes"
        )
    if s.solver.scheme != "generalized-alpha":
        _refuse(
            "solver.scheme",
            s.solver.scheme,
            f'{full} is marched by "generalized-alpha" only; leave this key out, {instead}',
        )
    if d.frame != "mean-axis":
        _refuse(
            "discretization.frame",
            d.frame,
            f'{full} is marched in the "mean-axis" frame only; leave this key out, {instead}',
        )
    if d.kinetics != "first-order":
        _refuse("discretization.kinetics", d.kinetics, f'the full nodal model is "first-order"; {instead}')
    if s.beam.modal_damping_ratio > 0.0:
        _refuse(
            "beam.modal_damping_ratio",
            s.beam.modal_damping_ratio,
            f"the full nodal model has no modes to damp; use beam.kelvin_voigt, {instead}",
        )


def _check_solver(s: Scenario) -> None:
    v = s.solver
    if s.end_time / v.output_interval > MAX_SAMPLES:
        _refuse("solver.output_interval", v.output_interval, f"gives more than {MAX_SAMPLES} samples")
    if s.end_time / v.output_interval * _values_per_sample(s) > MAX_VALUES:
        _refuse(
            "solver.output_interval",
            v.output_interval,
            f"gives {s.end_time / v.output_interval:.3g} samples of {_values_per_sample(s)} values; "
            f"at most {MAX_VALUES:.0e} values fit into a history",
        )
    if v.scheme != "event":
        for key in ("free_step", "contact_step"):
            if s.end_time / getattr(v, key) > MAX_STEPS:
                _refuse(f"solver.{key}", getattr(v, key), f"gives more than {MAX_STEPS} steps")


def _values_per_sample(s: Scenario) -> int:
    """Count the numbers of one sample in memory: states and accelerations, results at 33 stations, scalars."""
    d = s.discretization
    shapes = d.modes or 2 * d.elements
    return 3 * (shapes + 1) + 8 * 33 + 60


def _build_parts(s: Scenario) -> None:
    """Build the parts of one's own: what they do not take is refused before anything runs."""
    for section, key in PARTS:
        name, numbers = getattr(getattr(s, section), key), dict(getattr(s.parameters, key))
        try:
            part = s.part(key)
            if part is not None:
                part.check(s.end_time)
        except InputError as error:
            raise ValueError(f"{section}.{key}: {error}") from None
        if part is None and numbers:
            words = f'only with a {section}.{key} of one\'s own (it is "{name}")'
            raise ValueError(f"parameters.{key} = {short(numbers)}: {words}")


#: keys that may name a part of one's own, each with its section; `parameters` calls the numbers by the key
PARTS = (
    ("contact", "friction"),
    ("contact", "normal"),
    ("contact", "impact"),
    ("root", "profile"),
    ("solver", "scheme"),
)

RULES: tuple[Callable[[Scenario], None], ...] = (
    _build_parts,
    _check_root,
    _check_beam,
    _check_slope,
    _check_contact,
    _check_nodal,
    _check_discretization,
    _check_solver,
)
