"""Particles, a belt and a rod against closed forms: every scheme, every friction model, every scale.

How far a scheme may be away follows from its order and its step h, with the data of each problem:

* event: a few times its tolerance;
* fixed-step: what is judged at the end of a step is noticed up to h late, once per event;
* generalized-alpha: second order; its ground is elastic, and pressed in where something lies on it from the start.
"""

from __future__ import annotations

from math import atan, cos, log2, pi, sin, sqrt
from typing import Any, NamedTuple

import numpy as np
import pytest

from oblique_impact import History, simulate_system
from oblique_impact.contact.friction import Coulomb, FrictionCurve, Frictionless
from oblique_impact.contact.impacts import NewtonImpact
from oblique_impact.contact.state import State
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.validation.small_systems import FreeRod, Particle
from tests.small.systems import (
    EVENT_ERROR,
    FRICTIONLESS,
    GRAVITY,
    HOLDING_CURVE,
    MODIFIED,
    RIGID,
    SCHEMES,
    UNSCALED,
    YIELDING_CURVE,
    Law,
    Scale,
    completed,
    coulomb,
    ground_of,
    just_after,
    kinds_of,
    last,
    scheme_of,
    slide,
    times_of,
)

LAWS = {
    "frictionless": FRICTIONLESS,
    "coulomb-0.2": coulomb(0.2),
    "coulomb-0.4": coulomb(0.4),
    "modified-coulomb": MODIFIED,
    "curve-that-holds": HOLDING_CURVE,
    "curve-that-yields": YIELDING_CURVE,
}


def bound(scheme: str, fixed_step: float, generalized_alpha: float = 0.0) -> float:
    """Return what a scheme may be away from the closed form, never less than the event scheme may."""
    of = {"event": 0.0, "fixed-step": fixed_step, "generalized-alpha": generalized_alpha}
    return EVENT_ERROR + of[scheme]


# --- a particle on an incline ----------------------------------------------------------------------------------

INCLINE, THROW, SLIDING_TIME, SLIDING_STEP = pi / 10, 2.0, 0.8, 5e-3
GROUND = 1e4  # N/m, of ground that is not rigid


def thrown_up(scheme: str, law: Law, scale: Scale = UNSCALED, step: float = SLIDING_STEP) -> History:
    """Run a particle that is thrown up the incline; all of the problem is scaled."""
    particle = Particle(
        above=-GRAVITY * cos(INCLINE) * scale.acceleration,
        along=-GRAVITY * sin(INCLINE) * scale.acceleration,
        mass=scale.mass,
    )
    ground = ground_of(scheme, GRAVITY * cos(INCLINE) * scale.force, GROUND * scale.stiffness)
    return simulate_system(
        particle,
        np.array([0.0, ground.gap]),
        np.array([THROW * scale.speed, 0.0]),
        SLIDING_TIME * scale.time,
        friction=law.make(scale),
        contact_law=ground.contact_law,
        scheme=scheme_of(scheme, step * scale.time),
        output_interval=0.1 * scale.time,
    )


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("law", LAWS)
def test_a_particle_thrown_up_an_incline_turns_and_comes_back_or_stays(law, scheme):
    """v' = -g sin(alpha) - mu(|v|) sign(v) g cos(alpha), x(0) = 0, v(0) = 2 m/s, alpha = pi/10, for 0.8 s.

    Way, speed and turns by SciPy (`systems.slide`).  It stays where v vanishes if mu_s >= tan(alpha) = 0.325, and
    comes back otherwise.
    """
    chosen, h, end = LAWS[law], SLIDING_STEP, SLIDING_TIME
    normal, drive = GRAVITY * cos(INCLINE), -GRAVITY * sin(INCLINE)
    exact = slide(end, THROW, drive, normal, chosen)
    history = completed(thrown_up(scheme, chosen))
    stays = chosen.static is not None and chosen.static >= np.tan(INCLINE)
    turning = [] if law == "frictionless" else ["stick" if stays else "reversal"]
    assert kinds_of(history) == turning
    if stays:  # at once, also where the end of a step is past its stop
        assert abs(just_after(history, "slip_rate", times_of(history)[0])) <= EVENT_ERROR
    # fixed-step: a force that jumps by `jump`, or bends, acts up to h too long at each of up to four kinks
    rate, pull = chosen.steepest * normal, abs(drive) + chosen.at(0.5) * normal
    late = (chosen.jump * normal + abs(drive) * (chosen.static is not None)) * h + 4.0 * rate * pull * h**2
    # generalized-alpha: (rate h)^2 of the speed per unit of rate * time, and per branch
    second = h**2 * (5.0 * pull + rate * THROW * (5.0 + rate * end))
    assert times_of(history) == pytest.approx(exact.turns if turning else [], abs=bound(scheme, h, second / pull))
    assert last(history, "slip") == pytest.approx(exact.way, abs=bound(scheme, late * end, second))
    assert last(history, "slip_rate") == pytest.approx(
        exact.speed, abs=bound(scheme, late, h**2 * rate * (5.0 * pull + rate * THROW * end))
    )
    assert np.abs(history["gap"].values - ground_of(scheme, normal, GROUND).gap).max() <= EVENT_ERROR
    assert last(history, "lambda_n") == pytest.approx(normal, rel=1e-9)
    assert abs(history.summary["energy"]["unaccounted"]) <= bound(scheme, late * THROW, second * pull)


