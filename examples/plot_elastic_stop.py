"""
An elastic stop converges
=========================

A compliant slope, with 1e6 N/m, instead of a rigid one. The model is the full one, with all nodes, marched
implicitly.
"""

from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.renders.style import GREY, SERIES, figure_style

base = Scenario.builtin("elastic-stop", ["end_time=0.335", "solver.output_interval=1e-5"])
histories = {count: simulate(base.replace(discretization__elements=count)) for count in (16, 32)}

# %%
# An independent, geometrically exact program finds five contacts, a largest force of 924.45 N and an impulse of
# 2.140259 N s.

for count, history in histories.items():
    collision = history.summary["macro_collisions"][0]
    print(
        f"{count} elements: {collision['contacts']} contacts, impulse {collision['normal_impulse']:.6f} N s, "
        f"peak {collision['peak_force']:.2f} N"
    )

# %%
# With twice the elements the contact force is the same curve, point by point:

with figure_style():
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    axes = figure.subplots()
    for (count, history), colour, dash in zip(histories.items(), SERIES[1::-1], ("-", (0, (4, 2))), strict=True):
        line = {"color": colour, "linestyle": dash, "label": f"{count} elements"}
        axes.plot(1e3 * history["time"], history["lambda_n"], **line)
    axes.axhline(924.45, color=GREY, linestyle=":", linewidth=0.9, label="peak of the independent code")
    axes.set(xlabel="time (ms)", ylabel="normal force (N)", xlim=(316.5, 330.0), ylim=(0.0, 1100.0))
    axes.legend(loc="upper center", ncols=3)
    figure.savefig("elastic_stop.svg")
