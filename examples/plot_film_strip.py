"""A strip of the first macro-collision.

The beam before, during and after its first contacts, coloured by bending stress; the deflection is magnified by
the factor that is written in the last row.
"""

from __future__ import annotations

import sys
from pathlib import Path

from oblique_impact import Scenario, simulate
from renders.film import write_strip
from renders.frame import Style


def main(folder: str = "out/examples") -> list[Path]:
    """Draw the strip; returns the picture."""
    history = simulate(Scenario.builtin("paper", ["end_time=0.4"]))
    return [write_strip([history], ["paper"], Style(size=(1000, 200)), [], Path(folder) / "film_strip.png")]


if __name__ == "__main__":
    main(*sys.argv[1:2])
