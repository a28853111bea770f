"""The built-in case of a beam so stiff that it is a rigid pinned bar falling on the slope, in closed form."""

from __future__ import annotations

from math import asin, cos, cosh, pi, sin, sinh, sqrt

import numpy as np
import pytest
from scipy.special import ellipk, ellipkinc

from oblique_impact import Scenario, simulate
from oblique_impact.validation.reference_values import VALUES

RIGID = VALUES["4"]


def first_touch(scenario: Scenario) -> tuple[float, float, float]:
    """Time, angle and speed of the rigid bar when its end meets the slope, by elliptic integrals.

    From rest theta'^2 = (3 g/L)(sin theta_0 - sin theta).  With phi = pi/2 + theta the bar is a pendulum of
    natural frequency sqrt(3 g/(2 L)) released at phi_0.
    """
    length, gravity, slope = scenario.beam.length, scenario.gravity, scenario.slope
    x, y = slope.origin
    final = slope.angle + asin((y * cos(slope.angle) - x * sin(slope.angle)) / length)
    k = sin(0.5 * (0.5 * pi + scenario.initial.angle))
    amplitude = asin(sin(0.5 * (0.5 * pi + final)) / k)
    time = (ellipk(k * k) - ellipkinc(amplitude, k * k)) / sqrt(1.5 * gravity / length)
    speed = -sqrt(3.0 * gravity / length * (sin(scenario.initial.angle) - sin(final)))
    return float(time), final, speed


def tip_bound(scenario: Scenario) -> float:
    """Bound of the tip's deflection in the mean-axis frame (m): twice the static one of the first hinged mode.

    It is released suddenly under m g (the cosine is 1 at most): 2 g P phi(L)/K with phi(L) = 2,
    P = m int phi, K = E I b^4/L^3, for phi = sin z/sin b + sinh z/sinh b.
    """
    beam, b = scenario.beam, VALUES["1.2"][0]
    mean = ((1.0 - cos(b)) / sin(b) + (cosh(b) - 1.0) / sinh(b)) / b
    load = beam.density * beam.area * beam.length * abs(mean)
    stiffness = beam.youngs_modulus * beam.second_moment * b**4 / beam.length**3
    return 2.0 * scenario.gravity * load * 2.0 / stiffness


def test_the_closed_form_is_the_tabulated_one():
    time, theta, speed = first_touch(Scenario.builtin("paper"))
    assert (time, theta, speed) == pytest.approx((RIGID["t"], RIGID["theta_f"], RIGID["omega"]), rel=1e-13)


def test_built_in_rigid_limit():
    scenario = Scenario.builtin("rigid-limit")
    time, theta, speed = first_touch(scenario)
    history, bound = simulate(scenario), tip_bound(scenario) / scenario.beam.length
    touch = history.events[0].time
    before = int(np.flatnonzero(history["time"].values == touch)[0])
    assert bound < 1e-6
    assert history["theta"].values[before] == pytest.approx(theta, abs=bound)
    assert touch == pytest.approx(time, abs=bound / abs(speed))
    # theta'' = 3 g cos(theta)/(2 L)
    allowed = 1.5 * 9.8 / 0.3 * bound / abs(speed)
    assert history["theta_dot"].values[before] == pytest.approx(speed, abs=allowed)
