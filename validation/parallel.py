"""The same function over many items: on processes of this machine, or on a Dask cluster.

Both are executors (`concurrent.futures.Executor`), and what happens around them is written once: some items more
than there are workers are handed out, what is finished is taken, and one whose process dies costs itself alone.
"""

from __future__ import annotations

import itertools
import logging
import os
import re
import signal
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing import SimpleQueue, connection, get_context, parent_process, resource_tracker
from multiprocessing.process import BaseProcess
from typing import Any, NamedTuple, TypeVar

from oblique_impact.errors import InputError
from oblique_impact.history.provenance import NUMERIC_PACKAGES, package_version, source_digest
from oblique_impact.kernels.compiling import announce, listen
from oblique_impact.machine import THREADS, collect_rarely, cores
from oblique_impact.progress import OnProgress, Progress

Item = TypeVar("Item")
Result = TypeVar("Result")

#: packages whose source decides about results
SOURCE = (*NUMERIC_PACKAGES, "oblique_impact.validation")
#: s; how often we hear of what is compiled, and see whether a cluster is still there
_TICK = 0.1
#: items handed out: for each process of this machine, and to a cluster
_AHEAD, _AHEAD_ON_CLUSTER = 3, 1000
_ADDRESS = re.compile(r"((tcp|tls|ws|wss|ucx)://)?([^\s:/\[\]]+|\[[0-9a-fA-F:]+\]):\d{1,5}")
#: s to wait for a scheduler, and for its first worker
_PATIENCE = 10.0


class Crash(NamedTuple):
    """Stands for the result of an item that took its process down twice."""

    reason: str


def compute_each(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    workers: int | None = None,
    scheduler: str | None = None,
    isolated: bool = False,
) -> Iterator[tuple[int, Result | Crash]]:
    """Yield the index and the result of each item as it is finished.

    Parameters
    ----------
    function : callable
        A function of a module (it is sent by name); an exception of it is raised here.
    items : sequence
        Sent in this order: put the longest first.
    workers : int, optional
        Processes of this machine; default: the cores.  With one everything runs in this process.
    scheduler : str, optional
        Address of a Dask scheduler, whose workers are used instead; these need this package and nothing else.
    isolated : bool
        A single item takes a process as well, unless `workers` is one.

    Raises
    ------
    InputError
        In one line if the cluster cannot be used, or is lost.
    """
    count = min(workers or cores(), len(items))
    if scheduler is not None:
        yield from _on_cluster(scheduler, function, items)
    elif workers == 1 or (count <= 1 and not isolated):
        yield from ((index, function(item)) for index, item in enumerate(items))
    else:
        yield from _on_processes(function, items, count)


def map_parallel(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    workers: int | None = None,
    on_done: Callable[[int, Result], None] | None = None,
) -> list[Result]:
    """Return ``[function(item) for item in items]``, computed as `compute_each` does.

    `on_done` is called with the index and the result of each item as it is finished.  Raises InputError if an item
    takes its process down.
    """
    results: dict[int, Result] = {}
    for index, result in compute_each(function, items, workers):
        if isinstance(result, Crash):
            raise InputError(f"{items[index]}: {result.reason}")
        results[index] = result
        if on_done:
            on_done(index, result)
    return [results[index] for index in range(len(items))]


def told(on_progress: OnProgress, names: Sequence[str]) -> Callable[[int, object], None]:
    """Return an `on_done` for `map_parallel` over items of these names; it tells `on_progress`.

    That nothing is done yet is told at once.  Items may be finished in any order.
    """
    count = itertools.count(1)
    on_progress(Progress(0, len(names)))
    return lambda index, result: on_progress(Progress(next(count), len(names), names[index]))


