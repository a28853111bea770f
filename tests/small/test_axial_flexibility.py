"""A spring in series with Coulomb's slider, Jenkins's element: closed forms under every scheme."""

from __future__ import annotations

from math import asin, cos, inf, pi, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from oblique_impact import History, simulate_system
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.impacts import RouthImpact
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.errors import InputError
from oblique_impact.validation.small_systems import FreeRod, Particle
from tests.small.systems import (
    EVENT_ERROR,
    GRAVITY,
    SCHEMES,
    assert_order,
    completed,
    kinds_of,
    last,
    scheme_of,
    times_of,
)
from tests.systems import Block

STOP, FLEXIBILITY = 4e4, 1e-4  # N/m, m/N
LAW = Coulomb(0.4, 0.3)


def run(scheme: str, step: float, end: float, place: float, velocity: tuple[float, float], **more) -> History:
    """Run a mass of 1 kg, `place` (m) above an elastic ground, with a velocity (m/s) along it and upwards."""
    parts = {"contact_law": ElasticStop(STOP), "axial_flexibility": FLEXIBILITY} | more
    found = simulate_system(
        Particle(above=-GRAVITY),
        np.array([0.0, place]),
        np.array(velocity),
        end,
        friction=LAW,
        scheme=scheme_of(scheme, step),
        output_interval=end / 50.0,
        **parts,
    )
    return completed(found)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_mass_that_is_pushed_swings_on_its_spring_slips_and_swings_on(scheme):
    """It slips at mu_s N, where the spring falls back to mu_k N at once, and swings about where it comes to rest.

    What it has lost by then is mu_k N over its way and what the spring gave up in falling back.
    """
    speed, rate = 0.1, sqrt(1.0 / FLEXIBILITY)
    begins = asin(LAW.static * GRAVITY * FLEXIBILITY * rate / speed) / rate
    ends = begins + speed * cos(rate * begins) / (LAW.kinetic * GRAVITY)
    loss = 0.5 * speed**2 - 0.5 * FLEXIBILITY * (LAW.kinetic * GRAVITY) ** 2
    force = -LAW.kinetic * GRAVITY * cos(1.25 * pi)
    steps, errors, end = (4e-4, 2e-4, 1e-4), [], ends + 1.25 * pi / rate
    for step in steps[:1] if scheme == "event" else steps:
        found = run(scheme, step, end, -GRAVITY / STOP, (speed, 0.0))
        assert kinds_of(found) == ["slip", "stick"]
        energy = found.summary["energy"]
        assert abs(energy["unaccounted"]) < 1e-6 * speed**2
        stored = 0.5 * FLEXIBILITY * last(found, "lambda_tau") ** 2
        assert energy["contact"] - 0.5 * GRAVITY**2 / STOP == pytest.approx(stored, rel=1e-9)
        slip, stick = times_of(found) - [begins, ends]
        errors.append([slip, stick, energy["lost_friction"] / loss - 1.0, last(found, "lambda_tau") / force - 1.0])
    errors = np.abs(errors).T
    if scheme == "event":
        assert errors.max() < EVENT_ERROR
    elif scheme == "generalized-alpha":
        for some, most in zip(errors, (1e-6, 1e-6, 1e-7, 1e-3), strict=True):
            assert_order(steps, some, (1.8, 2.5), most)
    else:  # states change at the ends of steps
        assert np.all(errors[:2] <= steps)
        assert np.all(errors[2:] <= 100.0 * np.array(steps))


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize(("steepness", "kinds"), [(0.98, ["impact"]), (1.02, ["impact", "stick"])])
def test_an_oblique_impact_sticks_at_once_if_it_is_steep_enough(scheme, steepness, kinds):
    """Both forces grow from zero, their ratio is that of the stiffnesses times that of the speeds."""
    down = 0.5
    along = steepness * LAW.static * FLEXIBILITY * STOP * down
    found = run(scheme, 1e-5, 5e-3, 1e-5, (along, -down))
    assert kinds_of(found)[0] == "impact"
    if scheme == "event":
        assert found.events[0].state.name == ("STICK" if len(kinds) == 1 else "SLIP")


def test_axial_flexibility_needs_known_laws_and_on_a_rigid_or_damped_stop_the_event_scheme():
    routh, damped = {"contact_law": None, "impact_law": RouthImpact(0.3)}, {"contact_law": ElasticStop(STOP, 0.1)}
    for scheme, laws in (("event", routh), ("fixed-step", damped), ("fixed-step", {"contact_law": None})):
        with pytest.raises(InputError, match="axial_flexibility"):
            run(scheme, 1e-4, 1e-2, 0.0, (0.1, 0.0), **laws)


def rod_motion(angle: complex, spin: complex, drag: complex, ratio: float) -> tuple[complex, complex, complex]:
    """Accelerations of end and angle, and normal force N: m = l = 1, the ground drags with drag + ratio N."""
    c, s = np.cos(angle), np.sin(angle)
    normal = (GRAVITY - s * spin**2 + 3.0 * c * s * drag) / (1.0 + 3.0 * c * c - 3.0 * c * s * ratio)
    turning = 3.0 * (-c * normal + s * (drag + ratio * normal))
    return drag + ratio * normal + s * turning + c * spin**2, turning, normal


