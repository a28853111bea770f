"""Operators of both discretizations: frequencies, reduction of large meshes, what is kept for equal beams."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from oblique_impact import Scenario, modal, natural_frequencies
from oblique_impact.beam.operators import build_operators
from oblique_impact.fem_beam import reduction


@pytest.mark.parametrize(("modes", "count"), [(2, 4), (6, 6)])
def test_as_many_frequencies_as_modes_but_four_at_least(modes, count):
    found = natural_frequencies(Scenario.builtin("paper", [f"discretization.modes={modes}"]))
    assert found.flapwise.shape == found.chordwise.shape == (1, count)


@pytest.mark.parametrize("frame", ["tangent", "mean-axis"])
def test_few_modes_of_a_large_mesh_are_those_of_the_whole_decomposition(frame, monkeypatch):
    """Shift-invert Lanczos against the singular vectors: frequencies to 2e-10, shapes to the root of that."""
    scenario = Scenario.builtin("paper").replace(
        discretization__method="fem",
        discretization__frame=frame,
        discretization__elements=128,
        discretization__modes=16,
    )
    quick = reduction.build_operators(scenario)
    monkeypatch.setattr(reduction, "_LARGE", 10**9)
    whole = reduction.build_operators(scenario)
    assert_allclose(quick.natural_frequencies(), whole.natural_frequencies(), rtol=2e-10)
    assert_allclose(quick.contact_shape, whole.contact_shape, atol=2e-8 * np.abs(whole.contact_shape).max())
    again = reduction.build_operators(scenario.replace(end_time=0.5))
    np.testing.assert_array_equal(again.K, whole.K)


@pytest.mark.parametrize(
    "change",
    [
        {"contact__point": 0.6},
        {"root__hub_radius": 0.2, "root__kind": "hub"},
        {"beam__density": 3000.0},
        {"discretization__modes": 3},
    ],
)
def test_operators_are_kept_for_equal_beams_alone(change):
    """Runs that differ in friction or slope share them, read-only; each of these differs in the beam at rest."""
    base = Scenario.builtin("paper").replace(discretization__frame="tangent")
    operators = build_operators(base)
    assert build_operators(base.replace(contact__mu_kinetic=0.1, slope__angle=0.2)) is operators
    with pytest.raises(ValueError, match="read-only"):
        operators.M1[0, 0] = 0.0
    other, kept = base.replace(**change), build_operators(base.replace(**change))
    fresh = modal.build_operators(other)
    for name in ("M1", "S", "P", "contact_shape"):
        np.testing.assert_array_equal(getattr(kept, name), getattr(fresh, name))
