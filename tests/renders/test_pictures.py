"""Pictures of a run: the beam where it is, in the colour of its stress, with the numbers of that time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Text

from oblique_impact.contact.state import State
from oblique_impact.renders import scene as scenes
from oblique_impact.renders.frame import Composer
from oblique_impact.renders.player.content import content_of
from oblique_impact.renders.scene import Panel, Scene, View
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import BARE, Style
from oblique_impact.renders.surroundings import drawn_obstacles
from oblique_impact.renders.timeline import make_timeline

SIZE = (640, 360)
#: a strip of steel, 1 mm deep
SLENDER = ('beam.section={shape="rectangle", width=0.02, height=0.001}', "beam.material=steel", "end_time=0.33")


@pytest.fixture(scope="module")
def story(run):
    return story_of([run("paper")], Style(size=SIZE), ["run"])


@pytest.fixture(scope="module")
def strongest(story):
    """Time (s) of the largest force."""
    history = story.histories[0]
    return float(history["time"].values[int(np.argmax(np.nan_to_num(history["lambda_n"].values)))])


def words(composer):
    """All that is written in the frame that was drawn last."""
    return [text.get_text() for text in composer.sheet.figure.findobj(Text) if text.get_text()]


def scales_of(composer):
    """Labels of each scale of colours in a frame."""
    bars = [axes for axes in composer.sheet.figure.axes if axes.get_xlim() == (-1.0, 1.0)]
    return [[text.get_text() for text in axes.get_xticklabels()] for axes in bars]


def alone(story, time, **changes):
    """The picture of the beams and what stands around them, as integers; and the scene, which is closed."""
    style = replace(story.style, **(BARE | changes))
    scene = Scene(story, [Panel((0, 0, *SIZE), range(len(story.geometries)))], SIZE, style)
    picture = scene.draw(time).astype(int)
    return scene, picture


def projected(scene, points):
    """Pixels (n, 2) of points (n, 3), by VTK's own camera."""
    camera = scene.plotter.renderers[0].camera
    matrix = camera.GetCompositeProjectionTransformMatrix(SIZE[0] / SIZE[1], -1.0, 1.0)
    matrix = np.array([[matrix.GetElement(i, j) for j in range(4)] for i in range(4)])
    seen = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    return 0.5 * np.array(SIZE) * (np.array([1.0, 1.0]) + seen[:, :2] / seen[:, 3:] * np.array([1.0, -1.0]))


@pytest.mark.parametrize("camera", ["oblique", "front", "above"])
def test_the_beam_is_where_its_points_are_and_red_where_it_is_stretched(story, strongest, camera):
    geometry = story.geometries[0]
    scene, picture = alone(story, strongest, camera=camera)
    points, normals = geometry.tube(geometry.index(strongest))
    pixels, seen = projected(scene, points), normals @ scene.views[0].eye > 0.5
    scene.close()
    stress, limit = geometry.result("bending_stress", geometry.index(strongest)), story.colours.limit
    for sign in (-1.0,) if camera == "above" else (-1.0, 1.0):  # the stretched side is the lower one
        chosen = pixels[seen & (sign * stress > 0.3 * limit)].round().astype(int)
        assert len(chosen) > 10
        found = picture[chosen[:, 1], chosen[:, 0]]
        assert np.mean(sign * (found[:, 0] - found[:, 2]) > 20) > 0.8
    columns = np.flatnonzero((np.abs(picture - picture[0, 0]).max(axis=2) > 20).any(axis=0))
    assert columns[0] < pixels[:, 0].min() + 1.5
    assert columns[-1] > pixels[:, 0].max() - 1.5


def test_the_close_view_shows_each_of_the_sides_that_the_beam_strikes_and_none_from_behind(run):
    """The upper table, then the lower one."""
    story = story_of([run("gap", "end_time=0.22")], Style(size=SIZE))
    geometry = story.geometries[0]
    for collision in story.histories[0].macro_collisions:
        k = geometry.index(collision["start"])
        assert geometry.closed(k)[geometry.close_contact(k)]
    scene = Scene(story, [Panel((0, 0, *SIZE), [0], close=True)], SIZE)
    scene.close()
    assert all(scene.views[0].eye[:2] @ obstacle.normal >= 0.0 for obstacle in story.obstacles)