# --- a ball ----------------------------------------------------------------------------------------------------

DROP = 0.2  # m
FALL = sqrt(2.0 * DROP / GRAVITY)
LANDING_SPEED = GRAVITY * FALL


def dropped(
    scheme: str, step: float, end: float, speed: float = 0.0, scale: Scale = UNSCALED, **options: Any
) -> History:
    """Run a ball that falls from `DROP`, thrown along with a speed."""
    return simulate_system(
        Particle(above=-GRAVITY * scale.acceleration, mass=scale.mass),
        np.array([0.0, DROP * scale.length]),
        np.array([speed * scale.speed, 0.0]),
        end * scale.time,
        scheme=scheme_of(scheme, step * scale.time),
        output_interval=0.05 * scale.time,
        **options,
    )


@pytest.mark.parametrize("scheme", RIGID)
@pytest.mark.parametrize("friction", [Frictionless(), Coulomb(0.3, 0.3)], ids=["frictionless", "coulomb"])
def test_a_ball_bounces_half_as_fast_each_time_and_comes_to_rest(friction, scheme):
    """e = 0.5 from 0.2 m: landings at t0 (1 + 2 (e + e^2 + ... + e^k)), t0 = sqrt(2 h/g), and rest at 3 t0.

    Restitution acts on the normal velocity alone; without motion along the ground friction changes nothing.
    """
    h, end = 2e-3, 1.0
    history = completed(dropped(scheme, h, end, impact_law=NewtonImpact(0.5), friction=friction))
    kinds, times = kinds_of(history), times_of(history)
    assert kinds == ["rebound"] * (len(kinds) - 1) + ["impact"]
    exact = FALL * (1.0 + 2.0 * np.cumsum(0.5 ** np.arange(4)) - 2.0)
    # fixed-step: each landing is noticed up to h late, and a flight that begins as deep as that is 2 h shorter
    early, rest = 3.0 * h * np.arange(1, 5), 3.0 * h * len(kinds)
    assert np.all(np.abs(times[:4] - exact) <= [bound(scheme, e) for e in early])
    for k, event in enumerate(history.events[:3]):
        speed = 0.5**k * LANDING_SPEED
        assert -event.normal_velocity == pytest.approx(speed, abs=bound(scheme, GRAVITY * early[k]))
    # the smallest bounce that a step resolves lasts h; the event scheme goes on to far smaller ones
    lowest = 4.0 * EVENT_ERROR  # m, a bounce that need not be told from rest
    unresolved = {"event": 4.0 * sqrt(2.0 * lowest / GRAVITY), "fixed-step": rest}
    assert times[-1] == pytest.approx(3.0 * FALL, abs=unresolved[scheme])
    most = log2(LANDING_SPEED / (GRAVITY * h)) + 6.0 if scheme == "fixed-step" else 60.0
    assert len(kinds) <= most
    assert int(last(history, "state")) != State.FREE
    assert last(history, "lambda_n") == pytest.approx(GRAVITY, rel=1e-6)
    # a bounce of speed v is closed for good when e v can no longer lift the ball out of the depth v h
    assert abs(last(history, "gap")) <= bound(scheme, 8.0 * GRAVITY * h**2)
    assert history.summary["energy"]["lost_impact"] == pytest.approx(
        GRAVITY * DROP, abs=bound(scheme, 2.0 * GRAVITY * LANDING_SPEED * h)
    )


