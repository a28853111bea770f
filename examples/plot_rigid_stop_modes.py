"""
What a rigid stop does as modes are added
=========================================

The mass that a rigid stop turns around in an instant is that of the tip, and it shrinks with every mode. Here is
what that does to the first macro-collision of the paper's beam, without friction.
"""

from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from renders.style import GREY, SERIES, figure_style

modes = [2, 4, 6, 8, 10, 12]
base = Scenario.builtin("paper", ["end_time=0.34", "contact.friction=frictionless"])
impulses, forces = [], []
for count in modes:
    history = simulate(base.replace(discretization__modes=count, discretization__frame="mean-axis"))
    collision = history.summary["macro_collisions"][0]
    impulses.append(collision["normal_impulse"])
    forces.append(collision["peak_force"])
    print(
        f"{count:2d} modes: impulse {impulses[-1]:.4f} N s, largest force {forces[-1]:6.0f} N, "
        f"{collision['contacts']} contacts"
    )

# %%
# The impulse settles near 1.87 N s. The largest force does not: read the impulse off such a model, never the
# force.

with figure_style():
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(modes, impulses, "o-", color=SERIES[0])
    left.axhline(1.87, color=GREY, linestyle="--", linewidth=0.9)
    left.set(title="settles", xlabel="modes (1)", ylabel="normal impulse (N s)", ylim=(1.6, 2.0))
    right.plot(modes, forces, "o-", color=SERIES[1])
    right.set(title="does not", xlabel="modes (1)", ylabel="largest force (N)", ylim=(0.0, None))
    figure.savefig("rigid_stop_modes.png")
