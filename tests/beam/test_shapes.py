"""Cross-sections by their shapes, materials by their names: closed forms, and bending stress of tapered beams."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from scipy.integrate import quad

from oblique_impact import Scenario, natural_frequencies
from oblique_impact.beam.cross_sections import Sections

FEM = {"discretization__method": "fem", "discretization__modes": 3, "discretization__frame": "mean-axis"}


def shaped(shape: str, **sizes) -> Scenario:
    keys = {f"beam__section__{name}": size for name, size in sizes.items()}
    return Scenario().replace(beam__section__shape=shape, **keys, **FEM)


def by_strips(width_at, height: float) -> tuple[float, float]:
    """Area and second moment of a section of some width at the height y over its centre."""
    half = 0.5 * height
    corners = [-half, half]
    area = quad(width_at, -half, half, points=corners, limit=500, epsabs=1e-14)[0]
    return area, quad(lambda y: width_at(y) * y * y, -half, half, limit=500, epsabs=1e-18)[0]


#: sizes (m), the width of the section at the height y, its height
BY_STRIPS = {
    "rectangle": ({"width": 0.03, "height": 0.01}, lambda y: 0.03, 0.01),
    "circle": ({"diameter": 0.02}, lambda y: 2.0 * math.sqrt(max(0.01**2 - y * y, 0.0)), 0.02),
    "tube": (
        {"diameter": 0.03, "thickness": 0.004},
        lambda y: 2.0 * (math.sqrt(max(0.015**2 - y * y, 0.0)) - math.sqrt(max(0.011**2 - y * y, 0.0))),
        0.03,
    ),
    "i-beam": (
        {"width": 0.04, "height": 0.06, "flange_thickness": 0.006, "web_thickness": 0.004},
        lambda y: 0.04 if abs(y) > 0.024 else 0.004,
        0.06,
    ),
}


@pytest.mark.parametrize("shape", BY_STRIPS)
def test_area_second_moment_and_outer_fibre_by_strips(shape):
    sizes, width_at, height = BY_STRIPS[shape]
    beam = shaped(shape, **sizes).beam
    area, second_moment = by_strips(width_at, height)
    assert beam.area == pytest.approx(area, rel=1e-5)
    assert beam.second_moment == pytest.approx(second_moment, rel=1e-5)
    assert beam.outer_fibre == height / 2.0


#: a rectangle whose height falls to a half, and another kink inside
TAPER = {"width": [[0.0, 0.02], [0.4, 0.03], [1.0, 0.015]], "height": [[0.0, 0.02], [1.0, 0.01]]}
HEIGHT = Polynomial([0.02, -0.01])
WIDTHS = ((0.0, 0.4, Polynomial([0.02, 0.025])), (0.4, 1.0, Polynomial([0.04, -0.025])))


def integral(weight) -> float:
    """Integral over the beam of a polynomial that depends on the width."""
    total = 0.0
    for a, b, width in WIDTHS:
        whole = weight(width).integ()
        total += whole(b) - whole(a)
    return total


def test_sizes_over_x_are_met_exactly():
    scenario = shaped("rectangle", **TAPER)
    sections = Sections.from_scenario(scenario)
    x = np.array([0.0, 0.1, 0.4, 0.77, 1.0])
    width, height = np.interp(x, [0.0, 0.4, 1.0], [0.02, 0.03, 0.015]), HEIGHT(x)
    np.testing.assert_allclose(sections.area(x), width * height, rtol=1e-14)
    np.testing.assert_allclose(sections.second_moment(x), width * height**3 / 12.0, rtol=1e-14)
    np.testing.assert_allclose(sections.fibre_distance(x), height / 2.0, rtol=1e-14)
    rho, X = scenario.beam.density, Polynomial([0.0, 1.0])
    assert sections.mass == pytest.approx(rho * integral(lambda w: w * HEIGHT), rel=1e-14)
    assert sections.static_moment == pytest.approx(rho * integral(lambda w: w * HEIGHT * X), rel=1e-14)
    assert sections.inertia == pytest.approx(rho * integral(lambda w: w * HEIGHT * X**2), rel=1e-14)
    assert float(sections.outer_mass(0.4)) == pytest.approx(
        rho * ((WIDTHS[1][2] * HEIGHT).integ()(1.0) - (WIDTHS[1][2] * HEIGHT).integ()(0.4)), rel=1e-14
    )


def test_frequencies_of_a_wedge():
    """A cantilever of constant width whose height falls to nearly nothing.

    Exact for the wedge: omega = 5.315 sqrt(E h^2 / (12 rho L^4)) with the height h at the root (Kirchhoff 1879;
    Naguleswaran, J. Sound Vib. 172, 1994, 289-304, table 1: 5.3151, 15.2072).
    """
    wedge = shaped("rectangle", width=0.02, height=[[0.0, 0.02], [1.0, 1e-5]])
    clamped = wedge.replace(root__kind="driven", discretization__frame="tangent", discretization__elements=80)
    beam = wedge.beam
    unit = math.sqrt(beam.youngs_modulus * 0.02**2 / (12.0 * beam.density))
    found = natural_frequencies(clamped, [0.0], 2).flapwise[0] / unit
    assert found[0] == pytest.approx(5.3151, rel=2e-3)
    assert found[1] == pytest.approx(15.2072, rel=5e-3)


def test_the_resolved_file_is_the_same_beam_and_follows_what_is_changed_in_it():
    scenario = shaped("rectangle", **TAPER).replace(beam__material="titanium")
    text = scenario.to_toml()
    again = Scenario.from_toml(text)
    assert again == scenario
    followers = {"area", "second_moment", "outer_fibre", "density", "youngs_modulus"}
    assert not followers & (again.beam.model_fields_set | scenario.beam.model_fields_set)
    assert "[beam.section]\n" in text
    assert 'shape = "rectangle"' in text
    assert "diameter" not in text
    first = Sections.from_scenario(scenario)
    x = np.linspace(0.0, 1.0, 11)
    np.testing.assert_array_equal(Sections.from_scenario(again).second_moment(x), first.second_moment(x))
    changed = Scenario.from_toml(text, ["beam.section.width=0.02", "beam.material=steel"])
    assert (changed.beam.density, changed.beam.youngs_modulus) == (7850.0, 210e9)
    np.testing.assert_allclose(Sections.from_scenario(changed).area(0.5), 0.02 * 0.015)
    assert scenario.replace(beam__section__height=0.01).beam.area[0] == (0.0, pytest.approx(2e-4))
