"""The energy ledger closes, in every regime and with every loss (event scheme: 1e-8 J)."""

from __future__ import annotations

import pytest

from oblique_impact.scenario import builtin_names

CASES = {
    "frictionless": ("contact.friction=frictionless",),
    "hybrid": (),
    "modified": ("contact.friction=modified-coulomb",),
    "kelvin-voigt": ("beam.kelvin_voigt=1e-5",),
    "mass-proportional": ("beam.mass_proportional=2.0",),
    "modal-damping": ("beam.modal_damping_ratio=0.02",),
    "restitution": ("contact.restitution=0.7",),
    "full": ("discretization.kinetics=full",),
    "mean-axis": ("discretization.frame=mean-axis", "discretization.modes=6"),
    "stick": (
        "discretization.frame=mean-axis",
        "discretization.modes=3",
        "contact.mu_static=8",
        "contact.mu_kinetic=6",
    ),
    "finite elements": ("discretization.method=fem",),
    "hub with torque": ("root.kind=hub", "root.inertia=0.1", "root.torque=-2.0", "root.hub_radius=0.1"),
    "driven into the slope": (
        "root.kind=driven",
        "root.profile=constant-speed",
        "root.spin_rate=-1.0",
        "end_time=0.6",
    ),
}


@pytest.mark.parametrize("overrides", CASES.values(), ids=CASES)
def test_ledger_closes(run, overrides):
    energy = run("paper", *overrides).summary["energy"]
    assert abs(energy["unaccounted"]) < 1e-8
    losses = energy["lost_impact"], energy["lost_friction"], energy["lost_damping"]
    assert all(loss >= 0.0 for loss in losses)
    assert energy["final"] == pytest.approx(energy["kinetic"] + energy["elastic"] + energy["gravity"])


@pytest.mark.parametrize("name", builtin_names())
def test_ledger_of_the_built_in_scenarios(run, name):
    assert abs(run(name).summary["energy"]["unaccounted"]) < 1e-8


def test_damping_and_friction_are_really_there(run):
    assert run("paper", *CASES["kelvin-voigt"]).summary["energy"]["lost_damping"] > 0.1
    assert run("paper", *CASES["modal-damping"]).summary["energy"]["lost_damping"] > 0.1
    assert run("paper", *CASES["hybrid"]).summary["energy"]["lost_friction"] > 1e-3
    assert abs(run("paper", *CASES["driven into the slope"]).summary["energy"]["supplied"]) > 0.1
    assert run("paper", *CASES["hub with torque"]).summary["energy"]["supplied"] > 0.1


def test_a_hub_torque_supplies_torque_times_angle(run):
    history = run("paper", *CASES["hub with torque"])
    turned = float(history["theta"][-1] - history["theta"][0])
    assert history.summary["energy"]["supplied"] == pytest.approx(-2.0 * turned, rel=1e-9)
