"""Clearance of the beam from the slope, warnings about it, and ends of the slope."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.beam.bent_beam import BentBeam
from oblique_impact.beam.clearance import clearance_along
from oblique_impact.beam.cross_sections import Sections


def test_without_contact_there_is_no_distance(run):
    history = run("spin-up", "end_time=0.01")
    assert "clearance" not in history.data
    assert history.summary["clearance"] is None


# What is said ---------------------------------------------------------------------------------------------------


def about_slope(history):
    return [line for line in history.summary["warnings"] if "slope" in line]


def test_a_free_end_that_passes_the_slope_is_told(run):
    (line,) = about_slope(run("mid-span", "contact.where=point", "contact.point=0.6", "slope.extent=[]"))
    assert line == "passes 75 mm below the slope at x = 1 m; only x = 0.6 m is in contact"


@pytest.mark.parametrize(
    "case",
    [
        ("mid-span", "contact.where=point", "contact.point=0.6"),
        ("paper", 'solver.scheme="fixed-step"', "solver.contact_step=1e-5", "end_time=0.33"),
        ("paper", "contact.shortening=false", "end_time=0.4"),
    ],
    ids=lambda case: " ".join(case),
)
def test_a_mere_touch_is_no_passing(run, case):
    assert about_slope(run(*case)) == []


def test_a_side_that_the_beam_passes_where_nothing_touches_it_is_told(run):
    """The root is 0.1 m below the side, the free end above it; an elastic stop that is pressed in is not told."""
    side = ("slope.enabled=false", "contact.where='anywhere'", "contact.grid=1", "obstacles=[{origin=[0.0, 0.1]}]")
    history = run("paper", *side, "end_time=0.01")
    assert history.summary["clearance"] == {"distance": pytest.approx(-0.1), "x": 0.0, "time": 0.0, "obstacle": 1}
    (line,) = [line for line in history.summary["warnings"] if "passes" in line]
    assert line.startswith("passes 100 mm below obstacle 1 at x = 0 m")
    assert "contact.grid = 1" in line
    pressed = run("gap", "contact.normal='spring'", "end_time=0.2")
    assert pressed.summary["clearance"]["distance"] < -5e-4
    assert not [line for line in pressed.summary["warnings"] if "passes" in line]


def about_pegs(history):
    return [line for line in history.summary["warnings"] if line.startswith("passes through")]


@pytest.mark.parametrize("radius", [0.0, 0.02])
def test_a_beam_that_comes_to_a_peg_from_behind_passes_through_and_is_told(run, radius):
    """The beam turns away from a peg below it, at 6 rad/s; three quarters of a turn later it is there again."""
    peg = f"obstacles=[{{kind='point', origin=[0.0, -0.5], radius={radius}}}]"
    turning = ("discretization.frame=mean-axis", "gravity=0", "initial.angle=0", "end_time=0.9", peg)
    turning = (*turning, "slope.enabled=false", "contact.where='anywhere'", "solver.output_interval=1e-4")
    away = run("paper", *turning, "initial.angular_velocity=6")
    assert away.events == []
    (line,) = about_pegs(away)
    time = float(line.split("t = ")[1].split(" s")[0])
    assert line.startswith("passes through obstacle 1 at t = ")
    assert time == pytest.approx((1.5 * np.pi - np.arcsin(radius / 0.5)) / 6.0, abs=3e-4)
    least = away.summary["clearance"]
    assert least["distance"] == pytest.approx(-radius, abs=1e-4)
    assert least["time"] == pytest.approx(1.5 * np.pi / 6.0, abs=1e-4)
    # towards the peg it strikes it, and nothing is told
    towards = run("paper", *turning, "initial.angular_velocity=-6", "end_time=0.4")
    assert towards.events
    assert about_pegs(towards) == []
    assert towards["clearance"].values.min() > -1e-6


@pytest.mark.parametrize("case", ["two-pegs", "gap", "mid-span"])
@pytest.mark.parametrize("changes", [(), ("contact.normal='spring'",)], ids=["rigid", "spring"])
def test_a_beam_that_meets_its_obstacles_passes_through_none(run, case, changes):
    history = run(case, *changes, "end_time=0.45")
    assert history.contacts
    assert not [line for line in history.summary["warnings"] if "passes" in line]


def test_the_clearance_of_a_pressed_peg_is_its_gap(run):
    """Of a point there is no inside, the distance from it has no sign: the contact knows how deep it is."""
    peg = "obstacles=[{kind='point', origin=[0.5, 0.0]}]"
    onto = ("slope.enabled=false", "contact.where='anywhere'", "contact.normal='spring'", peg, "end_time=0.4")
    history = run("paper", "discretization.frame=mean-axis", *onto)
    gap, clearance = history["contact_gap"].values[:, 0], history["clearance"].values
    pressed = (history["contact_state"].values[:, 0] != 0) & (gap < 0.0)
    assert gap[pressed].min() < -1e-4
    np.testing.assert_allclose(clearance[pressed], gap[pressed], rtol=0.0, atol=1e-15)
    assert (clearance[~pressed] > -1e-9).all()
    found = history.summary["clearance"]
    assert (found["distance"], found["obstacle"]) == (pytest.approx(gap.min()), 1)
    assert found["x"] == pytest.approx(0.5, abs=1e-3)
    assert about_pegs(history) == []


def test_beyond_the_end_the_beam_falls_past(run):
    """No force in mid-air: the motion is that without a slope, and the passage is recorded and told."""
    history = run("paper", "slope.extent=[0.0, 0.5]", "end_time=0.4")
    assert history.events == []
    assert np.all(history["lambda_n"].values == 0.0)
    alone = run("paper", "contact.enabled=false", "end_time=0.4")
    assert float(history["theta"][-1]) == pytest.approx(float(alone["theta"][-1]), abs=1e-8)
    (passed,) = history.summary["slope_ends"]
    assert (passed["how"], passed["end"]) == ("falls past", 0.5)
    assert passed["place"] == pytest.approx(0.710377, abs=5e-5)
    assert any("falls past slope.extent = [0, 0.5]" in line for line in about_slope(history))


SLIDING = {  # other schemes: tests/small/test_slope_ends.py
    "rigid, event": ("paper", 0.71017, "end_time=0.33"),
    "spring, exact": (
        *("paper", 0.71018, "contact.normal='spring'", "contact.friction='frictionless'", "end_time=0.3225"),
        *("discretization.method='absolute'", "discretization.frame='mean-axis'", "discretization.elements=4"),
        *("solver.free_step=1e-3", "solver.contact_step=2e-5", "solver.output_interval=1e-3"),
    ),
}


@pytest.mark.parametrize("name", SLIDING)
def test_contact_ends_where_the_contact_point_slides_beyond_an_end(run, name):
    """Of the unbounded slope the slip says when; up to there the motion is the same."""
    case, first, *changes = SLIDING[name]
    whole = run(case, *changes)
    history = run(case, f"slope.extent=[{first}, 0.8]", *changes)
    (*before, last) = history.events
    assert [e.kind for e in before] == [e.kind for e in whole.events[: len(before)]]
    np.testing.assert_allclose([e.time for e in before], [e.time for e in whole.events[: len(before)]], rtol=1e-9)
    if "exact" not in name:  # of which few samples are kept
        slip = np.interp(last.time, whole["time"].values, whole["slip"].values)
        assert slip == pytest.approx(first, abs=1e-6)
    assert last.kind.value == "release"
    passed = history.summary["slope_ends"][0]
    assert (passed["how"], passed["time"], passed["end"]) == ("slides off", last.time, first)
    assert passed["place"] == pytest.approx(first, abs=1e-11)
    after = history["time"].values > last.time
    assert np.all(history["lambda_n"].values[after] == 0.0)
    assert np.all(history["state"].values[after] == 0)
    assert abs(history.summary["energy"]["unaccounted"]) < 1e-6
    assert history.contacts[-1].end == last.time
    assert any("slides off slope.extent" in line for line in about_slope(history))


def test_a_start_beyond_the_end_may_be_below_the_slope():
    """Hanging straight down: the line of the slope is above the tip, its end is beside it."""
    hanging = {"initial__angle": -np.pi / 2, "slope__origin": (0.5, 0.0), "slope__angle": 0.0, "end_time": 0.01}
    with pytest.raises(InputError, match=r"^initial.angle = .*m below the slope"):
        Scenario().replace(**hanging)
    history = simulate(Scenario().replace(**hanging, slope__extent=(0.0, 1.0)))
    assert history.events == []
    assert history.summary["slope_ends"] == []


# Geometry -------------------------------------------------------------------------------------------------------


def of_straight_beam(scenario, stations, angle=0.0, rise=0.0):
    """Clearance of a straight axis of length 1 from the origin, raised by some heights (m)."""
    heights = np.atleast_1d(rise)
    x, theta = np.linspace(0.0, 1.0, stations), np.full((heights.size, 1), angle)
    bent = BentBeam(theta, x, 1j * np.repeat(heights[:, None], stations, axis=1))
    return clearance_along(scenario, Sections.from_scenario(scenario), bent, {"station": x}, on_side=[True])


OBSTACLES = (
    {"kind": "side", "origin": (0.0, 0.8), "angle": np.pi, "extent": (-0.6, 0.0)},  # solid above the beam
    {"kind": "point", "origin": (0.37, 0.3), "radius": 0.1},
)


@pytest.mark.parametrize(("surface", "depth"), [("axis", 0.0), ("section", 0.02)])
def test_the_nearest_of_several_obstacles(surface, depth):
    """A horizontal axis of length 1 that rises through a peg to a side; on both sides of a peg it is positive."""
    scenario = Scenario().replace(
        beam__outer_fibre=0.02,
        initial__angle=0.0,
        slope__enabled=False,
        contact__where="anywhere",
        contact__surface=surface,
        obstacles=OBSTACLES,
    )
    found = of_straight_beam(scenario, 101, rise=[0.0, 0.22, 0.295, 0.305, 0.5, 0.75])
    exact = np.array([0.2, -0.02, -0.095, -0.095, 0.1, 0.05]) - depth
    np.testing.assert_allclose(found["clearance"], exact, atol=1e-12)
    np.testing.assert_allclose(found["clearance_at"][:-1], 0.37, atol=1e-12)
    assert found["clearance_obstacle"].tolist() == [2, 2, 2, 2, 2, 1]


def test_a_peg_between_two_stations_is_as_near_as_its_contact_says(run):
    """A station is up to 16 mm from where the beam touches: without the gap the distance would jump there."""
    history = run("two-pegs", "end_time=0.45")
    gap, place = history["contact_gap"].values, history["contact_place"].values
    clearance = history["clearance"].values
    beside = (place >= 0.0) & (place <= 1.0)
    assert np.all(clearance[:, None] <= np.where(beside, gap, np.inf) + 1e-12)
    closed = history["contact_state"].values.any(axis=1)
    assert closed.any()
    assert np.abs(clearance[closed]).max() < 1e-9
    fastest = np.abs(np.diff(gap, axis=0)).max()
    assert np.abs(np.diff(clearance)).max() < fastest + 1e-12
