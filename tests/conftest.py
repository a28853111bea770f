"""Shared by all tests: one run per scenario and session."""

from __future__ import annotations

import signal
from functools import cache

import pytest

from oblique_impact import History, Scenario, simulate

# a shell lets what it starts in the background ignore interrupts; the tests of interrupts send them
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@cache
def _run(name: str, overrides: tuple[str, ...]) -> History:
    return simulate(Scenario.builtin(name, list(overrides)))


@pytest.fixture(scope="session")
def run():
    """Simulate a built-in scenario with overrides; the same case is computed once."""

    def call(name: str = "paper", *overrides: str) -> History:
        return _run(name, overrides)

    return call
