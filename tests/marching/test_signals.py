"""Interrupts of a run: neither lost nor in the midst of what belongs together."""

from __future__ import annotations

import signal
import threading

import h5py
import numpy as np
import pytest

from oblique_impact import Interrupted, Scenario, simulate
from oblique_impact.fem_beam.exact.run import Run as AbsoluteRun
from oblique_impact.files import CheckedFile
from oblique_impact.interrupts import hold_interrupts
from oblique_impact.kernels.compiling import preparing
from oblique_impact.marching.event import EventScheme

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@pytest.fixture(autouse=True)
def usual_handlers():
    before = [signal.signal(number, signal.default_int_handler) for number in SIGNALS]
    yield
    for number, handler in zip(SIGNALS, before, strict=True):
        assert signal.getsignal(number) is signal.default_int_handler
        signal.signal(number, handler)


@pytest.mark.parametrize("number", SIGNALS)
def test_it_comes_where_it_is_let(number):
    done = []
    with hold_interrupts() as let_come:
        signal.raise_signal(number)
        done.append(1)
        with pytest.raises(KeyboardInterrupt):
            let_come()
        let_come()  # it comes once
    assert done == [1]


@pytest.mark.parametrize("error", [None, ValueError])
def test_at_the_end_it_comes_at_the_latest(error):
    done = []

    def block():
        with hold_interrupts():
            signal.raise_signal(signal.SIGINT)
            done.append(1)
            if error:
                raise error

    with pytest.raises(KeyboardInterrupt):
        block()
    assert done == [1]


def test_a_second_one_comes_at_once():
    with hold_interrupts():
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)


def test_while_a_kernel_is_compiled_it_comes_at_once():
    with hold_interrupts(), pytest.raises(KeyboardInterrupt), preparing():
        signal.raise_signal(signal.SIGINT)


def test_other_handlers_stay():
    came = []
    handler = lambda number, frame: came.append(number)  # noqa: E731
    signal.signal(signal.SIGINT, handler)
    with hold_interrupts() as let_come:
        assert signal.getsignal(signal.SIGINT) is handler
        signal.raise_signal(signal.SIGINT)
        let_come()
    assert came == [signal.SIGINT]
    signal.signal(signal.SIGINT, signal.default_int_handler)


def test_a_handler_that_is_put_back_in_the_block_is_replaced_again():
    """As the command line does once the kernels are compiled."""
    signal.signal(signal.SIGINT, handler := lambda number, frame: None)
    with hold_interrupts() as let_come:
        assert signal.getsignal(signal.SIGINT) is handler
        signal.signal(signal.SIGINT, signal.default_int_handler)
        let_come()
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            let_come()


def test_another_thread_leaves_it_to_the_main_one():
    def elsewhere():
        with hold_interrupts() as let_come:
            let_come()

    with hold_interrupts() as let_come:
        signal.raise_signal(signal.SIGINT)
        thread = threading.Thread(target=elsewhere)
        thread.start()
        thread.join()
        with pytest.raises(KeyboardInterrupt):
            let_come()


@pytest.mark.parametrize("check", [True, False])
def test_it_does_not_come_while_hdf5_writes(tmp_path, check):
    """HDF5 calls Python for each write, and crashes if that does not return."""
    path = tmp_path / "a.h5"

    def write():
        with CheckedFile(path) as raw, h5py.File(raw, "w") as file:
            for _ in range(2):
                signal.raise_signal(signal.SIGINT)
            file["x"] = np.arange(10.0)
            if check:
                raw.check()
            file["y"] = 1.0

    with pytest.raises(KeyboardInterrupt):
        write()
    with h5py.File(path) as file:
        assert set(file) == ({"x"} if check else {"x", "y"})
        assert list(file["x"]) == list(range(10))


@pytest.mark.parametrize("times", [1, 2])
def test_the_last_sample_of_an_interrupted_run_is_a_state_that_the_motion_was_in(run, monkeypatch, times):
    """One that came with the end of a leg once left the state of that end at the time of its beginning."""
    march, legs = EventScheme.march, []

    def interrupted(self, *arguments):
        progress = march(self, *arguments)
        legs.append(progress.front.t)
        if len(legs) == 4:
            for _ in range(times):  # the second one comes at once
                signal.raise_signal(signal.SIGINT)
        return progress

    whole = run("paper", "end_time=0.4")
    monkeypatch.setattr(EventScheme, "march", interrupted)
    with pytest.raises(Interrupted) as stopped:
        simulate(Scenario.builtin("paper", ["end_time=0.4"]))
    history = stopped.value.history
    last = float(history["time"][-1])
    assert last == pytest.approx(legs[3] if times == 1 else legs[2], abs=1e-9)
    assert last > 0.0
    for name in ("q", "qd", "gap", "axial_force"):
        expected = np.asarray(whole.at(last, side="right")[name])
        np.testing.assert_allclose(np.asarray(history[name])[-1], expected, rtol=1e-5, atol=1e-6)
    assert abs(history.summary["energy"]["unaccounted"]) < 1e-10


def test_the_exact_beam_books_whole_steps(monkeypatch):
    accept, steps = AbsoluteRun._accept, []

    def interrupted(self, step, length):
        steps.append(length)
        if len(steps) == 5:
            signal.raise_signal(signal.SIGINT)
        accept(self, step, length)

    monkeypatch.setattr(AbsoluteRun, "_accept", interrupted)
    words = [
        "discretization.method=absolute",
        "discretization.elements=4",
        "contact.normal=spring",
        "end_time=0.01",
    ]
    with pytest.raises(Interrupted) as stopped:
        simulate(Scenario.builtin("paper", words))
    summary = stopped.value.history.summary
    assert summary["steps"] == 5
    assert summary["end_time"] == pytest.approx(sum(steps))


@pytest.mark.parametrize("attribute", ["data", "scenario_toml"])
def test_what_is_made_late_is_not_lost_by_an_interrupt(monkeypatch, attribute):
    """Ctrl-C saves a history a second time."""
    history = simulate(Scenario.builtin("paper", ["end_time=0.01"]))

    def interrupted(*arguments):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("oblique_impact.history.history.dataset", interrupted)
        patch.setattr(Scenario, "to_toml", interrupted)
        with pytest.raises(KeyboardInterrupt):
            getattr(history, attribute)
    assert len(getattr(history, attribute)) > 0
