"""The paper's beam on an elastic stop against a geometrically exact code."""

from __future__ import annotations

from oblique_impact.history.history import History
from validation.checks.registry import Measurement, checks_of, within
from validation.reference_values import VALUES, source
from validation.runs import run

check = checks_of("exact-geometry", "Geometrically exact code")

_SPRING = (
    "contact.normal=spring",
    "contact.stiffness=1e6",
    "contact.friction=frictionless",
    "end_time=0.87",
    "discretization.frame=mean-axis",
    "discretization.method=fem",
    "discretization.elements=32",
)
_MODELS = {
    "nodal": (
        "discretization.modes=0",
        "solver.scheme=generalized-alpha",
        "solver.free_step=1e-5",
        "solver.contact_step=2e-6",
        "solver.rho_infinity=0.9",
    ),
    "reduced": ("discretization.modes=24",),
}


def _on_a_spring(model: str) -> History:
    return run("paper", *_SPRING, *_MODELS[model])


@check("The paper's beam on a spring of 10⁶ N/m, 32 elements: impulse, peak, next contact.", seconds=8.0)
def collision() -> list[Measurement]:
    """Full nodal model by the implicit scheme, and 24 of its modes event-located."""
    exact, text, found = VALUES["7a-elastic"], source("7a-elastic"), []
    for model in _MODELS:
        first, second = _on_a_spring(model).summary["macro_collisions"][:2]
        found += [
            within(
                f"impulse, {model}",
                first["normal_impulse"],
                exact["impulse"],
                "N s",
                1e-3,
                text,
                f"impulse-{model}",
            ),
            within(f"peak force, {model}", first["peak_force"], exact["peak"], "N", 5e-3, text, f"peak-{model}"),
            Measurement(
                f"next contact, {model}", second["start"], exact["next"], "s", 2e-3, text, f"next-{model}"
            ),
        ]
    return found


@check("The same: starts and ends of the five contacts of the first macro-collision.", seconds=8.0)
def contacts() -> list[Measurement]:
    """Ten event times."""
    exact, found = VALUES["7a-elastic"]["contacts"], []
    for model in _MODELS:
        events = _on_a_spring(model).events
        for k, pair in enumerate(exact):
            for event, time, name in zip(events[2 * k : 2 * k + 2], pair, ("start", "end"), strict=True):
                found.append(
                    Measurement(
                        f"{name} of contact {k + 1}, {model}",
                        event.time,
                        time,
                        "s",
                        2e-5,
                        source("7a-elastic"),
                        f"{model}-{name}-{k + 1}",
                    )
                )
    return found
