"""Films, checked by decoding them: frames, size, duration; nothing half-made is left."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from oblique_impact.renders.film import strip_times, write_film, write_still, write_strip
from oblique_impact.renders.overview import overview_figure
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


def test_a_strip_has_a_row_for_each_time_in_their_order(run, tmp_path):
    """Rows of one time are alike; by default five around the first macro-collision, one at the largest force."""
    story = story_of([run("paper")], Style(size=(600, 160)))
    history = story.histories[0]
    write_strip(story, [0.1, 0.1, 0.3], tmp_path / "a.png")
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.size[0] == 600
        assert 3 * 160 < picture.size[1] < 4 * 160
        rows = np.asarray(picture).astype(int)
    first, second, third = (rows[n * 160 + 4 : n * 160 + 156] for n in range(3))
    assert np.array_equal(first, second)
    assert np.abs(second - third).max() > 50
    times = strip_times(history)
    assert len(times) == 5
    assert times == sorted(times)
    first = history.summary["macro_collisions"][0]
    force = history.data["lambda_n"].sel(time=slice(first["start"], first["end"]))
    assert float(force["time"][int(np.argmax(force.values))]) in times


def test_pictures_and_films_say_what_made_them_and_what_their_run_warns_of(run, tmp_path):
    history = run("paper")
    warned = replace(history, summary=history.summary | {"warnings": ["a rigid stop"]})
    story = story_of([warned], Style(size=SIZE))
    with Image.open(write_still(story, 0.1, tmp_path / "a.png")) as picture:
        said = [picture.text["Comment"]]
        assert picture.info["dpi"][0] == pytest.approx(story.style.resolution, rel=1e-3)
    mp4 = write_film(story, make_timeline(story.time_map, frames=2), tmp_path / "a.mp4")
    said.append(mp4.read_bytes().decode("utf-8", "replace"))
    svg = overview_figure({"run": warned}, tmp_path / "a.svg").read_text(encoding="utf-8")
    assert "warning: a rigid stop" in svg
    for text in said:
        assert "oblique-impact" in text
        assert "warning: a rigid stop" in text


def test_an_interrupted_film_leaves_nothing(run, tmp_path):
    story = small(run)
    timeline = make_timeline(story.time_map, frames=50)

    def stop(done, total):
        if done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_film(story, timeline, tmp_path / "a.mp4", stop)
    assert list(tmp_path.iterdir()) == []


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
