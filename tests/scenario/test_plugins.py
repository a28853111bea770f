"""User-defined parts: each against a built-in one that it repeats, or a closed form; bad ones are one line."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from numpy.testing import assert_allclose

from oblique_impact import InputError, Scenario, simulate, simulate_system
from oblique_impact.beam.base_motion import BaseMotion
from oblique_impact.contact.friction import Branch, FrictionCurve, FrictionLaw
from oblique_impact.contact.impacts import ImpactLaw, newton_impulse
from oblique_impact.contact.stops import ContactLaw, ElasticStop
from oblique_impact.scenario.user_defined import names, register
from tests.systems import Block, RungeKutta


@register("contact_laws", "test-linear")
@dataclass(frozen=True)
class Linear(ContactLaw):
    stiffness: float = 1e6
    damping: float = 0.0

    @staticmethod
    def normal_force(depth, rate, stiffness, damping):
        return stiffness * depth * (1.0 + damping * rate)


@register("contact_laws", "test-power")
@dataclass(frozen=True)
class Power(ContactLaw):
    stiffness: float = 1e6
    exponent: float = 1.5

    @staticmethod
    def normal_force(depth, rate, stiffness, exponent):
        return stiffness * depth**exponent


@register("base_motions", "test-spin-up")
@dataclass(frozen=True)
class SpinUp(BaseMotion):
    speed: float = 4.0
    period: float = 0.5

    @staticmethod
    def turn(t, speed, period):
        if t >= period:
            return speed * (t - 0.5 * period), speed, 0.0
        w = 2.0 * math.pi / period
        angle = speed / period * (0.5 * t * t + (math.cos(w * t) - 1.0) / w**2)
        return angle, speed / period * (t - math.sin(w * t) / w), speed / period * (1.0 - math.cos(w * t))

    @property
    def breakpoints(self):
        return (self.period,)


register("integrators", "test-rk4")(RungeKutta)


@register("impact_laws", "test-newton")
@dataclass(frozen=True)
class Newton(ImpactLaw):
    restitution: float = 0.5

    def impulse(self, instant, restitution):
        return newton_impulse(instant, restitution)


@register("friction_laws", "test-curve")
def curve(v0=1e-3, v1=1e-2, mu=0.3):
    return FrictionCurve(((0.0, 0.0), (v0, 0.0), (v1, mu)))


SHORT = {"end_time": 0.34, "solver__output_interval": 1e-3}


def times(history):
    return np.array([event.time for event in history.events])


@pytest.fixture(scope="module")
def run():
    def simulated(**changes):
        return simulate(Scenario.builtin("paper").replace(**{**SHORT, **changes}))

    return simulated


# --- each part against the built-in one that it repeats


@pytest.mark.parametrize(
    ("scheme", "apart"), [("event", 1e-10), ("fixed-step", 1e-12), ("generalized-alpha", 1e-9)]
)
def test_a_contact_law_of_ones_own_is_the_elastic_stop_that_it_repeats(run, scheme, apart):
    common = {"solver__scheme": scheme, "solver__contact_step": 2e-6}
    built_in = run(contact__normal="spring", contact__damping=0.3, **common)
    own = run(contact__normal="test-linear", parameters__normal={"damping": 0.3}, **common)
    assert len(own.events) == len(built_in.events) > 4
    assert_allclose(times(own), times(built_in), rtol=0, atol=apart)
    for entry in ("contact", "lost_damping", "final"):
        assert own.summary["energy"][entry] == pytest.approx(built_in.summary["energy"][entry], rel=1e-6, abs=1e-9)
    assert own.summary["energy"]["lost_damping"] > 0.1


def test_a_stop_of_ones_own_stores_the_work_of_its_force():
    law = Power(2e6, 1.5)
    assert law.energy(-1e-3) == pytest.approx(2e6 * 1e-3**2.5 / 2.5, rel=1e-12)
    assert law.energy(1e-3) == 0.0


def test_a_mass_on_a_power_law_stop_leaves_as_it_came():
    """Contact lasts 2 d / v B(1/(n+1), 1/2) / (n+1); the depth d follows from 1/2 m v^2 = k d^(n+1) / (n+1)."""
    from scipy.special import beta

    speed, n, k = 0.5, 1.5, 1e6
    mass = Block(lambda t, q, qd: (0.0, 0.0))
    history = simulate_system(mass, [0.0, 1e-3], [0.0, -speed], 0.03, stop=Power(k, n), output_interval=1e-3)
    begin, end = times(history)
    depth = ((n + 1) * 0.5 * speed**2 / k) ** (1.0 / (n + 1))
    assert begin == pytest.approx(1e-3 / speed, abs=1e-12)
    assert end - begin == pytest.approx(2.0 * depth / speed * beta(1.0 / (n + 1), 0.5) / (n + 1), rel=1e-8)
    assert float(history["qd"][-1, 1]) == pytest.approx(speed, rel=1e-9)
    assert abs(history.summary["energy"]["unaccounted"]) < 1e-10


def test_a_base_motion_of_ones_own_is_the_spin_up_that_it_repeats():
    root = {"root__kind": "driven", "initial__angle": 0.5, "end_time": 0.6, "contact__enabled": False}
    base = Scenario.builtin("paper").replace(**root)
    built_in = simulate(base.replace(root__profile="spin-up", root__spin_rate=4.0, root__spin_up_time=0.5))
    own = simulate(base.replace(root__profile="test-spin-up"))
    assert_allclose(own["q"], built_in["q"], rtol=0, atol=1e-11)
    assert own.summary["energy"]["supplied"] == pytest.approx(built_in.summary["energy"]["supplied"], rel=1e-9)
    assert abs(own.summary["energy"]["unaccounted"]) < 1e-9


def test_a_driven_root_of_ones_own_starts_with_its_speed():
    @register("base_motions", "test-turning")
    @dataclass(frozen=True)
    class Turning(BaseMotion):
        speed: float = 3.0

        @staticmethod
        def turn(t, speed):
            return speed * t, speed, 0.0

    scenario = Scenario.builtin("paper").replace(
        root__kind="driven", root__profile="test-turning", parameters__profile={"speed": 2.5}, end_time=0.01
    )
    assert scenario.initial_angular_velocity == 2.5
    assert_allclose(simulate(scenario)["theta_dot"], 2.5, rtol=1e-12)


def test_a_friction_law_of_ones_own_is_the_modified_coulomb_law_that_it_repeats(run):
    built_in = run(contact__friction="modified-coulomb")
    own = run(contact__friction="test-curve")
    assert [e.kind for e in own.events] == [e.kind for e in built_in.events]
    assert_allclose(times(own), times(built_in), rtol=0, atol=1e-9)
    assert own.summary["energy"]["lost_friction"] == pytest.approx(built_in.summary["energy"]["lost_friction"])


def test_an_impact_law_of_ones_own_is_the_one_that_it_repeats(run):
    built_in = run(contact__restitution=0.5)
    own = run(contact__impact="test-newton")
    assert_allclose(times(own), times(built_in), rtol=0, atol=0)


def test_an_integrator_of_ones_own_finds_the_events_of_the_event_scheme(run):
    """From close above the slope, as fast as after the fall."""
    near = {"initial__angle": 0.23, "initial__angular_velocity": -3.786, "end_time": 0.016}
    near["solver__output_interval"] = 1e-4
    steps = {"solver__free_step": 2e-5, "solver__contact_step": 2e-6}
    exact, own = run(**near), run(solver__scheme="test-rk4", **steps, **near)
    assert [e.kind for e in own.events] == [e.kind for e in exact.events]
    assert len(own.events) == 8
    assert_allclose(times(own), times(exact), rtol=0, atol=2e-9)
    flight = own["time"].values[own["time"].values < 0.0022]
    assert_allclose(flight, 1e-4 * np.arange(22), rtol=0, atol=1e-12)


def test_an_integrator_of_ones_own_has_its_order():
    base = Scenario.builtin("paper").replace(end_time=0.1)
    exact = simulate(base.replace(solver__tolerance=1e-13))["q"][-1]
    errors = []
    for step in (4e-5, 2e-5):
        found = simulate(base.replace(solver__scheme="test-rk4", solver__free_step=step))
        errors.append(float(abs(found["q"][-1] - exact).max()))
    assert errors[0] / errors[1] == pytest.approx(2.0**4, rel=0.1)


def test_an_integrator_of_ones_own_sees_a_gap_that_closes_and_opens_within_a_step():
    """A mass thrown over a plane just touches it between two steps: 1 um deep, for 1/40 of a step."""
    from oblique_impact.scenario.sections import SolverSection

    depth, gravity = 1e-6, -9.8  # the mass is pulled away from the plane
    speed = math.sqrt(2.0 * 9.8 * (0.1 + depth))
    system = Block(lambda t, q, qd: (0.0, -gravity))
    scheme = RungeKutta(SolverSection(free_step=0.04, contact_step=1e-3))
    history = simulate_system(system, [0.0, 0.1], [0.0, -speed], 0.3, scheme=scheme)
    first = history.events[0]
    assert first.kind.value == "rebound"
    assert first.time == pytest.approx((speed - math.sqrt(2.0 * 9.8 * depth)) / 9.8, abs=1e-12)


# --- a law with a stick state and kinks beside zero


def test_kinks_of_a_law_that_sticks_are_passed_without_a_stop():
    """m v' = -N mu(v) with mu linear between points is an exponential on each; the block then rests."""
    points, weight = ((0.0, 0.4), (0.1, 0.2), (0.5, 0.3)), 9.8
    law = FrictionCurve(points, static=0.45)
    law.check(1.0)
    block = Block(lambda t, q, qd: (0.0, -weight))
    history = simulate_system(block, [0.0, 0.0], [1.0, 0.0], 1.0, friction=law)
    expected = (1.0 - 0.5) / (0.3 * weight)
    for (v0, mu0), (v1, mu1) in zip(reversed(points[:-1]), reversed(points[1:]), strict=True):
        rate = weight * (mu1 - mu0) / (v1 - v0)
        expected += math.log(mu1 / mu0) / rate
    stick = next(event for event in history.events if event.kind.value == "stick")
    assert stick.time == pytest.approx(expected, abs=1e-10)
    assert history.summary["energy"]["lost_friction"] == pytest.approx(0.5, abs=1e-10)
    assert len([e for e in history.events if e.kind.value == "reversal"]) == 0


