"""
A user-defined contact law and friction law
===========================================

A Hertzian stop and Stribeck friction, each a few lines, take the places of the built-in laws.
"""

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.contact.friction import FrictionCurve
from oblique_impact.contact.stops import ContactLaw
from oblique_impact.renders.style import SERIES, figure_style
from oblique_impact.scenario.user_defined import register

# %%
# A contact law is one function of depth and rate of depth. It is compiled for the run, and what it does not give
# back is booked as damping.


@register("contact_laws", "hertz")
@dataclass(frozen=True)
class Hertz(ContactLaw):
    """A sphere on a plane, with the damping of Hunt and Crossley."""

    stiffness: float = 1e8  # N/m^1.5
    damping: float = 0.0  # s/m

    @staticmethod
    def normal_force(depth, rate, stiffness, damping):
        return stiffness * depth**1.5 * (1.0 + damping * rate)


# %%
# A friction law may be a table: coefficients over speed, linear in between.


@register("friction_laws", "stribeck")
class Stribeck(FrictionCurve):
    """mu(v) = kinetic + (static - kinetic) exp(-v / speed), as straight lines."""

    def __init__(self, static=0.3, kinetic=0.1, speed=0.05):
        speeds = np.concatenate([np.linspace(0.0, 3.0, 13), [4.0, 5.0]]) * speed
        points = tuple((v, kinetic + (static - kinetic) * math.exp(-v / speed)) for v in speeds.tolist())
        super().__init__(points, static)


# %%
# Scenarios call them by their names. The swinging beam strikes the stops with the same speed.

base = Scenario.builtin("paper").replace(
    end_time=0.3192, solver__output_interval=1e-6, contact__friction="stribeck"
)
cases = {
    "spring, 1e6 N/m": base.replace(contact__normal="spring", contact__damping=0.3),
    "Hertz, 1e8 N/m^1.5": base.replace(contact__normal="hertz", parameters__normal={"damping": 0.3}),
}
histories = {name: simulate(scenario) for name, scenario in cases.items()}
for name, history in histories.items():
    energy = history.summary["energy"]
    print(
        f"{name:19s} peak {float(history['lambda_n'].max()):5.0f} N, damping {1e3 * energy['lost_damping']:.1f} mJ"
    )
    print(f"{'':19s} friction {1e3 * energy['lost_friction']:.2f} mJ, unaccounted {energy['unaccounted']:.0e} J")

with figure_style():
    figure = Figure(figsize=(7.2, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    for (name, history), colour in zip(histories.items(), SERIES, strict=False):
        normal = history["lambda_n"].values
        pressed = normal > 1e-6
        left.plot(-1e3 * history["gap"].values[pressed], normal[pressed], color=colour, label=name)
        ratio = np.abs(history["lambda_tau"].values[pressed]) / normal[pressed]
        right.plot(np.abs(history["slip_rate"].values[pressed]), ratio, ".", ms=3, color=colour)
    left.set(xlabel="depth (mm)", ylabel="normal force (N)", ylim=(0.0, 2600.0))
    left.legend()
    right.set(xlabel="slip speed (m/s)", ylabel="tangential over normal force (1)", ylim=(0.0, 0.35))
    figure.savefig("own_laws.svg")
