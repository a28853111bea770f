"""Transitions under fixed steps and generalized-alpha, reproducibility, interpreted runs; closed forms decide."""

from __future__ import annotations

import json
from math import acos, cos, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from oblique_impact import History, MechanicalSystem, Outcome, Scenario, simulate, simulate_system
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.impacts import NewtonImpact
from oblique_impact.contact.state import Baumgarte, State
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.kernels.system import ContactRows
from oblique_impact.marching import loop
from oblique_impact.marching.fixed_step import FixedStepScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.validation.reference_values import VALUES
from oblique_impact.validation.small_systems import FreeRod, Particle
from tests.processes import python
from tests.refusals import refused_in_one_line
from tests.small.systems import (
    EVENT_ERROR,
    GRAVITY,
    RIGID,
    ROUNDING,
    SCHEMES,
    assert_order,
    completed,
    ground_of,
    just_after,
    kinds_of,
    last,
    scheme_of,
    times_of,
)
from tests.systems import Block, Prescribed

REST = np.zeros(2)


# --- transitions that generalized-alpha locates -----------------------------------------------------------

RHOS = [0.0, 0.5, 0.8, 1.0]


@pytest.mark.parametrize("rho", RHOS)
def test_generalized_alpha_sees_a_graze_within_a_step(rho):
    """A ball that is pulled up flies v = 1.47 m/s towards the ground and would turn 5 mm under it, or 1 mm above.

    Both ends of the first step of 0.1 s from the turn are above the ground. The scheme is exact for a parabola.
    """
    speed, h = 1.47, 0.1
    turns, rise = speed / GRAVITY, 0.5 * speed**2 / GRAVITY

    def flight(depth: float) -> History:
        start, scheme = np.array([0.0, rise - depth]), GeneralizedAlphaScheme(h, h, rho)
        options = {"scheme": scheme, "contact_law": ElasticStop(1e4)}
        return completed(
            simulate_system(Particle(above=GRAVITY), start, np.array([0.0, -speed]), 3.0 * h, **options)
        )

    grazes = flight(5e-3)
    assert kinds_of(grazes)[0] == "impact"
    assert times_of(grazes)[0] == pytest.approx(turns - sqrt(2.0 * 5e-3 / GRAVITY), abs=ROUNDING)
    passes = flight(-1e-3)
    assert not kinds_of(passes)
    exact = 1e-3 + 0.5 * GRAVITY * (passes["time"].values - turns) ** 2
    assert passes["gap"].values == pytest.approx(exact, abs=ROUNDING)


def test_generalized_alpha_takes_no_rigid_stop():
    with refused_in_one_line("scheme: should be an EventScheme or TimeSteppingScheme with a rigid stop"):
        simulate_system(Particle(above=-GRAVITY), [0.0, 0.1], REST, 0.1, scheme=GeneralizedAlphaScheme(1e-3, 1e-3))


@pytest.mark.parametrize("rho", ["fixed-step", *RHOS])
def test_a_mass_on_a_spring_turns_until_friction_holds_it(rho):
    """Table 6g (SDND100, published): m = 1 kg, k = 1e4 N/m, mu = 0.1, g = 10, from 0.85 mm.

    It turns at multiples of pi/100 s, at -0.65, 0.45, -0.25, 0.05 mm, where it stays.  By fixed
    steps a turn is noticed up to h late: friction pushes on with 2 mu m g for h, by up to mu g h^2 in place.
    """
    exact, spring, fixed = np.array(VALUES["6g"]), Particle(above=-10.0, stiffness=1e4), rho == "fixed-step"
    ground = ground_of("fixed-step" if fixed else "generalized-alpha", 10.0)
    start = np.array([0.85e-3, ground.gap])
    steps, times, places = np.array([4e-4, 2e-4, 1e-4]) * (1.0 if fixed else 2.0), [], []
    for h in steps:
        scheme = FixedStepScheme(h, h) if fixed else GeneralizedAlphaScheme(h, h, rho)
        options = {"friction": Coulomb(0.1, 0.1), "scheme": scheme, "contact_law": ground.contact_law}
        history = completed(simulate_system(spring, start, REST, 0.14, **options))
        assert kinds_of(history) == ["reversal"] * 3 + ["stick"]
        times.append(np.abs(times_of(history) - np.arange(1, 5) * pi / 100).max())
        found = np.array([just_after(history, "slip", t) for t in times_of(history)])
        places.append(np.abs(found - exact).max())
    if fixed:  # errors of first order depend on where in a step an event falls
        assert_order(steps, times, (0.4, 1.6), 4.04 * steps)
        assert np.all(places <= 4.0 * (0.1 * 10.0 + 8.5) * steps**2)
    else:  # where it turns it is at its amplitude, which dissipation of third order takes
        assert_order(steps, times, (1.7, 2.4), 4.0 * pi / 100 * (100.0 * steps) ** 2)
        assert_order(steps, places, (2.7, 3.3), 4.0 * 0.85e-3 * (100.0 * steps) ** 3)


