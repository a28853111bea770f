"""Values that are hardly meant are named before a run, and in its summary; the built-in cases have none."""

import pytest

from oblique_impact import Scenario
from oblique_impact.beam.validity.plausibility import implausible_values
from oblique_impact.scenario.scenario import builtin_names

ANYWHERE = ["contact.where=anywhere", "slope.enabled=false", "root.kind=driven", "initial.angle=0"]

# changes of the paper's case -> the beginning of each line, and what it must say
DOUBTS = {
    "GPa left out": (
        ["beam.youngs_modulus=70"],
        [("beam.youngs_modulus: 70 Pa", '"70 GPa"'), ("beam.length: ", "")],
    ),
    "steel in MPa": (
        ["beam.youngs_modulus=210000"],
        [("beam.youngs_modulus: ", '"210 GPa"'), ("beam.length: ", "")],
    ),
    "stiffer than diamond": (["beam.youngs_modulus=7e13"], [("beam.youngs_modulus: ", "stiffer than diamond")]),
    "density in g/cm^3": (["beam.density=2.7"], [("beam.density: 2.7 kg/m^3", '"2.7 g/cm^3"')]),
    "denser than osmium": (["beam.density=5e4"], [("beam.density: ", "denser than metal")]),
    "stout": (["beam.length=0.02", "slope.origin=[0.0, 0.0]"], [("beam.second_moment: ", "Euler-Bernoulli")]),
    "fibre inside the axis": (["beam.outer_fibre=1 mm"], [("beam.outer_fibre: 0.001 m", "sqrt(I/A) = 0.005 m")]),
    "degrees": (["slope.angle=5"], [("slope.angle: 5 rad are 286 degrees", '"5 deg"')]),
    # half of 0.00091 s times the first frequency of the pinned beam, (3.9266 / L)^2 sqrt(E I/m) = 384.9 rad/s
    "damping fitted to a mesh": (["beam.kelvin_voigt=0.00091"], [("beam.kelvin_voigt: 0.00091 s", "17.5 %")]),
    "mass-proportional damping": (["beam.mass_proportional=77"], [("beam.mass_proportional: 77 1/s", "10 %")]),
    "modal damping": (["beam.modal_damping_ratio=0.06"], [("beam.modal_damping_ratio: 0.06", "6 %")]),
    "steps": (
        ["solver.scheme=fixed-step", "solver.free_step=0.1"],
        [("solver.free_step: 0.1 s", "first period of about 0.0716 s")],
    ),
    "steps on a shaken base": (
        ["solver.scheme=fixed-step", "solver.free_step=0.002", "base.acceleration=1", "base.sweep_rate=50"],
        [("solver.free_step: 0.002 s", "1/18 of a period of the base of 0.02 s")],
    ),
    "steps under a force": (
        ["solver.scheme=fixed-step", "solver.free_step=0.002", "forces=[{force=1},{force=1,frequency=50}]"],
        [("solver.free_step: 0.002 s", "1/18 of a period of force 2 of 0.02 s")],
    ),
    # 0.6 (0.01 m)^2/1 m are 60 um
    "a peg at the end of a held beam": (
        [*ANYWHERE, 'obstacles=[{kind="point",origin=[0.99995,-0.01]}]'],
        [("obstacles.1.origin: 0.99995 m along the beam", "ends at 0.99994 m")],
    ),
    "a base that shakes along the beam": (
        ["base.acceleration=1", "base.frequency=20", "initial.angle=90 deg", "root.kind=driven"],
        [("base.direction: ", 'across it is "0 deg"')],
    ),
}
#: of the last one: something else bends the beam
BENT = ("forces=[{force=1}]", "initial.angle=80 deg", "base.direction=1 deg", "initial.angular_velocity=0.1")


@pytest.mark.parametrize("name", builtin_names())
def test_builtin_cases_are_plausible(name):
    assert implausible_values(Scenario.builtin(name)) == ()


@pytest.mark.parametrize("case", DOUBTS)
def test_what_is_hardly_meant_is_named(case):
    changes, expected = DOUBTS[case]
    found = implausible_values(Scenario.builtin("paper", changes))
    assert len(found) == len(expected), found
    for line, (start, words) in zip(found, expected, strict=True):
        assert line.startswith(start)
        assert words in line
        assert len(line.splitlines()) == 1


@pytest.mark.parametrize("change", BENT)
def test_a_base_that_shakes_along_a_beam_is_named_only_where_nothing_bends_it(change):
    (changes, _) = DOUBTS["a base that shakes along the beam"]
    kept = [*changes, "root.kind=pin"] if "velocity" in change else changes
    assert implausible_values(Scenario.builtin("paper", [*kept, change])) == ()


def test_a_peg_that_the_end_of_a_held_beam_reaches_is_none():
    for place in (0.9999, 1.001):
        near = f'obstacles=[{{kind="point",origin=[{place},-0.01]}}]'
        assert implausible_values(Scenario.builtin("paper", [*ANYWHERE, near])) == ()
