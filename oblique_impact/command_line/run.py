"""The command `run`: one simulation and its four files."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.filesize import decimal

from oblique_impact.command_line.console import JsonOption, ScenarioArgument, SetOption, print_note, print_result
from oblique_impact.errors import Interrupted
from oblique_impact.scenario.messages import counted

if TYPE_CHECKING:
    from oblique_impact.history.history import History
    from oblique_impact.scenario.scenario import Scenario


def run(
    scenario: ScenarioArgument = "paper",
    out: Annotated[Path, typer.Option("--out", help="Folder for the results.")] = Path("out"),
    changes: SetOption = None,
    check: Annotated[bool, typer.Option("--check", help="Check the scenario; run and write nothing.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Simulate a scenario; writes scenario.toml, history.nc, events.csv and summary.json."""
    from oblique_impact.beam.validity.plausibility import implausible_values
    from oblique_impact.command_line.progress_bars import progress_bar
    from oblique_impact.files import writing
    from oblique_impact.scenario.scenario import Scenario
    from oblique_impact.simulation import check_scenario, compute_history

    chosen = Scenario.load(scenario, changes)
    warnings = implausible_values(chosen)
    for warning in [*warnings, *_size_notes(chosen)]:
        print_note(f"warning: {warning}")
    for line in chosen.taken_defaults:
        print_note(f"note: {line}")
    if check:
        check_scenario(chosen)
        line = f"scenario: {scenario}: nothing refused"
        print_result([line], {"scenario": scenario, "warnings": warnings}, as_json)
        return
    with writing(out):
        replaced = (out / "history.nc").exists()
        try:
            with progress_bar() as on_progress:
                history = compute_history(chosen, on_progress)
        except Interrupted as interrupt:
            history = interrupt.history
        history.save(out)
    lines = summary_lines(history, out, replaced, warnings)
    print_result(lines, {**history.summary, "results": out}, as_json)
    outcome = history.outcome
    if outcome.exit_code:
        print_note(f"{outcome.label} at t = {history.summary['end_time']:.6g} s: {history.summary['message']}")
        raise typer.Exit(outcome.exit_code)


def _size_notes(scenario: Scenario) -> Iterator[str]:
    """Yield a note if the history will be large."""
    from oblique_impact.history.size import LARGE, MEMORY, expected_size

    size = expected_size(scenario)
    if size > LARGE:
        needs = f"about {decimal(int(size))} on disk and {decimal(int(MEMORY * size))} of memory"
        yield f"the history will take {needs}; a longer solver.output_interval makes it smaller"


def summary_lines(history: History, folder: Path, replaced: bool, known: Sequence[str] = ()) -> Iterator[str]:
    """Yield the summary of a run in lines; `known` warnings, which were printed before, are left out."""
    from oblique_impact.history.summary import LOSSES, balance_text

    summary, energy = history.summary, history.summary["energy"]
    yield f"{summary['outcome']}: t = {summary['end_time']:.6g} s, {counted(summary['events'], 'event')}"
    for number, m in enumerate(summary["macro_collisions"], start=1):
        # the force of a rigid stop has no largest value that more modes or elements would not exceed
        peak = "" if "peak_force" in summary.get("without_limit", ()) else f", peak {m['peak_force']:.4g} N"
        yield (
            f"  collision {number}: {m['start']:.6f} to {m['end']:.6f} s, {counted(m['contacts'], 'contact')} "
            f"(less than {history.clustering_time:.2g} s apart), {m['normal_impulse']:.5g} N s{peak}"
        )
    losses = ", ".join(f"{name} {energy[f'lost_{name}']:.4g}" for name in LOSSES)
    yield f"  energy: {balance_text(energy)}"
    yield f"  lost: {losses} J"
    unaccounted, steps, seconds = energy["unaccounted"], summary["steps"], summary["wall_time"]
    yield f"  unaccounted: {unaccounted:.2e} J; {counted(steps, 'step')}, {seconds:.2f} s"
    for warning in (words for words in summary.get("warnings", []) if words not in known):
        yield f"  warning: {warning}"
    yield f"  results: {folder}{' (those of an earlier run were replaced)' if replaced else ''}"
