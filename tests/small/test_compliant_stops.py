"""A mass on stops of each kind: closed forms of springs and their damping, in every scheme."""

from __future__ import annotations

from math import log, sqrt

import numpy as np
import pytest
from scipy.optimize import brentq

from oblique_impact import simulate_system
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.history.history import History
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.fixed_step import FixedStepScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.marching.scheme import Scheme
from oblique_impact.marching.time_stepping import TimeSteppingScheme
from oblique_impact.validation.small_systems import Particle

MASS, STIFFNESS, SPEED = 2.0, 5e3, 3.0  # kg, N/m, m/s
DASHPOT, HUNT_CROSSLEY = 40.0, 0.1  # N s/m, s/m


def scheme_of(name: str, step: float) -> Scheme:
    """Return a scheme with one step (s) in flight and in contact."""
    return {
        "event": EventScheme(1e-11),
        "fixed-step": FixedStepScheme(step, step),
        "generalized-alpha": GeneralizedAlphaScheme(step, step, 1.0, 1.0, 1e-12),
        "time-stepping": TimeSteppingScheme(step, step, 1.0, 1e-12),
    }[name]


def strike(stop: ElasticStop, scheme: Scheme) -> History:
    """Let a mass strike a stop without gravity, from 4 mm above it."""
    ball = Particle(above=0.0, mass=MASS)
    start = np.array([0.0, 4e-3]), np.array([0.0, -SPEED])
    return simulate_system(ball, *start, 0.1, contact_law=stop, scheme=scheme, output_interval=1e-2)


def rebound_from_a_dashpot() -> float:
    """Speed (m/s) at which k d + c d' is zero: d = (v/w) exp(-a t) sin w t with a = c/2m."""
    a = 0.5 * DASHPOT / MASS
    w = sqrt(STIFFNESS / MASS - a * a)
    depth = lambda t: SPEED / w * np.exp(-a * t) * np.sin(w * t)  # noqa: E731
    rate = lambda t: SPEED * np.exp(-a * t) * (np.cos(w * t) - a / w * np.sin(w * t))  # noqa: E731
    end = brentq(lambda t: STIFFNESS * depth(t) + DASHPOT * rate(t), 0.5 * np.pi / w, np.pi / w, xtol=1e-15)
    return -float(rate(end))


def rebound_of_hunt_and_crossley() -> float:
    """Speed (m/s) at which v/a - ln(1 + a v)/a^2 is what it was (Hunt and Crossley 1975)."""
    a = HUNT_CROSSLEY
    integral = lambda v: v / a - log(1.0 + a * v) / a**2  # noqa: E731
    return float(brentq(lambda v: integral(-v) - integral(SPEED), 0.0, SPEED, xtol=1e-15))


STOPS = {
    "spring": (ElasticStop(STIFFNESS), SPEED),
    "dashpot": (ElasticStop(STIFFNESS, 0.0, DASHPOT), rebound_from_a_dashpot()),
    "Hunt and Crossley": (ElasticStop(STIFFNESS, HUNT_CROSSLEY), rebound_of_hunt_and_crossley()),
}


@pytest.mark.parametrize("name", STOPS)
def test_a_mass_rebounds_as_the_closed_form_says(name):
    """Located; where the dashpot lets go the force has a kink in the middle of the contact."""
    stop, exact = STOPS[name]
    found = strike(stop, scheme_of("event", 0.0))
    assert float(found["qd"].values[-1, 1]) == pytest.approx(exact, rel=1e-9)
    lost = 0.5 * MASS * (SPEED**2 - exact**2)
    assert found.balance["lost_damping"] == pytest.approx(lost, abs=1e-8)
    assert abs(found.balance["unaccounted"]) < 1e-9
    assert found["lambda_n"].values.min() >= 0.0
    (contact,) = found.contacts
    assert contact.normal_impulse == pytest.approx(MASS * (SPEED + exact), rel=1e-9)


# fixed steps find a contact late, by any part of a step
ORDERS = [("fixed-step", 0.5), ("generalized-alpha", 1.5), ("time-stepping", 1.5)]


@pytest.mark.parametrize(("scheme", "order"), ORDERS)
@pytest.mark.parametrize("name", STOPS)
def test_steps_come_to_the_closed_form_with_their_order(name, scheme, order):
    """Errors of the speed over five halvings of the step; energy is accounted for."""
    stop, exact = STOPS[name]
    steps = 3e-4 / 2.0 ** np.arange(6)
    errors = []
    for step in steps:
        found = strike(stop, scheme_of(scheme, step))
        errors.append(abs(float(found["qd"].values[-1, 1]) - exact))
        assert found["lambda_n"].values.min() >= 0.0
    # one step of a contact may fall anywhere: the order is that of the line through the errors
    slope = np.polyfit(np.log(steps), np.log(np.maximum(errors, 1e-13)), 1)[0]
    assert slope > order or max(errors) < 1e-10
    assert errors[-1] < 2e-4 * SPEED
    assert abs(found.balance["unaccounted"]) < 1e-5 * SPEED**2


@pytest.mark.parametrize("stiffness", [1e4, 1e8, 1e12, 1e20])
def test_time_stepping_takes_stops_of_any_stiffness_and_gives_no_energy(stiffness):
    """A stop that the step does not resolve is plastic or nearly so; one that it resolves gives all back."""
    found = strike(ElasticStop(stiffness), scheme_of("time-stepping", 1e-4))
    speed = float(found["qd"].values[-1, 1])
    assert -1e-9 < speed < SPEED * (1.0 + 1e-6)
    if stiffness == 1e4:
        assert speed == pytest.approx(SPEED, rel=1e-4)
    assert found.balance["lost_scheme"] > -1e-6
    assert abs(found.balance["unaccounted"]) < 1e-9
    assert found["gap"].values.min() > -SPEED * (sqrt(MASS / stiffness) + 2e-4)
