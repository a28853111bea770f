"""What each use costs, as ratios over something that does the least: the table of docs/speed.md.

    python benchmarks/bench.py [TURNS]      some minutes; keeps docs/speed.csv

Both sides of a ratio take turns, and processor time is what counts, so that a machine with other work to do
disturbs both alike; what is given is the median of the turns' ratios.  Films are measured by `films.py`, work over
precision by `work_precision.py`.
"""

from __future__ import annotations

import csv
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from rich.console import Console
from rich.table import Table

from oblique_impact.machine import THREADS

os.environ.update(dict.fromkeys(THREADS, "1"))  # before anything loads NumPy

sys.path.insert(0, str(Path(__file__).parent))
import nodal
import sweep
import work_precision

from oblique_impact import Scenario
from oblique_impact.marching.loop import Run
from oblique_impact.problem import beam_of, beam_problem
from oblique_impact.scenario.scenario import builtin_names

STORE = Path(__file__).parents[1] / "docs" / "speed.csv"
IMPORTS = "import numpy, scipy.linalg, numba, xarray, h5netcdf"
SIXTEEN = ("discretization.frame=mean-axis", "discretization.modes=16")
FIRST_RUNS = 1  # it is long, and one is enough to tell 15 from 34


class Row(NamedTuple):
    """A ratio: what it is of, what was measured, what was asked for."""

    what: str
    ratio: float
    asked: str


def processor(arguments: list[str], **environment: str) -> float:
    """Processor seconds of a whole process and of those that it starts."""

    def used() -> float:
        children = resource.getrusage(resource.RUSAGE_CHILDREN)
        return children.ru_utime + children.ru_stime

    before, variables = used(), {**os.environ, **environment}
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True, env=variables)
    return used() - before


def over(turns: int, one: Callable[[], float], other: Callable[[], float]) -> float:
    """Return the median of the ratios of two costs that take turns."""
    return statistics.median(one() / other() for _ in range(turns))


def imports() -> float:
    """Processor seconds of the libraries alone."""
    return processor(["-c", IMPORTS])


def start_up(turns: int) -> Iterator[Row]:
    """Yield runs from the command line over the imports of their libraries."""
    with tempfile.TemporaryDirectory() as folder:

        def run(name: str, **environment: str) -> float:
            return processor(["-m", "oblique_impact", "run", name, "--out", f"{folder}/{name}"], **environment)

        for name in builtin_names():
            run(name)  # compiles what is missing
            yield Row(
                f"warm run of `{name}` over imports", over(turns, lambda name=name: run(name), imports), "1.8"
            )
        fresh = iter(f"{folder}/cache{k}" for k in range(FIRST_RUNS))
        first = over(FIRST_RUNS, lambda: run("paper", NUMBA_CACHE_DIR=next(fresh)), imports)
        yield Row("first run of `paper` over imports", first, "15")


def many_modes(turns: int) -> Iterator[Row]:
    """Yield the march of sixteen mean-axis modes over the imports."""

    def march() -> float:
        run = Run(beam_problem(beam_of(Scenario.builtin("paper", SIXTEEN))))
        started = time.process_time()
        run.execute()
        return time.process_time() - started

    march()
    yield Row("marching 1 s with 16 mean-axis modes over imports", over(turns, march, imports), "1.1")


def nodal_steps(turns: int) -> Iterator[Row]:
    """Yield the costs of steps of the nodal model over each other."""
    for name, ratio in nodal.step_ratios(nodal.step_costs(turns)).items():
        yield Row(f"nodal step, {name}", ratio, "1.5" if name.startswith("flight") else "9")


def sweeps(turns: int) -> Iterator[Row]:
    """Yield the processor time of a sweep over that of marching its runs."""
    yield Row("sweep of 1,000 runs over their marching", sweep.cost(1000)["processor"], f"{sweep.ASKED}")


def others(turns: int) -> Iterator[Row]:
    """Yield how much longer other solvers take; Exudyn's cheapest configuration whatever its error."""
    points = work_precision.measure(turns)
    work_precision.keep(points)
    yield from _against(points)


def _against(points: list[work_precision.Point]) -> Iterator[Row]:
    for largest in (1e-3, 1e-4, 1e-5):
        for solver, ratio in work_precision.ratios(points, largest).items():
            yield Row(f"{solver} over oblique-impact, error {largest:g}", ratio, "at least 10")
    own = min(p.seconds for p in points if p.solver == "oblique-impact" and p.error <= 1e-4)
    for point in points:
        if point.label == work_precision.label_of(work_precision.exudyn_beam.LUCKY):
            row = f"{point.solver}, over oblique-impact with an error of 1e-4"
            yield Row(row, point.seconds / own, "at least 10")


GROUPS = (start_up, many_modes, nodal_steps, sweeps, others)


def main(turns: int = 5) -> None:
    """Measure, keep and print."""
    rows = []
    for group in GROUPS:
        for row in group(turns):
            rows.append(row)
            print(f"{row.what}: {row.ratio:.3g}", flush=True)
    with STORE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("cost", "ratio", "asked"))
        writer.writerows((row.what, f"{row.ratio:.3g}", row.asked) for row in rows)
    table = Table(title="Ratios, medians")
    for heading in ("cost", "ratio", "asked"):
        table.add_column(heading, justify="left" if heading == "cost" else "right")
    for row in rows:
        table.add_row(row.what, f"{row.ratio:.3g}", row.asked)
    Console(width=110).print(table)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
