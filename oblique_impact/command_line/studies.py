"""The commands `validate`, `refine`, `reproduce`, `sweep`, `fit` and `compare`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from oblique_impact.command_line.console import (
    JsonOption,
    ScenarioArgument,
    SetOption,
    minutes,
    print_note,
    print_result,
)
from oblique_impact.command_line.progress_bars import counting_bar
from oblique_impact.errors import InputError

if TYPE_CHECKING:
    from oblique_impact.validation.result import Result

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
    as_json: JsonOption = False,
) -> None:
    """Check the program against closed forms, published tables and other programs; writes a report."""
    from oblique_impact.validation.suite import select
    from oblique_impact.validation.suite import validate as compute

    checks = select(only or [], quick)
    expected = minutes(f"{len(checks)} checks", sum(check.seconds for check in checks), workers)
    with counting_bar("checks", note=expected) as show:
        result = compute(out, only or [], quick, workers, show)
    _print(result, out, as_json)
    if len(result.failed):
        raise typer.Exit(1)


def refine(
    scenario: ScenarioArgument = "paper",
    elements: Annotated[str | None, typer.Option(help="Numbers of elements, separated by commas.")] = None,
    modes: Annotated[str | None, typer.Option(help="Numbers of modes, separated by commas.")] = None,
    steps: Annotated[str | None, typer.Option(help="Free steps in s; contact steps keep their ratio.")] = None,
    tolerances: Annotated[str | None, typer.Option(help="Tolerances of the event scheme.")] = None,
    stiffness: Annotated[str | None, typer.Option(help="Stiffnesses of an elastic stop in N/m.")] = None,
    quantities: Annotated[
        list[str] | None,
        typer.Option(
            "--quantity",
            metavar="NAME",
            help="A quantity of interest, as impulse, peak_force, tip_y@0.5, max:lambda_n; repeatable.",
        ),
    ] = None,
    predictability: Annotated[
        bool,
        typer.Option(
            "--predictability", help="Sensitivity of event times, from runs with perturbed initial angles."
        ),
    ] = False,
    study: Annotated[
        str | None,
        typer.Option(hidden=True, help="Studies are files now."),
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.")] = Path("out/refine"),
    changes: SetOption = None,
    within: Annotated[float | None, typer.Option(help="Relative uncertainty to reach; default 1e-3.")] = None,
    scheduler: SchedulerOption = None,
    workers: WorkersOption = None,
    timeout: TimeoutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Refine elements, modes, steps or a stop's stiffness, or run a study file; writes report.html and results."""
    from oblique_impact.scenario.scenario import Scenario
    from oblique_impact.validation.studies import predictability as sensitivity
    from oblique_impact.validation.studies import refinement
    from oblique_impact.validation.studies.series import is_study

    if study is not None:
        words = f"is a file, docs/studies/{study}.toml of the sources and of the documentation"
        raise InputError(f"--study {study}: a study {words}: refine FILE, or sweep FILE for a sweep")
    axes = {"elements": elements, "modes": modes, "steps": steps, "stiffness": stiffness, "tolerances": tolerances}
    how: dict[str, Any] = {"out": out, "scheduler": scheduler, "workers": workers, "timeout": timeout}
    how["name"] = Path(scenario).name
    if predictability:
        for name, value in {**axes, "quantity": quantities, "within": within}.items():
            if value:
                raise InputError(f"--{name} together with --predictability: does not apply")
        base = Scenario.load(scenario, changes or [])
        with counting_bar("predictability") as show:
            result = sensitivity.predictability(base, on_progress=show, **how)
    else:
        how |= {axis: refinement.parse_levels(axis, text) for axis, text in axes.items() if text is not None}
        how |= {"quantities": quantities or (), "within": within}
        source: Any = scenario
        if is_study(scenario):
            how["changes"] = changes or ()
        else:
            source = Scenario.load(scenario, changes or [])
        with counting_bar("refine") as show:
            result = refinement.refine(source, on_progress=show, **how)
    _print(result, out, as_json)


def reproduce(
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.")] = Path("out/reproduce"),
    workers: WorkersOption = None,
    as_json: JsonOption = False,
) -> None:
    """Reproduce the paper's figures 2 to 16 and its claims; writes report.html, results.json and CSV tables."""
    from oblique_impact.validation.paper.command import SECONDS
    from oblique_impact.validation.paper.command import reproduce as compute

    expected = minutes("figures 2 to 16 and 31 claims", SECONDS, workers)
    with counting_bar("reproduce", note=expected) as show:
        result = compute(out, workers, show)
    _print(result, out, as_json)


