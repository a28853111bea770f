"""Pictures without baselines: silhouettes where points project to, colours by sign, frames that differ."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oblique_impact import InputError
from oblique_impact.renders import scene
from oblique_impact.renders.backdrop import picture_of, reduced
from oblique_impact.renders.beam3d import CAMERAS, contact_force
from oblique_impact.renders.difference import magnify_difference
from oblique_impact.renders.frame import Composer
from oblique_impact.renders.scene import View
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import DARK, LIGHT, Style
from oblique_impact.renders.timeline import make_timeline

BARE = Style(ghosts=False, trace=False, arrow=False, ground=False)
SIZE = (480, 320)


@pytest.fixture(scope="module")
def story(run):
    return story_of([run("paper")], BARE)


@pytest.fixture(scope="module")
def geometry(story):
    return story.geometries[0]


def strongest(geometry):
    force = np.nan_to_num(geometry.history["lambda_n"].values)
    return float(geometry.times[int(np.argmax(force))])


def drawn(view, time):
    return np.asarray(view.draw(time)).astype(int)


def view_of(story, **changes):
    return View(story, [0], SIZE, style=replace(BARE, **changes))


@pytest.fixture(scope="module")
def view(story):
    view = view_of(story)
    yield view
    view.close()


@pytest.mark.parametrize("camera", ["oblique", "front", "above"])
def test_the_silhouette_is_where_the_points_project_to(story, geometry, camera):
    view = view_of(story, camera=camera)
    time = 0.15  # in flight, away from pin and slope
    picture = drawn(view, time)
    points = geometry.surface(geometry.index(time)).points
    pixels = view.project(points)
    assert pixels.min() > 0.0
    assert np.all(pixels.max(axis=0) < SIZE)
    covered = np.abs(picture - 255).max(axis=2) > 12
    # right of the middle there is nothing but the beam above its lowest point
    right = pixels[:, 0].max()
    columns = np.flatnonzero(covered[: int(pixels[:, 1].min()) + 40].any(axis=0))
    assert abs(columns.max() - right) < 1.5
    top = np.flatnonzero(covered.any(axis=1)).min()
    assert abs(top - pixels[:, 1].min()) < 1.5
    view.close()


def test_colour_tells_the_sign_of_the_stress(story, geometry):
    """Red where the fibre is stretched, blue where it is compressed."""
    view = View(story, [0], (1280, 800))
    time = strongest(geometry)
    surface = geometry.surface(geometry.index(time))
    picture = drawn(view, time)
    stress, eye = surface.arrays["bending_stress"], CAMERAS["oblique"] / np.linalg.norm(CAMERAS["oblique"])
    for sign in (1.0, -1.0):
        # points that face the camera and carry at least 30 % of the largest stress
        facing = (surface.normals @ eye > 0.5) & (sign * stress > 0.3 * np.abs(stress).max())
        x, y = view.project(surface.points[facing]).round().astype(int).T
        redder = sign * (picture[y, x, 0] - picture[y, x, 2])
        assert redder.size > 10
        assert redder.min() > 15
    view.close()


def test_the_contact_touches(geometry, view):
    """The lowest point of the tip lies on the drawn slope: there is no gap of background between them."""
    time = 0.3183  # in the middle of the first contact
    picture = drawn(view, time)
    touch = geometry.contact_place(geometry.index(time))
    x, y = view.project(touch[None])[0].round().astype(int)
    around = picture[y - 2 : y + 3, x - 2 : x + 3].reshape(-1, 3)
    assert np.all(np.abs(around - 255).max(axis=1) > 12)


def test_frames_differ_and_repeat(view):
    first, second = drawn(view, 0.1), drawn(view, 0.2)
    assert np.abs(first - second).max() > 50
    np.testing.assert_array_equal(drawn(view, 0.1), first)


def rgb(colour):
    return np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)])


def arrow_of(story, time, camera, close):
    """Pixels (n, 2) in the colour of the arrow; in the picture, direction of the force and point of contact."""
    view = View(story, [0], SIZE, style=replace(BARE, arrow=True, camera=camera), close=close)
    picture, geometry = drawn(view, time), story.geometries[0]
    k = geometry.index(time)
    place = geometry.contact_place(k)
    force = contact_force(geometry, k)
    ends = view.project(np.array([place, place + 0.1 * np.append(force / np.linalg.norm(force), 0.0)]))
    view.close()
    rows, columns = np.nonzero(np.abs(picture - rgb(LIGHT.arrow)).max(axis=2) < 40)
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    return np.stack([columns + 0.5, rows + 0.5], axis=1), along, ends[0]


def check_arrow(pixels, along, place):
    """It lies outside of the beam, behind the point of contact that it points to, and has its head in front."""
    offsets = pixels - place
    ahead, aside = offsets @ along, np.abs(offsets @ np.array([-along[1], along[0]]))
    assert pixels.shape[0] > 40
    assert np.linalg.norm(offsets, axis=1).min() > 3.0  # the point of contact is not covered
    assert ahead.max() < 0.0
    assert ahead.max() > -12.0
    assert aside.max() < 8.0
    middle = 0.5 * (ahead.max() + ahead.min())
    assert aside[ahead > middle].max() > 1.5 * aside[ahead < middle].max()


def check_arrow_outline(corners, along, place, length):
    """Corners of an arrow of this length: it ends just before the place that it points to, with its head."""
    ahead, aside = (corners - place) @ along, (corners - place) @ np.array([-along[1], along[0]])
    assert -12.0 < ahead.max() < -3.0
    assert ahead.max() - ahead.min() == pytest.approx(length, rel=1e-6)
    assert aside[np.argmax(ahead)] == pytest.approx(0.0, abs=1e-6)
    assert ahead[np.argmax(np.abs(aside))] > ahead.max() - 0.7 * length
    assert np.abs(aside[ahead == ahead.min()]).max() < 0.5 * np.abs(aside).max()


@pytest.mark.parametrize("camera", ["oblique", "front", "above"])
@pytest.mark.parametrize("close", [False, True])
def test_the_arrow_points_along_the_force_and_leaves_the_contact_point_free(story, geometry, camera, close):
    for time in (strongest(geometry), 0.3256):  # slipping down and up the slope
        pixels, along, place = arrow_of(story, time, camera, close)
        check_arrow(pixels, along, place)
        with pytest.raises(AssertionError):  # as it would be with the other sign
            check_arrow(pixels, -along, place)


def test_the_arrow_is_as_long_as_the_root_of_the_force(story, geometry, monkeypatch):
    """0.16 of the beam's length at the largest force of the run, seen from the front."""
    lengths, outline = [], scene.arrow_outline

    def spy(tip, along, length, unit):
        lengths.append(length)
        return outline(tip, along, length, unit)

    monkeypatch.setattr(scene, "arrow_outline", spy)
    view = view_of(story, arrow=True, camera="front")
    pixels = view.project(np.array([[0.0, 0.0, 0.0], [geometry.scenario.beam.length, 0.0, 0.0]]))
    longest = 2.0 * 0.16 * (pixels[1, 0] - pixels[0, 0])  # the window is twice as large
    for time in (strongest(geometry), 0.3232, 0.3256):
        view.draw(time)
        part = np.linalg.norm(contact_force(geometry, geometry.index(time))) / geometry.peak_force
        assert lengths.pop() == pytest.approx(longest * np.sqrt(part), rel=1e-6)
    view.close()


