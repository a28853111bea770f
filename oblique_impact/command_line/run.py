"""The command `run`: one simulation and its four files."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from oblique_impact.command_line.words import JsonOption, ScenarioArgument, SetOption, print_note, print_result
from oblique_impact.errors import InputError, Interrupted

if TYPE_CHECKING:
    from oblique_impact.history.history import History


def run(
    scenario: ScenarioArgument = "paper",
    out: Annotated[Path, typer.Option("--out", help="Folder for the results.")] = Path("out"),
    changes: SetOption = None,
    as_json: JsonOption = False,
) -> None:
    """Simulate a scenario; writes scenario.toml, history.nc, events.csv and summary.json."""
    from oblique_impact.command_line.bars import progress_bar
    from oblique_impact.files import writing
    from oblique_impact.history.size import expected_size
    from oblique_impact.scenario.scenario import Scenario
    from oblique_impact.simulation import simulate

    chosen = Scenario.load(scenario, changes)
    with writing(out) as folder:
        replaced = (folder / "history.nc").exists()
        _check_size(expected_size(chosen), folder)
        try:
            with progress_bar() as on_progress:
                history = simulate(chosen, on_progress)
        except Interrupted as stop:
            history = stop.history
        history.save(folder)
    print_result(summary_lines(history, folder, replaced), {**history.summary, "results": folder}, as_json)
    outcome = history.outcome
    if outcome.exit_code:
        print_note(f"{outcome.label} at t = {history.summary['end_time']:.6g} s: {history.summary['message']}")
        raise typer.Exit(outcome.exit_code)


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


def summary_lines(history: History, folder: Path, replaced: bool) -> Iterator[str]:
    """Yield what a run was like, for a terminal."""
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
    for warning in summary.get("warnings", []):
        yield f"  warning: {warning}"
    yield f"  results: {folder}{' (those of an earlier run were replaced)' if replaced else ''}"
