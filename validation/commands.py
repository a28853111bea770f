"""The commands `validate`, `refine`, `reproduce`, `sweep` and `compare`: words in, one typed call, lines out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from oblique_impact.command_line.bars import counting_bar
from oblique_impact.command_line.words import ScenarioArgument, SetOption, print_line, print_note
from oblique_impact.errors import InputError

if TYPE_CHECKING:
    from oblique_impact.scenario.scenario import Scenario

WorkersOption = Annotated[
    int | None, typer.Option(min=1, max=1024, help="Parallel processes; default: the cores.")
]
SchedulerOption = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="Run on the Dask cluster of this scheduler.")
]
TimeoutOption = Annotated[
    float | None, typer.Option(metavar="SECONDS", help="Wall time of a run; one that takes longer is given up.")
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
    stiffness: Annotated[
        str | None, typer.Option(help="Stiffnesses of an elastic stop in N/m, ascending.")
    ] = None,
    quantities: Annotated[
        list[str] | None, typer.Option("--quantity", metavar="NAME", help="A quantity of interest; repeatable.")
    ] = None,
    predictability: Annotated[
        bool, typer.Option("--predictability", help="Ask by shadow runs whether event times mean anything.")
    ] = False,
    study: Annotated[
        str | None,
        typer.Option(
            help="A shipped study: elements, steps, remedies, grading, rigid-stop, predictability or "
            "small-deflection."
        ),
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.")] = Path("out/refine"),
    changes: SetOption = None,
    within: Annotated[
        float | None, typer.Option(help="Relative uncertainty that counts as converged; default 1e-3.")
    ] = None,
    scheduler: SchedulerOption = None,
    workers: WorkersOption = None,
    timeout: TimeoutOption = None,
) -> None:
    """Refine elements, modes, steps or a stop's stiffness; writes report.html, results.json and results.csv."""
    from oblique_impact.scenario.scenario import Scenario
    from validation.refinement.command import ShippedStudy, lines
    from validation.refinement.command import refine as compute
    from validation.refinement.ladders import parse_levels
    from validation.report.provenance import command_line

    given = {
        "elements": elements,
        "modes": modes,
        "steps": steps,
        "tolerances": tolerances,
        "stiffness": stiffness,
    }
    texts = {axis: text for axis, text in given.items() if text is not None}
    levels: dict[str, Any] = {axis: parse_levels(axis, text) for axis, text in texts.items()}
    changes, quantities = changes or [], quantities or []
    how: dict[str, Any] = {"within": within, "out": out}
    how |= {"scheduler": scheduler, "workers": workers, "timeout": timeout}
    if study is not None and scenario != "paper":
        raise InputError(f"scenario = {scenario!r} together with --study {study}: a shipped study has its own")
    shown = [] if study else [scenario]
    if study == "small-deflection":
        refused = {
            **texts,
            "quantity": quantities,
            "within": within,
            "set": changes,
            "predictability": predictability,
        }
        refused |= {"scheduler": scheduler, "timeout": timeout}
        for name in (name for name, value in refused.items() if value not in (None, [], False)):
            raise InputError(f"--{name} together with --study {study}: does not apply")
        _map_small_deflection(out, workers)
        return
    if predictability or study == "predictability":
        refused = {**texts, "quantity": quantities, "within": within, "set": changes if study else []}
        for name in (name for name, value in refused.items() if value not in (None, [])):
            raise InputError(f"--{name} together with --{'study ' if study else ''}predictability: does not apply")
        _predict(None if study else Scenario.load(scenario, changes), Path(scenario).name, shown, changes, how)
        return
    repeat = command_line("refine", *shown, study=study, **texts, quantity=quantities, set=changes, **how)
    with counting_bar(study or "refine") as show:
        result = compute(
            None if study else Scenario.load(scenario, changes),
            quantities=quantities,
            study=cast(ShippedStudy | None, study),
            changes=changes if study else (),
            name=Path(scenario).name,
            command=repeat,
            on_progress=show,
            **levels,
            **how,
        )
    for line in [*lines(result), f"report: {result.report}"]:
        print_line(line)


