"""
A rigid stop that converges
===========================

With a little internal damping, 0.2 per cent of critical in the first mode, results on a rigid stop converge. A
contact point without inertia needs few modes; plastic impacts converge to the same limit, more slowly.
"""

from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.renders.style import GREY, SERIES, figure_style

LIMIT = 1.819369  # N s; the impulse of the first macro-collision
modes = [8, 10, 12, 14, 16]
base = Scenario.builtin(
    "paper", ["end_time=0.34", "contact.friction=frictionless", "discretization.frame=mean-axis"]
).replace(beam__kelvin_voigt=1e-5)
impulses = {"plastic impacts": [], "no inertia": []}
for count in modes:
    for name, inertia in (("plastic impacts", "kept"), ("no inertia", "none")):
        history = simulate(base.replace(discretization__modes=count, contact__point_inertia=inertia))
        collision = history.summary["macro_collisions"][0]
        impulses[name].append(collision["normal_impulse"])
        print(f"{count:2d} modes, {name}: {impulses[name][-1]:.6f} N s, {collision['contacts']} contacts")

# %%
# Eight modes do not resolve the damping, and the run says so: their highest one is damped too little, and what
# follows the first touch-down is left to chance.

print("\n".join(simulate(base.replace(discretization__modes=8)).summary["warnings"]))

# %%
# From twelve modes on the five contacts are always the same.

with figure_style():
    figure = Figure(figsize=(6.4, 3.2), layout="constrained")
    axes = figure.subplots()
    for index, (name, values) in enumerate(impulses.items()):
        axes.plot(modes, values, "o-", color=SERIES[index], label=name)
    axes.axhline(LIMIT, color=GREY, linestyle="--", linewidth=0.9, label="limit")
    axes.set(xlabel="modes (1)", ylabel="normal impulse (N s)")
    axes.legend()
    figure.savefig("damped_stop.svg")
