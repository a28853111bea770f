"""Shared by all tests: the last few runs of built-in scenarios."""

from __future__ import annotations

import signal

import pytest

from validation.runs import run as simulated

# a shell lets what it starts in the background ignore interrupts; the tests of interrupts send them
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def run():
    """Simulate a built-in scenario (default: the paper's) with overrides; the last few are remembered."""
    return lambda name="paper", *overrides: simulated(name, *overrides)
