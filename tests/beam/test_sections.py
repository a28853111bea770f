"""Tables over x, tip mass and graded meshes: input, sizes of elements, frequencies."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from oblique_impact import Scenario, fem_beam
from oblique_impact.beam.operators import build_operators
from oblique_impact.fem_beam.mesh import beam_mesh
from oblique_impact.validation.reference_values import VALUES
from oblique_impact.validation.runs import UNIT
from tests.refusals import refused_in_one_line

LENGTH = 1.3


# Input ----------------------------------------------------------------------------------------------------------

BAD = {
    "not a number": ('[beam]\narea = "thick"', ["beam.area", '"thick"', "number in m^2", "1 m^2"]),
    "one row": ("[beam]\narea = [[0, 1e-4]]", ["beam.area", "2 to 1000 pairs", "not of 1"]),
    "too many rows": (f"[beam]\narea = {[[i, 1.0] for i in range(1001)]}", ["beam.area", "1000", "not of 1001"]),
    "row of three": (
        "[beam]\narea = [[0, 1e-4], [1, 2e-4, 3]]",
        ["beam.area", "pairs", "row 2", "[1, 0.0002, 3]"],
    ),
    "table in a row": ("[beam]\narea = [[0, {a = 1}], [1, 2]]", ["beam.area", "pairs", "row 1", "{a = 1}"]),
    "late start": ("[beam]\narea = [[0.1, 1], [1, 1]]", ["beam.area", "begins at x = 0", "not at 0.1"]),
    "not ascending": ("[beam]\narea = [[0, 1], [0.5, 1], [0.5, 2], [1, 1]]", ["beam.area", "ascending", "row 3"]),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_tables_are_one_line_with_key_value_and_what_is_allowed(name):
    text, parts = BAD[name]
    with refused_in_one_line(*parts):
        Scenario.from_toml(text)


# Meshes ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("grading", [1.0, 1.5, 30.0, 1e4])
@pytest.mark.parametrize("elements", [2, 7, 64])
def test_sizes_shrink_geometrically_to_a_contact_point_at_the_tip(grading, elements):
    sizes = np.diff(beam_mesh(LENGTH, elements, LENGTH, grading=grading).p[0])
    assert sizes.size == elements
    assert sizes.sum() == pytest.approx(LENGTH, rel=1e-14)
    assert_allclose(sizes[:-1] / sizes[1:], grading ** (1.0 / (elements - 1)), rtol=1e-7)


@pytest.mark.parametrize("grading", [3.0, 100.0])
@pytest.mark.parametrize("kinks", [[], [0.1, 0.33, 1.1]])
def test_sizes_shrink_from_both_sides_to_a_contact_point_inside(grading, kinks):
    point = 0.8
    nodes = beam_mesh(LENGTH, 30, point, np.array(kinks), grading).p[0]
    sizes = np.diff(nodes)
    assert (nodes.size, nodes[0], nodes[-1]) == (31, 0.0, LENGTH)
    for place in (point, *kinks):
        assert np.abs(nodes - place).min() == 0.0
    assert sizes.max() / sizes.min() == pytest.approx(grading, rel=1e-9)
    if not kinks:
        left, right = sizes[nodes[1:] <= point], sizes[nodes[:-1] >= point]
        assert np.all(np.diff(left) < 0.0)
        assert np.all(np.diff(right) > 0.0)
        assert 0.7 < left[-1] / right[0] < 1.4
        for side in (left, right):
            assert_allclose(side[1:] / side[:-1], side[1] / side[0], rtol=1e-9)


def test_kinks_that_lie_too_close_get_no_nodes_of_their_own():
    kinks = np.array([0.3, 0.3001, 0.9999])
    nodes = beam_mesh(1.0, 10, 1.0, kinks).p[0]
    assert np.diff(nodes).min() > 0.05 / 10
    assert np.abs(nodes - 0.3).min() == 0.0
    many = beam_mesh(1.0, 12, 0.77, np.linspace(0.0, 1.0, 202)[1:-1]).p[0]
    assert many.size == 13
    assert np.abs(many - 0.77).min() == 0.0
    assert np.all(np.diff(many) > 0.0)


# Frequencies ----------------------------------------------------------------------------------------------------

UNEVEN = {
    "area": [[0.0, 1.0], [0.3, 0.5], [1.0, 0.8]],
    "second_moment": [[0.0, 1.0], [0.6, 0.4], [1.0, 0.3]],
    "tip_mass": 0.2,
}


def shooting(guess, frame):
    """Frequency near `guess`: (EI w'')'' = m omega^2 w integrated from the tip, which carries the tip mass."""
    area, second_moment = np.transpose(UNEVEN["area"]), np.transpose(UNEVEN["second_moment"])
    places = np.union1d(area[0], second_moment[0])

    def remainder(omega):
        def slope(x, y):  # y = w, w', M = EI w'', M'
            stiffness, mass = np.interp(x, *second_moment), np.interp(x, *area)
            return [y[1], y[2] / stiffness, y[3], mass * omega**2 * y[0]]

        ends = []
        for start in ([1.0, 0.0, 0.0, -UNEVEN["tip_mass"] * omega**2], [0.0, 1.0, 0.0, 0.0]):
            y = np.array(start)
            for a, b in zip(places[-2::-1], places[:0:-1], strict=True):
                y = solve_ivp(slope, (b, a), y, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
            ends.append(y[[0, 1]] if frame == "tangent" else y[[0, 2]])
        return float(np.linalg.det(ends))

    return brentq(remainder, 0.98 * guess, 1.01 * guess, xtol=1e-12)


@pytest.mark.parametrize("frame", ["tangent", "mean-axis"])
@pytest.mark.parametrize("grading", [1.0, 8.0])
def test_frequencies_of_tables_with_a_tip_mass_converge_at_order_four(frame, grading):
    """Kinks of either table at nodes; clamped-free and hinged-free."""

    def beam(elements):
        shapes = {"method": "fem", "frame": frame, "modes": 3, "elements": elements, "grading": grading}
        free = {"beam": {**UNIT, **UNEVEN}, "contact": {"enabled": False}, "discretization": shapes}
        return Scenario.from_dict(free)

    found = [build_operators(beam(n)).natural_frequencies() for n in (10, 20, 40)]
    exact = np.array([shooting(guess, frame) for guess in found[0]])
    errors = np.array(found) / exact - 1.0
    order = np.log2(errors[:-1] / errors[1:])
    if grading == 1.0:
        assert np.all((order > 3.9) & (order < 4.1)), order
    # dispersion of a uniform mesh, (beta h)^4/1440 with beta^4 = omega^2 m/EI at its largest, m/EI < 3
    largest = np.max(np.diff(fem_beam.NodalBeam.from_scenario(beam(40)).nodes))
    assert np.all(errors[2] > -1e-10)
    assert np.all(errors[2] < 3.0 * exact**2 * largest**4 * VALUES["1.3"])