def test_trace_and_ghosts_are_the_past(story, geometry):
    """The path of the contact point up to the time; the beam at twelfths of the run, the newest one strongest."""
    view = view_of(story, trace=True, ghosts=True)
    time, beam = 0.42, view._beams[0]
    beam.move(time)
    seen, place = beam._trace_times <= time, geometry.contact_point(geometry.index(time))
    path = np.array([geometry.contact_point(geometry.index(t)) for t in beam._trace_times[seen]])
    np.testing.assert_allclose(beam._trace.points[seen, :2], path, atol=1e-6)
    np.testing.assert_allclose(
        beam._trace.points[~seen, :2], np.broadcast_to(place, ((~seen).sum(), 2)), atol=1e-6
    )
    for n, (mesh, actor) in enumerate(beam._ghosts):
        assert actor.visibility
        surface = geometry.surface(geometry.index((4 - n) / 12.0))
        behind = 4.0 * (n + 1) * geometry.radii.max() * beam._eye
        np.testing.assert_allclose(mesh.points, surface.points - behind, atol=1e-6)
    strength = [np.abs(255 * np.array(actor.prop.color.float_rgb) - 255).sum() for _, actor in beam._ghosts]
    assert strength == sorted(strength, reverse=True)
    assert strength[-1] > 0.0
    view.close()


