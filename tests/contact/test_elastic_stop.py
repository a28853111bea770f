"""Friction holds a beam, and a block, on an elastic stop."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import Scenario, simulate, simulate_system
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.stops import ElasticStop
from tests.small.systems import scheme_of
from tests.systems import Block


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


@pytest.mark.parametrize("scheme", ["event", "generalized-alpha"])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_growing_pull_ends_the_stick_on_an_elastic_stop_at_the_edge_of_the_cone(scheme, direction):
    """The block lies as deep as its weight asks for: 20 N/s overcome 0.4 m g after 0.196 s."""
    block = Block(lambda t, q, qd: (direction * 20.0 * t, -9.8))
    history = simulate_system(
        block,
        [0.0, -9.8 / 1e4],
        [0.0, 0.0],
        0.25,
        friction=Coulomb(0.4, 0.3),
        contact_law=ElasticStop(1e4),
        scheme=scheme_of(scheme, 1e-3),
    )
    assert [event.kind.value for event in history.events] == ["impact", "slip"]
    assert history.events[1].time == pytest.approx(0.4 * 9.8 / 20.0, abs=1e-8)
    assert direction * float(history["slip_rate"][-1]) > 0.0
