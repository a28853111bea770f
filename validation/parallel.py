"""The same function over many items, in parallel processes, with results in the order of the items."""

from __future__ import annotations

import itertools
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from multiprocessing import SimpleQueue, connection, get_context, parent_process, resource_tracker
from typing import TypeVar

from oblique_impact.kernels.compiling import announce, listen
from oblique_impact.progress import OnProgress, Progress

Item = TypeVar("Item")
Result = TypeVar("Result")

#: one process a core is enough: threads inside of one would only wait for each other
_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")

#: s; how often we hear of what is compiled
TICK = 0.1


def default_workers() -> int:
    """Return the number of cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def map_parallel(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    workers: int | None = None,
    on_done: Callable[[int, Result], None] | None = None,
) -> list[Result]:
    """Return ``[function(item) for item in items]``, computed in `workers` fresh processes.

    Parameters
    ----------
    function : callable
        A function of a module (it is sent by name); an exception of it is raised here.
    items : sequence
        Sent in this order: put the longest first.
    workers : int, optional
        Default: the number of cores.  With one, or one item, everything runs in this process.
    on_done : callable, optional
        Called with the index and the result of each item as it is finished.
    """
    count = min(workers or default_workers(), len(items))
    results: dict[int, Result] = {}

    def take(index: int, result: Result) -> None:
        results[index] = result
        if on_done:
            on_done(index, result)

    if count <= 1:
        for index, item in enumerate(items):
            take(index, function(item))
    else:
        context = get_context("spawn")
        compiled = context.SimpleQueue()
        with single_threaded(), ProcessPoolExecutor(count, context, _begin, (compiled,)) as pool:
            try:
                with deaf_to_interrupts():
                    submitted = [pool.submit(function, item) for item in items]
                futures = {future: index for index, future in enumerate(submitted)}
                _collect(futures, take, compiled)
            except BaseException:
                _kill(pool)
                raise
    return [results[index] for index in range(len(items))]


def _begin(compiled: SimpleQueue[str]) -> None:
    """Prepare a process: it leaves with its parent, and tells it what it compiles."""
    leave_with_parent()
    listen(compiled.put)


def _collect(
    futures: dict[Future[Result], int],
    take: Callable[[int, Result], None],
    compiled: SimpleQueue[str],
) -> None:
    pending = set(futures)
    while pending:
        done, pending = wait(pending, TICK, return_when=FIRST_COMPLETED)
        while not compiled.empty():
            announce(compiled.get())
        for future in sorted(done, key=futures.__getitem__):
            take(futures[future], future.result())


def _kill(pool: ProcessPoolExecutor) -> None:
    """End all processes at once: what they compute is of no use any more."""
    # after its shutdown a pool forgets its processes
    processes = list((getattr(pool, "_processes", None) or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    for process in processes:
        process.kill()


@contextmanager
def deaf_to_interrupts() -> Iterator[None]:
    """Let processes that are started inside of the block not hear interrupts: their parent decides.

    An interrupt that comes in the meantime is heard at the end.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # it would let them hear again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def leave_with_parent() -> None:
    """Have this process leave when its parent is gone, even in the middle of its work."""
    threading.Thread(target=_wait_for_parent, daemon=True).start()


def _wait_for_parent() -> None:
    parent = parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)


@contextmanager
def single_threaded() -> Iterator[None]:
    """Environment for processes that are started inside of the block: one thread each."""
    before = {name: os.environ.get(name) for name in _THREADS}
    os.environ.update(dict.fromkeys(_THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def told(on_progress: OnProgress, names: Sequence[str]) -> Callable[[int, object], None]:
    """Return an `on_done` for `map_parallel` over items of these names; it tells `on_progress`.

    That nothing is done yet is told at once.  Items may be finished in any order.
    """
    count = itertools.count(1)
    on_progress(Progress(0, len(names)))
    return lambda index, result: on_progress(Progress(next(count), len(names), names[index]))
