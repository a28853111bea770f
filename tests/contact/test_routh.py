"""Impacts with friction by Routh's method: paths by hand, beyond the check `small-systems.rod-impact`."""

from math import exp, log

import pytest

from oblique_impact.contact.friction import Coulomb, FrictionCurve, Frictionless, ModifiedCoulomb
from oblique_impact.contact.impacts import newton_impulse, routh_impulse
from oblique_impact.contact.state import Candidate


@pytest.mark.parametrize(
    ("a_nt", "mu", "expected"), [(0.5, 0.6, "sticks"), (0.5, 0.2, "reverses"), (-0.5, 0.2, "on")]
)
def test_routh_after_the_slip_has_stopped(a_nt, mu, expected):
    """Slip -0.1 in, a_nn = a_tt = 1: the path by hand, piece by piece."""
    gap_rate, slip_rate = -1.0, -0.1
    moving = Candidate(
        gap_rate=gap_rate, slip_rate=slip_rate, a_nn=1.0, a_nt=a_nt, a_tt=1.0, gap_acceleration=-9.8
    )
    impulse = routh_impulse(moving, 0.0, mu)
    slip_growth, gap_growth = a_nt + mu, 1.0 + mu * a_nt
    if expected == "on":
        # friction and coupling work against each other: a_nt + mu < 0, the slip grows in its direction
        assert slip_growth < 0.0
        normal = 1.0 / gap_growth
        assert impulse.normal == pytest.approx(normal, rel=1e-14)
        assert impulse.tangential == pytest.approx(mu * normal, rel=1e-14)
        return
    first = 0.1 / slip_growth
    ratio = -a_nt if expected == "sticks" else -mu
    second = (1.0 - gap_growth * first) / (1.0 + ratio * a_nt)
    assert impulse.normal == pytest.approx(first + second, rel=1e-14)
    assert impulse.tangential == pytest.approx(mu * first + ratio * second, rel=1e-14)
    slip_after = slip_rate + a_nt * impulse.normal + impulse.tangential
    assert slip_after == pytest.approx(0.0 if expected == "sticks" else (a_nt - mu) * second, abs=1e-14)


def test_routh_passes_a_painleve_configuration():
    """a_nn - mu a_nt < 0: sliding drives the bodies together, but the slip stops before compression ends."""
    c = Candidate(gap_rate=-1.0, slip_rate=1.0, a_nn=1.0, a_nt=0.8, a_tt=1.0, gap_acceleration=-9.8)
    impulse = routh_impulse(c, 0.0, 1.5)
    first = 1.0 / (1.5 * 1.0 - 0.8)  # until the slip stops; then |a_nt| < mu a_tt: it sticks
    second = (1.0 + (1.5 * 0.8 - 1.0) * first) / (1.0 - 0.8**2)
    assert impulse.normal == pytest.approx(first + second, rel=1e-14)
    assert impulse.tangential == pytest.approx(-1.5 * first - 0.8 * second, rel=1e-14)


def striking(gap_rate: float, slip_rate: float, a_nt: float = 0.0) -> Candidate:
    """A contact with a_nn = a_tt = 1."""
    return Candidate(gap_rate=gap_rate, slip_rate=slip_rate, a_nn=1.0, a_nt=a_nt, a_tt=1.0)


@pytest.mark.parametrize("restitution", [0.0, 0.5, 1.0])
def test_without_friction_poissons_restitution_is_newtons(restitution):
    """Compression ends at P = v/a_nn, so that e times as much again leaves the gap rate e v."""
    moving = striking(-2.0, 0.7, 0.4)
    poisson, newton = routh_impulse(moving, restitution, Frictionless()), newton_impulse(moving, restitution)
    assert poisson == pytest.approx(newton, rel=1e-14, abs=1e-15)
    assert moving.gap_rate + poisson.normal == pytest.approx(2.0 * restitution, abs=1e-14)


@pytest.mark.parametrize("a_nt", [0.0, 0.5, -0.5])
@pytest.mark.parametrize("slip_rate", [2.0, -2.0])
def test_routh_with_friction_in_proportion_to_the_slip_velocity(slip_rate, a_nt):
    """dv/dP = a_nt - c v: the slip velocity decays towards a_nt/c, with P_tau = v - v0 - a_nt P."""
    c = 0.4
    impulse = routh_impulse(striking(-1.0, slip_rate, a_nt), 0.0, FrictionCurve(((0.0, 0.0), (10.0, 10.0 * c))))
    after = a_nt / c + (slip_rate - a_nt / c) * exp(-c * impulse.normal)
    assert impulse.tangential == pytest.approx(after - slip_rate - a_nt * impulse.normal, rel=1e-13)
    assert -1.0 + impulse.normal + a_nt * impulse.tangential == pytest.approx(0.0, abs=1e-14)
    whole = routh_impulse(striking(-1.0, slip_rate, a_nt), 0.5, FrictionCurve(((0.0, 0.0), (10.0, 10.0 * c))))
    assert whole.normal == pytest.approx(1.5 * impulse.normal, rel=1e-14)


@pytest.mark.parametrize(("approach", "ends"), [(2.0, "fast"), (4.0, "slow"), (8.0, "sticks")])
def test_routh_with_friction_that_grows_as_the_slip_ends(approach, ends):
    """mu = 0.2 down to 1 m/s, from there to 0.4 at rest: v = 1.5 - 0.2 P, then v = 2 - exp(0.2 (P - 2.5))."""
    law = FrictionCurve(((0.0, 0.4), (1.0, 0.2)), static=0.4)
    impulse = routh_impulse(striking(-approach, 1.5), 0.0, law)
    after = {"fast": 1.5 - 0.2 * approach, "slow": 2.0 - exp(0.2 * (approach - 2.5)), "sticks": 0.0}[ends]
    assert impulse.normal == pytest.approx(approach, rel=1e-14)
    assert impulse.tangential == pytest.approx(after - 1.5, rel=1e-13)
    assert approach > 2.5 + 5.0 * log(2.0) or ends != "sticks"


def test_routh_sticks_up_to_the_static_coefficient():
    """Slip that has ended begins anew where the coefficient of slip alone would not hold it."""
    struck = striking(-1.0, -0.1, 0.5)
    assert routh_impulse(struck, 0.0, Coulomb(0.2, 0.2)) == routh_impulse(struck, 0.0, 0.2)
    held = routh_impulse(struck, 0.0, Coulomb(0.6, 0.2))
    assert -0.1 + 0.5 * held.normal + held.tangential == pytest.approx(0.0, abs=1e-15)


def test_routh_without_a_stick_state_comes_to_rest_slowly():
    """Below v0 the modified Coulomb law has no force: the coupling alone makes it slip there."""
    impulse = routh_impulse(striking(-1.0, -0.1, 0.1), 0.0, ModifiedCoulomb(0.3, 0.02, 0.05))
    after = -0.1 + 0.1 * impulse.normal + impulse.tangential
    assert after == pytest.approx(0.0, abs=0.05)
    assert impulse.tangential > 0.0
