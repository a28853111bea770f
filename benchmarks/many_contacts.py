"""Costs of time-stepping: the case `slap`, steps with ten closed contacts over those with one, and of fine meshes.

    python benchmarks/many_contacts.py [TURNS]

The beam lies on pegs along it, which all stay closed, on one or on ten.
"""

from __future__ import annotations

import statistics
import sys
from functools import partial

from measuring import call_cost, median_ratio

from oblique_impact import Scenario
from oblique_impact.beam_problem import beam_of, beam_problem
from oblique_impact.marching.stepped import SteppedRun

STEPS = 2_000
STEP = 5e-6  # s


def on_pegs(pegs: int, elements: int) -> Scenario:
    """Return a beam at rest on pegs from a fifth of its length on, all of which it presses."""
    places = [0.2 + 0.75 * i / max(pegs - 1, 1) for i in range(pegs)] if pegs > 1 else [0.7]
    return Scenario.builtin("slap").adapted(
        beam__kelvin_voigt=1e-3,
        discretization__elements=elements,
        end_time=STEPS * STEP,
        initial__angle=0.0,
        obstacles=[{"kind": "point", "origin": [place, -1e-3], "radius": 1e-3} for place in places],
        solver__free_step=STEP,
        solver__contact_step=STEP,
    )


def cost(scenario: Scenario) -> float:
    """Return the processor seconds of marching."""
    return call_cost(SteppedRun(beam_problem(beam_of(scenario))).execute)[0]


def slap() -> float:
    """Return the processor seconds of marching `slap`: 64 elements, steps of 5e-6 s near the table."""
    return cost(Scenario.builtin("slap"))


def ratios(turns: int) -> dict[str, float]:
    """Return the medians over turns of ratios of costs."""
    one, ten = on_pegs(1, 64), on_pegs(10, 64)
    coarse, fine = on_pegs(10, 128), on_pegs(10, 1024)
    for scenario in (one, fine):
        cost(scenario)  # compiles what is missing
    return {
        "ten closed contacts over one, 64 elements": median_ratio(turns, partial(cost, ten), partial(cost, one)),
        "1,024 over 128 elements, ten contacts": median_ratio(turns, partial(cost, fine), partial(cost, coarse)),
    }


if __name__ == "__main__":
    turns = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    slap()
    print(f"slap: {statistics.median(slap() for _ in range(turns)):.2f} s of marching")
    for name, value in ratios(turns).items():
        print(f"{name}: {value:.2f}")
