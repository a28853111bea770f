"""Section forces at the pin, and where accelerations are unknown; the rest: `tests/history/test_identities`."""

from __future__ import annotations

import numpy as np

from oblique_impact import Scenario
from oblique_impact.beam.section_forces import Motion, fields_along
from oblique_impact.problem import beam_of


def test_first_order_kinetics_leave_a_small_moment_at_the_pin(run):
    """Third powers of the deflection, which they drop: here 1e-3 of the largest moment, mean-axis frame."""
    moment = run("paper", "discretization.frame=mean-axis", "discretization.modes=3")["moment"].values
    assert np.abs(moment[:, 0]).max() < 2e-3 * np.abs(moment).max()
    assert np.abs(moment[:, -1]).max() == 0.0


def test_section_forces_are_unknown_where_accelerations_are_and_do_not_depend_on_the_block():
    shapes = ("method=fem", "elements=4", "modes=3")
    scenario = Scenario.builtin("paper", ["contact.enabled=false", *(f"discretization.{key}" for key in shapes)])
    model, rng = beam_of(scenario), np.random.default_rng(5)
    motion = Motion(np.zeros(7), *(rng.normal(size=(7, 4)) for _ in range(3)), *rng.normal(size=(2, 7)))
    motion.qdd[4] = np.nan
    whole = fields_along(model, motion, 100)._asdict()
    for name, found in fields_along(model, motion, 3)._asdict().items():
        np.testing.assert_allclose(found, whole[name], rtol=1e-9, atol=1e-9 * np.nanmax(np.abs(whole[name])))
        known = ~np.isnan(found).any(axis=1)
        assert known.tolist() == [k != 4 or name in ("ux", "uy", "ux_dot", "uy_dot") for k in range(7)]
