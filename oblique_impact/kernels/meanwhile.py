"""A process beside this one compiles a kernel while this one compiles another: half the wait of a first run.

It reads from its standard input which kernel it is, and for arguments of which types; what it makes is found in
the cache on disk.  Whether it succeeds does not matter: a process that finds nothing there compiles the kernel
itself.
"""

from __future__ import annotations

import atexit
import multiprocessing
import os
import pickle
import subprocess
import sys
from importlib import import_module
from typing import Any

from oblique_impact.machine import cores


def has_room() -> bool:
    """Whether there is a core for another process, and this one is not one of several that share them already."""
    return cores() > 1 and multiprocessing.parent_process() is None


class Meanwhile:
    """A process that compiles the kernel `name` of `module` for arguments of the types `kinds`."""

    def __init__(self, module: str, name: str, kinds: tuple[Any, ...]) -> None:
        wanted = pickle.dumps((module, name, kinds))
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )
        atexit.register(self._process.kill)
        assert self._process.stdin is not None
        self._process.stdin.write(wanted)
        self._process.stdin.close()

    def wait(self) -> None:
        """Return when it has ended, whatever it has reached; an interrupt ends it."""
        try:
            self._process.wait()
        finally:
            self._process.kill()
            self._process.wait()
            atexit.unregister(self._process.kill)


if __name__ == "__main__":
    module, name, kinds = pickle.load(sys.stdin.buffer)  # noqa: S301  from the process that started this one
    getattr(import_module(module), name).compile(kinds)
