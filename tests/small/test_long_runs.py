"""Small systems over many calls of a march."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import simulate_system
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.impacts import NewtonImpact
from oblique_impact.contact.state import State
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.kernels.system import ContactRows, MechanicalSystem
from oblique_impact.validation.small_systems import FreeRod, Particle
from tests.small.systems import GRAVITY, PulledMass, completed, kinds_of, last, scheme_of, times_of


class TwoMasses(MechanicalSystem):
    """A mass on a belt, on a spring to the wall and one to a second mass; q = [x1, y1, x2]."""

    size = 3
    belt, wall, between, masses = 0.1, 40.0, 30.0, np.diag([1.0, 1.0, 0.5])

    def mass_matrix(self, t, q):
        return self.masses

    def forces(self, t, q, qd):
        pull = self.between * (q[2] - q[0])
        return np.array([pull - self.wall * q[0], -GRAVITY, -pull])

    def stiffness_matrix(self, t, q):
        a, b = self.wall, self.between
        return np.array([[a + b, 0.0, -b], [0.0, 0.0, 0.0], [-b, 0.0, b]])

    def contact(self, t, q, qd):
        normal, tangential = np.eye(3)[1], np.eye(3)[0]
        return ContactRows(q[1], q[0] - self.belt * t, qd[1], qd[0] - self.belt, normal, tangential)

    def energy(self, t, q, qd):
        elastic = 0.5 * self.wall * q[0] ** 2 + 0.5 * self.between * (q[2] - q[0]) ** 2
        return 0.5 * float(qd @ self.masses @ qd), elastic, GRAVITY * q[1]


ROUGH, ROD = Coulomb(0.4, 0.3), FreeRod(gravity=GRAVITY)
SYSTEMS = {
    "ball at rest": (Particle(above=-GRAVITY), [0.0, 0.0], [0.0, 0.0], {}),
    "sliding block": (Particle(above=-GRAVITY, along=-0.5), [0.0, 0.0], [4.0, 0.0], {}),
    "two masses": (TwoMasses(), np.zeros(3), np.zeros(3), {}),
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


def test_a_ball_at_rest_stays_where_it_is():
    history = marched("ball at rest", "generalized-alpha", 1e-4, 4500)
    assert np.all(history["gap"] == 0.0)
    np.testing.assert_allclose(history["lambda_n"][1:], GRAVITY, rtol=1e-12)  # the first is before the touch


def test_a_sliding_block_stops_after_many_calls():
    """It brakes at 0.3 g + 0.5 m/s^2 from 4 m/s, and then friction holds it."""
    history = marched("sliding block", "generalized-alpha", 4e-4, 4500)
    brake = 0.3 * GRAVITY + 0.5
    assert kinds_of(history) == ["stick"]
    assert times_of(history)[0] == pytest.approx(4.0 / brake, abs=1e-6)
    assert last(history, "state") == State.STICK
    assert last(history, "slip") == pytest.approx(4.0**2 / (2.0 * brake), abs=1e-6)


@pytest.mark.parametrize("step", [1e-4, 2.5e-5])
def test_two_masses_stick_and_slip_as_the_event_scheme_locates_it(step):
    steps = 5000  # 0.5 s: slip begins at 0.41 s
    located, stepped = (marched("two masses", s, step, steps) for s in ("event", "generalized-alpha"))
    assert kinds_of(stepped) == kinds_of(located)
    np.testing.assert_allclose(times_of(stepped), times_of(located), rtol=0, atol=1e3 * step**2)
    np.testing.assert_allclose(stepped["q"][-1], located["q"][-1], rtol=0, atol=10.0 * step**2)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["fixed-step", "generalized-alpha"])
@pytest.mark.parametrize("name", SYSTEMS)
def test_small_systems_reach_their_end_over_1e5_steps(name, scheme):
    history = marched(name, scheme, 1e-4, 100_000)
    energy = history.summary["energy"]
    assert history.summary["steps"] >= 100_000
    assert abs(energy["unaccounted"]) < 1e-4 * (1.0 + abs(energy["initial"]))
