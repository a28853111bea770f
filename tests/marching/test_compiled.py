"""Kernels: compiled in the plain way where names of numba are missing; laws that cannot be compiled."""

from __future__ import annotations

import time
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest

from oblique_impact.kernels.compiling import clock
from oblique_impact.kernels.reference import Reference
from tests.processes import python

_NAMES = """
import logging, sys
logging.basicConfig(level=logging.INFO)
import numba.core.codegen
if sys.argv[1] == "plain":
    del numba.core.codegen.JITCodeLibrary
"""
#: named tuples in each other, a method of theirs, and a helper that both call
_SMALL = """
from typing import Any, NamedTuple, Protocol
import numpy as np
from oblique_impact.kernels.jit import by_reference, compiled_protocol, jitable, kernel

@compiled_protocol
class Weighed(Protocol):
    def weigh(self, factor: float) -> float: ...

class Masses(NamedTuple):
    values: Any

@jitable
def total(masses, factor):
    found = 0.0
    for value in masses.values:
        found += factor * value
    return found

@jitable
def weigh(body, factor):
    return total(body.masses, factor)

class _Body(NamedTuple):
    masses: Masses

class Body(_Body):
    __slots__ = ()
    weigh = weigh

@kernel("the weight")
def weight(system, gravity):
    body = by_reference(system)
    return body.weigh(gravity) + total(body.masses, 1.0)

print(weight(Body(Masses(np.array([0.1, 0.2, 0.3]))), 9.8))
"""


def solved(folder):
    """Compile and call a kernel in a new process; returns what it prints and what it logs."""
    # it need not be fast
    ended = python(_NAMES + _SMALL, folder.name, NUMBA_CACHE_DIR=str(folder), NUMBA_OPT="0")
    return [float(word) for word in ended.stdout.split()], ended.stderr


def test_where_names_of_numba_are_missing_the_plain_way_takes_over(tmp_path):
    usual, log = solved(tmp_path / "usual")
    assert "plain way" not in log
    plain, log = solved(tmp_path / "plain")
    assert log.count("plain way") == 1
    assert plain == pytest.approx(usual, rel=1e-12)


class Pair(NamedTuple):
    first: Any
    second: Any = 1.0


def test_references_have_the_same_name_for_one_layout_alone():
    """Functions that a cached kernel and a new one call have it in their names: another layout is other code."""
    whole, real, table = np.zeros(2, np.int64), np.zeros(2), np.zeros((2, 2))
    names = [Reference(numba.typeof(Pair(values))).name for values in (whole, real, table, real.copy())]
    assert len(set(names)) == 3
    assert names[1] == names[3]


def test_seconds_of_compiling_are_not_counted():
    started = time.perf_counter()
    with clock() as marching:
        numba.njit(lambda x: x**0.5 + 1.0)(2.0)
        seconds, whole = marching.seconds, time.perf_counter() - started
    assert 0.0 <= seconds < 0.5 * whole
