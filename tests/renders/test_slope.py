"""The drawn slope: where the beam touches it, as far as the beam comes near it."""

from __future__ import annotations

import numpy as np
import pytest

from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.overview import overview
from oblique_impact.renders.scenery import slope_wedge
from oblique_impact.renders.slope import drawn_slope

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


def test_the_overview_draws_the_slope_of_the_film(run):
    """The same corners, whatever the deformation factor; the edge of a prism in the scene."""
    history = run(*CASES["ledge"])
    outline = drawn_slope(BeamGeometry(history)).outline
    np.testing.assert_array_equal(drawn_slope(BeamGeometry(history, 50.0)).outline, outline)
    patches = overview({"run": history}).axes[0].patches
    assert any(len(p.get_xy()) == 5 and np.allclose(p.get_xy()[:4], outline) for p in patches)
    solid = np.asarray(slope_wedge(BeamGeometry(history), drawn_slope(BeamGeometry(history))).points)
    front = solid[solid[:, 2] > 0.0][:, :2]
    assert np.linalg.norm(front[:, None] - outline, axis=-1).min(axis=0).max() < 1e-6


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