STIFFNESS, CONTACT_RATE = 400.0, 20.0  # N/m for 1 kg, rad/s
CONTACT_TIME = 2.0 / CONTACT_RATE * (pi - atan(CONTACT_RATE * LANDING_SPEED / GRAVITY))


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize(
    "law", ["frictionless", "coulomb-0.4", "modified-coulomb", "curve-that-holds", "curve-that-yields"]
)
def test_a_ball_leaves_an_elastic_stop_as_fast_as_it_came(law, scheme):
    """m y'' = -m g - k y below y = 0, from 0.2 m: contact lasts 2/w (pi - atan(w v/g)), w^2 = k/m, then y' = v.

    Friction takes mu(|x'|) of the normal impulse, 2 m v + m g t_c.  With x' = 4 m/s it slides all the time, and
    dx'/dI = -mu(x')/m is linear between the points of the law.
    """
    chosen, h = LAWS[law], 1e-3
    end = FALL + CONTACT_TIME + 0.05
    history = completed(
        dropped(scheme, h, end, 4.0, friction=chosen.make(UNSCALED), contact_law=ElasticStop(STIFFNESS))
    )
    assert kinds_of(history) == ["impact", "release"]
    impulse = 2.0 * LANDING_SPEED + GRAVITY * CONTACT_TIME
    along = slide(impulse, 4.0, 0.0, 1.0, chosen).speed
    wh, v = CONTACT_RATE * h, LANDING_SPEED
    # fixed-step misses up to k v h^2/2 of the impulse and is up to h late; generalized-alpha: (w h)^2
    early, late = times_of(history)
    assert early == pytest.approx(FALL, abs=bound(scheme, h, h**2))
    assert late == pytest.approx(FALL + CONTACT_TIME, abs=bound(scheme, 2.0 * h, CONTACT_TIME * wh**2))
    speed = v - GRAVITY * 0.05
    assert last(history, "gap_rate") == pytest.approx(speed, abs=bound(scheme, v * wh, v * wh**2))
    assert last(history, "slip_rate") == pytest.approx(along, abs=bound(scheme, v * wh, v * wh**2))
    assert history.contacts[0].normal_impulse == pytest.approx(impulse, abs=bound(scheme, 2 * v * wh, v * wh**2))
    depth = GRAVITY / CONTACT_RATE**2 + sqrt((GRAVITY / CONTACT_RATE**2) ** 2 + (v / CONTACT_RATE) ** 2)
    peak = history.contacts[0].peak_force
    # of samples h apart the largest force falls short of the peak by up to (w h)^2/8 of it
    assert peak == pytest.approx(STIFFNESS * depth, rel=wh**2 / 8.0 + bound(scheme, wh, wh**2))


def test_the_peak_of_a_feather_is_its_weight():
    """A particle of a milligram that lies on a rigid plane presses on it by 9.8e-6 N."""
    feather = Particle(above=-GRAVITY, mass=1e-6)
    history = completed(simulate_system(feather, np.zeros(2), np.zeros(2), 0.1, friction=Frictionless()))
    assert history.contacts[0].peak_force == pytest.approx(1e-6 * GRAVITY, rel=1e-9)


# --- a mass on a belt ------------------------------------------------------------------------------------------

BELT, SPRING, RATE = 0.2, 100.0, 10.0  # m/s, N/m, rad/s for 1 kg
RIDING_LAWS = {
    "coulomb": lambda scale: Coulomb(0.4, 0.3),
    "curve": lambda scale: FrictionCurve(((0.0, 0.3),), 0.4),
}
EXCESS = 0.1 * GRAVITY / SPRING  # (mu_s - mu_k) m g/k
FIRST_SLIP = 0.4 * GRAVITY / (SPRING * BELT)
SLIP_TIME, STICK_TIME = 2.0 / RATE * (pi - atan(EXCESS * RATE / BELT)), 2.0 * EXCESS / BELT


