"""What the pictures of a run share: slope, scale of colours, time map, scale bar."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.layout import scale_bar
from oblique_impact.renders.story import ColourScale, colour_scale, round_up
from oblique_impact.renders.style import Colour
from oblique_impact.renders.surroundings import drawn_obstacles
from oblique_impact.renders.timeline import make_timeline, time_map

# Slope --------------------------------------------------------------------------------------------------------


def test_what_passes_below_an_unbounded_slope_is_seen_to_do_so(run):
    """The slope is drawn over every place of the axis that is below it; its surface half a depth lower."""
    geometry = BeamGeometry(run("mid-span", "contact.where=point", "contact.point=0.6", "slope.extent=[]"))
    (slope,), (tangent, normal) = drawn_obstacles(geometry), geometry.slope_axes
    places = geometry.stations_at(np.arange(geometry.times.size)) - geometry.scenario.slope.origin
    below = (places @ tangent)[places @ normal < 0.0]
    assert slope.ends[0] < below.min()
    assert slope.ends[1] > below.max()
    corners = slope.outline - geometry.scenario.slope.origin
    np.testing.assert_allclose(corners[:2] @ normal, -geometry.touch_radius, atol=1e-12)
    np.testing.assert_allclose(corners[:2] @ tangent, slope.ends, atol=1e-12)
    assert np.all(corners[2:] @ normal < corners[0] @ normal)


def test_the_ends_of_a_slope_are_those_of_the_scenario_within_reach(run):
    ledge = BeamGeometry(run("mid-span"))
    (slope,) = drawn_obstacles(ledge)
    assert slope.ends == ledge.scenario.slope.extent
    (wide,) = drawn_obstacles(BeamGeometry(run("paper", "end_time=0.01", "slope.extent=[-100.0, 100.0]")))
    assert np.ptp(wide.ends) < 2.5
    assert drawn_obstacles(BeamGeometry(run("paper", "end_time=0.01", "slope.extent=[5.0, 6.0]"))) == []
    assert drawn_obstacles(BeamGeometry(run("spin-up", "end_time=0.01"))) == []


# Colours ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("case", [("tapered", "end_time=0.34"), ("mid-span",)])
def test_the_scale_covers_the_drawn_surface(run, case):
    geometry = BeamGeometry(run(*case))
    for quantity in get_args(Colour):
        scale = colour_scale([geometry], quantity)
        samples = np.linspace(0, geometry.times.size - 1, 25).astype(int)
        assert max(np.abs(geometry.result(quantity, k)).max() for k in samples) <= 1.01 * scale.limit
        largest = np.abs(geometry.at_fibres(quantity)).max()
        assert largest <= scale.limit <= 1.35 * largest
        assert not scale.exceeded


def test_a_run_that_blew_up_is_exceeded_and_says_so(run):
    history = run("paper")
    sound = colour_scale([BeamGeometry(history)], "bending_stress")
    blown = copy.deepcopy(replace(history, summary=history.summary | {"outcome": "diverged"}))
    blown.section_forces()["bending_stress"].values[-2:] = [[1e28], [1e300]]
    scale = colour_scale([BeamGeometry(blown)], "bending_stress")
    assert 0.5 * sound.limit < scale.limit <= sound.limit
    assert scale.exceeded
    labels = [text for _, text in scale.ticks]
    assert (labels[0][0], labels[-1][0]) == ("≤", "≥")


def test_labels_of_the_scale_are_their_numbers():
    for limit, unit, labels in (
        (2.5e6, "MPa", ["−2.50", "−1.25", "0", "1.25", "2.50"]),
        (1.5e10, "GPa", ["−15.0", "−7.5", "0", "7.5", "15.0"]),
        (4.0, "Pa", ["−4", "−2", "0", "2", "4"]),
    ):
        scale = ColourScale("bending_stress", limit, False)
        assert scale.title == f"bending stress ({unit}), tension positive"
        assert [text for _, text in scale.ticks] == labels


def test_the_ends_of_a_scale_and_of_a_scale_bar_are_round():
    assert [round_up(v) for v in (0.0, 1.0, 86.0, 100.0, 100.1)] == [1.0, 1.0, 100.0, 100.0, 120.0]
    for pixels, length, text in ((100.0, 0.5, "0.5 m"), (3000.0, 0.02, "20 mm"), (2e6, 2e-5, "20 µm")):
        bar = scale_bar(np.array([pixels, 0.0]), 80.0)
        assert (bar.length, bar.text) == (pytest.approx(length), text)
        np.testing.assert_allclose(bar.across, [length * pixels, 0.0])


# Time ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["paper", "spin-up", "mid-span"])
def test_the_map_of_a_run_ascends_at_round_rates(run, name):
    history = run(name)
    course = time_map(history)
    assert np.all(np.diff(course.times) > 0.0)
    assert np.all(np.diff(course.film) > 0.0)
    assert course.times[[0, -1]] == pytest.approx(history["time"].values[[0, -1]], abs=0.0)
    assert 10.0 < course.duration < 75.0
    rates = np.diff(course.times) / np.diff(course.film)
    np.testing.assert_allclose(rates, 0.5 * (course.rates[1:] + course.rates[:-1]), rtol=0.02)
    for rate in (course.rates.min(), course.rates.max()):
        assert any(f"{number:.6e}"[:8] in ("1.000000", "2.000000", "5.000000") for number in (rate, 1.0 / rate))


def test_a_film_is_as_long_as_it_is_asked_to_be(run):
    """It is the page's film, stretched evenly."""
    history = run("paper")
    course, page = time_map(history, seconds=12.0), time_map(history)
    assert make_timeline(course, fps=30).duration == pytest.approx(12.0, abs=0.1)
    times = np.linspace(*page.times[[0, -1]], 501)
    np.testing.assert_allclose(course.film_at(times) / 12.0, page.film_at(times) / page.duration, atol=1e-9)
