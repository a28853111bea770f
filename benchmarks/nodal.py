"""The full nodal model: cost per step, memory, and whole runs against SciPy's solve_ivp and Exudyn.

    python benchmarks/nodal.py [RUNS]

Whole runs are 1 s of the paper's beam on an elastic stop of 1e6 N/m, without friction.  Their quantity is the
normal impulse of the first contact, its error taken against the converged value of the same model; only marching
is timed, with warm kernels.  Exudyn is optional (pip install exudyn); `exudyn_beam.py` says how it is set up.
"""

from __future__ import annotations

import importlib.util
import statistics
import sys
import time
from pathlib import Path
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


def step_costs(runs: int) -> Table:
    """Microseconds per step in contact, and memory of a state and its work arrays, over the number of elements."""
    table = Table(title="Nodal model, generalized-alpha: one step in contact")
    for heading in ("elements", "us per step", "asked", "cost, of 128 elements", "work arrays (kB)"):
        table.add_column(heading, justify="right")
    touching = ("slope.origin=[0.0, 0.0]", "slope.angle=0.0", "initial.angle=0.0", "contact.stiffness=1e4")
    asked = {32: "6", 128: "20"}
    base = 0.0
    for elements, steps in ((32, 20_000), (128, 10_000), (512, 3_000), (1024, 1_500)):
        mesh = f"discretization.elements={elements}"
        timing = march(runs, *NODAL, *touching, mesh, f"end_time={steps * 1e-6}", "solver.rho_infinity=0.0")
        cost = 1e6 * timing.seconds / timing.steps
        base = cost if elements == 128 else base
        problem = problem_of(*NODAL, mesh)
        memory = sum(array.nbytes for array in problem.system.new_workspace()) + problem.system.bands.nbytes
        growth = f"{cost / base:.2f}" if elements > 128 else ""
        table.add_row(str(elements), f"{cost:.2f}", asked.get(elements, ""), growth, f"{memory / 1e3:.0f}")
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
        self._phase = problem.machine.closed(Probe(self._system, 0.0, start, self._work).instant)
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


def against_exudyn(runs: int) -> Table | None:
    """Whole runs at an error of the first impulse of at most 1e-4 in both, if Exudyn is installed."""
    if importlib.util.find_spec("exudyn") is None:
        return None
    sys.path.insert(0, str(Path(__file__).parent))
    import exudyn_beam

    table = Table(title="Against Exudyn: 1 s, error of the first impulse at most 1e-4 (asked: ratio 10)")
    for heading in ("program", "configuration", "seconds", "steps", "error of the first impulse", "ratio"):
        table.add_column(heading, justify="left" if heading in ("program", "configuration") else "right")
    fine = ("solver.free_step=5e-6", "solver.contact_step=5e-7", "solver.rho_infinity=1.0", "end_time=0.321")
    limit = march(1, *NODAL, "discretization.elements=64", *fine).impulse
    chosen = ("discretization.elements=16", "solver.free_step=1e-4", "solver.contact_step=2e-5")
    ours = march(runs, *NODAL, *chosen, "solver.rho_infinity=0.8", "solver.tolerance=1e-4")
    add(table, "oblique-impact", "16 elements, 1e-4 / 2e-5 s", ours, ours.impulse / limit - 1.0, "")
    for configuration in exudyn_beam.CONFIGURATIONS:
        found = exudyn_beam.measure(configuration, runs)
        ratio = f"{found['marching'] / ours.seconds:.1f}"
        cells = f"{found['marching']:.4f}", "", f"{found['error']:+.1e}", ratio
        table.add_row("Exudyn", configuration.name, *cells)
    return table


def add(table: Table, first: str, second: str, timing: Timing, error: float, ratio: str) -> None:
    """Append a row."""
    table.add_row(first, second, f"{timing.seconds:.4f}", str(timing.steps), f"{error:+.1e}", ratio)


def main(runs: int = 7) -> None:
    """Measure and print."""
    console = Console(width=130)
    console.print(step_costs(runs))
    console.print(against_scipy(runs))
    table = against_exudyn(runs)
    console.print(table or "Exudyn is not installed: pip install exudyn")


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
