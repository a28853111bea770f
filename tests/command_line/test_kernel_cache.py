"""The cache of compiled kernels is optional: whatever is wrong with it costs compiling, never the run."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

#: numba keeps nothing of what has no module
KERNEL = """
from collections import namedtuple
from oblique_impact.kernels.jit import kernel

class Packed(namedtuple("Packed", "number")):
    __slots__ = ()

def cube(system):
    return system.number**3

compiled = kernel("the cube")(cube)
"""
PROGRAM = """
from oblique_impact.kernels.compiling import compilations
from cubes import Packed, compiled
told = []
with compilations(told.append):
    print(compiled(Packed(3.0)), len(told))
"""


@pytest.fixture
def use(tmp_path):
    """Call a kernel in a process of its own, with a cache: what it returns and how many kernels it compiled."""
    (tmp_path / "cubes.py").write_text(KERNEL)
    (tmp_path / "program.py").write_text(PROGRAM)

    def call(folder):
        environment = {name: value for name, value in os.environ.items() if name != "NUMBA_DISABLE_JIT"}
        words = [sys.executable, str(tmp_path / "program.py")]
        environment |= {"NUMBA_CACHE_DIR": str(folder)}
        return subprocess.run(words, capture_output=True, text=True, check=True, env=environment).stdout.split()

    return call


def test_a_damaged_cache_is_filled_anew(use, tmp_path):
    """An index without content, and half of the code."""
    cache = tmp_path / "cache"
    assert use(cache) == ["27.0", "1"]
    for ending, part in ((".nbi", 0.0), (".nbc", 0.5)):
        for file in cache.rglob(f"*{ending}"):
            content = file.read_bytes()
            file.write_bytes(content[: int(part * len(content))])
        assert use(cache) == ["27.0", "1"]
        assert use(cache) == ["27.0", "0"]


def test_a_cache_that_cannot_be_written_costs_compiling(use, tmp_path):
    (tmp_path / "file").write_text("in the way")
    assert use(tmp_path / "file") == ["27.0", "1"]
