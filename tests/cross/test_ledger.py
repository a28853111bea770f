"""The energy ledger closes, in every regime and with every loss (event scheme: 1e-8 J)."""

from __future__ import annotations

import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.scenario.scenario import builtin_names

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


IMPLICIT = [n for n in builtin_names() if Scenario.builtin(n).solver.scheme == "generalized-alpha"]


@pytest.mark.parametrize("name", sorted(set(builtin_names()) - set(IMPLICIT)))
def test_ledger_of_the_built_in_scenarios(run, name):
    assert abs(run(name).summary["energy"]["unaccounted"]) < 1e-8


@pytest.mark.parametrize("name", IMPLICIT)
def test_implicit_ledger_of_the_built_in_scenarios(run, name):
    """Second order in the step: nonlinear forces do work by the trapezoidal rule (see the next test);
    a rigid stop's many impacts excite vibrations that no step of this size resolves."""
    energy = run(name).summary["energy"]
    assert abs(energy["unaccounted"]) < 5e-7 * energy["initial"]


def test_implicit_ledger_closes_at_second_order(run):
    left = []
    for part in (2.0, 0.5, 0.25):
        steps = [f"solver.free_step={2e-5 * part}", f"solver.contact_step={4e-6 * part}"]
        left.append(abs(run("elastic-stop", *steps).summary["energy"]["unaccounted"]))
    assert left[-1] < 1e-8
    assert left[1] < left[0] / 8.0  # 16 at order 2; vibrations that the largest step does not resolve take part
    assert left[2] < left[0] / 50.0  # 64


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


@pytest.mark.parametrize("restitution", [0.0, 0.8])
@pytest.mark.parametrize("rho", [0.0, 0.25, 0.8])
def test_stiff_damping_neither_feeds_nor_hides_energy_at_rebounds(restitution, rho):
    """Kelvin-Voigt damping that no step resolves: a careless ledger finds 40 J of damping work in 8 J of energy.

    A flight after a rebound starts with a jump of the velocity as a contact does.
    """
    scenario = Scenario.builtin("paper").replace(
        end_time=0.15,
        beam__kelvin_voigt=1e-4,
        beam__youngs_modulus=1.2e11,
        initial__angle=0.0,
        initial__angular_velocity=-7.4,
        slope__origin=(0.06, -0.25),
        slope__angle=0.07,
        contact__point=0.5,
        contact__restitution=restitution,
        contact__friction="frictionless",
        discretization__method="fem",
        discretization__frame="mean-axis",
        discretization__modes=0,
        discretization__elements=7,
        discretization__grading=3.0,
        solver__scheme="generalized-alpha",
        solver__contact_step=1e-5,
        solver__rho_infinity=rho,
    )
    history = simulate(scenario)
    energy = history.summary["energy"]
    total = history["energy_kinetic"] + history["energy_elastic"] + history["energy_gravity"]
    assert len(history.events) < 40
    assert energy["lost_damping"] > 4.0
    assert float(total.max()) < energy["initial"] + 1e-9
    assert abs(energy["unaccounted"]) < 1e-3 * energy["initial"]
