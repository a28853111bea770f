"""Stills and films of histories, as files that appear whole or not at all."""

from __future__ import annotations

import subprocess
from collections.abc import Callable, Generator, Iterator
from contextlib import closing, suppress
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

from oblique_impact.errors import InputError
from oblique_impact.files import save_whole
from oblique_impact.renders.frame import Composer
from oblique_impact.renders.picture_files import comment
from oblique_impact.renders.story import Story
from oblique_impact.renders.timeline import Timeline

GIF_FPS = 50

OnFrame = Callable[[int, int], None]
Pixels = NDArray[np.uint8]


def write_still(story: Story, time: float, out: Path) -> Path:
    """Write one picture at a physical time (s).

    Raises InputError for a time outside of the run or a file that cannot be written.
    """
    first, last = story.geometries[0].times[[0, -1]]
    if not first <= time <= last:
        raise InputError(f"--time {time:g}: should be from {first:g} to {last:g} s")
    info, dpi = PngInfo(), story.style.resolution
    info.add_itxt("Comment", comment(story.histories))
    with Composer(story) as composer:
        image = Image.fromarray(np.ascontiguousarray(composer.draw(time)))
    return save_whole(out, lambda part: image.save(part, dpi=(dpi, dpi), pnginfo=info))


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
