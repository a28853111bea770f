"""`oblique-impact sweep`: from the command line's words to a table and its report."""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from oblique_impact import interrupts
from oblique_impact.errors import InputError, Outcome
from validation.parallel import default_workers
from validation.sweep.cluster import Cluster, check_address
from validation.sweep.design import Design
from validation.sweep.plan import Plan, load_plan
from validation.sweep.pool import LocalPool, TakeRows
from validation.sweep.progress import sweep_bar
from validation.sweep.store import Store, open_store
from validation.sweep.work import Done, Job, make_job

if TYPE_CHECKING:
    import pyarrow as pa


class Executor(Protocol):
    """What runs rows: processes of this machine, or a cluster."""

    def run(self, numbers: Sequence[int], take: TakeRows, scratch: str | None = None) -> None:
        """Do the runs; hand over what is finished."""

    def close(self) -> None:
        """Leave nothing behind."""


def sweep_command(source: str, out: Path, scheduler: str | None = None, workers: int | None = None) -> list[str]:
    """Run a sweep, or what is missing of it, and write its table and report into `out`.

    Parameters
    ----------
    source : str
        A shipped study or a sweep file.
    out : Path
        Folder; a sweep that was interrupted there goes on.
    scheduler : str, optional
        Address of a Dask scheduler.
    workers : int, optional
        Processes of this machine; default: the cores.

    Returns
    -------
    list of str
        Lines to print.

    Raises
    ------
    InputError
        In one line.
    """
    if scheduler is not None and workers is not None:
        raise InputError(f"--workers {workers} together with --scheduler: a cluster has its own workers; give one")
    if scheduler is not None:
        check_address(scheduler)
    plan = load_plan(source)
    if plan.impossible:
        _say(f"{plan.impossible} of {plan.design.size} runs are not possible; the first is {plan.fault}")
    started = time.monotonic()
    with open_store(out, plan) as store:
        earlier = len(store.done)
        if not store.complete:
            _run(plan, store, scheduler, workers)
        return [*_finish(plan, store, earlier, time.monotonic() - started), f"results: {out}"]


def _run(plan: Plan, store: Store, scheduler: str | None, workers: int | None) -> None:
    missing = store.missing()
    if not missing:
        return
    executor = _executor(scheduler, min(workers or default_workers(), len(missing)), make_job(plan), plan.design)
    try:
        if scheduler is None:
            _announce_compilation(plan)
        # what is needed at the end is loaded while the others work
        import validation.sweep.report  # noqa: F401

        with sweep_bar(plan.design.size, len(store.done)) as advance, interrupts.keeping():

            def take(finished: Sequence[Done]) -> None:
                store.add(finished)
                advance(len(finished))

            try:
                executor.run(missing, take, store.scratch)
            except KeyboardInterrupt:
                store.flush()
                kept = f"{len(store.done)} of {plan.design.size} runs are kept"
                raise KeyboardInterrupt(f"{kept}; the same command goes on with the others") from None
            store.flush()
    finally:
        executor.close()


def _executor(scheduler: str | None, workers: int, job: Job, design: Design) -> Executor:
    if scheduler is None:
        return LocalPool(job, design, workers)
    return Cluster(scheduler, job, design)


def _finish(plan: Plan, store: Store, earlier: int, seconds: float) -> list[str]:
    """Write the table if it is not there, and the report; returns lines to print."""
    from validation.sweep.report import write_sweep_report
    from validation.sweep.table import make_table, read_table, write_table

    if not store.complete:
        store.flush()
        write_table(store.table, make_table(plan, store.rows()))
    store.finish()
    table = read_table(store.table, plan)
    write_sweep_report(store.folder, plan, table)
    return _lines(plan, table, earlier, seconds)


def _lines(plan: Plan, table: pa.Table, earlier: int, seconds: float) -> list[str]:
    outcomes = Counter(table["outcome"].to_pylist())
    words = ", ".join(f"{count} {name}" for name, count in sorted(outcomes.items(), key=lambda item: -item[1]))
    new = plan.design.size - earlier
    lines = [f"{plan.design.size} runs: {words}"]
    if earlier:
        lines.append(f"  {earlier} of them were there before")
    if new:
        lines.append(f"  {new} runs in {seconds:.1f} s, {new / seconds:.1f} runs/s")
    for row in table.select(["run", "outcome", "message"]).to_pylist():
        if row["outcome"] not in (Outcome.COMPLETED.label, ""):
            lines.append(f"  the first not to complete is run {row['run']}: {row['outcome']}: {row['message']}")
            break
    return lines


def _announce_compilation(plan: Plan) -> None:
    from oblique_impact.jit import is_compiled

    if not is_compiled("march_fixed" if plan.base.solver.scheme == "fixed-step" else "march_event"):
        _say("first run on this machine: compiling the numerical kernels, about 20 s, once")


def _say(line: str) -> None:
    """Write one line to standard error."""
    print(f"oblique-impact: {line}", file=sys.stderr, flush=True)
