"""
Friction and slope
==================

Ten thousand runs of the paper's case, 1 s each, over the angle of the slope and both friction coefficients: the
sweep ``docs/studies/friction-slope.toml``, of some minutes on two cores. Columns of its table are kept beside
this page.
"""

import json
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import renders
from oblique_impact.renders.style import figure_style

store = Path(renders.__file__).parents[1] / "docs" / "friction-slope.json"
stored = json.loads(store.read_text(encoding="utf-8"))
count = stored["count"]
angle, friction = (np.linspace(*stored[key], count) for key in ("slope.angle", "contact.mu_kinetic"))
values = {name: np.array(stored[name]).reshape(count, count) for name in ("energy_final", "lost_friction")}
print(stored["outcomes"])

# %%
# On gentle slopes the beam keeps up to two thirds of its 3 J in bands of the slope angle, which friction shifts
# and does not wipe out. Between them it keeps less; near their edges, and in the bands of steeper slopes, runs
# side by side differ by half a joule: where a rigid stop is struck many times, the last impacts are left to
# chance. Friction takes a tenth of a joule, and most of it in the bands.

panels = {
    "energy_final": ("energy left after 1 s (J)", "magma"),
    "lost_friction": ("lost to friction (J)", "viridis"),
}
with figure_style():
    figure = Figure(figsize=(7.2, 4.2), layout="constrained")
    for axes, name in zip(figure.subplots(1, 2, sharey=True), panels, strict=True):
        title, colours = panels[name]
        places = {"extent": (friction[0], friction[-1], *np.degrees(angle[[0, -1]])), "aspect": "auto"}
        highest = float(np.nanquantile(values[name], 0.995))
        image = axes.imshow(
            values[name], origin="lower", cmap=colours, interpolation="nearest", vmin=0.0, vmax=highest, **places
        )
        figure.colorbar(image, ax=axes, location="top", label=title, extend="max", aspect=28)
        axes.set(xlabel="friction coefficient (1)", yticks=range(0, 46, 15))
        axes.tick_params(which="both", direction="out")
        axes.grid(visible=False)
        for side in axes.spines.values():
            side.set_visible(True)
    figure.axes[0].set(ylabel="slope angle (deg)")
    figure.savefig("friction_slope.svg", dpi=200)
