"""
The paper's case at a glance
============================

A beam falls from 45 degrees about its pin onto a slope of 18 degrees, slips, reverses its slip and bounces.
A scenario says what to simulate; the built-in ``paper`` has the data of the source paper: two clamped modes,
a rigid stop without restitution, a coefficient of friction of 0.3.
"""

from oblique_impact import Scenario, simulate
from oblique_impact.renders import render

history = simulate(Scenario.builtin("paper"))
render(history, "paper_still.png", time=0.3245)

# %%
# The tip is pressed onto the slope; the inset shows it at true scale.
#
# Every transition is located to about 1e-10 s. These are the events of the first *macro-collision*, the group of
# contacts in quick succession.

for event in history.events[:8]:
    print(f"{event.time:.10f} s  {event.kind.value:8s}  then {event.state.name.lower()}")

# %%
# Motion, shapes, contact force, gap, and where the energy goes:

history.plot().savefig("paper_case.svg")

# %%
# The summary holds what is asked for most. The ledger compares the energy that is left with what impacts and
# friction took; the part that it cannot explain measures the error of the integration.

for collision in history.summary["macro_collisions"]:
    print(f"macro-collision from {collision['start']:.4f} s: {collision['normal_impulse']:.4f} N s")
energy = history.summary["energy"]
print(f"energy: {energy['initial']:.4f} J at first, {energy['final']:.4f} J at last")
print(f"impacts took {energy['lost_impact']:.4f} J, friction {energy['lost_friction']:.4f} J")
print(f"not explained: {abs(energy['unaccounted']):.0e} J")
