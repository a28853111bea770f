"""A slope with ends: a block slides off, falls past, comes back and strikes again, in every scheme."""

from __future__ import annotations

from math import cos, pi, sin, sqrt

import numpy as np
import pytest

from oblique_impact import simulate_system
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.impacts import NewtonImpact
from oblique_impact.contact.state import Baumgarte
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.validation.small_systems import Particle
from tests.small.systems import GRAVITY, RIGID, SCHEMES, completed, kinds_of, last, scheme_of
from tests.systems import Block

STEP = 1e-3
#: what a scheme may be away in time (s): a fixed step notices up to a step late, generalized-alpha is second order
LATE = {"event": 1e-9, "fixed-step": 1.01 * STEP, "generalized-alpha": 5e-6}


def scheme(name):
    return scheme_of(name, STEP)


@pytest.mark.parametrize("name", RIGID)
@pytest.mark.parametrize("mu", [0.0, 0.2])
def test_a_block_slides_off_the_end_and_falls_freely(name, mu):
    """From x = 0 at v to the end at -L, L = v t + a t^2/2, a = g (sin(alpha) - mu cos(alpha)), then it falls"""
    alpha, way, end, start = pi / 6, 0.5, 0.6, 0.5
    push, pull = GRAVITY * cos(alpha), GRAVITY * sin(alpha)
    acceleration = pull - mu * push
    speed = sqrt(start**2 + 2.0 * way * acceleration)
    leaves = (speed - start) / acceleration
    history = completed(
        simulate_system(
            Particle(above=-GRAVITY * np.cos(alpha), along=-GRAVITY * np.sin(alpha)),
            np.zeros(2),
            np.array([-start, 0.0]),
            end,
            friction=Coulomb(mu, mu),
            scheme=scheme(name),
            extent=(-way, 2.0),
            output_interval=0.01,
        )
    )
    assert kinds_of(history)[-1] == "release"
    (passed,) = history.summary["slope_ends"]
    assert history.events[-1].time == passed["time"] == pytest.approx(leaves, abs=LATE[name] + 1e-8)
    assert (passed["how"], passed["end"]) == ("slides off", -way)
    assert passed["place"] == pytest.approx(-way, abs=speed * LATE[name])
    flies = end - leaves
    late = LATE[name] * (push + acceleration) * end + 1e-8
    assert last(history, "gap") == pytest.approx(-0.5 * push * flies**2, abs=late)
    assert last(history, "slip") == pytest.approx(-way - speed * flies - 0.5 * pull * flies**2, abs=late)
    after = history["time"].values > passed["time"]
    assert np.all(history["lambda_n"].values[after] == 0.0)
    assert np.all(history["state"].values[after] == 0)
    energy = history.summary["energy"]
    assert energy["lost_friction"] == pytest.approx(mu * push * way, abs=2e-2 * mu * push * way + 1e-9)
    assert abs(energy["unaccounted"]) < 1e-8


W = 4.0  # rad/s, of a mass that swings through the line of the slope
QUARTER = 0.5 * pi / W


def swing(name, start, first, restitution, end):
    """Run y'' = -w^2 y from (0, start) at x' = 1 over a slope from `first` to 2 m."""
    system = Block(lambda t, q, qd: (0.0, -W * W * q[1]))
    q0, qd0, impact = np.array([0.0, start]), np.array([1.0, 0.0]), NewtonImpact(restitution)
    return completed(
        simulate_system(
            system, q0, qd0, end, impact_law=impact, scheme=scheme(name), extent=(first, 2.0), output_interval=0.05
        )
    )


@pytest.mark.parametrize("name", RIGID)
def test_it_falls_past_beyond_an_end_comes_back_and_strikes_again_from_above(name):
    """y = cos(w t), x = t: it crosses y = 0 after one and three quarters of a period, then hits the slope."""
    end = 5.7 * QUARTER
    history, late = swing(name, 1.0, 3.5 * QUARTER, 1.0, end), LATE[name] + 1e-8
    ends = history.summary["slope_ends"]
    assert [passed["how"] for passed in ends] == ["falls past", "comes back"]
    assert [passed["time"] for passed in ends] == pytest.approx([QUARTER, 3 * QUARTER], abs=W * late)
    assert [passed["place"] for passed in ends] == pytest.approx([QUARTER, 3 * QUARTER], abs=W * late)
    assert kinds_of(history) == ["rebound"]
    assert history.events[0].time == pytest.approx(5 * QUARTER, abs=W * late)
    assert history.events[0].normal_impulse == pytest.approx(2.0 * W, rel=1e-4)
    assert last(history, "gap") == pytest.approx(abs(cos(W * end)), abs=4.0 * W * late)


@pytest.mark.parametrize("name", RIGID)
def test_a_start_on_the_line_beyond_an_end_falls_past_at_once(name):
    history = swing(name, 0.0, 1.0, 0.0, 0.5 * QUARTER)
    (passed,) = history.summary["slope_ends"]
    assert (passed["how"], passed["time"]) == ("falls past", 0.0)
    assert kinds_of(history) == []


@pytest.mark.parametrize("name", SCHEMES)
def test_what_an_elastic_stop_stores_at_its_end_is_lost_with_the_contact(name):
    """A block at rest in its stop, pushed along: at the end the spring lets go of (m g)^2/(2 k)."""
    stiffness, way, speed = 1e4, 0.3, 2.0
    depth = GRAVITY / stiffness
    history = completed(
        simulate_system(
            Particle(above=-GRAVITY),
            np.array([0.0, -depth]),
            np.array([speed, 0.0]),
            0.3,
            scheme=scheme(name),
            contact_law=ElasticStop(stiffness),
            extent=(-1.0, way),
            output_interval=0.01,
            baumgarte=Baumgarte(0.0, 0.0),
        )
    )
    (passed,) = history.summary["slope_ends"]
    assert passed["time"] == pytest.approx(way / speed, abs=LATE[name])
    energy = history.summary["energy"]
    assert energy["lost_damping"] == pytest.approx(0.5 * stiffness * depth**2, rel=1e-3)
    assert abs(energy["unaccounted"]) < 1e-9
    assert last(history, "gap_rate") == pytest.approx(
        -GRAVITY * (0.3 - way / speed), abs=GRAVITY * LATE[name] + 1e-4
    )
