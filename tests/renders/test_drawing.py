"""Frames drawn by several processes: all of them, in order, the same as by one; nobody is left behind."""

from __future__ import annotations

import os
import signal
from collections import deque

import pytest

from oblique_impact.renders import drawing
from oblique_impact.renders.drawing import frames_of, in_order
from oblique_impact.renders.film import write_film
from oblique_impact.renders.frame import Composer
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style
from oblique_impact.renders.timeline import make_timeline
from tests.processes import descendants, is_alive, started, wait_for

AHEAD = drawing._DRAWN


@pytest.fixture
def story(run):
    return story_of([run("paper")], Style(size=(480, 270)))


@pytest.fixture
def helpers(monkeypatch):
    """The processes that are started, even for a short film."""
    found = []

    class Kept(drawing._Helper):
        def __init__(self, *args):
            super().__init__(*args)
            found.append(self)

    monkeypatch.setattr(drawing, "_Helper", Kept)
    monkeypatch.setattr(drawing, "WORTHWHILE", 0)
    monkeypatch.setattr(drawing, "cores", lambda: 2)
    return found


def ready(helper):
    wait_for(helper.connection.poll)
    return True


@pytest.mark.parametrize("end", ["it lives", "it dies"])
def test_two_processes_draw_the_frames_of_one(story, helpers, end):
    timeline = make_timeline(story.time_map, frames=40)
    composer = Composer(story, timeline)
    alone = [
        composer.draw(float(time), float(rate)).tobytes()
        for time, rate in zip(timeline.times, timeline.rates, strict=True)
    ]
    own = []
    draw, composer.draw = composer.draw, lambda *args: own.append(args) or draw(*args)
    shared, asked = [], 0
    for number, frame in enumerate(frames_of(composer, timeline), start=1):
        shared.append(frame)
        if number == 1:
            (helper,) = helpers
            ready(helper)
        if number == 20 and end == "it dies":
            helper._process.kill()
            helper._process.wait()
        asked = max(asked, len(helper.asked))
    composer.close()
    assert shared == alone
    assert asked > 0
    assert (len(own) == 40) == (helper._process.returncode == 0)  # the helper drew what this process did not
    assert helper._process.returncode is not None


class Slow:
    """Stands for a process that draws a frame while others are asked for, and dies after some."""

    def __init__(self, dies_after):
        self.asked, self.alive, self.connection, self.left = deque(), True, None, dies_after

    @property
    def free(self):
        return self.alive and len(self.asked) < 2

    def ask(self, number):
        self.asked.append(number)

    def finished(self):
        if self.alive and self.asked and self.left > 0:
            self.left -= 1
            number = self.asked.popleft()
            return {number: f"helper {number}"}
        self.alive = self.alive and self.left > 0
        return {}


@pytest.mark.parametrize("deaths", [[], [0], [3], [100], [5, 100], [2, 2, 7]])
def test_frames_come_in_order_and_few_are_kept(monkeypatch, deaths):
    monkeypatch.setattr(drawing, "wait", lambda connections: None)
    drawn, taken = [], []

    def draw(number):
        assert number - len(taken) < AHEAD
        drawn.append(number)
        return f"own {number}"

    helpers = [Slow(after) for after in deaths]
    for frame in in_order(draw, 60, helpers):
        taken.append(frame)
        assert all(number - len(taken) < AHEAD for helper in helpers for number in helper.asked)
    assert [int(frame.split()[1]) for frame in taken] == list(range(60))
    assert len(drawn) == len(set(drawn)) == 60 - sum(frame.startswith("helper") for frame in taken)


def test_an_interrupted_film_leaves_no_process_and_no_file(story, helpers, tmp_path):
    def stop(done, total):
        if done == 3 and ready(helpers[0]):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_film(story, make_timeline(story.time_map, frames=30), tmp_path / "a.mp4", stop)
    assert [helper._process.returncode for helper in helpers] == [-signal.SIGKILL]
    assert list(tmp_path.iterdir()) == []


def test_a_short_film_starts_no_process(story, helpers, monkeypatch):
    monkeypatch.setattr(drawing, "WORTHWHILE", 3 * 480 * 270 + 1)
    composer = Composer(story, timeline := make_timeline(story.time_map, frames=3))
    assert len(list(frames_of(composer, timeline))) == 3
    composer.close()
    assert helpers == []


@pytest.mark.slow
def test_the_processes_of_a_killed_command_leave(run, tmp_path):
    history = run("paper").save(tmp_path / "paper")
    with started("render", history, "--out", tmp_path / "a.mp4") as process:
        wait_for(lambda: len(descendants(process.pid)) >= 1 + (drawing.cores() > 1))  # an encoder, and who draws
        children = descendants(process.pid)
        os.kill(process.pid, signal.SIGKILL)
        wait_for(lambda: not any(map(is_alive, children)))
