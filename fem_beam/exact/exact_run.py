"""From a scenario to a run of the exact beam, in the loop of all methods, and how long that will take."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from oblique_impact.beam.base_motion import BaseMotion, base_motion_of
from oblique_impact.beam.cross_sections import Sections
from oblique_impact.beam_problem import NEAR, Parts, beam_tolerances, candidates_at, contact_machine
from oblique_impact.fem_beam.exact.elastic_sections import ElasticSections
from oblique_impact.fem_beam.exact.exact_scheme import ExactScheme
from oblique_impact.fem_beam.exact.exact_system import ExactSystem, beam_of, places_of, touchings_of
from oblique_impact.marching.loop import Run
from oblique_impact.marching.problem import Candidates, Problem
from oblique_impact.progress import Status
from oblique_impact.scenario.scenario import Scenario

#: steps that are timed to estimate the time of the whole run: some hundredths of a second
_TIMED = 20
_WAIT = 10.0  # s; a shorter run is not worth a line


def exact_problem(
    scenario: Scenario, sections: ElasticSections | None = None, motion: BaseMotion | None = None
) -> Problem:
    """Return the problem of a scenario with the exact beam.

    `sections` and the `motion` of a driven root replace those of the scenario.
    """
    beam, scheme, driven = beam_of(scenario, sections), ExactScheme(), scenario.root.kind == "driven"
    system = ExactSystem(scenario, beam, motion or base_motion_of(scenario.root), touchings_of(scenario, beam))
    tolerances, places = beam_tolerances(scenario, Sections.from_scenario(scenario).mass), places_of(scenario)
    if places:
        candidates = candidates_at(places, scenario, scheme, tolerances)._replace(hand_over=system.hand_over)
    else:
        stiffness, extent = scenario.contact.stiffness, scenario.slope.extent
        machine = contact_machine(scenario, scheme, tolerances, Parts(), stiffness, extent)
        candidates = Candidates.of_one(machine)
    q = beam.straight(scenario.initial.angle)
    speed = system.motion.at(0.0).speed if driven else scenario.initial.angular_velocity
    return Problem(
        system,
        q,
        beam.turning(q, speed),
        candidates=candidates,
        scheme=scheme,
        end_time=scenario.end_time,
        output_interval=scenario.solver.output_interval,
        scales=np.ones(2 * q.size),
        contact=scenario.contact.enabled,
        breakpoints=(*system.breakpoints, *(system.shaking.breakpoints if system.shaking else ())),
    )


def exact_run(problem: Problem, on_progress: Callable[[Status], None] | None = None) -> Run:
    """Return the run of a problem, which after its first steps tells how long it may take."""
    started, told = time.perf_counter(), False

    def report(status: Status) -> None:
        nonlocal told
        if not told and run.record.steps >= _TIMED:
            told = True
            step = (time.perf_counter() - started) / run.record.steps
            status = status._replace(notice=expected_duration(problem.system.scenario, step))
        if on_progress:
            on_progress(status)

    run = Run(problem, report)
    return run


def expected_duration(scenario: Scenario, step: float) -> str:
    """Return the estimated computing time of a run as text; "" if it is short.  A step takes `step` (s)."""
    lengths = scenario.solver.free_step, scenario.solver.contact_step
    free, near = (step * scenario.end_time / length for length in lengths)
    if not scenario.contact.enabled:
        return f"about {_duration(free)}, at {1e3 * step:.2g} ms a step" if free > _WAIT else ""
    if max(free, near) < _WAIT:
        return ""
    words, reach = f"{_duration(free)} if it stays away from obstacles", f"{NEAR:g} beam.length"
    return f"{words}, {_duration(near)} if it stays within {reach} of one, at {1e3 * step:.2g} ms a step"


def _duration(seconds: float) -> str:
    """Format a computing time."""
    for size, unit in ((3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{seconds:.0f} s"
