"""Ctrl-C during a run: what is computed is kept, and the loop around the run ends."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from oblique_impact import History, Interrupted, Outcome, Scenario, simulate, simulate_system, simulation
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


@pytest.mark.parametrize("changes", [(), NODAL], ids=["modes", "nodes"])
@pytest.mark.parametrize("calls", [1, 3, 5])
def test_an_interrupted_run_keeps_what_is_computed(tmp_path, changes, calls):
    scenario = Scenario.builtin("paper", ["end_time=0.4", *changes])
    with pytest.raises(KeyboardInterrupt) as stopped:
        simulate(scenario, after(calls))
    assert isinstance(stopped.value, Interrupted)
    history, whole = stopped.value.history, simulate(scenario)
    assert history.summary["outcome"] == "interrupted"
    assert history.outcome.exit_code == 130
    count = history["time"].size
    assert 0 < count < whole["time"].size
    # the last sample is taken where the interrupt has come, the right-hand one of a jump perhaps
    for label, variable in history.data.data_vars.items():
        expected, found = whole[label].values[: count - 1], variable.values[: count - 1]
        scale = np.nanmax(np.abs(expected), initial=0.0)
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * scale, err_msg=str(label))
    loaded = History.load(history.save(tmp_path))
    xr.testing.assert_identical(loaded.data.drop_attrs(deep=False), history.data.drop_attrs(deep=False))
    assert loaded.summary["outcome"] == "interrupted"


def test_an_interrupt_ends_the_loop_over_runs():
    started = []

    def runs():
        for angle in (0.7, 0.8):
            started.append(angle)
            simulate(Scenario.builtin("paper", [f"initial.angle={angle}", "end_time=0.1"]), after(1))

    with pytest.raises(KeyboardInterrupt):
        runs()
    assert started == [0.7]


def test_a_small_system_is_interrupted_alike():
    ball, start, options = Block(lambda t, q, qd: (0.0, -9.8)), np.array([0.0, 1.0]), {"output_interval": 1e-3}
    with pytest.raises(Interrupted) as stopped:
        simulate_system(ball, start, np.zeros(2), 5.0, on_progress=after(2), **options)
    assert 0.0 <= stopped.value.history.summary["end_time"] < 5.0


def test_an_interrupt_after_the_last_step_loses_nothing(monkeypatch):
    """While the results along the beam are computed, which takes seconds for 1e5 samples."""
    calls, compute = [], simulation.beam_variables

    def interrupted_once(*arguments):
        calls.append(arguments)
        if len(calls) == 1:
            raise KeyboardInterrupt
        return compute(*arguments)

    monkeypatch.setattr(simulation, "beam_variables", interrupted_once)
    with pytest.raises(Interrupted) as stopped:
        simulate(Scenario.builtin("paper").replace(end_time=0.01))
    assert stopped.value.history.outcome is Outcome.COMPLETED
    assert float(stopped.value.history["time"][-1]) == 0.01
