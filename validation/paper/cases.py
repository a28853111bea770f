"""What is simulated: the paper's case, the choices that it leaves open, and scenarios that stick."""

from __future__ import annotations

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

    `paper` is behind figures 2 to 16.  `sticking` (a steep rough slope) and `rough` (the paper's slope with much
    friction) stick.
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
    return found


def combinations() -> list[dict[str, Any]]:
    """Return all combinations of modes, g, shortening and Baumgarte's form, each as `paper` takes it.

    The form matters to the fixed-step scheme only: located contacts have nothing to stabilize.
    """
    names = ("scheme", "discretization__modes", "gravity", "contact__shortening", "solver__baumgarte_form")
    grid = product(SCHEMES, (1, 2, 3, 4), (9.8, 9.81), (True, False), ("squared", "plain"))
    found = [dict(zip(names, point, strict=True)) for point in grid]
    return [c for c in found if c["scheme"] == "fixed-step" or c["solver__baumgarte_form"] == "squared"]