@pytest.mark.parametrize("case", ["paper", "shaken"])
def test_the_eye_is_on_the_side_of_the_beam_and_not_behind_the_stop(run, case):
    story = story_of([run(case)], Style(size=SIZE), ["run"])
    scene, _ = alone(story, 0.0, camera="oblique")
    scene.close()
    assert all(scene.views[0].eye[:2] @ obstacle.normal > 0.1 for obstacle in story.obstacles)


def test_the_close_view_of_a_wide_strip_looks_along_the_line_on_which_it_touches(run):
    story = story_of([run("paper", *SLENDER)], Style(size=SIZE))
    scene = Scene(story, [Panel((0, 0, *SIZE), [0], close=True)], SIZE)
    near = story.geometries[0].near_places(0)
    ends = projected(scene, np.concatenate([near, near * (1.0, 1.0, -1.0)]))
    scene.close()
    assert near[0, 2] == pytest.approx(0.01)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-6)


def test_the_arrow_points_along_the_force_to_the_contact_point(story, strongest):
    """Of the sign that the slope pushes with, as long as the root of the force; none in flight."""
    geometry = story.geometries[0]
    scene, with_arrow = alone(story, strongest, arrow=True, camera="front")
    again = scene.draw(strongest).astype(int)
    flight = scene.draw(0.1).astype(int)
    place = projected(scene, geometry.contact_place(geometry.index(strongest))[None])[0]
    scene.close()
    np.testing.assert_array_equal(with_arrow, again)
    others, without = alone(story, strongest, camera="front")
    others.close()
    orange = (with_arrow[..., 0] - with_arrow[..., 2] > 100) & (np.abs(with_arrow - without).max(axis=2) > 40)
    pixels = np.argwhere(orange)[:, ::-1] - place
    along = geometry.contact_force(geometry.index(strongest))[:2] * (1.0, -1.0)
    along /= np.linalg.norm(along)
    assert (pixels @ along).max() < 0.0
    assert np.abs(pixels @ (-along[1], along[0])).max() < 10.0
    assert np.ptp(pixels @ along) > 40.0
    assert not ((flight[..., 0] - flight[..., 2] > 150) & (flight[..., 1] < 150)).any()


#: a beam that slaps onto a table below it, and onto one above it
SLAPS = {
    "below": ("end_time=0.385",),
    "above": (
        *["end_time=0.07", "gravity=0.0", "initial.angle=-0.25", "initial.angular_velocity=4.6"],
        "obstacles=[{kind='side', origin=[0.0,0.02], angle=3.141592653589793}]",
    ),
}


@pytest.mark.parametrize("where", SLAPS)
def test_the_band_lies_on_the_face_from_the_first_to_the_last_closed_place(run, where):
    history = run("slap", *SLAPS[where])
    story = story_of([history], Style(size=SIZE))
    geometry, page = story.geometries[0], content_of(story)
    closed, places = history["contact_state"].values != State.FREE, history["contact_place"].values
    firsts, lasts = np.where(closed, places, np.inf).min(axis=1), np.where(closed, places, -np.inf).max(axis=1)
    k = int(np.argmax(lasts - firsts))
    first, last = firsts[k], lasts[k]
    assert last - first > 0.05
    (zone,) = geometry.zones(k)
    assert (zone.obstacle, zone.first, zone.last) == (1, first, last)
    frame = int(np.flatnonzero(page.arrays["time"] == geometry.times[k])[0])
    np.testing.assert_array_equal(page.arrays["zone"][frame], [[first, last]])
    free = np.flatnonzero(page.arrays["state"] == State.FREE)
    assert not page.arrays["zone"][free].any()
    # its ends are the places that the forces push on, on the side of the beam that touches
    face = geometry.face(k, page.facts["zone_sides"][0])
    ends = [[np.interp(place, geometry.stations, column) for column in face.T] for place in (first, last)]
    np.testing.assert_allclose(ends, geometry.contact_places(k)[closed[k]][[0, -1]], atol=1e-5)
    scene, picture = alone(story, geometry.times[k], arrow=True, camera="front")
    along = np.linspace(first + 0.02, last - 0.02, 30)
    points = np.stack([*(np.interp(along, geometry.stations, column) for column in face.T), 0.0 * along], axis=1)
    x, y = projected(scene, points).round().astype(int).T
    scene.close()
    assert np.mean(picture[y, x, 0] - picture[y, x, 2] > 100) > 0.7  # marks of forces are white


