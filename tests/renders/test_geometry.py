"""The drawn beam against the history: positions, results on the surface, magnification about the chord."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.contact.state import State
from oblique_impact.renders.geometry import SIDES, BeamGeometry
from oblique_impact.renders.player.content import content_of
from oblique_impact.renders.story import story_of
from oblique_impact.renders.style import Style

#: built-in scenarios that differ in what is drawn
CASES = {
    "paper": ("paper",),
    "mid-span": ("mid-span",),
    "hub": ("paper", "root.kind=hub", "root.inertia=0.1", "root.hub_radius=0.1", "contact.enabled=false"),
    "tapered": ("tapered", "end_time=0.34"),
}


@pytest.fixture(params=CASES)
def history(run, request):
    return run(*CASES[request.param])


def strongest(history):
    """The sample of the largest force."""
    return int(np.argmax(np.nan_to_num(history["lambda_n"].values)))


def test_magnification_keeps_root_and_contact_point(history):
    true, drawn = BeamGeometry(history, 1.0), BeamGeometry(history, 7.0)
    for k in (0, strongest(history), history["time"].size - 1):
        a, b = true.centreline(k), drawn.centreline(k)
        np.testing.assert_allclose(b[[0, true.touch]], a[[0, true.touch]], atol=1e-12)
        chord = a[0] + (true.stations / true.stations[true.touch])[:, None] * (a[true.touch] - a[0])
        np.testing.assert_allclose(b - chord, 7.0 * (a - chord), atol=1e-12)


def test_the_normal_of_a_peg_is_across_the_bent_beam(run):
    """The force along the beam there is the friction: the undeformed beam would give it 1.7 mN more."""
    history = run("two-pegs", "initial.angle=-0.0499", "beam.kelvin_voigt=1e-3", "end_time=0.1")
    geometry, friction = BeamGeometry(history), history["contact_lambda_tau"].values
    k = int(np.argmax(np.abs(np.nan_to_num(friction)).sum(axis=1)))
    pushes, normals = geometry.pushes(k), geometry.contact_normals(k)
    along = pushes[:, 0] * normals[:, 1] - pushes[:, 1] * normals[:, 0]
    assert np.abs(along) == pytest.approx(np.abs(friction[k]), abs=1e-4)


def test_the_tube_is_closed_and_wound_outward(history):
    geometry = BeamGeometry(history)
    mesh = pv.PolyData(geometry.tube(strongest(history))[0], geometry.solid.faces)
    assert mesh.is_manifold
    assert mesh.n_open_edges == 0
    # the tube together with the sphere at its tip: half of one in the tube's radius, or the mass there
    length, end = geometry.stations[-1], geometry.mass_radius or geometry.radii[-1]
    x = np.linspace(0.0, length + end, 4001)
    tube = np.where(x <= length, np.interp(x, geometry.stations, geometry.radii), 0.0)
    expected = np.pi * np.trapezoid(np.maximum(tube**2, end**2 - (x - length) ** 2), x)
    # polygons have sin(2 pi/n)/(2 pi/n) of the circle's area; the magnified beam is a little longer
    assert mesh.volume == pytest.approx(expected * np.sinc(2.0 / SIDES), rel=0.02)


def test_a_history_without_a_beam_is_one_line(run):
    history = run("paper")
    with pytest.raises(InputError, match="lambda_n"):
        BeamGeometry(replace(history, data=history.data.drop_vars("lambda_n")))


HUBS = {
    "driven, tip mass": (
        "root.kind=driven root.profile=constant-speed root.spin_rate=-2.0 root.hub_radius=0.1 "
        "beam.tip_mass=0.1 end_time=0.35"
    ),
    "contact inside, on the face": (
        "root.kind=hub root.inertia=0.05 root.hub_radius=0.2 "
        "contact.point=0.75 contact.surface=section end_time=0.5"
    ),
}


@pytest.mark.parametrize("case", HUBS)
def test_the_page_has_the_points_of_the_geometry_and_the_drawn_face_touches_the_slope(run, case):
    """On both sides of jumps; the lowest point of a round end is on the drawn surface in contact."""
    history = run("paper", *HUBS[case].split(), "discretization.method=fem", "discretization.elements=8")
    story = story_of([history], Style(deformation=1.0))
    geometry, page = story.geometries[0], content_of(story).arrays
    normal = geometry.slope_axes[1]
    surface, closed = story.obstacles[0].outline[0] @ normal, 0
    for n in range(0, page["time"].size, max(1, page["time"].size // 60)):
        k = int(np.flatnonzero(geometry.times == page["time"][n])[0])
        place = geometry.contact_place(k)[:2]
        np.testing.assert_allclose(page["axis"][n], geometry.centreline(k)[:, :2], rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(page["place"][n, 0] + page["offset"][n, 0], place, rtol=0.0, atol=1e-12)
        if history["state"].values[k] != State.FREE:
            closed += 1
            height = place @ normal
            assert height == pytest.approx(surface + float(history["gap"].values[k]), abs=1e-9)
            if not geometry.flat_end and geometry.touch == geometry.stations.size - 1:  # it is drawn by flat faces
                lowest = (geometry.outline(k) @ normal).min()
                assert lowest == pytest.approx(height, abs=0.1 * geometry.touch_radius)
    assert closed > 5


# Sections -----------------------------------------------------------------------------------------------------

FEM = {"discretization__method": "fem", "discretization__modes": 2, "discretization__frame": "mean-axis"}
SHAPES = {
    "rectangle": {"width": 0.05, "height": [[0.0, 0.03], [1.0, 0.012]]},
    "i-beam": {"width": 0.05, "height": 0.08, "flange_thickness": 0.006, "web_thickness": 0.004},
    "circle": {"diameter": 0.02},
    "tube": {"diameter": 0.03, "thickness": 0.002},
}


def drawn(shape: str, **keys) -> BeamGeometry:
    sizes = {f"beam__section__{name}": size for name, size in SHAPES[shape].items()}
    scenario = Scenario().replace(beam__section__shape=shape, end_time=0.01, **sizes, **FEM, **keys)
    return BeamGeometry(simulate(scenario), 1.0)


def offsets_of(geometry: BeamGeometry) -> np.ndarray:
    """Points (n, 3) of the straight beam at the start: along the axis, across it, out of the plane."""
    points, angle = geometry.tube(0)[0], geometry.scenario.initial.angle
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("shape", SHAPES)
def test_the_drawn_solid_is_that_of_the_section(shape):
    """Height in the plane of motion, width across it, stress by the height; corners: volume and normals too."""
    geometry, sizes = drawn(shape), SHAPES[shape]
    x, on_rings = geometry.stations, geometry.stations.size * SIDES
    offsets = offsets_of(geometry)[:on_rings].reshape(-1, SIDES, 3)
    height, width = (sizes.get(name, sizes.get("diameter")) for name in ("height", "width"))
    heights = np.interp(x, *np.array(height).T) if isinstance(height, list) else np.full(x.size, height)
    np.testing.assert_allclose(np.ptp(offsets[:, :, 1], axis=1), heights, rtol=1e-12)
    np.testing.assert_allclose(np.ptp(offsets[:, :, 2], axis=1), width, rtol=1e-12)
    assert geometry.half_width == pytest.approx(width / 2.0, rel=1e-12)
    # one with corners touches along a line across it, whose near end is shown
    np.testing.assert_allclose(
        2.0 * geometry.near_places(0)[:, 2], width if shape in ("rectangle", "i-beam") else 0.0
    )
    # top and bottom are where the outline is drawn
    np.testing.assert_allclose(offsets[0, [0, SIDES // 2], 1], [geometry.radii[0], -geometry.radii[0]])
    last = geometry.times.size - 1
    stress = geometry.result("bending_stress", last)[:on_rings].reshape(-1, SIDES)
    inertia = geometry.sections.second_moment(x)
    top = -geometry.along("moment", last) * 0.5 * heights / inertia
    np.testing.assert_allclose(stress[:, 0], top, rtol=1e-9, atol=1e-3)
    points, directions = geometry.tube(0)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    if shape in ("rectangle", "i-beam"):  # with a flat, filled end
        solid = pv.PolyData(points, geometry.solid.faces).triangulate()
        assert solid.volume == pytest.approx(geometry.sections.mass / geometry.sections.density, rel=1e-3)
    if shape == "rectangle":  # a convex one: all normals of its sides point away from the axis
        away = points[:on_rings] - np.repeat(geometry.centreline(0), SIDES, axis=0)
        assert np.all(np.einsum("pi,pi->p", away, directions[:on_rings]) > 0.0)


@pytest.mark.parametrize("shape", ["tube", "rectangle"])
def test_a_mass_at_the_tip_is_a_sphere_of_its_volume(shape):
    mass = 0.4
    geometry = drawn(shape, beam__tip_mass=mass)
    radius = (3.0 * mass / geometry.scenario.beam.density / (4.0 * np.pi)) ** (1 / 3)
    assert geometry.mass_radius == pytest.approx(radius, rel=1e-12)
    cap = offsets_of(geometry)[geometry.stations.size * SIDES : -1] - (1.0, 0.0, 0.0)
    np.testing.assert_allclose(np.linalg.norm(cap, axis=1), radius, rtol=1e-6)
    assert cap[:, 0].max() == pytest.approx(radius)
    # the sphere rests on the slope, whose drawn surface lies its radius below the line of contact
    assert geometry.touch_radius == pytest.approx(radius)
    assert drawn(shape, beam__tip_mass=mass, contact__point=0.5).touch_radius < radius / 2.0
