"""Listeners to what numba compiles: a first run takes half a minute for it, and a person should know why.

Nothing here needs numba, so that a command which compiles nothing does not wait for it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

_listeners: list[Callable[[str], None]] = []


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
