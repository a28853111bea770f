"""What a sweep costs: overhead over plain runs of some 50 ms, and the gain of a second process.

Everything is measured in turns, so that a machine with other work to do disturbs all alike.
Warm processes only: starting them (some 2 s of imports, once) is a line of its own.
"""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from collections.abc import Callable, Sequence

# like the processes of a sweep: one thread each, for a fair comparison
os.environ.update({"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"})

from oblique_impact import simulate
from validation.sweeps.plan import changed, make_plan
from validation.sweeps.pool import LocalPool
from validation.sweeps.store import open_store
from validation.sweeps.work import Done, make_job

RUNS, ROUNDS = 100, 7
SWEEP = f"""
quantities = ["theta@end", "energy_final"]
changes.end_time = 0.15
[[axes]]
key = "initial.angle"
range = [0.75, 0.85]
count = {RUNS}
"""


def seconds(function: Callable[[], object]) -> float:
    """Wall time of a call."""
    started = time.perf_counter()
    function()
    return time.perf_counter() - started


def main() -> None:
    """Print the table."""
    plan = make_plan(SWEEP)
    job, numbers = make_job(plan), range(RUNS)
    scenarios = [changed(plan.base, plan.changes, plan.design.keys, plan.design.values(n)) for n in numbers]

    def plain() -> None:
        for scenario in scenarios:
            simulate(scenario)

    inside: list[float] = []

    def sweep(pool: LocalPool) -> Callable[[], None]:
        def call() -> None:
            with tempfile.TemporaryDirectory() as folder, open_store(folder, plan) as store:

                def take(finished: Sequence[Done]) -> None:
                    store.add(finished)
                    inside.extend(row["wall_time"] for row, _ in finished)

                inside.clear()
                pool.run(numbers, take, store.scratch)

        return call

    start = time.perf_counter()
    pools = [LocalPool(job, plan.design, workers) for workers in (1, 2)]
    cases = {"plain runs": plain, "1 process": sweep(pools[0]), "2 processes": sweep(pools[1])}
    for case in cases.values():
        case()
    print(f"start and first round: {time.perf_counter() - start:.1f} s")
    times: dict[str, list[float]] = {name: [] for name in cases}
    outside = []
    for _ in range(ROUNDS):
        for name, case in cases.items():
            times[name].append(seconds(case))
            if name == "1 process":
                outside.append(100.0 * (times[name][-1] / sum(inside) - 1.0))
    for pool in pools:
        pool.close()
    for name, values in times.items():
        each = [1e3 * value / RUNS for value in values]
        print(f"{name:12} {statistics.median(each):7.2f} ms a run ({min(each):.2f} to {max(each):.2f})")
    overhead = [one / alone for one, alone in zip(times["1 process"], times["plain runs"], strict=True)]
    gain = [one / two for one, two in zip(times["1 process"], times["2 processes"], strict=True)]
    percents = [100.0 * (ratio - 1.0) for ratio in overhead]
    print(f"outside of the runs {statistics.median(outside):.2f} % ({min(outside):.2f} to {max(outside):.2f})")
    print(f"over plain runs {statistics.median(percents):.2f} % ({min(percents):.2f} to {max(percents):.2f})")
    print(f"gain of a second process {statistics.median(gain):.2f} ({min(gain):.2f} to {max(gain):.2f})")


if __name__ == "__main__":
    main()
