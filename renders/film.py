"""Stills, strips and films of histories, as files that appear whole or not at all."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from PIL import Image

from oblique_impact.errors import InputError
from oblique_impact.files import cannot_write, only_writer, write_whole
from oblique_impact.history.history import History
from renders.frame import Composer, Style
from renders.metadata import add_comment, made_by, save_picture
from renders.outputs import FILMS
from renders.story import story_of
from renders.themes import theme_of
from renders.timeline import Timeline, contact_windows

_ROWS = 5
_COLOURS = 64  # of a GIF: one palette for the whole film, without dither
_PALETTE_FRAMES = 12

Progress = Callable[[int, int], None]


def write_still(
    histories: Sequence[History], names: Sequence[str], style: Style, time: float, out: Path, dpi: int = 200
) -> Path:
    """Write one picture at a physical time (s).

    Raises InputError for a time outside of the run or a file that cannot be written.
    """
    _check_times(histories[0], [time])
    composer = Composer(story_of(histories, style.quantity, style.deformation), names, style)
    try:
        picture = composer.draw(time)
    finally:
        composer.close()
    return _save(picture, out, dpi, histories)


def write_strip(
    histories: Sequence[History],
    names: Sequence[str],
    style: Style,
    times: Sequence[float],
    out: Path,
    dpi: int = 200,
) -> Path:
    """Write a strip: one row for each physical time (s), a colour bar below the last.

    Raises InputError as `write_still` does.
    """
    wanted = list(times) or strip_times(histories[0])
    _check_times(histories[0], wanted)
    rows, story = [], story_of(histories, style.quantity, style.deformation)
    letters = 0.8 * style.size[0] / 1000.0
    plain = replace(style, charts=False, inset=False, ghosts=False, trace=False, letters=letters)
    # the last row tells what the colours mean and how much the deflection is magnified
    for times, caption in ((wanted[:-1], False), (wanted[-1:], True)):
        composer = Composer(story, names, replace(plain, caption=caption), span=(min(wanted), max(wanted)))
        try:
            rows += [composer.draw(time) for time in times]
        finally:
            composer.close()
    height = sum(row.height for row in rows) + len(rows) - 1
    picture = Image.new("RGB", (style.size[0], height), theme_of(style.theme).line)
    for n, row in enumerate(rows):
        picture.paste(row, (0, n * (row.height + 1)))
    return _save(picture, out, dpi, histories)


def strip_times(history: History) -> list[float]:
    """Return instants that tell the story: before, through and after the first macro-collision."""
    windows = contact_windows(history)
    first, last = float(history["time"][0]), float(history["time"][-1])
    if not windows:
        return [float(t) for t in np.linspace(first, last, _ROWS)]
    groups = history.summary.get("macro_collisions") or [{"start": windows[0][0], "end": windows[0][1]}]
    start, end = float(groups[0]["start"]), float(groups[0]["end"])
    # where the force is largest, and the middle of the collision
    inside = sorted((_strongest(history, start, end), 0.5 * (start + end)))
    times = [start - 2.0 * (end - start) - 5e-3, start, *inside, end + 2.0 * (end - start) + 5e-3]
    return [float(np.clip(t, first, last)) for t in times]


def _strongest(history: History, start: float, end: float) -> float:
    """Time (s) of the largest normal force between two times."""
    time, force = np.asarray(history["time"].values), np.nan_to_num(history["lambda_n"].values)
    return float(time[np.argmax(np.where((time >= start) & (time <= end), force, -np.inf))])


def write_film(
    histories: Sequence[History],
    names: Sequence[str],
    style: Style,
    timeline: Timeline,
    out: Path,
    on_frame: Progress | None = None,
) -> Path:
    """Write a film as .mp4, .gif or .webp.

    Parameters
    ----------
    histories, names
        One to three histories and what they are called.
    style, timeline
        How the frames look, and when they are.
    out : Path
        Its suffix decides the format.
    on_frame : callable, optional
        Called with the number of frames done and their total.

    Raises
    ------
    InputError
        For an unknown suffix or a file that cannot be written.
    """
    if out.suffix.lower() not in FILMS:
        raise InputError(f"--out {out}: films end with {', '.join(FILMS)}")
    story = story_of(histories, style.quantity, style.deformation)
    composer = Composer(story, names, style, timeline)
    try:
        frames = _frames(composer, timeline, on_frame)
        with only_writer(_writable(out)):
            write_whole(
                out, lambda part: _encode(frames, style.size, timeline, part, composer, made_by(histories))
            )
    except OSError as error:
        raise cannot_write(out, error) from None
    finally:
        composer.close()
    return out


def _frames(composer: Composer, timeline: Timeline, on_frame: Progress | None) -> Iterator[Image.Image]:
    for n, (time, rate) in enumerate(zip(timeline.times, timeline.rates, strict=True), start=1):
        yield composer.draw(float(time), float(rate))
        if on_frame:
            on_frame(n, timeline.times.size)


def _encode(
    frames: Iterable[Image.Image],
    size: tuple[int, int],
    timeline: Timeline,
    part: Path,
    composer: Composer,
    made: str,
) -> None:
    """Send raw frames to ffmpeg, which are never all in memory; `made` says in the file what made it."""
    with tempfile.TemporaryDirectory() as folder:
        extra = _palette_options(composer, timeline, Path(folder)) if part.suffix.lower() == ".gif" else []
        command = [
            _encoder(),
            *("-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"),
            *("-s", f"{size[0]}x{size[1]}", "-r", str(timeline.fps), "-i", "-"),
            *extra,
            *_codec(part.suffix.lower()),
            *("-metadata", f"comment={made}"),
            str(part),
        ]
        log = Path(folder) / "log"
        # in a session of its own: Ctrl-C is for this process, which ends the encoder
        with (
            log.open("wb") as errors,
            subprocess.Popen(command, stdin=subprocess.PIPE, stderr=errors, start_new_session=True) as encoder,
        ):
            assert encoder.stdin is not None
            try:
                for frame in frames:
                    encoder.stdin.write(frame.tobytes())
            except BrokenPipeError:
                pass  # it says why in its log
            except BaseException:
                encoder.kill()
                raise
            finally:
                encoder.stdin.close()
        if encoder.returncode != 0:
            text = " ".join(log.read_text(encoding="utf-8", errors="replace").split())[:200]
            raise OSError(0, f"the encoder stopped: {text}")
        add_comment(part, made)


def _encoder() -> str:
    """Return the path of ffmpeg, which is tried out when it is first asked for."""
    try:
        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except RuntimeError:
        raise InputError(
            "films need ffmpeg: install the one of the package imageio-ffmpeg, or set IMAGEIO_FFMPEG_EXE"
        ) from None


def _codec(suffix: str) -> tuple[str, ...]:
    if suffix == ".mp4":
        quality = ("-c:v", "libx264", "-preset", "fast", "-crf", "18", "-pix_fmt", "yuv420p")
        return (*quality, "-movflags", "+faststart")
    if suffix == ".webp":
        return ("-c:v", "libwebp_anim", "-lossless", "0", "-q:v", "80", "-loop", "0")
    return ("-loop", "0")


def _palette_options(composer: Composer, timeline: Timeline, folder: Path) -> list[str]:
    """One palette for the whole film, from frames spread over it."""
    picks = np.unique(np.linspace(0, timeline.times.size - 1, _PALETTE_FRAMES).astype(int))
    samples = [composer.draw(float(timeline.times[k]), float(timeline.rates[k])) for k in picks]
    wide = Image.new("RGB", (samples[0].width, sum(s.height for s in samples)))
    for n, sample in enumerate(samples):
        wide.paste(sample, (0, n * sample.height))
    few = wide.quantize(_COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    table = np.array(few.getpalette(), dtype=np.uint8).reshape(-1, 3)[:_COLOURS]
    square = np.resize(table, (256, 3)).reshape(16, 16, 3)
    file = folder / "palette.png"
    Image.fromarray(square).save(file)
    return ["-i", str(file), "-lavfi", "paletteuse=dither=none"]


def _check_times(history: History, times: Sequence[float]) -> None:
    first, last = float(history["time"][0]), float(history["time"][-1])
    for time in times:
        if not first <= time <= last:
            raise InputError(f"--time {time:g}: should be from {first:g} to {last:g} s")


def _writable(out: Path) -> Path:
    out.parent.mkdir(parents=True, exist_ok=True)
    return out


def _save(picture: Image.Image, out: Path, dpi: int, histories: Sequence[History]) -> Path:
    try:
        write_whole(_writable(out), lambda part: save_picture(picture, part, dpi, made_by(histories)))
    except OSError as error:
        raise cannot_write(out, error) from None
    return out