def test_a_ball_that_bounces_under_fixed_steps_does_not_sink():
    """From 0.2 m with e = 0.5, without stabilization: at rest after 3 sqrt(2 h/g) = 0.606 s, at y = 0.

    A bounce of speed v is the last if e v does not lift the ball out of the depth v h in which it was noticed:
    v <= 2 g h/e^2 = 8 g h, a depth of 8 g h^2.  So about log2(v0/(8 g h)) bounces, each up to 3 h out in time.
    """
    ball, h, start = Particle(above=-GRAVITY), 4e-3, (np.array([0.0, 0.2]), REST)
    options = {"impact_law": NewtonImpact(0.5), "scheme": FixedStepScheme(h, h), "baumgarte": Baumgarte(0.0, 0.0)}
    history = completed(simulate_system(ball, *start, 0.75, **options))
    bounces = int(np.log2(sqrt(0.4 / GRAVITY) / h)) + 4
    assert len(history.events) <= bounces
    for rebound in history.events[:-1]:  # each rises out of the slope, in which its step has found it
        after = history.at(rebound.time, "right")
        assert float(after["gap_rate"]) ** 2 / (2.0 * GRAVITY) > -float(after["gap"])
    assert times_of(history)[-1] == pytest.approx(3.0 * sqrt(0.4 / GRAVITY), abs=3.0 * h * bounces)
    resting = history["time"].values > times_of(history)[-1]
    assert np.abs(history["gap"].values[resting]).max() <= 8.0 * GRAVITY * h**2


def test_a_contact_that_a_fixed_step_notices_late_is_pushed_out_though_a_force_lifts_it():
    """Stabilization outweighs 5 m/s^2 until it has brought the block out of the ground, within (pi/2) / beta."""
    block, scheme = Block(lambda t, q, qd: (0.0, 5.0)), FixedStepScheme(1e-4, 1e-4)
    start, options = ([0.0, 0.05], [0.0, -1.0]), {"scheme": scheme, "baumgarte": Baumgarte(20.0, 1e6)}
    history = completed(simulate_system(block, *start, 0.1, **options))
    assert kinds_of(history) == ["impact", "release"]
    landed, left = times_of(history)
    assert left - landed < 0.5 * pi / 1e3


# --- runs that end by name, short flights ---------------------------------------------------------------------


def test_chattering_is_bounded_and_named(monkeypatch):
    """A drive that always pushes against the slip, beyond the cone: no state persists."""
    monkeypatch.setattr(loop, "MAX_EVENTS", 300)  # so that a failure takes no minutes
    block = Block(lambda t, q, qd: (-20.0 if qd[0] >= 0.0 else 20.0, -9.8))
    history = simulate_system(block, [0.0, 0.0], [1.0, 0.0], 1.0, friction=Coulomb(0.5, 0.5))
    assert history.outcome is Outcome.CHATTERING
    # x'' = -20 - 0.5 * 9.8 up to the standstill
    assert history.summary["end_time"] == pytest.approx(1.0 / 24.9, abs=1e-8)
    assert len(history.events) < 200


