"""Gap, slip and their rates against the geometry of the deformed centreline."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.interpolate import CubicSpline

from oblique_impact.history.history import History
from oblique_impact.history.sample_times import pieces
from oblique_impact.validation.checks.registry import ROUNDING, Measurement, checks_of
from oblique_impact.validation.runs import NEAR_FINE, Array, column, run

check = checks_of("kinematics", "Contact kinematics")

_METHODS = {"modal": (), "fem": ("discretization.method=fem",)}


def integral_defects(history: History, values: str, rate: str) -> Array:
    """Change of a variable less the integral of its rate, for each smooth piece of a history."""
    time, y, dy = (column(history, name) for name in ("time", values, rate))
    found = []
    for piece in pieces(time):
        if piece.size >= 4:
            spline = CubicSpline(time[piece], dy[piece])
            found.append(y[piece[-1]] - y[piece[0]] - float(spline.integrate(time[piece[0]], time[piece[-1]])))
    return np.array(found)


@check(
    "Rates integrate to positions between jumps: the contact rows are the gradients of gap and slip.", seconds=1.5
)
def rates() -> Iterator[Measurement]:
    """Largest defect over the phases of the first macro-collision."""
    text = "fundamental theorem of calculus; cubic splines through samples 10 µs apart"
    for name, overrides in _METHODS.items():
        history = run("paper", *NEAR_FINE, *overrides)
        for values, rate in (("gap", "gap_rate"), ("slip", "slip_rate"), ("tip_x", "tip_vx"), ("tip_y", "tip_vy")):
            worst = float(np.abs(integral_defects(history, values, rate)).max())
            label, quantity = values.replace("_", "-"), f"{values} against {rate}: largest defect, {name}"
            yield Measurement(quantity, worst, 0.0, "m", 1e-12, text, f"{label}-{name}")


@check("A closed contact stays closed, and its force never pulls.", seconds=1.5)
def closed_contact() -> list[Measurement]:
    """Largest |gap| while closed and smallest normal force, event scheme."""
    history = run("paper", *NEAR_FINE)
    closed = column(history, "state") > 0
    force = column(history, "lambda_n")
    drift = float(np.abs(column(history, "gap")[closed]).max())
    pull = -float(np.minimum(force[closed], 0.0).min()) / float(force.max())
    flight, text = float(np.abs(force[~closed]).max()), "unilateral contact (Signorini)"
    return [
        Measurement("largest |gap| in contact", drift, 0.0, "m", ROUNDING, text, "drift"),
        # a release is located where the force is zero but for rounding
        Measurement("largest pull over the largest force", pull, 0.0, "1", ROUNDING, text, "pull"),
        Measurement("largest force in flight", flight, 0.0, "N", 0.0, text, "flight"),
    ]
