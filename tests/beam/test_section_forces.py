"""Section forces at the pin, and where accelerations are unknown; the rest: `tests/history/test_identities`."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import Scenario
from oblique_impact.beam.section_forces import Motion, PointLoads, fields_along
from oblique_impact.beam_problem import beam_of

MASS, BENDING, GRAVITY = 0.86874, 541.27, 9.8  # kg/m, N m^2, m/s^2: the paper's beam


def test_a_beam_on_three_supports():
    """Uniform beam of two equal spans l, pinned at its root: reactions 3/8, 10/8 and 3/8 of w l (Timoshenko).

    Its moment is -w l^2/8 over the middle support and 9 w l^2/128 at 3/8 of a span.  A third contact is open.
    """
    scenario = Scenario.from_dict(
        {
            "gravity": GRAVITY,
            "beam": {"area": 1.0, "density": MASS, "youngs_modulus": BENDING, "second_moment": 1.0},
            "initial": {"angle": 0.3},
            "contact": {"enabled": False},
            "discretization": {"method": "fem", "elements": 8, "modes": 4},
        }
    )
    beam = beam_of(scenario)
    x, span, nan = beam.operators.stations.points, 0.5, np.nan
    load = MASS * GRAVITY * np.cos(0.3)  # per length, across the beam; its part along it pulls at the pin
    place, force = np.array([[span, 2.0 * span, nan]]), load * span * np.array([[1.25, 0.375, 0.0]])
    c, s = np.cos(0.3), np.sin(0.3)
    q, rest = np.array([[0.3, 0.0, 0.0, 0.0, 0.0]]), np.zeros((1, 5))
    fields = fields_along(
        beam, Motion(np.zeros(1), q, rest, rest, PointLoads(place, c * place, s * place, -s * force, c * force))
    )
    along = np.minimum(x, 2.0 * span - x)  # from the nearer end
    moment = load * (0.375 * span * along - 0.5 * along**2)
    np.testing.assert_allclose(fields.moment[0], moment, atol=1e-12)
    middle, largest = int(np.argmin(np.abs(x - span))), int(np.argmin(np.abs(x - 0.375 * span)))
    assert fields.moment[0, middle] == pytest.approx(-load * span**2 / 8.0, rel=1e-12)
    assert fields.moment[0, largest] == pytest.approx(9.0 * load * span**2 / 128.0, rel=1e-12)
    inboard = x <= span  # just inboard of the middle support the shear is -5/8 w l
    shear = load * np.where(inboard, 0.375 * span - x, 1.625 * span - x)
    np.testing.assert_allclose(fields.shear[0], shear, atol=1e-12)
    np.testing.assert_allclose(fields.axial_force[0], -MASS * GRAVITY * s * (2.0 * span - x), atol=1e-12)


def test_section_forces_are_unknown_where_accelerations_are_and_do_not_depend_on_the_block():
    shapes = ("method=fem", "elements=4", "modes=3")
    scenario = Scenario.builtin("paper", ["contact.enabled=false", *(f"discretization.{key}" for key in shapes)])
    model, rng = beam_of(scenario), np.random.default_rng(5)
    loads = PointLoads(*rng.normal(size=(5, 7, 2)))
    motion = Motion(np.zeros(7), *(rng.normal(size=(7, 4)) for _ in range(3)), loads)
    motion.qdd[4] = np.nan
    whole = fields_along(model, motion, 100)._asdict()
    for name, found in fields_along(model, motion, 3)._asdict().items():
        np.testing.assert_allclose(found, whole[name], rtol=1e-9, atol=1e-9 * np.nanmax(np.abs(whole[name])))
        known = ~np.isnan(found).any(axis=1)
        assert known.tolist() == [k != 4 or name in ("ux", "uy", "ux_dot", "uy_dot") for k in range(7)]
