"""The summary says what of an impact has no limit, and what would give it one."""

import pytest

from oblique_impact import Scenario, simulate
from oblique_impact.beam.determinacy import _up, undetermined, without_limit
from oblique_impact.command_line.run import summary_lines
from oblique_impact.problem import beam_of

DAMPED = "beam.kelvin_voigt=1e-5"
SPRING = "contact.normal=spring"
ALL = ("start", "end", "contacts", "normal_impulse", "tangential_impulse", "peak_force")
NODAL = ("discretization.method=fem", "discretization.modes=0")


def said(*changes: str, contacts=(3,)) -> str:
    """The one line about a run of the paper's case, "" for none."""
    lines = undetermined(beam_of(Scenario.builtin("paper", changes)), contacts)
    assert len(lines) <= 1
    return "".join(lines)


@pytest.mark.parametrize(
    ("changes", "names"),
    [
        ((), ALL),
        ((DAMPED,), ("peak_force",)),
        ((SPRING, "contact.stiffness=1e6"), ()),
        # a thousand times 105 EI/(2 L^3), the stiffness of the hinged beam at its tip: 2.84e7 N/m
        ((SPRING, "contact.stiffness=2.8e7"), ()),
        ((SPRING, "contact.stiffness=2.9e7"), ALL),
        ((SPRING, "contact.stiffness=1e9"), ALL),
        ((SPRING, "contact.stiffness=1e9", DAMPED), ()),
        (("contact.enabled=false",), ()),
    ],
)
def test_what_has_no_limit(changes, names):
    assert without_limit(Scenario.builtin("paper", changes)) == names


def test_an_undamped_beam_on_a_rigid_stop_is_named_with_the_damping_that_helps():
    """Two clamped modes: omega_2 = (4.69409 / L)^2 sqrt(EI/m) = 550 rad/s, and 0.5/550 s = 0.91 ms."""
    line = said()
    assert line.startswith("contact.normal: a rigid stop under an undamped beam has no limit")
    assert "beam.kelvin_voigt = 0.00091 s or more" in line
    enough = said("beam.kelvin_voigt=0.00091")
    assert enough == ""
    assert said(contacts=()) == ""  # it did not come to a contact


@pytest.mark.parametrize(
    ("value", "text"), [(9.11e-4, "0.00092"), (9.1e-4, "0.00091"), (0.0401, "0.041"), (1.0, "1")]
)
def test_damping_that_is_enough_is_rounded_up(value, text):
    assert _up(value) == text


def test_elements_that_do_not_resolve_the_damping_are_counted():
    """h <= pi sqrt(eta c): 20.2 elements for 1e-5 s and c = 24.96 m^2/s."""
    line = said(*NODAL, DAMPED, "discretization.elements=16")
    assert line.startswith("beam.kelvin_voigt: 1e-05 s is not resolved by 16 elements")
    assert "about 21 elements, or 1.6e-05 s or more" in line
    assert said(*NODAL, DAMPED, "discretization.elements=21") == ""
    assert "resolved by 24 elements" in said(
        *NODAL, DAMPED, "discretization.elements=24", "discretization.grading=4"
    )


def test_modes_that_do_not_resolve_the_damping_are_counted():
    """eta omega_N >= 0.5: omega of hinged mode N is ((N + 1/4) pi)^2 c, and 14 of them reach 5e4 rad/s."""
    modal = (DAMPED, "discretization.frame=mean-axis")
    assert "not resolved by 8 modes" in said(*modal, "discretization.modes=8")
    assert "not resolved by 13 modes" in said(*modal, "discretization.modes=13")
    assert said(*modal, "discretization.modes=15") == ""


def test_a_soft_stop_that_is_met_very_often_is_named_too():
    soft = (SPRING, "contact.stiffness=1e7")
    assert said(*soft, contacts=(20, 3)) == ""
    assert "met 21 times" in said(*soft, contacts=(3, 21))


@pytest.mark.parametrize(("normal", "peak"), [("rigid", False), ("spring", True)])
def test_a_peak_that_has_no_limit_is_not_printed(normal, peak, tmp_path, capsys):
    changes = (f"contact.normal={normal}", "end_time=0.34", "discretization.frame=mean-axis")
    history = simulate(Scenario.builtin("paper", changes))
    print("\n".join(summary_lines(history, tmp_path, False)))
    shown = capsys.readouterr().out
    assert (", peak " in shown) is peak
    assert ("warning: contact.normal: a rigid stop" in shown) is not peak
    assert history.summary["macro_collisions"][0]["peak_force"] > 0.0
