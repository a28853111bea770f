"""The commands `render` and `export`: words in, one typed call, lines out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from typer import Option

from oblique_impact.command_line.console import JsonOption, print_note, print_result
from oblique_impact.errors import InputError

Histories = Annotated[list[Path], typer.Argument(metavar="HISTORY", help="Run folders or history.nc files.")]
Times = Annotated[list[float] | None, Option("--time", help="Stills, strips: time (s); of a strip repeatable.")]
Strip = Annotated[bool, Option("--strip", help="Strips: instead of a still, one row for each time.")]
Between = Annotated[str | None, Option(metavar="T0,T1", help="Films: part of the run (s).")]
Preset = Annotated[str, Option(help="talk, paper or social; other options hold instead of its own.")]
Title = Annotated[str | None, Option(help="The title; default: the name of the run.")]
Seconds = Annotated[float | None, Option(help="Films: so long, if no speed is given; default 20.")]
Letters = Annotated[float | None, Option(help="Size of text (points); default 10.")]
Dpi = Annotated[float | None, Option(help="Pixels per inch; default: the picture fills a slide.")]
ContactSpeed = Annotated[float | None, Option(help="Films: the same in contact, e.g. 0.001.")]
LayoutName = Annotated[str, Option(help="Of several histories: side-by-side or overlay.")]
Names = Annotated[list[str] | None, Option("--name", help="What a history is called; repeatable.")]
Magnify = Annotated[
    float | None, Option("--magnify-difference", help="Draw the second history so far from the first.")
]
Format = Annotated[str | None, Option("--format", help="pvd, xdmf or csv; default: as the suffix of --out says.")]
Every = Annotated[
    int | None, Option(metavar="N", help="Every N-th sample and all events; default: about 1000 and them.")
]
Near = Annotated[float | None, Option(metavar="SECONDS", help="Only so close to an event.")]


def render(
    histories: Histories,
    out: Annotated[Path, Option(help="FILE.png, .mp4, .gif, .svg, .pdf or .html.")] = Path("out/film.mp4"),
    times: Times = None,
    event: Annotated[int | None, Option(help="Stills: at an event, by its number from 1.")] = None,
    strip: Strip = False,
    preset: Preset = "",
    title: Title = None,
    size: Annotated[str, Option(help="WIDTHxHEIGHT in pixels; of one row of a strip.")] = "",
    fps: Annotated[int | None, Option(help="Films: frames per second; default 30.")] = None,
    speed: Annotated[float | None, Option(help="Films: physical over film time in flight.")] = None,
    contact_speed: ContactSpeed = None,
    seconds: Seconds = None,
    between: Between = None,
    frames: Annotated[int | None, Option(help="Films: exactly so many frames.")] = None,
    deformation: Annotated[float | None, Option(help="Deformation factor; default: chosen.")] = None,
    colour: Annotated[str, Option(help="The result in colour.")] = "bending_stress",
    camera: Annotated[str, Option(help="oblique, front or above.")] = "oblique",
    theme: Annotated[str | None, Option(help="light, dark or print; of a page light, dark or auto.")] = None,
    letters: Letters = None,
    dpi: Dpi = None,
    layout: LayoutName = "side-by-side",
    names: Names = None,
    magnify: Magnify = None,
    bare: Annotated[bool, Option("--bare", help="Nothing but beam, slope and pin.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Draw a still, a strip, a film, charts or an interactive page from histories, as the suffix of --out says.

    A page takes --deformation, --theme, --colour, --name, --title; charts --theme, --title, --name, --preset.
    """
    from oblique_impact.renders.command import parse_size, render_command
    from oblique_impact.renders.style import BARE, Style

    look: dict[str, Any] = {"theme": theme, "letters": letters, "dpi": dpi, "title": title}
    look = {name: value for name, value in look.items() if value is not None}
    look |= {"camera": camera, "quantity": colour, "deformation": deformation}
    if size or strip:
        look["size"], note = parse_size(size or "1000x250")
        if note:
            print_note(note)
    if bare:
        look |= BARE | ({"title": title} if title is not None else {})
    look["layout"] = "overlay" if magnify is not None else layout
    style = Style.of(preset, **look) if preset else Style(**look)
    options: dict[str, Any] = {"times": times or (), "event": event, "strip": strip, "names": names or ()}
    options |= {"fps": fps, "speed": speed, "contact_speed": contact_speed, "frames": frames}
    options |= {"seconds": seconds, "between": _pair("--between", between), "magnify_difference": magnify}
    print_result(*render_command(histories, out, style, **options), as_json)


def export(
    history: Annotated[Path, typer.Argument(help="A run folder, or the history.nc in one.")],
    out: Annotated[Path, Option(help="The file; its suffix is appended if it has none.")],
    format: Format = None,
    every: Every = None,
    all_samples: Annotated[bool, Option("--all", help="Every sample.")] = False,
    between: Annotated[str | None, Option(metavar="T0,T1", help="Only this span of time (s).")] = None,
    around_events: Near = None,
    deformation: Annotated[float, Option(metavar="FACTOR", help="Magnify the bending; 1: true shapes.")] = 1.0,
    as_json: JsonOption = False,
) -> None:
    """Write a history as a time series: PVD with .vtp files or XDMF with an .h5 file, or as a table (CSV)."""
    from oblique_impact.renders.exports.command import export_command
    from oblique_impact.renders.exports.selection import Selection

    if all_samples and every is not None:
        raise InputError("--all and --every: one of the two at a time")
    selection = Selection(1 if all_samples else every, _pair("--between", between), around_events)
    print_result(*export_command(history, out, format, selection, deformation), as_json)


def _pair(option: str, text: str | None) -> tuple[float, float] | None:
    """Two numbers separated by a comma."""
    if text is None:
        return None
    try:
        first, second = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"{option} {text}: should be two numbers separated by a comma") from None
    return first, second
