"""Shared by all tests: the last few runs of built-in scenarios."""

from __future__ import annotations

import os
import signal

import pytest

# before anything imports NumPy: for the small matrices here more threads than one only wait for each other, which
# took up to ten times the time where several test processes share the cores
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# a shell lets what it starts in the background ignore interrupts; the tests of interrupts send them
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def run():
    """Simulate a built-in scenario (default: the paper's) with overrides; the last few are remembered."""
    from validation.runs import run as simulated

    return lambda name="paper", *overrides: simulated(name, *overrides)
