"""Elastic rods that strike a wall, under every scheme: force, impulse and duration in closed form."""

import numpy as np
import pytest

from oblique_impact import simulate_system
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.marching.event import EventScheme
from oblique_impact.marching.fixed_step import FixedStepScheme
from oblique_impact.marching.generalized_alpha import GeneralizedAlphaScheme
from oblique_impact.validation.checks.rods import BAR, bouncing_bar, strike

STEP = 0.2 * 0.5 / 30.0  # s; a fifth of the time of a wave through one of twenty elements
SCHEMES = {
    "event": EventScheme(1e-7),
    "fixed-step": FixedStepScheme(STEP, STEP),
    "generalized-alpha": GeneralizedAlphaScheme(STEP, STEP, 1.0),
}


@pytest.mark.parametrize("scheme", SCHEMES)
def test_force_impulse_and_duration_of_a_bar(scheme):
    """Without gravity the force is constant, F = 300; with it F = 300 (1 + t), to first order in the mesh."""
    for gravity, middle, impulse in ((0.0, 300.0, 200.0), (10.0, BAR["middle"], BAR["impulse"])):
        history = strike(bouncing_bar(20, gravity), 10.0, 0.8, SCHEMES[scheme])
        (contact,) = history.contacts
        assert float(history.at(BAR["tau"] / 2.0)["lambda_n"]) == pytest.approx(middle, rel=1e-3)
        assert contact.normal_impulse == pytest.approx(impulse, rel=0.014)
        assert contact.end == pytest.approx(BAR["tau"], abs=0.055 * BAR["tau"] + STEP)
        assert abs(history.summary["energy"]["unaccounted"]) < 1e-3 * history.summary["energy"]["initial"]


def test_a_speed_that_rounding_changes_has_the_scale_of_its_way():
    """Forces of an undeformed rod are rounding: a gap of a centimetre is not closed at t = 0."""
    for elements in (8, 10, 20):
        rod, stop = bouncing_bar(elements, 0.0), ElasticStop(30.0)
        history = simulate_system(rod, rod.at(1e-2), np.full(elements, -10.0), 2e-3, contact_law=stop)
        assert history.contacts[0].start == pytest.approx(1e-3, rel=1e-9)
