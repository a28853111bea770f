"""Runs on a Dask cluster.  Its workers need this package and nothing else: no folder, no file of the sweep."""

from __future__ import annotations

import logging
import math
import re
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from typing import Any

from oblique_impact.errors import InputError
from validation.sweeps.design import Design
from validation.sweeps.pool import TICK, TakeRows
from validation.sweeps.work import CRASHED, Done, Job, failed, run_many, running_source

#: s of work in one task: much more than a task costs (some ms), little enough to lose
CHUNK = 1.0
_MOST = 256
_ADDRESS = re.compile(r"((tcp|tls|ws|wss|ucx)://)?([^\s:/\[\]]+|\[[0-9a-fA-F:]+\]):\d{1,5}")
#: s to wait for the scheduler, and for its first worker
_PATIENCE = 10.0


def check_address(address: str) -> None:
    """Raise InputError, in one line, for what is no address of a scheduler."""
    if not _ADDRESS.fullmatch(address):
        raise InputError(f"--scheduler {address}: should be the address of a Dask scheduler, like tcp://host:8786")


class Cluster:
    """The workers of a Dask scheduler.

    Parameters
    ----------
    address : str
        Of the scheduler, like tcp://host:8786.
    job : Job
        What the runs have in common.
    design : Design
        Their values.

    Raises
    ------
    InputError
        In one line if Dask is not installed, the scheduler does not answer, has no workers, or these do not have
        this package in this version.
    """

    def __init__(self, address: str, job: Job, design: Design) -> None:
        self._address, self._job, self._design = address, job, design
        try:
            from distributed import Client
        except ImportError:
            raise InputError(
                f"--scheduler {address}: needs Dask, which is not installed: pip install 'oblique-impact[cluster]'"
            ) from None
        _be_quiet()
        try:
            self._client: Any = Client(address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise self._fault(f"cannot be reached: {error}") from None
        try:
            self._check_workers()
        except BaseException:
            self.close()
            raise

    def run(self, numbers: Iterable[int], take: TakeRows, scratch: str | None = None) -> None:
        """Do the runs; `take` gets what is finished, and nothing several times a second if nothing is."""
        chunks = _Chunks(list(numbers))
        pending: dict[Any, list[int]] = {}
        try:
            with self._client.as_current():
                while chunks.left or pending:
                    with self._talking():
                        wanted = 2 * max(sum(self._client.nthreads().values()), 1)
                        while chunks.left and len(pending) < wanted:
                            self._submit(chunks.next(wanted), pending)
                        finished = self._collect(pending, chunks)
                    take(finished)
        finally:
            with suppress(Exception):
                self._client.cancel(list(pending))

    def close(self) -> None:
        """Leave the cluster as it is."""
        with suppress(Exception):
            self._client.close(timeout=0.3)

    def _check_workers(self) -> None:
        try:
            self._client.wait_for_workers(1, timeout=_PATIENCE)
        except TimeoutError:
            raise self._fault(f"has had no workers for {_PATIENCE:g} s; start some: dask worker ADDRESS") from None
        ours = running_source()
        try:
            found = self._client.run(running_source, on_error="return")
        except Exception as error:
            raise self._fault(f"its workers cannot be asked: {error}") from None
        for worker, theirs in found.items():
            if theirs != ours:
                broken = isinstance(theirs, Exception)
                words = f"{type(theirs).__name__}: {theirs}" if broken else f"it has {theirs}"
                raise self._fault(f"worker {worker} needs oblique-impact {ours}; {words}")

    def _submit(self, runs: list[int], pending: dict[Any, list[int]]) -> None:
        work = [(run, self._design.values(run)) for run in runs]
        pending[self._client.submit(run_many, self._job, work, pure=False)] = runs

    def _collect(self, pending: dict[Any, list[int]], chunks: _Chunks) -> list[Done]:
        from distributed import wait

        with suppress(TimeoutError):
            wait(list(pending), timeout=TICK, return_when="FIRST_COMPLETED")
        finished: list[Done] = []
        for future in [f for f in pending if f.done()]:
            runs = pending.pop(future)
            if future.status == "finished":
                found: list[Done] = future.result()
                chunks.learn(found)
                finished += found
            elif future.status == "error":
                finished += self._failed(future.exception(), runs, chunks)
            else:
                raise self._lost()
        if self._client.status != "running":
            raise self._lost()
        return finished

    def _failed(self, error: BaseException, runs: list[int], chunks: _Chunks) -> list[Done]:
        """Divide the runs of a task whose workers died; a single run has had its chances with the scheduler."""
        from distributed import KilledWorker

        if not isinstance(error, KilledWorker):
            raise self._fault(f"a worker cannot run: {type(error).__name__}: {error}")
        if len(runs) > 1:
            chunks.alone.extend(runs)
            return []
        return [Done(failed(runs[0], CRASHED, "its workers died, again and again"))]

    @contextmanager
    def _talking(self) -> Iterator[None]:
        """Say in one line that the scheduler is gone, whatever the client says to that."""
        try:
            yield
        except (OSError, TimeoutError, CancelledError):
            raise self._lost() from None
        except (RuntimeError, AttributeError):
            # the client falls apart in several ways when its connection ends in the middle of a call
            if self._client.status == "running":
                raise
            raise self._lost() from None

    def _lost(self) -> InputError:
        return self._fault("the connection is lost; what is done is kept: sweep again to go on")

    def _fault(self, what: str) -> InputError:
        return InputError(f"--scheduler {self._address}: {' '.join(what.split())[:300]}")


def _be_quiet() -> None:
    """Leave it to us to say what is wrong: Dask gives each of its loggers a level of its own."""
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(logging.CRITICAL)


class _Chunks:
    """Runs in tasks of about `CHUNK` seconds."""

    def __init__(self, runs: list[int]) -> None:
        self._runs = deque(runs)
        self.alone: deque[int] = deque()  # suspects
        self._seconds = math.inf

    @property
    def left(self) -> int:
        return len(self._runs) + len(self.alone)

    def learn(self, finished: list[Done]) -> None:
        """Follow the time that a run takes."""
        mean = sum(done.row["wall_time"] for done in finished) / len(finished)
        self._seconds = mean if math.isinf(self._seconds) else 0.5 * (self._seconds + mean)

    def next(self, at_once: int) -> list[int]:
        """Return the next task; at the end the tasks grow small, so that all workers finish together."""
        if self.alone:
            return [self.alone.popleft()]
        fair = -(-len(self._runs) // at_once)
        count = min(max(1, int(CHUNK / max(self._seconds, 1e-6))), _MOST, fair)
        return [self._runs.popleft() for _ in range(count)]
