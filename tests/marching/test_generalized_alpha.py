"""Generalized-alpha on fine meshes: rounding does not reach the motion."""

import numpy as np
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


def test_reported_forces_end_with_the_branch_of_friction():
    """A branch ends where its slip velocity is located, in steps a little beyond it: by 3e-8 of the force here."""
    contact = {
        "point": 1.0,
        "normal": "spring",
        "shortening": False,
        "friction": "modified-coulomb",
        "mu_kinetic": 0.1,
    }
    history = simulate(
        Scenario.from_dict(
            {
                "end_time": 0.5,
                "beam": {"youngs_modulus": 1e10},
                "initial": {"angle": 1.0},
                "slope": {"origin": [0.0, 0.0], "angle": 0.0},
                "discretization": {"method": "fem", "frame": "mean-axis", "modes": 0, "elements": 2},
                "contact": contact,
                "solver": {"scheme": "generalized-alpha", "contact_step": 1e-5, "rho_infinity": 0.0},
            }
        )
    )
    normal, tangential = history["lambda_n"].values, history["lambda_tau"].values
    assert sum(event.kind.value == "reversal" for event in history.events) > 2
    assert np.all(np.abs(tangential) <= 0.1 * (1.0 + 1e-12) * np.maximum(normal, 0.0))
