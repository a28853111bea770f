"""Generalized-alpha on fine meshes: rounding does not reach the motion."""

import pytest

from oblique_impact import Scenario, simulate


@pytest.mark.parametrize(("elements", "grading"), [(512, 1.0), (128, 8.0)])
def test_rounding_of_fine_and_graded_meshes_does_not_reach_the_motion(elements, grading):
    """K x is zero, but its rounding grows like 1/h^3: taken from W it would hold the beam like a spring."""
    tips, nodal = (
        [],
        ("discretization.method=fem", "discretization.modes=0", "contact.enabled=false", "end_time=0.3"),
    )
    for number, ratio in ((64, 1.0), (elements, grading)):
        mesh = (f"discretization.elements={number}", f"discretization.grading={ratio}")
        history = simulate(Scenario.builtin("paper", [*nodal, *mesh]))
        assert history.outcome.exit_code == 0
        # gravity is sampled to second order: 1e-8 J at this step, on every mesh
        assert abs(history.summary["energy"]["unaccounted"]) < 1.5e-8
        tips.append(float(history["tip_y"][-1]))
    assert tips[1] == pytest.approx(tips[0], abs=2e-9)
