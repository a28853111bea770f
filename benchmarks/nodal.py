"""The full nodal model: cost per step, memory, and whole runs against SciPy's solve_ivp.

    python benchmarks/nodal.py [RUNS]

Whole runs are 1 s of the paper's beam on an elastic stop of 1e6 N/m, without friction.  Their quantity is the
normal impulse of the first contact, its error taken against the converged value of the same model; only marching
is timed, with warm kernels.
"""

from __future__ import annotations

import statistics
import sys
import time
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table
from scipy.integrate import solve_ivp

from oblique_impact import Scenario
from oblique_impact.contact.state import Phase
from oblique_impact.kernels.jit import kernel
from oblique_impact.kernels.workspace import Workspace
from oblique_impact.marching.equations import QUADRATURES, derivative
from oblique_impact.marching.loop import Problem, Run
from oblique_impact.marching.probe import Probe
from oblique_impact.problem import beam_of, beam_problem

SPRING = ("contact.normal=spring", "contact.friction=frictionless", "discretization.frame=mean-axis")
NODAL = ("solver.scheme=generalized-alpha", "discretization.method=fem", "discretization.modes=0")
QUIET = "solver.output_interval=0.05"


class Timing(NamedTuple):
    """Median seconds of marching, steps, and the impulse of the first contact (N s)."""

    seconds: float
    steps: int
    impulse: float


def problem_of(*overrides: str) -> Problem:
    """Problem of the paper's beam on a spring."""
    return beam_problem(beam_of(Scenario.builtin("paper", [*SPRING, QUIET, *overrides])))


def march(runs: int, *overrides: str) -> Timing:
    """Time whole runs of the loop."""
    seconds, record = [], None
    for _ in range(runs + 1):
        run = Run(problem_of(*overrides))
        start = time.perf_counter()
        record = run.execute()
        seconds.append(time.perf_counter() - start)
    assert record is not None
    impulse = record.contacts[0].normal_impulse if record.contacts else 0.0
    return Timing(statistics.median(seconds[1:]), record.steps, impulse)


#: at rest on a soft stop, and a flight far above the slope
TOUCHING = (
    "slope.origin=[0.0, 0.0]",
    "slope.angle=0.0",
    "initial.angle=0.0",
    "contact.stiffness=1e4",
    "solver.rho_infinity=0.0",
)
FLYING = ("slope.origin=[0.0, -5.0]",)
STEPS = {32: 4000, 128: 2000, 512: 500, 1024: 250}
_IN_CONTACT, _IN_FLIGHT = 1e-6, 1e-4  # s, the steps of the built-in cases


def step_cost(elements: int, flight: bool) -> float:
    """Processor seconds of one step."""
    kind, step = (FLYING, _IN_FLIGHT) if flight else (TOUCHING, _IN_CONTACT)
    mesh = f"discretization.elements={elements}", f"end_time={STEPS[elements] * step}"
    run = Run(problem_of(*NODAL, *kind, *mesh))
    start = time.process_time()
    record = run.execute()
    return (time.process_time() - start) / record.steps


def step_costs(turns: int) -> dict[tuple[int, bool], list[float]]:
    """Return the costs (s) of steps over turns by number of elements, and whether in flight."""
    found: dict[tuple[int, bool], list[float]] = {}
    for turn in range(turns + 1):
        for elements in STEPS:
            for flight in (False, True):
                found.setdefault((elements, flight), [])
                found[elements, flight] += [step_cost(elements, flight)] if turn else []
    return found


def step_ratios(costs: dict[tuple[int, bool], list[float]]) -> dict[str, float]:
    """Return the medians over turns of the ratios that are asked for."""

    def ratio(a: tuple[int, bool], b: tuple[int, bool]) -> float:
        return statistics.median(x / y for x, y in zip(costs[a], costs[b], strict=True))

    return {
        "flight over contact, 128 elements": ratio((128, True), (128, False)),
        "flight over contact, 1,024 elements": ratio((1024, True), (1024, False)),
        "1,024 over 128 elements, contact": ratio((1024, False), (128, False)),
        "1,024 over 128 elements, flight": ratio((1024, True), (128, True)),
    }


