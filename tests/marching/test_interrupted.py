"""Ctrl-C during a run: what is computed is kept, and the loop around the run ends."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import History, Interrupted, Outcome, Scenario, simulate, simulate_system
from oblique_impact.contact.friction import Coulomb
from oblique_impact.contact.impacts import NewtonImpact
from tests.systems import Block

NODAL = (
    'discretization={method="fem", elements=8, modes=0, frame="mean-axis"}',
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


class Thrown(Block):
    """A block of 1 kg that is thrown onto a rough ground, and interrupted as its forces are asked for."""

    def __init__(self, calls: int = 10**9) -> None:
        super().__init__(lambda t, q, qd: (0.0, -9.8))
        self.left = calls

    def forces(self, t, q, qd):
        self.left -= 1
        if self.left == 0:
            raise KeyboardInterrupt
        return super().forces(t, q, qd)

    def energy(self, t, q, qd):
        return 0.5 * float(qd @ qd), 0.0, 9.8 * float(q[1])

    def run(self) -> History:
        """A rebound, a second impact with the rest of the slip, and stick."""
        laws = {"friction": Coulomb(0.3, 0.3), "impact_law": NewtonImpact(0.3)}
        return simulate_system(self, [0.0, 0.1], [0.4, 0.0], 0.5, output_interval=5e-2, **laws)


def test_an_interrupt_within_a_transition_leaves_books_that_agree():
    """At any call of the forces: momentum and energy balance at the last sample, and nothing is later than it."""
    whole = Thrown()
    assert [e.kind.value for e in whole.run().events][-1] == "stick"
    calls = 10**9 - whole.left
    for call in np.linspace(30, calls - 60, 150).astype(int):
        with pytest.raises(Interrupted) as stopped:
            Thrown(int(call)).run()
        history = stopped.value.history
        end = history.summary["end_time"]
        assert end == float(history["time"].values[-1])
        assert all(event.time <= end for event in history.events)
        assert all(contact.start <= contact.end <= end for contact in history.contacts)
        pushed = sum(contact.normal_impulse for contact in history.contacts)
        assert pushed - 9.8 * end == pytest.approx(float(history["qd"][-1, 1]), abs=1e-9)
        rubbed = sum(contact.tangential_impulse for contact in history.contacts)
        assert 0.4 + rubbed == pytest.approx(float(history["qd"][-1, 0]), abs=1e-9)
        assert abs(history.summary["energy"]["unaccounted"]) < 1e-9


@pytest.mark.parametrize("calls", [1, 2, 4])
def test_time_stepping_is_interrupted_alike(calls):
    """Events are logged by the steps of a call: those behind its last sample are not of the history."""
    keys = "initial.angle=0.2214 initial.angular_velocity=-6 contact.where=anywhere contact.grid=4 end_time=0.1"
    steps = (
        "solver.scheme=time-stepping solver.contact_step=1e-5 solver.free_step=1e-5 solver.output_interval=7e-3"
    )
    with pytest.raises(Interrupted) as stopped:
        simulate(
            Scenario.builtin("paper", [*keys.split(), *steps.split(), "discretization.frame=mean-axis"]),
            after(calls),
        )
    history = stopped.value.history
    end = history.summary["end_time"]
    assert history.contacts
    assert all(event.time <= end for event in history.events)
    assert all(
        contact.start <= contact.end <= end and contact.normal_impulse >= 0.0 for contact in history.contacts
    )
    assert abs(history.summary["energy"]["unaccounted"]) < 1e-5 * history.summary["energy"]["initial"]
