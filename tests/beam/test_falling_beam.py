"""Item 4b: bending of a pinned beam that falls, the statics of the falling chimney."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.beam.operators import build_operators
from oblique_impact.validation.reference_values import VALUES

CHIMNEY = VALUES["4b"]
MASS, BENDING, GRAVITY, ANGLE = 0.86874, 541.27, 9.8, np.pi / 4


def falling(stiffening: float = 1.0, damping: float = 0.0, end_time: float = 1.0, **shapes: Any) -> Scenario:
    """The beam of item 4b, with an output station at L/3 (that of a contact point that is switched off)."""
    return Scenario.from_dict(
        {
            "end_time": end_time,
            "gravity": GRAVITY,
            "beam": {
                "length": 1.0,
                "area": 1.0,
                "density": MASS,
                "youngs_modulus": stiffening * BENDING,
                "second_moment": 1.0,
                "modal_damping_ratio": damping,
            },
            "initial": {"angle": ANGLE},
            "contact": {"enabled": False, "point": 1.0 / 3.0},
            "discretization": shapes,
            "solver": {"output_interval": end_time / 200},
        }
    )


def third(points: np.ndarray) -> int:
    """Index of the station at L/3."""
    return int(np.argmin(np.abs(points - 1.0 / 3.0)))


@pytest.mark.parametrize("method", ["modal", "fem"])
def test_a_damped_fall_bends_as_statics_say(method):
    """The same through the equations of motion: the quasi-static part of the damped motion, at every angle."""
    scenario = falling(100.0, 0.9, 0.05, method=method, frame="mean-axis", modes=12, elements=60)
    history = simulate(scenario)
    late = history["time"].values > 0.01  # the slowest vibration has fallen by exp(-0.9 omega_1 t) = 1e-15
    theta, elastic = history["theta"].values[late], history["q"].values[late, 1:]
    share = np.cos(theta) / np.cos(ANGLE)
    tip = history["uy"].values[late, -1] - elastic @ build_operators(scenario).root_slope
    moment = history["moment"].values[late, third(history["station"].values)]
    # 12 modes: 2.8e-4 of the tip is missing; nothing of the moment, which is one of equilibrium: only the beam's
    # own accelerations disturb it, of the order (rate of the fall/omega_1)^2 = 1e-6;
    # the damper lags by 2 zeta/omega_1 = 0.5 ms, over which cos(theta) changes by 2e-4
    np.testing.assert_allclose(tip, CHIMNEY["tip"] / 100.0 * share, rtol=6e-4)
    np.testing.assert_allclose(moment, CHIMNEY["Mmax"] * share, rtol=1e-5)


def test_a_sudden_release_doubles_the_bending():
    """One hinged-free mode swings between 0 and twice its static deflection, with its own frequency."""
    frequency = CHIMNEY["omega1"] * np.sqrt(100.0 * BENDING / MASS)
    scenario = falling(100.0, 0.0, 2.0 * np.pi / frequency, method="modal", frame="mean-axis", modes=1)
    o, history = build_operators(scenario), simulate(scenario)
    static = -GRAVITY * np.cos(ANGLE) * o.P[0] / o.K[0, 0]
    amplitude = history["q"].values[:, 1] / static
    phase = frequency * history["time"].values
    # in one period theta falls by g t^2 = 2e-5 rad, and omega_1 is given to 5 digits
    np.testing.assert_allclose(amplitude, 1.0 - np.cos(phase), atol=1e-4)
    assert amplitude.max() == pytest.approx(2.0, abs=1e-4)