def test_the_close_view_tells_of_the_peg_that_is_struck_of_two_that_face_each_other(run):
    story = story_of([run("cantilever", "end_time=0.3")], Style(size=SIZE))
    geometry = story.geometries[0]
    struck = {contact.obstacle for contact in story.histories[0].contacts}
    for contact in story.histories[0].contacts:
        k = geometry.index(0.5 * (contact.start + contact.end))
        assert geometry.closed(k)[geometry.close_contact(k)]
    assert struck == {1, 2}


def test_the_close_view_stays_with_a_contact_until_it_opens_and_shows_its_force(run):
    story = story_of([run("slap", *SLAPS["below"])], Style(size=SIZE))
    geometry = story.geometries[0]
    closed = story.histories[0]["contact_state"].values != State.FREE
    shown = np.array([geometry.close_contact(k) for k in range(geometry.times.size)])
    touching, changed = np.flatnonzero(closed.any(axis=1)), np.flatnonzero(np.diff(shown)) + 1
    assert closed[touching, shown[touching]].all()
    assert not closed[changed, shown[changed - 1]].any()
    k = int(np.argmax(geometry.values("contact_lambda_n").max(axis=1)))
    with Composer(story) as composer:
        composer.draw(geometry.times[k])
        force = np.linalg.norm(geometry.pushes(k)[shown[k]])
        assert f"contact force {force:.0f} N" in words(composer)


def test_a_scale_bar_is_as_long_as_what_it_names(story):
    for camera in ("oblique", "front", "above"):
        scene, _ = alone(story, 0.1, camera=camera)
        bar = scene.views[0].scale_bar(150.0)
        ends = projected(scene, np.array([[0.2, 0.1, 0.0], [0.2 + bar.length, 0.1, 0.0]]))
        scene.close()
        np.testing.assert_allclose(bar.across, ends[1] - ends[0], atol=0.05)


def test_a_frame_tells_time_state_rate_force_and_gap(story):
    story = replace(story, style=Style((960, 540)))
    geometry = story.geometries[0]
    force = np.linalg.norm(geometry.contact_force(geometry.index(0.3232)))
    gap = 1e3 * float(geometry.value("gap", geometry.index(0.31)))
    with Composer(story, make_timeline(story.time_map, frames=4)) as composer:
        composer.draw(0.3232, 1 / 384)
        found = set(words(composer))
        assert {"t = 0.32320 s", "SLIP", "1/380 of real time", f"contact force {force:.0f} N"} <= found
        assert {"gap 0.000 mm", "contact force (N)", "energy (J)", "run", story.colours.title} <= found
        assert any(f"×{story.factor:g}" in text for text in found)
        assert scales_of(composer) == [[text for _, text in story.colours.ticks]]
        composer.draw(0.31, 2.5)
        assert {"FREE", "no contact force", f"gap {gap:.0f} mm"} <= set(words(composer))


def test_a_still_at_an_event_tells_which_side_of_the_jump_it_shows(story):
    event, geometry = story.histories[0].events[0], story.geometries[0]
    with Composer(replace(story, names=())) as composer:
        composer.draw(event.time)
        assert f"SLIP, just after the {event.kind.value}" in words(composer)
    left = int(np.flatnonzero(geometry.times == event.time)[0])
    sides = [geometry.beside(k) for k in (left, left + 1, left + 2)]
    assert sides == [f"just before the {event.kind.value}", f"just after the {event.kind.value}", ""]


