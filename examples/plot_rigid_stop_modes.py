"""What a rigid stop does as modes are added.

The impulse of the first macro-collision settles near 1.87 N s. The largest contact force does not: it grows
with the number of modes, because the mass that takes part in an impact shrinks. Read the impulse off such a
model, not the force.
"""

from __future__ import annotations

import sys
from pathlib import Path

from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from renders.files import save_figure
from renders.style import GREY, SERIES, figure_style

MODES = (2, 4, 6, 8, 10, 12)


def main(folder: str = "out/examples") -> list[Path]:
    """Run the first macro-collision with more and more modes; returns the picture."""
    base = Scenario.builtin("paper", ["end_time=0.34", "contact.friction=frictionless"])
    impulses, forces = [], []
    for modes in MODES:
        history = simulate(base.replace(discretization__modes=modes, discretization__frame="mean-axis"))
        collision = history.summary["macro_collisions"][0]
        impulses.append(collision["normal_impulse"])
        forces.append(collision["peak_force"])
        print(
            f"{modes:2d} modes: impulse {impulses[-1]:.4f} N s, largest force {forces[-1]:6.0f} N, "
            f"{collision['contacts']} contacts"
        )
    with figure_style():
        figure = Figure(figsize=(7.2, 3.2), layout="constrained")
        left, right = figure.subplots(1, 2)
        left.plot(MODES, impulses, "o-", color=SERIES[0])
        left.axhline(1.87, color=GREY, linestyle="--", linewidth=0.9)
        left.set(title="settles", xlabel="modes (1)", ylabel="normal impulse (N s)", ylim=(1.6, 2.0))
        right.plot(MODES, forces, "o-", color=SERIES[1])
        right.set(title="does not", xlabel="modes (1)", ylabel="largest force (N)", ylim=(0.0, None))
        return [save_figure(figure, Path(folder) / "rigid_stop_modes.png", "")]


if __name__ == "__main__":
    main(*sys.argv[1:2])
