"""
User-defined laws and a base motion
===================================

A Hertzian stop and Stribeck friction, each a few lines, take the places of the built-in laws; then the root swings
as prescribed, and two schemes march it all.
"""

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from oblique_impact import Scenario, simulate
from oblique_impact.beam.base_motion import BaseMotion
from oblique_impact.contact.friction import FrictionCurve
from oblique_impact.contact.stops import ContactLaw, ElasticStop
from oblique_impact.renders.style import SERIES, figure_style

# %%
# A contact law is one function of depth and rate of depth. It is compiled for the run, and what it does not give
# back is booked as damping.


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


def stribeck(static=0.3, kinetic=0.1, speed=0.05):
    """mu(v) = kinetic + (static - kinetic) exp(-v / speed), as straight lines."""
    speeds = np.concatenate([np.linspace(0.0, 3.0, 13), [4.0, 5.0]]) * speed
    points = tuple((v, kinetic + (static - kinetic) * math.exp(-v / speed)) for v in speeds.tolist())
    return FrictionCurve(points, static)


# %%
# They are handed to `simulate`. The swinging beam strikes both stops with the same speed.

base = Scenario.builtin("paper").replace(end_time=0.3192, solver__output_interval=1e-6, contact__normal="spring")
stops = {"spring, 1e6 N/m": ElasticStop(1e6, 0.3), "Hertz, 1e8 N/m^1.5": Hertz(damping=0.3)}
histories = {name: simulate(base, friction=stribeck(), contact_law=stop) for name, stop in stops.items()}
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
        normal = np.asarray(history["lambda_n"])
        pressed = normal > 1e-6
        left.plot(-1e3 * np.asarray(history["gap"])[pressed], normal[pressed], color=colour, label=name)
        ratio = np.abs(np.asarray(history["lambda_tau"])[pressed]) / normal[pressed]
        right.plot(np.abs(np.asarray(history["slip_rate"])[pressed]), ratio, ".", ms=3, color=colour)
    left.set(xlabel="depth (mm)", ylabel="normal force (N)", ylim=(0.0, 2600.0))
    left.legend()
    right.set(xlabel="slip speed (m/s)", ylabel="tangential over normal force (1)", ylim=(0.0, 0.35))
    figure.savefig("own_laws.svg")

# %%
# A base motion is one function of time as well. The paper's fixed steps notice an event at the end of a step.


@dataclass(frozen=True)
class Swing(BaseMotion):
    """angle = amplitude (1 - cos(2 pi frequency t))."""

    amplitude: float = -0.2  # rad
    frequency: float = 2.0  # Hz

    @staticmethod
    def turn(t, amplitude, frequency):
        w = 2.0 * math.pi * frequency
        angle, speed = amplitude * (1.0 - math.cos(w * t)), amplitude * w * math.sin(w * t)
        return angle, speed, amplitude * w**2 * math.cos(w * t)


driven = Scenario.builtin("paper").replace(
    end_time=0.3,
    root__kind="driven",
    initial__angle=0.6,
    contact__normal="spring",
)
fixed = driven.replace(solver__scheme="fixed-step", solver__free_step=2e-5, solver__contact_step=2e-6)
parts = {"base_motion": Swing(), "friction": stribeck(), "contact_law": Hertz(damping=0.1)}
exact, steps = simulate(driven, **parts), simulate(fixed, **parts)
for one, other in zip(exact.events[:6], steps.events[:6], strict=True):
    print(f"{one.kind.value:8s} at {one.time:.6f} s, by fixed steps {1e6 * (other.time - one.time):+.1f} us off")
