"""What the machine has that this process may use."""

from __future__ import annotations

import gc
import os

#: variables by which libraries of linear algebra are told how many threads to use: one is enough for matrices as
#: small as here, more would only wait for each other
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


def cores() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def collect_rarely() -> None:
    """Look for garbage in cycles a thousand times as rarely, for the process of a command or of a sweep.

    Libraries, kernels and figures make little of it, and to look took a tenth of the time.
    """
    gc.freeze()
    gc.set_threshold(1_000_000)
