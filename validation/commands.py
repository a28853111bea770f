"""The commands `validate`, `refine`, `reproduce` and `sweep`: words in, one typed call, lines out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from oblique_impact.command_line.words import ScenarioArgument, SetOption, print_line, print_note

WorkersOption = Annotated[
    int | None, typer.Option(min=1, max=1024, help="Parallel processes; default: the cores.")
]


def validate(
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.")] = Path("out/validate"),
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="ID", help="A check or a group; repeatable.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Leave out the checks that take long.")] = False,
    workers: WorkersOption = None,
) -> None:
    """Check everything against something outside it; writes report.html, results.json and results.csv."""
    from oblique_impact.command_line.bars import counting_bar
    from validation.report.provenance import command_line
    from validation.suite import counts
    from validation.suite import validate as compute

    repeat = command_line("validate", out=out, only=only, quick=quick, workers=workers)

    with counting_bar("checks") as show:
        results = compute(out, only or [], quick, workers, show, repeat)
    failed = [result for result in results if result.verdict == "fail"]
    for result in failed:
        print_note(f"{result.id}: {result.quantity}: {result.computed} against {result.reference} {result.unit}")
    print_line(f"{counts(results)}; report: {out / 'report.html'}")
    if failed:
        raise typer.Exit(1)


def refine(
    scenario: ScenarioArgument = "paper",
    elements: Annotated[str | None, typer.Option(help="Numbers of elements, separated by commas.")] = None,
    modes: Annotated[str | None, typer.Option(help="Numbers of modes, separated by commas.")] = None,
    steps: Annotated[
        str | None, typer.Option(help="Free steps in s; contact steps keep their ratio to them.")
    ] = None,
    tolerances: Annotated[
        str | None, typer.Option(help="Tolerances of the event scheme, separated by commas.")
    ] = None,
    quantities: Annotated[
        list[str] | None, typer.Option("--quantity", metavar="NAME", help="A quantity of interest; repeatable.")
    ] = None,
    study: Annotated[
        str | None, typer.Option(help="A shipped study: elements, steps, remedies or grading.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.")] = Path("out/refine"),
    changes: SetOption = None,
    within: Annotated[
        float | None, typer.Option(help="Relative uncertainty that counts as converged; default 1e-3.")
    ] = None,
    workers: WorkersOption = None,
) -> None:
    """Refine elements, modes or time steps; writes report.html, results.json and results.csv."""
    from validation.refinement.command import refine_command

    lines = refine_command(
        scenario, elements, modes, steps, quantities, study, out, changes, workers, tolerances, within
    )
    for line in lines:
        print_line(line)


def reproduce(
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.")] = Path("out/reproduce"),
    workers: WorkersOption = None,
) -> None:
    """Reproduce the paper's figures 2 to 16 and its claims; writes report.html, results.json and CSV tables."""
    from validation.reproduction.command import reproduce_command

    for line in reproduce_command(out, workers):
        print_line(line)


def sweep(
    source: Annotated[str, typer.Argument(metavar="SWEEP", help="A shipped study or a TOML file.")],
    out: Annotated[
        Path, typer.Option("--out", help="Folder for the results; an interrupted sweep goes on there.")
    ] = Path("out/sweep"),
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Run on the Dask cluster of this scheduler.")
    ] = None,
    workers: WorkersOption = None,
) -> None:
    """Run a scenario over axes of its keys; writes results.parquet and report.html."""
    from validation.sweeps.command import sweep_command

    for line in sweep_command(source, out, scheduler, workers):
        print_line(line)