def ridden(
    scheme: str, friction: Any, start: tuple[float, float], step: float, scale: Scale = UNSCALED, end: float = 1.0
) -> History:
    """Run a mass on a spring that a belt carries along."""
    belt = Particle(
        above=-GRAVITY * scale.acceleration,
        stiffness=SPRING * scale.stiffness,
        belt_speed=BELT * scale.speed,
        mass=scale.mass,
    )
    ground = ground_of(scheme, GRAVITY * scale.force, GROUND * scale.stiffness)
    return simulate_system(
        belt,
        np.array([start[0] * scale.length, ground.gap]),
        np.array([start[1] * scale.speed, 0.0]),
        end * scale.time,
        friction=friction,
        contact_law=ground.contact_law,
        scheme=scheme_of(scheme, step * scale.time),
        output_interval=0.1 * scale.time,
    )


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("law", RIDING_LAWS)
def test_a_mass_on_a_belt_sticks_and_slips_in_a_limit_cycle(law, scheme):
    """m x'' = -k x + lambda_tau on a belt at V = 0.2 m/s, mu_s = 0.4, mu_k = 0.3; it starts with the belt.

    Exact: slips at mu_s m g/(k V), for 2/w (pi - atan(D w/V)), sticks for 2 D/V, D = (mu_s - mu_k) m g/k.
    """
    h = 2.5e-3
    history = completed(ridden(scheme, RIDING_LAWS[law](UNSCALED), (0.0, BELT), h))
    exact = FIRST_SLIP + np.array([0.0, SLIP_TIME, SLIP_TIME + STICK_TIME])
    assert kinds_of(history) == ["slip", "stick", "slip"]
    # fixed-step: an event is noticed up to h late, and a slip that begins late sticks for so much longer
    # generalized-alpha: (w h)^2 of each phase, and V D (w h)^2 over V^2
    second = 2.0 * (RATE * h) ** 2 * (SLIP_TIME + EXCESS / BELT)
    for k, found in enumerate(times_of(history)):
        assert found == pytest.approx(exact[k], abs=bound(scheme, (1.0 + k) * h, second))
    tau = 1.0 - exact[-1]
    place = 0.3 * GRAVITY / SPRING + EXCESS * cos(RATE * tau) + BELT / RATE * sin(RATE * tau)
    assert last(history, "q")[0] == pytest.approx(place, abs=BELT * bound(scheme, 4.0 * h, 2.0 * second))


# --- time-stepping, which finds changes of slip to a step ------------------------------------------------------


@pytest.mark.parametrize("law", ["coulomb-0.2", "coulomb-0.4", "modified-coulomb", "curve-that-yields"])
def test_time_stepping_slides_up_an_incline_and_back_or_stays_to_first_order(law):
    """A reversal may stick for a step."""
    chosen, steps, ways = LAWS[law], np.array([4e-3, 2e-3, 1e-3]), []
    exact = slide(SLIDING_TIME, THROW, -GRAVITY * sin(INCLINE), GRAVITY * cos(INCLINE), chosen)
    for h in steps:
        history = completed(thrown_up("time-stepping", chosen, step=h))
        assert history.events[0].time == 0.0
        assert times_of(history)[0] == pytest.approx(exact.turns[0], abs=1.5 * h)
        ways.append(last(history, "slip") - exact.way)
        assert last(history, "slip_rate") == pytest.approx(exact.speed, abs=GRAVITY * h)
        assert np.abs(history["gap"].values).max() <= EVENT_ERROR
        assert abs(history.summary["energy"]["unaccounted"]) <= EVENT_ERROR
    assert np.all(np.abs(ways) <= 0.5 * steps)


@pytest.mark.parametrize("law", RIDING_LAWS)
def test_time_stepping_rides_a_belt_that_supplies_what_friction_takes(law):
    h = 1e-3
    history = completed(ridden("time-stepping", RIDING_LAWS[law](UNSCALED), (0.0, BELT), h))
    exact = FIRST_SLIP + np.array([0.0, SLIP_TIME, SLIP_TIME + STICK_TIME])
    assert kinds_of(history) == ["slip", "stick", "slip"]
    assert times_of(history) == pytest.approx(exact, abs=2.0 * h)
    assert abs(history.summary["energy"]["unaccounted"]) <= EVENT_ERROR
    assert history.summary["energy"]["supplied"] > 0.1


