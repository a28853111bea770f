"""What `oblique-impact render` does: read histories, choose the kind of picture by the suffix, draw, tell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from oblique_impact.errors import InputError
from oblique_impact.history import History
from renders.difference import magnify_difference
from renders.film import FILMS, write_film, write_still, write_strip
from renders.frame import Style
from renders.geometry import BeamGeometry
from renders.timeline import FPS, make_timeline

_SUFFIXES = (".png", *FILMS, ".html")


@dataclass(frozen=True)
class Request:
    """Options of the command that are not of the style."""

    times: tuple[float, ...] = ()
    event: int | None = None
    strip: bool = False
    fps: int = FPS
    speed: float | None = None
    contact_speed: float | None = None
    between: tuple[float, float] | None = None
    frames: int | None = None
    names: tuple[str, ...] = ()
    magnify: float | None = None


def parse_size(text: str) -> tuple[tuple[int, int], str]:
    """Return WIDTHxHEIGHT in pixels, rounded up to even numbers, and what was rounded in words (or nothing).

    Raises InputError with one line for anything else.
    """
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.isdigit() and len(part) <= 5 for part in parts):
        raise InputError(f"--size {text}: should be WIDTHxHEIGHT in pixels, e.g. 1280x720")
    width, height = (int(part) for part in parts)
    even = width + width % 2, height + height % 2
    note = (
        "" if even == (width, height) else f"size {text} rounded to {even[0]}x{even[1]}: films need even numbers"
    )
    return even, note


def render(paths: Sequence[Path], out: Path, style: Style, request: Request) -> list[str]:
    """Draw what `out` asks for by its suffix; returns the lines to print.

    Raises InputError with one line for bad input.
    """
    suffix = out.suffix.lower()
    if suffix not in _SUFFIXES:
        raise InputError(f"--out {out}: should end with {', '.join(_SUFFIXES)}")
    histories = [History.load(path) for path in paths]
    names = _names(paths, histories, request.names)
    # runs that blew up hold numbers of any size
    with np.errstate(over="ignore", invalid="ignore"):
        return _draw(histories, names, out, style, request)


def _draw(histories: list[History], names: list[str], out: Path, style: Style, request: Request) -> list[str]:
    suffix = out.suffix.lower()
    if request.magnify is not None:
        histories, names = _magnified(histories, names, request.magnify)
    lines = [_factor(histories, style)]
    if suffix == ".html":
        if len(histories) > 1:
            raise InputError(f"HISTORY: {len(histories)} given: a page shows one")
        from renders.player import write_player

        write_player(histories[0], out, factor=style.deformation, theme=style.theme)
    elif suffix == ".png" and request.strip:
        write_strip(histories, names, style, request.times, out)
    elif suffix == ".png":
        write_still(histories, names, style, _instant(histories[0], request), out)
    else:
        lines.append(_film(histories, names, style, request, out))
    return [*lines, f"picture: {out}" if suffix == ".png" else f"written: {out}"]


def _names(paths: Sequence[Path], histories: Sequence[History], given: Sequence[str]) -> list[str]:
    """Names of the histories: as given, or of their folders."""
    if given and len(given) != len(histories):
        raise InputError(f"--name: {len(given)} given for {len(histories)} histories")
    return list(given) or [(path if path.is_dir() else path.parent).resolve().name for path in paths]


def _magnified(histories: list[History], names: list[str], factor: float) -> tuple[list[History], list[str]]:
    if len(histories) != 2:
        raise InputError(f"--magnify-difference: needs two histories, {len(histories)} given")
    second = magnify_difference(histories[0], histories[1], factor)
    return [histories[0], second], [names[0], f"{names[1]}, difference ×{factor:g}"]


def _factor(histories: Sequence[History], style: Style) -> str:
    factor = min(BeamGeometry(history, style.deformation).factor for history in histories)
    return f"deformation factor {factor:g}, about the line from pin to contact point"


def _instant(history: History, request: Request) -> float:
    """Time of a still: as given, that of an event, or that of the largest force."""
    if request.event is not None:
        if not 1 <= request.event <= len(history.events):
            raise InputError(f"--event {request.event}: should be from 1 to {len(history.events)}")
        return history.events[request.event - 1].time
    if len(request.times) > 1:
        raise InputError(f"--time: {len(request.times)} given: a still shows one (or choose --strip)")
    if request.times:
        return request.times[0]
    force = np.nan_to_num(history["lambda_n"].values)
    return float(history["time"].values[int(np.argmax(force))])


def _film(histories: Sequence[History], names: Sequence[str], style: Style, request: Request, out: Path) -> str:
    timeline = make_timeline(
        histories[0], request.fps, request.speed, request.contact_speed, request.between, request.frames
    )
    console = Console(stderr=True)
    columns = (
        TextColumn("frames"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task("frames", total=timeline.times.size)
        write_film(histories, names, style, timeline, out, lambda done, _: bar.update(task, completed=done))
    fastest, slowest = timeline.rates.max(), timeline.rates.min()
    return (
        f"{timeline.times.size} frames of {style.size[0]}x{style.size[1]}, {timeline.duration:.1f} s at "
        f"{timeline.fps} per second; time runs at {fastest:.3g} to {slowest:.3g} of real time"
    )
