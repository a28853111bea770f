"""Films, checked by decoding them: frames, size, duration; nothing half-made is left."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from itertools import pairwise

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from oblique_impact import InputError
from oblique_impact.renders.film import strip_times, write_film, write_strip
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style
from oblique_impact.renders.timeline import make_timeline
from tests.renders.decoding import decode

SIZE = (480, 270)


def small(run):
    return story_of([run("paper")], Style(size=SIZE))


def film(run, tmp_path, name, frames=12):
    story = small(run)
    timeline = make_timeline(story.time_map, between=(0.30, 0.34), frames=frames, fps=20)
    done = []
    out = tmp_path / name
    write_film(story, timeline, out, lambda n, total: done.append((n, total)))
    assert done[-1] == (frames, frames)
    assert sorted(p.name for p in tmp_path.iterdir()) == [name]
    return out


@pytest.mark.parametrize("name", ["a.mp4", "a.gif"])
def test_a_film_has_its_frames_size_and_duration(run, tmp_path, name):
    duration, frames = decode(film(run, tmp_path, name))
    assert len(frames) == 12
    assert duration == pytest.approx(12 / 20, abs=0.06)
    changes = [np.abs(a.astype(int) - b).max() for a, b in pairwise(frames)]
    assert min(changes) > 20
    assert all(frame.std() > 5.0 for frame in frames)


def test_a_webp_is_animated(run, tmp_path):
    with Image.open(film(run, tmp_path, "a.webp")) as picture:
        assert picture.n_frames == 12
        assert picture.size == SIZE


def test_a_strip_has_a_row_for_each_time(run, tmp_path):
    story = story_of([run("paper")], Style(size=(600, 160)))
    times = strip_times(story.histories[0])
    assert len(times) == 5
    assert times == sorted(times)
    file = write_strip(story, [], tmp_path / "strip.png")
    with Image.open(file) as picture:
        assert picture.size == (600, 5 * 160 + 4)
        rows = np.asarray(picture).astype(int)
    parts = [rows[n * 161 : n * 161 + 160] for n in range(5)]
    assert all(np.abs(a - b).max() > 50 for a, b in pairwise(parts))
    write_strip(story, [0.1, 0.2], tmp_path / "two.png")
    with Image.open(tmp_path / "two.png") as picture:
        assert picture.size == (600, 321)


def test_the_rows_of_a_strip_are_in_the_order_of_their_times(run, tmp_path):
    """Two rows of one time are alike, above the one with the colour bar; one shows the largest force."""
    story = story_of([run("paper")], Style(size=(600, 160)))
    write_strip(story, [0.1, 0.1, 0.3], tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as picture:
        rows = np.asarray(picture).astype(int)
    first, second, third = (rows[n * 161 : n * 161 + 160] for n in range(3))
    assert np.array_equal(first, second)
    assert not np.array_equal(second, third)
    history = story.histories[0]
    first = history.summary["macro_collisions"][0]
    force = history.data["lambda_n"].sel(time=slice(first["start"], first["end"]))
    assert float(force["time"][int(np.argmax(force.values))]) in strip_times(history)


def test_an_interrupted_film_leaves_nothing(run, tmp_path):
    story = small(run)
    timeline = make_timeline(story.time_map, frames=50)

    def stop(done, total):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_film(story, timeline, tmp_path / "a.mp4", stop)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("place", ["trial", "encoder"])
@pytest.mark.parametrize("interrupted", [False, True])
def test_a_failing_encoder_is_an_error_and_an_interrupt_is_not(run, tmp_path, monkeypatch, place, interrupted):
    """In both cases nothing is left of the film."""
    failing = tmp_path / "failing"
    failing.write_text("#!/bin/sh\ncat > /dev/null\nexit 1\n")
    failing.chmod(0o755)

    def ffmpeg():
        if place == "encoder":
            return str(failing)
        raise KeyboardInterrupt if interrupted else RuntimeError("No ffmpeg exe could be found.")

    def on_frame(done, total):
        if interrupted and done == total:
            raise KeyboardInterrupt

    monkeypatch.setattr(imageio_ffmpeg, "get_ffmpeg_exe", ffmpeg)
    story = small(run)
    words = "films need ffmpeg" if place == "trial" else "the encoder stopped"
    with pytest.raises(KeyboardInterrupt if interrupted else InputError, match=None if interrupted else words):
        write_film(story, make_timeline(story.time_map, frames=2), tmp_path / "a.mp4", on_frame)
    assert list(tmp_path.iterdir()) == [failing]


def test_unknown_kinds_are_one_line(run, tmp_path):
    story = small(run)
    timeline = make_timeline(story.time_map, frames=2)
    with pytest.raises(InputError, match=r"films end with \.mp4"):
        write_film(story, timeline, tmp_path / "a.avi")


def without_libraries(tmp_path, code):
    """Run Python with no library to draw with: names that are not found stand for them."""
    text = f"""
        import ctypes
        real = ctypes.CDLL
        def missing(name, *a, **k):
            if isinstance(name, str) and ("EGL" in name or "OSMesa" in name):
                raise OSError(name + ": cannot open shared object file")
            return real(name, *a, **k)
        ctypes.CDLL = missing
        {code}
    """
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "VTK_DEFAULT_OPENGL_WINDOW")}
    return subprocess.run(
        [sys.executable, "-c", textwrap.dedent(text)],
        capture_output=True,
        text=True,
        env=environment,
        cwd=tmp_path,
        timeout=120,
        check=False,
    )


def test_without_a_library_to_draw_with_there_is_one_line(run, tmp_path):
    run("paper").save(tmp_path / "run")
    done = without_libraries(
        tmp_path,
        "from oblique_impact.command_line.application import main; "
        "main(['render', 'run', '--out', 'a.png', '--size', '320x240'])",
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "libegl1" in done.stderr
    assert not (tmp_path / "a.png").exists()


@pytest.mark.slow
def test_memory_does_not_grow_over_six_hundred_frames(run, tmp_path):
    import resource

    story = small(run)
    peaks = []

    def watch(done, total):
        if done in (100, 600):
            peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)

    timeline = make_timeline(story.time_map, frames=600)
    write_film(story, timeline, tmp_path / "a.mp4", watch)
    assert peaks[1] < 1.05 * peaks[0]
