"""One run of a study, in whatever process: simulated, measured, a row whatever happens.

Sweeps and refinements run and measure by this; it needs nothing but this package: no folder, no file of theirs.
"""

from __future__ import annotations

import math
import re
import tempfile
import time
from collections.abc import Container, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict

from oblique_impact.errors import InputError, Outcome
from oblique_impact.kernels.compiling import compilations
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.parallel import Crash, compute_each
from oblique_impact.validation.quantities import GapError, not_determined, quantity

# the compiler is loaded by the processes that run, not by the one that hands out the work
if TYPE_CHECKING:
    from oblique_impact.history.history import History

#: outcomes of rows besides those of the physics
FAILURES = INVALID, ERROR, CRASHED, TIMEOUT = "invalid", "error", "crashed", "timeout"

#: what a first macro-collision can be, from the least to the most; "stopped" by another cause than Painleve
REGIMES = ("no contact", "slip", "reversal", "stick", "painleve", "stopped")


class Task(NamedTuple):
    """One run, and what it is asked for.

    `changes` holds values by key of the scenario; `timeout` (s) bounds the wall time of the run but for what is
    compiled in it; `scratch` is a folder for temporary files; `label` is for those who watch.
    """

    number: int
    base: Scenario
    quantities: tuple[str, ...]
    changes: dict[str, Any] = {}  # noqa: RUF012  never changed
    histories: bool = False
    timeout: float | None = None
    scratch: str | None = None
    label: str = ""

    def scenario(self) -> Scenario:
        """Return what is simulated; raises InputError if its values do not fit together."""
        return self.base.replace(**{key.replace(".", "__"): value for key, value in self.changes.items()})


class Row(TypedDict):
    """What is kept of a run; `wall_time` (s) is the only entry that differs from one time to the next."""

    run: int
    values: dict[str, float]  # NaN: the run does not have this quantity
    gaps: dict[str, str]  # why
    regime: str  # "" where there is no telling
    outcome: str
    message: str
    stopped_at: float  # s
    steps: int
    events: int
    energy: float  # J, the larger of initial and final energy
    warnings: list[str]  # of the run's summary
    undetermined: dict[str, str]  # quantities that have no limit over modes or elements, and why
    wall_time: float


# the files of a history by name
Files = dict[str, bytes]


class Done(NamedTuple):
    """A finished run."""

    row: Row
    files: Files | None = None


class OutOfTimeError(Exception):
    """Raised in a run that takes longer than it may."""


def measure_each(
    tasks: Sequence[Task], workers: int | None = None, scheduler: str | None = None, isolated: bool = False
) -> Iterator[Done]:
    """Yield the runs as they are finished; one that takes its process down is a row too.

    The arguments are those of :func:`~oblique_impact.validation.parallel.compute_each`.
    """
    for index, done in compute_each(measure_run, tasks, workers, scheduler, isolated):
        yield Done(failed(tasks[index].number, CRASHED, done.reason)) if isinstance(done, Crash) else done


def measure_run(task: Task) -> Done:
    """Simulate and measure one run; a failure becomes a row that says so."""
    from oblique_impact.simulation import simulate

    started = time.perf_counter()
    row = failed(task.number, ERROR, "")
    files = None
    try:
        with compilations(clock := _Clock(task.timeout)):
            history = simulate(task.scenario(), clock.check)
        _measure(row, task.quantities, history)
        files = _files(history, task.scratch) if task.histories else None
    except InputError as error:
        row = failed(task.number, INVALID, str(error))
    except OutOfTimeError as error:
        row = failed(task.number, TIMEOUT, str(error))
    except Exception as error:
        row = failed(task.number, ERROR, f"{type(error).__name__}: {error}")
    row["wall_time"] = time.perf_counter() - started
    return Done(row, files)


class _Clock:
    """Ends a run that takes too long, where it tells its progress: several times a second.

    It starts anew after each kernel that is compiled, which is no fault of the run.
    """

    def __init__(self, timeout: float | None) -> None:
        self._timeout = timeout
        self._started: float | None = time.perf_counter()

    def __call__(self, compiled: str) -> None:
        self._started = None

    def check(self, status: Any) -> None:
        now = time.perf_counter()
        self._started = now if self._started is None else self._started
        if self._timeout is not None and now - self._started > self._timeout:
            raise OutOfTimeError(f"took longer than {self._timeout:g} s, until t = {status.time:.6g} s")


def failed(number: int, outcome: str, message: str) -> Row:
    """Return the row of a run that has nothing to tell but why it failed."""
    return Row(
        run=number,
        values={},
        gaps={},
        regime="",
        outcome=outcome,
        message=" ".join(message.split())[:500],
        stopped_at=math.nan,
        steps=0,
        events=0,
        energy=math.nan,
        warnings=[],
        undetermined={},
        wall_time=0.0,
    )


def same_warnings(runs: Iterable[tuple[str, Sequence[str]]]) -> list[tuple[str, list[str]]]:
    """Group the warnings of runs by their text: that of the first run that has it, and the labels of all.

    Texts that differ in their numbers alone are the same.
    """
    found: dict[str, tuple[str, list[str]]] = {}
    for label, warnings in runs:
        for warning in warnings:
            kind = re.sub(r"\d[\d.e+-]*", "#", warning)
            text, labels = found.get(kind, (warning, []))
            found[kind] = text, [*labels, label]
    return list(found.values())


def is_row(row: Any, runs: int, quantities: Container[str]) -> bool:
    """Whether something that was read from a file is a row of a study of so many runs, with these quantities."""
    return (
        isinstance(row, dict)
        and row.keys() == Row.__annotations__.keys()
        and row["run"] in range(runs)
        and all(name in quantities for name in (*row["values"], *row["gaps"]))
    )


def regime(history: History) -> str:
    """Name what the first macro-collision of a run is: one of `REGIMES`.

    The strongest of what happens in it counts: stick before reversal before slip.
    """
    from oblique_impact.contact.state import State
    from oblique_impact.contact.transitions import EventKind

    collisions, outcome = history.macro_collisions, history.outcome
    if outcome is not Outcome.COMPLETED:
        stop = history.end_time
        if not collisions or (len(collisions) == 1 and stop - collisions[0]["end"] < history.macro_gap):
            return "painleve" if outcome is Outcome.PAINLEVE else "stopped"
    if not collisions:
        return "no contact"
    start, end = collisions[0]["start"], collisions[0]["end"]
    inside = [event for event in history.events if start <= event.time <= end]
    if any(event.state is State.STICK for event in inside):
        return "stick"
    return "reversal" if any(event.kind is EventKind.REVERSAL for event in inside) else "slip"


def _measure(row: Row, quantities: Sequence[str], history: History) -> None:
    for name in quantities:
        try:
            row["values"][name] = float(quantity(name).measure(history))
        except GapError as gap:
            row["values"][name], row["gaps"][name] = math.nan, str(gap)
    row["regime"] = regime(history)
    row["outcome"] = history.outcome.label
    row["message"] = "" if history.outcome is Outcome.COMPLETED else history.summary["message"]
    row["stopped_at"] = history.end_time
    row["steps"], row["events"] = history.steps, len(history.events)
    row["energy"] = max(abs(history.balance[key]) for key in ("initial", "final"))
    row["warnings"] = list(history.summary.get("warnings", ()))
    row["undetermined"] = not_determined(quantities, history)


def _files(history: History, scratch: str | None) -> Files:
    with tempfile.TemporaryDirectory(dir=scratch) as folder:
        history.save(folder)
        return {file.name: file.read_bytes() for file in Path(folder).iterdir()}
