"""Pictures as a call, `render`, and as the command `oblique-impact render`: the suffix chooses the kind."""

from __future__ import annotations

import os
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from oblique_impact.command_line.progress_bars import counting_bar
from oblique_impact.errors import InputError
from oblique_impact.history.history import History, require_history
from oblique_impact.progress import OnProgress, Progress, silent
from oblique_impact.renders.difference import magnify_difference as magnified
from oblique_impact.renders.outputs import CHARTS, FILM, PAGE, STILL, STRIP, check_options, kind_of
from oblique_impact.renders.overview import overview_figure
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style
from oblique_impact.renders.timeline import FPS, SECONDS, Timeline, make_timeline
from oblique_impact.renders.title import name_of
from oblique_impact.scenario.scenario import Scenario

#: a run, or where it lies
Source = History | str | os.PathLike[str]
#: of one row of a strip
STRIP_STYLE = Style(size=(1000, 250))
#: what a notebook shows as it is, and how pages name it
_PICTURES = {".png": "png", ".gif": "gif", ".svg": "svg+xml"}


@dataclass(frozen=True)
class Rendered:
    """A picture, a film or a page."""

    file: Path
    factor: float  # by which the bending is magnified
    size: tuple[int, int]  # width and height (pixels) of a still, of a row of a strip, or of a frame
    timeline: Timeline | None = None  # when the frames of a film are

    def _repr_html_(self) -> str:
        """Show a picture in a notebook; films and pages by their names."""
        kind = _PICTURES.get(self.file.suffix.lower())
        if kind is None:
            return f"<code>{escape(str(self.file))}</code>"
        return f'<img src="data:image/{kind};base64,{b64encode(self.file.read_bytes()).decode()}">'


def render(
    histories: Source | Sequence[Source],
    out: str | os.PathLike[str],
    style: Style | None = None,
    *,
    times: Sequence[float] = (),
    event: int | None = None,
    strip: bool = False,
    fps: int | None = None,
    speed: float | None = None,
    contact_speed: float | None = None,
    seconds: float | None = None,
    between: tuple[float, float] | None = None,
    frames: int | None = None,
    names: Sequence[str] = (),
    magnify_difference: float | None = None,
    on_progress: OnProgress = silent,
) -> Rendered:
    """Draw a still, a strip, a film, charts or an interactive page.

    Parameters
    ----------
    histories : History, path, or sequence of them
        One to three, of beams; a path is that of a run folder or the history.nc in it.
    out : path
        The suffix decides: .png a still or a strip; .mp4 or .gif a film; .svg or .pdf charts, as
        :func:`~oblique_impact.renders.overview.overview` draws them; .html a page (of one history).
    style : Style, optional
        Size, theme, camera, colour, deformation factor, title, what is shown; default: 1280 x 720, a row of a
        strip 1000 x 250.  A page takes its theme, title, deformation factor and result in
        colour, charts their theme and title.
        ``Style.of("talk")`` is that of a preset.
    times : sequence of float
        Physical times (s) of the rows of a strip (default: before, through and after the first macro-collision),
        or the one of a still (default: that of the largest contact force).
    event : int, optional
        A still at an event, by its number from 1.
    strip : bool
        A strip: one row for each time.
    fps : int
        Frames per second of a film; default 30.
    speed, contact_speed : float, optional
        Physical over film time in flight and in contact; chosen if not given.
    seconds : float, optional
        How long the film of the whole run lasts (s), if neither speed is given; default 20.
    between : tuple of float, optional
        First and last physical time (s) of a film, which is that part of the film of the whole run.
    frames : int, optional
        Exactly so many frames.
    names : sequence of str
        What the histories are called; default: as their folders.
    magnify_difference : float, optional
        Draw the second of two histories so many times as far from the first one as it is.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` after each frame of a film.

    Returns
    -------
    Rendered
        The file, the deformation factor, and the timeline of a film.

    Raises
    ------
    InputError
        In one line, for values out of range, an argument that does not apply to what is
        drawn, histories without a beam, a file that cannot be written, or a system without
        libEGL and libOSMesa.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> from renders import Style, render
    >>> history = simulate(Scenario.builtin("paper"))
    >>> render(history, "impact.png", Style(size=(960, 540)), event=1).file  # doctest: +SKIP
    """
    from oblique_impact.renders.film import write_film, write_still, write_strip  # they load PyVista and VTK

    file, kind = Path(out), kind_of(Path(out), strip)
    style = style or (STRIP_STYLE if kind == STRIP else Style())
    options: dict[str, Any] = {"times": list(times), "event": event, "strip": strip, "fps": fps, "speed": speed}
    options |= {"contact_speed": contact_speed, "seconds": seconds, "between": between, "frames": frames}
    check_options(file, kind, options | {"magnify_difference": magnify_difference})
    if isinstance(histories, History | str | os.PathLike) or not isinstance(histories, Sequence):
        sources: list[Source] = [histories]
    else:
        sources = list(histories)
    called = list(names) or [_name(source, number, sources) for number, source in enumerate(sources, start=1)]
    # runs that blew up hold numbers of any size
    with np.errstate(over="ignore", invalid="ignore"):
        several = _checked(sources, called, kind, magnify_difference)
        story = story_of(
            several,
            style,
            called,
            speed,
            contact_speed,
            seconds=(SECONDS if seconds is None else seconds) if kind == FILM else None,
            difference=magnify_difference or 1.0,
        )
        timeline = None
        if kind == FILM:
            if any(pixels % 2 for pixels in style.size):
                raise InputError("--size {}x{}: films need even numbers".format(*style.size))
            timeline = make_timeline(story.time_map, FPS if fps is None else fps, between, frames)
            write_film(story, timeline, file, lambda done, of: on_progress(Progress(done, of)))
        elif kind == PAGE:
            if style.theme == "print":
                raise InputError("--theme print: of a page should be one of light, dark, auto")
            from oblique_impact.renders.player import write_player

            write_player(story, file)
        elif kind == STRIP:
            write_strip(story, times, file)
        elif kind == CHARTS:
            overview_figure(dict(zip(called, several, strict=True)), file, style.colours, story.heading)
        else:
            write_still(story, _instant(several[0], times, event), file)
    return Rendered(file, story.factor, style.size, timeline)


