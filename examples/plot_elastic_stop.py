"""An elastic stop has a limit.

The full nodal model on a spring of 1e6 N/m: with twice the elements the contact force is the same curve. Its
first five contacts are known from an independent, geometrically exact code (peak 924.45 N, total impulse
2.140259 N s).
"""

from __future__ import annotations

import sys
from pathlib import Path

from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from renders.files import save_figure
from renders.style import GREY, SERIES, figure_style

PEAK = 924.45  # N


def main(folder: str = "out/examples") -> list[Path]:
    """Run the first macro-collision on two meshes; returns the picture."""
    base = Scenario.builtin("elastic-stop", ["end_time=0.335", "solver.output_interval=1e-5"])
    with figure_style():
        figure = Figure(figsize=(7.2, 3.2), layout="constrained")
        axes = figure.subplots()
        for elements, colour, dash in ((16, SERIES[1], "-"), (32, SERIES[0], (0, (4, 2)))):
            history = simulate(base.replace(discretization__elements=elements))
            collision = history.summary["macro_collisions"][0]
            print(
                f"{elements} elements: {collision['contacts']} contacts, "
                f"impulse {collision['normal_impulse']:.6f} N s, peak {collision['peak_force']:.2f} N"
            )
            axes.plot(
                1e3 * history["time"],
                history["lambda_n"],
                color=colour,
                linestyle=dash,
                label=f"{elements} elements",
            )
        axes.axhline(PEAK, color=GREY, linestyle=":", linewidth=0.9, label="peak of the independent code")
        axes.set(xlabel="time (ms)", ylabel="normal force (N)", xlim=(316.5, 330.0), ylim=(0.0, 1100.0))
        axes.legend(loc="upper center", ncols=3)
        return [save_figure(figure, Path(folder) / "elastic_stop.png", "")]


if __name__ == "__main__":
    main(*sys.argv[1:2])
