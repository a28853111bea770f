"""Beams on elastic stops: closed form, converged finite elements, a published test, a geometrically exact code.

Unlike a rigid stop, an elastic one has a limit for the continuous beam, so numbers converge with the modes.
"""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.simulation import simulate_system
from validation.checks.springs import SCALE, SPEED, sdnl32_run, strike
from validation.small_systems import Particle

MODAL = ("discretization.method=modal", "discretization.modes=40")
FEM = ("discretization.method=fem", "discretization.elements=64", "discretization.modes=40")
# Benchmark 5f: hinged beam, EI = 541.27, rho A = 0.86874, L = 1, v0 = 3.77 m/s on a unilateral spring
# (finite elements, exact in time, n = 128, converged digits): peak force (N), end of contact (s),
# impulse (N s), rotation rate after (rad/s)
FIRST_CONTACT = {1e5: (317.107, 0.00599442, 1.034329, 0.19818), 1e6: (683.155, 0.00297991, 0.746103, 1.1935)}


@pytest.mark.parametrize("discretization", [MODAL, FEM], ids=["modal", "fem"])
@pytest.mark.parametrize("stiffness", FIRST_CONTACT)
def test_first_contact_on_a_spring(stiffness, discretization):
    peak, end, impulse, rotation = FIRST_CONTACT[stiffness]
    history = strike(stiffness, 1.05 * end, *discretization)
    release = next(e for e in history.events if e.kind.value == "release")
    contact = history["time"].values <= release.time
    force, time = history["lambda_n"].values[contact] / SCALE, history["time"].values[contact]
    computed = np.trapezoid(force, time)
    # 40 modes leave out a compliance of order 1/N^3 = 1.6e-5 relative to the beam's own
    assert force.max() == pytest.approx(peak, rel=1.5e-4)
    assert release.time == pytest.approx(end, rel=5e-5)
    assert computed == pytest.approx(impulse, rel=5e-5)
    # angular momentum about the pin, J = m L^3 / 3; positive still turns towards the stop
    assert SPEED - computed / (0.86874 / 3.0) == pytest.approx(rotation, abs=2e-4)


@pytest.mark.parametrize(("stiffness", "ceiling"), [(1e6, 2e-4), (1e7, 2e-3)])
def test_peak_on_a_spring_before_reflections(stiffness, ceiling):
    """Benchmark 5e: F_max = 0.85803877759 v0 Z^(2/3) k^(1/3) at 1.64522887065 (Z/k)^(2/3) (Mittag-Leffler)."""
    beam = Scenario.builtin("paper").beam
    Z = (beam.youngs_modulus * beam.second_moment) ** 0.25 * (beam.density * beam.area) ** 0.75 / np.sqrt(2.0)
    expected = 0.85803877759 * SPEED * Z ** (2 / 3) * stiffness ** (1 / 3)
    at = 1.64522887065 * (Z / stiffness) ** (2 / 3)
    errors = []
    for modes in (30, 60):
        history = strike(stiffness, 2.0 * at, "discretization.method=modal", f"discretization.modes={modes}")
        sample = int(np.argmax(history["lambda_n"].values))
        errors.append(abs(float(history["lambda_n"][sample]) / SCALE / expected - 1.0))
    assert errors[1] < 0.35 * errors[0]  # truncation falls at least like N^-1.5
    assert errors[1] < ceiling  # the stiffer spring asks for higher modes
    assert float(history["time"][sample]) == pytest.approx(at, rel=2e-2)


# VPCS test SDNL32 (code_aster V5.02.032, external source): tip displacement (mm) at 1..12 ms
SDNL32 = (-2.66, -4.33, -4.92, -4.78, -3.82, -2.87, -2.71, -3.09, -3.41, -3.36, -2.64, -0.742)


