"""The command line: the one place where scenario, discretization, simulation and pictures meet."""

from __future__ import annotations

import json
import os
import shutil
import sys
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from oblique_impact.command_line import interrupts
from oblique_impact.errors import InputError, Interrupted

if TYPE_CHECKING:
    from oblique_impact.beam.frequencies import Frequencies
    from oblique_impact.history.history import History
    from oblique_impact.scenario.scenario import Scenario

app = typer.Typer(
    name="oblique-impact",
    help="A flexible beam swings on a pin, strikes a rigid slope, slips, sticks and bounces.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

ScenarioArgument = Annotated[str, typer.Argument(help="A built-in name (paper, ...) or a TOML file.")]
SetOption = Annotated[
    list[str] | None, typer.Option("--set", metavar="SECTION.KEY=VALUE", help="Change a key; repeatable.")
]

WorkersOption = Annotated[
    int | None, typer.Option(min=1, max=1024, help="Parallel processes; default: the cores.")
]


@app.command()
def run(
    scenario: ScenarioArgument = "paper",
    out: Annotated[Path, typer.Option("--out", help="Folder for the results.")] = Path("out"),
    changes: SetOption = None,
) -> None:
    """Simulate a scenario; writes scenario.toml, history.nc, events.csv and summary.json."""
    chosen = _load(scenario, changes)
    from oblique_impact.beam.plausibility import doubts
    from oblique_impact.files import writing

    said = doubts(chosen)
    for doubt in said:
        _say(f"warning: {doubt}")
    replaced = (out / "history.nc").exists()
    with writing(out):
        history = _simulate(chosen)
        folder = _save(history, out)
    _print_summary(history, folder, replaced, said)
    outcome = history.outcome
    if outcome.exit_code:
        _say(f"{outcome.label} at t = {history.summary['end_time']:.6g} s: {outcome.sentence}")
        raise typer.Exit(outcome.exit_code)
    interrupts.check()


@app.command()
def modes(
    scenario: ScenarioArgument = "paper",
    speeds: Annotated[str, typer.Option(help="Spin rates in rad/s, separated by commas.")] = "0",
    count: Annotated[int | None, typer.Option(min=1, max=100, help="Frequencies per speed.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object.")] = False,
    out: Annotated[
        Path | None, typer.Option("--out", help="Campbell diagram: a picture file or a folder.")
    ] = None,
    changes: SetOption = None,
) -> None:
    """Natural frequencies (rad/s) of the spinning beam, flapwise and chordwise."""
    chosen = _load(scenario, changes)
    rates = _speeds(speeds)
    if out is not None:
        from oblique_impact.files import prepare_folder

        prepare_folder(out.parent if out.suffix else out)
    from oblique_impact.beam.frequencies import natural_frequencies
    from oblique_impact.command_line.progress import counting_bar

    # one call of LAPACK, of minutes on fine meshes
    with interrupts.ending_at_once(), counting_bar("frequencies"):
        found = natural_frequencies(chosen, rates, count)
    if as_json:
        typer.echo(json.dumps(found.to_dict()))
    else:
        _print_modes(found)
    if out is not None:
        from renders.campbell import campbell_diagram

        _say(f"Campbell diagram: {campbell_diagram(chosen, rates, found.flapwise.shape[1], out)}")


@app.command()
def validate(
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.")] = Path("out/validate"),
    only: Annotated[
        list[str] | None, typer.Option("--only", metavar="ID", help="A check or a group; repeatable.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Leave out the checks that take long.")] = False,
    workers: WorkersOption = None,
) -> None:
    """Check everything against something outside it; writes report.html, results.json and results.csv."""
    from oblique_impact.command_line.progress import counting_bar
    from validation.report.provenance import command_line
    from validation.suite import counts, validate

    repeat = command_line("validate", out=out, only=only, quick=quick, workers=workers)

    with counting_bar("checks") as show:
        results = validate(out, only or [], quick, workers, show, repeat)
    failed = [result for result in results if result.verdict == "fail"]
    for result in failed:
        _say(f"{result.id}: {result.quantity}: {result.computed} against {result.reference} {result.unit}")
    _print(f"{counts(results)}; report: {out / 'report.html'}")
    if failed:
        raise typer.Exit(1)


@app.command()
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
        _print(line)


@app.command()
def reproduce(
    out: Annotated[Path, typer.Option("--out", help="Folder for the report.")] = Path("out/reproduce"),
    workers: WorkersOption = None,
) -> None:
    """Reproduce the paper's figures 2 to 16 and its claims; writes report.html, results.json and CSV tables."""
    from validation.reproduction.command import reproduce_command

    for line in reproduce_command(out, workers):
        _print(line)


@app.command()
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
        _print(line)


@app.command()
def render(
    context: typer.Context,
    histories: Annotated[
        list[Path], typer.Argument(metavar="HISTORY...", help="Run folders or history.nc files.")
    ],
    out: Annotated[Path, typer.Option("--out", help="FILE.png, .mp4, .gif, .webp or .html.")] = Path(
        "out/film.mp4"
    ),
    times: Annotated[
        list[float] | None,
        typer.Option("--time", help="Stills, strips: time (s); of a strip repeatable."),
    ] = None,
    event: Annotated[
        int | None,
        typer.Option(help="Stills: at an event, by its number from 1."),
    ] = None,
    strip: Annotated[
        bool, typer.Option("--strip", help="Strips: instead of a still, one row for each time.")
    ] = False,
    size: Annotated[str, typer.Option(help="WIDTHxHEIGHT in pixels; of one row of a strip.")] = "",
    fps: Annotated[int | None, typer.Option(help="Films: frames per second; default 30.")] = None,
    speed: Annotated[float | None, typer.Option(help="Films: physical over film time in flight.")] = None,
    contact_speed: Annotated[float | None, typer.Option(help="Films: the same in contact, e.g. 0.001.")] = None,
    between: Annotated[str | None, typer.Option(metavar="T0,T1", help="Films: part of the run (s).")] = None,
    frames: Annotated[int | None, typer.Option(help="Films: exactly so many frames.")] = None,
    deformation: Annotated[float | None, typer.Option(help="Deformation factor; default: chosen.")] = None,
    colour: Annotated[str, typer.Option(help="The result in colour.")] = "bending_stress",
    camera: Annotated[str, typer.Option(help="oblique, front or above.")] = "oblique",
    theme: Annotated[str, typer.Option(help="light or dark; of a page also auto.")] = "light",
    layout: Annotated[str, typer.Option(help="Of several histories: side-by-side or overlay.")] = "side-by-side",
    names: Annotated[
        list[str] | None,
        typer.Option("--name", help="What a history is called; repeatable."),
    ] = None,
    magnify: Annotated[
        float | None,
        typer.Option(
            "--magnify-difference",
            help="Draw the second history so far from the first.",
        ),
    ] = None,
    bare: Annotated[bool, typer.Option("--bare", help="No charts, inset, ghosts, trace.")] = False,
) -> None:
    """Draw a still, a strip, a film or an interactive page from histories, as the suffix of --out says.

    A page (.html) takes --deformation and --theme alone.
    """
    from renders.command import parse_size, render_command
    from renders.frame import Style

    pixels, note = parse_size(size or ("1000x250" if strip else "1280x720"))
    if note:
        _say(note)
    shown = not bare
    style = Style(
        size=pixels,
        theme=cast(Any, theme),
        camera=cast(Any, camera),
        quantity=cast(Any, colour),
        deformation=deformation,
        charts=shown,
        inset=shown,
        ghosts=shown,
        trace=shown,
        layout="overlay" if magnify is not None else cast(Any, layout),
    )
    for line in render_command(
        histories,
        out,
        style,
        given=_typed(context),
        times=times or (),
        event=event,
        strip=strip,
        fps=fps,
        speed=speed,
        contact_speed=contact_speed,
        between=_pair("--between", between),
        frames=frames,
        names=names or (),
        magnify_difference=magnify,
    ):
        _print(line)


def _typed(context: typer.Context) -> list[str]:
    """Options of a command that were given, but for --out."""
    return [
        parameter.opts[0]
        for parameter in context.command.params
        if parameter.name not in ("histories", "out")
        and getattr(context.get_parameter_source(str(parameter.name)), "name", "") == "COMMANDLINE"
    ]


@app.command()
def export(
    history: Annotated[Path, typer.Argument(help="A run folder, or the history.nc in one.")],
    out: Annotated[Path, typer.Option("--out", help="The file; its suffix is appended if it has none.")],
    format: Annotated[
        str | None, typer.Option("--format", help="vtkhdf, pvd or xdmf; default: as the suffix of --out says.")
    ] = None,
    every: Annotated[
        int | None,
        typer.Option(
            "--every", metavar="N", help="Every N-th sample and all events; default: about 1000 and them."
        ),
    ] = None,
    all_samples: Annotated[bool, typer.Option("--all", help="Every sample.")] = False,
    between: Annotated[
        str | None, typer.Option("--between", metavar="T0,T1", help="Only this span of time (s).")
    ] = None,
    around_events: Annotated[
        float | None, typer.Option("--around-events", metavar="SECONDS", help="Only so close to an event.")
    ] = None,
    deformation: Annotated[
        float, typer.Option("--deformation", metavar="FACTOR", help="Magnify the bending; 1: true shapes.")
    ] = 1.0,
) -> None:
    """Write a history as a time series for ParaView: VTKHDF, PVD with .vtp files, or XDMF with an .h5 file."""
    from renders.exports.command import export_command
    from renders.exports.selection import Selection

    if all_samples and every is not None:
        raise InputError("--all and --every: one of the two at a time")
    selection = Selection(1 if all_samples else every, _pair("--between", between), around_events)
    for line in export_command(history, out, format, selection, deformation):
        _print(line)


def _load(source: str, changes: list[str] | None) -> Scenario:
    from oblique_impact.scenario.scenario import Scenario

    return Scenario.load(source, changes)


def _speeds(text: str) -> list[float]:
    import math

    try:
        rates = [float(part) for part in text.split(",")]
    except ValueError:
        rates = [math.nan]
    if not all(math.isfinite(rate) and abs(rate) <= 1e9 for rate in rates):
        raise InputError(f"--speeds {text}: should be finite numbers in rad/s, separated by commas")
    return rates


def _pair(option: str, text: str | None) -> tuple[float, float] | None:
    """Two numbers separated by a comma."""
    if text is None:
        return None
    try:
        first, second = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"{option} {text}: should be two numbers separated by a comma") from None
    return first, second