@pytest.mark.parametrize("case", [("spin-up",), ("paper", *SLENDER)])
def test_a_beam_too_thin_to_be_seen_is_drawn_thicker_says_so_and_touches_the_slope_where_it_does(run, case):
    story = story_of([run(*case)], Style(size=SIZE))
    times = story.thickness
    assert times > 1.0
    thin, thick = story.geometries[0], story.drawn[0]
    with Composer(story) as composer:
        composer.draw(0.0)
        said = words(composer)
    assert any(f"thickness ×{times:g}" in text for text in said)
    assert ("contact point, true scale" in said) == (case[0] == "paper")
    k = int(np.argmax(np.abs(thin.values("lambda_n"))))
    np.testing.assert_allclose(thick.result("bending_stress", k), thin.result("bending_stress", k), rtol=1e-9)
    axis = thin.centreline(k)[thin.solid.rings]
    np.testing.assert_allclose(thick.tube(k)[0] - axis, times * (thin.tube(k)[0] - axis), atol=1e-9)
    if case[0] == "paper":
        (slope,) = drawn_obstacles(thick)
        away = thick.contact_places(k)[0] - slope.surface[0]
        assert away @ slope.normal == pytest.approx(0.0, abs=1e-9)
        lower = (thick.face(k, -1.0)[thick.touch] - slope.surface[0]) @ slope.normal
        assert lower == pytest.approx(0.0, abs=0.1 * thick.touch_radius)


def test_a_compliant_stop_tells_its_compression_and_what_is_drawn(run):
    """Few modes leave out a part of the beam's own flexibility; they are drawn deeper than the stop is pressed."""
    history = run("paper", "contact.normal=spring", "end_time=0.335")
    k = int(np.argmax(history["depth"].values))
    with Composer(story_of([history], Style(size=SIZE))) as composer:
        composer.draw(float(history["time"].values[k]))
        (said,) = (text for text in words(composer) if text.startswith("gap"))
    pressed, drawn = (1e3 * float(history[name].values[k]) for name in ("depth", "gap"))
    assert said == f"gap {-pressed:.3f} mm, drawn {drawn:.3f}".replace("-", "−")


def test_several_runs_share_one_scale_and_one_factor(run):
    soft, hard = run("paper"), run("sticking")
    single = [story_of([history]) for history in (soft, hard)]
    both = story_of([soft, hard], Style(size=(960, 540)), ["a", "b"])
    assert both.colours.limit == max(s.colours.limit for s in single)
    assert [g.factor for g in both.geometries] == [min(s.factor for s in single)] * 2
    with Composer(both) as composer:
        composer.draw(0.1)
        found = words(composer)
        ranges = [view.beams[0].actor.mapper.scalar_range for view in composer.scene.views]
        assert scales_of(composer) == 2 * [[text for _, text in both.colours.ticks]]
    assert {"a", "b"} <= set(found)
    limit = both.colours.limit / both.colours.unit[0]
    assert ranges == [(-limit, limit)] * 2


@pytest.mark.parametrize(
    "style",
    [
        Style((360, 640), theme="dark"),
        Style((480, 270), layout="overlay"),
        Style.of("paper", size=(480, 270), dpi=None),
    ],
)
def test_sizes_themes_and_presets(run, style):
    runs = [run("paper"), run("mid-span")] if style.layout == "overlay" else [run("paper")]
    story = story_of(runs, style, ["a", "b"][: len(runs)])
    with Composer(story, make_timeline(story.time_map, frames=10)) as composer:
        picture = composer.draw(0.3232, 0.01)
    assert picture.shape == (style.size[1], style.size[0], 3)
    paper = np.array([int(style.colours.background[k : k + 2], 16) for k in (1, 3, 5)])
    assert np.abs(picture[2, -3].astype(int) - paper).max() <= 2
    assert picture.std() > 5.0


def test_plane_faces_have_the_colours_that_their_light_gives_them(story, monkeypatch):
    """Each pixel of slope, ground and stand is as if VTK had lit it."""
    panels = [Panel((0, 0, 200, 160), [0]), Panel((200, 0, 120, 160), [0], close=True)]
    found = Scene(story, panels, (320, 160))
    monkeypatch.setattr(scenes, "View", lambda *given: View(*given[:-1], turns=True))
    lit = Scene(story, panels, (320, 160))
    for time in (0.0, 0.3232):
        np.testing.assert_allclose(found.draw(time).astype(int), lit.draw(time), atol=1)
    for scene in (found, lit):
        scene.close()


def test_a_frame_does_not_depend_on_those_before(story):
    """Texts that stay are copied from the second frame on."""
    timeline = make_timeline(story.time_map)
    with Composer(story, timeline) as composer:
        for time in (0.1, 0.1, 0.1, 0.3232, 0.1):
            last = composer.draw(time, 0.05)
    with Composer(story, timeline) as fresh:
        np.testing.assert_array_equal(fresh.draw(0.1, 0.05), last)
