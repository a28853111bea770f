"""Friction holds a beam on an elastic stop."""

from __future__ import annotations

import numpy as np

from oblique_impact import Scenario, simulate


def test_friction_sticks_on_an_elastic_stop():
    overrides = [
        "contact.normal=spring",
        "contact.stiffness=1e5",
        "contact.mu_static=12",
        "contact.mu_kinetic=12",
        "discretization.frame=mean-axis",
        "discretization.modes=4",
        "end_time=0.34",
    ]
    history = simulate(Scenario.builtin("paper", overrides))
    stuck = history["state"].values == 2
    assert stuck.sum() > 10
    assert np.abs(history["slip_rate"].values[stuck]).max() < 1e-8
    cone = 12.0 * history["lambda_n"].values[stuck] - np.abs(history["lambda_tau"].values[stuck])
    assert cone.min() > -1e-6
