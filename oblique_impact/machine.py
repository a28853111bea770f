"""Cores, threads and garbage collection of this process."""

from __future__ import annotations

import gc
import os

#: environment variables that set the threads of linear algebra: one is fastest for matrices as small as here
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def cores() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def collect_rarely() -> None:
    """Collect cyclic garbage a thousand times less often, in the process of a command or of a study.

    There is little of it, and the search took a tenth of the time.
    """
    gc.freeze()
    gc.set_threshold(1_000_000)
