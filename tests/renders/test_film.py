"""Films, checked by decoding them: frames, size, duration; nothing half-made is left."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from oblique_impact.renders.film import write_film, write_gif, write_still
from oblique_impact.renders.overview import overview_figure
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style
from oblique_impact.renders.timeline import make_timeline

SIZE = (480, 270)


@pytest.fixture
def story(run):
    return story_of([run("paper")], Style(size=SIZE))


def decode(file: Path) -> tuple[float, NDArray[np.uint8]]:
    """Return the duration of a film (s) as the container tells it, and its frames (count, height, width, 3)."""
    ffmpeg = imageio_ffmpeg.get_ffmpeg_exe()
    command = [ffmpeg, "-i", str(file), "-f", "rawvideo", "-pix_fmt", "rgb24", "-fps_mode", "passthrough", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    text = done.stderr.decode()
    width, height = map(int, re.search(r" (\d{2,})x(\d{2,})[ ,]", text).groups())
    hours, minutes, seconds = re.search(r"Duration: (\d+):(\d+):([\d.]+)", text).groups()
    frames = np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3)
    return 3600 * int(hours) + 60 * int(minutes) + float(seconds), frames


@pytest.mark.parametrize("name", ["a.mp4", "a.gif"])
def test_a_film_has_its_frames_size_and_duration(story, tmp_path, name):
    timeline, done = make_timeline(story.time_map, between=(0.30, 0.34), frames=12, fps=20), []
    write_film(story, timeline, tmp_path / name, lambda n, total: done.append((n, total)))
    assert done[-1] == (12, 12)
    assert [p.name for p in tmp_path.iterdir()] == [name]
    duration, frames = decode(tmp_path / name)
    assert frames.shape == (12, SIZE[1], SIZE[0], 3)
    assert duration == pytest.approx(12 / 20, abs=0.06)
    assert min(np.abs(a.astype(int) - b).max() for a, b in pairwise(frames)) > 20


@pytest.mark.parametrize("fps", [1, 7, 30, 33, 50])
def test_a_gif_plays_at_the_rate_that_it_is_asked_for(tmp_path, fps):
    """Delays are whole hundredths of a second, of which players take one or none for a tenth."""
    count = 10 * fps  # ten seconds
    frames = (np.full((2, 2, 3), n % 2 * 255, np.uint8) for n in range(count))
    write_gif(tmp_path / "a.gif", frames, count, fps, "")
    with Image.open(tmp_path / "a.gif") as film:
        delays = [film.seek(n) or film.info["duration"] for n in range(film.n_frames)]
    assert len(delays) == count
    assert sum(delays) == pytest.approx(1e3 * count / fps, rel=1e-3)
    assert min(delays) >= 20
    np.testing.assert_allclose(np.cumsum(delays), 1e3 * np.arange(1, count + 1) / fps, atol=5.0 + 1e-9)


def test_frames_of_a_gif_that_are_alike_last_as_long_as_all_of_them(tmp_path):
    frames = (np.full((2, 2, 3), 40 * (n // 15), np.uint8) for n in range(60))
    write_gif(tmp_path / "a.gif", frames, 60, 30, "")
    with Image.open(tmp_path / "a.gif") as film:
        assert [film.seek(n) or film.info["duration"] for n in range(film.n_frames)] == [500.0] * 4


def test_pictures_and_films_say_what_made_them_and_what_their_run_warns_of(story, tmp_path):
    history = story.histories[0]
    warned = replace(history, summary=history.summary | {"warnings": ["a rigid stop"]})
    story = story_of([warned], Style(size=SIZE))
    with Image.open(write_still(story, 0.1, tmp_path / "a.png")) as picture:
        said = [picture.text["Comment"]]
        assert picture.info["dpi"][0] == pytest.approx(story.style.resolution, rel=1e-3)
    mp4 = write_film(story, make_timeline(story.time_map, frames=2), tmp_path / "a.mp4")
    said.append(mp4.read_bytes().decode("utf-8", "replace"))
    with Image.open(write_film(story, make_timeline(story.time_map, frames=2), tmp_path / "a.gif")) as gif:
        assert gif.n_frames == 2
        said.append(gif.info["comment"].decode())
    svg = overview_figure({"run": warned}, tmp_path / "a.svg").read_text(encoding="utf-8")
    assert "warning: a rigid stop" in svg
    for text in said:
        assert "oblique-impact" in text
        assert "warning: a rigid stop" in text


def test_an_interrupted_film_leaves_nothing(story, tmp_path):
    def stop(done, total):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_film(story, make_timeline(story.time_map, frames=50), tmp_path / "a.mp4", stop)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="other systems draw without these libraries")
@pytest.mark.parametrize("lacking", ["libraries", "drivers"])
def test_without_a_library_to_draw_with_there_is_one_line(run, tmp_path, lacking):
    """Files that are no libraries stand before those of the system; or EGL finds no driver."""
    run("paper", "end_time=0.01").save(tmp_path / "run")
    (tmp_path / "none").mkdir()
    osmesa = ["libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"]
    for name in osmesa if lacking == "drivers" else [*osmesa, "libEGL.so.1"]:
        (tmp_path / "none" / name).touch()
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "VTK_DEFAULT_OPENGL_WINDOW")}
    environment |= {"LD_LIBRARY_PATH": str(tmp_path / "none"), "__EGL_VENDOR_LIBRARY_DIRS": str(tmp_path / "none")}
    command = [sys.executable, "-m", "oblique_impact", "render", "run", "--out", "a.png", "--size", "320x240"]
    done = subprocess.run(command, capture_output=True, text=True, env=environment, cwd=tmp_path, check=False)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "libegl1" in done.stderr
    assert not (tmp_path / "a.png").exists()
