"""Frequencies of a spinning beam.

A beam clamped to a turning root, by 8 assumed modes: rotation stiffens it, out of the plane of rotation more
than in it.
"""

from __future__ import annotations

import sys
from pathlib import Path

from oblique_impact import Scenario
from oblique_impact.plugins import discretization
from renders.campbell import campbell_diagram


def main(folder: str = "out/examples") -> list[Path]:
    """Draw the Campbell diagram of the spin-up beam; returns the picture."""
    scenario = Scenario.builtin("spin-up")
    beam = discretization(scenario.discretization.method).spectrum(scenario)
    for rate in (0.0, 6.0):
        print(f"first chordwise frequency at {rate:.0f} rad/s: {beam.chordwise(rate, 1)[0]:.6f} rad/s")
    return [campbell_diagram(beam, [0.0, 6.0], 3, Path(folder) / "campbell.png")]


if __name__ == "__main__":
    main(*sys.argv[1:2])
