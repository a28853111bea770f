"""Why the tip can or cannot stick: the forces that would hold it, beside what friction can give.

At an instant of contact the two constraints Z_n'' = 0 and Z_tau'' = 0 together have one solution
(lambda_n, lambda_tau).  The tip can stick only where its slip velocity is zero, that solution pushes
(lambda_n > 0) and lies in the friction cone, |lambda_tau| <= mu_s lambda_n.

Why the ratio is about 10 in the paper's example: the beam does not stretch, so to first order in its
deflection its tip moves across the line from the pin only, and a contact that holds it has to act along
that line.  With an angle b between line and slope such a force has the ratio |lambda_tau|/lambda_n = cot|b|:
in contact b = -0.093 and cot|b| = 10.7, the friction coefficient at which a rigid bar would jam.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from oblique_impact.beam.beam import Beam
from oblique_impact.beam.operators import build_operators
from oblique_impact.contact.forces import OK, holding_force
from oblique_impact.contact.state import Baumgarte, Phase
from oblique_impact.contact.transitions import EventKind
from oblique_impact.history.history import History
from oblique_impact.history.sample_times import last_sample
from oblique_impact.marching.sampling import contact_problem
from oblique_impact.validation.paper.cases import paper
from oblique_impact.validation.paper.measures import NAN, run_light


class StickCheck(NamedTuple):
    """The sticking solution at a reversal of slip, or where stick began (SI units).

    `normal` and `tangential` are lambda_n and lambda_tau (N) as the run's scheme judges them, fixed steps with
    Baumgarte's terms; NaN where there is no solution.  `cotangent` is cot|b|, b the angle between the slope and
    the line from the pin to the contact point.
    """

    time: float
    kind: str
    slip_rate: float
    normal: float
    tangential: float
    cotangent: float

    @property
    def ratio(self) -> float:
        """|lambda_tau| / lambda_n; infinite where the contact would pull, NaN where there is no solution."""
        if np.isnan(self.normal):
            return NAN
        return abs(self.tangential) / self.normal if self.normal > 0.0 else float("inf")


def stick_checks(run: History) -> list[StickCheck]:
    """Return the sticking solution wherever the direction of slip turned or stick began."""
    scenario = run.scenario
    assert scenario is not None
    solver = scenario.solver
    model = Beam(scenario, build_operators(scenario)).model
    work, times = model.new_workspace(), run["time"].values
    rate, place = Baumgarte.from_parameters(*solver.baumgarte, solver.baumgarte_form)
    checks = []
    for event in run.events:
        if event.kind not in (EventKind.REVERSAL, EventKind.STICK):
            continue
        sample = int(last_sample(times, event.time))
        q, qd = (np.ascontiguousarray(run[name].values[sample]) for name in ("q", "qd"))
        problem = contact_problem(model, float(times[sample]), q, qd, work)[2]
        slip_rate = problem.slip_rate
        if solver.scheme == "fixed-step":
            problem = problem._replace(
                gap_acceleration=problem.gap_acceleration + rate * problem.gap_rate + place * problem.gap,
                slip_acceleration=problem.slip_acceleration + rate * slip_rate,
            )
        force = holding_force(Phase(), problem, 0.0)
        normal, tangential = force[1:] if force.status == OK else (NAN, NAN)
        line = np.arctan2(run["tip_y"].values[sample], run["tip_x"].values[sample])
        cotangent = float(1.0 / np.tan(abs(line - scenario.slope.angle)))
        checks.append(StickCheck(event.time, event.kind.value, slip_rate, normal, tangential, cotangent))
    return checks


class Threshold(NamedTuple):
    """Ratio of forces that the first reversal asks for, and what happens there with `mu_static` around it."""

    ratio: float
    tried: list[dict[str, Any]]


def find_threshold(checks: Sequence[StickCheck]) -> Threshold:
    """Try static coefficients just below and just above what the first reversal of the paper's case asks for."""
    first = next(check for check in checks if check.kind == "reversal")
    tried: list[dict[str, Any]] = []
    for factor in (0.999, 1.001):
        mu = factor * first.ratio
        found = stick_checks(run_light(paper("event", end_time=0.335, contact__mu_static=mu)))
        check = min(found, key=lambda c: abs(c.time - first.time))
        tried.append({"mu_static": mu, "happened": f"{check.kind} at {check.time:.6f} s"})
    return Threshold(first.ratio, tried)
