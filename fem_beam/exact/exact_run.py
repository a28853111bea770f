"""A scenario with the exact beam as a problem for the loop of all methods."""

from __future__ import annotations

import numpy as np

from oblique_impact.beam.base_motion import base_motion_of
from oblique_impact.beam.beam import contact_places
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam_problem import Parts, beam_tolerances, decision_about
from oblique_impact.fem_beam.exact.elastic_sections import ElasticSections
from oblique_impact.fem_beam.exact.exact_scheme import ExactScheme
from oblique_impact.fem_beam.exact.exact_system import ExactSystem, beam_of, touchings_of
from oblique_impact.marching.problem import Problem
from oblique_impact.scenario.scenario import Scenario


def exact_problem(scenario: Scenario, sections: ElasticSections | None = None, parts: Parts = Parts()) -> Problem:
    """Return the problem of a scenario with the exact beam.

    `sections`, and friction and base motion of `parts`, replace those of the scenario.
    """
    beam, scheme, driven = beam_of(scenario, sections), ExactScheme(), scenario.root.kind == "driven"
    motion = parts.base_motion or base_motion_of(scenario.root)
    system = ExactSystem(scenario, beam, motion, touchings_of(scenario, beam))
    tolerances = beam_tolerances(scenario, Sections.from_scenario(scenario).mass)
    q = beam.straight(scenario.initial.angle)
    speed = system.motion.at(0.0).speed if driven else scenario.initial.angular_velocity
    return Problem(
        system,
        q,
        beam.turning(q, speed),
        decision_about(contact_places(scenario), scenario, scheme, tolerances, parts),
        scheme,
        end_time=scenario.end_time,
        output_interval=scenario.solver.output_interval,
        scales=np.ones(2 * q.size),
        contact=scenario.contact.enabled,
        breakpoints=(*system.breakpoints, *(system.shaking.breakpoints if system.shaking else ())),
        hand_over=system.hand_over,
    )
