"""A beam that lies down on a table, by its mesh: the picture of docs/convergence.md.

python benchmarks/anywhere.py [FOLDER]      runs docs/studies/anywhere.toml there (ten minutes) or takes its rows
"""

from __future__ import annotations

import sys
from pathlib import Path

from matplotlib.figure import Figure

from oblique_impact.renders.style import PAGE, figure_style
from oblique_impact.validation import refine

DOCS = Path(__file__).parents[1] / "docs"
#: by panel: title, series with their legends
PANELS = {
    "edge, damped": {
        "edge, plastic, nodes alone": "nodes alone",
        "edge, plastic, elements": "plastic",
        "edge, no inertia, elements": "no inertia",
    },
    "slap, damped": {
        "slap, plastic, elements": "plastic",
        "slap, no inertia, elements": "no inertia",
    },
    "slap, undamped": {
        "slap, undamped, plastic, elements": "plastic",
        "slap, undamped, no inertia, elements": "no inertia",
    },
}
COLOURS = {"nodes alone": 2, "plastic": 0, "no inertia": 1}


def main(folder: Path) -> None:
    """Draw the impulses over the number of elements."""
    found = (
        refine(DOCS / "studies" / "anywhere.toml", out=folder).tables["levels"].loc["impulse"].set_index("series")
    )
    with figure_style(PAGE):
        figure = Figure(figsize=(9.2, 3.4), layout="constrained")
        for axes, (title, names) in zip(figure.subplots(1, 3), PANELS.items(), strict=True):
            for name, legend in names.items():
                levels, values = found.loc[name, "level"], found.loc[name, "value"]
                axes.semilogx(
                    levels, values, "o-", color=PAGE.series[COLOURS[legend]], markersize=4.5, label=legend
                )
            axes.set_xticks([16, 32, 64, 128], ["16", "32", "64", "128"])
            axes.minorticks_off()
            axes.set(xlabel="elements", title=title)
            axes.legend(fontsize=8.5)
        figure.axes[0].set(ylabel="impulse (N s)", ylim=(3.15, 4.05))
        for axes in figure.axes[1:]:  # on one scale, of 4 % of the impulse
            axes.set_ylim(2.66, 2.78)
        figure.savefig(DOCS / "anywhere.svg", metadata={"Date": None})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("out/anywhere"))
