"""
A beam that falls across the edge of a table
============================================

The table ends 0.61 m from the pin. Its corner, which is a place of its own between those of the mesh, takes all
of the impact; the free end whips over it. The impulse is larger than that of a slap onto a longer table.
"""

import numpy as np

from oblique_impact import Scenario, simulate
from oblique_impact.renders import Style, render

scenario = Scenario.builtin("edge")
angle = 0.1  # rad, with the speed of a fall from 45 degrees
drop = scenario.beam.length * (np.sin(scenario.initial.angle) - np.sin(angle))  # m
speed = np.sqrt(3.0 * scenario.gravity * drop) / scenario.beam.length  # rad/s
fall = {"initial__angle": angle, "initial__angular_velocity": -speed, "end_time": 0.045}
history = simulate(scenario.replace(solver__output_interval=2e-5, **fall))
slap = simulate(Scenario.builtin("slap").replace(**fall))
for name, run in (("edge", history), ("slap", slap)):
    print(f"{name}: {run.macro_collisions[0]['normal_impulse']:.3f} N s")

# %%
# Each contact is at the corner, over which the beam slides by hundredths of a millimetre.

print(history.contact_table[["start", "end", "first_place", "last_place", "normal_impulse"]].to_string())
look = Style(size=(720, 320), charts=False, inset=False, trace=False, ghosts=False)
render(history, "edge.gif", look, seconds=7.0, fps=12)