def _collect(
    submit: Callable[[int], Future[Any]],
    queue: deque[int],
    running: dict[Future[Any], int],
    ahead: int,
    on_tick: Callable[[], None],
) -> Iterator[tuple[int, Future[Any]]]:
    """Keep `ahead` items handed out until the queue is empty; yields those that are finished.

    One whose result cannot be taken stays in `running`.
    """
    while queue or running:
        with _deaf_to_interrupts():
            while queue and len(running) < ahead:
                future = submit(queue[0])
                running[future] = queue.popleft()
        done, _ = wait(running, _TICK, FIRST_COMPLETED)
        on_tick()
        for future in sorted(done, key=running.__getitem__):
            yield running[future], future
            del running[future]


# --- processes of this machine


def _on_processes(
    function: Callable[[Item], Result], items: Sequence[Item], workers: int
) -> Iterator[tuple[int, Result | Crash]]:
    left, suspects, deaths = deque(range(len(items))), deque[int](), Counter[int]()
    while left or suspects:
        # a pool breaks as a whole: what it was at is done again one by one, to find out which it was
        alone = bool(suspects)
        queue, count, ahead = (suspects, 1, 1) if alone else (left, workers, _AHEAD * workers)
        running: dict[Future[Result], int] = {}
        with _started(min(count, len(queue))) as processes:
            try:
                for index, future in _collect(
                    lambda index: processes.pool.submit(function, items[index]),
                    queue,
                    running,
                    ahead,
                    processes.hear,
                ):
                    yield index, future.result()
            except BrokenProcessPool:
                reason, lost = processes.end(), sorted(running.values())
                deaths.update(lost if alone else ())
                if alone and deaths[lost[0]] >= 2:
                    yield lost[0], Crash(f"its process ended, twice: {reason}")
                else:
                    suspects.extend(lost)


class _Processes:
    """A pool of fresh processes, and what they tell."""

    def __init__(self, count: int) -> None:
        context = get_context("spawn")
        if hasattr(signal, "pthread_sigmask"):  # it lets processes hear interrupts that should be deaf to them
            resource_tracker.ensure_running()
        self._told = context.SimpleQueue()
        self._ready = False
        self._members: list[Any] = []
        self.pool = ProcessPoolExecutor(count, context, _begin, (self._told,))

    def hear(self) -> None:
        """Announce the kernels that are compiled."""
        # a pool forgets its processes when it ends
        self._members = self._members or list((getattr(self.pool, "_processes", None) or {}).values())
        while not self._told.empty():
            name = self._told.get()
            self._ready = True
            if name:
                announce(name)

    def end(self) -> str:
        """Say how the first process ended; raises InputError if none could work."""
        self.hear()
        reason = "for an unknown reason"
        for process in self._members[:1]:
            process.join()
            code = _exit_code(process)
            if code is not None:
                with suppress(ValueError):
                    reason = f"killed by {signal.Signals(-code).name}" if code < 0 else f"exit code {code}"
        if not self._ready:
            raise InputError(
                f"--workers: a process ended before it could work: {reason}; a script that starts processes needs "
                'if __name__ == "__main__": around its calls, or workers=1'
            )
        return reason

    def kill(self) -> None:
        """End all processes at once."""
        self.hear()
        self.pool.shutdown(wait=False, cancel_futures=True)
        for process in self._members:
            process.kill()


def _exit_code(process: BaseProcess) -> int | None:
    """Exit code of a process that has ended; the pool's own thread may just be taking it, and passes it on."""
    for _ in range(100):
        if process.exitcode is not None:
            break
        time.sleep(_TICK / 10.0)
    return process.exitcode


@contextmanager
def _started(count: int) -> Iterator[_Processes]:
    """Start processes with one thread each; an exception ends them at once."""
    processes = _Processes(count)
    with _single_threaded(), processes.pool:
        try:
            yield processes
        except BaseException:
            processes.kill()
            raise


def _begin(compiled: SimpleQueue[str]) -> None:
    """Prepare a process: it leaves with its parent, even in the middle of its work, and tells what it compiles."""
    collect_rarely()
    threading.Thread(target=_wait_for_parent, daemon=True).start()
    compiled.put("")  # ready
    listen(compiled.put)


