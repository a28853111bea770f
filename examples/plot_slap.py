"""
A beam that slaps onto a table
==============================

The beam falls flat onto a table 20 mm under its pin. Its tip strikes first, then contact runs along the beam:
places of it close and open by the dozen, which time-stepping decides step by step, without a search for events.
The run begins a little above the table, with the speed of a fall from 45 degrees.
"""

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.renders import Style, draw_contact_map, render
from oblique_impact.renders.style import figure_style

scenario = Scenario.builtin("slap")
angle = 0.1  # rad
drop = scenario.beam.length * (np.sin(scenario.initial.angle) - np.sin(angle))  # m
speed = np.sqrt(3.0 * scenario.gravity * drop) / scenario.beam.length  # rad/s
scenario = scenario.replace(
    initial__angle=angle, initial__angular_velocity=-speed, end_time=0.045, solver__output_interval=2e-5
)
history = simulate(scenario)
(collision,) = history.macro_collisions
print(f"{collision['contacts']} contacts within {1e3 * (collision['end'] - collision['start']):.2f} ms")
print(history.contact_table[["start", "end", "last_place", "normal_impulse"]].head(8).to_string())

# %%
# Where it touches over time. Each of the 64 places that can touch is a bar while it is closed, in the colour of
# its force; what sticks would be hatched.

with figure_style():
    figure = Figure(figsize=(7.2, 3.0), layout="constrained")
    axes = figure.subplots()
    figure.colorbar(draw_contact_map(axes, history), ax=axes, label="normal force (N)")
    axes.set(xlabel="time (ms)", ylabel="place along the beam (m)")
    figure.savefig("slap.svg")

# %%
# The film shows every force at its place, and the zone of contact as a band on the beam.

look = Style(size=(720, 320), charts=False, inset=False, trace=False, ghosts=False)
render(history, "slap.gif", look, seconds=7.0, fps=12)
