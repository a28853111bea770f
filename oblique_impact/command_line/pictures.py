"""The commands `render` and `export`."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, cast

import typer
from typer import Option

from oblique_impact.command_line.console import JsonOption, print_result
from oblique_impact.command_line.progress_bars import counting_bar
from oblique_impact.errors import InputError

Histories = Annotated[list[Path], typer.Argument(metavar="HISTORY", help="Run folders or history.nc files.")]
Time = Annotated[float | None, Option(help="Stills: time (s).")]
Event = Annotated[int | None, Option(help="Stills: at an event, by its number from 1.")]
Between = Annotated[str | None, Option(metavar="T0,T1", help="Films: part of the run (s).")]
Preset = Annotated[str, Option(help="talk or paper; other options hold instead of its own.")]
Title = Annotated[str | None, Option(help="The title; default: the name of the run.")]
Size = Annotated[str, Option(help="WIDTHxHEIGHT in pixels, of films even.")]
Fps = Annotated[int, Option(help="Films: frames per second.")]
Speed = Annotated[float | None, Option(help="Films: physical over film time in flight.")]
ContactSpeed = Annotated[float | None, Option(help="Films: the same in contact, e.g. 0.001.")]
Seconds = Annotated[float | None, Option(help="Films: so long (s), if no speed is given; default 20.")]
Frames = Annotated[int | None, Option(help="Films: exactly so many frames.")]
Deformation = Annotated[float | None, Option(help="Deformation factor; default: chosen.")]
Camera = Annotated[str, Option(help="oblique, front or above.")]
ThemeOption = Annotated[
    str | None, Option("--theme", help="light, dark or print; of a page light, dark or auto (default).")
]
Letters = Annotated[float | None, Option(help="Size of text (points); default 10.")]
Dpi = Annotated[float | None, Option(help="Pixels per inch; default: the picture fills a slide.")]
LayoutName = Annotated[str, Option(help="Of several histories: side-by-side or overlay.")]
Names = Annotated[list[str] | None, Option("--name", help="What a history is called; repeatable.")]
Format = Annotated[str | None, Option("--format", help="pvd, xdmf or csv; default: as the suffix of --out says.")]
Every = Annotated[
    int | None,
    Option(metavar="N", help="Every N-th sample and all events, 1: all; default: about 1000 and events."),
]


def render(
    histories: Histories,
    out: Annotated[Path, Option(help="FILE.png, .mp4, .gif, .svg, .pdf or .html.")] = Path("out/film.mp4"),
    time: Time = None,
    event: Event = None,
    preset: Preset = "",
    title: Title = None,
    size: Size = "",
    fps: Fps = 30,
    speed: Speed = None,
    contact_speed: ContactSpeed = None,
    seconds: Seconds = None,
    between: Between = None,
    frames: Frames = None,
    deformation: Deformation = None,
    colour: Annotated[str, Option(help="The result in colour.")] = "bending_stress",
    camera: Camera = "oblique",
    theme: ThemeOption = None,
    letters: Letters = None,
    dpi: Dpi = None,
    layout: LayoutName = "side-by-side",
    names: Names = None,
    bare: Annotated[bool, Option("--bare", help="Nothing but beam, slope and pin.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Draw a still, a film, charts or an interactive page from histories, as the suffix of --out says.

    A page takes --deformation, --theme, --colour, --name, --title; charts --theme, --title, --name, --preset.
    """
    from oblique_impact.renders.command import CHARTS, FILMS
    from oblique_impact.renders.command import render as draw
    from oblique_impact.renders.style import BARE, Style

    look: dict[str, Any] = dict(BARE) if bare else {}
    look |= {"camera": camera, "quantity": colour, "deformation": deformation, "layout": layout}
    given = {"theme": theme, "letters": letters, "dpi": dpi, "title": title}
    look |= {name: value for name, value in given.items() if value is not None}
    if size:
        look["size"] = _size(size)
    with counting_bar("film" if out.suffix.lower() in FILMS else "picture") as show:
        result = draw(
            histories,
            out,
            Style.of(preset, **look) if preset else Style(**look),
            time=time,
            event=event,
            fps=fps,
            speed=speed,
            contact_speed=contact_speed,
            seconds=seconds,
            between=_pair("--between", between),
            frames=frames,
            names=names or (),
            on_progress=show,
        )
    lines: list[str] = []
    data: dict[str, Any] = {"file": result.file, "factor": result.factor, "size": result.size}
    if out.suffix.lower() not in CHARTS:
        about = "" if result.factor == 1.0 else ", about the line from root to contact point"
        lines.append(f"deformation factor {result.factor:g}{about}")
    if (film := result.timeline) is not None:
        count = film.times.size
        lines.append(
            f"{count} frames of {result.size[0]}x{result.size[1]}, {film.duration:.1f} s at "
            f"{film.fps} per second; time runs at {film.rates.max():.3g} to {film.rates.min():.3g} of real time"
        )
        data |= {"frames": count, "fps": film.fps, "duration": film.duration}
    print_result([*lines, f"written: {out}"], data, as_json)


def export(
    history: Annotated[Path, typer.Argument(help="A run folder, or the history.nc in one.")],
    out: Annotated[Path, Option(help="The file; its suffix is appended if it has none.")],
    format: Format = None,
    every: Every = None,
    between: Annotated[str | None, Option(metavar="T0,T1", help="Part of the run (s).")] = None,
    deformation: Annotated[float, Option(metavar="FACTOR", help="Magnify the bending; 1: true shapes.")] = 1.0,
    as_json: JsonOption = False,
) -> None:
    """Write a history as a time series: PVD with .vtp files or XDMF with an .h5 file, or as a table (CSV)."""
    from oblique_impact.history.history import History
    from oblique_impact.renders.exports import READERS
    from oblique_impact.renders.exports import export as write

    span = _pair("--between", between)
    kind = cast(Any, format)  # a wrong one is refused with the list of those that are allowed
    with counting_bar("export") as show:
        run = History.load(history)
        done = write(
            run,
            out,
            format=kind,
            every=every,
            between=span,
            deformation=deformation,
            on_progress=show,
        )
    lines = [
        f"{done.samples} of {done.of} samples, {done.span[0]:g} to {done.span[1]:g} s",
        f"  {done.format}: {done.file}",
        f"  read by {READERS[done.format]}",
    ]
    if done.format != "csv":
        lines[0] += f"; deformation factor {done.factor:g}"
    warnings = run.summary.get("warnings", [])
    lines += [f"  warning: {text}" for text in warnings]
    print_result(lines, asdict(done) | {"warnings": warnings}, as_json)


def _size(text: str) -> tuple[int, int]:
    """Return WIDTHxHEIGHT in pixels."""
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.isdigit() and len(part) <= 5 for part in parts):
        raise InputError(f"--size {text}: should be WIDTHxHEIGHT in pixels, e.g. 1280x720")
    return int(parts[0]), int(parts[1])


def _pair(option: str, text: str | None) -> tuple[float, float] | None:
    """Return two numbers separated by a comma."""
    if text is None:
        return None
    try:
        first, second = (float(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"{option} {text}: should be two numbers separated by a comma") from None
    return first, second
