"""Stills, strips and films of histories, as files that appear whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

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
_COLOURS = 64  # of a GIF: a quarter of the size of 256 ones

OnFrame = Callable[[int, int], None]


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
    """Write a film as .mp4 or .gif, as the suffix of `out` says, with PyVista's movie writer.

    `on_frame` is called with the number of frames done and their total.  Raises InputError for a file that cannot
    be written.
    """

    def write(part: Path) -> None:
        with Composer(story, timeline) as composer:
            open_film(composer.scene.plotter, part, timeline.fps, comment(story.histories))
            for n, (time, rate) in enumerate(zip(timeline.times, timeline.rates, strict=True), start=1):
                composer.scene.plotter.mwriter.append_data(composer.draw(float(time), float(rate)))
                if on_frame:
                    on_frame(n, timeline.times.size)
        if part.suffix.lower() == ".gif":
            _add_gif_comment(part, comment(story.histories))

    return save_whole(out, write)


def open_film(plotter: Any, file: Path, fps: int, text: str) -> None:
    """Open the movie writer of a plotter; `text` is the comment of an MP4 file."""
    if file.suffix.lower() == ".gif":
        plotter.open_gif(str(file), fps=fps, loop=0, palettesize=_COLOURS, subrectangles=True)
        return
    options = ["-preset", "veryfast", "-crf", "17", "-movflags", "+faststart", "-metadata", f"comment={text}"]
    plotter.open_movie(str(file), fps, quality=None, macro_block_size=2, output_params=options)


def _add_gif_comment(file: Path, text: str) -> None:
    """Put a comment before the first frame of a GIF, which imageio's writer has no option for.

    GIF89a specification (CompuServe 1990), sections 18 and 24: colours follow the first 13 bytes, as many as the
    byte 10 says; a comment is a chain of blocks of up to 255 characters.
    """
    content, words = file.read_bytes(), text.encode("ascii", "replace")
    first = 13 + (3 << (content[10] % 8 + 1) if content[10] & 0x80 else 0)
    parts = [words[k : k + 255] for k in range(0, len(words), 255)]
    block = b"\x21\xfe" + b"".join(bytes([len(part)]) + part for part in parts) + b"\x00"
    file.write_bytes(content[:first] + block + content[first:])


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
