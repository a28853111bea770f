"""Build the problem that is marched from a scenario: system, scheme, contact laws, tolerances."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, get_args, get_type_hints

import numpy as np

from oblique_impact.beam.base_motion import BaseMotion
from oblique_impact.beam.beam import Beam, ContactPlace, FullBeam
from oblique_impact.beam.cross_sections import Sections, check_numbers
from oblique_impact.beam.floating_frame import BeamModel
from oblique_impact.beam.frequencies import lowest_elastic_frequency
from oblique_impact.beam.normal_modes import normal_modes
from oblique_impact.beam.operators import Discretization, build_operators
from oblique_impact.contact.compliance import Compliance
from oblique_impact.contact.decision import Decision
from oblique_impact.contact.friction import FrictionLaw, friction_law
from oblique_impact.contact.impacts import ImpactLaw, NewtonImpact, RouthImpact
from oblique_impact.contact.pairs import ContactPair
from oblique_impact.contact.state import SLIDING, Baumgarte, Candidate, Contacts, Tolerances
from oblique_impact.contact.stops import NO_INERTIA, ContactLaw, elastic_stop
from oblique_impact.errors import InputError
from oblique_impact.kernels.jit import is_compiled
from oblique_impact.kernels.workspace import FREE_ACCELERATION, Array
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.fixed_step import FixedStepScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.marching.problem import Problem
from oblique_impact.marching.sampling import solve_problem
from oblique_impact.marching.scheme import Scheme
from oblique_impact.marching.time_stepping import TimeSteppingScheme
from oblique_impact.scenario.messages import refused
from oblique_impact.scenario.scenario import Scenario

#: generalized-alpha takes its contact step in flight too where the gap is below this part of the length
NEAR = 0.01
#: tolerance of the iterations of one implicit step over that of the run: the errors of steps add up
ITERATIONS = 0.01
#: rad, of the slowest vibration in a step of time-stepping that resolves it
RESOLVED = 0.05
#: built-in schemes by their names in `solver.scheme`; `order` is that of their steps
SCHEMES: dict[str, type[Scheme]] = {
    "event": EventScheme,
    "fixed-step": FixedStepScheme,
    "generalized-alpha": GeneralizedAlphaScheme,
    "time-stepping": TimeSteppingScheme,
}
#: s; sizes of a beam's angle, deflections and velocities are 1 rad, 1 m and these over the second
BEAM_TIME = 1.0


@dataclass(frozen=True)
class Parts:
    """User-defined parts of a run, each in the place of the built-in one that its scenario names.

    Attributes
    ----------
    friction : FrictionLaw, optional
        In the place of `contact.friction`.
    contact_law : ContactLaw, optional
        In the place of the spring of ``contact.normal = "spring"``.  Warnings are based on `contact.stiffness`,
        which should have the order of its stiffness.
    impact_law : ImpactLaw, optional
        In the place of `contact.impact`, on a rigid stop.
    base_motion : BaseMotion, optional
        In the place of `root.profile`, of a driven root.
    scheme : Scheme, optional
        In the place of `solver.scheme`.
    discretization : Discretization, optional
        In the place of `discretization.method`.
    """

    friction: FrictionLaw | None = None
    contact_law: ContactLaw | None = None
    impact_law: ImpactLaw | None = None
    base_motion: BaseMotion | None = None
    scheme: Scheme | None = None
    discretization: Discretization | None = None

    def given(self) -> dict[str, Any]:
        """Return the parts that are given, by their names."""
        parts = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: part for name, part in parts.items() if part is not None}

    def check(self, scenario: Scenario) -> None:
        """Raise InputError, in one line, for a part of the wrong kind or one that does not fit the scenario."""
        kinds = get_type_hints(Parts)
        for name, part in self.given().items():
            kind = get_args(kinds[name])[0]
            if not isinstance(part, kind):
                raise refused(name, part, f"should be a {kind.__name__} ({kind.__module__})")
            if needed := _requirement(name, scenario):
                raise InputError(f"{name}: only with {needed}")
        for name, part in self.given().items():
            if name != "discretization":
                part.check(scenario.end_time)


def _requirement(name: str, s: Scenario) -> str:
    """Return the settings that a user-defined part needs, "" if the scenario has them."""
    if s.is_absolute and name not in ("friction", "base_motion"):
        return 'discretization.method = "modal" or "fem"'
    if name == "contact_law" and s.contact.normal != "spring":
        return f'contact.normal = "spring" (it is "{s.contact.normal}"), in whose place it stands'
    if name == "contact_law" and any(item.bedding for item in s.obstacles):
        return "obstacles.bedding = 0: it has the force of a place, not over a length"
    if name == "impact_law" and (s.contact.normal != "rigid" or s.contact.point_inertia == "none"):
        return 'contact.normal = "rigid" and contact.point_inertia = "kept": others have no impacts'
    if name == "base_motion" and s.root.kind != "driven":
        return f'root.kind = "driven" (it is "{s.root.kind}")'
    if name == "base_motion" and (s.root.spin_rate != 0.0 or s.root.profile != "hold"):
        return 'root.profile = "hold" and root.spin_rate = 0, in whose place it stands'
    if name == "contact_law" and s.solver.scheme == "time-stepping":
        return 'another solver.scheme than "time-stepping", whose stops are springs with their damping'
    if name == "impact_law" and s.solver.scheme == "time-stepping":
        return 'another solver.scheme than "time-stepping", whose steps decide impacts'
    if name in ("scheme", "impact_law") and s.contact.where == "anywhere":
        return 'contact.where = "point": of several contacts the built-in one decides'
    if name in ("friction", "contact_law", "impact_law") and s.contact.axial_flexibility:
        return "contact.axial_flexibility = false, which knows Coulomb's friction, plain stops and Newton's impact"
    if name == "scheme" and s.contact.axial_flexibility and s.contact.normal == "rigid":
        return 'contact.normal = "spring" with contact.axial_flexibility: the built-in scheme takes a rigid stop'
    if name in ("scheme", "discretization") and s.is_nodal:
        return "discretization.modes >= 1"
    return ""


def beam_of(scenario: Scenario, parts: Parts = Parts()) -> Beam:
    """Return the discretized beam of a scenario: reduced, or the full nodal model."""
    check_numbers(Sections.from_scenario(scenario))
    if scenario.is_nodal:
        from oblique_impact.fem_beam import build_nodal  # which is built on `beam`

        return FullBeam(scenario, build_nodal(scenario), parts.base_motion)
    return Beam(scenario, build_operators(scenario, parts.discretization), parts.base_motion)


def beam_problem(beam: Beam, parts: Parts = Parts()) -> Problem:
    """Return the problem of a beam: with its scheme, contact laws and tolerances."""
    s = beam.scenario
    scheme, tolerances = parts.scheme or scheme_of(s), beam_tolerances(s, beam.mass)
    q0, qd0 = beam.initial_state()
    massless = s.contact.point_inertia == "none"
    nodes_without = s.is_nodal and (s.touches_anywhere or s.solver.scheme == "time-stepping")
    if massless and not nodes_without and not beam.residual_compliance > 0.0:
        raise refused(
            "contact.point_inertia",
            s.contact.point_inertia,
            'should be "kept": this discretization leaves no flexibility out; keep fewer modes',
        )
    return Problem(
        beam.model,
        q0,
        qd0,
        decision_about(beam.candidates, s, scheme, tolerances, parts, beam.compliance),
        scheme,
        end_time=s.end_time,
        output_interval=s.solver.output_interval,
        scales=np.ones(2 * q0.size),
        contact=s.contact.enabled,
        breakpoints=beam.breakpoints,
        modes=normal_modes(beam.model) if isinstance(beam.model, BeamModel) else None,
        relative_deflection=beam.relative_deflection,
        compliance=beam.compliance,
    )


def decision_about(
    places: Sequence[ContactPlace],
    scenario: Scenario,
    scheme: Scheme,
    tolerances: Tolerances,
    parts: Parts = Parts(),
    compliance: Compliance | None = None,
) -> Decision:
    """Return the transition table of places that can touch, at least one.

    `compliance` is that of the beam behind them, None of one that yields nothing.
    """
    v, c = scenario.solver, scenario.contact
    pairs = [
        ContactPair(
            parts.contact_law or contact_law_of(scenario, place.stiffness, place.extent, place.cell),
            place.extent,
            place.obstacle,
            place.on_side,
            place.numbers[0],
            compliance.behind(i) if compliance else None,
            place.behind,
        )
        for i, place in enumerate(places)
    ]
    friction = parts.friction or friction_law(c.friction, c.mu_static, c.mu_kinetic, c.regularization)
    projects = v.scheme == "generalized-alpha"  # what sticks onto its constraint, after every step
    return Decision(
        pairs,
        friction,
        parts.impact_law or _impact_law(scenario, friction),
        tolerances._replace(flight=scheme.shortest_flight),
        Baumgarte() if projects else Baumgarte.from_parameters(*v.baumgarte, v.baumgarte_form),
        scheme.stick_criterion,
    )


def beam_tolerances(scenario: Scenario, mass: float) -> Tolerances:
    """Return the zero tolerances of a beam of the given mass (kg)."""
    return Tolerances.of(scenario.beam.length, BEAM_TIME, mass * max(scenario.largest_gravity, 1.0))


def scheme_of(scenario: Scenario) -> Scheme:
    """Return the built-in marching scheme of a scenario."""
    v = scenario.solver
    if v.scheme == "fixed-step":
        return FixedStepScheme(v.free_step, v.contact_step, literal=v.stick == "force")
    if v.scheme == "generalized-alpha":
        near = NEAR * scenario.beam.length if scenario.contact.enabled else 0.0
        tolerance = ITERATIONS * v.tolerance
        return GeneralizedAlphaScheme(
            v.free_step, min(v.contact_step, v.free_step), v.rho_infinity, near, tolerance
        )
    if v.scheme == "time-stepping":
        return TimeSteppingScheme(
            v.free_step,
            min(v.contact_step, v.free_step),
            NEAR * scenario.beam.length,
            ITERATIONS * v.tolerance,
            massless=scenario.contact.point_inertia == "none",
            slowest=_slowest_vibration(scenario),
        )
    return EventScheme(v.tolerance)


def _slowest_vibration(scenario: Scenario) -> float:
    """Return the frequency (rad/s) that rules the length of steps in flight, 0 where it is to be the same.

    That is so of a driven root, beside whose motion vibrations are small, and of the exact beam; and where the
    given step does not resolve the slowest vibration, so that its error there says nothing.
    """
    if scenario.is_absolute or scenario.root.kind == "driven":
        return 0.0
    slowest = lowest_elastic_frequency(scenario)
    return slowest if slowest * scenario.solver.free_step <= RESOLVED else 0.0


def contact_law_of(
    scenario: Scenario, stiffness: float, extent: tuple[float, ...] = (), cell: float = 0.0
) -> ContactLaw | None:
    """Return the built-in law of a compliant stop of the given stiffness (N/m), None of a rigid one.

    A `cell` (m) of the beam bears on a bedding, between the slips `extent` (m) if it has ends.
    """
    c = scenario.contact
    if c.normal == "spring":
        return elastic_stop(stiffness, c.damping, extent, cell, c.linear_damping)
    if c.point_inertia == "none" and scenario.solver.scheme != "time-stepping":
        return NO_INERTIA
    return None


def _impact_law(scenario: Scenario, friction: FrictionLaw) -> ImpactLaw:
    """Return the built-in impact law of a scenario."""
    c = scenario.contact
    return NewtonImpact(c.restitution) if c.impact == "newton" else RouthImpact(friction, c.restitution)


def system_scales(system: Any, q0: Array, qd0: Array, end_time: float) -> tuple[Tolerances, Array]:
    """Return zero tolerances, and scales (2 d,) of q and q', from the initial state of a system.

    Gap g, velocity v and acceleration a of the contact give the length max(g, v^2/a), at most v times `end_time`,
    and the velocity max(v, sqrt(a length)); a system at rest in contact has the scales of a flight of `end_time`
    (s).  Coordinates have sizes of their own in the same way.
    """
    work, packed = system.new_workspace(), is_compiled(system)
    contacts = Contacts.new([Candidate(state=SLIDING)], q0.size, packed)
    defined = solve_problem(system, contacts, 0.0, q0, qd0, work, np.zeros(1))
    c = contacts.of(0)
    speed = max(abs(c.gap_rate), abs(c.slip_rate))
    push = max(abs(c.gap_acceleration), abs(c.slip_acceleration)) if defined else 0.0
    # the distance is bounded by that within the run, because the acceleration may be rounding
    distance = speed * end_time
    length = max(abs(c.gap), min(distance, speed * speed / push) if push > 0.0 else distance)
    length = length or push * end_time**2 or 1.0
    speed = max(speed, math.sqrt(push * length)) or length / end_time
    time = length / speed
    effective_mass = 1.0 / c.a_nn if c.a_nn > 0.0 else 1.0
    tolerances = Tolerances.of(length, time, effective_mass * max(push, speed / time))
    pull = np.abs(work.vectors[FREE_ACCELERATION]) if defined else np.zeros_like(q0)
    with np.errstate(divide="ignore", invalid="ignore"):
        distances = np.minimum(np.where(pull > 0.0, qd0**2 / pull, np.inf), np.abs(qd0) * end_time)
    size = np.maximum(np.abs(q0), distances)
    size = np.where(size > 0.0, size, pull * time**2)
    size = np.where(size > 0.0, size, np.max(size) or length)
    rate = np.maximum(np.abs(qd0), np.sqrt(pull * size))
    return tolerances, np.concatenate([size, np.where(rate > 0.0, rate, size / time)])
