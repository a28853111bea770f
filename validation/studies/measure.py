"""One run of a study, in whatever process: simulated and measured; a row whatever happens."""

from __future__ import annotations

import math
import re
import tempfile
import time
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from oblique_impact.errors import InputError, Outcome
from oblique_impact.kernels.compiling import Clock, clock
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.studies.quantities import FIELDS, GapError, not_determined, quantity

# the compiler is loaded by the processes that run, not by the one that hands out the work
if TYPE_CHECKING:
    from oblique_impact.history.history import History

#: outcomes of rows besides those of the physics
FAILURES = INVALID, ERROR, CRASHED, TIMEOUT = "invalid", "error", "crashed", "timeout"

#: what a first macro-collision can be, from the least to the most; "stopped" by another cause than Painleve
REGIMES = ("no contact", "slip", "reversal", "stick", "painleve", "stopped")

#: columns of every study besides its labels and quantities: value of a run that failed, unit, meaning
COLUMNS: dict[str, tuple[Any, str, str]] = {
    "regime": ("", "", f"first macro-collision: {', '.join(REGIMES)}"),
    "outcome": ("", "", "how the run ended"),
    "message": ("", "", "why, if it did not reach its end time"),
    "gaps": ("", "", "why quantities are missing, a line each"),
    "warnings": ("", "", "warnings of the run, a line each"),
    "undetermined": ("", "", "quantities that have no limit over modes or elements, and why, a line each"),
    "stopped_at": (math.nan, "s", "time that the run reached"),
    "steps": (0, "1", "steps"),
    "events": (0, "1", "events"),
    "energy": (math.nan, "J", "the larger of initial and final energy"),
    "wall_time": (0.0, "s", "wall time of the run; the only column that differs from time to time"),
}


class Task(NamedTuple):
    """What a process is given: a scenario, the names of quantities, and whether its history is wanted.

    `timeout` (s) bounds the wall time of the run but for what is compiled in it.
    """

    scenario: Scenario
    quantities: tuple[str, ...]
    histories: bool = False
    timeout: float | None = None


class OutOfTimeError(Exception):
    """Raised in a run that takes longer than it may."""


def measure_run(task: Task) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Simulate and measure one run; returns its row and the files of its history, if wanted.

    A failure becomes a row that says so.
    """
    from oblique_impact.simulation import simulate

    started, files = time.perf_counter(), dict[str, bytes]()
    try:
        with clock() as marching:
            history = simulate(
                task.scenario,
                lambda status: _check_time(marching, task.timeout, status.time),
                section_forces=task.histories or any(name.partition(":")[2] in FIELDS for name in task.quantities),
            )
        row = measure(history, task.quantities)
        files = _files(history) if task.histories else files
    except InputError as error:
        row = failed(INVALID, str(error))
    except OutOfTimeError as error:
        row = failed(TIMEOUT, str(error))
    except Exception as error:
        row = failed(ERROR, f"{type(error).__name__}: {error}")
    row["wall_time"] = time.perf_counter() - started
    return row, files


def failed(outcome: str, message: str) -> dict[str, Any]:
    """Return the row of a run that has nothing to tell but why it failed."""
    row = {name: empty for name, (empty, *_) in COLUMNS.items()}
    return row | {"outcome": outcome, "message": " ".join(message.split())[:500]}


def measure(history: History, quantities: Sequence[str]) -> dict[str, Any]:
    """Return the row of a run: the quantities, NaN where it does not have one, and `COLUMNS`."""
    row, gaps = dict[str, Any](), list[str]()
    for name in quantities:
        try:
            row[name] = float(quantity(name).measure(history))
        except GapError as gap:
            row[name] = math.nan
            gaps.append(f"{name}: {gap}")
    undetermined = not_determined(quantities, history)
    return row | {
        "regime": regime(history),
        "outcome": history.outcome.label,
        "message": "" if history.outcome is Outcome.COMPLETED else history.summary["message"],
        "gaps": "\n".join(gaps),
        "warnings": "\n".join(history.summary.get("warnings", ())),
        "undetermined": "\n".join(f"{name}: {why}" for name, why in undetermined.items()),
        "stopped_at": history.end_time,
        "steps": history.steps,
        "events": len(history.events),
        "energy": max(abs(history.balance[key]) for key in ("initial", "final")),
    }


def reasons(lines: str) -> dict[str, str]:
    """Return the reasons by quantity of one entry of `gaps` or `undetermined`."""
    return dict(line.split(": ", 1) for line in lines.splitlines())


def same_warnings(runs: Iterable[tuple[str, str]]) -> list[tuple[str, list[str]]]:
    """Group the warnings of labelled runs by their text: that of the first run that has it, and the labels of all.

    Texts that differ in their numbers alone are the same.
    """
    found: dict[str, tuple[str, list[str]]] = {}
    for label, warnings in runs:
        for warning in warnings.splitlines():
            kind = re.sub(r"\d[\d.e+-]*", "#", warning)
            text, labels = found.get(kind, (warning, []))
            found[kind] = text, [*labels, label]
    return list(found.values())


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


def _check_time(marching: Clock, timeout: float | None, reached: float) -> None:
    if timeout is not None and marching.seconds > timeout:
        raise OutOfTimeError(f"took longer than {timeout:g} s, until t = {reached:.6g} s")


def _files(history: History) -> dict[str, bytes]:
    """Return the files of a history: a worker of a cluster may have no folder in common with us."""
    with tempfile.TemporaryDirectory() as folder:
        history.save(folder)
        return {file.name: file.read_bytes() for file in Path(folder).iterdir()}
