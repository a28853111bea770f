"""Meshes at a rigid stop: drift, stick, steps that do not resolve the mesh."""

import numpy as np
import pytest

from oblique_impact import Outcome
from oblique_impact.contact.transitions import EventKind
from oblique_impact.validation.runs import FEM, MEAN_AXIS


def test_sticking_on_a_rigid_stop_holds_both_constraints(run):
    """mu = 12: nine sticks in one collision; neither gap nor slip drifts while the tip sticks."""
    history = run(
        "paper",
        FEM,
        MEAN_AXIS,
        "discretization.elements=3",
        "discretization.modes=6",
        "contact.mu_static=12.0",
        "contact.mu_kinetic=12.0",
        "solver.output_interval=1e-5",
        "end_time=0.34",
    )
    assert history.outcome is Outcome.COMPLETED
    assert [event.kind for event in history.events].count(EventKind.STICK) >= 8
    state, slip, gap = (history[name].values for name in ("state", "slip", "gap"))
    sticks = np.flatnonzero(state == 2)
    assert sticks.size > 100
    for stick in np.split(sticks, np.flatnonzero(np.diff(sticks) > 1) + 1):
        assert np.ptp(slip[stick]) < 1e-9
        assert np.abs(gap[stick]).max() < 1e-9
        tangential, normal = (history[name].values[stick] for name in ("lambda_tau", "lambda_n"))
        assert np.all(np.abs(tangential) <= 12.0 * normal * (1.0 + 1e-6) + 1e-6)


@pytest.mark.parametrize(("elements", "step"), [(32, 1e-4), (64, 2e-5), (128, 2e-5), (128, 1e-4)])
def test_steps_that_do_not_resolve_the_mesh_gain_no_energy(run, elements, step):
    """Up to 41 h^2/c: impacts must not throw what is not resolved."""
    history = run(
        "paper",
        FEM,
        "discretization.modes=0",
        f"discretization.elements={elements}",
        "contact.friction=frictionless",
        f"solver.free_step={step}",
        f"solver.contact_step={step}",
        "end_time=0.34",
    )
    assert history.outcome is Outcome.COMPLETED
    energy, total = history.summary["energy"], history.total_energy.values
    assert total.max() < energy["initial"] + 1e-7
    assert 0.3 < energy["lost_impact"] < 0.7  # 0.5 to 0.65 J with 4 to 20 modes, the less the finer they are
    assert energy["lost_scheme"] == 0.0
    assert abs(energy["unaccounted"]) < 1e-6
    assert history.summary["macro_collisions"][0]["normal_impulse"] == pytest.approx(1.87, abs=0.12)