def _wait_for_parent() -> None:
    parent = parent_process()
    if parent is not None:
        connection.wait([parent.sentinel])
        os._exit(1)


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Let processes that are started inside of the block not hear interrupts: their parent decides.

    An interrupt that comes in the meantime is heard at the end.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # a terminal sends Ctrl-C and its own end to all of them, but not SIGTERM
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _single_threaded() -> Iterator[None]:
    """Environment for processes that are started inside of the block: one thread each."""
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def check_limits(scheduler: str | None, workers: int | None, timeout: float | None) -> None:
    """Raise InputError, in one line, for what is no address of a scheduler, no time, or too much of both."""
    if scheduler is not None and workers is not None:
        raise InputError(f"--workers {workers} together with --scheduler: a cluster has its own workers; give one")
    if scheduler is not None and not _ADDRESS.fullmatch(scheduler):
        raise InputError(
            f"--scheduler {scheduler}: should be the address of a Dask scheduler, like tcp://host:8786"
        )
    if timeout is not None and not timeout > 0.0:
        raise InputError(f"--timeout {timeout}: should be a time in s, greater than 0")


# --- a cluster


def running_source() -> str:
    """Version and digest of what computes the results, where it runs; asked of the workers of a cluster."""
    return f"{package_version()} (source {source_digest(SOURCE)})"


def _on_cluster(
    address: str, function: Callable[[Item], Result], items: Sequence[Item]
) -> Iterator[tuple[int, Result | Crash]]:
    with _client(address) as client:
        from distributed import KilledWorker

        executor: Executor = client.get_executor(pure=False)
        lost = _fault(address, "the connection is lost; what is done is kept: the same command goes on")

        def check() -> None:
            if client.status != "running":
                raise lost

        try:
            for index, future in _collect(
                lambda index: executor.submit(function, items[index]),
                deque(range(len(items))),
                {},
                _AHEAD_ON_CLUSTER,
                check,
            ):
                try:
                    yield index, future.result()
                except KilledWorker:
                    yield index, Crash("its workers died, again and again")
                except (ImportError, AttributeError) as error:
                    raise _fault(address, f"a worker cannot run: {type(error).__name__}: {error}") from None
        except (OSError, TimeoutError, CancelledError):
            raise lost from None
        finally:
            with suppress(Exception):
                executor.shutdown(wait=False)


@contextmanager
def _client(address: str) -> Iterator[Any]:
    """Yield a connection to a scheduler with workers that have this package in this version."""
    try:
        from distributed import Client
    except ImportError:
        raise InputError(
            f"--scheduler {address}: needs Dask, which is not installed: pip install 'oblique-impact[cluster]'"
        ) from None
    for name in list(logging.root.manager.loggerDict):  # it is left to us to say what is wrong
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        client = Client(address, timeout=_PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise _fault(address, f"cannot be reached: {error}") from None
    try:
        _check_workers(address, client)
        yield client
    finally:
        with suppress(Exception):
            client.close(timeout=0.3)


def _check_workers(address: str, client: Any) -> None:
    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
        found = client.run(running_source, on_error="return")
    except TimeoutError:
        raise _fault(address, f"has had no workers for {_PATIENCE:g} s; start some: dask worker ADDRESS") from None
    except Exception as error:
        raise _fault(address, f"its workers cannot be asked: {error}") from None
    ours = running_source()
    for worker, theirs in found.items():
        if theirs != ours:
            broken = isinstance(theirs, Exception)
            words = f"{type(theirs).__name__}: {theirs}" if broken else f"it has {theirs}"
            raise _fault(address, f"worker {worker} needs oblique-impact {ours}; {words}")


def _fault(address: str, what: str) -> InputError:
    return InputError(f"--scheduler {address}: {' '.join(what.split())[:300]}")
