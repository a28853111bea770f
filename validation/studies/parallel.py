"""One function over many items: on processes of this machine through joblib, or on a Dask cluster."""

from __future__ import annotations

import logging
import re
import signal
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError
from typing import Any, NamedTuple, TypeVar

from joblib import Parallel, delayed, parallel_config

from oblique_impact.errors import InputError
from oblique_impact.history.provenance import NUMERIC_PACKAGES, package_version, source_digest
from oblique_impact.machine import collect_rarely, cores
from oblique_impact.progress import OnProgress, Progress, silent

Item = TypeVar("Item")
Result = TypeVar("Result")

#: packages whose source decides about results
SOURCE = (*NUMERIC_PACKAGES, "oblique_impact.validation")
#: items handed out for each process
_AHEAD = 2
_ADDRESS = re.compile(r"((tcp|tls|ws|wss|ucx)://)?([^\s:/\[\]]+|\[[0-9a-fA-F:]+\]):\d{1,5}")
#: s to wait for a scheduler, and for its first worker
_PATIENCE = 10.0


class Crash(NamedTuple):
    """Stands for the result of an item that took its process down."""

    reason: str


def compute_each(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    workers: int | None = None,
    scheduler: str | None = None,
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
        Address of a Dask scheduler, whose workers are used instead.

    Raises
    ------
    InputError
        In one line if the cluster cannot be used, or is lost.
    """
    if scheduler is not None:
        yield from _on_cluster(scheduler, function, items)
        return
    left = dict(enumerate(items))
    count = max(1, min(workers or cores(), len(left)))
    ahead = _AHEAD * count

    def run(some: Mapping[int, Item]) -> Iterator[tuple[int, Result]]:
        parallel = Parallel(batch_size=1, pre_dispatch=ahead, return_as="generator_unordered", max_nbytes=None)
        found: Iterator[tuple[int, Result]] = parallel(
            delayed(_numbered)(function, *item) for item in some.items()
        )
        return found

    # one thread each; a Ctrl-C in a terminal reaches every process, and it is for this one to decide
    with parallel_config("loky", n_jobs=count, inner_max_num_threads=1, initializer=_begin):
        while left:
            try:
                for index, result in run(dict(left)):
                    del left[index]
                    yield index, result
            except BrokenExecutor:
                # joblib does not say whose process died: what it may have handed out runs again, one by one
                for index in list(left)[: 2 * ahead]:
                    try:
                        yield from run({index: left.pop(index)})
                    except BrokenExecutor as error:
                        codes = re.search(r"\{(.+)\}", str(error))
                        yield index, Crash(f"its process ended: {codes[1] if codes else 'killed'}")


def map_parallel(
    function: Callable[[Item], Result],
    items: Sequence[Item],
    workers: int | None = None,
    on_progress: OnProgress = silent,
    names: Sequence[str] = (),
) -> list[Result]:
    """Return ``[function(item) for item in items]``; `names` of the items are for those who watch.

    Raises InputError if an item takes its process down.
    """
    names, results = names or [str(item) for item in items], dict[int, Result]()
    on_progress(Progress(0, len(items)))
    with warnings.catch_warnings():
        # workers that hold much memory after a long run are replaced by joblib, which says so
        warnings.filterwarnings("ignore", "A worker stopped while some jobs were given")
        for index, result in compute_each(function, items, workers):
            if isinstance(result, Crash):
                raise InputError(f"{names[index]}: {result.reason}")
            results[index] = result
            on_progress(Progress(len(results), len(items), names[index]))
    return [results[index] for index in range(len(items))]


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


def running_source() -> str:
    """Return version and digest of what computes the results, where it runs."""
    return f"{package_version()} (source {source_digest(SOURCE)})"


def _numbered(function: Callable[[Item], Result], index: int, item: Item) -> tuple[int, Result]:
    return index, function(item)


def _begin() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    collect_rarely()


def _on_cluster(
    address: str, function: Callable[[Item], Result], items: Sequence[Item]
) -> Iterator[tuple[int, Result | Crash]]:
    """Run items through Dask itself: joblib 1.6's backend waits for ever for an item whose worker was killed."""
    try:
        from distributed import Client, KilledWorker, as_completed
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
        places = {client.submit(function, item, pure=False): n for n, item in enumerate(items)}
        for future in as_completed(places, loop=client.loop):
            if isinstance(future.exception(), KilledWorker):
                yield places[future], Crash("its workers died, again and again")
            else:
                yield places[future], future.result()
    except (OSError, TimeoutError, CancelledError):
        lost = "the connection is lost; what is done is kept: the same command goes on"
        raise _fault(address, lost) from None
    finally:
        client.close(timeout=1.0)


def _check_workers(address: str, client: Any) -> None:
    """Raise InputError unless there are workers, all of which have this source."""
    ours = running_source()
    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
        found = client.run(running_source)
    except (OSError, TimeoutError, ImportError, AttributeError) as error:
        raise _fault(address, f"its workers cannot be used: {type(error).__name__}: {error}") from None
    for worker, theirs in found.items():
        if theirs != ours:
            raise _fault(address, f"worker {worker} needs oblique-impact {ours}; it has {theirs}")


def _fault(address: str, what: str) -> InputError:
    return InputError(f"--scheduler {address}: {' '.join(what.split())[:300]}")
