"""Sweeps as a call, `sweep`: to a table and its report."""

from __future__ import annotations

import os
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from oblique_impact.errors import InputError, Outcome
from oblique_impact.progress import OnProgress, Progress, silent
from oblique_impact.scenario.scenario import Scenario
from oblique_impact.validation.measuring import measure_each
from oblique_impact.validation.parallel import check_limits
from oblique_impact.validation.report.provenance import call_text
from oblique_impact.validation.sweeps.plan import Plan, SweepFile, load_plan, plan_of
from oblique_impact.validation.sweeps.store import Store, open_store

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa

    from oblique_impact.history.history import History


#: distinct warnings that a terminal shows at most
_LISTED = 5


@dataclass(frozen=True)
class SweepResult:
    """A finished sweep.

    Attributes
    ----------
    plan : Plan
        What was varied, and what each run was asked for.
    folder : Path
        Where results.parquet, report.html, scenario.toml, sweep.toml and the histories lie.
    table : pyarrow.Table
        A row for each run: its values, quantities, outcome; every column with its unit.
    earlier : int
        Runs that were there before.
    seconds : float
        Wall time (s) of this call.
    """

    plan: Plan
    folder: Path
    table: pa.Table
    earlier: int
    seconds: float

    @property
    def report(self) -> Path:
        """The page."""
        return self.folder / "report.html"

    @property
    def outcomes(self) -> dict[str, int]:
        """How many runs ended how, the most frequent first."""
        counts = Counter(self.table["outcome"].to_pylist())
        return dict(sorted(counts.items(), key=lambda item: -item[1]))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data: the rows of the table, the counts of outcomes, the place of the files."""
        return {"outcomes": self.outcomes, "runs": self.table.to_pylist(), "results": str(self.folder)}

    def to_dataframe(self) -> pd.DataFrame:
        """Return the table for pandas."""
        frame: pd.DataFrame = self.table.to_pandas()
        return frame

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
    command: str | None = None,
) -> SweepResult:
    """Run a scenario over axes of its keys, or what is missing of it, and write the table and its report.

    Parameters
    ----------
    source : str, path, SweepFile or Plan
        A shipped study by name, a sweep file, or what such a file would say.
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
    command : str, optional
        How to repeat the sweep, for the report; default: this call.

    Returns
    -------
    SweepResult
        The table for pyarrow and pandas, and where everything is.

    Raises
    ------
    InputError
        In one line, before anything runs, for a faulty source or folder.  Runs that are not possible, or that the
        physics stops, are rows that say so.

    Examples
    --------
    >>> from validation import AxisSection, SweepFile, sweep
    >>> friction = AxisSection(keys=["contact.mu_static", "contact.mu_kinetic"], values=[0.1, 0.2])
    >>> plan = SweepFile(scenario="paper", axes=[friction], quantities=["impulse"])
    >>> result = sweep(plan, "out/friction", workers=1)  # doctest: +SKIP
    >>> result.to_dataframe()["impulse"]  # doctest: +SKIP
    """
    check_limits(scheduler, workers, timeout)
    plan = _plan(source, base)
    limits: dict[str, Any] = {"scheduler": scheduler, "workers": workers, "timeout": timeout}
    named = type(source).__name__ if isinstance(source, SweepFile | Plan) else repr(os.fspath(source))
    started = time.monotonic()
    with open_store(out, plan) as store:
        earlier = len(store.done)
        on_progress(Progress(earlier, plan.design.size))
        if earlier < plan.design.size:
            _run(plan, store, on_progress, **limits)
        table = _finish(plan, store, command or call_text("sweep", [named, repr(os.fspath(out))], **limits))
    return SweepResult(plan, Path(out), table, earlier, time.monotonic() - started)


def _plan(source: str | os.PathLike[str] | SweepFile | Plan, base: Scenario | None) -> Plan:
    if isinstance(source, Plan):
        if base is not None:
            raise InputError("base: a plan has its own scenario")
        return source
    return plan_of(source, base=base) if isinstance(source, SweepFile) else load_plan(source, base)


def _run(
    plan: Plan,
    store: Store,
    on_progress: OnProgress,
    scheduler: str | None,
    workers: int | None,
    timeout: float | None,
) -> None:
    runs, scratch = plan.design.size, None if scheduler else store.scratch
    tasks = [plan.task(run, timeout, scratch) for run in range(runs) if run not in store.done]
    try:
        for done in measure_each(tasks, workers, scheduler, isolated=True):
            store.add(done)
            on_progress(Progress(len(store.done), runs, f"run {done.row['run'] + 1}"))
    except KeyboardInterrupt:
        kept = f"{len(store.done)} of {runs} runs are kept"
        raise KeyboardInterrupt(f"{kept}; the same command goes on with the others") from None


def _finish(plan: Plan, store: Store, command: str) -> pa.Table:
    """Write the table if it is not there, and the report."""
    from oblique_impact.validation.sweeps.report import write_sweep_report
    from oblique_impact.validation.sweeps.table import make_table, read_table, write_table

    if store.journal is not None:
        write_table(store.table, make_table(plan, store.journal.rows()))
        store.journal.remove()
    table = read_table(store.table, plan)
    write_sweep_report(store.folder, plan, table, command)
    return table


def lines(result: SweepResult) -> list[str]:
    """Return how a sweep went in lines, for a terminal."""
    from oblique_impact.validation.sweeps.table import warned

    plan, earlier, seconds = result.plan, result.earlier, result.seconds
    words = ", ".join(f"{count} {name}" for name, count in result.outcomes.items())
    new = plan.design.size - earlier
    told = [f"{plan.design.size} runs: {words}"]
    if earlier:
        told.append(f"  {earlier} of them were there before")
    if new:
        told.append(f"  {new} runs in {seconds:.1f} s, {new / seconds:.1f} runs/s")
    for row in result.table.select(["run", "outcome", "message"]).to_pylist():
        if row["outcome"] not in (Outcome.COMPLETED.label, ""):
            told.append(f"  the first not to complete is run {row['run']}: {row['outcome']}: {row['message']}")
            break
    found = warned(result.table)
    for count, run, text in found[:_LISTED]:
        told.append(f"  warning of {count} of {plan.design.size} runs, the first run {run}: {text}")
    if len(found) > _LISTED:
        told.append(f"  and {len(found) - _LISTED} other warnings, in the column warnings")
    return told
