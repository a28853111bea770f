"""
A strip on a shaken base
========================

A steel strip stands clamped on a base that is shaken across it, near its first frequency. Without the stop
it would swing by more than three times the gap; it strikes the stop, and soon once in each period. All motion is
that seen from the base.
"""

import matplotlib.pyplot as plt

from oblique_impact import Scenario, simulate

history = simulate(Scenario.builtin("shaken"))
for contact in history.contacts[-4:]:
    print(f"{contact.start:.5f} s: {1e3 * contact.normal_impulse:.3f} mN s, at most {contact.peak_force:.3f} N")
print(f"the base has done a work of {1e3 * history.balance['supplied']:.3f} mJ")

# %%
# The tip in the phase plane: grey from the start at rest, in colour the last three periods.

period = 1.0 / history.scenario.base.frequency
figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
for part, colour in ((history.data, "0.7"), (history.data.sel(time=slice(1.0 - 3.0 * period, 1.0)), "C0")):
    axes.plot(1e3 * part["tip_x"], part["tip_vx"], color=colour, linewidth=0.8)
axes.axvline(2.0, color="k", linewidth=0.8)
axes.set_xlabel("tip, mm")
axes.set_ylabel("velocity, m/s")
figure.savefig("shaken.svg")
