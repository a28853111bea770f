"""What a sweep costs: the paper's second with coarse output over friction and slope, on two processes.

    python benchmarks/sweep.py [RUNS]

The cost is the processor time of all processes from the first row on, starting them (some 2 s of imports, once)
left out, over the time that the runs are marched; the wall time, times the processes, over the same says what the
machine gave besides, which is less on one that has other work to do.
"""

from __future__ import annotations

import os
import statistics
import sys
import tempfile
import time
from typing import Any, NamedTuple

from oblique_impact.machine import THREADS, collect_rarely

# like the program and the processes of a sweep: one thread each, for a fair comparison
os.environ.update(dict.fromkeys(THREADS, "1"))

from oblique_impact import simulation
from oblique_impact.validation.measuring import Done, Task, measure_run
from oblique_impact.validation.parallel import Crash, compute_each
from oblique_impact.validation.sweeps.plan import make_plan
from oblique_impact.validation.sweeps.store import open_store

WORKERS = 2
ASKED = 1.15
_SWEEP = """
quantities = ["impulse", "energy_final"]
changes.solver.output_interval = 0.01
[[axes]]
keys = ["contact.mu_static", "contact.mu_kinetic"]
range = [0.0, 0.6]
count = {frictions}
[[axes]]
key = "slope.angle"
range = [0.2, 0.4]
count = {slopes}
"""


class Timed(NamedTuple):
    """A finished run, the seconds (wall, processor) of its march, and its process with its processor time."""

    done: Done
    march: tuple[float, float]
    process: int
    processor: float


def timed(task: Task) -> Timed:
    """Run and measure one of a sweep, its march timed."""
    plain, seconds = simulation._march, (0.0, 0.0)

    def march(*arguments: Any) -> Any:
        nonlocal seconds
        wall, processor = time.perf_counter(), time.process_time()
        found = plain(*arguments)
        seconds = time.perf_counter() - wall, time.process_time() - processor
        return found

    simulation._march = march
    try:
        done = measure_run(task)
    finally:
        simulation._march = plain
    return Timed(done, seconds, os.getpid(), time.process_time())


def cost(runs: int, workers: int = WORKERS) -> dict[str, float]:
    """Return seconds of marching per run, and the ratios of processor and wall time to it."""
    slopes = max(1, round(runs**0.5))
    plan = make_plan(_SWEEP.format(frictions=-(-runs // slopes), slopes=slopes))
    tasks = [plan.task(run) for run in range(runs)]
    found: list[Timed] = []
    known: set[int] = set()
    with tempfile.TemporaryDirectory() as folder, open_store(folder, plan) as store:
        wall = processor = 0.0
        for _, each in compute_each(timed, tasks, workers, isolated=True):
            assert not isinstance(each, Crash), each
            assert each.done.row["outcome"] == "completed", each.done.row  # a run that is refused marches nothing
            if each.process not in known:
                wall, processor = time.perf_counter(), time.process_time()
                known.add(each.process)
                found.clear()  # until all processes are there
            found.append(each)
            store.add(each.done)
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
    runs_of = [[each for each in found if each.process == process] for process in known]
    # of each process what it has used since its first run was done
    processor += sum(own[-1].processor - own[0].processor for own in runs_of)
    counted = [each.march for own in runs_of for each in own[1:]]
    return {
        "march": statistics.median(seconds for _, seconds in counted),
        "processor": processor / sum(seconds for _, seconds in counted),
        "wall": wall * workers / sum(seconds for seconds, _ in counted),
    }


def main(runs: int = 1000) -> None:
    """Print the table."""
    collect_rarely()  # like the program
    found = cost(runs)
    print(f"{runs} runs on {WORKERS} processes, {1e3 * found['march']:.1f} ms of marching each (asked: {ASKED})")
    print(f"processor time of all processes over marching  {found['processor']:.3f}")
    print(f"wall time x processes over marching            {found['wall']:.3f}")


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
