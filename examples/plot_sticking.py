"""A tip that sticks.

On a steep, rough slope friction beats the lever arm: after one bounce the tip sticks. Sticking lasts as
long as the tangential force stays inside the friction cone, here between the dashed lines.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.contact import State
from renders.files import save_figure
from renders.style import GREY, STATE_COLOURS, figure_style


def main(folder: str = "out/examples") -> list[Path]:
    """Run the case and draw force ratio and gap in the colours of the states; returns the picture."""
    scenario = Scenario.builtin("sticking")
    history = simulate(scenario)
    time, state = history["time"].values, history["state"].values
    pressed = np.nan_to_num(history["lambda_n"].values) > 1e-3
    ratio = np.where(
        pressed, history["lambda_tau"].values / np.where(pressed, history["lambda_n"].values, 1.0), np.nan
    )
    for kind in ("impact", "stick", "slip", "release"):
        print(f"{kind:8s} {sum(event.kind.value == kind for event in history.events):3d} times")
    with figure_style():
        figure = Figure(figsize=(7.2, 4.2), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True)
        for member, name in ((State.SLIP, "slip"), (State.STICK, "stick")):
            there = np.where(state == member, ratio, np.nan)
            upper.plot(time, there, ".", markersize=2.5, color=STATE_COLOURS[member], label=name)
        for sign in (-1.0, 1.0):
            upper.axhline(sign * scenario.contact.mu_static, color=GREY, linestyle="--", linewidth=0.9)
        upper.set(ylabel="tangential over\nnormal force (1)", ylim=(-2.6, 3.4))
        upper.legend(markerscale=4, ncols=2, loc="upper left")
        for member in State:
            there = np.where(state == member, 1e3 * history["gap"].values, np.nan)
            lower.plot(time, there, color=STATE_COLOURS[member], label=member.name.lower())
        lower.set(xlabel="time (s)", ylabel="gap (mm)", xlim=(0.54, 0.65), ylim=(-1.0, 20.0))
        lower.legend(ncols=3, loc="upper right")
        return [save_figure(figure, Path(folder) / "sticking.png", "")]


if __name__ == "__main__":
    main(*sys.argv[1:2])
