"""What the machine has that this process may use."""

from __future__ import annotations

import os

#: variables by which libraries of linear algebra are told how many threads to use: one is enough for matrices as
#: small as here, more would only wait for each other
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def cores() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