@pytest.mark.parametrize("height", [0.0, 1e-4, 3e-3, 0.2])
def test_time_stepping_stops_a_ball_on_the_ground_wherever_it_starts(height):
    """It starts with 2 m/s downwards, also where it touches already or does within the first half of a step."""
    h, start = 4e-3, (np.array([0.0, height]), np.array([0.0, -2.0]))
    ball, scheme = Particle(above=-GRAVITY), scheme_of("time-stepping", h)
    history = completed(simulate_system(ball, *start, 0.3, scheme=scheme))
    (contact,) = history.contacts
    lands = (sqrt(4.0 + 2.0 * GRAVITY * height) - 2.0) / GRAVITY
    assert contact.start == pytest.approx(lands, abs=2.0 * GRAVITY * h**2)
    # plastic: the momentum at the landing, and the weight from there on
    impulse = 2.0 + GRAVITY * 0.3
    assert contact.normal_impulse == pytest.approx(impulse, abs=1e-9)
    assert history["gap"].values.min() > -GRAVITY * h**2
    assert history["gap"].values[-1] == pytest.approx(0.0, abs=1e-9)


# --- a rod that falls on its end -------------------------------------------------------------------------------

ANGLE, HALF, HEIGHT = pi / 3, 0.5, 0.05
ROD_FALL = sqrt(2.0 * HEIGHT / GRAVITY)
ROD_LAWS = {
    "frictionless": FRICTIONLESS,
    "coulomb": coulomb(0.3),
    "modified-coulomb": MODIFIED,
    "curve": HOLDING_CURVE,
}


def falling_rod(scheme: str, step: float, scale: Scale = UNSCALED, end: float = 0.12, **options: Any) -> History:
    """Run a rod that falls without spin and moves along with 2 m/s."""
    rod = FreeRod(scale.mass, HALF * scale.length, GRAVITY * scale.acceleration)
    return simulate_system(
        rod,
        rod.at(ANGLE, HEIGHT * scale.length),
        rod.moving(ANGLE, (2.0 * scale.speed, 0.0)),
        end * scale.time,
        scheme=scheme_of(scheme, step * scale.time),
        output_interval=0.02 * scale.time,
        **options,
    )


class Landing(NamedTuple):
    """A rod just after its plastic, frictionless impact (SI units, 1 kg)."""

    impulse: float
    slip_rate: float
    spin: float
    force: float  # N, of the sliding contact


def landing(law: Law) -> Landing:
    """I = m v/(1 + 3 c^2); slip changes by -3 s c I/m, spin by -3 c I/(m l); then the sliding end presses with

    lambda_n = m (g - l s w^2)/(1 + 3 c^2 + 3 s c mu), slip being positive.
    """
    s, c, v = sin(ANGLE), cos(ANGLE), GRAVITY * ROD_FALL
    impulse = v / (1.0 + 3.0 * c * c)
    slip, spin = 2.0 - 3.0 * s * c * impulse, -3.0 * c * impulse / HALF
    force = (GRAVITY - HALF * s * spin**2) / (1.0 + 3.0 * c * c + 3.0 * s * c * law.at(slip))
    return Landing(impulse, slip, spin, force)


@pytest.mark.parametrize("scheme", RIGID)
@pytest.mark.parametrize("law", ROD_LAWS)
def test_a_rod_that_falls_on_its_end(law, scheme):
    """m = 1 kg, half-length 0.5 m, 60 degrees, 50 mm above the ground, 2 m/s along it; plastic impact.

    Exact: impulse, velocities and the force of the sliding contact just after (`landing`).
    """
    chosen, h = ROD_LAWS[law], 1e-3
    exact, history = landing(chosen), completed(falling_rod(scheme, h, friction=chosen.make(UNSCALED)))
    impact = history.events[0]
    assert kinds_of(history) == ["impact"]
    assert impact.state is State.SLIP
    # a fixed step notices the ground up to h late, g h faster
    faster = GRAVITY * h
    assert impact.time == pytest.approx(ROD_FALL, abs=bound(scheme, h))
    assert impact.normal_impulse == pytest.approx(exact.impulse, abs=bound(scheme, faster))
    assert impact.tangential_velocity == pytest.approx(exact.slip_rate, abs=bound(scheme, faster))
    spin = just_after(history, "qd", impact.time)[2]
    assert spin == pytest.approx(exact.spin, abs=bound(scheme, faster * 3.0 / HALF))
    slope = 2.0 * HALF * abs(exact.spin) + chosen.steepest * GRAVITY  # of the force over spin and slip
    force = just_after(history, "lambda_n", impact.time)
    assert force == pytest.approx(exact.force, abs=bound(scheme, slope * faster * 3.0 / HALF) * 10.0)
    friction = just_after(history, "lambda_tau", impact.time)
    assert friction == pytest.approx(-chosen.at(impact.tangential_velocity) * force, abs=EVENT_ERROR * GRAVITY)


