"""Values that are hardly meant are named before a run, and in its summary; the built-in cases have none."""

import json
import math

import pytest

from oblique_impact import Scenario
from oblique_impact.beam.plausibility import implausible_values
from oblique_impact.scenario.scenario import builtin_names

# changes of the paper's case -> the beginning of each line, and what it must say
DOUBTS = {
    "GPa left out": (
        ["beam.youngs_modulus=70"],
        [("beam.youngs_modulus: 70 Pa", '"70 GPa"'), ("beam.length: ", "")],
    ),
    "MPa for Pa": (
        ["beam.youngs_modulus=7e4"],
        [("beam.youngs_modulus: 70000 Pa", '"70 GPa"'), ("beam.length: ", "")],
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
}


@pytest.mark.parametrize("name", builtin_names())
def test_builtin_cases_are_plausible(name):
    assert implausible_values(Scenario.builtin(name)) == []


@pytest.mark.parametrize("case", DOUBTS)
def test_what_is_hardly_meant_is_named(case):
    changes, expected = DOUBTS[case]
    found = implausible_values(Scenario.builtin("paper", changes))
    assert len(found) == len(expected), found
    for line, (start, words) in zip(found, expected, strict=True):
        assert line.startswith(start)
        assert words in line
        assert len(line.splitlines()) == 1


@pytest.mark.parametrize(
    ("key", "softest", "stiffest"),
    [("beam.youngs_modulus", 1e6, 1.3e12), ("beam.density", 20.0, 3e4)],
)
def test_rubber_and_diamond_foam_and_osmium_are_plausible(key, softest, stiffest):
    """Moduli in Pa, densities in kg/m^3: what lies between them, but no more, is not named."""
    for value, named in ((0.99 * softest, 1), (1.01 * softest, 0), (0.99 * stiffest, 0), (1.01 * stiffest, 1)):
        lines = implausible_values(Scenario.builtin("paper", [f"{key}={value}"]))
        assert sum(line.startswith(key) for line in lines) == named, value


def stout(*changes):
    found = implausible_values(Scenario.builtin("paper", ["contact.enabled=false", *changes]))
    return [line for line in found if line.startswith("beam.second_moment")]


def test_a_radius_of_gyration_of_a_fifth_of_the_length_is_named():
    """sqrt(I/A) = 5 mm of the paper's beam; 30 mm at the thick end of one that is 0.1 m long."""
    assert stout("beam.length=0.0249")
    assert not stout("beam.length=0.0251")
    (line,) = stout(
        "discretization.method=fem",
        "beam.length=0.1",
        "beam.area=1e-4",
        "beam.second_moment=[[0,9e-8],[0.1,1e-12]]",
    )
    assert "sqrt(I/A) = 0.03 m, is more than a fifth of beam.length = 0.1 m" in line


@pytest.mark.parametrize(("factor", "named"), [(0.45, False), (0.55, True)])
def test_the_limit_of_bending_under_its_own_weight(factor, named):
    """m g L^4/(8 E I) of the uniform beam; at half its length it is named."""
    weight = 2766.7 * 3.14e-4 * 9.8  # N/m
    modulus = weight / (8.0 * 7.85e-9 * factor)
    assert (
        any(
            line.startswith("beam.length")
            for line in implausible_values(Scenario().replace(beam__youngs_modulus=modulus))
        )
        == named
    )
    none = Scenario().replace(beam__youngs_modulus=modulus, gravity=0.0)
    assert not any(line.startswith("beam.length") for line in implausible_values(none))


def test_the_first_period_is_that_of_a_clamped_beam():
    """1.875104^2 sqrt(E I/(m L^4)); a step just above it is named, one just below is not."""
    period = 2.0 * math.pi / (1.875104**2 * math.sqrt(68.952e9 * 7.85e-9 / (2766.7 * 3.14e-4)))
    for factor, named in ((1.01, True), (0.99, False)):
        scenario = Scenario().replace(solver__scheme="fixed-step", solver__free_step=factor * period)
        assert bool(implausible_values(scenario)) == named


def test_warnings_stand_in_the_summary_and_are_printed_before_the_run(tmp_path, cli):
    changes = ["end_time=0.001", "beam.density=7.8"]
    options = [word for change in changes for word in ("--set", change)]
    warning = 'beam.density: 7.8 kg/m^3 is lighter than foam; did you mean "7.8 g/cm^3"?'
    code, out, err = cli("run", "paper", *options, "--out", tmp_path / "out")
    assert (code, err.splitlines()[0]) == (0, f"oblique-impact: warning: {warning}")
    assert warning not in out  # once is enough
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["warnings"] == [warning]