def _simulate(scenario: Scenario) -> History:
    from xarray import DataArray

    from oblique_impact.command_line.progress import progress_bar
    from oblique_impact.marching.loop import Status
    from oblique_impact.simulation import simulate

    # xarray looks for array libraries when it makes its first array: an interrupted run should not wait for that
    DataArray(0.0)
    with progress_bar() as show:

        def proceed(status: Status) -> None:
            interrupts.keep()
            show(status)
            interrupts.check()

        try:
            return simulate(scenario, proceed)
        except Interrupted as stopped:
            return cast("History", stopped.history)


def _save(history: History, out: Path) -> Path:
    """Write the results, elsewhere if the disk is full by now: what is computed is not thrown away."""
    from tempfile import mkdtemp

    interrupts.keep()
    try:
        return history.save(out)
    except InputError as error:
        try:
            elsewhere = mkdtemp(prefix="oblique-impact-")
            history.save(elsewhere)
        except (InputError, OSError):
            raise error from None
        raise InputError(f"{error}; the results are in {elsewhere}") from None


def _print_summary(history: History, folder: Path, replaced: bool, said: Sequence[str] = ()) -> None:
    """Print what a run was like; warnings that were `said` before it are not repeated."""
    summary, energy = history.summary, history.summary["energy"]
    _print(f"{summary['outcome']}: t = {summary['end_time']:.6g} s, {summary['events']} events")
    for number, m in enumerate(summary["macro_collisions"], start=1):
        _print(
            f"  collision {number}: {m['start']:.6f} to {m['end']:.6f} s, {m['contacts']} contacts "
            f"(gap < {history.macro_gap:.2g} s), "
            f"{m['normal_impulse']:.5g} N s, peak {m['peak_force']:.4g} N"
        )
    losses = ", ".join(
        f"{name} {energy[f'lost_{name}']:.4g}" for name in ("impact", "friction", "damping", "scheme")
    )
    _print(f"  energy: {energy['initial']:.6g} -> {energy['final']:.6g} J")
    _print(f"  lost: {losses} J")
    _print(f"  unaccounted: {energy['unaccounted']:.2e} J; {summary['steps']} steps, {summary['wall_time']:.2f} s")
    for warning in (words for words in summary.get("warnings", []) if words not in said):
        _print(f"  warning: {warning}")
    _print(f"  results: {folder}{' (those of an earlier run were replaced)' if replaced else ''}")


