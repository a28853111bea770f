"""Item 4: a beam so stiff that it is a rigid pinned bar falling on the slope."""

from __future__ import annotations

from functools import cache
from math import asin, cos, cosh, pi, sin, sinh, sqrt

import numpy as np
import pytest
from scipy.special import ellipk, ellipkinc

from oblique_impact import History, Scenario, simulate
from oblique_impact.contact.transitions import EventKind
from validation.reference_values import VALUES

RIGID = VALUES["4"]
SCALES = [1.0, 1e2, 1e4, 1e6]


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


def at_first_impact(history: History) -> dict[str, float]:
    """The left values at the first event."""
    event = history.events[0]
    assert event.kind is EventKind.IMPACT
    index = int(np.flatnonzero(history["time"].values == event.time)[0])
    names = ("time", "theta", "theta_dot", "tip_x", "tip_y", "slip", "gap_rate", "slip_rate")
    return {name: float(history[name].values[index]) for name in names}


@cache
def touch_of(scenario: Scenario) -> dict[str, float]:
    """The first impact of a scenario, computed once."""
    return at_first_impact(simulate(scenario))


def stiff_bar(scale: float, frame: str = "mean-axis") -> Scenario:
    """The paper's beam with one mode and a scaled Young's modulus."""
    paper = Scenario.builtin("paper")
    return paper.replace(
        beam__youngs_modulus=scale * paper.beam.youngs_modulus,
        discretization__frame=frame,
        discretization__modes=1,
        contact__friction="frictionless",
        end_time=0.3175,
    )


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


@pytest.mark.parametrize("scale", SCALES)
def test_first_touch_tends_to_the_rigid_bar(scale):
    """The tip is off by a vibration of bounded size, so angle and time are off by that over L and v_tip."""
    scenario = stiff_bar(scale)
    bound, touch = tip_bound(scenario), touch_of(scenario)
    tolerance = 1e-11  # of the marching
    assert touch["theta"] == pytest.approx(RIGID["theta_f"], abs=bound + tolerance)
    assert touch["time"] == pytest.approx(RIGID["t"], abs=bound / RIGID["v_tip"] + tolerance)
    # theta'' is 14.34 rad/s^2 at the end (item 4)
    allowed = 14.35 * bound / RIGID["v_tip"] + 100 * tolerance
    assert touch["theta_dot"] == pytest.approx(RIGID["omega"], abs=allowed)


@pytest.mark.parametrize("frame", ["mean-axis", "tangent"])
def test_the_error_falls_with_the_stiffness(frame):
    errors = []
    for scale in SCALES:
        touch = touch_of(stiff_bar(scale, frame))
        errors.append(abs(touch["time"] - RIGID["t"]))
    # 1/E, times a phase of the vibration that is anywhere between 0 and 2
    assert np.all(np.diff(np.log10(errors)) < -1.0), errors
    assert errors[-1] < 1e-4 * errors[0]


@pytest.mark.parametrize("frame", ["mean-axis", "tangent"])
def test_place_and_velocities_of_the_first_touch(frame):
    scenario = stiff_bar(1e6, frame)
    touch, bound = touch_of(scenario), tip_bound(scenario)
    assert touch["tip_x"] == pytest.approx(RIGID["point"][0], abs=1e-11)
    assert touch["tip_y"] == pytest.approx(RIGID["point"][1], abs=1e-11)
    assert touch["slip"] == pytest.approx(RIGID["dist_along_slope"], abs=1e-11)
    # the tip vibrates with omega = b^2 sqrt(EI/(m L^4)): its velocity is off by that times the bound
    beam = scenario.beam
    rate = VALUES["1.2"][0] ** 2 * sqrt(beam.youngs_modulus * beam.second_moment / (beam.density * beam.area))
    assert touch["gap_rate"] == pytest.approx(-RIGID["v_n"], abs=rate * bound)
    assert touch["slip_rate"] == pytest.approx(RIGID["v_t"], abs=rate * bound)


def test_built_in_rigid_limit():
    scenario = Scenario.builtin("rigid-limit")
    time, theta, speed = first_touch(scenario)
    touch, bound = touch_of(scenario), tip_bound(scenario) / scenario.beam.length
    assert bound < 1e-6
    assert touch["theta"] == pytest.approx(theta, abs=bound)
    assert touch["time"] == pytest.approx(time, abs=bound / abs(speed))
    # theta'' = 3 g cos(theta)/(2 L)
    assert touch["theta_dot"] == pytest.approx(speed, abs=1.5 * 9.8 / 0.3 * bound / abs(speed))