@pytest.mark.parametrize("method", ["modal", "fem"])
def test_published_impact_on_a_spring(method):
    """A 14 mm square beam turns at 3.8 rad/s onto a spring of 18000 N/m; 1 % modal damping."""
    history = sdnl32_run(method)
    tip = 1e3 * np.interp(np.arange(1, 13) * 1e-3, history["time"], history["tip_y"])
    np.testing.assert_allclose(tip, SDNL32, rtol=0.0, atol=0.05)


def test_paper_beam_on_a_spring_against_a_geometrically_exact_code():
    """Theory Sec. 7a: ANCF, extensible, explicit and implicit, 64 and 128 elements; k = 1e6 N/m, no friction."""
    overrides = [
        "contact.normal=spring",
        "contact.stiffness=1e6",
        "contact.friction=frictionless",
        "discretization.method=fem",
        "discretization.elements=32",
        "discretization.frame=mean-axis",
        "discretization.modes=24",
        "end_time=0.87",
    ]
    history = simulate(Scenario.builtin("paper", overrides))
    first, second = history.summary["macro_collisions"][:2]
    assert first["normal_impulse"] == pytest.approx(2.140259, rel=1e-3)
    assert first["peak_force"] == pytest.approx(924.45, rel=5e-3)
    assert second["start"] == pytest.approx(0.86535, abs=2e-3)
    contacts = [0.317147, 0.320131, 0.320816, 0.321611, 0.324809, 0.325811, 0.326045, 0.326719, 0.328510, 0.329274]
    np.testing.assert_allclose([e.time for e in history.events[:10]], contacts, rtol=0.0, atol=2e-5)


IMPLICIT = ("solver.scheme=generalized-alpha", "solver.free_step=1e-5")
# a fixed step does not integrate across the kinks of friction at its order
SCHEMES = {
    "event": (("solver.scheme=event",), 1e-8),
    "fixed-step": (("solver.scheme=fixed-step",), 1e-4),
    "generalized-alpha": (IMPLICIT, 1e-5),
    "generalized-alpha, nodal": ((*IMPLICIT, *FEM, "discretization.modes=0", "discretization.elements=8"), 1e-5),
}


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("friction", ["frictionless", "hybrid", "modified-coulomb"])
def test_ledger_on_an_elastic_stop(scheme, friction):
    chosen, ceiling = SCHEMES[scheme]
    overrides = [
        "contact.normal=spring",
        "contact.stiffness=1e5",
        "contact.damping=0.2",
        f"contact.friction={friction}",
        "discretization.frame=mean-axis",
        "discretization.modes=3",
        "end_time=0.4",
        *chosen,
    ]
    history = simulate(Scenario.builtin("paper", overrides))
    energy = history.summary["energy"]
    assert energy["lost_damping"] > 0.1  # the Hunt-Crossley dashpot
    assert energy["lost_impact"] == 0.0
    assert (energy["lost_friction"] > 1e-3) == (friction != "frictionless")
    assert abs(energy["unaccounted"]) < ceiling
    assert history["lambda_n"].min() >= 0.0


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


def test_a_mass_bounces_on_a_spring_for_half_a_period():
    """Closed form: without gravity contact lasts pi sqrt(m/k), peak force v sqrt(k m), the speed comes back."""
    mass, stiffness, speed, height = 2.0, 5e3, 3.0, 0.3
    history = simulate_system(
        Particle(above=0.0, mass=mass),
        np.array([0.0, height]),
        np.array([0.0, -speed]),
        0.5,
        stop=ElasticStop(stiffness),
        output_interval=1e-3,
    )
    impact, release = history.events
    assert impact.time == pytest.approx(height / speed, abs=1e-11)
    assert release.time - impact.time == pytest.approx(np.pi * np.sqrt(mass / stiffness), abs=1e-10)
    assert release.normal_velocity == pytest.approx(speed, abs=1e-9)
    collision = history.summary["macro_collisions"][0]
    assert collision["normal_impulse"] == pytest.approx(2.0 * mass * speed, rel=1e-9)
    assert collision["peak_force"] == pytest.approx(speed * np.sqrt(stiffness * mass), rel=1e-6)
