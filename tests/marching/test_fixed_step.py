"""Fixed steps on the beam: contact is noticed up to a step late."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact.validation.runs import event_times

FRICTIONLESS = ("contact.friction=frictionless", "end_time=0.335")


@pytest.mark.slow
def test_fixed_step_converges_to_the_located_events(run):
    """Contact is noticed a random part of a free step late, so errors stay below a multiple of the step."""
    exact = event_times(run("paper", *FRICTIONLESS))
    for free_step in (1e-5, 1e-6, 1e-7):
        steps = (f"solver.free_step={free_step}", f"solver.contact_step={free_step / 10}")
        history = run("paper", *FRICTIONLESS, "solver.scheme=fixed-step", *steps)
        assert [e.kind.value for e in history.events[:3]] == ["impact", "release", "impact"]
        assert np.abs(event_times(history)[:3] - exact[:3]).max() < 8.0 * free_step
