"""What a sweep costs: the paper's second with coarse output over friction and slope, on two processes.

    python benchmarks/sweep.py [RUNS]

The wall time of the whole sweep, times the processes, over the time that its runs take by themselves: what handing
out, measuring, keeping and reporting cost.  A first, short sweep starts the processes and loads the kernels.
"""

from __future__ import annotations

import sys
import tempfile

from oblique_impact.validation import sweep
from oblique_impact.validation.studies.design import make_plan

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


def cost(runs: int, workers: int = WORKERS) -> dict[str, float]:
    """Return the median wall time (s) of a run, and the ratio of the sweep's to that of all runs."""
    slopes = max(2, round(runs**0.5))
    plans = [
        make_plan(_SWEEP.format(frictions=-(-count // slopes), slopes=slopes)) for count in (4 * slopes, runs)
    ]
    with tempfile.TemporaryDirectory() as folder:
        for number, plan in enumerate(plans):
            result = sweep(plan, f"{folder}/{number}", workers=workers)
    assert set(result.verdicts) == {"completed"}, result.verdicts
    times = result.frame["wall_time"]
    return {"run": times.median(), "wall": result.seconds * workers / times.sum()}


def main(runs: int = 1000) -> None:
    """Print the figures."""
    found = cost(runs)
    print(f"{runs} runs on {WORKERS} processes, {1e3 * found['run']:.1f} ms each")
    print(f"wall time x processes over that of the runs  {found['wall']:.3f} (asked: {ASKED})")


if __name__ == "__main__":
    main(*(int(argument) for argument in sys.argv[1:2]))
