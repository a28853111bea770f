"""Sliding of rigid rods with friction (Painleve), beyond the checks "small-systems"."""

from __future__ import annotations

from math import atan, cos, radians, sin, sqrt

import numpy as np
import pytest

from oblique_impact import History, Outcome, simulate_system
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.transitions import EventKind
from oblique_impact.validation.reference_values import VALUES
from oblique_impact.validation.small_systems import FreeRod, samples_at


def slide_rod(mu: float, angle: float, slip: float, spin: float) -> History:
    """Run a rod (m = l = 1) under gravity whose end slides on the ground, for half a second."""
    rod = FreeRod(gravity=9.8)
    start = rod.at(angle), rod.moving(angle, (slip, 0.0), spin)
    return simulate_system(rod, *start, 0.5, friction=Coulomb(mu, mu))


@pytest.mark.parametrize("spin", [0.3, 1.0, 2.0])
def test_a_rod_slides_into_the_paradox_only_above_a_second_critical_friction(spin):
    """Genot and Brogliato (1999): below mu = 8/(3 sqrt 3) it lifts off first, above it reaches the edge.

    Near the edge, with p the effective inverse mass and b the gap acceleration without force,
    d b/d theta = A b/(theta - edge) and A = 1 at that friction; checked in the last lines.
    """
    second = 8.0 / (3.0 * sqrt(3.0))
    below = slide_rod(1.5, radians(45.0), -20.0, spin)
    assert below.events[1].kind is EventKind.RELEASE
    released, _ = samples_at(below, below.events[1].time)
    assert released[2] < VALUES["6d"]["interval_rad"][0]
    above = slide_rod(1.6, radians(45.0), -20.0, spin)
    edge = atan((3.0 * 1.6 - sqrt(9.0 * 1.6**2 - 16.0)) / 2.0)
    assert above.outcome is Outcome.PAINLEVE
    # the run ends where the effective inverse mass has fallen to 1e-9 of its frictionless value
    assert above["q"].values[-1, 2] == pytest.approx(edge, abs=1e-8)
    for mu, sign in ((1.5, 1.0), (second, 0.0), (1.6, -1.0)):
        x = atan((3.0 * mu - sqrt(9.0 * mu**2 - 16.0)) / 2.0)
        growth = 6.0 * sin(x) * (mu * sin(x) - cos(x)) / (3.0 * (sin(2.0 * x) + mu * cos(2.0 * x)))
        assert np.sign(round(growth - 1.0, 9)) == sign
