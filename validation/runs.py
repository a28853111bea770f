"""Runs and beams that several checks or studies share within one process."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from oblique_impact.history.history import History
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.simulation import compute_history as simulate

Array = NDArray[np.float64]

#: length, mass per length and bending stiffness of one
UNIT = {"length": 1.0, "area": 1.0, "density": 1.0, "youngs_modulus": 1.0, "second_moment": 1.0}
EPS = float(np.finfo(float).eps)

#: keys that several checks and studies take
FEM, MEAN_AXIS = "discretization.method=fem", "discretization.frame=mean-axis"
FRICTIONLESS, SPRING = "contact.friction=frictionless", "contact.normal=spring"
#: the full nodal model by generalized-alpha, in flight and on elastic stops
NODAL = (FEM, "discretization.modes=0", MEAN_AXIS, "solver.scheme=generalized-alpha")
#: the paper's beam just above the slope, straight and as fast as after its fall: it strikes after 21 µs
NEAR = ("initial.angle=0.2214", "initial.angular_velocity=-3.786")
#: the same until 0.02 s, sampled finely
NEAR_FINE = (*NEAR, "end_time=0.02", "solver.output_interval=1e-5")


@lru_cache(maxsize=24)
def run(name: str, *overrides: str) -> History:
    """Simulate a built-in scenario with overrides ``section.key=value``; the last few are remembered."""
    return simulate(Scenario.builtin(name, list(overrides)))


def run_exact(scenario: Scenario) -> History:
    """Simulate the exact beam without shear and rotary inertia, as the floating frame has it."""
    from oblique_impact.fem_beam import exact  # takes a while to load, for some checks alone

    return exact.simulate(scenario, sections=exact.ElasticSections.bernoulli_euler(scenario))


def event_times(history: History, *kinds: str) -> Array:
    """Return the times (s) of the events, or of those of the given kinds."""
    return np.array([e.time for e in history.events if not kinds or e.kind.value in kinds])


def contact_times(history: History) -> Array:
    """Start and end (s) of every contact; a rebound is a contact of no length.

    Whether a last, grazing contact is a rebound or lasts a microsecond depends on the mesh; its times
    converge all the same.
    """
    return np.array([time for contact in history.contacts for time in (contact.start, contact.end)])


def column(history: History, name: str) -> Array:
    """Values of one variable of a history."""
    return np.asarray(history[name].values, dtype=float)


def unit_beam(root: dict[str, Any] | None = None, **discretization: Any) -> Scenario:
    """Return a beam of unit data without contact."""
    return Scenario.from_dict(
        {
            "beam": UNIT,
            "contact": {"enabled": False},
            "root": root or {"kind": "pin"},
            "discretization": discretization,
        }
    )
