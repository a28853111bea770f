"""Interrupts between calls of compiled code: neither lost nor in the midst of one."""

from __future__ import annotations

import signal
import threading

import pytest

from oblique_impact.kernels.interrupts import call, interrupts_between_calls


def compiled(done, number=signal.SIGINT):
    """Stand for compiled code that calls Python, and is interrupted there."""
    signal.raise_signal(number)
    done.append(number)
    return 7


@pytest.fixture(autouse=True)
def usual_handlers():
    before = [signal.signal(number, signal.default_int_handler) for number in (signal.SIGINT, signal.SIGTERM)]
    yield
    for number, handler in zip((signal.SIGINT, signal.SIGTERM), before, strict=True):
        assert signal.getsignal(number) is signal.default_int_handler
        signal.signal(number, handler)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_comes_when_the_call_is_done(number):
    done = []
    with pytest.raises(KeyboardInterrupt), interrupts_between_calls():
        call(compiled, (done, number))
    assert done == [number]
    with interrupts_between_calls():
        assert call(len, ([1, 2],)) == 2  # it comes once


def test_between_two_calls_it_comes_at_once():
    done = []
    with pytest.raises(KeyboardInterrupt), interrupts_between_calls():
        compiled(done)
    assert done == []


def test_other_handlers_stay(monkeypatch):
    came = []
    handler = lambda number, frame: came.append(number)  # noqa: E731
    signal.signal(signal.SIGINT, handler)
    with interrupts_between_calls():
        assert signal.getsignal(signal.SIGINT) is handler
        assert call(compiled, ([],)) == 7
    assert came == [signal.SIGINT]
    signal.signal(signal.SIGINT, signal.default_int_handler)


def test_a_handler_that_is_put_back_in_the_block_is_held_again():
    """As the command line does once the kernels are compiled."""
    signal.signal(signal.SIGINT, handler := lambda number, frame: None)
    done = []
    with interrupts_between_calls() as hold:
        assert signal.getsignal(signal.SIGINT) is handler
        signal.signal(signal.SIGINT, signal.default_int_handler)
        hold()
        with pytest.raises(KeyboardInterrupt):
            call(compiled, (done,))
    assert done == [signal.SIGINT]


def test_another_thread_leaves_it_to_the_main_one():
    """The main thread is in a call while another one ends its own."""
    results = []

    def elsewhere():
        results.append(call(len, ([1, 2, 3],)))

    def with_a_thread_within():
        signal.raise_signal(signal.SIGINT)
        thread = threading.Thread(target=elsewhere)
        thread.start()
        thread.join()

    with pytest.raises(KeyboardInterrupt), interrupts_between_calls():
        call(with_a_thread_within, ())
    assert results == [3]
