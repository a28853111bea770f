"""
Two pegs
========

A beam falls across two pegs. Its impacts alternate between them, each a fraction of the time after the one before,
until both hold it; then it leaves them one after the other. With ``contact.where = "anywhere"`` the whole beam can
touch slope and obstacles, and a peg touches it wherever it lies on it.
"""

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.renders import Style, render
from oblique_impact.renders.style import SERIES, figure_style

history = simulate(Scenario.builtin("two-pegs"))
print(history.event_table[["time", "kind", "obstacle", "place", "normal_impulse"]].head(8).to_string())

# %%
# Every contact has its place, gap, forces and state over time, along the dimension ``contact``.

time, force = 1e3 * history["time"].values, history["contact_lambda_n"].values
with figure_style():
    figure = Figure(figsize=(7.2, 3.4), layout="constrained")
    axes = figure.subplots()
    for number in history["contact_obstacle"].values:
        axes.plot(time, np.nan_to_num(force[:, number - 1]), color=SERIES[number - 1], label=f"peg {number}")
    axes.set(xlabel="time (ms)", ylabel="normal force (N)", xlim=(380.8, 385.0), ylim=(0.0, None))
    axes.legend()
    figure.savefig("two_pegs.svg")

# %%
# The film shows every force at its place; here it is small and short.

render(history, "two_pegs.gif", Style(size=(640, 360), charts=False), between=(0.36, 0.386), seconds=6.0, fps=12)
