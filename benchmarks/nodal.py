"""The full nodal model: processor time of a step and memory, over the number of elements.

python benchmarks/nodal.py [TURNS]
"""

from __future__ import annotations

import statistics
import sys

from measuring import call_cost, print_table

from oblique_impact import Scenario
from oblique_impact.beam_problem import beam_of, beam_problem
from oblique_impact.marching.loop import Problem, Run

NODAL = (
    "contact.normal=spring",
    "contact.friction=frictionless",
    "discretization.frame=mean-axis",
    "discretization.method=fem",
    "discretization.modes=0",
    "solver.scheme=generalized-alpha",
    "solver.output_interval=0.05",
)
#: at rest on a soft stop, and a flight far above the slope
CONTACT = (
    "slope.origin=[0.0, 0.0]",
    "slope.angle=0.0",
    "initial.angle=0.0",
    "contact.stiffness=1e4",
    "solver.rho_infinity=0.0",
)
FLIGHT = ("slope.origin=[0.0, -5.0]",)
STEPS = {32: 4000, 128: 2000, 512: 500, 1024: 250}
CONTACT_STEP, FLIGHT_STEP = 1e-6, 1e-4  # s, those of the built-in cases

#: (elements, whether in flight) -> seconds of a step in each turn
Costs = dict[tuple[int, bool], list[float]]


def problem_of(elements: int, *changes: str) -> Problem:
    """Return the problem of the paper's beam on a spring."""
    mesh = f"discretization.elements={elements}"
    return beam_problem(beam_of(Scenario.builtin("paper", [*NODAL, mesh, *changes])))


def step_cost(elements: int, flight: bool) -> float:
    """Return the processor seconds of one step."""
    kind, step = (FLIGHT, FLIGHT_STEP) if flight else (CONTACT, CONTACT_STEP)
    run = Run(problem_of(elements, *kind, f"end_time={STEPS[elements] * step}"))
    seconds, record = call_cost(run.execute)
    return seconds / record.steps


def step_costs(turns: int) -> Costs:
    """Return the costs of steps over turns, after one that is not counted."""
    found: Costs = {(elements, flight): [] for elements in STEPS for flight in (False, True)}
    for turn in range(turns + 1):
        for case, seconds in found.items():
            cost = step_cost(*case)
            if turn:
                seconds.append(cost)
    return found


def step_ratios(costs: Costs) -> dict[str, float]:
    """Return the medians over turns of ratios of costs."""

    def ratio(a: tuple[int, bool], b: tuple[int, bool]) -> float:
        return statistics.median(x / y for x, y in zip(costs[a], costs[b], strict=True))

    return {
        "flight over contact, 128 elements": ratio((128, True), (128, False)),
        "flight over contact, 1,024 elements": ratio((1024, True), (1024, False)),
        "1,024 over 128 elements, contact": ratio((1024, False), (128, False)),
        "1,024 over 128 elements, flight": ratio((1024, True), (128, True)),
    }


def memory(elements: int) -> int:
    """Return the bytes of the work arrays and of the banded matrices."""
    system = problem_of(elements).system
    work = system.new_workspace()
    return sum(array.nbytes for array in (*work[:-1], *work.vectors)) + int(system.bands.nbytes)


def main(turns: int = 7) -> None:
    """Measure and print."""
    costs = step_costs(turns)
    rows = [
        [
            elements,
            *(f"{1e6 * statistics.median(costs[elements, flight]):.2f}" for flight in (False, True)),
            f"{memory(elements) / 1e3:.0f}",
        ]
        for elements in STEPS
    ]
    headings = ("elements", "in contact (us)", "in flight (us)", "arrays (kB)")
    print_table("Generalized-alpha: processor time of a step", headings, rows)
    for name, ratio in step_ratios(costs).items():
        print(f"{name}: {ratio:.2f}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