def _name(source: Source, number: int, sources: Sequence[Source]) -> str:
    """Return what a run is called: as its folder; a single one without, as the built-in case that it is of."""
    if not isinstance(source, str | os.PathLike):
        if not isinstance(source, History):
            return ""
        return name_of(Scenario.from_toml(source.scenario_toml)) if len(sources) == 1 else f"history {number}"
    path = Path(source)
    return (path if path.is_dir() else path.parent).resolve().name


def _checked(sources: list[Source], called: list[str], kind: str, magnify: float | None) -> list[History]:
    """Return what is drawn; raises InputError for what does not fit together."""
    histories = [History.load(source) if isinstance(source, str | os.PathLike) else source for source in sources]
    if not histories:
        raise InputError("HISTORY: none given: should be one, two or three")
    for history in histories:
        require_history(history, "render")
        if "uy" in history and not np.isfinite(history["uy"].values).all(axis=1).any():
            raise InputError("HISTORY: no sample has a finite shape")
    count = len(histories)
    if kind == PAGE and count > 1:
        raise InputError(f"HISTORY: {count} given: a page shows one")
    if len(called) != count:
        raise InputError(f"--name: {len(called)} given for {count} histories")
    if magnify is not None:
        if count != 2:
            raise InputError(f"--magnify-difference: needs two histories, {count} given")
        histories = [histories[0], magnified(histories[0], histories[1], magnify)]
    return histories


def render_command(
    paths: Sequence[Path], out: Path, style: Style, **options: Any
) -> tuple[list[str], dict[str, Any]]:
    """Call `render` with a progress bar; returns the lines to print, and the same as data.  Raises InputError."""
    kind = kind_of(out, options["strip"])
    with counting_bar("film" if kind == FILM else "picture") as show:
        result = render(paths, out, style, on_progress=show, **options)
    lines = (
        []
        if kind == CHARTS
        else [f"deformation factor {result.factor:g}, about the line from pin to contact point"]
    )
    data: dict[str, Any] = {"file": result.file, "factor": result.factor, "size": result.size}
    if (film := result.timeline) is not None:
        count = film.times.size
        lines.append(
            f"{count} frames of {result.size[0]}x{result.size[1]}, {film.duration:.1f} s at "
            f"{film.fps} per second; time runs at {film.rates.max():.3g} to {film.rates.min():.3g} of real time"
        )
        data |= {"frames": count, "fps": film.fps, "duration": film.duration}
    return [*lines, f"picture: {out}" if kind in (STILL, STRIP) else f"written: {out}"], data


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


def _instant(history: History, times: Sequence[float], event: int | None) -> float:
    """Time of a still: as given, that of an event, or that of the largest force."""
    if event is not None:
        if not 1 <= event <= len(history.events):
            raise InputError(f"--event {event}: should be from 1 to {len(history.events)}")
        return history.events[event - 1].time
    if len(times) > 1:
        raise InputError(f"--time: {len(times)} given: a still shows one (or choose --strip)")
    if len(times):
        return float(times[0])
    force = np.nan_to_num(history["lambda_n"].values)
    return float(history["time"].values[int(np.argmax(force))])
