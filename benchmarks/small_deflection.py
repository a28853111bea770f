"""Where the small-deflection model ends: numbers and picture of docs/theory/absolute.md and the README.

    python benchmarks/small_deflection.py               computed if docs/small-deflection.json lacks, then drawn
    python benchmarks/small_deflection.py --random      docs/small-deflection-random.json, some ten minutes

The first holds the same numbers as oblique-impact refine --study small-deflection.  The second are random roots,
hubs, loads and spins: the estimate of `oblique_impact.beam.small_deflection` was fitted to such with other seeds,
and this one says how often it warns where the exact beam differs by a tenth.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.beam.small_deflection import (
    NOTICEABLE,
    Motion,
    contact_force_error,
    deflection_error,
    largest_motion,
)
from oblique_impact.history.history import History
from oblique_impact.problem import beam_of
from oblique_impact.renders.style import figure_style
from oblique_impact.validation.studies.parallel import map_parallel
from oblique_impact.validation.studies.small_deflection import SIZE, Case, draw_map, small_deflection

DOCS = Path(__file__).parents[1] / "docs"
STORE, RANDOM = DOCS / "small-deflection.json", DOCS / "small-deflection-random.json"
CASES, SEED = 80, 20261125
#: modes, and fewer of them: what differs between the two is left out
_MODES, _FEWER = (6, 4), (4, 3)


def random_case(rng: np.random.Generator) -> Case:
    """Draw a root, a hub of a thousandth to thirty times the beam's inertia, a load, a spin."""
    root = str(rng.choice(["pin", "hub", "hub", "driven"]))
    loads = {"pin": ["gravity"], "hub": ["gravity", "torque"], "driven": ["gravity", "stop"]}[root]
    load, hub = str(rng.choice(loads)), float(10.0 ** rng.uniform(-3.0, 1.5)) if root == "hub" else 0.0
    still = Case(root, load, 0.1, hub=hub)
    spin = rng.choice([0.0, 1.0]) * rng.uniform(-0.9, 0.9) * 2.0 * math.pi / still.period
    return Case(
        root,
        load,
        nominal=float(10.0 ** rng.uniform(-1.7, -0.3)),
        spin=0.0 if load == "stop" else float(spin),
        hub=hub,
        angle=0.0 if load == "stop" else float(rng.uniform(-1.2, 1.2)),
        stiffness=float(10.0 ** rng.uniform(1.0, 2.5)),
    )


def rows_of(case: Case) -> list[dict[str, Any]]:
    """Return what each model of a case reports of itself, and its error against the exact beam."""
    rows = []
    for frame in ("tangent",) if case.root == "driven" else ("tangent", "mean-axis"):
        reference = simulate(case.exact(frame))
        for kinetics in ("first-order", "full"):
            counts = _FEWER if (case.root, frame, kinetics) == ("pin", "tangent", "first-order") else _MODES
            changes = {"discretization__frame": frame, "discretization__kinetics": kinetics}
            runs = [simulate(case.scenario.replace(**changes, discretization__modes=n)) for n in counts]
            if not all(run.outcome.label == "completed" for run in (reference, *runs)):
                continue
            if case.load == "stop" and not all(run.contacts for run in (reference, *runs)):
                continue
            error, fewer = (error_of(case, reference, run) for run in runs)
            beam = beam_of(case.scenario.replace(**changes, discretization__modes=counts[0]))
            variables = {name: runs[0][name].values for name in ("uy", "theta_dot", "q", "qd")}
            motion = largest_motion(beam, variables)
            row = {
                **asdict(case),
                "frame": frame,
                "kinetics": kinetics,
                "deflection": motion.deflection,
                "rate": motion.spin,
                "lost_momentum": motion.lost_momentum,
                "error": error,
                "error_of_fewer_modes": fewer,
            }
            rows.append(row)
    return rows


def error_of(case: Case, reference: History, history: History) -> float:
    """Return the error of a model's run: of the tip's deflection, or on a stop of the largest force."""
    if case.load == "stop":
        exactly, force = (max(contact.peak_force for contact in run.contacts) for run in (reference, history))
        return float(abs(force / exactly - 1.0))
    times, tip = reference["time"].values, reference["deflection"].values
    found = np.interp(times, history["time"].values, history["deflection"].values)
    return float(np.abs(found - tip).max() / np.abs(tip).max())


def estimate(row: dict[str, Any]) -> float:
    """Return the estimate for a row: of the deflection, on a stop of the largest force."""
    case = Case(**{name: row[name] for name in Case.__dataclass_fields__})
    changes = {"discretization__frame": row["frame"], "discretization__kinetics": row["kinetics"]}
    scenario: Scenario = case.scenario.replace(**changes)
    if case.load == "stop":
        return contact_force_error(scenario, row["deflection"])
    return deflection_error(scenario, Motion(row["deflection"], row["rate"], row["lost_momentum"]))


def by_modes(row: dict[str, Any]) -> bool:
    """Whether modes that are left out decide the error of a row."""
    return bool(abs(row["error"] - row["error_of_fewer_modes"]) > 0.02 + 0.2 * row["error"])


def compute_random(cases: int, seed: int) -> None:
    """Run random cases, write their rows, print how often the warning is right."""
    rng = np.random.default_rng(seed)
    drawn = [random_case(rng) for _ in range(cases)]
    found = map_parallel(rows_of, drawn, None, lambda progress: print(progress.done, flush=True))
    rows = [row for of_case in found for row in of_case]
    RANDOM.write_text(json.dumps(rows, indent=1) + "\n")
    clear = [row for row in rows if not by_modes(row)]
    for spoken in (True, False):
        mine = [row["error"] for row in clear if (estimate(row) > NOTICEABLE) == spoken]
        off = sorted(error for error in mine if (error > NOTICEABLE) != spoken)
        print(
            f"{'warned' if spoken else 'silent'}: {len(mine)}, of these wrong {len(off)}, at errors of",
            np.round(off, 3),
        )


def compute_map() -> None:
    """Compute the map."""
    result = small_deflection(on_progress=lambda progress: print(progress.done, progress.last, flush=True))
    result.points.to_json(STORE, orient="records", indent=1, double_precision=15)


def main() -> None:
    """Compute what is missing, and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", action="store_true", help="random cases")
    parser.add_argument("--cases", type=int, default=CASES, help="how many of them")
    parser.add_argument("--seed", type=int, default=SEED, help="of the random numbers")
    words = parser.parse_args()
    if words.random:
        compute_random(words.cases, words.seed)
        return
    if not STORE.exists():
        compute_map()
    points = pd.read_json(STORE, orient="records", dtype=False)
    with figure_style():
        figure = Figure(figsize=SIZE, layout="constrained")
        draw_map(figure, points)
        figure.savefig(DOCS / "small-deflection.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