@pytest.mark.parametrize("rate", [-0.7, -0.5, -0.3, -0.1, -0.05, 0.0, 0.05, 0.1, 0.3, 0.5, 0.7])
@pytest.mark.parametrize("direction", [1, -1])
def test_branches_of_a_curve_hold_around_the_velocity_they_are_asked_for(rate, direction):
    law = FrictionCurve(((0.0, 0.4), (0.1, 0.2), (0.5, 0.3)))
    branch = law.branch(rate, direction)
    assert branch.lower <= rate <= branch.upper
    assert rate != (branch.upper if direction > 0 else branch.lower)
    if rate not in (0.0,):
        mu = np.interp(abs(rate), [0.0, 0.1, 0.5], [0.4, 0.2, 0.3])
        assert branch.intercept + branch.slope * rate == pytest.approx(-math.copysign(mu, rate), abs=1e-15)


# --- Routh's impact on the beam


def test_routh_without_friction_is_newton(run):
    changes = {"contact__friction": "frictionless", "contact__restitution": 0.4}
    newton, routh = run(**changes), run(contact__impact="routh", **changes)
    assert_allclose(times(routh), times(newton), rtol=0, atol=1e-11)


def test_routh_with_friction_gives_the_beam_a_tangential_impulse_inside_the_cone(run):
    history = run(contact__impact="routh", contact__restitution=0.4)
    impacts = [event for event in history.events if event.normal_impulse > 0.0]
    assert all(abs(e.tangential_impulse) <= 0.3 * e.normal_impulse * (1 + 1e-12) for e in impacts)
    assert max(abs(e.tangential_impulse) for e in impacts) > 1e-3
    assert abs(history.summary["energy"]["unaccounted"]) < 1e-9


