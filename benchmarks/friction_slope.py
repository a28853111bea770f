"""The paper's case over friction and slope: the 10,000 runs behind a map of the gallery.

    python benchmarks/friction_slope.py        some minutes on two cores

Numbers are kept in docs/friction-slope.json; examples/plot_friction_slope.py draws them.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

from oblique_impact.progress import Progress
from oblique_impact.validation import sweep
from oblique_impact.validation.studies.design import make_plan

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


def show(progress: Progress) -> None:
    """Print how far it is."""
    if progress.done % 500 == 0:
        print(f"{progress.done} of {progress.total} runs", flush=True)


def main() -> None:
    """Run, and keep the numbers; what an interrupted run has computed lies in out/friction-slope."""
    plan = make_plan(SWEEP)
    result = sweep(plan, "out/friction-slope", on_progress=show)
    names = [quantity.name for quantity in plan.quantities]
    kept = {name: [float(f"{value:.{DIGITS}g}") for value in result.frame[name]] for name in names}
    head = {"slope.angle": [0.0, STEEPEST], "contact.mu_kinetic": [0.0, ROUGHEST], "count": COUNT}
    STORE.write_text(json.dumps({**head, "outcomes": result.verdicts, **kept}) + "\n", encoding="utf-8")
    print(result.verdicts)


if __name__ == "__main__":
    main()
