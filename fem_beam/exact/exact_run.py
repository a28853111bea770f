"""A scenario with the exact beam as a problem for the loop of all methods."""

from __future__ import annotations

import numpy as np

from oblique_impact.beam.base_motion import base_motion_of
from oblique_impact.beam.beam import contact_places
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam_problem import NEAR, Parts, beam_tolerances, decision_about
from oblique_impact.contact.transitions import Earlier
from oblique_impact.fem_beam.exact.exact_beam import ExactBeam
from oblique_impact.fem_beam.exact.exact_rest import start_of
from oblique_impact.fem_beam.exact.exact_scheme import ExactScheme
from oblique_impact.fem_beam.exact.exact_system import beam_of, hand_over_of, model_of
from oblique_impact.marching.problem import Problem
from oblique_impact.scenario.scenario import Scenario


def exact_problem(scenario: Scenario, beam: ExactBeam | None = None, parts: Parts = Parts()) -> Problem:
    """Return the problem of a scenario with the exact beam.

    `beam` replaces that of the scenario, friction and base motion of `parts` its own.
    """
    beam = beam_of(scenario) if beam is None else beam
    solver, driven = scenario.solver, scenario.root.kind == "driven"
    motion = parts.base_motion or base_motion_of(scenario.root)
    model = model_of(scenario, beam, motion)
    near = NEAR * scenario.beam.length if scenario.contact.enabled else -np.inf
    shortest = min(solver.contact_step, solver.free_step)
    scheme = ExactScheme(solver.free_step, shortest, near, solver.tolerance, len(scenario.acting_forces))
    tolerances = beam_tolerances(scenario, Sections.from_scenario(scenario).mass)
    q, earlier = beam.straight(scenario.initial.angle), dict[int, Earlier]()
    if scenario.initial.state != "undeformed":
        q, earlier = start_of(scenario, beam, scheme, parts)
    speed = motion.at(0.0).speed if driven else scenario.initial.angular_velocity
    return Problem(
        model,
        q,
        beam.turning(q, speed),
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
        hand_over=hand_over_of(model.touchings),
    )