# --- scales ----------------------------------------------------------------------------------------------------

#: powers of two next to 1e-3 and 1e3: scaling itself rounds nothing, so what differs is a hidden dimension
SMALL, LARGE = 2.0**-10, 2.0**10
SCALES = {
    "a thousandth of the length": Scale(length=SMALL),
    "a thousand times the length": Scale(length=LARGE),
    "a thousandth of the time": Scale(time=SMALL),
    "a thousand times the time": Scale(time=LARGE),
    "small and slow": Scale(length=SMALL, time=LARGE),
    "a thousandth of the mass": Scale(mass=SMALL),
}


def _bouncing(scheme: str, scale: Scale) -> History:
    return dropped(scheme, 4e-3, 0.8, 0.5, scale, impact_law=NewtonImpact(0.5), friction=Coulomb(0.3, 0.3))


def _elastic(scheme: str, scale: Scale) -> History:
    stop = ElasticStop(STIFFNESS * scale.stiffness)
    return dropped(scheme, 2e-3, 0.35, 4.0, scale, contact_law=stop, friction=Coulomb(0.3, 0.3))


CASES = {
    "incline": lambda scheme, scale: thrown_up(scheme, LAWS["coulomb-0.2"], scale, 1e-2),
    "incline, modified Coulomb": lambda scheme, scale: thrown_up(scheme, MODIFIED, scale, 1e-2),
    "bouncing ball": _bouncing,
    "elastic stop": _elastic,
    "belt": lambda scheme, scale: ridden(scheme, Coulomb(0.4, 0.3), (0.0, BELT), 5e-3, scale),
    "rod": lambda scheme, scale: falling_rod(scheme, 2e-3, scale, friction=Coulomb(0.3, 0.3)),
}


#: each scheme meets each scale, and each case each scheme that takes it: one scale for each pair of them
PAIRS = [
    (case, scheme, list(SCALES)[(i + 2 * k) % len(SCALES)])
    for i, case in enumerate(CASES)
    for k, scheme in enumerate(RIGID if case in ("bouncing ball", "rod") else SCHEMES)
]


@pytest.mark.parametrize(("case", "scheme", "scale"), PAIRS)
def test_a_scaled_problem_has_the_scaled_solution(case, scheme, scale):
    """q(t; L, T, M) = L q(t/T): with lengths, times and masses scaled, laws and steps too, nothing else changes.

    No scale is given to the solver; what it takes for zero has to follow from the motion.  Scaled by powers of two
    every operation rounds the same: adaptive steps must not know metres or seconds.
    """
    factors = SCALES[scale]
    found, exact = CASES[case](scheme, factors), CASES[case](scheme, UNSCALED)
    assert found.outcome is exact.outcome
    assert kinds_of(found) == kinds_of(exact)
    assert found.summary["steps"] == exact.summary["steps"]
    error = 10.0 * EVENT_ERROR
    assert times_of(found) / factors.time == pytest.approx(times_of(exact), abs=error)
    end = slice(0, 2)  # a place in the plane; the angle of the rod is no length
    assert last(found, "q")[end] / factors.length == pytest.approx(last(exact, "q")[end], abs=error)
    assert last(found, "qd")[end] / factors.speed == pytest.approx(last(exact, "qd")[end], abs=error)
    assert last(found, "lambda_n") / factors.force == pytest.approx(last(exact, "lambda_n"), abs=100.0 * error)
