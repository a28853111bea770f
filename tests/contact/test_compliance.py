"""Compliance behind contacts: between all places, with the force of its change, the same in every scheme."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.beam_problem import beam_of
from oblique_impact.contact.compliance import Compliance, across, across_by_shift, locate
from oblique_impact.history.history import History

MEAN_AXIS, SPRING = "discretization.frame=mean-axis", "contact.normal=spring"
ANYWHERE = "contact.where=anywhere", "slope.enabled=false"
#: a peg at half of the beam, which slides along it; two pegs; a point of the beam on the slope
PEG = (*ANYWHERE, 'obstacles=[{kind="point",origin=[0.5,0.0],radius=0.02}]')
PEGS = (*ANYWHERE, 'obstacles=[{kind="point",origin=[0.35,0.0]},{kind="point",origin=[0.7,0.0]}]')
FALL = MEAN_AXIS, "discretization.modes=4", "end_time=0.375", SPRING


@cache
def fall(*keys: str) -> History:
    return simulate(Scenario.builtin("paper", [*FALL, *keys]))


def compliance_of(*keys: str) -> Compliance:
    found = beam_of(Scenario.builtin("paper", [*FALL, *keys])).compliance
    assert found is not None
    return found


@pytest.mark.parametrize(
    "keys",
    [PEGS, (), ("contact.surface=section", "contact.point=0.8"), (*PEGS, "discretization.frame=tangent")],
    ids=["pegs", "slope", "section", "clamped"],
)
def test_derivatives_of_compliances_over_place_and_angle_are_differences_of_them(keys):
    y, step = compliance_of(*keys), 1e-5
    last = len(y.places) - 1

    def at(shift: float, of: int, by: int) -> float:
        locate(y, 0, shift)
        if last:
            locate(y, last, 0.7)
        return float(across(y, 0, of, last, by))

    for shift in (0.31, 0.52):
        for of in (0, 1):
            for by in (0, 1):
                difference = (at(shift + step, of, by) - at(shift - step, of, by)) / (2.0 * step)
                at(shift, of, by)
                found = across_by_shift(y, 0, of, last, by)
                if last == 0:  # both of its places are those of the contact
                    found += across_by_shift(y, 0, by, 0, of)
                size = max(abs(at(shift, 0, 0)), 1e-9)
                assert found == pytest.approx(difference, abs=1e-6 * size)


@pytest.mark.parametrize("friction", ["frictionless", "hybrid"])
@pytest.mark.parametrize("stop", [("contact.damping=0.2",), ("contact.linear_damping=30",), ()])
def test_one_contact_point_and_one_place_anywhere_are_the_same_contact(friction, stop):
    keys = f"contact.friction={friction}", "end_time=0.33", *stop
    point, anywhere = fall(*keys), fall(*keys, "contact.where=anywhere", "contact.grid=1")
    assert len(point.contacts) > 0
    for name in ("theta", "gap", "lambda_n", "lambda_tau", "energy_contact"):
        np.testing.assert_array_equal(point[name].values, anywhere[name].values)


SCHEMES = {
    # energy unaccounted for, energy that the scheme takes (J, of 3)
    "event": ((), 1e-10, 1e-12),
    "generalized-alpha": (("solver.contact_step=1e-6", "solver.free_step=1e-5"), 2e-8, 2e-6),
    "time-stepping": (("solver.contact_step=1e-6", "solver.free_step=1e-5"), 2e-9, 5e-6),
}


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("friction", ["frictionless", "hybrid"])
@pytest.mark.parametrize("pegs", [PEG, PEGS], ids=["one", "two"])
def test_a_beam_that_slides_over_elastic_pegs_keeps_its_energy(scheme, friction, pegs):
    """Without the force of the change of C it would gain or lose 1e-6 J."""
    steps, unaccounted, taken = SCHEMES[scheme]
    found = fall(*pegs, f"contact.friction={friction}", f"solver.scheme={scheme}", *steps)
    slid = np.ptp(found["contact_slip"].values[found["contact_lambda_n"].values.max(axis=1) > 10.0], axis=0)
    assert slid.max() > 1e-4
    balance = found.balance
    assert abs(balance["unaccounted"]) < unaccounted * 3.0
    assert abs(balance["lost_scheme"]) < taken * 3.0
    held = found.total_energy.values
    wanted = held[0] - balance["lost_friction"] - balance["lost_scheme"]
    assert held[-1] == pytest.approx(wanted, abs=4.0 * unaccounted)
    assert (balance["lost_friction"] > 1e-4) == (friction == "hybrid")


def test_schemes_agree_on_elastic_pegs_at_their_orders():
    """Angle at 0.375 s: second order by generalized-alpha, with events found within steps by time-stepping too."""
    keys = *PEGS, "contact.friction=hybrid"
    exact = float(fall(*keys, "solver.tolerance=1e-12")["theta"].values[-1])
    for scheme in ("generalized-alpha", "time-stepping"):
        errors = []
        for step in (8e-6, 4e-6, 2e-6):
            steps = f"solver.contact_step={step}", f"solver.free_step={step}"
            found = fall(*keys, f"solver.scheme={scheme}", *steps)
            errors.append(abs(float(found["theta"].values[-1]) - exact))
        assert errors[-1] < 3e-7
        assert errors[-1] < 0.5 * errors[0]


KINDS = {
    "spring": (),
    "stiff spring": ("contact.stiffness=1e8", "beam.kelvin_voigt=1e-5"),
    "damped spring": ("contact.damping=0.3", "contact.linear_damping=20"),
    "axial flexibility": ("contact.axial_flexibility=true",),
    "relaxing": ("beam.kelvin_voigt=1e-4",),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_time_stepping_has_its_order_with_each_kind_of_compliance(kind):
    """Angle and energy after two contacts: of first order at least, to what located events have.

    Of damping in series with the beam these take the rate at rest, which modes as many as are needed do not see.
    """
    keys = *PEGS, "contact.friction=hybrid", *KINDS[kind]
    located, steps, errors = fall(*keys, "solver.tolerance=1e-12"), 1.6e-5 / 2.0 ** np.arange(4), []

    def stepped(step: float) -> History:
        lengths = f"solver.contact_step={step}", f"solver.free_step={step}"
        return fall(*keys, "solver.scheme=time-stepping", *lengths)

    exact = stepped(2.5e-7)
    assert exact.contacts[0].normal_impulse == pytest.approx(located.contacts[0].normal_impulse, rel=3e-3)
    if kind in ("spring", "axial flexibility"):
        assert float(exact["theta"].values[-1]) == pytest.approx(float(located["theta"].values[-1]), abs=1e-9)
    for step in steps:
        found = stepped(step)
        errors.append([abs(float((found[name] - exact[name]).values[-1])) for name in ("theta", "energy_kinetic")])
    orders = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert (orders > 0.8).all()


def test_a_place_without_inertia_is_refused_behind_a_spring_in_modes():
    with pytest.raises(InputError, match=r"contact\.point_inertia"):
        Scenario.builtin("paper", [*FALL, "contact.point_inertia=none"])
    nodes = "discretization.method=fem", "discretization.modes=0", "solver.scheme=generalized-alpha"
    Scenario.builtin("paper", [SPRING, *nodes, "contact.point_inertia=none"])
