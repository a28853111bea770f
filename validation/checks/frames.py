"""Tangent against mean-axis frame, for the same beam."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from oblique_impact.beam.operators import build_operators
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.checks.kinetics import tip_at
from oblique_impact.validation.checks.registry import ROUNDING, Measurement, checks_of
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import column, run

check = checks_of("frames", "Tangent against mean-axis frame")


@check(
    "Free fall in both frames, full kinetics: the tips' paths approach each other as modes are added.", seconds=2.0
)
def free_fall() -> list[Measurement]:
    """Largest distance for 1, 2 and 4 modes."""
    times, differences = np.linspace(0.0, 0.15, 31), []
    for modes in (1, 2, 4):
        common = ("end_time=0.15", "discretization.kinetics=full", f"discretization.modes={modes}")
        a, b = run("paper", *common), run("paper", *common, "discretization.frame=mean-axis")
        differences.append(float(np.abs(tip_at(a, times) - tip_at(b, times)).max()))
    text = "one continuous beam: truncated sums of k⁻⁴ and faster"
    second, fourth = (differences[k + 1] / differences[k] for k in (0, 1))
    return [
        Measurement("largest distance, four modes", differences[2], 0.0, "m", 1e-6, text, "distance"),
        Measurement("distance of two modes over that of one", second, 0.0, "1", 1.0 / 3.0, text, "falls-2"),
        Measurement("distance of four modes over that of two", fourth, 0.0, "1", 0.5, text, "falls-4"),
    ]


@check("A driven hub in all modes of one mesh: both frames span the same nodal space.", seconds=2.0)
def same_space() -> list[Measurement]:
    """Tip distance for a torque and a tenth of it: what is left is of second order in the deflection."""
    hub = ("root.kind=hub", "root.inertia=2.0", "contact.enabled=false", "gravity=0.0", "end_time=0.05")
    keys = ("method=fem", "elements=4", "modes=8", "kinetics=full")
    base = Scenario.builtin("paper", [*hub, *(f"discretization.{key}" for key in keys)])
    times, differences = np.linspace(0.0, 0.05, 11), []
    for torque in (30.0, 3.0):
        tips = [
            tip_at(simulate(base.replace(root__torque=torque, discretization__frame=frame)), times)
            for frame in ("tangent", "mean-axis")
        ]
        differences.append(float(np.abs(tips[0] - tips[1]).max()))
    text, ratio = "the foreshortened positions differ by products of deflections", differences[1] / differences[0]
    return [
        Measurement("largest distance, 30 N m", differences[0], 0.0, "m", 1e-7, text, "distance"),
        Measurement("distance at a tenth of the torque over that", ratio, 0.0, "1", 0.008, text, "quadratic"),
    ]


@check(
    "The frame decides how fast it turns: like a rigid bar in the mean-axis frame; in the tangent frame the "
    "elastic coordinates leave the angle hardly any inertia.",
    seconds=2.0,
)
def frame_rate() -> Iterator[Measurement]:
    """Largest theta' through the paper's impacts in the mean-axis frame; inertia left in the tangent frame."""
    history = run("paper", "discretization.frame=mean-axis", "discretization.modes=4")
    fastest, quantity = float(np.abs(column(history, "theta_dot")).max()), "largest rate, mean-axis, four modes"
    speed, text = -VALUES["4"]["omega"], f"speed at the first touch; {source('4')}"
    # the beam vibrates a little while it falls
    yield Measurement(quantity, fastest, speed, "rad/s", 3e-3, text, "mean-axis")
    for modes in (1, 2, 4):
        o = build_operators(Scenario.builtin("paper", [f"discretization.modes={modes}"]))
        left = float(1.0 - o.S @ np.linalg.solve(o.M1, o.S) / o.J)
        # a small difference from 1, which is what is rounded
        exact = 1.0 - 12.0 * sum(root**-4 for root in VALUES["1.1"][:modes])
        text = "closed form: 1 - 12 sum b^-4, as int x phi dx = 2 L^2/b^2 (clamped-free, int phi^2 dx = L)"
        text, quantity = f"{text}; {source('1.1')}", f"inertia left for theta over J, tangent, {modes} modes"
        yield Measurement(quantity, left, exact, "1", ROUNDING, text, f"tangent-{modes}")
