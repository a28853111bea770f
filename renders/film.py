"""Stills, strips and films of histories, as files that appear whole or not at all."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import replace
from io import BytesIO
from itertools import chain
from pathlib import Path
from subprocess import DEVNULL, PIPE
from tempfile import TemporaryFile
from typing import Any

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from oblique_impact.contact.state import State
from oblique_impact.errors import InputError
from oblique_impact.files import save_whole
from oblique_impact.history.history import History
from oblique_impact.renders.files import comment
from oblique_impact.renders.frame import Composer
from oblique_impact.renders.scene import Panel, Scene
from oblique_impact.renders.sheet import LINE, SMALL, STATE, Sheet
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import SLIDE, figure_style
from oblique_impact.renders.timeline import Timeline

_ROWS = 5  # of a strip
_LETTERS = 26  # so many of its rows have a letter
GIF_FPS = 50

OnFrame = Callable[[int, int], None]
Pixels = NDArray[np.uint8]


def write_still(story: Story, time: float, out: Path) -> Path:
    """Write one picture at a physical time (s).

    Raises InputError for a time outside of the run or a file that cannot be written.
    """
    _check_times(story, [time])
    with Composer(story) as composer:
        return _save(composer.draw(time), out, story, story.style.resolution)


def write_strip(story: Story, times: Sequence[float], out: Path) -> Path:
    """Write a strip: a row for each physical time (s), by default `strip_times`, with the scales below the last.

    The size of the style is that of a row.  Raises InputError as `write_still` does.
    """
    times = list(times) or strip_times(story.histories[0])
    _check_times(story, times)
    (width, height), geometry = story.style.size, story.geometries[0]
    dpi = story.style.dpi or width / SLIDE[0]
    style = replace(story.style, ghosts=False, trace=False, ground=False, dpi=dpi)
    with figure_style(style.colours):
        row = Sheet((width, height), style)
        unit, margin, small = row.unit, 16.0 * row.unit, 1.45 * row.pixels(SMALL)
        head = round(0.6 * margin + 1.3 * row.pixels(STATE))
        panel = Panel((0, head, width, height - head), list(range(len(story.geometries))))
        scene = Scene(story, [panel], (width, height), style, (min(times), max(times)))
        sheet = Sheet((width, height * len(times) + round(1.3 * row.pixels(LINE) + small + 32.0 * unit)), style)
        for number, time in enumerate(times):
            k = geometry.index(time)
            top, state = number * height, State(int(geometry.value("state", int(k))))
            if number:
                sheet.rule((0.0, top), (width, top))
            letter = f"({chr(ord('a') + number)})  " if number < _LETTERS else ""
            clock = sheet.write(margin, top + 0.6 * margin, f"{letter}t = {time:.5f} s", STATE, weight="bold")
            left = margin + sheet.width_of(clock) + 20.0 * unit
            name = sheet.write(
                left, top + 0.6 * margin, state.name, STATE, style.colours.states[state], weight="bold"
            )
            left += sheet.width_of(name) + 20.0 * unit
            force = geometry.force_text(float(np.linalg.norm(geometry.contact_force(k))))
            notes = [geometry.beside(k), f"contact force {force}" if force and style.arrow else ""]
            if not story.overlay and len(story.geometries) == 1:
                beside = sheet.write(left, top + 0.6 * margin + 0.8 * row.pixels(STATE), "", LINE, va="baseline")
                sheet.fit(beside, [", ".join(filter(None, notes))], width - left - margin)
        low = sheet.size[1] - 10.0 * unit
        if story.magnified:
            note = sheet.write(width - margin, low - small, "", LINE, va="bottom", ha="right")
            sheet.fit(note, story.magnified, 0.68 * width - 250.0 * unit - margin)  # beside the colours
        sheet.scale_bar(margin, low, scene.views[0].scale_bar(0.15 * width))
        if not story.overlay:
            sheet.colour_bar(0.32 * width, low, 220.0 * unit, story.colours)
        whole = sheet.drawn()
    for number, time in enumerate(times):
        whole[number * height + head : (number + 1) * height, :, :3] = scene.draw(time)[head:]
    scene.close()
    return _save(whole[..., :3], out, story, dpi)


def strip_times(history: History) -> list[float]:
    """Return instants that tell the story: before, through and after the first macro-collision."""
    time, force = history["time"].values, np.nan_to_num(history["lambda_n"].values)
    collisions = history.summary["macro_collisions"]
    if not collisions:
        return [float(t) for t in np.linspace(time[0], time[-1], _ROWS)]
    start, end = float(collisions[0]["start"]), float(collisions[0]["end"])
    strongest = time[np.argmax(np.where((time >= start) & (time <= end), force, -np.inf))]
    aside = 2.0 * (end - start) + 5e-3
    times = [start - aside, start, *sorted((strongest, 0.5 * (start + end))), end + aside]
    return [float(np.clip(t, time[0], time[-1])) for t in times]


def write_film(story: Story, timeline: Timeline, out: Path, on_frame: OnFrame | None = None) -> Path:
    """Write a film as .mp4 or .gif, as the suffix of `out` says.

    `on_frame` is called with the number of frames done and their total.  Raises InputError for a file that cannot
    be written, or a GIF of more than 50 frames per second.
    """
    gif = out.suffix.lower() == ".gif"
    if gif and timeline.fps > GIF_FPS:  # of shorter delays players make a tenth of a second
        raise InputError(f"--fps {timeline.fps}: of a GIF should be from 1 to {GIF_FPS}")

    def frames() -> Generator[Pixels]:
        with Composer(story, timeline) as composer:
            for n, (time, rate) in enumerate(zip(timeline.times, timeline.rates, strict=True), start=1):
                yield composer.draw(float(time), float(rate))
                if on_frame:
                    on_frame(n, timeline.times.size)

    def write(part: Path) -> None:
        words = comment(story.histories)
        with closing(frames()) as drawn:
            if gif:
                write_gif(part, drawn, timeline.times.size, timeline.fps, words)
            else:
                write_mp4(part, drawn, timeline.fps, words)

    return save_whole(out, write)


def write_gif(file: Path, frames: Iterator[Pixels], count: int, fps: int, text: str) -> None:
    """Write so many frames (rows, columns, 3) as a GIF with a comment.

    Delays are whole hundredths of a second: frames last as many of them as keep the mean rate.  Raises OSError.
    """
    ends = np.rint(100.0 * np.arange(count + 1) / fps)
    look: dict[str, Any] = {"duration": (10.0 * np.diff(ends)).tolist(), "loop": 0}  # ms
    pictures = (Image.fromarray(frame).quantize() for frame in frames)
    content = BytesIO()
    next(pictures).save(
        content, "GIF", save_all=True, append_images=pictures, comment=text.encode("ascii", "replace"), **look
    )
    file.write_bytes(content.getbuffer())


def write_mp4(file: Path, frames: Iterator[Pixels], fps: int, text: str) -> None:
    """Write frames (rows, columns, 3) as an MP4 file with a comment, through ffmpeg.

    Raises OSError with what it says if it fails.
    """
    first = next(frames)
    size, name = f"{first.shape[1]}x{first.shape[0]}", imageio_ffmpeg.get_ffmpeg_exe()
    given = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", str(fps), "-i", "-"]
    wanted = ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-preset", "veryfast", "-crf", "17"]
    about = ["-movflags", "+faststart", "-metadata", f"comment={text}", "-f", "mp4", str(file)]
    with TemporaryFile() as said:
        # in a session of its own: Ctrl-C at the terminal is for this process, which ends it
        command = [name, "-y", "-v", "error", *given, *wanted, *about]
        ffmpeg = subprocess.Popen(command, stdin=PIPE, stdout=DEVNULL, stderr=said, start_new_session=True)
        assert ffmpeg.stdin is not None
        try:
            with suppress(BrokenPipeError):  # when it has failed, which its exit code tells
                for frame in chain([first], frames):
                    ffmpeg.stdin.write(np.ascontiguousarray(frame).data)
                ffmpeg.stdin.close()
            code = ffmpeg.wait()
        finally:
            ffmpeg.kill()
            with suppress(OSError):
                ffmpeg.stdin.close()
            ffmpeg.wait()
        said.seek(0)
        lines = said.read().decode(errors="replace").splitlines()
        if code or any("rror" in line for line in lines):  # older ones lose the end of a file with exit code 0
            raise OSError(lines[-1].rpartition(": ")[2] if lines else f"ffmpeg ended with code {code}")


def _check_times(story: Story, times: Sequence[float]) -> None:
    first, last = story.geometries[0].times[[0, -1]]
    for time in times:
        if not first <= time <= last:
            raise InputError(f"--time {time:g}: should be from {first:g} to {last:g} s")


def _save(picture: NDArray[np.uint8], out: Path, story: Story, dpi: float) -> Path:
    info = PngInfo()
    info.add_itxt("Comment", comment(story.histories))
    image = Image.fromarray(np.ascontiguousarray(picture))
    return save_whole(out, lambda part: image.save(part, dpi=(dpi, dpi), pnginfo=info))
