"""Small systems over many calls of a march."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import simulate_system
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.impacts import NewtonImpact
from oblique_impact.contact.state import State
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.validation.small_systems import FreeRod, Particle
from tests.small.systems import GRAVITY, PulledMass, completed, kinds_of, last, scheme_of, times_of

ROUGH, ROD = Coulomb(0.4, 0.3), FreeRod(gravity=GRAVITY)
SYSTEMS = {
    "ball at rest": (Particle(above=-GRAVITY), [0.0, 0.0], [0.0, 0.0], {}),
    "sliding block": (Particle(above=-GRAVITY, along=-0.5), [0.0, 0.0], [4.0, 0.0], {}),
    "pulled mass": (PulledMass(stiffness=20.0, pull=0.2), [0.0, 0.0], [0.0, 0.0], {}),
    "mass on a belt": (Particle(above=-GRAVITY, stiffness=40.0, belt_speed=0.3), [0.0, 0.0], [0.0, 0.0], {}),
    "ball on a spring": (Particle(above=-GRAVITY), [0.0, 0.05], [0.3, 0.0], {"contact_law": ElasticStop(1e4)}),
    "bouncing ball": (Particle(above=-GRAVITY), [0.0, 0.2], [0.3, 0.0], {"impact_law": NewtonImpact(0.5)}),
    "rod": (ROD, ROD.at(1.2, 0.05), np.zeros(3), {}),
}


def marched(name, scheme, step, steps, friction=ROUGH):
    system, q0, qd0, options = SYSTEMS[name]
    end = step * steps
    chosen = {"friction": friction, "scheme": scheme_of(scheme, step), "output_interval": end / 50}
    return completed(simulate_system(system, q0, qd0, end, **chosen, **options))


def test_a_sliding_block_stops_after_many_calls():
    """It brakes at 0.3 g + 0.5 m/s^2 from 4 m/s, and then friction holds it."""
    history = marched("sliding block", "generalized-alpha", 4e-4, 4500)
    brake = 0.3 * GRAVITY + 0.5
    assert kinds_of(history) == ["stick"]
    assert times_of(history)[0] == pytest.approx(4.0 / brake, abs=1e-6)
    assert last(history, "state") == State.STICK
    assert last(history, "slip") == pytest.approx(4.0**2 / (2.0 * brake), abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["fixed-step", "generalized-alpha"])
@pytest.mark.parametrize("name", SYSTEMS)
def test_small_systems_reach_their_end_over_1e5_steps(name, scheme):
    history = marched(name, scheme, 1e-4, 100_000)
    energy = history.summary["energy"]
    assert history.summary["steps"] >= 100_000
    assert abs(energy["unaccounted"]) < 1e-4 * (1.0 + abs(energy["initial"]))
