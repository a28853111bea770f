"""What is simulated: the paper's case, the choices that it leaves open, and scenarios that stick."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

from oblique_impact.scenario.scenario import Scenario

#: contact.friction of the three models, in the order of the paper
MODELS = ("hybrid", "frictionless", "modified-coulomb")
#: the two schemes that integrate the same equations, and their names in the report
SCHEMES = {"fixed-step": "fixed-step, as printed", "event": "event-located"}

#: output intervals (s) for figures, whose curves are not to be aliased (a period of the second clamped mode is
#: 10 ms), and for numbers
FINE, COARSE = 1e-5, 1e-4

#: friction coefficient at which the tip sticks on the paper's own slope (stick needs about 10 there)
ROUGH = 12.0


def paper(scheme: str, model: str = "hybrid", output_interval: float = COARSE, **changes: Any) -> Scenario:
    """Return the paper's case with one of its two schemes and one of its three models.

    Fixed steps judge stick as it is printed (Sec. 5.3), by the force alone.
    """
    return Scenario.builtin("paper").replace(
        **{
            "solver__stick": "force",
            "contact__friction": model,
            "solver__scheme": scheme,
            "solver__output_interval": output_interval,
            **changes,
        }
    )


def cases() -> dict[str, Scenario]:
    """Return the scenarios that are drawn and judged, by group/scheme/model.

    `paper` is behind figures 2 to 16.  `sticking` (a steep rough slope), `rough` (the paper's slope with much
    friction) and `no-shortening` (the contact point's foreshortening left out) stick, or are judged to.
    """
    steep = Scenario.builtin("sticking").replace(solver__output_interval=COARSE)
    rough = paper(
        "event",
        contact__mu_static=ROUGH,
        contact__mu_kinetic=ROUGH,
        discretization__frame="mean-axis",
        discretization__modes=3,
    )
    found = {f"paper/{scheme}/{model}": paper(scheme, model, FINE) for scheme, model in product(SCHEMES, MODELS)}
    for group, scenario in (("sticking", steep), ("rough", rough)):
        for scheme, model in product(SCHEMES, ("hybrid", "modified-coulomb")):
            found[f"{group}/{scheme}/{model}"] = scenario.replace(
                contact__friction=model, solver__scheme=scheme, solver__stick="force"
            )
    found["no-shortening/fixed-step/hybrid"] = paper("fixed-step", "hybrid", FINE, contact__shortening=False)
    return found


@dataclass(frozen=True)
class Variant:
    """One value of one choice that the paper leaves open; `assumed` marks the value in all other runs."""

    choice: str
    label: str
    scenario: Scenario
    assumed: bool


#: what the paper leaves open, with the values that it allows, the assumed one among them
_CHOICES: dict[str, dict[str, dict[str, Any]]] = {
    "number of modes": {f"{n} clamped": {"discretization__modes": n} for n in (1, 2, 3, 4)},
    "kind of modes": {
        "2 clamped, tangent frame": {},
        **{
            f"{n} hinged, mean-axis frame": {"discretization__frame": "mean-axis", "discretization__modes": n}
            for n in (2, 3, 4, 8)
        },
    },
    "contact point": {f"x_F = {x} m": {"contact__point": x} for x in (1.0, 0.95, 0.9, 0.8)},
    "value of g": {f"{g} m/s²": {"gravity": g} for g in (9.8, 9.80665, 9.81, 10.0)},
    "Baumgarte's form": {
        "Z'' + 2χZ' + β²Z = 0": {},
        "Z'' + χZ' + βZ = 0": {"solver__baumgarte_form": "plain"},
    },
    "velocities of the modified Coulomb law": {
        f"v₀ = {low:g}, v₁ = {high:g} m/s": {
            "contact__friction": "modified-coulomb",
            "contact__regularization": [low, high],
        }
        for low, high in ((1e-3, 1e-2), (0.0, 1e-2), (1e-5, 1e-4), (1e-2, 1e-1))
    },
    "judgement of stick": {
        "by the force that would hold the contact (Sec. 5.3)": {},
        "and by the slip, which must end within the step": {"solver__stick": "arrest"},
    },
    "foreshortening of the contact point": {
        "in gap and slip": {},
        "left out of both": {"contact__shortening": False},
    },
}
#: ways to integrate: each is a scheme of its own, so they are not crossed with the two schemes
_INTEGRATORS: dict[str, dict[str, Any]] = {
    "RK4, 0.1 ms and 1 µs": {"scheme": "fixed-step"},
    "RK4, 10 µs and 1 µs": {"scheme": "fixed-step", "solver__free_step": 1e-5},
    "RK4, 1 µs always": {"scheme": "fixed-step", "solver__free_step": 1e-6},
    "generalized-α, ρ∞ = 0.8": {"scheme": "generalized-alpha"},
    "order 8, event-located": {"scheme": "event"},
}


def variants() -> list[Variant]:
    """Return the paper's case with one choice changed at a time, under both schemes."""
    found = []
    for choice, values in _CHOICES.items():
        for (label, changes), scheme in product(values.items(), SCHEMES):
            scenario = paper(scheme, **changes)
            ours = paper(scheme, str(scenario.contact.friction))
            found.append(Variant(choice, label, scenario, scenario == ours))
    for label, changes in _INTEGRATORS.items():
        scenario = paper(**changes)
        found.append(Variant("integrator", label, scenario, scenario == paper("fixed-step")))
    return found


def combinations() -> list[dict[str, Any]]:
    """Return all combinations of modes, g, shortening and Baumgarte's form, each as `paper` takes it.

    The form matters to the fixed-step scheme only: located contacts have nothing to stabilize.
    """
    names = ("scheme", "discretization__modes", "gravity", "contact__shortening", "solver__baumgarte_form")
    grid = product(SCHEMES, (1, 2, 3, 4), (9.8, 9.81), (True, False), ("squared", "plain"))
    found = [dict(zip(names, point, strict=True)) for point in grid]
    return [c for c in found if c["scheme"] == "fixed-step" or c["solver__baumgarte_form"] == "squared"]
