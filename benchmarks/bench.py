"""Speed of the main cases: medians over several runs, in one table.

    python benchmarks/bench.py [RUNS]

Marching and whole calls are timed in this process after imports and with warm kernel caches; start-up
and first compilation are timed as whole processes.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time

from rich.console import Console
from rich.table import Table

from oblique_impact import Scenario, simulate

CASES = (
    ("paper, 2 modes, event", [], 0.3),
    (
        "paper, 16 mean-axis modes, event",
        ["discretization.frame=mean-axis", "discretization.modes=16"],
        5.0,
    ),
    ("paper, 2 modes, fixed-step", ["solver.scheme=fixed-step"], 1.0),
    (
        "paper, 64 elements, 2 modes, event",
        ["discretization.method=fem", "discretization.elements=64"],
        None,
    ),
    ("paper, 2 modes, full kinetics", ["discretization.kinetics=full"], None),
)


def time_case(overrides: list[str], runs: int) -> tuple[float, float, float, float]:
    """Median, least and largest seconds of `simulate`, and the median of its marching."""
    scenario = Scenario.builtin("paper", overrides)
    simulate(scenario)  # loads the kernels
    walls, marches = [], []
    for _ in range(runs):
        start = time.perf_counter()
        history = simulate(scenario)
        walls.append(time.perf_counter() - start)
        marches.append(history.summary["wall_time"])
    return statistics.median(walls), min(walls), max(walls), statistics.median(marches)


def time_process(arguments: list[str], runs: int, **environment: str) -> tuple[float, float, float]:
    """Median, least and largest seconds of a whole process."""
    seconds = []
    for _ in range(runs):
        start = time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "oblique_impact", *arguments],
            check=True,
            capture_output=True,
            env={**os.environ, **environment},
        )
        seconds.append(time.perf_counter() - start)
    return statistics.median(seconds), min(seconds), max(seconds)


def main(runs: int = 7) -> None:
    """Measure and print."""
    table = Table(title=f"Seconds, {runs} runs each")
    for heading in ("case", "median", "min", "max", "of it marching", "asked"):
        table.add_column(heading, justify="left" if heading == "case" else "right")

    def row(name: str, timing: tuple[float, ...], asked: float | None) -> None:
        cells = [f"{value:.3f}" for value in timing] + [""] * (4 - len(timing))
        table.add_row(name, *cells, "" if asked is None else f"{asked:g}")

    for name, overrides, asked in CASES:
        row(name, time_case(overrides, runs), asked)
    row("oblique-impact --help (process)", time_process(["--help"], runs), 0.5)
    with tempfile.TemporaryDirectory() as folder:
        run = ["run", "paper", "--out", os.path.join(folder, "run")]
        row("oblique-impact run paper (process, warm)", time_process(run, 3), None)
        fresh = os.path.join(folder, "cache")
        row("first run, compilation included (process)", time_process(run, 1, NUMBA_CACHE_DIR=fresh), 30.0)
    Console(width=110).print(table)


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
