"""Stills, strips and films of histories, as files that appear whole or not at all."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from itertools import chain, repeat
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from PIL import Image

from oblique_impact.errors import InputError
from oblique_impact.files import only_writer
from oblique_impact.history.history import History
from oblique_impact.renders.drawing import frames_of
from oblique_impact.renders.files import save_whole
from oblique_impact.renders.frame import Composer
from oblique_impact.renders.metadata import add_comment, comment, save_picture
from oblique_impact.renders.outputs import FILMS
from oblique_impact.renders.story import Story
from oblique_impact.renders.style import SLIDE, Style
from oblique_impact.renders.timeline import Timeline
from oblique_impact.renders.title_card import title_card

_ROWS = 5
_COLOURS = 64  # of a GIF: one palette for the whole film, without dither
_PALETTE_FRAMES = 12
_PIPE = 1 << 20  # bytes; as large as it may be, so that drawing and encoding wait for each other less
CODECS = {
    ".mp4": "-c:v libx264 -preset veryfast -crf 17 -pix_fmt yuv420p -movflags +faststart",
    ".webp": "-c:v libwebp_anim -lossless 0 -q:v 80 -compression_level 2 -loop 0",
    ".gif": "-loop 0",
}

OnFrame = Callable[[int, int], None]


def write_still(story: Story, time: float, out: Path) -> Path:
    """Write one picture at a physical time (s).

    Raises InputError for a time outside of the run or a file that cannot be written.
    """
    _check_times(story, [time])
    with _composer(story) as composer:
        return _save(composer.draw(time), out, story, story.style.resolution)


def write_strip(story: Story, times: Sequence[float], out: Path) -> Path:
    """Write a strip: one row for each physical time (s), by default `strip_times`, a colour bar below the last.

    Raises InputError as `write_still` does.
    """
    times = list(times) or strip_times(story.histories[0])
    _check_times(story, times)
    width, span = story.style.size[0], (min(times), max(times))
    plain = replace(
        story.style,
        charts=False,
        inset=False,
        ghosts=False,
        trace=False,
        ground=False,
        title="",
        dpi=story.style.dpi or width / SLIDE[0],
    )
    rows: list[Image.Image] = []
    # the last row tells what the colours mean and how much the deflection is magnified
    for some, caption in ((times[:-1], False), (times[-1:], True)):
        with _composer(story, None, replace(plain, caption=caption), span) as composer:
            rows += [composer.draw(time) for time in some]
    picture = Image.new("RGB", (width, len(rows) * (rows[0].height + 1) - 1), story.style.colours.line)
    for n, row in enumerate(rows):
        picture.paste(row, (0, n * (row.height + 1)))
    return _save(picture, out, story, plain.resolution)


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
    """Write a film as .mp4, .gif or .webp, as the suffix of `out` says.

    `on_frame` is called with the number of frames done and their total.  Raises InputError for an unknown suffix
    or a file that cannot be written.
    """
    if out.suffix.lower() not in FILMS:
        raise InputError(f"--out {out}: films end with {', '.join(FILMS)}")

    def write(part: Path) -> None:
        with only_writer(out), _composer(story, timeline) as composer:
            _encode(composer, timeline, part, comment(story.histories, story.factor), on_frame)

    return save_whole(out, write)


@contextmanager
def _composer(
    story: Story,
    timeline: Timeline | None = None,
    style: Style | None = None,
    span: tuple[float, float] | None = None,
) -> Iterator[Composer]:
    """Make a composer; frees its windows at the end of the block."""
    composer = Composer(story, timeline, style, span)
    try:
        yield composer
    finally:
        composer.close()


def _encode(composer: Composer, timeline: Timeline, part: Path, text: str, on_frame: OnFrame | None) -> None:
    """Send raw frames to ffmpeg, which are never all in memory; `text` is the comment in the file."""
    suffix, (width, height) = part.suffix.lower(), composer.style.size
    card = title_card(composer.story, timeline).tobytes() if timeline.card else b""
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile() as log:
        command = [
            *(_encoder(), "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"),
            *("-s", f"{width}x{height}", "-r", str(timeline.fps), "-i", "-"),
            *(_palette_options(composer, timeline, Path(folder)) if suffix == ".gif" else []),
            *(*CODECS[suffix].split(), "-metadata", f"comment={text}", str(part)),
        ]
        # in a session of its own: Ctrl-C is for this process, which ends the encoder
        with (
            subprocess.Popen(
                command, stdin=subprocess.PIPE, stderr=log, start_new_session=True, pipesize=_PIPE
            ) as encoder,
            closing(frames_of(composer, timeline)) as frames,
        ):
            assert encoder.stdin is not None
            try:
                for n, frame in enumerate(chain(repeat(card, timeline.card), frames), start=1):
                    encoder.stdin.write(frame)
                    if on_frame:
                        on_frame(n, timeline.card + timeline.times.size)
            except BrokenPipeError:
                pass  # it says why in its log
            except BaseException:
                encoder.kill()
                raise
            finally:
                encoder.stdin.close()
        if encoder.returncode != 0:
            log.seek(0)
            why = " ".join(log.read().decode(errors="replace").split())[:200]
            raise OSError(0, f"the encoder stopped: {why}")
    add_comment(part, text)


def _encoder() -> str:
    """Return the path of ffmpeg, which is tried out when it is first asked for."""
    try:
        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError:
        raise InputError(
            "films need ffmpeg: install the one of the package imageio-ffmpeg, or set IMAGEIO_FFMPEG_EXE"
        ) from None


def _palette_options(composer: Composer, timeline: Timeline, folder: Path) -> list[str]:
    """One palette for the whole film, from frames spread over it."""
    picks = np.unique(np.linspace(0, timeline.times.size - 1, _PALETTE_FRAMES).astype(int))
    samples = [composer.draw(float(timeline.times[k]), float(timeline.rates[k])) for k in picks]
    if timeline.card:
        samples.append(title_card(composer.story, timeline))
    wide = Image.new("RGB", (samples[0].width, sum(s.height for s in samples)))
    for n, sample in enumerate(samples):
        wide.paste(sample, (0, n * sample.height))
    few = wide.quantize(_COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    table = np.array(few.getpalette(), dtype=np.uint8).reshape(-1, 3)[:_COLOURS]
    square = np.resize(table, (256, 3)).reshape(16, 16, 3)
    file = folder / "palette.png"
    Image.fromarray(square).save(file)
    return ["-i", str(file), "-lavfi", "paletteuse=dither=none:diff_mode=rectangle"]


def _check_times(story: Story, times: Sequence[float]) -> None:
    first, last = story.geometries[0].times[[0, -1]]
    for time in times:
        if not first <= time <= last:
            raise InputError(f"--time {time:g}: should be from {first:g} to {last:g} s")


def _save(picture: Image.Image, out: Path, story: Story, dpi: float) -> Path:
    text = comment(story.histories, story.factor)
    return save_whole(out, lambda part: save_picture(picture, part, dpi, text))
