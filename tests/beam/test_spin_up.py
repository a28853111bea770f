"""The spin-up of Simo and Vu-Quoc where the model fails; where it holds, the checks "spin-up" have the numbers."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import Outcome, Scenario
from oblique_impact.validation.reference_values import VALUES


@pytest.mark.parametrize("modes", [1, 8])
def test_zeroth_order_kinetics_fail(run, modes):
    """Without foreshortening the rotating beam softens: unstable above its first frequency (Kane et al. 1987)."""
    history = run("spin-up", f"discretization.modes={modes}", "discretization.kinetics=zeroth-order")
    beyond = np.abs(history["deflection"].values) > 0.5 * Scenario.builtin("spin-up").beam.length
    assert history.outcome is Outcome.LARGE_DEFLECTION
    assert beyond.any()
    assert history["theta_dot"].values[np.argmax(beyond)] > VALUES["3-SVQ-w1"]
