"""Sweeps: a scenario over axes of its keys, in parallel, resumable, into one table with its report."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from oblique_impact.errors import InputError, Outcome
from oblique_impact.files import save_text, writing
from oblique_impact.history.history import History
from oblique_impact.progress import OnProgress, Progress, silent
from oblique_impact.scenario.messages import counted
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.report import Block, Cell, Report, Section, Table, Text, cell, shown_unit
from oblique_impact.validation.report.parameters import parameters
from oblique_impact.validation.studies.design import Plan, SweepFile, load_plan, plan_of
from oblique_impact.validation.studies.maps import sweep_pictures
from oblique_impact.validation.studies.parallel import check_limits
from oblique_impact.validation.studies.study import reasons, run_study, same_warnings

#: distinct warnings that a terminal shows at most; runs and warnings that the report lists at most
_SHOWN, _LISTED = 5, 20


@dataclass(frozen=True, repr=False)
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
    def unfinished(self) -> pd.DataFrame:
        """Rows of the runs that did not complete."""
        return self.frame[self.frame["outcome"] != Outcome.COMPLETED.label]

    @property
    def outcomes(self) -> dict[str, int]:
        """Number of runs by outcome, the most frequent first."""
        return {str(name): int(count) for name, count in self.frame["outcome"].value_counts().items()}

    def __repr__(self) -> str:
        """Return what the terminal shows: how the runs ended, what it took, the most frequent warnings."""
        count, earlier = len(self.frame), self.earlier
        ends = ", ".join(f"{number} {name}" for name, number in self.outcomes.items())
        found, new = [f"{counted(count, 'run')}: {ends}"], count - earlier - len(self.plan.impossible)
        if earlier:
            found.append(f"  {earlier} of them were there before")
        if new:
            found.append(f"  {counted(new, 'run')} in {self.seconds:.1f} s, {new / self.seconds:.1f} runs/s")
        for row in self.unfinished.head(1).to_dict("records"):
            found.append(f"  the first not to complete is run {row['run']}: {row['outcome']}: {row['message']}")
        warnings = warned(self.frame)
        for runs, run, text in warnings[:_SHOWN]:
            found.append(f"  warning of {runs} of {count} runs, the first run {run}: {text}")
        if len(warnings) > _SHOWN:
            found.append(f"  and {counted(len(warnings) - _SHOWN, 'other warning')}, in the column warnings")
        return "\n".join(found)

    def _repr_html_(self) -> str:
        """Show the head of the report in a notebook."""
        return report(self)._repr_html_()

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each run: `frame`."""
        return self.frame

    def to_dict(self) -> dict[str, Any]:
        """Return plain data: the rows of the table, the counts of outcomes, the place of the files."""
        return {"outcomes": self.outcomes, "runs": self.frame, "results": self.folder}

    def history(self, run: int) -> History:
        """Read the history of a run by its number; a sweep keeps them if its file says ``histories = true``.

        Raises InputError if there is none.
        """
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
) -> SweepResult:
    """Run a scenario over axes of its keys, or what is missing of it, and write the table and its report.

    Parameters
    ----------
    source : str, path, SweepFile or Plan
        A sweep file, or what such a file would say.
    out : path
        Folder; a sweep that was interrupted there goes on.
    base : Scenario, optional
        In place of the scenario that the source names.
    scheduler, workers, timeout, on_progress
        As for :func:`~oblique_impact.validation.studies.study.run_study`.

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

    folder = Path(out)
    check_limits(scheduler, workers, timeout)
    with writing(folder):
        frame = run_study(
            plan.runs,
            out,
            scheduler=scheduler,
            workers=workers,
            timeout=timeout,
            units={key: direction.unit for direction in plan.directions for key in direction.names},
            histories=plan.file.histories,
            exclusive=True,
            on_progress=count,
        )
        save_text(folder / "scenario.toml", plan.base.to_toml())
        save_text(folder / "sweep.toml", plan.to_toml())
        result = SweepResult(plan, folder, frame, there[0] - len(plan.impossible), time.monotonic() - started)
        report(result).write(folder)
    return result


def warned(frame: pd.DataFrame) -> list[tuple[int, str, str]]:
    """Return the warnings: number of runs that have it, the first of them, and the text; most frequent first."""
    found = same_warnings(zip(frame["run"].map(str), frame["warnings"], strict=True))
    return sorted(((len(runs), runs[0], text) for text, runs in found), key=lambda entry: -entry[0])


def report(result: SweepResult) -> Report:
    """Return the report of a finished sweep.  The numbers are in the table."""
    plan, frame, unfinished = result.plan, result.frame, result.unfinished
    outcomes = frame[["outcome", "regime"]].value_counts().rename("runs").reset_index()
    outcomes = outcomes.rename(columns={"regime": "first macro-collision"}).replace("painleve", "Painlevé")
    warnings = pd.DataFrame(warned(frame)[:_LISTED], columns=["runs", "first run", "warning"])
    stopped = unfinished.head(_LISTED)[["run", "outcome", "stopped_at", "message"]]
    more = f"The first {len(stopped)} of {len(unfinished)} runs."
    headings = {"run": "run", "outcome": "outcome", "stopped_at": "stopped at", "message": "reason"}
    none = [Text("Pictures are drawn for sweeps with one or two directions.", note=True)]
    name = Path(plan.file.scenario).name
    return Report(
        plan.file.title or f"Parameter study of {name}",
        plan.file.description or f"The scenario {name} with other values of some parameters.",
        result.seconds,
        facts=[("runs", str(len(frame))), ("scenario", name)],
        overview=[
            *_descriptions(plan, frame),
            Table.of_frame(outcomes, "How the runs ended."),
            Table.of_frame(warnings, "Warnings of the runs.", wide=(2,)),
            *(sweep_pictures(plan, frame) or none),
        ],
        sections=[
            Section("Runs that did not complete", [Table.of_frame(stopped, more, wide=(3,), columns=headings)]),
            *parameters({name: plan.base}, "Those that change from run to run have other values there."),
        ],
    )


def _clear(values: pd.Series[float]) -> pd.Series[float]:
    """Return values without what is rounding beside the largest of them."""
    return values.mask(values.abs() < 1e-12 * values.abs().max(), 0.0)


def _descriptions(plan: Plan, frame: pd.DataFrame) -> list[Block]:
    """Return tables of what changes from run to run, and of what each run is asked for."""
    directions = []
    for direction in plan.directions:
        values = frame[direction.names[0]]
        numeric = pd.api.types.is_numeric_dtype(values) and not pd.api.types.is_bool_dtype(values)
        ends = (values.min(), values.max()) if numeric else (str(values.iloc[0]), str(values.iloc[-1]))
        unit = shown_unit(direction.unit)
        directions.append([direction.words, Cell(direction.label, "code"), unit, int(values.nunique()), *ends])
    undetermined = pd.Series([name for lines in frame["undetermined"] for name in reasons(lines)]).value_counts()
    quantities = [
        [
            q.meaning,
            Cell(q.name, "code"),
            shown_unit(q.unit),
            *(cell(value, 4) for value in (values.min(), values.max())),
            int(values.isna().sum()),
            int(undetermined.get(q.name, 0)),
        ]
        for q, values in ((q, _clear(frame[q.name])) for q in plan.quantities)
    ]
    columns = ["quantity", "symbol", "unit", "least", "largest", "missing in runs", "not determined in runs"]
    caption = (
        "What each run is asked for. Why a value is missing is in the column gaps of results.parquet; one that is "
        "not determined has no limit as modes or elements are added."
    )
    changes = ["parameter", "key", "unit", "values", "from", "to"]
    return [
        Table(changes, directions, "What changes from run to run.", wide=(0, 1)),
        Table(columns, quantities, caption, wide=(0,)),
    ]
