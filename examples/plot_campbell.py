"""
Frequencies of a spinning beam
==============================

A beam clamped to a turning root, by eight assumed modes. Rotation stiffens it, out of the plane of rotation
(flapwise) more than in it (chordwise). ``oblique-impact modes`` does the same from the command line.
"""

from oblique_impact import Scenario, natural_frequencies
from oblique_impact.renders import campbell_diagram

scenario = Scenario.builtin("spin-up")
found = natural_frequencies(scenario, speeds=[0.0, 6.0], count=3)
for rate, row in zip(found.speeds, found.chordwise, strict=True):
    print(f"first chordwise frequency at {rate:.0f} rad/s: {row[0]:.6f} rad/s")

# %%
# The dotted lines 1P and 2P are the spin rate and twice of it: where one crosses a frequency, a load that is fixed
# in space excites that mode once or twice per revolution.

campbell_diagram(scenario, [0.0, 6.0], 3, "campbell.svg")
