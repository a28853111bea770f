"""A stop behind what the modes leave out: one force for any stiffness and damping, and its limits."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

from oblique_impact import Outcome, Scenario, simulate
from oblique_impact.contact.forces import stop_force
from oblique_impact.contact.state import Candidate
from oblique_impact.contact.stops import ElasticStop


def in_series(law, compliance: float, depth: float, rate: float) -> float:
    """Force (N) of a law behind a compliance (m/N), by Brent's method on the compression of the stop itself.

    Its part of the rate is its part of the depth at rest.
    """

    def compression(stop_rate: float) -> float:
        excess = lambda d: max(0.0, law(d, stop_rate)) - (depth - d) / compliance  # noqa: E731
        return brentq(excess, 0.0, depth, xtol=1e-300, rtol=1e-15, maxiter=10_000)

    rate *= compression(0.0) / depth
    own = compression(rate)
    shorter, longer = own * (1.0 - 1e-12), own * (1.0 + 1e-12)
    softer = law(longer, rate) - law(shorter, rate) < (longer - shorter) / compliance
    return max(0.0, law(own, rate)) if softer else (depth - own) / compliance  # what is known to more digits


LAWS = {
    "spring": lambda k, c: lambda d, rate: k * d * (1.0 + c * rate),
    "Hertz": lambda k, c: lambda d, rate: k * d**1.5 * (1.0 + c * rate),
    "progressive": lambda k, c: lambda d, rate: k * (d + 1e6 * d**3) * (1.0 + c * rate),
    "with a gap": lambda k, c: lambda d, rate: k * max(0.0, d - 1e-4) * (1.0 + c * rate),
    "saturated": lambda k, c: lambda d, rate: min(k * d, 100.0) * (1.0 + c * rate),
}


@pytest.mark.parametrize("name", LAWS)
def test_the_force_in_series_is_found_for_any_stiffness_damping_and_rate(name):
    """Stiffnesses to 1e30, damping to 100 s/m, closing and opening: 300 cases of each law."""
    random = np.random.default_rng(46)
    for _ in range(300):
        k, compliance, c = (float(10.0**e) for e in random.uniform((3.0, -11.0, -3.0), (30.0, -5.0, 2.0)))
        depth, rate = float(10.0 ** random.uniform(-9.0, -2.0)), float(2.0 * random.normal())
        law, stop = LAWS[name](k, c), Candidate(compliant=1, compliance=compliance)
        wanted = in_series(law, compliance, depth, rate)
        close = {"rel": 1e-11, "abs": 1e-14 * depth / compliance}
        assert stop_force(law, stop, depth, rate) == pytest.approx(wanted, **close)
        if name == "spring":
            spring = ElasticStop(k, c)
            assert stop_force(None, stop.changed(**spring.stop), depth, rate) == pytest.approx(wanted, **close)
            at_rest = in_series(law, compliance, depth, 0.0)
            held = 0.5 * at_rest * depth
            assert spring.peak_energy(depth, at_rest, compliance) == pytest.approx(held, rel=1e-11)


def test_the_force_in_series_falls_to_zero_without_a_jump_as_the_stop_opens():
    """However stiff and damped: between two rates that differ by 1e-6 m/s it changes by as little."""
    rates = np.linspace(0.0, 20.0, 2001)
    for ratio in (0.1, 1.0, 3.0, 30.0, 1e6):
        stop = Candidate(compliant=1, stiffness=1e6, damping=0.5, compliance=ratio / 1e6)
        forces = np.array([stop_force(None, stop, 1e-3, -rate) for rate in rates])
        steepest = 1e6 * 1e-3 * 0.5
        assert np.abs(np.diff(forces)).max() < 1.001 * steepest * rates[1]
        assert (np.diff(forces) <= 0.0).all()
        assert forces[-1] == 0.0 or ratio > 3.0


def first_contact(stiffness: float, *keys: str):
    scenario = Scenario.builtin("paper", ["contact.normal=spring", f"contact.stiffness={stiffness}", *keys])
    history = simulate(scenario.replace(end_time=0.322, solver__output_interval=1e-3))
    return history, history.contacts[0] if history.contacts else None


@pytest.mark.parametrize("damping", [0.0, 0.1, 5.0])
def test_a_stiff_stop_tends_to_the_rigid_one_behind_the_residual_flexibility(damping):
    """The compliance 1/k of the stop adds to that of the beam: what differs from the limit goes like 1/k.

    At 1e10 N/m by some 2e-5 of the force; from 1e15 on it is rounding, to 1e30 N/m.
    """
    found = {}
    for k in (1e9, 1e10, 1e11, 1e12, 1e15, 1e20, 1e30):
        history, contact = first_contact(k, f"contact.damping={damping}")
        assert history.outcome is Outcome.COMPLETED
        assert abs(history.balance["unaccounted"]) < 1e-10
        found[k] = np.array([contact.peak_force, contact.normal_impulse, contact.end])
    limit = found[1e30]
    np.testing.assert_allclose(found[1e15], limit, rtol=1e-9)
    np.testing.assert_allclose(found[1e20], limit, rtol=1e-9)
    apart = np.abs(np.array([found[k] - limit for k in (1e10, 1e11, 1e12)]))
    assert (apart[0] / limit < [3e-5, 1e-5, 1e-6]).all()
    np.testing.assert_allclose(apart[:-1] / apart[1:], 10.0, rtol=0.02)
    compliance = contact.compliance
    assert limit[0] == pytest.approx(found[1e9][0] * (1.0 + 0.5e-9 / compliance), rel=1e-4)


def test_without_residual_flexibility_the_force_grows_like_the_root_of_the_stiffness():
    """Impulse and end of the contact tend to their limits, like the duration pi (m/k)^1/2."""
    stiffnesses = np.array([1e8, 1e10, 1e12, 1e14, 1e16])
    contacts = [first_contact(k, "contact.residual_flexibility=false")[1] for k in stiffnesses]
    peaks, impulses, lasts = np.array([(c.peak_force, c.normal_impulse, c.end - c.start) for c in contacts]).T
    np.testing.assert_allclose(peaks[1:] / np.sqrt(stiffnesses[1:]), peaks[-1] / 1e8, rtol=2e-4)
    np.testing.assert_allclose(impulses[1:], impulses[-1], rtol=2e-5)
    np.testing.assert_allclose(lasts[:-1] * np.sqrt(stiffnesses[:-1]), lasts[1] * 1e5, rtol=2e-3)


@pytest.mark.parametrize("damping", [0.0, 0.1])
@pytest.mark.parametrize("stiffness", [1e20, 1e30])
def test_a_contact_that_time_cannot_resolve_ends_by_name(stiffness, damping):
    """At 0.3 s times have a unit of rounding of 6e-17 s; a contact of 1e-9 s times that is none."""
    keys = "contact.residual_flexibility=false", f"contact.damping={damping}"
    history, _ = first_contact(stiffness, *keys)
    assert history.outcome is Outcome.STEP_UNDERFLOW
    assert abs(history.balance["unaccounted"]) < 1e-9


@pytest.mark.parametrize("stiffness", [1e6, 2e6, 3e6, 4e6, 7e6, 1e7])
@pytest.mark.parametrize("damping", [0.5, 5.0])
def test_a_damped_stop_that_opens_fast_completes(stiffness, damping):
    history, contact = first_contact(stiffness, f"contact.damping={damping}")
    assert history.outcome is Outcome.COMPLETED
    assert history.steps < 3000
    assert 500.0 < contact.peak_force < 695.0
    assert history.balance["lost_damping"] > 0.0
    assert abs(history.balance["unaccounted"]) < 1e-10
