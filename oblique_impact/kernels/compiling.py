"""Listeners to what numba compiles: a first run takes half a minute for it, and a person should know why.

Nothing here needs numba, so that a command which compiles nothing does not wait for it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_listeners: list[Callable[[str], None]] = []
_clocks: list[Clock] = []


class Clock:
    """Measures a span of time without the preparation of kernels in it."""

    def __init__(self) -> None:
        self._started, self.prepared = time.perf_counter(), 0.0  # s

    @property
    def seconds(self) -> float:
        """Time since the start (s) without that of preparation."""
        return time.perf_counter() - self._started - self.prepared


@contextmanager
def clock() -> Iterator[Clock]:
    """Measure the time of the block without that in which kernels are compiled or loaded."""
    _clocks.append(new := Clock())
    try:
        yield new
    finally:
        _clocks.remove(new)


@contextmanager
def preparing() -> Iterator[None]:
    """Say that the block compiles or loads a kernel."""
    started = time.perf_counter()
    try:
        yield
    finally:
        for one in _clocks:
            one.prepared += time.perf_counter() - started


@contextmanager
def compilations(tell: Callable[[str], None]) -> Iterator[None]:
    """Call `tell` with the name of each kernel that is compiled while the block runs, when that begins.

    Kernels that come from the cache on disk are not told.  Processes hear of their own only; those that
    `validation` starts hand on what they hear to the one that started them.
    """
    listen(tell)
    try:
        yield
    finally:
        _listeners.remove(tell)


def listen(tell: Callable[[str], None]) -> None:
    """Call `tell` as :func:`compilations` does, as long as this process lives."""
    _listeners.append(tell)


def announce(name: str) -> None:
    """Say that the kernel of this name is being compiled."""
    for tell in tuple(_listeners):
        tell(name)