def test_friction_on_a_single_coordinate_at_rest_is_redundant():
    pressed = Prescribed(lambda s: s, lambda s: 1.0, lambda s: 0.0, acceleration=-3.0)
    history = simulate_system(pressed, [0.0], [0.0], 0.1, friction=Coulomb(0.3, 0.3))
    assert history.outcome is Outcome.REDUNDANT_CONSTRAINTS


def test_an_impact_into_a_painleve_configuration_keeps_the_impulse():
    """A rod at 60 degrees falls on its end, which slides: m v/(1 + 3 cos^2), and then no force is consistent."""
    rod = FreeRod(gravity=GRAVITY)
    start = rod.at(pi / 3, 0.05), rod.moving(pi / 3, (-3.0, 0.0))
    history = simulate_system(rod, *start, 0.5, friction=Coulomb(1.5, 1.5))
    assert history.outcome is Outcome.PAINLEVE
    assert kinds_of(history) == ["impact"]
    assert history.events[0].normal_impulse == pytest.approx(sqrt(2.0 * GRAVITY * 0.05) / 1.75, rel=1e-9)


class Inclined(MechanicalSystem):
    """Coordinates x, y of 1 kg each under constant forces, with the gap x and the slip 3 x + y."""

    size = 2

    def __init__(self, *force: float) -> None:
        self.force = np.array(force)

    def mass_matrix(self, t, q):
        return np.eye(2)

    def forces(self, t, q, qd):
        return self.force

    def contact(self, t, q, qd):
        rows = np.array([1.0, 0.0]), np.array([3.0, 1.0])
        return ContactRows(q[0], rows[1] @ q, qd[0], rows[1] @ qd, *rows)

    def energy(self, t, q, qd):
        return 0.5 * float(qd @ qd), 0.0, -float(self.force @ q)


@pytest.mark.parametrize(("scheme", "error"), [("event", EVENT_ERROR), ("fixed-step", 1e-3)])
def test_a_sliding_contact_that_could_hold_or_open_opens(scheme, error):
    """A_nn - mu A_nt = 1 - 3/2 is negative: with x'' = 1 without force x'' = 0 with 2 N solves the problem too.

    The gap 0.01 - 0.3 t + t^2/2 closes at 0.3 - sqrt(0.07); a plastic impact leaves it (t - t1)^2/2.
    """
    closes = 0.3 - sqrt(0.07)
    start, end = ([0.01, 0.0], [-0.3, 5.0]), 0.2
    pushed = simulate_system(
        Inclined(1.0, 0.0), *start, end, friction=Coulomb(0.5, 0.5), scheme=scheme_of(scheme, 1e-4)
    )
    assert pushed.outcome is Outcome.COMPLETED
    assert kinds_of(pushed) == ["rebound"]
    assert last(pushed, "gap") == pytest.approx(0.5 * (end - closes) ** 2, abs=error)
    (warning,) = pushed.summary["warnings"]
    assert "not unique at 0.035" in warning
    # without friction there is nothing to choose
    assert "warnings" not in simulate_system(Inclined(1.0, 0.0), *start, end).summary


def test_a_sliding_contact_that_would_close_without_a_force_is_painleve():
    pressed = simulate_system(Inclined(-1.0, 0.0), [0.01, 0.0], [-0.3, 5.0], 0.2, friction=Coulomb(0.5, 0.5))
    assert pressed.outcome is Outcome.PAINLEVE
    assert "warnings" not in pressed.summary


