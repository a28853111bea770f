"""The paper's case over friction and slope: the 10,000 runs behind a map of the gallery.

    python benchmarks/friction_slope.py        some minutes on two cores

Numbers are kept in docs/friction-slope.json; examples/plot_friction_slope.py draws them.
"""

from __future__ import annotations

import json
import math
import time
from pathlib import Path

import numpy as np

from oblique_impact.validation.measuring import measure_each
from oblique_impact.validation.sweeps.plan import make_plan

STORE = Path(__file__).parents[1] / "docs" / "friction-slope.json"
COUNT, STEEPEST, ROUGHEST = 100, math.pi / 4, 1.0  # rad, 1
DIGITS = 5
SWEEP = f"""
quantities = ["lost_friction", "energy_final"]
changes.solver.output_interval = 0.01
changes.solver.tolerance = 1e-7
[[axes]]
key = "slope.angle"
range = [0.0, {STEEPEST}]
count = {COUNT}
[[axes]]
keys = ["contact.mu_static", "contact.mu_kinetic"]
range = [0.0, {ROUGHEST}]
count = {COUNT}
"""


def main() -> None:
    """Run, and keep the numbers."""
    plan, started = make_plan(SWEEP), time.perf_counter()
    runs = plan.design.size
    values = {quantity.name: np.full(runs, np.nan) for quantity in plan.quantities}
    outcomes: dict[str, int] = {}
    for count, done in enumerate(measure_each([plan.task(run) for run in range(runs)]), 1):
        row = done.row
        outcomes[row["outcome"]] = outcomes.get(row["outcome"], 0) + 1
        for name, value in row["values"].items():
            values[name][row["run"]] = value
        if count % 500 == 0 or count == runs:
            print(f"{count} runs, {time.perf_counter() - started:.0f} s", flush=True)
            _keep(values, outcomes)
    print(outcomes)


def _keep(values: dict[str, np.ndarray], outcomes: dict[str, int]) -> None:
    kept = {name: [float(f"{value:.{DIGITS}g}") for value in column] for name, column in values.items()}
    head = {"slope.angle": [0.0, STEEPEST], "contact.mu_kinetic": [0.0, ROUGHEST], "count": COUNT}
    STORE.write_text(json.dumps({**head, "outcomes": outcomes, **kept}) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
