"""First-order against full kinetic energy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from oblique_impact.history.history import History
from oblique_impact.validation.checks.registry import Measurement, checks_of
from oblique_impact.validation.runs import column, run

check = checks_of("kinetics", "First-order against full kinetics")

_FULL = "discretization.kinetics=full"
_DROPPED = "first-order kinetics drop cubic terms of T, forces of second order in the deflection (theory Sec. 3)"
_TEXT = "nothing-dropped kinetic energy by quadrature (theory Sec. 3)"


def tip_at(history: History, times: NDArray[np.float64]) -> NDArray[np.float64]:
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


@check("Zeroth-order kinetics leave the foreshortening out altogether.", seconds=0.5)
def zeroth_order() -> Measurement:
    """Largest axial displacement."""
    history = run("paper", "end_time=0.3", "discretization.kinetics=zeroth-order")
    worst, text = float(np.abs(column(history, "ux")).max()), "definition of zeroth order"
    return Measurement("largest axial displacement, zeroth order", worst, 0.0, "m", 0.0, text)
