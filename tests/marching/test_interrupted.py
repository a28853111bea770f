"""Ctrl-C during a run: what is computed is kept, and the loop around the run ends."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import History, Interrupted, Outcome, Scenario, simulate, simulate_system
from tests.systems import Block

NODAL = (
    'discretization={method="fem", elements=8, modes=0, frame="mean-axis"}',
    "solver.scheme=generalized-alpha",
    "solver.free_step=5e-4",
)


def after(calls):
    """A progress callback that is interrupted at its n-th call."""
    left = [calls]

    def proceed(status):
        left[0] -= 1
        if left[0] == 0:
            raise KeyboardInterrupt

    return proceed


def assert_begins_as(history, whole):
    """An interrupted run is the beginning of the whole one, and its ledger closes."""
    assert history.outcome is Outcome.INTERRUPTED
    assert history.outcome.exit_code == 130
    count = history["time"].size
    assert 0 < count < whole["time"].size
    for label, variable in history.data.data_vars.items():
        expected = whole[label].values[:count]
        scale = np.nanmax(np.abs(expected), initial=0.0)
        np.testing.assert_allclose(variable, expected, rtol=1e-12, atol=1e-12 * scale, err_msg=str(label))
    energy = history.summary["energy"]
    assert abs(energy["unaccounted"]) < 1e-5 * energy["initial"]
    assert history.summary["end_time"] == float(history["time"][-1])


@pytest.mark.parametrize("changes", [(), NODAL], ids=["modes", "nodes"])
@pytest.mark.parametrize("calls", [1, 3, 5])
def test_an_interrupted_run_keeps_what_is_computed(tmp_path, changes, calls):
    scenario = Scenario.builtin("paper", ["end_time=0.4", *changes])
    with pytest.raises(KeyboardInterrupt) as stopped:
        simulate(scenario, after(calls))
    assert isinstance(stopped.value, Interrupted)
    assert_begins_as(stopped.value.history, simulate(scenario))
    assert History.load(stopped.value.history.save(tmp_path)).outcome is Outcome.INTERRUPTED


def test_the_exact_beam_is_interrupted_alike():
    exact = ["discretization.method=absolute", "discretization.elements=4", "contact.normal=spring"]
    with pytest.raises(Interrupted) as stopped:
        simulate(Scenario.builtin("paper", [*exact, "end_time=0.02"]), after(1))
    summary = stopped.value.history.summary
    assert summary["steps"] > 0
    assert 0.0 < summary["end_time"] < 0.02


def test_a_small_system_is_interrupted_alike():
    ball, start = Block(lambda t, q, qd: (0.0, -9.8)), np.array([0.0, 1.0])
    with pytest.raises(Interrupted) as stopped:
        simulate_system(ball, start, np.zeros(2), 5.0, on_progress=after(2), output_interval=1e-3)
    assert 0.0 <= stopped.value.history.summary["end_time"] < 5.0
