"""One run of a sweep, in whatever process: a row, whatever happens.  Needs nothing but this package."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Container, Iterable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypedDict

from oblique_impact.errors import InputError, Outcome
from oblique_impact.history.provenance import package_version, source_digest
from oblique_impact.scenario.scenario import Scenario
from validation.refinement.quantities import GapError, quantity
from validation.sweeps.plan import SOURCE, Plan, changed

# the compiler is loaded by the processes that run, not by the one that hands out the work
if TYPE_CHECKING:
    from oblique_impact.history.history import History

#: outcomes of rows besides those of the physics
INVALID, ERROR, CRASHED = "invalid", "error", "crashed"

#: what a first macro-collision can be, from the least to the most; "stopped" by another cause than Painleve
REGIMES = ("no contact", "slip", "reversal", "stick", "painleve", "stopped")


class Job(NamedTuple):
    """What is the same for all runs; sent to the processes that run them."""

    scenario_toml: str
    changes: dict[str, Any]
    keys: tuple[str, ...]
    quantities: tuple[str, ...]
    histories: bool


class Row(TypedDict):
    """One run in the table; `wall_time` (s) is the only entry that differs from one run to the next."""

    run: int
    values: dict[str, float]  # NaN: the run does not have this quantity
    gaps: dict[str, str]  # why
    regime: str  # "" where there is no telling
    outcome: str
    message: str
    stopped_at: float  # s
    steps: int
    wall_time: float


#: the files of a history by name
Files = dict[str, bytes]


class Done(NamedTuple):
    """A finished run."""

    row: Row
    files: Files | None = None


def make_job(plan: Plan) -> Job:
    """Return what the runs of a plan have in common."""
    names = tuple(q.name for q in plan.quantities)
    return Job(plan.base.to_toml(), plan.changes, plan.design.keys, names, plan.file.histories)


def run_many(job: Job, runs: Sequence[tuple[int, tuple[Any, ...]]]) -> list[Done]:
    """Do several runs, each given by its number and its values."""
    return [run_one(job, number, values) for number, values in runs]


def run_one(job: Job, number: int, values: Iterable[Any], scratch: str | None = None) -> Done:
    """Simulate and measure one run; a failure becomes a row that says so.

    Parameters
    ----------
    job : Job
        What all runs have in common.
    number : int
        Of the run, from 0.
    values : iterable
        In the order of `job.keys`.
    scratch : str, optional
        Folder for temporary files.
    """
    from oblique_impact.simulation import simulate

    started = time.perf_counter()
    row = failed(number, ERROR, "")
    files = None
    try:
        history = simulate(changed(_base(job.scenario_toml), job.changes, job.keys, values))
        _measure(row, job, history)
        files = _files(history, scratch) if job.histories else None
    except InputError as error:
        row = failed(number, INVALID, str(error))
    except Exception as error:
        row = failed(number, ERROR, f"{type(error).__name__}: {error}")
    row["wall_time"] = time.perf_counter() - started
    return Done(row, files)


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
        wall_time=0.0,
    )


def is_row(row: Any, runs: int, quantities: Container[str]) -> bool:
    """Whether something that was read from a file is a row of a sweep of so many runs, with these quantities."""
    if not isinstance(row, dict) or row.keys() != Row.__required_keys__:
        return False
    kinds = {"regime": str, "outcome": str, "message": str, "values": dict, "gaps": dict, "run": int, "steps": int}
    if not all(type(row[name]) is kind for name, kind in kinds.items()):
        return False
    numbers = [row["stopped_at"], row["wall_time"], *row["values"].values()]
    return (
        0 <= row["run"] < runs
        and 0 <= row["steps"] < 2**63
        and all(type(value) is float for value in numbers)
        and all(type(why) is str for why in row["gaps"].values())
        and all(name in quantities for name in (*row["values"], *row["gaps"]))
    )


def running_source() -> str:
    """Version and digest of what computes the rows, where it runs; asked of the workers of a cluster."""
    return f"{package_version()} (source {source_digest(SOURCE)})"


def regime(history: History) -> str:
    """Name what the first macro-collision of a run is: one of `REGIMES`.

    The strongest of what happens in it counts: stick before reversal before slip.
    """
    from oblique_impact.contact.state import State
    from oblique_impact.contact.transitions import EventKind

    collisions, outcome = history.summary["macro_collisions"], history.outcome
    if outcome is not Outcome.COMPLETED:
        stop = history.summary["end_time"]
        if not collisions or (len(collisions) == 1 and stop - collisions[0]["end"] < history.macro_gap):
            return "painleve" if outcome is Outcome.PAINLEVE else "stopped"
    if not collisions:
        return "no contact"
    start, end = collisions[0]["start"], collisions[0]["end"]
    inside = [event for event in history.events if start <= event.time <= end]
    if any(event.state is State.STICK for event in inside):
        return "stick"
    return "reversal" if any(event.kind is EventKind.REVERSAL for event in inside) else "slip"


@lru_cache(maxsize=4)
def _base(text: str) -> Scenario:
    return Scenario.from_toml(text)


def _measure(row: Row, job: Job, history: History) -> None:
    for name in job.quantities:
        try:
            row["values"][name] = float(quantity(name).measure(history))
        except GapError as gap:
            row["values"][name], row["gaps"][name] = math.nan, str(gap)
    row["regime"] = regime(history)
    row["outcome"] = history.outcome.label
    row["message"] = "" if history.outcome is Outcome.COMPLETED else history.outcome.sentence
    row["stopped_at"] = float(history.summary["end_time"])
    row["steps"] = int(history.summary["steps"])


def _files(history: History, scratch: str | None) -> Files:
    with tempfile.TemporaryDirectory(dir=scratch) as folder:
        history.save(folder)
        return {file.name: file.read_bytes() for file in Path(folder).iterdir()}
