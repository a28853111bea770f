"""
A beam between two tables
=========================

The beam swings up against a table above it, falls onto the one below, and bounces on it: impacts are plastic, what
bounces is its bending.
"""

from oblique_impact import Scenario, simulate
from oblique_impact.renders import Style, render

history = simulate(Scenario.builtin("gap"))
for collision in history.macro_collisions:
    print(
        f"{collision['start']:.4f} s: {collision['contacts']} contacts, {collision['normal_impulse']:.3f} N s, "
        f"at most {collision['peak_force']:.0f} N"
    )

# %%
# Sides can be touched by the free end and by the ends of ``contact.grid`` equal parts of the beam. Here the end
# alone touches; a warning would say if the beam passed below a table elsewhere.

print(history.contact_table[["start", "end", "obstacle", "last_place", "normal_impulse"]].head().to_string())
render(history, "gap.gif", Style(size=(640, 360), charts=False), between=(0.0, 0.3), seconds=6.0, fps=12)
