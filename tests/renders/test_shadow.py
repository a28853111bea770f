"""The ground and its soft shadows: below the beam, on the right surface, wide and pale with height."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oblique_impact.renders.ground import ground_of
from oblique_impact.renders.scene import View
from oblique_impact.renders.shadow import Caster, Part, Surface, part_of, shadow_around, shadow_on
from oblique_impact.renders.slope import DrawnSlope
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style

PLAIN = Style(ghosts=False, trace=False, arrow=False)
SIZE = (800, 560)


@pytest.fixture(scope="module")
def story(run):
    return story_of([run("paper")], PLAIN)


def view_of(story, **changes):
    return View(story, [0], SIZE, style=replace(PLAIN, **changes))


def darkened(story, time, **changes):
    """By how much the shadows of the moving beam darken each pixel (rows, columns), and the view."""
    view = view_of(story, **changes)
    picture = np.asarray(view.draw(time)).astype(int)
    surfaces, view._surfaces = view._surfaces, []
    without = np.asarray(view.draw(time)).astype(int)
    view._surfaces = surfaces
    return (without - picture).max(axis=2), view


def at(view, points, found):
    x, y = np.round(view.project(np.asarray(points))).astype(int).T
    return found[y, x]


@pytest.mark.parametrize("theme", ["light", "dark", "print"])
@pytest.mark.parametrize("camera", ["oblique", "above"])
def test_the_shadow_lies_below_the_beam(story, camera, theme):
    """Darkest where the plumb line from the axis meets the ground, pale beside it, and nowhere beyond the beam."""
    time, ground = 0.15, story.ground
    found, view = darkened(story, time, camera=camera, theme=theme)
    geometry = story.geometries[0]
    axis = geometry.centreline(geometry.index(time))
    x = np.linspace(0.15, 0.55, 9)  # between the pin and the block under the slope
    below = [
        at(view, np.stack([x, np.full(9, ground.y), np.full(9, z)], axis=1), found) for z in (0.0, -0.085, 0.085)
    ]
    beyond = at(view, [[-0.05, ground.y, 0.06], [ground.last - 0.01, ground.y, 0.0]], found)
    view.close()
    assert below[0].min() >= 2
    assert np.all(below[0] > below[1])
    assert np.all(below[0] > below[2])
    # the beam rises: farther from the pin it is higher, and its shadow paler
    assert np.all(np.diff(axis[:, 1]) > 0.0)
    assert below[0][0] > 1.5 * below[0][-1]
    assert beyond.max() == 0


def test_the_beam_itself_pin_and_sides_of_the_slope_are_not_darkened(story):
    """Only pixels in the colours of the ground and of the upper side of the slope change."""
    view = view_of(story)
    time = 0.3183
    picture = np.asarray(view.draw(time)).astype(int)
    surfaces, view._surfaces = view._surfaces, []
    without = np.asarray(view.draw(time)).astype(int)
    tops = [np.frombuffer(surface.tones[:1].tobytes(), np.uint8)[:3].astype(int) for surface in surfaces]
    view.close()
    changed = np.abs(picture - without).max(axis=2) > 6
    assert changed.sum() > 200
    near = np.min([np.abs(without[changed] - top).max(axis=1) for top in tops], axis=0)
    # but for edges, where a pixel of the picture is the mean of several
    assert np.mean(near < 40) > 0.97


def test_the_contact_point_has_its_shadow_on_the_slope(story):
    """In the close view too: close to the beam while it touches, farther away and paler while it is higher."""
    dark = []
    for time in (0.3183, 0.31, 0.29):
        view = View(story, [0], (420, 420), style=PLAIN, close=True)
        shown = np.asarray(view.draw(time)).astype(int)
        surfaces, view._surfaces = view._surfaces, []
        dark.append(int((np.asarray(view.draw(time)).astype(int) - shown).max()))
        view._surfaces = surfaces
        view.close()
    assert dark[0] > dark[1] > dark[2] >= 0
    assert dark[0] > 30


def test_a_shadow_falls_straight_down_and_grows_with_height():
    """On a level surface, seen from above at 100 pixels per metre: no formula of the program."""
    surface = Surface.of(np.array([[0.0, 0.0], [2.0, 0.0]]), 1.0, np.array([200, 200, 200], np.uint8))

    def project(points):
        points = np.asarray(points)
        return np.stack([100.0 * points[:, 0], 100.0 * (1.0 + points[:, 2])], axis=1)

    def see(ends, reach):
        return part_of(surface, project, (200, 200), ends, reach)

    x = np.linspace(0.5, 1.5, 21)
    widths, peaks = [], []
    for height in (0.05, 0.5, 2.0):
        caster = Caster(np.stack([x, np.full(21, height)], axis=1), np.full(21, 0.05))
        shadow = shadow_on(surface, [caster], see)
        levels = np.zeros((200, 200), int)
        left, top, right, bottom = shadow.box
        levels[top:bottom, left:right] = shadow.levels
        column = levels[:, 100]
        rows = np.flatnonzero(column)
        assert 0.5 * (rows[0] + rows[-1] + 1) == pytest.approx(100.0, abs=1.0)  # in the plane of motion
        if height < 1.0:
            assert levels[:, :20].max() == 0  # 0.3 m from its end
        widths.append(rows.size)
        peaks.append(column.max())
    assert widths[0] < widths[1] < widths[2]
    assert peaks[0] > peaks[1] > peaks[2] > 0
    below = Caster(np.stack([x + 5.0, np.full(21, 0.05)], axis=1), np.full(21, 0.05))
    assert shadow_on(surface, [below], see) is None  # beyond the surface


def test_what_stands_on_the_ground_has_a_shadow_around_it_that_fades():
    x, z = np.meshgrid(np.linspace(-0.2, 0.6, 81), np.linspace(-0.3, 0.3, 61))
    seen = Part((0, 0, 81, 61), x, z, x > -0.195)
    levels = shadow_around([(0.0, 0.4, 0.1)], 0.05, seen).levels.astype(int)
    under = (x >= 0.0) & (x <= 0.4) & (np.abs(z) <= 0.1)
    assert np.ptp(levels[under]) == 0
    assert levels[under].min() == levels.max()
    right, ahead = levels[30, 60:], levels[40:, 40]  # away from its edges
    for way in (right, ahead):
        assert way[0] == levels.max()
        assert np.all(np.diff(way) <= 0)
        assert way[-1] == 0 < way[3]
    np.testing.assert_array_equal(right[:11], ahead[:11])
    np.testing.assert_array_equal(levels[:, 1:], levels[::-1, 1:])
    np.testing.assert_array_equal(levels[:, 1:-1], levels[:, -2:0:-1])
    assert levels[:, 0].max() == 0  # beyond the ground


def test_a_mass_at_the_tip_throws_its_shadow_at_the_tip(run):
    story = story_of([run("tapered", "end_time=0.01")], PLAIN)
    (beam,) = (view := View(story, [0], (320, 200)))._beams
    radii, geometry = beam.caster(0.0).radii, story.geometries[0]
    assert radii[0] == geometry.radii[0]
    assert radii[-1] == geometry.mass_radius > geometry.radii[-1]
    view.close()


def test_a_frame_does_not_depend_on_the_frames_before_it(story):
    view = view_of(story)
    first = np.asarray(view.draw(0.1))
    view.draw(0.25)
    np.testing.assert_array_equal(np.asarray(view.draw(0.1)), first)
    view.close()


def test_everything_stands_on_the_ground_and_the_beam_stays_above_it(run):
    for name in ("paper", "mid-span", "sticking", "tapered"):
        story = story_of([run(name, "end_time=0.6")])
        ground, geometry = story.ground, story.geometries[0]
        places = geometry.stations_of(np.arange(geometry.times.size))
        assert places[..., 1].min() > ground.y
        assert ground.first < min(places[..., 0].min(), story.slope.outline[:, 0].min())
        assert ground.last > max(places[..., 0].max(), story.slope.outline[:, 0].max())
        assert ground.y <= min(story.slope.outline[:, 1].min(), -6.0 * geometry.radii[0])
        view = View(story, [0], (320, 200))
        left, right, _ = np.array(view._footprints).T
        view.close()
        assert len(left) >= 2
        assert ((left < 0.0) & (right > 0.0)).any()  # the pin
        middle = story.slope.outline[:, 0].mean()
        assert ((left < middle + 0.1) & (right > middle - 0.1)).any()  # the slope, or the block under it


def test_without_gravity_or_slope_or_room_there_is_no_ground(run):
    assert story_of([run("spin-up", "end_time=0.01")]).ground is None
    assert story_of([run("paper", "end_time=0.01", "gravity=0")]).ground is None
    low = story_of([run("paper", "end_time=0.01", "initial.angle=-0.5", "slope.origin=[0.3, -1.0]")])
    assert low.ground.y < -np.sin(0.5)
    above = DrawnSlope(low.slope.ends, low.slope.outline + np.array([0.0, 2.0]))
    assert ground_of(low.geometries, above) is None  # the beam would be below it


def test_bare_pictures_and_strips_have_none(story):
    view = view_of(story, ground=False)
    assert (view._surfaces, view._footprints) == ([], [])
    view.close()