# --- scenarios


def test_numbers_of_parts_go_through_files_and_changes():
    text = '[contact]\nnormal = "test-power"\n[parameters.normal]\nstiffness = 3e7\n'
    scenario = Scenario.from_toml(text, ["parameters.normal.exponent=2"])
    assert dict(scenario.parameters.normal) == {"stiffness": 3e7, "exponent": 2.0}
    assert Scenario.from_toml(scenario.to_toml()) == scenario
    assert len({scenario, Scenario.from_toml(scenario.to_toml())}) == 1
    changed = scenario.replace(parameters__normal__exponent=1.25)
    assert changed.part("normal") == Power(3e7, 1.25)
    assert "[parameters" not in Scenario.builtin("paper").to_toml()


def test_registered_parts_are_listed_with_the_built_in_ones():
    assert {"test-linear", "test-power"} <= set(names("contact_laws"))
    assert Scenario.builtin("paper").part("normal") is None


@dataclass(frozen=True)
class Uncompiled(ContactLaw):
    @staticmethod
    def normal_force(depth, rate):
        return open("x")


@dataclass(frozen=True)
class Pulling(ContactLaw):
    @staticmethod
    def normal_force(depth, rate):
        return -depth


@dataclass(frozen=True)
class Inconsistent(BaseMotion):
    @staticmethod
    def turn(t):
        return t * t, 2.0 * t, 1.0