def sweep(
    source: Annotated[str, typer.Argument(metavar="SWEEP", help="A TOML file.")],
    out: Annotated[
        Path, typer.Option("--out", help="Folder for the results; an interrupted sweep goes on there.")
    ] = Path("out/sweep"),
    scheduler: SchedulerOption = None,
    workers: WorkersOption = None,
    timeout: TimeoutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Run a scenario over axes of its keys; writes results.parquet and report.html."""
    from oblique_impact.validation.studies.design import load_plan
    from oblique_impact.validation.studies.parallel import check_limits
    from oblique_impact.validation.studies.sweep import sweep as compute

    check_limits(scheduler, workers, timeout)
    plan = load_plan(source)
    if plan.impossible:
        first = plan.impossible[0]
        words = f"the first is run {first.labels['run']}: {first.fault}"
        print_note(f"{len(plan.impossible)} of {len(plan.runs)} runs are not possible; {words}")
    how: dict[str, Any] = {"scheduler": scheduler, "workers": workers, "timeout": timeout}
    with counting_bar("sweep", rate="runs") as show:
        result = compute(plan, out, on_progress=show, **how)
    _print(result, out, as_json)


def fit(
    scenario: Annotated[
        str | None, typer.Argument(metavar="SCENARIO", help="A built-in name or a TOML file.")
    ] = None,
    data: Annotated[
        Path | None, typer.Argument(metavar="DATA", help="A CSV file with units in its header.")
    ] = None,
    vary: Annotated[
        list[str] | None, typer.Option("--vary", metavar="KEY[=LOW:HIGH]", help="A key to be found; repeatable.")
    ] = None,
    more: Annotated[
        list[str] | None,
        typer.Option("--data", metavar="SCENARIO=FILE", help="A scenario with data of its own; repeatable."),
    ] = None,
    shift: Annotated[
        str, typer.Option(metavar="LOW:HIGH", help="Find a time (s) within a range by which series are late.")
    ] = "",
    starts: Annotated[int, typer.Option(help="Starts of the search.")] = 4,
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.")] = Path("out/fit"),
    changes: SetOption = None,
    workers: WorkersOption = None,
    as_json: JsonOption = False,
) -> None:
    """Find keys of scenarios from measured data; writes report.html, results.json, .csv and scenario.toml."""
    from oblique_impact.scenario.scenario import Scenario
    from oblique_impact.validation.studies.fitting.fit import fit as compute

    if (scenario is None) != (data is None):
        raise InputError("DATA: missing; fit SCENARIO DATA, or --data SCENARIO=FILE for each of several")
    pairs = [] if scenario is None or data is None else [(scenario, data)]
    for text in more or ():
        name, equals, file = text.rpartition("=")
        if not (name and equals and file):
            raise InputError(f"--data {text}: should be SCENARIO=FILE")
        pairs.append((name, Path(file)))
    if not pairs:
        raise InputError("SCENARIO: missing; fit SCENARIO DATA, or --data SCENARIO=FILE for each of several")
    (base, first), *others = [(Scenario.load(name, changes or []), file) for name, file in pairs]
    how: dict[str, Any] = {"starts": starts, "out": out, "workers": workers, "name": pairs[0][0]}
    with counting_bar("fit") as show:
        result = compute(base, first, vary=vary or (), others=others, shift=shift, on_progress=show, **how)
    _print(result, out, as_json)


def compare(
    left: Annotated[Path, typer.Argument(metavar="LEFT", help="A run folder, or the history.nc inside one.")],
    right: Annotated[list[Path], typer.Argument(metavar="RIGHT", help="Others, each compared with it.")],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="A report: .html or .json.")] = Path(
        "out/compare.html"
    ),
    as_json: JsonOption = False,
) -> None:
    """Compare runs with the first, events aligned; writes a page, or the numbers as JSON."""
    from oblique_impact.files import writing_file
    from oblique_impact.history.history import History
    from oblique_impact.validation.comparison import compare as compute

    if out.suffix not in (".html", ".json"):
        raise InputError(f"--out {out}: should end in .html or .json")
    runs = [left, *right]
    histories = [History.load(run) for run in runs]
    with writing_file(out):
        result = compute(*histories, names=[str(run) for run in runs])
        result.save(out)
    _print(result, out, as_json)


def _print(result: Result, out: Path, as_json: bool) -> None:
    """Print what was found, and where it is written."""
    page = out / "report.html" if out.is_dir() else out
    print_result([*result.lines(), f"report: {page}"], lambda: result.data() | {"results": out}, as_json)
