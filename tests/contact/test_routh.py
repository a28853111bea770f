"""Impacts with friction by Routh's method: paths by hand, beyond the check `small-systems.rod-impact`."""

import pytest

from oblique_impact.contact.impacts import routh_impulse
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
