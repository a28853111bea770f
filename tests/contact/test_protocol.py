"""What kernels ask of a mechanical system is known wherever they are used."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numba import njit

from oblique_impact.kernels.compiling import clock, preparing
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.reference import by_reference

_SOLVE = """
from oblique_impact import Scenario
from oblique_impact.marching.sampling import contact_problem
from oblique_impact.problem import beam_of, beam_problem
problem = beam_problem(beam_of(Scenario.builtin("paper")))
defined, _, contact = contact_problem(problem.system, 0.0, problem.q0, problem.qd0, problem.system.new_workspace())
assert defined and contact.a_nn > 0.0
"""


def test_a_kernel_compiles_without_the_calls_that_run_something(tmp_path):
    """From a problem alone, in a new process and with nothing compiled before."""
    root = Path(__file__).parents[2]
    paths = {"PYTHONPATH": str(root), "NUMBA_CACHE_DIR": str(tmp_path)}
    environment = {**os.environ, **paths, "NUMBA_OPT": "0"}  # what is compiled need not be fast
    ended = subprocess.run(
        [sys.executable, "-c", _SOLVE], env=environment, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr[-2000:]


def test_seconds_of_compiling_and_loading_are_not_counted():
    with clock() as whole:
        with preparing():
            time.sleep(0.2)
        assert whole.seconds < 0.2 <= whole.prepared


class _Pair(NamedTuple):
    numbers: np.ndarray
    size: int


class _Nested(NamedTuple):
    pair: _Pair
    factor: float


@jitable
def _scaled(nested, index):
    return nested.factor * nested.pair.numbers[index] * nested.pair.size


@njit
def _through_reference(nested, index):
    return _scaled(by_reference(by_reference(nested)), index)


def test_a_reference_reads_the_fields_of_its_tuple():
    """Nested ones too, of compiled source and interpreted."""
    nested = _Nested(_Pair(np.array([2.0, 3.0]), 5), 7.0)
    assert _through_reference(nested, 1) == _scaled(by_reference(nested), 1) == 105.0
    assert _through_reference(nested._replace(factor=1.0), 0) == 10.0
