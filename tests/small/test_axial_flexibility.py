"""A spring in series with Coulomb's slider, Jenkins's element: closed forms under every scheme."""

from __future__ import annotations

from math import asin, cos, pi, sqrt

import numpy as np
import pytest

from oblique_impact import History, simulate_system
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.errors import InputError
from tests.small.systems import (
    EVENT_ERROR,
    GRAVITY,
    SCHEMES,
    PulledMass,
    assert_order,
    completed,
    kinds_of,
    last,
    scheme_of,
    times_of,
)

STOP, FLEXIBILITY = 4e4, 1e-4  # N/m, m/N
LAW = Coulomb(0.4, 0.3)


def run(scheme: str, step: float, end: float, place: float, velocity: tuple[float, float], **more) -> History:
    """Run a mass of 1 kg, `place` (m) above an elastic ground, with a velocity (m/s) along it and upwards."""
    parts = {"contact_law": ElasticStop(STOP), "axial_flexibility": FLEXIBILITY} | more
    found = simulate_system(
        PulledMass(),
        np.array([0.0, place]),
        np.array(velocity),
        end,
        friction=LAW,
        scheme=scheme_of(scheme, step),
        output_interval=end / 50.0,
        **parts,
    )
    return completed(found)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_a_mass_that_is_pushed_swings_on_its_spring_slips_and_swings_on(scheme):
    """It slips at mu_s N, where the spring falls back to mu_k N at once, and swings about where it comes to rest.

    What it has lost by then is mu_k N over its way and what the spring gave up in falling back.
    """
    speed, rate = 0.1, sqrt(1.0 / FLEXIBILITY)
    begins = asin(LAW.static * GRAVITY * FLEXIBILITY * rate / speed) / rate
    ends = begins + speed * cos(rate * begins) / (LAW.kinetic * GRAVITY)
    loss = 0.5 * speed**2 - 0.5 * FLEXIBILITY * (LAW.kinetic * GRAVITY) ** 2
    force = -LAW.kinetic * GRAVITY * cos(1.25 * pi)
    steps, errors, end = (4e-4, 2e-4, 1e-4), [], ends + 1.25 * pi / rate
    for step in steps[:1] if scheme == "event" else steps:
        found = run(scheme, step, end, -GRAVITY / STOP, (speed, 0.0))
        assert kinds_of(found) == ["slip", "stick"]
        energy = found.summary["energy"]
        assert abs(energy["unaccounted"]) < 1e-6 * speed**2
        stored = 0.5 * FLEXIBILITY * last(found, "lambda_tau") ** 2
        assert energy["contact"] - 0.5 * GRAVITY**2 / STOP == pytest.approx(stored, rel=1e-9)
        slip, stick = times_of(found) - [begins, ends]
        errors.append([slip, stick, energy["lost_friction"] / loss - 1.0, last(found, "lambda_tau") / force - 1.0])
    errors = np.abs(errors).T
    if scheme == "event":
        assert errors.max() < EVENT_ERROR
    elif scheme == "generalized-alpha":
        for some, most in zip(errors, (1e-6, 1e-6, 1e-7, 1e-3), strict=True):
            assert_order(steps, some, (1.8, 2.5), most)
    else:  # states change at the ends of steps
        assert np.all(errors[:2] <= steps)
        assert np.all(errors[2:] <= 100.0 * np.array(steps))


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize(("steepness", "kinds"), [(0.98, ["impact"]), (1.02, ["impact", "stick"])])
def test_an_oblique_impact_sticks_at_once_if_it_is_steep_enough(scheme, steepness, kinds):
    """Both forces grow from zero, their ratio is that of the stiffnesses times that of the speeds."""
    down = 0.5
    along = steepness * LAW.static * FLEXIBILITY * STOP * down
    found = run(scheme, 1e-5, 5e-3, 1e-5, (along, -down))
    assert kinds_of(found)[0] == "impact"
    if scheme == "event":
        assert found.events[0].state.name == ("STICK" if len(kinds) == 1 else "SLIP")


def test_axial_flexibility_needs_an_elastic_stop_without_damping():
    for law in (None, ElasticStop(STOP, 0.1)):
        with pytest.raises(InputError, match="axial_flexibility"):
            run("event", 1e-4, 1e-2, 0.0, (0.1, 0.0), contact_law=law)
