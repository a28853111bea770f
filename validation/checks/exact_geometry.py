"""The paper's beam on an elastic stop against a geometrically exact code."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from oblique_impact.history.history import History
from oblique_impact.validation.checks.registry import Measurement, checks_of, within
from oblique_impact.validation.reference_values import VALUES, source
from oblique_impact.validation.runs import FEM, FRICTIONLESS, MEAN_AXIS, NODAL, SPRING, run

check = checks_of("exact-geometry", "Geometrically exact code")

_SPRING = (SPRING, "contact.stiffness=1e6", FRICTIONLESS, MEAN_AXIS, FEM, "discretization.elements=32")
_MODELS = {
    "nodal": (*NODAL, "solver.free_step=1e-5", "solver.contact_step=2e-6", "solver.rho_infinity=0.9"),
    "reduced": ("discretization.modes=24",),
}


def _on_a_spring(model: str, end_time: float) -> History:
    return run("paper", *_SPRING, *_MODELS[model], f"end_time={end_time}")


def _first_collision(history: History, model: str) -> Iterator[Measurement]:
    """Impulse, peak, starts and ends of the five contacts."""
    exact, text = VALUES["7a-elastic"], source("7a-elastic")
    first = history.summary["macro_collisions"][0]
    impulse, peak = first["normal_impulse"], first["peak_force"]
    yield within(f"impulse, {model}", impulse, exact["impulse"], "N s", 3e-4, text, f"impulse-{model}")
    yield within(f"peak force, {model}", peak, exact["peak"], "N", 5e-3, text, f"peak-{model}")
    for k, time in enumerate(np.ravel(exact["contacts"])):
        side = ("start", "end")[k % 2]
        quantity, name = f"{side} of contact {k // 2 + 1}, {model}", f"{model}-{side}-{k // 2 + 1}"
        yield Measurement(quantity, history.events[k].time, time, "s", 8e-6, text, name)


@check("The paper's beam on a spring of 10⁶ N/m, full mesh: the first macro-collision.", seconds=2.0)
def collision() -> Iterator[Measurement]:
    """32 elements by the implicit scheme."""
    return _first_collision(_on_a_spring("nodal", 0.34), "nodal")


@check("The same by 24 of its modes, event-located, and the next contact of both.", seconds=14.0)
def next_contact() -> Iterator[Measurement]:
    """Start of the second macro-collision."""
    exact, text = VALUES["7a-elastic"]["next"], source("7a-elastic")
    for model, allowed in (("nodal", 3e-5), ("reduced", 3e-4)):
        start = _on_a_spring(model, 0.87).summary["macro_collisions"][1]["start"]
        yield Measurement(f"next contact, {model}", start, exact, "s", allowed, text, f"next-{model}")
    yield from _first_collision(_on_a_spring("reduced", 0.87), "reduced")