@pytest.mark.parametrize("layout", ["one", "overlay"])
def test_what_moves_and_what_stands_still_are_one_picture(run, layout):
    """Drawn in two parts or all at once, after other frames or alone, behind pin and slope or before them."""
    names = ["hybrid", "frictionless"][: 1 if layout == "one" else 2]
    runs = [run("paper", f"contact.friction={name}") for name in names]
    story = story_of(runs, replace(BARE, ghosts=True, trace=True, layout="overlay"), names)
    numbers = list(range(len(runs)))
    for camera in ("oblique", "above"):
        view, style = View(story, numbers, SIZE, style=replace(story.style, camera=camera)), story.style
        for time in (0.0, 0.1, 0.3232, 0.42, 0.9):
            picture = drawn(view, time)
            alone = View(story, numbers, SIZE, style=replace(style, camera=camera))
            np.testing.assert_array_equal(drawn(alone, time), picture)
            alone._show(still=True)
            for beam in alone._beams:
                beam.show_moving(True)
            whole = reduced(alone._read(0, 0, *alone._window.GetSize()))
            alone.close()
            np.testing.assert_array_equal(np.asarray(whole), picture)
        view.close()


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("camera", ["oblique", "above"])  # from the front the slope's surface is a line
def test_the_slope_is_lit_as_vtk_lights_it(story, camera, theme):
    view = view_of(story, camera=camera, theme=theme)
    view.draw(0.1)
    view._show(still=True)
    flat = view._still[1]
    plain = flat.mapper.dataset.copy()
    plain.clear_data()
    colours = DARK if theme == "dark" else LIGHT
    lit = view.plotter.add_mesh(plain, color=colours.slope, **scene._SOLID)
    pictures = []
    for shown in (flat, lit):
        for actor in view.plotter.actors.values():
            actor.visibility = actor is shown
        pixels = view._read(0, 0, *view._window.GetSize())
        pictures.append(np.asarray(picture_of(pixels).convert("RGB")).astype(int))
    view.close()
    assert (np.abs(pictures[0] - rgb(colours.background)).max(axis=2) > 20).sum() > 1000
    assert np.abs(pictures[0] - pictures[1]).max() <= 1


def test_the_force_is_that_of_the_slope_on_the_beam(geometry):
    """It pushes the beam off the slope, and friction acts against the velocity of the contact point."""
    angle = geometry.scenario.slope.angle
    tangent = np.array([np.cos(angle), np.sin(angle)])
    for time in (0.3185, 0.3232, 0.3256):
        k = geometry.index(time)
        force, velocity = contact_force(geometry, k), [geometry.value(n, k) for n in ("tip_vx", "tip_vy")]
        normal = np.array([-tangent[1], tangent[0]])
        assert force @ normal == pytest.approx(float(geometry.value("lambda_n", k)), rel=1e-12)
        assert force @ tangent == pytest.approx(float(geometry.value("lambda_tau", k)), rel=1e-12)
        assert force @ normal > 10.0
        assert (force @ tangent) * (velocity @ tangent) < 0.0


