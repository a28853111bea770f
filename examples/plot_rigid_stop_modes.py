"""
A rigid stop as modes are added
===============================

The velocity of the tip's effective mass jumps at a rigid stop, and this mass shrinks with every mode. The first
macro-collision (a group of contacts in quick succession) of the paper's beam, without friction, shows the effect.
"""

from matplotlib.figure import Figure

from oblique_impact import Scenario
from oblique_impact.renders.style import GREY, SERIES, figure_style
from oblique_impact.validation import refine

modes = [2, 4, 6, 8, 10, 12]
base = Scenario.builtin("paper", ["end_time=0.34", "contact.friction=frictionless"])
base = base.replace(discretization__frame="mean-axis")
study = refine(base, modes=modes, quantities=["impulse", "peak_force", "contacts"], workers=1)
values = study.tables["levels"]["value"]
impulses, forces, contacts = (values[name] for name in ("impulse", "peak_force", "contacts"))
for count, impulse, force, number in zip(modes, impulses, forces, contacts, strict=True):
    print(f"{count:2d} modes: impulse {impulse:.4f} N s, largest force {force:6.0f} N, {number:.0f} contacts")
for name in ("impulse", "peak_force"):
    print(f"{name}: {study[name].verdict}")

# %%
# The impulse stays in a narrow band about 1.87 N s, within which it has no limit: neither is determined without
# damping (:doc:`/convergence`). The largest force grows with every mode. Read the impulse off such a model with
# its band, and never the force.

with figure_style():
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(modes, impulses, "o-", color=SERIES[0])
    left.axhline(1.87, color=GREY, linestyle="--", linewidth=0.9)
    left.set(title="stays in a band", xlabel="modes", ylabel="normal impulse (N s)", ylim=(1.6, 2.0))
    right.plot(modes, forces, "o-", color=SERIES[1])
    right.set(title="grows", xlabel="modes", ylabel="largest force (N)", ylim=(0.0, None))
    figure.savefig("rigid_stop_modes.svg")
