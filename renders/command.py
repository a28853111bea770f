"""Draw histories: the call `render`; the suffix of the file chooses the kind of picture."""

from __future__ import annotations

import os
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from oblique_impact.errors import InputError
from oblique_impact.files import writing_file
from oblique_impact.history.history import History, require_history
from oblique_impact.progress import OnProgress, Progress, silent
from oblique_impact.renders.overview import save_overview
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style, require_plain
from oblique_impact.renders.timeline import FPS, Timeline, make_timeline
from oblique_impact.renders.title import name_of

#: a run, or where it lies
Source = History | str | os.PathLike[str]
FILMS, CHARTS = (".mp4", ".gif"), (".svg", ".pdf")
SECONDS = 20.0  # of a film, if not told otherwise
SUFFIXES = (".png", *CHARTS, *FILMS, ".html")
#: what a notebook shows as it is, and how pages name it
_PICTURES = {".png": "png", ".gif": "gif", ".svg": "svg+xml"}


@dataclass(frozen=True)
class Rendered:
    """A picture, a film or a page."""

    file: Path
    factor: float  # by which the bending is magnified
    size: tuple[int, int]  # width and height (pixels) of a still or a frame
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
    time: float | None = None,
    event: int | None = None,
    fps: int = FPS,
    speed: float | None = None,
    contact_speed: float | None = None,
    seconds: float | None = None,
    between: tuple[float, float] | None = None,
    frames: int | None = None,
    names: Sequence[str] = (),
    on_progress: OnProgress = silent,
) -> Rendered:
    """Draw a still, a film, charts or an interactive page.

    Parameters
    ----------
    histories : History, path, or sequence of them
        One to three, of beams; a path is that of a run folder or the history.nc in it.
    out : path
        The suffix decides: .png a still; .mp4 or .gif a film; .svg or .pdf charts, as
        :func:`~oblique_impact.renders.overview.overview` draws them; .html a page.
    style : Style, optional
        Size, theme, camera, colour, deformation factor, title, what is shown; default: 1280 x 720.  A page takes
        its theme, title, deformation factor and result in colour, charts their theme and title.
        ``Style.of("talk")`` is that of a preset.
    time : float, optional
        The physical time (s) of a still; default: that of the largest contact force, without one of the largest
        deflection.
    event : int, optional
        A still at an event, by its number from 1.
    fps : int
        Frames per second of a film.
    speed, contact_speed : float, optional
        Physical over film time in flight and in contact; chosen if not given.
    seconds : float, optional
        How long the film lasts (s), if neither speed is given; default: 20.
    between : tuple of float, optional
        First and last physical time (s) of a film, which is that part of the film of the whole run.
    frames : int, optional
        Exactly so many frames.
    names : sequence of str
        What the histories are called; default: as their folders.
    on_progress : callable, optional
        Called with a :class:`~oblique_impact.progress.Progress` after each frame of a film.

    Returns
    -------
    Rendered
        The file, the deformation factor, and the timeline of a film.

    Raises
    ------
    InputError
        In one line, for values out of range, histories without a beam, a file that cannot be written, or a system
        without libEGL and libOSMesa.

    Examples
    --------
    >>> from oblique_impact import Scenario, simulate
    >>> from oblique_impact.renders import Style, render
    >>> history = simulate(Scenario.builtin("paper"))
    >>> render(history, "impact.png", Style(size=(960, 540)), event=1).file  # doctest: +SKIP
    """
    from oblique_impact.renders.film import write_film, write_still  # they load PyVista and VTK
    from oblique_impact.renders.player import write_player

    file = Path(out)
    suffix = file.suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"--out {out}: should end with {', '.join(SUFFIXES)}")
    style = style or Style()
    single = isinstance(histories, str | os.PathLike) or not isinstance(histories, Sequence)
    sources: list[Any] = [histories] if single else list(histories)  # type: ignore[arg-type]
    called = list(names) or [_name(source, number, len(sources)) for number, source in enumerate(sources, start=1)]
    if len(called) != len(sources):
        raise InputError(f"--name: {len(called)} given for {len(sources)} histories")
    for name in called:
        require_plain("--name", name)
    runs = [_loaded(source) for source in sources]
    timeline = None
    if suffix in FILMS and any(pixels % 2 for pixels in style.size):
        raise InputError("--size {}x{}: films need even numbers".format(*style.size))
    # runs that blew up hold numbers of any size
    with writing_file(file), np.errstate(over="ignore", invalid="ignore"):
        long = SECONDS if seconds is None and suffix in FILMS else seconds
        story = story_of(runs, style, called, speed, contact_speed, long)
        if suffix in FILMS:
            if long and not (frames or speed or contact_speed) and (seconds or not between):
                frames = max(2, round(long * fps))
            timeline = make_timeline(story.time_map, fps, between, frames)
            write_film(story, timeline, file, lambda done, of: on_progress(Progress(done, of)))
        elif suffix in CHARTS:
            save_overview(story, file)
        elif suffix == ".html":
            write_player(story, file)
        else:
            write_still(story, _instant(runs[0], time, event), file)
    return Rendered(file, story.factor, style.size, timeline)


def _name(source: Source, number: int, count: int) -> str:
    """Return what a run is called: as its folder, a single one as the built-in case that it is of."""
    if isinstance(source, str | os.PathLike):
        path = Path(source)
        return (path if path.is_dir() else path.parent).resolve().name
    if count == 1 and isinstance(source, History) and source.scenario is not None:
        return name_of(source.scenario)
    return f"history {number}"


def _loaded(source: Source) -> History:
    """Return a history that can be drawn; raises InputError."""
    history = History.load(source) if isinstance(source, str | os.PathLike) else source
    require_history(history, "render")
    shapes = [history[name].values for name in ("theta", "ux", "uy") if name in history]
    if shapes and not np.all([np.isfinite(v.reshape(len(v), -1)).all(axis=1) for v in shapes], axis=0).any():
        raise InputError("HISTORY: no sample has a finite shape")
    return history


def _instant(history: History, time: float | None, event: int | None) -> float:
    """Return the time (s) of a still: as given, of an event, or of the largest force or else deflection."""
    if event is not None:
        if not 1 <= event <= len(history.events):
            raise InputError(f"--event {event}: should be from 1 to {len(history.events)}")
        return history.events[event - 1].time
    if time is not None:
        return time
    force, deflection = (np.nan_to_num(history[name].values) for name in ("lambda_n", "deflection"))
    return float(history["time"].values[int(np.argmax(force if force.any() else np.abs(deflection)))])