@pytest.mark.parametrize("dip", [0.3, 1e-2, 1e-3])
def test_a_force_that_dips_below_zero_is_a_short_flight(dip):
    """lambda_n = 1 - dip + cos 2 pi t is negative for a moment around t = 0.5 only."""
    w = 2.0 * pi
    block = Block(lambda t, q, qd: (0.0, dip - 1.0 - cos(w * t)))
    history = simulate_system(block, [0.0, 0.0], [0.0, 0.0], 1.0, output_interval=0.05)
    release = acos(dip - 1.0) / w

    def height(t: float) -> float:
        s = t - release
        return 0.5 * (dip - 1.0) * s**2 + (cos(w * t) - cos(w * release) + w * s * sin(w * release)) / w**2

    landing = brentq(height, 0.5 + 1.01 * (0.5 - release), 1.0, xtol=1e-15)
    assert kinds_of(history) == ["release", "impact"]
    assert np.abs(times_of(history) - [release, landing]).max() < 1e-8
    assert float(history["gap"].min()) > -1e-12


# --- a scheme that is used twice ------------------------------------------------------------------------------


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_scheme_that_is_used_twice_gives_the_same_bytes(scheme):
    """A bouncing mass on a spring; the first run ends after an impact."""
    system, one = Particle(above=-GRAVITY, stiffness=30.0), scheme_of(scheme, 5e-3)
    start = np.array([0.1, 0.05]), np.array([0.3, 0.0])

    def run(chosen: Any) -> History:
        options = {"impact_law": NewtonImpact(0.5)} if scheme in RIGID else {"contact_law": ElasticStop(1e3)}
        options |= {"friction": Coulomb(0.3, 0.3), "scheme": chosen}
        return simulate_system(system, *start, 0.3, **options)

    first, second, fresh = run(one), run(one), run(scheme_of(scheme, 5e-3))
    for again in (second, fresh):
        assert times_of(again).tobytes() == times_of(first).tobytes()
        for name in ("time", "q", "qd", "lambda_n", "lambda_tau"):
            assert again[name].values.tobytes() == first[name].values.tobytes(), name


# --- stick --------------------------------------------------------------------------------------------------


def test_a_sliding_block_stops_after_many_calls():
    """It brakes at 0.3 g + 0.5 m/s^2 from 4 m/s, and then friction holds it."""
    block, ground = Particle(above=-GRAVITY, along=-0.5), ground_of("generalized-alpha", GRAVITY)
    start = np.array([0.0, ground.gap]), np.array([4.0, 0.0])
    options = {"contact_law": ground.contact_law, "scheme": GeneralizedAlphaScheme(4e-4, 4e-4)}
    history = completed(simulate_system(block, *start, 1.8, friction=Coulomb(0.4, 0.3), **options))
    brake = 0.3 * GRAVITY + 0.5
    assert kinds_of(history) == ["stick"]
    assert times_of(history)[0] == pytest.approx(4.0 / brake, abs=1e-6)
    assert last(history, "state") == State.STICK
    assert last(history, "slip") == pytest.approx(4.0**2 / (2.0 * brake), abs=1e-6)


def test_a_contact_that_sticks_at_a_speed_is_brought_back_by_its_stabilization():
    """Where the force alone decides, as in the paper: Z'' + 2 chi Z' + beta^2 Z = 0 from Z' = 1 mm/s."""
    speed, rate, chi = 1e-3, 100.0, 10.0
    options = {"friction": Coulomb(0.4, 0.4), "scheme": FixedStepScheme(1e-4, 1e-4, literal=True)}
    options |= {"baumgarte": Baumgarte(2.0 * chi, rate**2), "output_interval": 1e-3}
    history = completed(simulate_system(Particle(above=-GRAVITY), REST, np.array([speed, 0.0]), 0.1, **options))
    assert np.all(history["state"].values[1:] == State.STICK)
    time, own = history["time"].values, sqrt(rate**2 - chi**2)
    exact = speed / own * np.exp(-chi * time) * np.sin(own * time)
    assert history["slip"].values == pytest.approx(exact, abs=1e-7 * speed / own)


