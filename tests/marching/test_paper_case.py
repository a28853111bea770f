"""The paper's case: sticks, jams and bounces of a rigid stop at the times of theory Secs. 4 and 8."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest


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
