"""The energy ledger closes, in every regime and with every loss (event scheme: 1e-8 J)."""

from __future__ import annotations

import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.scenario.scenario import builtin_names

IMPLICIT = [n for n in builtin_names() if Scenario.builtin(n).solver.scheme == "generalized-alpha"]


LONG = pytest.param("many-modes", marks=pytest.mark.slow)


@pytest.mark.parametrize("name", [*sorted(set(builtin_names()) - {*IMPLICIT, "many-modes"}), LONG])
def test_ledger_of_the_built_in_scenarios(run, name):
    assert abs(run(name).summary["energy"]["unaccounted"]) < 1e-8


@pytest.mark.parametrize("name", IMPLICIT)
def test_implicit_ledger_of_the_built_in_scenarios(run, name):
    """Second order in the step (check `balances.implicit-ledger`): nonlinear forces work by the trapezoidal rule;
    a rigid stop's many impacts excite vibrations that no step of this size resolves."""
    energy = run(name).summary["energy"]
    part = 1e-4 if name == "damped" else 5e-7  # a rigid stop on a fine mesh
    assert abs(energy["unaccounted"]) < part * energy["initial"]


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
