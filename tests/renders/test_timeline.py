"""When frames are: even film time, time stretched around contacts."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import InputError
from oblique_impact.renders.timeline import distance_from, make_timeline, time_map


def test_time_is_stretched_in_contacts(run):
    history = run("paper")
    timeline = make_timeline(time_map(history, 0.1, 0.001))
    assert np.all(np.diff(timeline.times) > 0.0)
    assert timeline.times[0] == 0.0
    assert timeline.times[-1] == pytest.approx(1.0, abs=1e-12)
    for contact in history.contacts:
        inside = (timeline.times > contact.start) & (timeline.times < contact.end)
        np.testing.assert_allclose(timeline.rates[inside], 0.001, rtol=1e-3)
    far = timeline.times < 0.2
    np.testing.assert_allclose(timeline.rates[far], 0.1, rtol=1e-6)


@pytest.mark.parametrize("frames", [None, 2000])
def test_rates_are_those_of_the_frames(run, frames):
    timeline = make_timeline(time_map(run("paper")), frames=frames)
    between = np.diff(timeline.times) * timeline.fps
    np.testing.assert_allclose(between, 0.5 * (timeline.rates[1:] + timeline.rates[:-1]), rtol=0.05)


def test_film_time_is_linear_in_frames(run):
    timeline = make_timeline(time_map(run("paper")), frames=301)
    assert timeline.times.size == 301
    np.testing.assert_allclose(timeline.course.film_at(timeline.times), np.arange(301) / 30, atol=1e-9)


def test_a_run_without_contact_has_one_rate(run):
    timeline = make_timeline(time_map(run("spin-up"), seconds=20.0))
    assert np.ptp(timeline.rates) < 1e-9 * timeline.rates[0]
    assert timeline.duration == pytest.approx(20.0, abs=0.1)


@pytest.mark.parametrize("name", ["paper", "sticking", "spin-up", "mid-span"])
def test_the_map_of_a_run_ascends_and_ends(run, name):
    history = run(name)
    course = time_map(history)
    assert np.all(np.diff(course.times) > 0.0)
    assert np.all(np.diff(course.film) > 0.0)
    assert course.times[[0, -1]] == pytest.approx(history["time"].values[[0, -1]], abs=0.0)
    assert 10.0 < course.duration < 75.0
    rates = np.diff(course.times) / np.diff(course.film)
    np.testing.assert_allclose(rates, 0.5 * (course.rates[1:] + course.rates[:-1]), rtol=0.02)


def test_a_part_of_the_film_runs_as_the_whole_film(run):
    """Between two physical times the same film time passes, at the same rates."""
    course = time_map(run("paper"))
    whole, part = make_timeline(course), make_timeline(course, between=(0.31, 0.335))
    times = np.linspace(0.31, 0.335, 200)
    shown = whole.course.film_at(times) - whole.course.film_at(0.31)
    np.testing.assert_allclose(part.course.film_at(times), shown, atol=1e-9)
    np.testing.assert_allclose(part.course.rate_at(times), whole.course.rate_at(times), rtol=1e-9)
    assert part.times[[0, -1]] == pytest.approx([0.31, 0.335], abs=0.0)


@pytest.mark.parametrize("seconds", [6.5, 10.0, 20.0])
@pytest.mark.parametrize("name", ["paper", "sticking", "spin-up"])
def test_a_film_is_as_long_as_it_is_asked_to_be(run, name, seconds):
    course = time_map(run(name), seconds=seconds)
    assert course.duration == pytest.approx(seconds, rel=1e-9)
    assert make_timeline(course, fps=30).duration == pytest.approx(seconds, abs=0.1)


@pytest.mark.parametrize("name", ["paper", "sticking", "spin-up", "mid-span"])
def test_without_a_length_to_keep_rates_are_round(run, name):
    """In flight and in contact 1, 2 or 5 times a power of ten, or one over it; a given speed as it is."""
    history = run(name)
    course = time_map(history)
    for rate in (course.rates.min(), course.rates.max()):
        assert any(f"{number:.6e}"[:8] in ("1.000000", "2.000000", "5.000000") for number in (rate, 1.0 / rate))
    given = time_map(history, speed=0.07, seconds=20.0)
    assert given.rates.max() == pytest.approx(0.07)


def test_distances_from_intervals():
    spans = np.array([[1.0, 2.0], [2.5, 2.5], [4.0, 7.0]])
    times = np.linspace(0.0, 9.0, 181)
    outside = np.maximum(spans[:, 0] - times[:, None], times[:, None] - spans[:, 1])
    np.testing.assert_allclose(distance_from(spans, times), np.maximum(outside, 0.0).min(axis=1), atol=1e-14)


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"fps": 0}, "--fps 0"),
        ({"speed": 0.0}, "--speed 0"),
        ({"contact_speed": -1.0}, "--contact-speed -1"),
        ({"contact_speed": float("nan")}, "--contact-speed nan"),
        ({"between": (0.5, 0.2)}, "--between 0.5,0.2: should be two increasing times from 0 to 1 s"),
        ({"between": (0.5, 7.0)}, "--between 0.5,7"),
        ({"frames": 1}, "--frames 1"),
    ],
)
def test_senseless_values_are_one_line(run, options, key):
    speeds = {name: value for name, value in options.items() if "speed" in name}
    with pytest.raises(InputError) as error:
        make_timeline(
            time_map(run("paper"), **speeds), **{name: options[name] for name in options.keys() - speeds.keys()}
        )
    assert str(error.value).startswith(key)
