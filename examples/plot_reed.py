"""
A reed that winds onto its lay
==============================

A force at the tip of a thin steel reed grows and presses it onto a lay that curves away from it: more and more of
it lies on the lay, from its root on. Then the force lets go. The lay is an outline, ``kind = "polyline"``: points
of an arc, from a list as here or from a file, ``points = "lay.csv"``.
"""

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.renders import Style, render
from oblique_impact.renders.style import SERIES, figure_style

scenario = Scenario.builtin("reed")
history = simulate(scenario)
print(history.balance)

# %%
# At rest the lay bends the reed to its own curvature, which takes the moment EI/R, up to where the force has just
# that moment about: a length EI/(R F) before the tip. The last place of contact follows it in steps of the chords.

beam, (force,) = scenario.beam, scenario.forces
bending = beam.youngs_modulus * beam.section.width * beam.section.height**3 / 12.0  # EI, N m^2
radius = 0.8  # m
time, pushes = history["time"].values, np.nan_to_num(history["contact_lambda_n"].values)
places = np.where(pushes > 0.0, history["contact_place"].values, np.nan)
wound = (time > 0.025) & (time < 0.08)
pressing = -np.interp(time[wound], *np.transpose(force.table))
with figure_style():
    figure = Figure(figsize=(7.2, 3.4), layout="constrained")
    axes = figure.subplots()
    axes.plot(1e3 * time, 1e3 * places, ".", color=SERIES[0], markersize=2.0)
    axes.plot(1e3 * time[wound], 1e3 * (beam.length - bending / (radius * pressing)), color=SERIES[1])
    axes.set(xlabel="time (ms)", ylabel="place along the reed (mm)", ylim=(0.0, 100.0))
    figure.savefig("reed.svg")

# %%
# The film shows where it lies.

look = Style(size=(720, 360), charts=False, inset=False, trace=False)
render(history, "reed.png", look, time=0.079)
render(history, "reed.gif", look, seconds=7.0, fps=12)
