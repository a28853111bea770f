"""A scenario with the exact beam as a problem for the loop of all methods."""

from __future__ import annotations

import numpy as np

from oblique_impact.beam.base_motion import base_motion_of
from oblique_impact.beam.beam import contact_places
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam_problem import NEAR, Parts, beam_tolerances, decision_about, scheme_of
from oblique_impact.contact.transitions import Earlier
from oblique_impact.fem_beam.exact.exact_beam import ExactBeam
from oblique_impact.fem_beam.exact.exact_rest import start_of
from oblique_impact.fem_beam.exact.exact_scheme import ExactScheme
from oblique_impact.fem_beam.exact.exact_system import beam_of, hand_over_of, model_of
from oblique_impact.fem_beam.exact.mean_step import SteppedModel
from oblique_impact.marching.problem import Problem
from oblique_impact.marching.scheme import Scheme
from oblique_impact.scenario.scenario import Scenario


def exact_problem(scenario: Scenario, beam: ExactBeam | None = None, parts: Parts = Parts()) -> Problem:
    """Return the problem of a scenario with the exact beam.

    `beam` replaces that of the scenario, friction and base motion of `parts` its own.
    """
    beam = beam_of(scenario) if beam is None else beam
    solver, driven = scenario.solver, scenario.root.kind == "driven"
    motion = parts.base_motion or base_motion_of(scenario.root)
    model = model_of(scenario, beam, motion)
    scheme: Scheme
    if scenario.contact.enabled and scenario.contact.normal == "rigid":
        model, scheme, hand_over = SteppedModel(*model), scheme_of(scenario), {}
    else:
        near = NEAR * scenario.beam.length if scenario.contact.enabled else -np.inf
        shortest = min(solver.contact_step, solver.free_step)
        scheme = ExactScheme(solver.free_step, shortest, near, solver.tolerance, len(scenario.acting_forces))
        hand_over = hand_over_of(model.touchings)
    tolerances = beam_tolerances(scenario, Sections.from_scenario(scenario).mass)
    q, earlier = beam.moved(beam.straight(scenario.initial.angle), scenario.root_axis), dict[int, Earlier]()
    if scenario.initial.state != "undeformed":
        q, earlier = start_of(scenario, beam, scheme, parts)
    speed = motion.at(0.0).speed if driven else scenario.initial.angular_velocity
    v = beam.turning(q, speed)
    if scenario.root.is_free:  # it turns about its middle
        spun = -1j * speed * complex(*scenario.initial.position)
        v = beam.moved(v, complex(*scenario.initial.velocity) + spun)
    return Problem(
        model,
        q,
        v,
        decision_about(contact_places(scenario), scenario, scheme, tolerances, parts),
        scheme,
        end_time=scenario.end_time,
        output_interval=solver.output_interval,
        scales=np.ones(2 * q.size),
        contact=scenario.contact.enabled,
        breakpoints=(
            *model.jumps.tolist(),
            *(model.shaking.breakpoints if model.shaking else ()),
            *(model.forces.each.breakpoints if model.forces else ()),
        ),
        earlier=earlier if scenario.contact.enabled else {},
        hand_over=hand_over,
    )
