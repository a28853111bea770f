"""
A tip that sticks
=================

On a steep, rough slope friction beats the lever arm: after one bounce the tip sticks.
"""

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.contact.state import State
from oblique_impact.renders.style import GREY, STATE_COLOURS, figure_style

scenario = Scenario.builtin("sticking")
history = simulate(scenario)
for kind in ("impact", "stick", "slip", "release"):
    print(f"{kind:8s} {sum(event.kind.value == kind for event in history.events):3d} times")

# %%
# A history is a set of labelled arrays. Sticking lasts as long as the tangential force stays inside the friction
# cone, here between the dashed lines.

time, state = history["time"].values, history["state"].values
normal, tangential = history["lambda_n"].values, history["lambda_tau"].values
pressed = np.nan_to_num(normal) > 1e-3
ratio = np.where(pressed, tangential / np.where(pressed, normal, 1.0), np.nan)

with figure_style():
    figure = Figure(figsize=(7.2, 4.2), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True)
    for member in (State.SLIP, State.STICK):
        there = np.where(state == member, ratio, np.nan)
        upper.plot(time, there, ".", markersize=2.5, color=STATE_COLOURS[member], label=member.name.lower())
    for sign in (-1.0, 1.0):
        upper.axhline(sign * scenario.contact.mu_static, color=GREY, linestyle="--", linewidth=0.9)
    upper.set(ylabel="tangential over\nnormal force (1)", ylim=(-2.6, 3.4))
    upper.legend(markerscale=4, ncols=2, loc="upper left")
    for member in State:
        there = np.where(state == member, 1e3 * history["gap"].values, np.nan)
        lower.plot(time, there, color=STATE_COLOURS[member], label=member.name.lower())
    lower.set(xlabel="time (s)", ylabel="gap (mm)", xlim=(0.54, 0.65), ylim=(-1.0, 20.0))
    lower.legend(ncols=3, loc="upper right")
    figure.savefig("sticking.svg")
