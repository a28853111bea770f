"""The command `run`: one simulation and its four files."""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from oblique_impact.command_line.words import JsonOption, ScenarioArgument, SetOption, print_note, print_result
from oblique_impact.errors import InputError, Interrupted, Outcome
from oblique_impact.interrupts import SIGNALS

if TYPE_CHECKING:
    from oblique_impact.history.history import History
    from oblique_impact.marching.loop import Status


def run(
    scenario: ScenarioArgument = "paper",
    out: Annotated[Path, typer.Option("--out", help="Folder for the results.")] = Path("out"),
    changes: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Simulate a scenario; writes scenario.toml, history.nc, events.csv and summary.json."""
    from oblique_impact.beam.plausibility import doubts
    from oblique_impact.command_line.bars import progress_bar
    from oblique_impact.files import writing
    from oblique_impact.history.size import expected_size
    from oblique_impact.scenario.scenario import Scenario
    from oblique_impact.simulation import simulate

    chosen = Scenario.load(scenario, changes)
    warnings = doubts(chosen)
    for warning in warnings:
        print_note(f"warning: {warning}")
    interrupted = False
    with ExitStack() as lock:
        lock.enter_context(writing(out))
        replaced = (out / "history.nc").exists()
        _check_size(expected_size(chosen), out)
        try:
            with ExitStack() as bar, _ending_at_once(bar, lock) as early:
                show = bar.enter_context(progress_bar())

                def on_progress(status: Status) -> None:
                    early.close()  # from here on there is something to keep
                    show(status)

                history = simulate(chosen, on_progress)
        except Interrupted as stop:
            history, interrupted = stop.history, True
    folder = _save(history, out)  # which locks the folder itself
    print_result(
        summary_lines(history, folder, replaced, warnings), {**history.summary, "results": folder}, as_json
    )
    outcome = history.outcome
    if outcome.exit_code:
        print_note(f"{outcome.label} at t = {history.summary['end_time']:.6g} s: {history.summary['message']}")
        raise typer.Exit(outcome.exit_code)
    if interrupted:
        print_note("interrupted when the run had ended: its results are complete")
        raise typer.Exit(Outcome.INTERRUPTED.exit_code)


def _check_size(size: float, out: Path) -> None:
    """Say beforehand that a history will be large; raises InputError if the disk has no room for it (bytes)."""
    from oblique_impact.history.size import LARGE, MEMORY, in_words

    remedy = "a longer solver.output_interval makes it smaller"
    free = shutil.disk_usage(out).free
    if size > free:
        room = f"the history takes about {in_words(size)} and {in_words(free)} are free"
        raise InputError(f"--out {out}: cannot be written: {room}; {remedy}")
    if size > LARGE:
        needs = f"about {in_words(size)} on disk and {in_words(MEMORY * size)} of memory"
        print_note(f"warning: the history will take {needs}; {remedy}")


def _save(history: History, out: Path) -> Path:
    """Write the results, elsewhere if the disk is full by now: what is computed is not thrown away."""
    from tempfile import mkdtemp

    try:
        return history.save(out)
    except KeyboardInterrupt:
        history.save(out)  # Ctrl-C ends runs and keeps what is done; a second one ends this too
        raise
    except InputError as error:
        try:
            elsewhere = mkdtemp(prefix="oblique-impact-")
            history.save(elsewhere)
        except (InputError, OSError):
            raise error from None
        raise InputError(f"{error}; the results are in {elsewhere}") from None


@contextmanager
def _ending_at_once(*stacks: ExitStack) -> Iterator[ExitStack]:
    """Let an interrupt close the stacks and end the process, in the block or until the yielded one is closed.

    The compiler calls back into Python too, and an exception that is raised there is lost.
    """

    def leave(number: int, frame: FrameType | None) -> None:
        for stack in stacks:
            with suppress(RuntimeError):  # a bar that is being drawn
                stack.close()
        os.write(2, b"oblique-impact: interrupted\n")  # what is buffered may be in the midst of a line
        os._exit(Outcome.INTERRUPTED.exit_code)

    with ExitStack() as restore:
        for number in SIGNALS:
            # not where they are ignored, nor in a program that handles them itself
            if signal.getsignal(number) is signal.default_int_handler:
                restore.callback(signal.signal, number, signal.signal(number, leave))
        yield restore


def summary_lines(history: History, folder: Path, replaced: bool, known: Sequence[str] = ()) -> Iterator[str]:
    """Yield what a run was like, for a terminal; `known` warnings, which were printed before, are not repeated."""
    from oblique_impact.history.summary import LOSSES, balance_in_words

    summary, energy = history.summary, history.summary["energy"]
    yield f"{summary['outcome']}: t = {summary['end_time']:.6g} s, {summary['events']} events"
    for number, m in enumerate(summary["macro_collisions"], start=1):
        # the force of a rigid stop has no largest value that more modes or elements would not exceed
        peak = "" if "peak_force" in summary.get("without_limit", ()) else f", peak {m['peak_force']:.4g} N"
        yield (
            f"  collision {number}: {m['start']:.6f} to {m['end']:.6f} s, {m['contacts']} contacts "
            f"(gap < {history.macro_gap:.2g} s), {m['normal_impulse']:.5g} N s{peak}"
        )
    losses = ", ".join(f"{name} {energy[f'lost_{name}']:.4g}" for name in LOSSES)
    yield f"  energy: {balance_in_words(energy)}"
    yield f"  lost: {losses} J"
    unaccounted, steps, seconds = energy["unaccounted"], summary["steps"], summary["wall_time"]
    yield f"  unaccounted: {unaccounted:.2e} J; {steps} steps, {seconds:.2f} s"
    for warning in (words for words in summary.get("warnings", []) if words not in known):
        yield f"  warning: {warning}"
    yield f"  results: {folder}{' (those of an earlier run were replaced)' if replaced else ''}"
