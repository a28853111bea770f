"""
Stills of the first contacts
============================

The beam before, during and after its first contacts, coloured by bending stress: a still for each time. Scale of
colours, magnification and camera are those of the run, so that the pictures can stand below each other in a paper.
The same from the command line: ``oblique-impact render out/paper --time 0.319 --out stills_2.png``.
"""

from oblique_impact import Scenario, simulate
from oblique_impact.renders import Style, render

history = simulate(Scenario.builtin("paper", ["end_time=0.4"]))
for number, time in enumerate((0.3, 0.319, 0.3245, 0.345), start=1):  # s
    render(history, f"stills_{number}.png", Style(size=(640, 360), inset=False, title=""), time=time)
