"""Two discretizations, one motion.

The paper's beam by two clamped assumed modes, and by Hermite finite elements that are reduced to two of their
own modes. Both go through the same contact, so all that can tell them apart is the discretization: the times of
their events approach each other with the fourth power of the element length.
"""

from __future__ import annotations

import sys
from pathlib import Path

from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from renders.files import save_figure
from renders.style import GREY, SERIES, figure_style
from validation.comparison import compare_events, largest_difference

ELEMENTS = (8, 16, 32, 64)
EVENTS = 8  # those of the first macro-collision


def main(folder: str = "out/examples") -> list[Path]:
    """Compare event times on four meshes; returns the picture."""
    scenario = Scenario.builtin("paper", ["end_time=0.4"])
    modal = simulate(scenario)
    differences = []
    for elements in ELEMENTS:
        fem = scenario.replace(discretization__method="fem", discretization__elements=elements)
        pairs = compare_events(modal, simulate(fem))
        differences.append(largest_difference(pairs[:EVENTS]))
        print(f"{elements:3d} elements: largest difference of an event time {differences[-1]:.2e} s")
    with figure_style():
        figure = Figure(figsize=(5.6, 3.6), layout="constrained")
        axes = figure.subplots()
        axes.loglog(ELEMENTS, differences, "o-", color=SERIES[0], label="finite elements against modes")
        slope = [differences[0] * (ELEMENTS[0] / n) ** 4 for n in ELEMENTS]
        axes.loglog(ELEMENTS, slope, "--", color=GREY, label="fourth order")
        axes.set(xlabel="elements (1)", ylabel="largest difference of\nan event time (s)")
        axes.set_xticks(ELEMENTS, [str(n) for n in ELEMENTS])
        axes.minorticks_off()
        axes.legend()
        return [save_figure(figure, Path(folder) / "two_discretizations.png", "")]


if __name__ == "__main__":
    main(*sys.argv[1:2])