def _predict(
    scenario: Scenario | None, name: str, shown: list[str], changes: list[str], how: dict[str, Any]
) -> None:
    """Ask by shadow runs what of a scenario, or of the shipped cases, is predictable."""
    from validation.refinement.predictability import lines, predictability
    from validation.refinement.shipped import predictability_cases
    from validation.report.provenance import command_line

    which: dict[str, Any] = {"study": "predictability"} if scenario is None else {"predictability": True}
    repeat = command_line("refine", *shown, **which, set=changes, **how)
    how = {key: value for key, value in how.items() if key != "within"}
    with counting_bar("predictability") as show:
        result = predictability(
            scenario or predictability_cases(), name=name, command=repeat, on_progress=show, **how
        )
    for line in [*lines(result), f"report: {result.report}"]:
        print_line(line)


def _map_small_deflection(out: Path, workers: int | None) -> None:
    """Hold the floating frame against the exact beam."""
    from validation.absolute.small_deflection import lines, small_deflection
    from validation.report.provenance import command_line

    repeat = command_line("refine", study="small-deflection", out=out, workers=workers)
    with counting_bar("small-deflection") as show:
        result = small_deflection(out=out, workers=workers, command=repeat, on_progress=show)
    for line in [*lines(result), f"report: {result.report}"]:
        print_line(line)


def reproduce(
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.")] = Path("out/reproduce"),
    workers: WorkersOption = None,
) -> None:
    """Reproduce the paper's figures 2 to 16 and its claims; writes report.html, results.json and CSV tables."""
    from validation.report.provenance import command_line
    from validation.reproduction.command import lines
    from validation.reproduction.command import reproduce as compute

    with counting_bar("reproduce") as show:
        result = compute(out, workers, show, command_line("reproduce", out=out, workers=workers))
    for line in lines(result):
        print_line(line)


def sweep(
    source: Annotated[str, typer.Argument(metavar="SWEEP", help="A shipped study or a TOML file.")],
    out: Annotated[
        Path, typer.Option("--out", help="Folder for the results; an interrupted sweep goes on there.")
    ] = Path("out/sweep"),
    scheduler: SchedulerOption = None,
    workers: WorkersOption = None,
    timeout: TimeoutOption = None,
) -> None:
    """Run a scenario over axes of its keys; writes results.parquet and report.html."""
    from validation.parallel import check_limits
    from validation.report.provenance import command_line
    from validation.sweeps.command import lines
    from validation.sweeps.command import sweep as compute
    from validation.sweeps.plan import load_plan

    check_limits(scheduler, workers, timeout)
    plan = load_plan(source)
    if plan.impossible:
        print_note(f"{plan.impossible} of {plan.design.size} runs are not possible; the first is {plan.fault}")
    how: dict[str, Any] = {"scheduler": scheduler, "workers": workers, "timeout": timeout}
    repeat = command_line("sweep", source, out=out, **how)
    with counting_bar("sweep", rate="runs") as show:
        result = compute(plan, out, on_progress=show, command=repeat, **how)
    for line in [*lines(result), f"results: {out}"]:
        print_line(line)


def compare(
    left: Annotated[Path, typer.Argument(help="A run folder, or the history.nc inside one.")],
    right: Annotated[Path, typer.Argument(help="Another one.")],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="A report: .html or .json.")] = Path(
        "out/compare.html"
    ),
) -> None:
    """Compare two runs, events aligned; writes a page, or the numbers as JSON."""
    from oblique_impact.history.history import History
    from validation.comparison import compare as compute
    from validation.comparison_report import check_target, save_comparison
    from validation.report.provenance import command_line

    check_target(out)
    found = compute(History.load(left), History.load(right), names=(str(left), str(right)))
    save_comparison(found, out, command_line("compare", left, right, out=out))
    for line in [*found.summary(), f"report: {out}"]:
        print_line(line)
