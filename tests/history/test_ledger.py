"""The energy ledger: its entries, and warnings about energy that the scheme takes."""

from __future__ import annotations

import re

import numpy as np
import pytest

from oblique_impact import Scenario, simulate, simulate_system
from oblique_impact.beam.validity.integration import energy_warnings
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.log import Contact
from oblique_impact.history.summary import MacroCollision, balance_text, macro_collisions
from oblique_impact.validation.small_systems import Particle


def test_energy_that_the_scheme_takes_is_warned_of(run):
    """An undamped mesh on a stiff stop: the scheme takes its shortest waves, more than friction takes."""
    coarse = ("beam.kelvin_voigt=0", "discretization.elements=24", "solver.rho_infinity=0.5", "end_time=0.33")
    steps = "solver.scheme=generalized-alpha", "solver.contact_step=2e-6", "contact.normal=spring"
    summary = run("tapered", *steps, *coarse, "contact.stiffness=1e9").summary
    energy = summary["energy"]
    assert energy["lost_scheme"] > energy["lost_friction"]
    (line,) = (words for words in summary["warnings"] if words.startswith("solver."))
    assert f"took {energy['lost_scheme']:.3g} J" in line


def test_the_balance_in_words_adds_up(run):
    """Initial energy, plus supplied, less lost."""
    for name, changes in (("spin-up", ("end_time=2",)), ("paper", ())):
        sum_, final = balance_text(run(name, *changes).balance).removesuffix(" J").split(" = ")
        parts = [float(part) for part in re.findall(r"-?\d\S*", sum_.replace(" - ", " -"))]
        assert sum(parts) == pytest.approx(float(final), abs=2e-5 * max(map(abs, parts)))
        assert ("supplied" in sum_, "lost" in sum_) == (name == "spin-up", name == "paper")


@pytest.mark.parametrize("rho", [0.25, 0.8])
def test_stiff_damping_neither_feeds_nor_hides_energy_at_a_touch_down(rho):
    """Kelvin-Voigt damping that no step resolves: the force on a contact point without inertia begins with a jump.

    A ledger that takes the steps of backward Euler there for others leaves 0.016 J unaccounted for.
    """
    keys = "beam.kelvin_voigt=1e-4 beam.youngs_modulus=1.2e11 initial.angle=0 initial.angular_velocity=-7.4 "
    keys += "slope.origin=[0.06,-0.25] slope.angle=0.07 contact.point_inertia=none "
    keys += "contact.friction=frictionless discretization.method=fem discretization.modes=0 end_time=0.15 "
    keys += (
        "discretization.elements=7 discretization.grading=3 solver.contact_step=1e-5 "
        f"solver.scheme=generalized-alpha solver.rho_infinity={rho}"
    )
    history = simulate(Scenario.builtin("paper", keys.split()))
    energy = history.summary["energy"]
    total = history["energy_kinetic"] + history["energy_elastic"] + history["energy_gravity"]
    assert len(history.events) < 40
    assert energy["lost_damping"] > 4.0
    assert float(total.max()) < energy["initial"] + 1e-9
    assert abs(energy["unaccounted"]) < 1e-3 * energy["initial"]


def test_a_belt_supplies_what_friction_takes_and_the_block_gains():
    """A block of 1 kg, at rest on a belt at 2 m/s, mu = 0.3: friction drives it for 0.2 s."""
    belt, force = Particle(above=-9.8, belt_speed=2.0), 0.3 * 9.8
    energy = simulate_system(belt, np.zeros(2), np.zeros(2), 0.2, friction=Coulomb(0.3, 0.3)).summary["energy"]
    gained = 0.5 * (0.2 * force) ** 2
    assert energy["supplied"] == pytest.approx(force * 2.0 * 0.2, rel=1e-12)
    assert energy["lost_friction"] == pytest.approx(force * 2.0 * 0.2 - gained, rel=1e-12)
    assert energy["kinetic"] == pytest.approx(gained, rel=1e-12)


def test_a_macro_collision_adds_up_its_contacts():
    """Two contacts 0.1 s apart, and two more from 0.3 s after the end of the second."""
    contacts = [
        Contact(0.0, 0.2, 1.0, -2.0, 30.0, 0.0, 0.0),
        Contact(0.3, 0.4, 4.0, -8.0, 20.0, 0.0, 0.0),
        Contact(0.7, 0.8, 16.0, -32.0, 10.0, 0.0, 0.0),
        Contact(0.9, 1.0, 2.0, 1.0, 15.0, 0.0, 0.0),
    ]
    assert macro_collisions(contacts, 0.25) == [
        MacroCollision(0.0, 0.4, 2, 5.0, -10.0, 30.0),
        MacroCollision(0.7, 1.0, 2, 18.0, -31.0, 15.0),
    ]


@pytest.mark.parametrize(
    ("scheme", "remedy", "foreign"),
    [
        ("event", "solver.tolerance", "solver.free_step"),
        ("fixed-step", 'solver.scheme = "event"', "solver.rho_infinity"),
        ("generalized-alpha", "solver.rho_infinity", 'solver.scheme = "event"'),
    ],
)
def test_a_warning_of_lost_energy_names_keys_of_its_scheme(scheme, remedy, foreign):
    lost = dict.fromkeys(("lost_impact", "lost_friction", "lost_damping", "lost_scheme"), 1.0)
    (line,) = energy_warnings({"initial": 8.0, "final": 4.0, "unaccounted": 0.0, **lost}, 8.0, 8.0, scheme)
    assert remedy in line
    assert foreign not in line


def test_rounding_of_energies_that_cancel_is_not_warned_of():
    """A beam at rest far below its root, bent as much: the total is 0 J, its rounding that of 1 kJ."""
    lost = dict.fromkeys(("lost_impact", "lost_friction", "lost_damping", "lost_scheme"), 0.0)
    energy = {"initial": 0.0, "final": 0.0, "unaccounted": 1e-10, **lost}
    assert energy_warnings(energy, 0.0, 2000.0, "event") == []
    (line,) = energy_warnings(energy | {"unaccounted": 1e-5}, 0.0, 2000.0, "event")
    assert "1e-05 J" in line
    lost["lost_scheme"] = 1e-10
    assert energy_warnings({**energy, **lost}, 0.0, 2000.0, "event") == []
