"""Runs on processes of this machine: kept alive, replaced if they die, gone when this process goes."""

from __future__ import annotations

import multiprocessing
import signal
from collections import Counter, deque
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from oblique_impact.errors import InputError
from oblique_impact.kernels.compiling import announce, listen
from validation.parallel import deaf_to_interrupts, leave_with_parent, single_threaded
from validation.sweeps.design import Design
from validation.sweeps.work import CRASHED, Done, Job, failed

#: s; so much work is handed out in advance, so that no process waits for the next number
AHEAD = 0.15
_MOST_AHEAD = 64
#: s; how often the caller hears from us at the latest
TICK = 0.1
#: a run that takes its process down twice is not tried again
_ATTEMPTS = 2

TakeRows = Callable[[Sequence[Done]], None]


class LocalPool:
    """Processes that run rows of a design.

    Parameters
    ----------
    job : Job
        What the runs have in common.
    design : Design
        Their values.
    workers : int
        Number of processes.

    Notes
    -----
    Each process has a pipe of its own: a process that dies takes nothing with it but the run it was at, and one
    whose parent dies sees the end of its pipe and leaves.
    """

    def __init__(self, job: Job, design: Design, workers: int) -> None:
        self._job, self._design = job, design
        self._scratch: str | None = None
        self._deaths: Counter[int] = Counter()
        self._seconds = _Mean()
        self._crew: list[_Worker] = []
        try:
            for _ in range(workers):
                self._hire()
        except BaseException:
            self.close()
            raise

    def run(self, numbers: Iterable[int], take: TakeRows, scratch: str | None = None) -> None:
        """Do the runs; `take` gets what is finished, and nothing several times a second if nothing is.

        `scratch` is a folder for temporary files.
        """
        todo = deque(numbers)
        self._scratch = scratch
        while todo or any(worker.assigned for worker in self._crew):
            for worker in self._crew:
                self._assign(worker, todo)
            ready = wait([worker.pipe for worker in self._crew], TICK)
            finished: list[Done] = []
            for worker in [w for w in self._crew if w.pipe in ready]:
                finished += self._hear(worker, todo)
            take(finished)

    def close(self) -> None:
        """End all processes at once; they hold nothing that is not handed over."""
        for worker in self._crew:
            worker.process.kill()
        for worker in self._crew:
            worker.process.join()
            worker.pipe.close()
        self._crew.clear()

    def _hire(self) -> None:
        ours, theirs = multiprocessing.Pipe()
        context = multiprocessing.get_context("spawn")
        with single_threaded(), deaf_to_interrupts():
            process = context.Process(target=_serve, args=(theirs, self._job, self._design), daemon=True)
            process.start()
        theirs.close()  # the only end that is left open is the process's: its death is the end of the pipe
        self._crew.append(_Worker(process, ours))

    def _assign(self, worker: _Worker, todo: deque[int]) -> None:
        if not worker.ready:
            return
        wanted = 1 if self._seconds.unknown else 1 + int(min(AHEAD / self._seconds.value, _MOST_AHEAD))
        with suppress(BrokenPipeError):  # its death is heard of next
            while todo and len(worker.assigned) < wanted:
                worker.assigned.append(todo.popleft())
                worker.pipe.send((worker.assigned[-1], self._scratch))

    def _hear(self, worker: _Worker, todo: deque[int]) -> list[Done]:
        finished = []
        try:
            while worker.pipe.poll():
                done = worker.pipe.recv()
                if done is None:
                    worker.ready = True
                    continue
                if isinstance(done, str):  # what it compiles
                    announce(done)
                    continue
                worker.assigned.remove(done.row["run"])
                self._seconds.add(done.row["wall_time"])
                finished.append(done)
        except (EOFError, OSError):
            finished += self._bury(worker, todo)
        return finished

    def _bury(self, worker: _Worker, todo: deque[int]) -> list[Done]:
        """Replace a process that died; the run it was at gets another chance."""
        worker.process.join()
        self._crew.remove(worker)
        worker.pipe.close()
        reason = _reason(worker.process.exitcode)
        if not worker.ready:
            raise InputError(f"--workers {len(self._crew) + 1}: a process ended before it could work: {reason}")
        lost: list[Done] = []
        if worker.assigned:
            culprit = worker.assigned[0]
            self._deaths[culprit] += 1
            if self._deaths[culprit] >= _ATTEMPTS:
                worker.assigned.popleft()
                message = f"its process ended, {_ATTEMPTS} times: {reason}"
                lost.append(Done(failed(culprit, CRASHED, message)))
            todo.extendleft(reversed(worker.assigned))
        self._hire()
        return lost


class _Worker:
    def __init__(self, process: BaseProcess, pipe: Connection[Any, Any]) -> None:
        self.process, self.pipe = process, pipe
        self.ready = False
        self.assigned: deque[int] = deque()


class _Mean:
    """Mean that follows: of what was lately, a tenth each."""

    def __init__(self) -> None:
        self.value = 0.0
        self.unknown = True

    def add(self, value: float) -> None:
        self.value = value if self.unknown else 0.9 * self.value + 0.1 * value
        self.value = max(self.value, 1e-6)
        self.unknown = False


def _reason(code: int | None) -> str:
    if code is not None and code < 0:
        with suppress(ValueError):
            return f"killed by {signal.Signals(-code).name}"
    return f"exit code {code}"


def _serve(pipe: Connection[Any, Any], job: Job, design: Design) -> None:
    """Do runs by their numbers until the pipe ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what an interrupt means
    leave_with_parent()
    import oblique_impact.simulation  # noqa: F401  what takes long is loaded before the first run
    from validation.sweeps.work import run_one

    with suppress(EOFError, BrokenPipeError, ConnectionResetError):
        listen(pipe.send)
        pipe.send(None)
        while True:
            number, scratch = pipe.recv()
            pipe.send(run_one(job, number, design.values(number), scratch))