def _print_modes(found: Frequencies) -> None:
    for direction, table in (("flapwise", found.flapwise), ("chordwise", found.chordwise)):
        _print(f"{direction} (rad/s)")
        for rate, row in zip(found.speeds, table, strict=True):
            _print(f"  at {rate:10.4g} rad/s: " + " ".join(f"{value:14.6f}" for value in row))


def _print(line: str) -> None:
    """Write a result to standard output; on a terminal it is broken between words, not within them."""
    if sys.stdout.isatty():
        width = shutil.get_terminal_size().columns - 1
        line = textwrap.fill(
            line, max(width, 20), subsequent_indent="    ", break_long_words=False, break_on_hyphens=False
        )
    typer.echo(line)


def _say(line: str) -> None:
    """Write one line to standard error."""
    typer.echo(f"oblique-impact: {line}", err=True)


def main(arguments: list[str] | None = None) -> None:
    """Entry point: exit 0 done, 1 stopped by the physics, 2 bad input, 130 interrupted."""
    given = sys.argv[1:] if arguments is None else arguments
    try:
        with interrupts.interruptible(_say):
            code = _call(given or ["--help"])
    except KeyboardInterrupt as stop:
        _say(": ".join(["interrupted", *map(str, stop.args)]))
        code = interrupts.EXIT_CODE
    sys.exit(code)


def _call(arguments: list[str]) -> int:
    """Run a command and return its exit code; what is wrong with the input is said in one line."""
    try:
        # not through typer's own main: it swallows interrupts
        command = typer.main.get_command(app)
        with command.make_context("oblique-impact", arguments) as context:
            command.invoke(context)
        sys.stdout.flush()
    except typer.Exit as stop:
        return stop.exit_code
    except BrokenPipeError:
        # whoever read the output has gone; nothing more can be said there, not even at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return 1
    except InputError as error:
        _say(str(error))
    except MemoryError as error:
        _say(f"not enough memory: {' '.join(str(error).split()) or 'a smaller model or fewer samples are needed'}")
    except Exception as error:
        # typer's usage errors have no public base class; they all know how to say what is wrong
        if not hasattr(error, "format_message"):
            raise
        _say(" ".join(error.format_message().split()))
    else:
        return 0
    return 2


if __name__ == "__main__":
    main()