@dataclass(frozen=True)
class NotFromZero(BaseMotion):
    @staticmethod
    def turn(t):
        return 1.0, 0.0, 0.0


class Pushing(FrictionLaw):
    def branch(self, slip_rate, direction):
        return Branch(0.3, 0.0, -math.inf, math.inf)


class Gaping(FrictionLaw):
    def branch(self, slip_rate, direction):
        return Branch(0.0, 0.0, slip_rate - 1.0, slip_rate + 1.0)


class WeakWhenStuck(FrictionCurve):
    def __init__(self):
        super().__init__(((0.0, 0.5), (1.0, 0.4)), static=0.2)


BAD = {
    "unknown law": ({"contact__normal": "rubber"}, "contact.normal = 'rubber': should be 'rigid', 'spring'"),
    "unknown number": (
        {"contact__normal": "test-power", "parameters__normal": {"mu": 1.0}},
        "contact.normal: test-power: ",
    ),
    "numbers without a part": (
        {"parameters__friction": {"mu": 1.0}},
        "parameters.friction = {'mu': 1.0}: only with",
    ),
    "no numbers": ({"parameters__friction": {"mu": "x"}}, "parameters.friction"),
    "infinite": ({"parameters__friction": {"mu": math.inf}}, "mu is inf"),
    "not compiled": ({"contact__normal": "bad-uncompiled"}, "Uncompiled.normal_force: cannot be compiled"),
    "pulls": ({"contact__normal": "bad-pulling"}, "Pulling: the force at rest at a depth of"),
    "wrong kind": ({"contact__normal": "bad-kind"}, "is a SpinUp, should be a ContactLaw"),
    "inconsistent": ({"root__kind": "driven", "root__profile": "bad-inconsistent"}, "the acceleration is not the"),
    "not from zero": ({"root__kind": "driven", "root__profile": "bad-start"}, "the angle at t = 0 is 1"),
    "pushes": ({"contact__friction": "bad-pushing"}, "pushes along the slip at"),
    "gapes": ({"contact__friction": "bad-gaping"}, "Gaping: no branch begins at"),
    "weak when stuck": ({"contact__friction": "bad-weak"}, "static = 0.2, should be at least the 0.5"),
}
for _name, _part in {
    ("contact_laws", "bad-uncompiled"): Uncompiled,
    ("contact_laws", "bad-pulling"): Pulling,
    ("contact_laws", "bad-kind"): SpinUp,
    ("base_motions", "bad-inconsistent"): Inconsistent,
    ("base_motions", "bad-start"): NotFromZero,
    ("friction_laws", "bad-pushing"): Pushing,
    ("friction_laws", "bad-gaping"): Gaping,
    ("friction_laws", "bad-weak"): WeakWhenStuck,
}.items():
    register(*_name)(_part)


@pytest.mark.parametrize("case", BAD)
def test_a_bad_part_is_one_line(case):
    changes, words = BAD[case]
    with pytest.raises(InputError) as refused:
        Scenario.builtin("paper").replace(**changes)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("kind", "name"), [("laws", "mine"), ("friction_laws", "../mine"), ("friction_laws", "")])
def test_parts_register_under_plain_names(kind, name):
    with pytest.raises(InputError, match=r"^register: "):
        register(kind, name)


def test_the_elastic_stop_stores_half_of_stiffness_times_depth_squared():
    assert ElasticStop(1e6).energy(-1e-3) == pytest.approx(0.5)
