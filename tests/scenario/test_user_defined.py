"""User-defined parts: each against a built-in one that it repeats, or a closed form; bad ones are one line."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from oblique_impact import Scenario, fem_beam, simulate, simulate_system
from oblique_impact.beam.base_motion import BaseMotion
from oblique_impact.contact.friction import Branch, FrictionCurve, FrictionLaw, Frictionless
from oblique_impact.contact.impacts import ImpactLaw, newton_impulse
from oblique_impact.contact.stops import ContactLaw
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from tests.docs.test_commands import DOCS, blocks
from tests.refusals import refused_in_one_line
from tests.systems import Block, PowerLaw


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


@dataclass(frozen=True)
class Newton(ImpactLaw):
    restitution: float = 0.5

    def impulse(self, instant, restitution):
        return newton_impulse(instant, restitution)


PAPER = Scenario.builtin("paper").replace(end_time=0.34, solver__output_interval=1e-3)


def times(history):
    return np.array([event.time for event in history.events])


# --- each part against the built-in one that it repeats


@pytest.mark.parametrize(
    ("scheme", "apart"),
    [
        ("event", 1e-10),
        pytest.param("fixed-step", 1e-12, marks=pytest.mark.slow),
        pytest.param("generalized-alpha", 1e-9, marks=pytest.mark.slow),
    ],
)
def test_a_contact_law_is_the_elastic_stop_that_it_repeats(scheme, apart):
    steps = {} if scheme == "event" else {"solver__contact_step": 2e-6}
    scenario = PAPER.replace(solver__scheme=scheme, contact__normal="spring", **steps)
    built_in = simulate(scenario.replace(contact__damping=0.3))
    own = simulate(scenario, contact_law=PowerLaw(exponent=1.0, damping=0.3))
    assert len(own.events) == len(built_in.events) > 4
    assert_allclose(times(own), times(built_in), rtol=0, atol=apart)
    for entry in ("contact", "lost_damping", "final"):
        assert own.summary["energy"][entry] == pytest.approx(built_in.summary["energy"][entry], rel=1e-6, abs=1e-9)
    assert own.summary["energy"]["lost_damping"] > 0.1


def test_a_mass_on_a_power_law_stop_leaves_as_it_came():
    """Contact lasts 2 d / v B(1/(n+1), 1/2) / (n+1); the depth d follows from 1/2 m v^2 = k d^(n+1) / (n+1)."""
    from scipy.special import beta

    speed, n, k = 0.5, 1.5, 1e6
    mass = Block(lambda t, q, qd: (0.0, 0.0))
    history = simulate_system(
        mass, [0.0, 1e-3], [0.0, -speed], 0.03, contact_law=PowerLaw(k, n), output_interval=1e-3
    )
    begin, end = times(history)
    depth = ((n + 1) * 0.5 * speed**2 / k) ** (1.0 / (n + 1))
    assert begin == pytest.approx(1e-3 / speed, abs=1e-12)
    assert end - begin == pytest.approx(2.0 * depth / speed * beta(1.0 / (n + 1), 0.5) / (n + 1), rel=1e-8)
    assert float(history["qd"][-1, 1]) == pytest.approx(speed, rel=1e-9)
    assert abs(history.summary["energy"]["unaccounted"]) < 1e-10


@pytest.mark.parametrize("exact", [False, True])
def test_a_base_motion_is_the_spin_up_that_it_repeats(exact):
    base = PAPER.replace(root__kind="driven", initial__angle=0.5, contact__enabled=False, end_time=0.6)
    if exact:
        steps = {"solver__free_step": 5e-3, "solver__output_interval": 0.1}
        base = base.replace(discretization__method="absolute", discretization__elements=2, **steps)
    built_in = simulate(base.replace(root__profile="spin-up", root__spin_rate=4.0, root__spin_up_time=0.5))
    own = simulate(base, base_motion=SpinUp())
    assert_allclose(own["q"], built_in["q"], rtol=0, atol=1e-11)
    assert own.summary["energy"]["supplied"] == pytest.approx(built_in.summary["energy"]["supplied"], rel=1e-9)


def test_a_friction_law_is_the_modified_coulomb_law_that_it_repeats():
    built_in = simulate(PAPER.replace(contact__friction="modified-coulomb"))
    own = simulate(PAPER, friction=FrictionCurve(((0.0, 0.0), (1e-3, 0.0), (1e-2, 0.3))))
    assert [e.kind for e in own.events] == [e.kind for e in built_in.events]
    assert_allclose(times(own), times(built_in), rtol=0, atol=1e-9)
    assert own.summary["energy"]["lost_friction"] == pytest.approx(built_in.summary["energy"]["lost_friction"])


def test_the_exact_beam_takes_a_friction_law():
    steps = {"solver__free_step": 2e-5, "solver__contact_step": 2e-5, "end_time": 2e-3}
    near = {"initial__angle": 0.2214, "initial__angular_velocity": -3.786, "discretization__elements": 4}
    base = PAPER.replace(**ABSOLUTE, **near, **steps)
    built_in = simulate(base.replace(contact__friction="modified-coulomb"))
    own = simulate(base, friction=FrictionCurve(((0.0, 0.0), (1e-3, 0.0), (1e-2, 0.3))))
    assert built_in.summary["energy"]["lost_friction"] > 0.0
    assert_allclose(own["q"], built_in["q"], rtol=0, atol=1e-12)
    assert "FrictionCurve" in own.summary["provenance"]["user_defined"]["friction"]


def test_routh_takes_the_friction_law_of_the_run():
    rough = PAPER.replace(contact__impact="routh", end_time=0.33)
    of = [
        simulate(rough),
        *(simulate(rough, friction=law) for law in (FrictionCurve(((0.0, 0.3),), 0.3), Frictionless())),
    ]
    built_in, own, smooth = (history.events[0].tangential_impulse for history in of)
    assert own == pytest.approx(built_in, rel=1e-12)
    assert abs(built_in) > 0.0
    assert smooth == 0.0


def test_an_impact_law_is_the_one_that_it_repeats():
    built_in = simulate(PAPER.replace(contact__restitution=0.5))
    assert_allclose(times(simulate(PAPER, impact_law=Newton())), times(built_in), rtol=0, atol=0)


def in_views(scenario):
    """Operators whose arrays are every other number of larger ones."""
    found = fem_beam.build_operators(scenario)
    arrays = {f.name: v for f in fields(found) if isinstance(v := getattr(found, f.name), np.ndarray)}
    return replace(found, **{name: np.repeat(v, 2, axis=-1)[..., ::2] for name, v in arrays.items()})


@pytest.mark.parametrize("build", [fem_beam.build_operators, in_views])
def test_a_discretization_is_the_built_in_one_that_it_repeats(build):
    built_in = simulate(PAPER.replace(discretization__method="fem"))
    own = simulate(PAPER, discretization=SimpleNamespace(build_operators=build, spectrum=fem_beam.spectrum))
    assert_allclose(own["q"], built_in["q"], rtol=0, atol=1e-12)


def test_a_history_names_the_parts_that_made_it(tmp_path):
    history = simulate(
        PAPER.replace(end_time=0.01), impact_law=Newton(0.25), friction=FrictionCurve(((0.0, 0.1),))
    )
    made = type(history).load(history.save(tmp_path)).summary["provenance"]["user_defined"]
    assert made["impact_law"] == "Newton(restitution=0.25)"
    assert made.keys() == {"impact_law", "friction"}
    assert "user_defined" not in simulate(PAPER.replace(end_time=0.01)).summary["provenance"]


@pytest.mark.slow  # its laws are compiled anew each time; the tests above try each kind of part
def test_the_parts_of_the_how_to_run():
    names: dict = {}
    for block in blocks(DOCS / "howto" / "own-parts.md", "python"):
        if "MassOnBelt" not in block:  # of the gallery
            exec(block, names)
    pressed = names["history"]
    of_stop = names["Hertz"]().stiffness * pressed["depth"].values ** 2.5 / 2.5
    of_modes_left_out = pressed["energy_contact"].values - of_stop  # their flexibility, in series with the stop
    assert of_stop.max() > 0.1
    assert of_modes_left_out.min() > -1e-9
    assert abs(pressed.summary["energy"]["unaccounted"]) < 1e-9
    law = names["ViscousCoulomb"]()
    forwards, backwards = law.branch(0.1, 1), law.branch(-0.1, -1)
    assert forwards.intercept + forwards.slope * 0.1 == pytest.approx(-(0.3 + 0.05 * 0.1))
    assert backwards.intercept - backwards.slope * 0.1 == pytest.approx(0.3 + 0.05 * 0.1)


# --- what is refused


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


SPRING = {"contact__normal": "spring"}
TURNED = {"root__kind": "driven"}
NODAL = {"discretization__method": "fem", "discretization__modes": 0}
ABSOLUTE = {"discretization__method": "absolute", **SPRING}
STEPS = EventScheme(1e-8)
ANYWHERE = {"contact__where": "anywhere"}
REFUSED = {
    "wrong kind": ({"contact_law": SpinUp()}, {}, "contact_law = SpinUp(speed=4.0, period=0.5): should be a Cont"),
    "a class": ({"friction": FrictionCurve}, {}, "should be a FrictionLaw"),
    "no discretization": ({"discretization": 3}, {}, "should be a Discretization"),
    "rigid stop": ({"contact_law": PowerLaw()}, {}, 'contact_law: only with contact.normal = "spring"'),
    "no impacts": ({"impact_law": Newton()}, SPRING, 'impact_law: only with contact.normal = "rigid"'),
    "pin": ({"base_motion": SpinUp()}, {}, 'base_motion: only with root.kind = "driven" (it is "pin")'),
    "two motions": (
        {"base_motion": SpinUp()},
        {**TURNED, "root__profile": "constant-speed", "root__spin_rate": 1.0},
        "root.spin_rate = 0",
    ),
    "elastic stops alone": (
        {"scheme": GeneralizedAlphaScheme(1e-4, 1e-5)},
        {},
        "scheme: should be an EventScheme or TimeSteppingScheme with a rigid stop, not GeneralizedAlphaScheme",
    ),
    "nodal": ({"scheme": STEPS}, NODAL, "scheme: only with discretization.modes >= 1"),
    "scheme of several": ({"scheme": STEPS}, ANYWHERE, 'scheme: only with contact.where = "point"'),
    "impacts of several": ({"impact_law": Newton()}, ANYWHERE, 'impact_law: only with contact.where = "point"'),
    "exact": ({"contact_law": PowerLaw()}, ABSOLUTE, 'contact_law: only with discretization.method = "modal" or'),
    "not compiled": ({"contact_law": Uncompiled()}, SPRING, "Uncompiled.normal_force: cannot be compiled"),
    "pulls": ({"contact_law": Pulling()}, SPRING, "Pulling: the force at rest at a depth of"),
    "inconsistent": ({"base_motion": Inconsistent()}, TURNED, "the acceleration is not the"),
    "not from zero": ({"base_motion": NotFromZero()}, TURNED, "the angle at t = 0 is 1"),
    "pushes": ({"friction": Pushing()}, {}, "pushes along the slip at"),
    "gapes": ({"friction": Gaping()}, {}, "Gaping: no branch begins at"),
    "weak when stuck": ({"friction": FrictionCurve(((0.0, 0.5), (1.0, 0.4)), static=0.2)}, {}, "static = 0.2"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_part_that_does_not_fit_is_one_line(case):
    parts, changes, words = REFUSED[case]
    with refused_in_one_line(words):
        simulate(PAPER.replace(**changes), **parts)
