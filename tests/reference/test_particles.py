"""Items 6a, 6b, 6c, 6e, 6g: a point mass on an incline, a belt and a spring, and a bouncing ball."""

from __future__ import annotations

from math import ceil, cos, log, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from oblique_impact import History, Outcome, simulate_system
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.impacts import NewtonImpact
from oblique_impact.contact.state import State
from oblique_impact.contact.transitions import EventKind
from validation.reference_values import VALUES
from validation.small_systems import Particle, events_of, samples_at

GRAVITY, SLOPE = 9.8, pi / 10
INCLINE = Particle(above=-GRAVITY * cos(SLOPE), along=-GRAVITY * sin(SLOPE))
REST = np.zeros(2)


def slide(
    system: Particle, along: float, speed: float, end_time: float, friction: Coulomb, **options: Any
) -> History:
    """Start on the plane at `along` with `speed`; the energy balance must close."""
    history = simulate_system(
        system, np.array([along, 0.0]), np.array([speed, 0.0]), end_time, friction=friction, **options
    )
    assert history.outcome is Outcome.COMPLETED
    assert abs(history.summary["energy"]["unaccounted"]) < 1e-11
    return history


@pytest.mark.parametrize(("excess", "state"), [(-1e-12, State.SLIP), (1e-12, State.STICK)])
def test_a_particle_sticks_to_the_incline_from_the_angle_of_friction_on(excess, state):
    """Item 6a: it stays iff mu_s >= tan(alpha)."""
    static = VALUES["6a"]["tan"] * (1.0 + excess)
    history = slide(INCLINE, 0.0, 0.0, 0.1, Coulomb(static, 0.2))
    assert np.all(history["state"].values[1:] == state)
    assert (history["q"].values[-1, 0] == 0.0) == (state is State.STICK)


def test_a_particle_slides_down_the_incline():
    """Item 6a: acceleration g (sin - mu cos), time for half a metre."""
    history = slide(INCLINE, 0.0, 0.0, VALUES["6a"]["t_05m"], Coulomb(0.2, 0.2))
    time, position, speed = history["time"].values, history["q"].values[:, 0], history["qd"].values[:, 0]
    assert position[-1] == pytest.approx(-0.5, rel=1e-11)
    np.testing.assert_allclose(speed, -VALUES["6a"]["a_mu02"] * time, atol=1e-11)


@pytest.mark.parametrize(("mu", "key"), [(0.2, "mu02"), (0.4, "mu04")])
def test_a_particle_is_thrown_up_the_incline(mu, key):
    """Item 6b: where it stops, and whether and how fast it comes back."""
    expected = VALUES["6b"][key]
    history = slide(INCLINE, 0.0, 2.0, VALUES["6b"]["mu02"]["t_total"], Coulomb(mu, mu))
    turning = events_of(history, EventKind.REVERSAL if expected["slides_back"] else EventKind.STICK)
    assert len(turning) == 1
    assert turning[0].time == pytest.approx(expected["t_stop"], rel=1e-11)
    assert samples_at(history, turning[0].time)[0][0] == pytest.approx(expected["d"], rel=1e-11)
    position, speed = history["q"].values[-1, 0], history["qd"].values[-1, 0]
    if expected["slides_back"]:
        assert (position, speed) == pytest.approx((0.0, -expected["v_return"]), abs=1e-11)
    else:
        assert (position, speed) == pytest.approx((expected["d"], 0.0), abs=1e-11)


