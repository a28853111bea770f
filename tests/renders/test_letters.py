"""Letters of pictures: large enough to be read, none over another, none cut off, at every size."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from oblique_impact.renders.charts import round_times
from oblique_impact.renders.frame import Composer
from oblique_impact.renders.layout import lay_out
from oblique_impact.renders.letters import LEAST, Letters
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style
from oblique_impact.renders.timeline import TimeMap, make_timeline
from tests.renders.writing import written

#: the smallest, the usual one, upright; between them and above it there is more room
SIZES = [(480, 270), (1280, 720), (720, 1280)]
MORE_SIZES = [(640, 360), (854, 480), (1920, 1080)]


def check(found):
    """Letters are readable, inside of the picture, and none is over another."""
    assert found
    for text, size, box, _, _, room in found:
        assert size >= LEAST - 0.5, (text, size)
        assert min(box[0], box[1], room[0] - box[2], room[1] - box[3]) >= -0.5, (text, box, room)
    for one, other in combinations(found, 2):
        if one.picture is other.picture:
            across = min(one.box[2], other.box[2]) - max(one.box[0], other.box[0])
            high = min(one.box[3], other.box[3]) - max(one.box[1], other.box[1])
            assert across <= 0.0 or high <= 0.0, (one, other)


def drawn(monkeypatch, story, time):
    """What a frame writes in a film."""

    def draw():
        composer = Composer(story, make_timeline(story.time_map))
        composer.draw(time, 0.002)
        composer.close()

    return written(monkeypatch, draw)


@pytest.mark.parametrize(
    "size",
    [*SIZES, *(pytest.param(size, marks=pytest.mark.slow) for size in MORE_SIZES)],
    ids=lambda s: f"{s[0]}x{s[1]}",
)
@pytest.mark.parametrize("case", ["one", "two", "overlay"])
def test_letters_are_readable_and_apart(run, monkeypatch, size, case):
    histories = [run("paper")] if case == "one" else [run("paper"), run("paper", "contact.friction=frictionless")]
    layout = "overlay" if case == "overlay" else "side-by-side"
    names = ["hybrid friction", "frictionless, a rather long name"][: len(histories)]
    check(drawn(monkeypatch, story_of(histories, Style(size=size, layout=layout), names), 0.3232))


@pytest.mark.parametrize(
    ("case", "below"),
    [
        (("paper", "end_time=1e-4"), "time (s)"),  # many decimals
        (("spin-up",), "time (s)"),  # thousands of J
        (("tapered", "end_time=0.34"), "time (s), stretched around contacts"),
    ],
)
def test_letters_of_other_runs(run, monkeypatch, case, below):
    """Labels with many digits fit too; that time is stretched is said where it is."""
    story = story_of([run(*case)], Style(size=(854, 480)))
    found = drawn(monkeypatch, story, story.histories[0].summary["end_time"])
    check(found)
    assert below in {item.text for item in found}


def test_what_would_be_too_small_is_left_out():
    plan = lay_out((1280, 720), 1, inset=True, charts=True)
    assert (len(plan.views), len(plan.charts)) == (1, 2)
    assert plan.inset
    assert len(lay_out((640, 360), 1, inset=True, charts=True).charts) == 1
    small = lay_out((320, 180), 1, inset=True, charts=True)
    assert (small.inset, small.charts) == (None, [])
    for size in SIZES:
        for count in (1, 2, 3):
            plan = lay_out(size, count, inset=count == 1, charts=True)
            boxes = [*plan.views, *plan.charts, *([plan.inset] if plan.inset else [])]
            covered = np.zeros(size, dtype=int)
            for left, top, width, height in boxes:
                covered[left : left + width, top : top + height] += 1
            assert covered.max() == 1
            assert (covered == 0).mean() < 0.01  # what does not divide by three


@pytest.mark.parametrize("width", [180.0, 420.0, 560.0, 1100.0])
@pytest.mark.parametrize("name", ["paper", "sticking", "spin-up"])
def test_ticks_are_round_times_with_the_same_decimals(run, width, name):
    course = story_of([run(name)]).time_map
    check_ticks(course, width)
    check_ticks(course.part(0.31, 0.335), width)


def check_ticks(course: TimeMap, width: float) -> None:
    times, labels = round_times(course, width, Letters(1.0).font(9.5).getlength)
    assert len(labels) >= 2
    assert len({len(label.partition(".")[2]) for label in labels}) == 1
    np.testing.assert_allclose([float(label) for label in labels], times, atol=1e-12)
    at = course.film_at(times) * width / course.duration
    longest = max(map(Letters(1.0).font(9.5).getlength, labels))
    assert np.diff(at).min() > longest
    assert at.min() >= 0.0
    assert at.max() <= width + 1e-9


@pytest.mark.parametrize("width", [180.0, 420.0, 560.0, 700.0, 1100.0])
def test_ticks_are_multiples_of_one_two_or_five(run, width):
    """On an even axis of one step, in a film of a second of 5 ms: three decimals with a 5 at the end, or less."""
    length = Letters(1.0).font(9.5).getlength
    times, _ = round_times(story_of([run("paper")]).time_map, width, length)
    np.testing.assert_allclose(times / 0.005, np.round(times / 0.005), atol=1e-6)
    for span in (0.2, 0.7, 3.0):
        even = TimeMap(np.array([0.0, span]), np.array([0.0, 10.0]), np.full(2, span / 10.0))
        times, _ = round_times(even, width, length)
        steps = np.diff(times)
        np.testing.assert_allclose(steps, steps[0])
        assert f"{steps[0]:.1e}"[:3] in ("1.0", "2.0", "5.0")
        assert times[0] == 0.0
        assert times[-1] > 0.5 * span
