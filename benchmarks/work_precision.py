"""Work over precision on the elastic stop: this suite, and SciPy's solve_ivp on the same equations.

    python benchmarks/work_precision.py [TURNS]     measures (some minutes), keeps docs/speed-precision.json, draws

The motion is 1 s of the paper's beam on a stop of 1e6 N/m, without friction: two macro-collisions.  Times are
processor seconds of marching, without imports, set-up and compiling; all solvers take turns, and medians are kept,
because the speed of a shared machine varies.
"""

from __future__ import annotations

import json
import os
import statistics
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from oblique_impact.machine import THREADS

# like the program: one thread, before anything loads NumPy
os.environ.update(dict.fromkeys(THREADS, "1"))

import numpy as np
from matplotlib.figure import Figure
from measuring import call_cost
from scipy.integrate import solve_ivp

from oblique_impact import Scenario
from oblique_impact.beam_problem import Problem, beam_of, beam_problem
from oblique_impact.contact.state import Contacts
from oblique_impact.kernels.jit import by_reference, kernel
from oblique_impact.kernels.workspace import Workspace
from oblique_impact.marching.equations import NORMAL_IMPULSE, OF_A_CONTACT, QUADRATURES, derivative
from oblique_impact.marching.loop import Run
from oblique_impact.marching.probe import Probe
from oblique_impact.renders.style import PAGE, figure_style

DOCS = Path(__file__).parents[1] / "docs"
STORE, PICTURE = DOCS / "speed-precision.json", DOCS / "speed-precision.svg"
CASE = (
    "contact.normal=spring",
    "contact.friction=frictionless",
    "contact.residual_flexibility=true",
    "discretization.frame=mean-axis",
    "solver.output_interval=0.05",
)
#: rad; of the beam as it touches, where the flexibility of the contact point is taken
TOUCH_ANGLE = 0.2213
BETWEEN = 0.5  # s; between the two macro-collisions
_SHORT = 3  # times that a short march is measured in a turn


class Limit(NamedTuple):
    """Converged values of a model: impulse (N s) of the first macro-collision, beginning (s) of the second."""

    impulse: float
    second: float


#: 24 and 32 modes with their residual flexibility at a tolerance of 1e-10, which agree to 1e-7
OURS = Limit(2.140199, 0.8653262)


class Point(NamedTuple):
    """What a solver reaches, and in how many processor seconds."""

    solver: str
    label: str
    error: float
    seconds: float


def error(found: Limit, limit: Limit) -> float:
    """Return the larger relative error of the impulse of the first macro-collision and the start of the second."""
    return max(abs(found.impulse / limit.impulse - 1.0), abs(found.second / limit.second - 1.0))


def problem_of(modes: int, tolerance: float) -> Problem:
    """Return the case with some modes."""
    changes = f"discretization.modes={modes}", f"solver.tolerance={tolerance}"
    return beam_problem(beam_of(Scenario.builtin("paper", [*CASE, *changes])))


def timed(turns: int, march: Callable[[], Any]) -> tuple[float, Any]:
    """Return the median of processor seconds over turns, after one that is not counted, and what comes out."""
    march()
    found = [call_cost(march) for _ in range(turns)]
    return statistics.median(seconds for seconds, _ in found), found[-1][1]


def ours(turns: int, modes: int, tolerance: float) -> Point:
    """Located events."""
    problem = problem_of(modes, tolerance)
    runs = iter([Run(problem) for _ in range(turns + 1)])
    seconds, record = timed(turns, lambda: next(runs).execute())
    first = sum(contact.normal_impulse for contact in record.contacts if contact.start < BETWEEN)
    second = next(contact.start for contact in record.contacts if contact.start > BETWEEN)
    return Point("oblique-impact", f"{modes} modes", error(Limit(first, second), OURS), seconds)


@kernel("the right-hand side")
def _rates(system: Any, contacts: Contacts, t: float, y: Any, work: Workspace, dy: Any) -> float:
    derivative(by_reference(system), by_reference(contacts), t, y, by_reference(work), dy)
    return contacts.each[0].gap


class RightHandSide:
    """The compiled right-hand side as SciPy takes it: one phase, because a spring's force ends by itself."""

    def __init__(self, problem: Problem) -> None:
        self._system, self.size = problem.system, problem.q0.size
        self._work = problem.system.new_workspace()
        start, free = np.concatenate([problem.q0, problem.qd0]), [problem.decision.free(0)]
        self._contacts, spare = (Contacts.new(free, self.size, packed=True) for _ in range(2))
        probe = Probe(problem, self._contacts, spare, 0.0, start, self._work)
        self._contacts.take(0, problem.decision.pressed(0, probe))
        self._dy = np.zeros(2 * self.size + QUADRATURES + OF_A_CONTACT)

    def __call__(self, t: float, y: Any) -> Any:  # noqa: D102
        _rates(self._system, self._contacts, t, y, self._work, self._dy)
        return self._dy.copy()

    def gap(self, t: float, y: Any) -> float:
        """Event function."""
        return float(_rates(self._system, self._contacts, t, y, self._work, self._dy))


