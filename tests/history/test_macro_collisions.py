"""Macro-collisions: contacts are grouped by times of the beam itself, whatever its discretization and its size."""

from __future__ import annotations

import math

import numpy as np
import pytest

from oblique_impact import Scenario, natural_frequencies, simulate, simulate_system
from oblique_impact.beam.frequencies import clustering_time, lowest_elastic_frequency
from oblique_impact.contact.impacts import NewtonImpact
from tests.systems import Block


def scaled(scenario, length, time):
    """A similar beam: lengths and times of other sizes, with the gravity and the modulus that this takes."""
    beam, (x, y) = scenario.beam, scenario.slope.origin
    return scenario.replace(
        end_time=time * scenario.end_time,
        gravity=length / time**2 * scenario.gravity,
        beam__length=length * beam.length,
        beam__area=length**2 * beam.area,
        beam__second_moment=length**4 * beam.second_moment,
        beam__youngs_modulus=length**2 / time**2 * beam.youngs_modulus,
        slope__origin=[length * x, length * y],
        contact__point=length * scenario.contact.point,
        solver__output_interval=time * scenario.solver.output_interval,
    )


def test_a_similar_beam_of_a_centimetre_has_as_many(run):
    time = 0.1
    history, small = run("paper"), simulate(scaled(Scenario.builtin("paper"), 1e-2, time))
    assert small.clustering_time == pytest.approx(time * history.clustering_time, rel=1e-12)
    ours, theirs = (h.summary["macro_collisions"] for h in (small, history))
    assert [m["contacts"] for m in ours] == [m["contacts"] for m in theirs]
    assert len(ours) == 3
    for one, other in zip(ours, theirs, strict=True):
        assert one["start"] == pytest.approx(time * other["start"], rel=1e-7)


def test_the_gap_of_the_paper():
    """Two periods of 2 pi / 384.6 rad/s; a tenth of sqrt(1 m / 9.8 m/s^2) is shorter."""
    paper = Scenario.builtin("paper")
    assert lowest_elastic_frequency(paper) == pytest.approx(384.854, abs=1e-3)
    assert clustering_time(paper) == pytest.approx(4.0 * math.pi / 384.854, rel=1e-6)
    assert clustering_time(Scenario.builtin("rigid-limit")) == pytest.approx(0.1 * math.sqrt(0.3 / 9.8), rel=1e-14)
    assert clustering_time(paper.replace(gravity=0.0)) == clustering_time(paper)


@pytest.mark.parametrize("root", ["pin", "hub", "driven"])
@pytest.mark.parametrize("tip_mass", [0.0, 0.5])
def test_the_lowest_elastic_frequency_is_that_of_fine_elements(root, tip_mass):
    """Of a uniform beam and of one whose sections follow a table, with and without a mass at its tip."""
    for name in ("paper", "tapered"):
        scenario = Scenario.builtin(name).replace(
            beam__tip_mass=tip_mass,
            root__kind=root,
            discretization__method="fem",
            discretization__elements=48,
            discretization__modes=2,
            discretization__frame="tangent",
        )
        found = natural_frequencies(scenario, count=2).flapwise[0]
        expected = found[0 if root == "driven" else 1]
        assert lowest_elastic_frequency(scenario) == pytest.approx(expected, rel=1e-5)


def ball(**options):
    return simulate_system(
        Block(lambda t, q, qd: (0.0, -9.8)),
        np.array([0.0, 1.0]),
        np.zeros(2),
        3.0,
        impact_law=NewtonImpact(0.5),
        **options,
    )


def test_contacts_of_a_small_system_are_their_own_collisions_unless_a_gap_is_given():
    single, grouped = ball(), ball(clustering_time=0.3)
    assert single.clustering_time == 0.0
    assert len(single.summary["macro_collisions"]) == len(single.contacts) >= 4
    assert len(grouped.summary["macro_collisions"]) == 2  # flights of 0.45 s, 0.23 s, ...
