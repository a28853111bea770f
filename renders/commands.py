"""The commands `render` and `export`: words in, one typed call, lines out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, cast

import typer

from oblique_impact.command_line.words import print_line, print_note
from oblique_impact.errors import InputError


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
        print_note(note)
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
        print_line(line)


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
        print_line(line)


def _typed(context: typer.Context) -> list[str]:
    """Options of a command that were given, but for --out."""
    return [
        parameter.opts[0]
        for parameter in context.command.params
        if parameter.name not in ("histories", "out")
        and getattr(context.get_parameter_source(str(parameter.name)), "name", "") == "COMMANDLINE"
    ]


def _pair(option: str, text: str | None) -> tuple[float, float] | None:
    """Two numbers separated by a comma."""
    if text is None:
        return None
    try:
        first, second = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"{option} {text}: should be two numbers separated by a comma") from None
    return first, second