def scipy(method: str, modes: int, tolerance: float) -> Point:
    """SciPy's solver on the same compiled right-hand side."""
    problem = problem_of(modes, 1e-10)
    at_touch = np.concatenate([[TOUCH_ANGLE], problem.q0[1:]])
    f = RightHandSide(replace(problem, q0=at_touch))
    start = np.concatenate([problem.q0, problem.qd0, np.zeros(QUADRATURES + OF_A_CONTACT)])

    f.gap(0.0, start)  # compiles
    options = {"rtol": tolerance, "atol": tolerance, "events": f.gap, "max_step": 1e-3}
    seconds, solution = call_cost(lambda: solve_ivp(f, (0.0, problem.end_time), start, method=method, **options))
    times, states = solution.t_events[0], solution.y_events[0]
    last = np.flatnonzero(times < BETWEEN)[-1]
    found = Limit(float(states[last][2 * f.size + QUADRATURES + NORMAL_IMPULSE]), float(times[last + 1]))
    return Point(f"solve_ivp, {method}", f"{modes} modes, {tolerance:g}", error(found, OURS), seconds)


def measure(turns: int) -> list[Point]:
    """Measure all in each turn, and say so as it comes."""
    found: dict[tuple[str, str], list[Point]] = {}
    for _ in range(turns):
        for point in _each():
            print(f"{point.solver:32} {point.label:34} {point.error:8.1e} {point.seconds:8.4f} s", flush=True)
            found.setdefault((point.solver, point.label), []).append(point)
    return [of[0]._replace(seconds=statistics.median(point.seconds for point in of)) for of in found.values()]


def _each() -> Iterator[Point]:
    for modes in (4, 6, 7, 8, 9, 10, 12):
        yield ours(_SHORT, modes, 1e-2)
    for modes in (16, 20):
        yield ours(_SHORT, modes, 1e-6)
    for modes, tolerance in ((9, 1e-5), (9, 1e-7), (10, 1e-7)):
        yield scipy("DOP853", modes, tolerance)


def ratios(points: list[Point], largest: float) -> dict[str, float]:
    """Return how much longer each other solver takes than this suite to an error of at most `largest`."""
    cheapest: dict[str, float] = {}
    for point in points:
        if point.error <= largest:
            cheapest[point.solver] = min(point.seconds, cheapest.get(point.solver, np.inf))
    own = cheapest.pop("oblique-impact")
    return {solver: seconds / own for solver, seconds in cheapest.items()}


def draw(points: list[Point]) -> None:
    """Draw processor seconds over the error."""
    with figure_style(PAGE):
        figure = Figure(figsize=(6.4, 4.0), layout="constrained")
        axes = figure.subplots()
        names = list(dict.fromkeys(point.solver for point in points))
        for index, name in enumerate(names):
            rows = sorted(((p.error, p.seconds) for p in points if p.solver == name), reverse=True)
            style = {"color": PAGE.series[index], "marker": "osD^vPX"[index], "label": name, "markersize": 5.0}
            axes.loglog(*zip(*rows, strict=True), linestyle="-" if index == 0 else "", linewidth=1.1, **style)
        for asked in (1e-3, 1e-4, 1e-5):
            axes.axvline(asked, color=PAGE.dim, linewidth=0.6, linestyle=":")
        axes.invert_xaxis()
        axes.set(xlabel="relative error (1)", ylabel="processor time of marching 1 s (s)")
        axes.legend(fontsize="small")
        figure.savefig(PICTURE, metadata={"Date": None})


def keep(points: list[Point]) -> None:
    """Write the numbers and the picture."""
    kept = [p._replace(error=float(f"{p.error:.3g}"), seconds=float(f"{p.seconds:.3g}"))._asdict() for p in points]
    STORE.write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    draw(points)


def main(turns: int = 5) -> None:
    """Measure, keep, draw, print."""
    points = measure(turns)
    keep(points)
    for largest in (1e-3, 1e-4, 1e-5):
        shown = ", ".join(f"{name} {ratio:.1f}" for name, ratio in ratios(points, largest).items())
        print(f"error at most {largest:g}, times as long as oblique-impact: {shown}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