def test_a_force_that_is_a_small_part_of_the_largest_one_has_an_arrow(story, geometry):
    view = view_of(story, arrow=True)
    force = np.hypot(*(np.nan_to_num(geometry.history[name].values) for name in ("lambda_n", "lambda_tau")))
    weak = np.flatnonzero((force > 0.002 * force.max()) & (force < 0.05 * force.max()))
    for k in weak[[0, len(weak) // 2, -1]]:
        place, acting = view._beams[0].force_at(float(geometry.times[k]))
        np.testing.assert_allclose(place, geometry.contact_place(k))
        assert np.linalg.norm(acting) == pytest.approx(force[k] / force.max())
    view.close()


def test_without_a_force_there_is_no_arrow(story):
    view = view_of(story, arrow=True)
    assert not np.any(np.abs(drawn(view, 0.15) - rgb(LIGHT.arrow)).max(axis=2) < 40)
    view.close()


def test_a_frame_has_all_its_parts(run):
    story = story_of([run("paper")], Style(size=(960, 540)))
    composer = Composer(story, make_timeline(story.time_map, frames=10))
    picture = np.asarray(composer.draw(0.3232, 0.002)).astype(int)
    composer.close()
    assert picture.shape == (540, 960, 3)
    slip = np.array([int(LIGHT.states[1][k : k + 2], 16) for k in (1, 3, 5)])
    title = picture[20:70, :400].reshape(-1, 3)
    assert (np.abs(title - slip).max(axis=1) < 8).sum() > 50  # the state in its colour
    chart = picture[370:, :500].reshape(-1, 3)
    assert (np.abs(chart - 255).max(axis=1) > 20).mean() > 0.01
    assert np.abs(picture[:, 700:] - 255).max() > 50


def test_themes_and_layouts(run):
    dark = Composer(story_of([run("paper")], Style(size=(480, 320), theme="dark")))
    picture = np.asarray(dark.draw(0.1))
    assert tuple(picture[-1, 0]) == tuple(int(DARK.background[k : k + 2], 16) for k in (1, 3, 5))
    dark.close()
    three = [run("paper", f"contact.friction={f}") for f in ("hybrid", "frictionless", "modified-coulomb")]
    for layout in ("side-by-side", "overlay"):
        composer = Composer(story_of(three, Style(size=(960, 320), layout=layout), ["a", "b", "c"]))
        assert np.asarray(composer.draw(0.69)).std() > 5.0
        composer.close()


@pytest.mark.parametrize(
    ("options", "key"),
    [
        ({"theme": "blue"}, "--theme blue"),
        ({"camera": "below"}, "--camera below"),
        ({"quantity": "taste"}, "--colour taste"),
        ({"layout": "stack"}, "--layout stack"),
        ({"size": (10, 10)}, "--size 10x10"),
    ],
)
def test_unknown_names_are_one_line(options, key):
    with pytest.raises(InputError) as error:
        Style(**options)
    assert str(error.value).startswith(key)
    assert "should be" in str(error.value)


def test_a_magnified_difference(run):
    modal, fem = run("paper"), run("paper", "discretization.method=fem")
    same = magnify_difference(modal, modal, 1e6)
    for name in ("theta", "ux", "uy"):
        np.testing.assert_allclose(same[name].values, modal[name].values, atol=1e-9)
    shown = magnify_difference(modal, fem, 1e4)
    k = 1000
    assert fem["time"].values[k] == modal["time"].values[k]
    for name in ("theta", "ux", "uy"):
        expected = modal[name].values[k] + 1e4 * (fem[name].values[k] - modal[name].values[k])
        np.testing.assert_allclose(shown[name].values[k], expected, rtol=0.0, atol=1e-12)
        assert np.abs(expected - fem[name].values[k]).max() > 1e-10
    with pytest.raises(InputError, match="--magnify-difference"):
        magnify_difference(modal, fem, 0.0)
