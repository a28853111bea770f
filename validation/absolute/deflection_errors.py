"""Errors of the floating frame against the exact beam, where deflections and spin rates grow.

Two problems in units of the beam, L = rho A = E I = 1 (unit of time T = sqrt(rho A L^4/E I)):

`hub`       a hub, thirty times as heavy to turn as the beam, spins at the rate eta; a torque bends the beam
`pendulum`  a pinned beam starts horizontally with the rate eta and falls

Loads grow, so that the largest deflection goes from a thousandth of the length to a half of it.  What is compared
is the deflection of the tip, from the tangent of the hub or from the mean axis of the pendulum, whatever the frame
of the model: the error is the largest difference from the exact beam within two periods of the first elastic mode,
over the largest deflection.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from oblique_impact.errors import InputError, Outcome
from oblique_impact.history.history import History
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import simulate
from validation.absolute.history import simulate as simulate_exactly
from validation.absolute.sections import Array, ElasticSections
from validation.beams import UNIT

#: nominal deflections over the length, and spin rates in units of 1/T
DEFLECTIONS = (0.001, 0.003, 0.01, 0.03, 0.1, 0.2, 0.35, 0.5)
SPINS = (0.0, 2.0, 4.0, 8.0)
#: E A L^2/E I: an extension that nothing shows
_SLENDER = 1e8
_EXACT_ELEMENTS, _EXACT_STEPS, _SAMPLES = 10, 1000, 200
#: spin rate (1/T) up to which so many steps are enough: sections turn by an angle, places along a chord, which
#: differ like the square of the turn in a step
_SLOW = 2.0
#: first elastic periods (T): clamped, hinged
_PERIODS = {"hub": 2.0 * math.pi / 3.5160, "pendulum": 2.0 * math.pi / 15.418}
#: errors that are those of the model: smaller ones may be of the exact beam's step, larger ones of another motion
_CLEAR = (0.01, 0.5)
_HUB = 10.0  # of the beam's rho A L^3

_MEAN, _TANGENT = "discretization__frame", "discretization__kinetics"
#: problem -> model -> changes
MODELS: dict[str, dict[str, dict[str, Any]]] = {
    "hub": {
        "tangent, zeroth order": {_TANGENT: "zeroth-order", "discretization__modes": 6},
        "tangent, first order": {_TANGENT: "first-order", "discretization__modes": 6},
        "tangent, full": {_TANGENT: "full", "discretization__modes": 6},
    },
    "pendulum": {
        "mean axis, zeroth order": {_TANGENT: "zeroth-order", _MEAN: "mean-axis", "discretization__modes": 6},
        "mean axis, first order": {_TANGENT: "first-order", _MEAN: "mean-axis", "discretization__modes": 6},
        "mean axis, full": {_TANGENT: "full", _MEAN: "mean-axis", "discretization__modes": 6},
        "tangent, first order": {_TANGENT: "first-order", "discretization__modes": 4},
        "tangent, full": {_TANGENT: "full", "discretization__modes": 4},
    },
}


@dataclass(frozen=True)
class Point:
    """One model at one flexibility and spin rate.

    Attributes
    ----------
    problem, model : str
        As in `MODELS`.
    nominal : float
        Deflection over length that sets the load.
    spin : float
        1/T.
    deflection : float
        Largest deflection of the exact beam over its length.
    error : float
        Relative error; NaN where the model has none.
    outcome : str
        How the model's run ended, "completed" or a name.
    """

    problem: str
    model: str
    nominal: float
    spin: float
    deflection: float
    error: float
    outcome: str


@dataclass(frozen=True)
class SmallDeflection:
    """The map, and its page if one was written."""

    points: tuple[Point, ...]
    seconds: float
    report: Path | None = None

    def of(self, problem: str, model: str) -> list[Point]:
        """Return the points of one model."""
        return [point for point in self.points if (point.problem, point.model) == (problem, model)]

    def coefficient(self, problem: str, model: str) -> float:
        """Median of the error over the square of the deflection over the length, where it is 1 % to 50 %."""
        points = [point for point in self.of(problem, model) if _CLEAR[0] <= point.error <= _CLEAR[1]]
        return float(np.median([point.error / point.deflection**2 for point in points])) if points else math.nan


def scenario_of(problem: str, nominal: float, spin: float) -> Scenario:
    """Return a problem, to be marched by any model.

    The load follows from small deflections: under a sudden angular acceleration a the tip of a clamped beam comes
    to twice 11 rho A a L^5/(120 E I); that of a beam falling under gravity g to about rho A g L^4/(160 E I) from
    its mean axis.
    """
    period = _PERIODS[problem]
    root: dict[str, Any] = {"kind": "pin"}
    gravity = 160.0 * nominal if problem == "pendulum" else 0.0
    if problem == "hub":
        acceleration = nominal * 120.0 / 22.0
        root = {"kind": "hub", "inertia": _HUB, "torque": acceleration * (_HUB + 1.0 / 3.0)}
    return Scenario.from_dict(
        {
            "end_time": 2.0 * period,
            "gravity": gravity,
            "beam": UNIT,
            "root": root,
            "initial": {"angle": 0.0, "angular_velocity": spin},
            "contact": {"enabled": False},
            "solver": {"output_interval": 2.0 * period / _SAMPLES, "tolerance": 1e-8},
        }
    )


def exact(problem: str, nominal: float, spin: float) -> History:
    """March the exact beam of a problem: slender, without rotary inertia."""
    base = scenario_of(problem, nominal, spin)
    scenario = base.replace(
        discretization__method="absolute",
        discretization__elements=_EXACT_ELEMENTS,
        discretization__frame="tangent" if problem == "hub" else "mean-axis",
        solver__free_step=base.end_time / (_EXACT_STEPS * math.ceil(max(1.0, spin / _SLOW))),
    )
    sections = ElasticSections.uniform(_SLENDER, 0.4 * _SLENDER, 1.0, 1.0)
    return simulate_exactly(scenario, sections=sections)


def tip_deflection(problem: str, history: History) -> tuple[Array, Array]:
    """Return times (s), and the deflection (m) of the tip from the hub's tangent or from the mean axis.

    On the mean axis int x u_y dx = 0.
    """
    if problem == "hub":
        return history["time"].values, history["deflection"].values
    x, weights = history["station"].values, _simpson(history["station"].size)
    z = x + history["ux"].values + 1j * history["uy"].values
    axis = z @ (weights * x)
    return history["time"].values, np.imag(z[:, -1] * axis.conj()) / np.abs(axis)


def _simpson(count: int) -> Array:
    """Weights of Simpson's rule over stations that are equally far apart, an odd number of them."""
    weights = np.full(count, 2.0)
    weights[1::2] = 4.0
    weights[[0, -1]] = 1.0
    return weights


def points_of(case: tuple[str, float, float]) -> list[Point]:
    """March the exact beam and all models of one problem; in whatever process this is."""
    problem, nominal, spin = case
    reference = exact(*case)
    if reference.outcome is not Outcome.COMPLETED:
        raise InputError(f"{problem}, deflection {nominal:g}, spin {spin:g}: {reference.outcome.sentence}")
    times, deflection = tip_deflection(problem, reference)
    largest, found = float(np.abs(deflection).max()), []
    for model, changes in MODELS[problem].items():
        history = simulate(scenario_of(*case).replace(**changes))
        error = math.nan
        if history.outcome is Outcome.COMPLETED:
            error = float(np.abs(np.interp(times, *tip_deflection(problem, history)) - deflection).max() / largest)
        found.append(Point(problem, model, nominal, spin, largest, error, history.outcome.label))
    return found
