"""Costs of the program as ratios: the table of docs/speed.md.

    python benchmarks/bench.py [TURNS]      some minutes; keeps docs/speed.csv

Both sides of a ratio take turns, and processor time is what counts, so that other work on the machine affects both
alike; the median of the turns' ratios is kept.  Films are measured by `films.py`, work over precision by
`work_precision.py`.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from oblique_impact.machine import THREADS

os.environ.update(dict.fromkeys(THREADS, "1"))  # before anything loads NumPy

import many_contacts
import nodal
import sweep
import work_precision
from measuring import call_cost, median_ratio, print_table, process_cost, write_csv

from oblique_impact import Scenario
from oblique_impact.beam_problem import beam_of, beam_problem
from oblique_impact.marching.loop import Run
from oblique_impact.scenario.scenario import builtin_names

STORE = Path(__file__).parents[1] / "docs" / "speed.csv"
IMPORTS = "import numpy, scipy.linalg, numba, xarray, h5netcdf"
SIXTEEN = ("discretization.frame=mean-axis", "discretization.modes=16")

#: what the ratio is of, the ratio, the aim
Row = tuple[str, float, str]


def imports() -> float:
    """Return the processor seconds of the libraries' imports."""
    return process_cost(["-c", IMPORTS])


def start_up(turns: int) -> Iterator[Row]:
    """Yield runs from the command line over the imports of their libraries."""
    with tempfile.TemporaryDirectory() as folder:

        def run(name: str, **environment: str) -> float:
            return process_cost(["-m", "oblique_impact", "run", name, "--out", f"{folder}/{name}"], **environment)

        for name in builtin_names():
            run(name)  # compiles what is missing
            ratio = median_ratio(turns, lambda name=name: run(name), imports)
            yield f"warm run of `{name}` over imports", ratio, "2.5"
        # one turn is enough for a ratio that large
        first = median_ratio(1, lambda: run("paper", NUMBA_CACHE_DIR=f"{folder}/cache"), imports)
        yield "first run of `paper` over imports", first, "15"


def many_modes(turns: int) -> Iterator[Row]:
    """Yield the marching of sixteen mean-axis modes over the imports."""

    def march() -> float:
        return call_cost(Run(beam_problem(beam_of(Scenario.builtin("paper", SIXTEEN)))).execute)[0]

    march()
    yield "marching 1 s with 16 mean-axis modes over imports", median_ratio(turns, march, imports), "1.1"


def nodal_steps(turns: int) -> Iterator[Row]:
    """Yield the costs of steps of the nodal model over each other."""
    for name, ratio in nodal.step_ratios(nodal.step_costs(turns)).items():
        yield f"nodal step, {name}", ratio, "1.5" if name.startswith("flight") else "9"


def time_stepping(turns: int) -> Iterator[Row]:
    """Yield the marching of `slap` over the imports, and costs of steps with many contacts over each other."""
    many_contacts.slap()
    yield "marching `slap` over imports", median_ratio(turns, many_contacts.slap, imports), "2"
    for (name, ratio), aim in zip(many_contacts.ratios(turns).items(), ("3", "10"), strict=True):
        yield f"time-stepping, {name}", ratio, aim


def sweeps(turns: int) -> Iterator[Row]:
    """Yield the time of a sweep over that of its runs."""
    yield "sweep of 1,000 runs over its runs", sweep.cost(1000)["wall"], f"{sweep.ASKED}"


def others(turns: int) -> Iterator[Row]:
    """Yield how much longer other solvers take to errors of 1e-3, 1e-4 and 1e-5."""
    points = work_precision.measure(turns)
    work_precision.keep(points)
    for largest in (1e-3, 1e-4, 1e-5):
        for solver, ratio in work_precision.ratios(points, largest).items():
            yield f"{solver} over oblique-impact, error {largest:g}", ratio, "at least 10"


def main(turns: int = 5) -> None:
    """Measure, keep and print."""
    rows = []
    for group in (start_up, many_modes, nodal_steps, time_stepping, sweeps, others):
        for what, ratio, aim in group(turns):
            rows.append((what, f"{ratio:.3g}", aim))
            print(f"{what}: {ratio:.3g}", flush=True)
    write_csv(STORE, ("cost", "ratio", "aim"), rows)
    print_table("Ratios, medians", ("cost", "ratio", "aim"), rows)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:2]))
