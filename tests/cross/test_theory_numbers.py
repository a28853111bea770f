"""The numbers of theory Sec. 8, on both discretizations.

Sources: `benchmarks/reference_impact.py` (SciPy alone, two clamped modes); the rigid bar's first touch in closed
form (elliptic integral).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

FRICTIONLESS = [
    ("impact", 0.3171473192),
    ("release", 0.3194243426),
    ("impact", 0.3215519110),
    ("release", 0.3271825776),
    ("impact", 0.3294994229),
    ("release", 0.3303667026),
]
HYBRID = [
    ("impact", 0.3171473192),
    ("release", 0.3194229069),
    ("impact", 0.3215523998),
    ("reversal", 0.3235971200),
    ("release", 0.3271806857),
    ("impact", 0.3295061743),
    ("reversal", 0.3299378327),
    ("release", 0.3303660603),
]
MODAL = ()
FEM = ("discretization.method=fem", "discretization.elements=64")


@pytest.mark.parametrize("discretization", [MODAL, FEM], ids=["modal", "fem-64"])
@pytest.mark.parametrize(
    ("friction", "expected"), [("frictionless", FRICTIONLESS), ("hybrid", HYBRID)], ids=["frictionless", "hybrid"]
)
def test_first_macro_collision_of_two_clamped_modes(run, discretization, friction, expected):
    history = run("paper", f"contact.friction={friction}", *discretization)
    events = history.events[: len(expected)]
    assert [e.kind.value for e in events] == [kind for kind, _ in expected]
    np.testing.assert_allclose([e.time for e in events], [t for _, t in expected], rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("discretization", [MODAL, FEM], ids=["modal", "fem-64"])
def test_first_impulse(run, discretization):
    history = run("paper", "contact.friction=frictionless", *discretization)
    # 64 elements differ by h^4: (beta_2 h)^4/1440 is 2e-8 of the second frequency
    assert history.events[0].normal_impulse == pytest.approx(0.356576404, rel=1e-7)


@pytest.mark.parametrize("frame", ["tangent", "mean-axis"])
def test_energy_at_rest(run, frame):
    history = run("paper", f"discretization.frame={frame}")
    # m g L/2 sin(theta0), theta0 = pi/4
    expected = 0.5 * 2766.7 * 3.14e-4 * 9.8 * np.sin(np.pi / 4)
    assert history.summary["energy"]["initial"] == pytest.approx(expected, rel=1e-14)
    assert expected == pytest.approx(3.0100, abs=5e-5)


def test_theta_dot_stays_moderate_in_the_mean_axis_frame_only(run):
    mean_axis = run("paper", "discretization.frame=mean-axis", "discretization.modes=4")
    tangent = run("paper", "discretization.frame=tangent", "discretization.modes=4")
    assert np.abs(mean_axis["theta_dot"]).max() < 4.0
    assert np.abs(tangent["theta_dot"]).max() > 20.0


# Sec. 6, rigid frictionless stop: mean-axis modes -> impulse of the first macro-collision, energy left
RIGID_STOP = {4: (1.834, 2.355), 6: (1.861, 2.416), 8: (1.864, 2.444), 10: (1.854, 2.475), 16: (1.890, 2.509)}


@pytest.mark.parametrize("modes", RIGID_STOP)
def test_rigid_stop_against_the_number_of_modes(run, modes):
    history = run(
        "paper",
        "contact.friction=frictionless",
        "discretization.frame=mean-axis",
        f"discretization.modes={modes}",
        "end_time=0.34",
    )
    collision = history.summary["macro_collisions"][0]
    impulse, energy = RIGID_STOP[modes]
    assert 0.32840 < collision["end"] < 0.32880
    # the source prints three decimals, cut rather than rounded
    assert impulse <= collision["normal_impulse"] + 1e-5 < impulse + 1.1e-3
    assert history.summary["energy"]["final"] == pytest.approx(energy, abs=1e-3)


def test_painleve_configuration_at_the_second_impact(run):
    history = run(
        "paper",
        "discretization.frame=mean-axis",
        "discretization.modes=3",
        "contact.mu_static=20",
        "contact.mu_kinetic=20",
    )
    assert history.outcome.label == "painleve"
    assert history.summary["end_time"] == pytest.approx(0.32372, abs=1e-5)


def test_long_sticks_below_the_painleve_coefficient(run):
    history = run(
        "paper",
        "discretization.frame=mean-axis",
        "discretization.modes=3",
        "contact.mu_static=12",
        "contact.mu_kinetic=12",
    )
    events = history.events
    sticks = [b.time - a.time for a, b in pairwise(events) if a.state.name == "STICK"]
    assert max(sticks) > 3e-3


def test_bounces_of_one_touch_down_end_in_finite_time(run):
    """Bounces at e = 0.5 shrink geometrically; contact closes and goes on."""
    history = run("bouncing")
    rebounds = [e for e in history.events if e.kind.value == "rebound"]
    closing = next(e for e in history.events if e.kind.value == "impact")
    flights = np.diff([e.time for e in rebounds if e.time < closing.time][-7:])
    np.testing.assert_allclose(flights[1:] / flights[:-1], 0.5, rtol=2e-2)
    assert closing.state.name == "SLIP"
    # sum of the geometric series, found independently with SciPy's solve_ivp and own Gauss integrals
    assert closing.time == pytest.approx(0.3190272, abs=2e-7)
    assert history.outcome.label == "completed"
    later = history["gap"].values[(history["time"] > closing.time) & (history["time"] < closing.time + 1e-3)]
    assert np.abs(later).max() < 1e-9


def test_paper_judgement_sticks_without_the_contact_points_shortening(run):
    """Theory Sec. 4: three sticks of about 0.1 ms at 0.3232, 0.3250 and 0.3268 s."""
    scheme = ("solver.scheme=fixed-step", "solver.stick=force")
    history = run("paper", *scheme, "contact.shortening=false", "end_time=0.34")
    events = history.events
    sticks = [(a.time, b.time - a.time) for a, b in pairwise(events) if a.state.name == "STICK"]
    long = [start for start, duration in sticks if duration > 4e-5]
    np.testing.assert_allclose(long, [0.3232, 0.3250, 0.3268], atol=1e-4)
