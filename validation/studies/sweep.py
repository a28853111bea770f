"""Sweeps: a scenario over axes of its keys, in parallel, resumable, into one table with its report."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import prepare_folder, write_text
from oblique_impact.progress import OnProgress, Progress, silent
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.report import Block, Cell, Report, Section, Table, Text
from oblique_impact.validation.studies.design import Plan, SweepFile, load_plan, plan_of
from oblique_impact.validation.studies.maps import sweep_pictures
from oblique_impact.validation.studies.measure import same_warnings
from oblique_impact.validation.studies.study import Limits, run_study

if TYPE_CHECKING:
    from oblique_impact.history.history import History

#: distinct warnings that a terminal shows at most; runs and warnings that the report lists at most
_SHOWN, _LISTED = 5, 20


@dataclass(frozen=True)
class SweepResult:
    """A finished sweep.

    Attributes
    ----------
    plan : Plan
        What was varied, and what each run was asked for.
    folder : Path
        Where results.parquet, report.html, scenario.toml, sweep.toml and the histories lie.
    frame : pandas.DataFrame
        A row for each run: its values, quantities, outcome; `frame.attrs["units"]` by column.
    earlier : int
        Runs that were there before.
    seconds : float
        Wall time (s) of this call.
    """

    plan: Plan
    folder: Path
    frame: pd.DataFrame
    earlier: int
    seconds: float

    @property
    def report(self) -> Path:
        """The page."""
        return self.folder / "report.html"

    @property
    def outcomes(self) -> dict[str, int]:
        """How many runs ended how, the most frequent first."""
        return {str(name): int(count) for name, count in self.frame["outcome"].value_counts().items()}

    def to_dict(self) -> dict[str, Any]:
        """Return plain data: the rows of the table, the counts of outcomes, the place of the files."""
        runs = self.frame.to_dict("records")
        return {"outcomes": self.outcomes, "runs": runs, "results": str(self.folder)}

    def history(self, run: int) -> History:
        """Read the history of a run by its number; a sweep keeps them if its file says ``histories = true``.

        Raises InputError if there is none.
        """
        from oblique_impact.history.history import History

        return History.load(self.folder / "histories" / f"{run:06d}")


def sweep(
    source: str | os.PathLike[str] | SweepFile | Plan,
    out: str | os.PathLike[str],
    *,
    base: Scenario | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    timeout: float | None = None,
    on_progress: OnProgress = silent,
    command: str = "",
) -> SweepResult:
    """Run a scenario over axes of its keys, or what is missing of it, and write the table and its report.

    Parameters
    ----------
    source : str, path, SweepFile or Plan
        A shipped sweep by name, a sweep file, or what such a file would say.
    out : path
        Folder; a sweep that was interrupted there goes on.
    base : Scenario, optional
        In place of the scenario that the source names.
    scheduler : str, optional
        Address of a Dask scheduler.
    workers : int, optional
        Processes of this machine; default: the cores.
    timeout : float, optional
        Wall time (s) that a run may take; one that takes longer is a row with the outcome "timeout".
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` before the first and after runs.
    command : str
        How to repeat the sweep, for the report.

    Raises
    ------
    InputError
        In one line, before anything runs, for a faulty source or folder.  Runs that are not possible, or that the
        physics stops, are rows that say so.

    Examples
    --------
    >>> from oblique_impact.validation import AxisSection, SweepFile, sweep
    >>> friction = AxisSection(keys=["contact.mu_static", "contact.mu_kinetic"], values=[0.1, 0.2])
    >>> plan = SweepFile(scenario="paper", axes=[friction], quantities=["impulse"])
    >>> result = sweep(plan, "out/friction", workers=1)  # doctest: +SKIP
    >>> result.frame["impulse"]  # doctest: +SKIP
    """
    limits = Limits(workers, scheduler, timeout)
    if isinstance(source, Plan):
        if base is not None:
            raise InputError("base: a plan has its own scenario")
        plan = source
    else:
        plan = plan_of(source, base=base) if isinstance(source, SweepFile) else load_plan(source, base)
    started, there = time.monotonic(), list[int]()

    def count(progress: Progress) -> None:
        there.append(progress.done)
        on_progress(progress)

    frame = run_study(
        plan.runs,
        out,
        limits=limits,
        units={key: dimension.unit for dimension in plan.dimensions for key in dimension.keys},
        histories=plan.file.histories,
        exclusive=True,
        on_progress=count,
    )
    folder = prepare_folder(out)
    write_text(folder / "scenario.toml", plan.base.to_toml())
    write_text(folder / "sweep.toml", plan.to_toml())
    result = SweepResult(plan, folder, frame, there[0] - len(plan.impossible), time.monotonic() - started)
    report(result, command).write(folder)
    return result


def warned(frame: pd.DataFrame) -> list[tuple[int, str, str]]:
    """Return the warnings: number of runs that have it, the first of them, and the text; most frequent first."""
    found = same_warnings(zip(frame["run"].map(str), frame["warnings"], strict=True))
    return sorted(((len(runs), runs[0], text) for text, runs in found), key=lambda entry: -entry[0])


def lines(result: SweepResult) -> list[str]:
    """Return how a sweep went in lines, for a terminal."""
    frame, earlier, seconds = result.frame, result.earlier, result.seconds
    found = [f"{len(frame)} runs: {', '.join(f'{count} {name}' for name, count in result.outcomes.items())}"]
    if earlier:
        found.append(f"  {earlier} of them were there before")
    new = len(frame) - earlier - len(result.plan.impossible)
    if new:
        found.append(f"  {new} runs in {seconds:.1f} s, {new / seconds:.1f} runs/s")
    for row in _unfinished(frame).head(1).to_dict("records"):
        found.append(f"  the first not to complete is run {row['run']}: {row['outcome']}: {row['message']}")
    warnings = warned(frame)
    for count, run, text in warnings[:_SHOWN]:
        found.append(f"  warning of {count} of {len(frame)} runs, the first run {run}: {text}")
    if len(warnings) > _SHOWN:
        found.append(f"  and {len(warnings) - _SHOWN} other warnings, in the column warnings")
    return found


def report(result: SweepResult, command: str) -> Report:
    """Return the report of a finished sweep; `command` repeats it.  The numbers are in the table."""
    plan, frame = result.plan, result.frame
    pictures: list[Block] = list(sweep_pictures(plan, frame))
    none = Text("Pictures are drawn for sweeps with one or two directions.", note=True)
    outcomes = frame[["outcome", "regime"]].value_counts().rename("runs").reset_index()
    warnings = pd.DataFrame(warned(frame)[:_LISTED], columns=["runs", "the first", "warning"])
    unfinished, names = _unfinished(frame), ["run", "outcome", "stopped_at", "message"]
    more = f"The first {_LISTED} of {len(unfinished)}." if len(unfinished) > _LISTED else ""
    stopped = Table.of_frame(unfinished.head(_LISTED), more, wide=(3,), columns={name: name for name in names})
    seconds = frame["wall_time"]
    return Report(
        plan.file.title or "Sweep",
        plan.file.description or "A scenario over axes of its keys; every run is a row of results.parquet.",
        command,
        facts=[
            ("runs", str(len(frame))),
            ("scenario", Path(plan.file.scenario).name),
            ("changes", ", ".join(f"{key} = {value}" for key, value in plan.changes.items()) or "none"),
        ],
        times=[
            ("wall time of all runs together", f"{seconds.sum():.1f} s"),
            ("of one run", f"{seconds.mean():.3f} s in the mean, {seconds.max():.3f} s at most"),
        ],
        overview=[
            Table.of_frame(outcomes, "How the runs ended; regime is the first macro-collision."),
            *([Table.of_frame(warnings, "Warnings of the runs.", wide=(2,))] if len(warnings) else []),
        ],
        sections=[
            Section("Pictures", pictures or [none]),
            Section("Directions and quantities", _descriptions(plan, frame)),
            *([Section("Runs that did not complete", [stopped])] if len(unfinished) else []),
        ],
    )


def _unfinished(frame: pd.DataFrame) -> pd.DataFrame:
    return frame[frame["outcome"] != Outcome.COMPLETED.label]


def _descriptions(plan: Plan, frame: pd.DataFrame) -> list[Block]:
    """Return tables of what changes from run to run, and of what each run is asked for."""
    directions = []
    for dimension in plan.dimensions:
        values = frame[dimension.keys[0]]
        numeric = pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values)
        ends = (values.min(), values.max()) if numeric else (str(values.iloc[0]), str(values.iloc[-1]))
        directions.append([Cell(dimension.label, "code"), dimension.unit, int(values.nunique()), *ends])
    asked = frame[[q.name for q in plan.quantities]].agg(["min", "max"]).T
    quantities = [
        [Cell(q.name, "code"), q.meaning, q.unit, *asked.loc[q.name], int(frame[q.name].isna().sum())]
        for q in plan.quantities
    ]
    caption = "What each run is asked for; the column gaps of the table says why a value is missing."
    columns = ["quantity", "meaning", "unit", "least", "largest", "missing"]
    return [
        Table(["key", "unit", "values", "from", "to"], directions, "What changes from run to run."),
        Table(columns, quantities, caption, wide=(1,)),
    ]
