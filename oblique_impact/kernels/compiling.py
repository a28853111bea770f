"""Notices of the kernels that numba compiles, which takes a first run half a minute, and a clock without that.

Nothing here imports numba, so that a command which compiles nothing does not wait for it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

_listeners: list[Callable[[str], None]] = []


class Stopwatch:
    """Measures the time since its start without that in which kernels are compiled or loaded.

    Parameters
    ----------
    compiling : numba.core.event.TimingListener
        Measures the latter.
    """

    def __init__(self, compiling: Any) -> None:
        self._started, self._compiling = time.perf_counter(), compiling

    @property
    def seconds(self) -> float:
        """Time since the start (s) without compiling."""
        compiling = self._compiling.duration if self._compiling.done else 0.0
        return float(time.perf_counter() - self._started - compiling)


@contextmanager
def clock() -> Iterator[Stopwatch]:
    """Measure the time of the block without that in which kernels are compiled or loaded."""
    from numba.core import event

    with event.install_listener("numba:compiler_lock", event.TimingListener()) as compiling:
        yield Stopwatch(compiling)


@contextmanager
def compilations(tell: Callable[[str], None]) -> Iterator[None]:
    """Call `tell` with the name of each kernel that is compiled while the block runs, when that begins.

    Kernels that come from the cache on disk are not reported.  Processes hear of their own only; those that
    `validation` starts hand on what they hear to the one that started them.
    """
    _listeners.append(tell)
    try:
        yield
    finally:
        _listeners.remove(tell)


def announce(name: str) -> None:
    """Announce that the kernel of this name is being compiled."""
    for tell in tuple(_listeners):
        tell(name)
