"""The paper's case at a glance.

A beam falls from 45 degrees about its pin onto a slope of 18 degrees, slips, reverses its slip and bounces:
motion, shapes, contact force, gap, and where the energy goes.
"""

from __future__ import annotations

import sys
from pathlib import Path

from oblique_impact import Scenario, simulate
from renders.overview import overview_figure


def main(folder: str = "out/examples") -> list[Path]:
    """Run the case and draw it; returns the picture."""
    history = simulate(Scenario.builtin("paper"))
    for event in history.events[:8]:
        print(f"{event.time:.10f} s  {event.kind.value:8s}  then {event.state.name.lower()}")
    for collision in history.summary["macro_collisions"]:
        print(f"macro-collision from {collision['start']:.4f} s: {collision['normal_impulse']:.4f} N s")
    return [overview_figure({"paper": history}, Path(folder) / "paper_case.png")]


if __name__ == "__main__":
    main(*sys.argv[1:2])
