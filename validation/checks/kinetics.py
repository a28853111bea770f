"""One beam in two forms: first-order against full kinetic energy, tangent against mean-axis frame."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from oblique_impact.beam.operators import build_operators
from oblique_impact.history.history import History
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import compute_history as simulate
from oblique_impact.validation.checks.registry import ROUNDING, Measurement, checks_of
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import Array, column, run

check = checks_of("kinetics", "First-order against full kinetics")
frames = checks_of("frames", "Tangent against mean-axis frame")

_FULL = "discretization.kinetics=full"
_DROPPED = "first-order kinetics drop cubic terms of T, forces of second order in the deflection (theory Sec. 3)"
_TEXT = "nothing-dropped kinetic energy by quadrature (theory Sec. 3)"


def tip_at(history: History, times: Array) -> Array:
    """Inertial tip positions (2, times)."""
    return np.stack([np.interp(times, column(history, "time"), column(history, n)) for n in ("tip_x", "tip_y")])


@check(
    "Mean-axis frame, six modes: first and second macro-collision in first-order and full kinetics.", seconds=14.0
)
def collisions() -> list[Measurement]:
    """Ends of the first and starts of the second macro-collision."""
    common = ("discretization.frame=mean-axis", "discretization.modes=6")
    first, full = (run("paper", *common, *extra).summary["macro_collisions"] for extra in ((), (_FULL,)))
    end, exact_end = first[0]["end"], full[0]["end"]
    start, exact_start = first[1]["start"], full[1]["start"]
    return [
        Measurement("end of the first macro-collision", end, exact_end, "s", 9e-7, _TEXT, "first"),
        Measurement("start of the second macro-collision", start, exact_start, "s", 5e-4, _TEXT, "second"),
    ]


@check("What first order drops is of second order in the relative deflection.", seconds=2.0)
def order_in_deflection() -> list[Measurement]:
    """Distance of the tips in free flight, for the paper's beam and one ten times softer."""
    times = np.linspace(0.0, 0.3, 31)
    differences, deflections = [], []
    for modulus in (68.952e8, 68.952e9):
        common = ("end_time=0.3", f"beam.youngs_modulus={modulus}")
        a, b = run("paper", *common), run("paper", *common, _FULL)
        differences.append(float(np.abs(tip_at(a, times) - tip_at(b, times)).max()))
        deflections.append(float(np.abs(column(a, "deflection")).max()))
    order = np.log(differences[0] / differences[1]) / np.log(deflections[0] / deflections[1])
    quantity, allowed = "largest distance of the tips, the paper's beam", 0.1 * deflections[1] ** 2
    text = "a part of the deflection squared over the length"
    return [
        # vibrations of two beams meet the sampled times in different phases
        Measurement("observed order", float(order), 2.0, "1", 0.5, _DROPPED, "order"),
        Measurement(quantity, differences[1], 0.0, "m", allowed, text, "distance"),
    ]


@frames("A driven hub in all modes of one mesh: both frames span the same nodal space.", seconds=2.0)
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


@frames(
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
