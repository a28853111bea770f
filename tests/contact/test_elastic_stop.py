"""Beams on elastic stops: every scheme closes its ledger under every friction law, and friction holds."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import Scenario, simulate, simulate_system
from oblique_impact.contact.stops import ElasticStop
from oblique_impact.validation.small_systems import Particle

NODAL = ("discretization.method=fem", "discretization.modes=0", "discretization.elements=8")
IMPLICIT = ("solver.scheme=generalized-alpha", "solver.free_step=1e-5")
# a fixed step does not integrate across the kinks of friction at its order
SCHEMES = {
    "event": (("solver.scheme=event",), 1e-8),
    "fixed-step": (("solver.scheme=fixed-step",), 1e-4),
    "generalized-alpha": (IMPLICIT, 1e-5),
    "generalized-alpha, nodal": ((*IMPLICIT, *NODAL), 1e-5),
}


@pytest.mark.parametrize(
    ("scheme", "friction"),
    [
        ("event", "hybrid"),
        ("event", "frictionless"),
        ("fixed-step", "modified-coulomb"),
        ("generalized-alpha", "hybrid"),
        ("generalized-alpha", "modified-coulomb"),
        ("generalized-alpha, nodal", "hybrid"),
        ("generalized-alpha, nodal", "frictionless"),
    ],
)
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


def test_what_a_damped_stop_takes_is_the_energy_of_the_ball():
    """2 kg with 3 m/s, and without weight: m (v^2 - v'^2)/2."""
    start = np.array([0.0, 0.3]), np.array([0.0, -3.0])
    history = simulate_system(Particle(above=0.0, mass=2.0), *start, 0.5, contact_law=ElasticStop(5e3, 0.2))
    taken = 3.0**2 - float(history["qd"][-1, 1]) ** 2
    assert history.summary["energy"]["lost_damping"] == pytest.approx(taken, rel=1e-9)
    assert taken > 1.0


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
