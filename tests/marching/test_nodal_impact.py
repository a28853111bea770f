"""The full nodal model at a rigid stop: pointwise force, drift, stick, steps that do not resolve the mesh."""

import numpy as np
import pytest

from oblique_impact import Outcome
from oblique_impact.contact.transitions import EventKind
from oblique_impact.validation.runs import NODAL


def test_sticking_on_a_rigid_stop_holds_both_constraints(run):
    """mu = 12: nine sticks in one collision; neither gap nor slip drifts while the tip sticks."""
    history = run(
        "paper",
        *NODAL,
        "discretization.elements=3",
        "contact.mu_static=12.0",
        "contact.mu_kinetic=12.0",
        "solver.free_step=1e-5",
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


def test_both_schemes_stick_alike(run):
    """The built-in case with a long stick, three modes: the same events, their times within the step's error."""
    alpha = run("sticking", "solver.scheme=generalized-alpha", "solver.free_step=1e-5")
    event = run("sticking")
    assert [e.kind for e in alpha.events] == [e.kind for e in event.events]
    assert EventKind.STICK in {e.kind for e in alpha.events}
    np.testing.assert_allclose([e.time for e in alpha.events], [e.time for e in event.events], atol=2e-6)


@pytest.mark.parametrize(
    ("elements", "step", "rho"),
    [(32, 1e-4, 0.8), (64, 2e-5, 0.8), (128, 2e-5, 0.5), (128, 1e-4, 0.0), (128, 1e-4, 0.5), (128, 1e-4, 0.8)],
)
def test_steps_that_do_not_resolve_the_mesh_gain_no_energy(run, elements, step, rho):
    """Up to 41 h^2/c: accelerations that start anew after every impact must not throw what is not resolved."""
    history = run(
        "paper",
        *NODAL,
        f"discretization.elements={elements}",
        "contact.friction=frictionless",
        f"solver.rho_infinity={rho}",
        f"solver.free_step={step}",
        f"solver.contact_step={step}",
        "end_time=0.34",
    )
    assert history.outcome is Outcome.COMPLETED
    energy = history.summary["energy"]
    assert 2.2 < energy["final"] < 2.5  # theory Sec. 6: 2.355 to 2.511 J
    assert energy["lost_scheme"] > 0.0
    assert abs(energy["unaccounted"]) < 2e-4
    assert history.summary["macro_collisions"][0]["normal_impulse"] == pytest.approx(1.87, abs=0.12)
