"""What kernels ask of a mechanical system is known wherever they are used."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

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
