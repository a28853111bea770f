"""What a sweep costs: overhead over plain runs of some 50 ms, and the gain of a second process.

Everything is measured in turns, so that a machine with other work to do disturbs all alike.  What it takes to
start processes (some 2 s of imports, once) is left out: the clock starts with the first row.
"""

from __future__ import annotations

import os
import statistics
import tempfile
import time

# like the processes of a sweep: one thread each, for a fair comparison
os.environ.update({"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"})

from oblique_impact import simulate
from validation.measuring import measure_each
from validation.sweeps.plan import make_plan
from validation.sweeps.store import open_store

RUNS, ROUNDS = 100, 7
SWEEP = f"""
quantities = ["theta@end", "energy_final"]
changes.end_time = 0.15
[[axes]]
key = "initial.angle"
range = [0.75, 0.85]
count = {RUNS}
"""


def main() -> None:
    """Print the table."""
    plan = make_plan(SWEEP)
    tasks = [plan.task(run) for run in range(RUNS)]
    scenarios = [task.scenario() for task in tasks]

    def plain() -> float:
        started = time.perf_counter()
        for scenario in scenarios:
            simulate(scenario)
        return (time.perf_counter() - started) / RUNS

    def sweep(workers: int) -> float:
        with tempfile.TemporaryDirectory() as folder, open_store(folder, plan) as store:
            found = measure_each(tasks, workers, isolated=True)
            store.add(next(found))
            started = time.perf_counter()
            for done in found:
                store.add(done)
            return (time.perf_counter() - started) / (RUNS - 1)

    cases = {"plain runs": plain, "1 process": lambda: sweep(1), "2 processes": lambda: sweep(2)}
    times: dict[str, list[float]] = {name: [] for name in cases}
    for case in cases.values():
        case()
    for _ in range(ROUNDS):
        for name, case in cases.items():
            times[name].append(1e3 * case())
    for name, each in times.items():
        print(f"{name:12} {statistics.median(each):7.2f} ms a run ({min(each):.2f} to {max(each):.2f})")
    ratios = [100.0 * (a / b - 1.0) for a, b in zip(times["1 process"], times["plain runs"], strict=True)]
    print(f"over plain runs {statistics.median(ratios):.2f} % ({min(ratios):.2f} to {max(ratios):.2f})")
    gain = [one / two for one, two in zip(times["1 process"], times["2 processes"], strict=True)]
    print(f"gain of a second process {statistics.median(gain):.2f} ({min(gain):.2f} to {max(gain):.2f})")


if __name__ == "__main__":
    main()
