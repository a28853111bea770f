"""
Frequencies of a spinning beam
==============================

A beam clamped to a turning root, by eight assumed modes. Rotation stiffens it, out of the plane of rotation
(flapwise) more than in it (chordwise). ``oblique-impact modes`` does the same from the command line.
"""

from pathlib import Path

from oblique_impact import Scenario
from oblique_impact.scenario.user_defined import discretization
from renders.campbell import campbell_diagram

scenario = Scenario.builtin("spin-up")
beam = discretization(scenario.discretization.method).spectrum(scenario)
for rate in (0.0, 6.0):
    print(f"first chordwise frequency at {rate:.0f} rad/s: {beam.chordwise(rate, 1)[0]:.6f} rad/s")

# %%
# The dotted line is the spin rate itself: where it crosses a frequency, a load that is fixed in space excites that
# mode once per revolution.

campbell_diagram(beam, [0.0, 6.0], 3, Path("campbell.png"))
