"""Bounces on a rigid stop end in finite time, and the contact goes on."""

from __future__ import annotations

import numpy as np
import pytest


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
