"""When frames are: even film time, time stretched around contacts."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import InputError
from renders.timeline import contact_windows, make_timeline


def test_contacts_of_the_paper(run):
    history = run("paper")
    windows = contact_windows(history)
    collisions = history.summary["macro_collisions"]
    assert sum(c["contacts"] for c in collisions) == len(windows)
    assert windows[0][0] == collisions[0]["start"]
    assert windows[-1][1] == collisions[-1]["end"]


def test_time_is_stretched_in_contacts(run):
    history = run("paper")
    timeline = make_timeline(history, speed=0.1, contact_speed=0.001)
    assert np.all(np.diff(timeline.times) > 0.0)
    assert timeline.times[0] == 0.0
    assert timeline.times[-1] == pytest.approx(1.0, abs=1e-12)
    for start, end in contact_windows(history):
        inside = (timeline.times > start) & (timeline.times < end)
        np.testing.assert_allclose(timeline.rates[inside], 0.001, rtol=1e-3)
    far = timeline.times < 0.2
    np.testing.assert_allclose(timeline.rates[far], 0.1, rtol=1e-6)


def test_rates_are_those_of_the_frames(run):
    timeline = make_timeline(run("paper"))
    between = np.diff(timeline.times) * timeline.fps
    np.testing.assert_allclose(between, 0.5 * (timeline.rates[1:] + timeline.rates[:-1]), rtol=0.05)


def test_film_time_is_linear_in_frames(run):
    timeline = make_timeline(run("paper"), frames=301)
    assert timeline.times.size == 301
    np.testing.assert_allclose(timeline.film_time(timeline.times), np.arange(301) / 30, atol=1e-9)


def test_a_run_without_contact_has_one_rate(run):
    timeline = make_timeline(run("spin-up"))
    assert np.ptp(timeline.rates) < 1e-9 * timeline.rates[0]
    assert 10.0 < timeline.duration < 40.0


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"fps": 0}, "--fps 0"),
        ({"speed": 0.0}, "--speed 0"),
        ({"contact_speed": -1.0}, "--contact-speed -1"),
        ({"contact_speed": float("nan")}, "--contact-speed nan"),
        ({"between": (0.5, 0.2)}, "--between 0.5,0.2"),
        ({"between": (0.5, 7.0)}, "--between 0.5,7"),
        ({"frames": 1}, "--frames 1"),
    ],
)
def test_senseless_values_are_one_line(run, options, key):
    with pytest.raises(InputError) as error:
        make_timeline(run("paper"), **options)
    assert str(error.value).startswith(key)
