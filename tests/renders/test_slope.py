"""One drawn slope: the same corners in overview, film, page and export, where the beam touches it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from oblique_impact.renders import overview
from oblique_impact.renders.exports.parts import parts_of
from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.player.content import content_of
from oblique_impact.renders.scene import View
from oblique_impact.renders.slope import DrawnSlope, drawn_slope
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import LIGHT, Style

#: the slope is that of all samples, however many
FEW = "solver.output_interval=1e-3"
CASES = {
    "paper": ("paper", "end_time=0.4", FEW),
    "ledge": ("mid-span", FEW),
    "mid-span without ends": ("mid-span", "slope.extent=[]", FEW),
    "tapered": ("tapered", "end_time=0.34", "contact.point=0.8", FEW),
    "steep": ("sticking", "slope.angle=1.2", "slope.origin=[0.5, 0.0]", "initial.angle=1.5", "end_time=0.1", FEW),
    "never reached": ("paper", "end_time=0.1", FEW),
}


@pytest.fixture(params=CASES)
def history(run, request):
    return run(*CASES[request.param])


def corners(story):
    """Corners (4, 2) of the slope as each kind of picture draws it."""
    axes = Figure().subplots()
    overview._draw_motion(axes, story, LIGHT, 0.1)
    (patch,) = (p for p in axes.patches if p.get_gid() == "slope")
    view = View(story, [0], (320, 200))
    solids = [np.asarray(mesh.points) for mesh in view.plotter.meshes if mesh.n_points == 8 and mesh.n_cells == 6]
    view.close()
    exported = np.asarray(parts_of(story)[-1].mesh(0).points)
    return {
        "overview": patch.get_xy()[:4],
        "film": front(solids[0]),
        "page": np.array(content_of(story, 20).facts["slope"]),
        "export": front(exported),
    }


def front(points):
    """Corners (4, 2) of a prism's front."""
    return points[points[:, 2] == points[:, 2].max()][:, :2]


def same(found, expected):
    """Whether corners are equal, in whatever order a solid has them, to the rounding of float32."""
    apart = np.linalg.norm(found[:, None] - expected, axis=-1)
    return found.shape == expected.shape and apart.min(axis=0).max() < 1e-6 > apart.min(axis=1).max()


def test_all_pictures_draw_the_same_slope(history):
    expected = drawn_slope(BeamGeometry(history)).outline
    for factor in (1.0, 50.0):
        story = story_of(
            [history], Style(deformation=factor, ghosts=False, trace=False, arrow=False, ground=False)
        )
        for name, found in corners(story).items():
            assert same(found, expected), (name, factor)


def test_all_pictures_take_the_slope_of_the_story(run, monkeypatch):
    story = story_of([run(*CASES["paper"])], Style(ghosts=False, trace=False, arrow=False, ground=False))
    shifted = DrawnSlope(story.slope.ends, story.slope.outline + np.array([0.0, 1e-3]))
    moved = replace(story)
    moved.__dict__["slope"] = shifted
    assert all(same(found, shifted.outline) for found in corners(moved).values())


def test_the_surface_lies_one_radius_below_the_axis(history):
    geometry = BeamGeometry(history)
    slope, scenario = drawn_slope(geometry), geometry.scenario
    angle = scenario.slope.angle
    tangent, normal = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    places = slope.outline - scenario.slope.origin
    area = scenario.beam.area
    if isinstance(area, tuple):
        area = np.interp(scenario.contact.point, *np.transpose(area))
    np.testing.assert_allclose(places[:2] @ normal, -np.sqrt(area / np.pi), atol=1e-12)
    np.testing.assert_allclose(places[:2] @ tangent, slope.ends, atol=1e-12)
    if scenario.slope.extent:
        assert slope.ends == scenario.slope.extent
    assert np.all(places[2:] @ normal < places[0] @ normal - 0.05 * scenario.beam.length)  # a solid below it


def test_what_passes_below_an_unbounded_slope_is_seen_to_do_so(run):
    """The slope is drawn over every place of the axis that is below it."""
    history = run("mid-span", "slope.extent=[]")  # of all samples, of which some are looked at
    geometry = BeamGeometry(history)
    first, last = drawn_slope(geometry).ends
    angle = geometry.scenario.slope.angle
    places = geometry.stations_of(np.arange(geometry.times.size)) - geometry.scenario.slope.origin
    height = places @ np.array([-np.sin(angle), np.cos(angle)])
    below = (places @ np.array([np.cos(angle), np.sin(angle)]))[height < 0.0]
    assert height.min() < -0.07
    assert first < below.min()
    assert last > below.max()


def test_ends_out_of_reach_are_not_drawn(run):
    """What the beam never reaches would only make it small; of a far obstacle nothing is left."""
    wide = drawn_slope(BeamGeometry(run("paper", "end_time=0.01", "slope.extent=[-100.0, 100.0]")))
    assert np.ptp(wide.ends) < 2.5
    assert drawn_slope(BeamGeometry(run("paper", "end_time=0.01", "slope.extent=[5.0, 6.0]"))) is None


def test_without_contact_there_is_none(run):
    history = run("spin-up", "end_time=0.01")
    assert drawn_slope(BeamGeometry(history)) is None
    assert content_of(story_of([history]), 20).facts["slope"] is None


@pytest.mark.parametrize("surface", ["axis", "section"])
def test_the_drawn_face_touches_the_drawn_slope_in_contact(run, surface):
    """The lowest point of the drawn beam is on the drawn surface, with contact on the axis or on the face."""
    history = run("paper", f"contact.surface='{surface}'", "end_time=0.335")
    geometry = BeamGeometry(history, 1.0)
    scenario = geometry.scenario
    normal = np.array([-np.sin(scenario.slope.angle), np.cos(scenario.slope.angle)])
    line, surfaces = np.array(scenario.slope.origin) @ normal, drawn_slope(geometry).outline[:2] @ normal
    np.testing.assert_allclose(surfaces, surfaces[0], rtol=0.0, atol=1e-12)
    half_depth = np.sqrt(scenario.beam.area / np.pi)
    # the drawn slope is where the slope is only if the face touches it
    assert line - surfaces[0] == pytest.approx(half_depth if surface == "axis" else 0.0, abs=1e-12)
    closed = np.flatnonzero(history["state"].values != 0)
    assert closed.size > 20
    for k in closed:
        lowest = (geometry.outline(float(k)) @ normal).min()
        # a hemisphere is drawn by flat faces
        assert lowest - surfaces[0] == pytest.approx(0.0, abs=(1e-2 if surface == "axis" else 1e-5) * half_depth)
        assert geometry.contact_place(float(k))[:2] @ normal == pytest.approx(surfaces[0], abs=1e-9)
        point = np.array([history["tip_x"].values[k], history["tip_y"].values[k]])
        np.testing.assert_allclose(geometry.contact_point(float(k)), point, rtol=0.0, atol=1e-9)

    # between two samples it stays on the surface
    assert geometry.contact_place(closed[5] + 0.5)[:2] @ normal == pytest.approx(surfaces[0], abs=1e-8)