@pytest.mark.parametrize("scheme", ["event", "generalized-alpha"])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_growing_pull_ends_the_stick_on_an_elastic_stop_at_the_edge_of_the_cone(scheme, direction):
    """The block lies as deep as its weight asks for: 20 N/s overcome 0.4 m g after 0.196 s."""
    block, place = Block(lambda t, q, qd: (direction * 20.0 * t, -9.8)), [0.0, -9.8 / 1e4]
    options = {"friction": Coulomb(0.4, 0.3), "contact_law": ElasticStop(1e4), "scheme": scheme_of(scheme, 1e-3)}
    history = simulate_system(block, place, [0.0, 0.0], 0.25, **options)
    assert kinds_of(history) == ["slip"]
    assert times_of(history)[0] == pytest.approx(0.4 * 9.8 / 20.0, abs=1e-8)
    assert direction * last(history, "slip_rate") > 0.0


# --- interpreted ----------------------------------------------------------------------------------------------

#: just above the slope, as fast as after a fall: it strikes within a fraction of a millisecond
CLOSE = {"initial__angle": 0.2214, "initial__angular_velocity": -3.786, "solver__output_interval": 2e-4}
NODAL = {
    "discretization__method": "fem",
    "discretization__modes": 0,
    "discretization__frame": "mean-axis",
    "discretization__elements": 2,  # more carry vibrations that a rounded instant of impact changes by 1e-9
}
INTERPRETED = {
    "event": {"solver__scheme": "event", "end_time": 4e-4},
    "fixed-step": {
        "solver__scheme": "fixed-step",
        "end_time": 2e-3,
        "solver__free_step": 2e-5,
        "solver__contact_step": 2e-5,
    },
    "generalized-alpha": {
        "solver__scheme": "generalized-alpha",
        "end_time": 1e-3,
        "solver__contact_step": 2e-5,
        "contact__normal": "spring",
    },
    "nodal": {"solver__scheme": "time-stepping", "end_time": 1e-3, "solver__contact_step": 2e-5, **NODAL},
    "event on a spring": {"solver__scheme": "event", "end_time": 1e-3, "contact__normal": "spring"},
}
_RUN = """
import json, sys
import numpy as np
from oblique_impact import Scenario, simulate
for name, changes in json.loads(sys.argv[1]).items():
    history = simulate(Scenario.builtin("paper").replace(**changes))
    np.savez(f"{sys.argv[2]}/{name}.npz", events=[event.time for event in history.events],
             **{key: history[key] for key in ("time", "q", "qd", "lambda_n")})
"""


@pytest.fixture(scope="module")
def interpreted(tmp_path_factory):
    """Run all of them in one process without the compiler; returns the folder with what came out."""
    folder = tmp_path_factory.mktemp("interpreted")
    changes = {name: {**CLOSE, **changes} for name, changes in INTERPRETED.items()}
    python(_RUN, json.dumps(changes), folder, NUMBA_DISABLE_JIT="1")
    return folder


@pytest.mark.parametrize("name", INTERPRETED)
def test_every_scheme_runs_without_the_compiler(name, interpreted):
    """With NUMBA_DISABLE_JIT=1 a short run through an impact and contact is the compiled one, to 1e-9."""
    compiled = simulate(Scenario.builtin("paper").replace(**CLOSE, **INTERPRETED[name]))
    with np.load(interpreted / f"{name}.npz") as file:
        found = dict(file)
    assert len(compiled.events) > 0
    np.testing.assert_allclose(found["events"], [event.time for event in compiled.events], rtol=0, atol=1e-12)
    for key in ("time", "q", "qd", "lambda_n"):
        size = max(1.0, float(np.nanmax(np.abs(compiled[key].values))))
        # in either run generalized-alpha closes a contact to 1e-10 L / sqrt(L/g) = 3.1e-10 m/s: over the step,
        # times the 0.094 kg that the contact point feels, that is a force
        left = 2.0 * 0.094 * 3.1e-10 / 2e-5 if key == "lambda_n" and "alpha" in name else 0.0
        np.testing.assert_allclose(found[key], compiled[key].values, rtol=0, atol=1e-9 * size + left, err_msg=key)
