"""Quantities of interest: their values, units and gaps; what the first macro-collision is."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from oblique_impact import InputError, Scenario
from oblique_impact.history.sample_times import last_sample
from oblique_impact.validation.studies.quantities import (
    GapError,
    default_quantities,
    natural_scale,
    quantity,
    quantity_table,
)
from oblique_impact.validation.studies.study import regime

#: with three mean-axis modes the second impact lands in a Painleve configuration (theory Sec. 5)
ROUGH = ("discretization.frame=mean-axis", "contact.mu_static=20.0", "contact.mu_kinetic=20.0", "end_time=0.4")


def test_quantities_of_the_papers_case(run):
    history = run("paper")
    first, second = history.summary["macro_collisions"][:2]
    expected = {
        "first_impact": first["start"],
        "collision_end": first["end"],
        "collision_duration": first["end"] - first["start"],
        "impulse": first["normal_impulse"],
        "tangential_impulse": first["tangential_impulse"],
        "peak_force": first["peak_force"],
        "contacts": first["contacts"],
        "second_impact": second["start"],
        "second_impulse": second["normal_impulse"],
        "energy_final": history.summary["energy"]["final"],
        "lost_friction": history.summary["energy"]["lost_friction"],
        "events": history.summary["events"],
        "theta@end": float(history["theta"][-1]),
        "max:tip_y": float(history["tip_y"].max()),
        "min:moment": float(history.section_forces()["moment"].min()),
        "min:theta_dot": float(history["theta_dot"].min()),
        # the beam turns backwards first, and fastest
        "peak:theta_dot": -float(history["theta_dot"].min()),
        "peak:bending_stress": float(np.abs(history.section_forces()["bending_stress"].values).max()),
        "event:1": history.events[0].time,
        f"event:{len(history.events)}": history.events[-1].time,
        "collision_impulse:2": second["normal_impulse"],
    }
    for name, value in expected.items():
        assert quantity(name).measure(history) == value, name
    lost = history.summary["energy"]["initial"] - quantity("energy_after_collision").measure(history)
    ended = quantity(f"lost_after:{first['end'] - first['start']!r}").measure(history)
    assert ended == pytest.approx(lost, rel=1e-9)
    assert 0.0 < lost < sum(history.summary["energy"][f"lost_{k}"] for k in ("impact", "friction", "scheme"))


def test_named_quantities_have_units_and_take_what_they_are_called(run):
    units = {
        "m": "zone",
        "s": "first_impact collision_end collision_duration second_impact",
        "N s": "impulse tangential_impulse second_impulse",
        "N": "peak_force",
        "1": "contacts events restitution model_error period transient impacts_per_period",
        "J": "energy_after_collision energy_final lost_impact lost_friction lost_damping lost_scheme unaccounted "
        "energy_lost supplied",
    }
    by_name = {name: unit for unit, names in units.items() for name in names.split()}
    listed = dict(quantity_table()["unit"])
    patterns = [name for name in listed if set(name) & set(":@")]
    assert {name: unit for name, unit in listed.items() if name not in patterns} == by_name
    examples = {"VARIABLE": "theta", "TIME": "0.1", "SECONDS": "0.1", ":N": ":1"}
    for name in patterns:
        for pattern, example in examples.items():
            name = name.replace(pattern, example)
        assert quantity(name).name == name
    history = run("paper", "end_time=0.4")
    keys = ("final", "lost_impact", "lost_friction", "lost_damping", "lost_scheme", "unaccounted", "supplied")
    energy = history.summary["energy"] | dict(zip(keys, (1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0), strict=True))
    known = replace(history, summary=history.summary | {"energy": energy})
    names = ("energy_final", *keys[1:], "energy_lost")
    assert [quantity(name).measure(known) for name in names] == [1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 30.0]


def test_a_jump_has_the_value_after_it(run):
    history = run("paper")
    impact = history.events[0].time
    place = int(last_sample(history["time"].values, impact))
    assert history["time"].values[place] > impact
    assert quantity(f"gap_rate@{impact!r}").measure(history) == float(history["gap_rate"][place])


def test_the_zone_is_the_least_place_of_the_first_collision(run):
    history = run("edge", "contact.grid=8", "discretization.elements=8", "end_time=0.385")
    assert quantity("zone").measure(history) == min(contact.first_place for contact in history.contacts) < 0.62
    assert quantity("zone").measure(run("paper", "end_time=0.4")) == 1.0


def test_what_a_run_does_not_have_is_a_named_gap(run):
    early, cut, flight = run("paper", "end_time=0.2"), run("paper", "end_time=0.318"), run("paper", "end_time=0.4")
    stopped = run("paper", *ROUGH, "discretization.modes=3")
    for name, history, words in (
        ("first_impact", early, "no contact before end_time"),
        ("impulse", early, "no contact before end_time"),
        ("second_impact", early, "no contact before end_time"),
        ("collision_end", cut, "still in contact"),
        ("second_impact", flight, "no second impact before end_time"),
        ("second_impulse", flight, "no second impact before end_time"),
        ("start:5", flight, "no macro-collision 5, only 1, before end_time"),
        ("impulse", stopped, "painleve"),
        ("second_impact", stopped, "painleve"),
        ("energy_final", stopped, "painleve"),
        ("tip_y@end", stopped, "painleve"),
        ("tip_y@0.39", stopped, "ended at"),
        ("lost_after:0.1", stopped, "ended at"),
    ):
        with pytest.raises(GapError, match=words):
            quantity(name).measure(history)
    assert quantity("first_impact").measure(stopped) == pytest.approx(0.317, abs=1e-3)


@pytest.mark.parametrize(
    "name", ["peak", "tip_y@", "moment@0.5", "max:", "mean:tip_y", "tip_y@-1", "lost_after:-1"]
)
def test_unknown_quantities_are_one_line(name):
    with pytest.raises(InputError, match=r"^--quantity .*[^\n]$"):
        quantity(name, 1.0)


def test_usual_quantities_fit_the_scenario():
    assert "second_impact" in default_quantities(Scenario.builtin("paper"))
    assert "tip_x@end" in default_quantities(Scenario.builtin("spin-up"))
    assert natural_scale("m", Scenario.builtin("spin-up"), 3.0) == 10.0
    assert natural_scale("J", Scenario.builtin("paper"), 3.0) == 3.0
    assert natural_scale("s", Scenario.builtin("paper"), 3.0) == 0.0


def test_regimes(run):
    mean_axis = ("discretization.frame=mean-axis", "discretization.modes=3", "end_time=0.4")
    assert regime(run("paper", "end_time=0.3")) == "no contact"
    assert regime(run("paper", *mean_axis)) == "slip"
    assert regime(run("paper", "end_time=0.4")) == "reversal"  # theory, Sec. 8: at 0.3235971 s
    assert regime(run("sticking")) == "stick"
    steep = ("contact.mu_static=20.0", "contact.mu_kinetic=20.0")
    assert regime(run("paper", *mean_axis, *steep)) == "painleve"


def test_the_model_error_is_the_estimate_that_a_run_warns_of(run):
    """A soft beam bends far: what the warning says in percent; the exact beam has no such error."""
    soft = ("beam.youngs_modulus=5e7", "contact.enabled=false", "end_time=0.4", "discretization.frame=mean-axis")
    history = run("paper", *soft)
    (warning,) = [text for text in history.summary["warnings"] if "small-deflection model" in text]
    error = quantity("model_error").measure(history)
    assert f"off by about {100.0 * error:.2g} % in deflection" in warning
    with pytest.raises(GapError, match="floating frame"):
        quantity("model_error").measure(run("paper", *soft, "end_time=1e-3", "discretization.method=absolute"))


TIP_MASS = ("discretization.method=fem", "beam.tip_mass=0.2", "beam.length=0.8")
#: half of it inside of the span, both with inertias
MASSES = (*TIP_MASS[::2], "masses=[{place=0.6,mass=0.1,inertia=0.002},{mass=0.1,inertia=0.01}]")


@pytest.mark.parametrize(
    ("frame", "changes"),
    [("mean-axis", ()), ("tangent", TIP_MASS), ("tangent", MASSES)],
    ids=["mean-axis", "tip mass", "masses"],
)
def test_restitution_is_the_balance_of_angular_momentum(run, frame, changes):
    """J (w+ - w-) is the moment of the contact impulses less that of gravity during the collision."""
    model = (f"discretization.frame={frame}", *changes, "contact.friction=frictionless")
    history = run("paper", "end_time=0.4", *model)
    tip_mass, length = (0.2, 0.8) if changes else (0.0, 1.0)
    collision = history.summary["macro_collisions"][0]
    times = history["time"].values
    before = np.flatnonzero(times == collision["start"])[0]
    after = np.flatnonzero(times == collision["end"])[-1]
    lengths = 0.3 * math.sin(math.pi / 10)  # of the foot of the perpendicular from the pin onto the slope
    lever = math.sqrt(length**2 - lengths**2)
    angle = math.pi / 10 - math.asin(lengths / length)
    mass = 3.14e-4 * 2766.7 * length
    inertia = (mass / 3.0 + tip_mass) * length**2
    first_moment = (0.5 * mass + tip_mass) * length
    if changes == MASSES:
        inertia += 0.1 * (0.6**2 - length**2) + 0.012
        first_moment += 0.1 * (0.6 - length)
    weight = first_moment * 9.8 * math.cos(angle) * (times[after] - times[before])
    change = (lever * collision["normal_impulse"] - weight) / inertia
    fall = 9.8 * first_moment * (math.sin(math.pi / 4) - math.sin(angle))
    spin = -math.sqrt(2.0 * fall / inertia)  # of the rigid bar that falls
    expected = -(spin + change) / spin
    assert quantity("restitution").measure(history) == pytest.approx(expected, abs=0.01)