def test_a_particle_on_a_belt_sticks_and_slips():
    """Item 6c: the limit cycle of a mass on a spring and a belt."""
    belt = Particle(above=-GRAVITY, stiffness=100.0, belt_speed=0.05)
    history = slide(belt, 0.0, belt.belt_speed, 4.0, Coulomb(0.4, 0.3), output_interval=1e-3)
    sticks = [event.time for event in events_of(history, EventKind.STICK)]
    slips = [event.time for event in events_of(history, EventKind.SLIP)]
    assert len(slips) == 5
    assert len(history.events) == 1 + len(slips) + len(sticks)  # and the touch at the start
    expected = VALUES["6c"]
    np.testing.assert_allclose(np.array(sticks) - slips[: len(sticks)], expected["t_slip"], rtol=1e-11)
    np.testing.assert_allclose(np.array(slips[1:]) - sticks[: len(slips) - 1], expected["t_stick"], rtol=1e-11)
    np.testing.assert_allclose(np.diff(slips), expected["period"], rtol=1e-11)
    time, first = np.unique(history["time"].values, return_index=True)
    q, qd = history["q"].values[first, 0], history["qd"].values[first, 0]
    cycle = (time >= slips[1]) & (time <= sticks[1])
    path = CubicHermiteSpline(time[cycle], q[cycle], qd[cycle])
    ends = path(path.derivative().roots(extrapolate=False))
    # between samples dt apart the cubic errs by (w dt)^4/384 of the amplitude, a parabola's top by less
    assert (ends.min(), ends.max()) == pytest.approx((expected["x_min"], expected["x_max"]), abs=1e-11)
    speed = CubicHermiteSpline(time[cycle], qd[cycle], 0.3 * GRAVITY - 100.0 * q[cycle])
    assert speed(speed.derivative().roots(extrapolate=False)).min() == pytest.approx(expected["v_min"], abs=1e-11)


@pytest.mark.parametrize(("restitution", "key"), [(0.5, "e05"), (0.8, "e08")])
@pytest.mark.parametrize("gap", [1e-12, 1e-18])
def test_a_bouncing_ball_comes_to_rest(restitution, key, gap):
    """Item 6e: infinitely many bounces in finite time."""
    ball, height = Particle(above=-GRAVITY), np.array([0.0, 1.0])
    end = 5.0
    history = simulate_system(ball, height, REST, end, impact=NewtonImpact(restitution), gap_tolerance=gap)
    assert history.outcome is Outcome.COMPLETED
    bounces, last = history.events[:-1], history.events[-1]
    assert {event.kind for event in bounces} == {EventKind.REBOUND}
    assert last.kind is EventKind.IMPACT
    # bounces lower than four gap tolerances are taken as the end: a finite number, and a bound of the time left
    assert len(bounces) == ceil(log(4.0 * gap) / (2.0 * log(restitution))) - 1
    assert bounces[0].time == pytest.approx(VALUES["6e"]["first"], rel=1e-11)
    left = 2.0 * sqrt(2.0 * 4.0 * gap / GRAVITY) / (1.0 - restitution)
    rounding = 1e-11
    assert -rounding < VALUES["6e"][key] - last.time < left + rounding
    risen = sum((restitution * event.normal_velocity) ** 2 / (2.0 * GRAVITY) for event in bounces)
    flown = 8.0 * gap / (1.0 - restitution**2)  # the way left, by the same bound
    assert -rounding < VALUES["6e"][f"dist_{key}"] - (1.0 + 2.0 * risen) < flown + rounding
    # then it lies on the ground
    resting = history["time"].values > last.time
    assert resting.sum() > 50
    assert np.all(history["state"].values[resting] != State.FREE)
    np.testing.assert_allclose(history["lambda_n"].values[resting], GRAVITY, rtol=1e-12)
    np.testing.assert_allclose(history["q"].values[resting, 1], 0.0, atol=1e-12)
    assert history.summary["energy"]["lost_impact"] == pytest.approx(GRAVITY, rel=1e-11)


def test_a_mass_on_a_spring_is_stopped_by_dry_friction():
    """Item 6g, VPCS SDND100: the amplitude falls by 2 mu m g/k each half period."""
    system, expected = Particle(above=-10.0, stiffness=1e4), VALUES["6g"]
    history = slide(system, 0.85e-3, 0.0, 0.2, Coulomb(0.1, 0.1))
    turning = history.events[1:]
    kinds = [EventKind.REVERSAL] * 3 + [EventKind.STICK]
    assert [event.kind for event in turning] == kinds
    # the speed, good to 1e-13 m/s, vanishes at k u = 15 m/s^2 and less towards the end
    np.testing.assert_allclose([event.time for event in turning], np.arange(1, 5) * pi / 100, rtol=1e-9)
    places = [samples_at(history, event.time)[0][0] for event in turning]
    np.testing.assert_allclose(places, expected, rtol=0.0, atol=1e-13)
    assert history["q"].values[-1, 0] == pytest.approx(expected[-1], abs=1e-13)
    # what friction took is mu m g times the path
    path = np.abs(np.diff([0.85e-3, *expected])).sum()
    assert history.summary["energy"]["lost_friction"] == pytest.approx(0.1 * 10.0 * path, rel=1e-9)