def step_table(turns: int) -> Table:
    """Microseconds per step, and memory of a state and its work arrays, over the number of elements."""
    table = Table(title="Nodal model, generalized-alpha: processor time of a step (us)")
    for heading in ("elements", "in contact", "in flight", "work arrays (kB)"):
        table.add_column(heading, justify="right")
    costs = step_costs(turns)
    for elements in STEPS:
        problem = problem_of(*NODAL, f"discretization.elements={elements}")
        work, bands = problem.system.new_workspace(), problem.system.bands
        memory = sum(array.nbytes for array in (*work[:-1], *work.vectors, bands))
        cells = (f"{1e6 * statistics.median(costs[elements, flight]):.2f}" for flight in (False, True))
        table.add_row(str(elements), *cells, f"{memory / 1e3:.0f}")
    table.caption = ", ".join(f"{name} {ratio:.2f}" for name, ratio in step_ratios(costs).items())
    return table


@kernel("the right-hand side")
def _rates(system: Any, phase: Phase, t: float, y: Any, work: Workspace, dy: Any) -> float:
    return derivative(system, phase, t, y, work, dy)[1].gap


class RightHandSide:
    """The compiled right-hand side as SciPy takes it: one phase, because a spring's force ends by itself."""

    def __init__(self, problem: Problem) -> None:
        self._system, self.size = problem.system, problem.q0.size
        self._work = problem.system.new_workspace()
        start = np.concatenate([problem.q0, problem.qd0])
        probe = Probe(problem, problem.machine.free(), 0.0, start, self._work)
        self._phase = problem.machine.closed(probe.instant)._replace(residual=probe.residual)
        self._dy = np.zeros(2 * self.size + QUADRATURES)

    def __call__(self, t: float, y: Any) -> Any:  # noqa: D102
        _rates(self._system, self._phase, t, y, self._work, self._dy)
        return self._dy.copy()

    def gap(self, t: float, y: Any) -> float:
        """Event function."""
        return float(_rates(self._system, self._phase, t, y, self._work, self._dy))


def solve(method: str, tolerance: float, *overrides: str) -> Timing:
    """Run SciPy's solver over the same second, with the gap as its event."""
    problem = problem_of(*overrides)
    f = RightHandSide(problem)
    y = np.concatenate([problem.q0, problem.qd0, np.zeros(QUADRATURES)])
    f(0.0, y)
    start = time.perf_counter()
    solution = solve_ivp(
        f, (0.0, problem.end_time), y, method=method, rtol=tolerance, atol=tolerance, events=f.gap, max_step=1e-3
    )
    seconds = time.perf_counter() - start
    impulse = solution.y_events[0][1][2 * f.size] if len(solution.y_events[0]) > 1 else float("nan")
    return Timing(seconds, solution.t.size - 1, float(impulse))


def against_scipy(runs: int) -> Table:
    """Event-located and implicit schemes against DOP853 and Radau on the same right-hand sides."""
    table = Table(title="Against scipy.integrate.solve_ivp on the same right-hand side (asked: ratio 10)")
    for heading in ("model", "solver", "seconds", "steps", "error of the first impulse", "ratio"):
        table.add_column(heading, justify="left" if heading in ("model", "solver") else "right")
    modal = ("discretization.modes=6",)
    nodal = (*NODAL, "discretization.elements=8", "solver.rho_infinity=0.9")
    # errors alike: the event scheme holds its tolerance, DOP853 loses a digit to the length of the run
    exact = march(1, *modal, "solver.tolerance=1e-12", "end_time=0.321").impulse
    fine = ("solver.free_step=4e-6", "solver.contact_step=5e-7", "end_time=0.321", "solver.rho_infinity=1.0")
    limit = march(1, *nodal, *fine).impulse
    steps = ("solver.free_step=1e-4", "solver.contact_step=2e-5", "solver.tolerance=1e-5")
    for model, ours, name, reference, theirs in (
        (
            modal,
            march(runs, *modal, "solver.tolerance=3e-7"),
            "event, 3e-7",
            exact,
            (("DOP853", 1e-8), ("Radau", 1e-6)),
        ),
        (nodal, march(runs, *nodal, *steps), "generalized-alpha", limit, (("DOP853", 1e-4),)),
    ):
        label = "6 modes" if model is modal else "8 elements, nodal"
        add(table, label, name, ours, ours.impulse / reference - 1.0, "")
        for method, tolerance in theirs:
            other = solve(method, tolerance, *model)
            ratio = f"{other.seconds / ours.seconds:.0f}"
            add(table, label, f"{method}, {tolerance:g}", other, other.impulse / reference - 1.0, ratio)
    return table


def add(table: Table, first: str, second: str, timing: Timing, error: float, ratio: str) -> None:
    """Append a row."""
    table.add_row(first, second, f"{timing.seconds:.4f}", str(timing.steps), f"{error:+.1e}", ratio)


def main(runs: int = 7) -> None:
    """Measure and print."""
    console = Console(width=130)
    console.print(step_table(runs))
    console.print(against_scipy(runs))


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
