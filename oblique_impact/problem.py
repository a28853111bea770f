"""From a scenario to the problem that is marched: system, scheme, laws of the contact, what counts as zero."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from oblique_impact.beam.beam import Beam, FullBeam
from oblique_impact.beam.cross_sections import Sections, check_numbers
from oblique_impact.beam.floating_frame import BeamModel
from oblique_impact.beam.normal_modes import normal_modes
from oblique_impact.beam.operators import build_operators, contiguous
from oblique_impact.contact.friction import friction_law
from oblique_impact.contact.impacts import ImpactLaw, NewtonImpact, RouthImpact
from oblique_impact.contact.state import Baumgarte, Tolerances
from oblique_impact.contact.stops import ContactLaw, ElasticStop, MasslessPoint
from oblique_impact.contact.transitions import ContactMachine
from oblique_impact.errors import InputError
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.fixed_step import FixedStepScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.marching.problem import Problem
from oblique_impact.marching.sampling import contact_problem
from oblique_impact.marching.scheme import Scheme
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.scenario.user_defined import discretization

#: flights closer to the slope than this part of the length take generalized-alpha's contact step
NEAR = 0.01
#: part of the tolerance that the iterations of one implicit step may leave: what they leave adds up
ITERATIONS = 0.01
#: s; sizes of a beam's angle, deflections and velocities are 1 rad, 1 m and these over the second
BEAM_TIME = 1.0


def beam_of(scenario: Scenario) -> Beam:
    """Return the discretized beam that a scenario marches: reduced, or nodal without reduction."""
    chosen = scenario.discretization
    check_numbers(Sections.from_scenario(scenario))
    if chosen.modes > 0 or scenario.solver.scheme != "generalized-alpha":
        return Beam(scenario, build_operators(scenario))
    build_nodal = getattr(discretization(chosen.method), "build_nodal", None)
    if build_nodal is None:
        words = "should be at least 1; this discretization has no nodal model (build_nodal)"
        raise InputError(f"discretization.modes = 0: {words}: {chosen.method}")
    return FullBeam(scenario, contiguous(build_nodal(scenario)))


def beam_problem(beam: Beam) -> Problem:
    """Put a beam, its scheme and its laws together for the loop."""
    s = beam.scenario
    scheme, tolerances = scheme_of(s), beam_tolerances(s, beam.mass)
    q0, qd0 = beam.initial_state()
    if s.contact.point_inertia == "none" and beam.residual_compliance == 0.0:
        words = 'should be "kept": this discretization leaves no flexibility out; keep fewer modes'
        raise InputError(f"contact.point_inertia: {words}")
    machine, scales = contact_machine(s, scheme, tolerances), np.ones(2 * q0.size)
    times = s.end_time, s.solver.output_interval
    contact, breakpoints = s.contact.enabled, beam.breakpoints
    modes = normal_modes(beam.model) if isinstance(beam.model, BeamModel) else None
    given = machine, scheme, *times, scales, contact, breakpoints, beam.residual, modes
    return Problem(beam.model, q0, qd0, *given, relative_deflection=beam.relative_deflection)


def beam_tolerances(scenario: Scenario, mass: float) -> Tolerances:
    """Return what counts as zero for a beam of the given mass (kg)."""
    return Tolerances.of(scenario.beam.length, BEAM_TIME, mass * max(scenario.gravity, 1.0))


def scheme_of(scenario: Scenario) -> Scheme:
    """Return the marching scheme of a scenario."""
    user_defined: Scheme | None = scenario.part("scheme")
    if user_defined is not None:
        return user_defined
    v = scenario.solver
    if v.scheme == "fixed-step":
        return FixedStepScheme(v.free_step, v.contact_step, literal=v.stick == "force")
    if v.scheme == "generalized-alpha":
        near = NEAR * scenario.beam.length if scenario.contact.enabled else 0.0
        tolerance = ITERATIONS * v.tolerance
        return GeneralizedAlphaScheme(
            v.free_step, min(v.contact_step, v.free_step), v.rho_infinity, near, tolerance
        )
    return EventScheme(v.tolerance)


def contact_machine(scenario: Scenario, scheme: Scheme, tolerances: Tolerances) -> ContactMachine:
    """Return the transition table of a scenario."""
    v, c = scenario.solver, scenario.contact
    return ContactMachine(
        scenario.part("friction") or friction_law(c.friction, c.mu_static, c.mu_kinetic, c.regularization),
        scenario.part("impact") or _impact_law(scenario),
        tolerances._replace(flight=scheme.shortest_flight),
        Baumgarte.from_parameters(*v.baumgarte, v.baumgarte_form),
        scheme.stick_criterion,
        stop_of(scenario),
        scenario.slope.extent,
    )


def stop_of(scenario: Scenario) -> ContactLaw | None:
    """Return the stop of a scenario that gives way, None for a rigid one."""
    c = scenario.contact
    if c.normal == "spring":
        return ElasticStop(c.stiffness, c.damping)
    if c.normal == "rigid" and c.point_inertia == "none":
        return MasslessPoint()
    user_defined: ContactLaw | None = scenario.part("normal")
    return user_defined


def _impact_law(scenario: Scenario) -> ImpactLaw:
    """Return the built-in impact law of a scenario."""
    c = scenario.contact
    if c.impact == "newton":
        return NewtonImpact(c.restitution)
    return RouthImpact(0.0 if c.friction == "frictionless" else c.mu_kinetic, c.restitution)


def system_scales(system: Any, q0: Array, qd0: Array, end_time: float) -> tuple[Tolerances, Array]:
    """Return what counts as zero for a system, and the sizes (2 d,) of q and q', from how it starts.

    Gap g, velocity v and acceleration a of the contact give the length max(g, v^2/a), at most v times `end_time`,
    and the velocity max(v, sqrt(a length)); a system at rest in contact has the scales of a flight of `end_time`
    (s).  Coordinates have sizes of their own in the same way.
    """
    work = system.new_workspace()
    defined, _, c = contact_problem(system, 0.0, q0, qd0, work)
    speed = max(abs(c.gap_rate), abs(c.slip_rate))
    push = max(abs(c.gap_acceleration), abs(c.slip_acceleration)) if defined else 0.0
    # an acceleration that is rounding changes nothing within the run
    way = speed * end_time
    length = max(abs(c.gap), min(way, speed * speed / push) if push > 0.0 else way)
    length = length or push * end_time**2 or 1.0
    speed = max(speed, math.sqrt(push * length)) or length / end_time
    time = length / speed
    effective_mass = 1.0 / c.a_nn if c.a_nn > 0.0 else 1.0
    tolerances = Tolerances.of(length, time, effective_mass * max(push, speed / time))
    pull = np.abs(work.vectors.free_acceleration) if defined else np.zeros_like(q0)
    with np.errstate(divide="ignore", invalid="ignore"):
        ways = np.minimum(np.where(pull > 0.0, qd0**2 / pull, np.inf), np.abs(qd0) * end_time)
    size = np.maximum(np.abs(q0), ways)
    size = np.where(size > 0.0, size, pull * time**2)
    size = np.where(size > 0.0, size, np.max(size) or length)
    rate = np.maximum(np.abs(qd0), np.sqrt(pull * size))
    return tolerances, np.concatenate([size, np.where(rate > 0.0, rate, size / time)])