def rod_events(angle: float, velocity: float, mu: float, flexibility: float, end: float) -> list[float]:
    """Times (s) at which the end of a rod on rigid ground slips and sticks by turns, by SciPy.

    The rate of the normal force is exact, by differentiation along the imaginary axis.
    """
    t, y, held, way, found = 0.0, np.array([0.0, velocity, angle, 0.0]), 0.0, 0.0, []

    def rates(t, y):
        law = (0.0, -way * mu) if way else ((held - y[0]) / flexibility, 0.0)
        end, turning, _ = rod_motion(y[2], y[3], *law)
        return np.array([y[1], end, y[3], turning])

    def turns(t, y):
        if not way:
            return 1.0
        z = y + 1e-30j * rates(t, y)
        rate = rod_motion(z[2], z[3], 0.0, -way * mu)[2].imag / 1e-30
        return way * y[1] - flexibility * mu * rate

    def inside(side):
        def cone(t, y):
            drag = (held - y[0]) / flexibility
            return 1.0 if way else mu * rod_motion(y[2], y[3], drag, 0.0)[2] + side * drag

        return cone

    guards = turns, inside(1.0), inside(-1.0)
    for guard in guards:
        guard.terminal, guard.direction = True, -1
    while True:
        part = solve_ivp(rates, (t, end), y, "DOP853", rtol=1e-13, atol=1e-15, events=guards, max_step=1e-3)
        t, y = part.t[-1], part.y[:, -1]
        if part.status == 0:
            return found
        found.append(t)
        if way:
            held, way = y[0] - flexibility * way * mu * rod_motion(y[2], y[3], 0.0, -way * mu)[2], 0.0
        else:
            way = 1.0 if part.t_events[1].size else -1.0


@pytest.mark.parametrize(("angle", "velocity", "mu"), [(0.6, 0.5, 0.6), (1.2, -0.5, 0.6)])
def test_a_rod_on_rigid_ground_slips_and_sticks_as_by_an_independent_program(angle, velocity, mu):
    """Friction and normal force of the rod depend on each other; both change as it turns."""
    rod, end = FreeRod(gravity=GRAVITY), 0.3
    parts = {"friction": Coulomb(mu, mu), "axial_flexibility": 1e-3, "output_interval": end / 50.0}
    found = simulate_system(rod, rod.at(angle), rod.moving(angle, (velocity, 0.0)), end, **parts)
    expected = rod_events(angle, velocity, mu, 1e-3, end)
    assert len(expected) >= 4
    assert times_of(completed(found)) == pytest.approx(expected, abs=EVENT_ERROR)
    assert found.summary["energy"]["unaccounted"] == pytest.approx(0.0, abs=1e-13)


def lifted(velocity: float, until: float, law: ElasticStop | None) -> History:
    """Run a mass on its spring, with a velocity (m/s) along the ground, which a force unloads meanwhile."""
    mass = Block(lambda t, q, qd: (0.0, 5.0 * sin(40.0 * t) - GRAVITY))
    stiffness = law.stiffness if law else inf
    at_rest = (np.array([0.0, -GRAVITY / stiffness]), np.array([velocity, 5.0 * 40.0 / stiffness]))
    parts = {"friction": LAW, "contact_law": law, "axial_flexibility": FLEXIBILITY}
    return completed(simulate_system(mass, *at_rest, until, **parts))


def test_a_spring_that_falls_back_on_a_cone_that_shrinks_holds_at_once():
    """Its force, on the way back already, meets mu_s N and falls to mu_k N, below which it goes on to fall."""
    rate, cone = sqrt(1.0 / FLEXIBILITY), lambda t: LAW.static * (GRAVITY - 5.0 * sin(40.0 * t))
    times = np.linspace(0.01, 0.02, 10001)
    speed = 1.001 * min(cone(t) * FLEXIBILITY * rate / sin(rate * t) for t in times)
    over = [speed * sin(rate * t) / (rate * FLEXIBILITY) > cone(t) for t in times]
    at = brentq(lambda t: speed * sin(rate * t) / (rate * FLEXIBILITY) - cone(t), 0.01, times[over.index(True)])
    found = lifted(speed, at + 3e-3, None)
    assert kinds_of(found) == ["slip", "stick"]
    assert times_of(found) == pytest.approx([at, at], abs=EVENT_ERROR)
    push = cone(at) / LAW.static
    lost = 0.5 * FLEXIBILITY * push**2 * (LAW.static**2 - LAW.kinetic**2)
    assert found.summary["energy"]["lost_friction"] == pytest.approx(lost, rel=1e-8)


def test_ever_stiffer_stops_have_the_rigid_one_as_their_limit():
    rigid, stiffness = times_of(lifted(0.1, 0.08, None)), np.array([1e6, 1e7])
    assert rigid.size >= 2
    late = [np.max(np.abs(times_of(lifted(0.1, 0.08, ElasticStop(k))) - rigid)) for k in stiffness]
    assert late[1] < 1e-5
    assert late[0] / late[1] == pytest.approx(10.0, rel=0.3)
