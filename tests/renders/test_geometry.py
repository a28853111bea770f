"""The drawn beam against the history: positions, results on the surface, magnification about the chord."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import pyvista as pv

from oblique_impact import InputError, Scenario, simulate
from oblique_impact.renders.geometry import BETWEEN, SIDES, BeamGeometry
from tests.renders import FAMILIES


@pytest.fixture(params=FAMILIES)
def history(run, request):
    name, *overrides = FAMILIES[request.param]
    return run(name, *overrides)


def places(history):
    """A few samples: the start, the largest force, the end."""
    force = np.nan_to_num(history["lambda_n"].values)
    return [0, int(np.argmax(force)), int(np.argmin(force)), history["time"].size - 1]


def test_magnification_keeps_root_and_contact_point(history):
    true, drawn = BeamGeometry(history, 1.0), BeamGeometry(history, 7.0)
    touch = int(np.argmin(np.abs(true.places - true.scenario.contact.point)))
    for k in places(history):
        a, b = true.centreline(k), drawn.centreline(k)
        np.testing.assert_allclose(b[[0, touch]], a[[0, touch]], atol=1e-12)
        chord = a[0] + (true.places / true.places[touch])[:, None] * (a[touch] - a[0])
        np.testing.assert_allclose(b - chord, 7.0 * (a - chord), atol=1e-12)


def test_the_tube_is_closed_and_wound_outward(history):
    geometry = BeamGeometry(history)
    points, _ = geometry.tube(places(history)[1])
    mesh = pv.PolyData(points, geometry.solid.faces)
    assert mesh.is_manifold
    assert mesh.n_open_edges == 0
    # the tube together with the sphere at its tip: half of one in the tube's radius, or the mass there
    length, end = geometry.places[-1], geometry.mass_radius or geometry.radii[-1]
    x = np.linspace(0.0, length + end, 4001)
    tube = np.where(x <= length, np.interp(x, geometry.places, geometry.radii), 0.0)
    expected = np.pi * np.trapezoid(np.maximum(tube**2, end**2 - (x - length) ** 2), x)
    # polygons of 24 sides: sin(2 pi/24)/(2 pi/24) of the circle's area; the magnified beam is a little longer
    assert mesh.volume == pytest.approx(expected * np.sin(np.pi / 12) / (np.pi / 12), rel=0.02)


def test_slope_is_the_derivative_of_the_deflection(history):
    geometry = BeamGeometry(history)
    k = places(history)[1]
    slope = geometry.along("section_rotation", k)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(geometry.places) * (slope[1:] + slope[:-1]))])
    rise = history["uy"].values[k] - history["uy"].values[k][0]
    np.testing.assert_allclose(integral[:: BETWEEN + 1], rise, atol=2e-3 * np.abs(rise).max() + 1e-15)


@pytest.mark.parametrize("name", ["paper", "rigid-limit", "spin-up"])
def test_the_factor_is_a_round_number_that_shows_the_deviation(run, name):
    """Six per cent of the length at most, and more than a fifth of that unless the largest factor is used."""
    geometry = BeamGeometry(run(name))
    true = BeamGeometry(run(name), 1.0)
    largest = 0.0
    for k in range(0, true.times.size, 50):
        axis, ends = true.centreline(k), true.centreline(k)[[0, -1]]
        chord = ends[0] + (true.places / true.places[-1])[:, None] * (ends[1] - ends[0])
        largest = max(largest, float(np.linalg.norm(axis - chord, axis=1).max()))
    shown = geometry.factor * largest / geometry.scenario.beam.length
    assert shown < 0.06
    assert shown > 0.015 or geometry.factor == 100.0
    assert geometry.factor in (1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0, 100.0)


def test_a_senseless_factor_or_a_history_without_a_beam_is_one_line(run):
    history = run("paper")
    for factor in (0.0, np.nan):
        with pytest.raises(InputError, match="--deformation"):
            BeamGeometry(history, factor)
    with pytest.raises(InputError, match="lambda_n"):
        BeamGeometry(replace(history, data=history.data.drop_vars("lambda_n")))


# Sections -----------------------------------------------------------------------------------------------------

FEM = {"discretization__method": "fem", "discretization__modes": 2, "discretization__frame": "mean-axis"}
SHAPES = {
    "rectangle": {"width": 0.05, "height": [[0.0, 0.03], [1.0, 0.012]]},
    "i-beam": {"width": 0.05, "height": 0.08, "flange_thickness": 0.006, "web_thickness": 0.004},
    "circle": {"diameter": 0.02},
    "tube": {"diameter": 0.03, "thickness": 0.002},
}


def scenario(shape: str, **keys) -> Scenario:
    sizes = {f"beam__section__{name}": size for name, size in SHAPES[shape].items()}
    return Scenario().replace(beam__section__shape=shape, end_time=0.01, **sizes, **FEM, **keys)


def drawn(shape: str, **keys) -> BeamGeometry:
    return BeamGeometry(simulate(scenario(shape, **keys)), 1.0)


def offsets_of(geometry: BeamGeometry) -> np.ndarray:
    """Points (n, 3) of the straight beam at the start: along the axis, across it, out of the plane."""
    points, angle = geometry.tube(0)[0], geometry.scenario.initial.angle
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("shape", SHAPES)
def test_height_lies_in_the_plane_of_motion_and_width_across_it(shape):
    geometry = drawn(shape)
    offsets = offsets_of(geometry)[: geometry.places.size * SIDES].reshape(-1, SIDES, 3)
    sizes = SHAPES[shape]
    height = sizes.get("height", sizes.get("diameter"))
    heights = np.interp(geometry.places, *np.array(height).T) if isinstance(height, list) else height
    np.testing.assert_allclose(
        np.ptp(offsets[:, :, 1], axis=1), heights * np.ones(geometry.places.size), rtol=1e-12
    )
    width = sizes.get("width", sizes.get("diameter"))
    np.testing.assert_allclose(np.ptp(offsets[:, :, 2], axis=1), width * np.ones(geometry.places.size), rtol=1e-12)
    assert geometry.half_width == pytest.approx(width / 2.0, rel=1e-12)
    # top and bottom are where the outline is drawn
    assert offsets[0, 0, 1] == pytest.approx(geometry.radii[0])
    assert offsets[0, SIDES // 2, 1] == pytest.approx(-geometry.radii[0])


@pytest.mark.parametrize("shape", ["rectangle", "i-beam"])
def test_the_drawn_solid_has_the_volume_of_the_beam_and_faces_outwards(shape):
    """Its end is flat and filled; VTK's volume is that of faces wound outwards."""
    geometry = drawn(shape)
    solid = pv.PolyData(geometry.tube(0)[0], geometry.solid.faces).triangulate()
    volume = geometry.sections.mass / geometry.sections.density
    assert solid.volume == pytest.approx(volume, rel=1e-3)
    directions = geometry.tube(0)[1]
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    if shape == "rectangle":  # a convex one: all normals of its sides point away from the axis
        sides = slice(0, geometry.places.size * SIDES)
        away = geometry.tube(0)[0][sides] - np.repeat(geometry.centreline(0), SIDES, axis=0)
        assert np.all(np.einsum("pi,pi->p", away, directions[sides]) > 0.0)


def test_the_web_of_an_i_beam_is_thin():
    geometry = drawn("i-beam")
    ring = offsets_of(geometry)[:SIDES, 1:].round(12)
    inner = ring[np.abs(ring[:, 0]) < 0.03]
    assert len(ring[np.isclose(np.abs(ring[:, 0]), 0.034)]) == 16
    assert len(inner) == 0
    assert sorted(set(np.abs(ring[:, 1]).round(9))) == [0.002, 0.025]


def test_bending_stress_at_the_top_of_a_rectangle():
    geometry = drawn("rectangle")
    last = geometry.times.size - 1
    stress = geometry.result("bending_stress", last)[: geometry.places.size * SIDES].reshape(-1, SIDES)
    moment = geometry.along("bending_moment", last)
    height = np.interp(geometry.places, [0.0, 1.0], [0.03, 0.012])
    np.testing.assert_allclose(stress[:, 0], -6.0 * moment / (0.05 * height**2), rtol=1e-9, atol=1e-3)


@pytest.mark.parametrize("shape", ["tube", "rectangle"])
def test_a_mass_at_the_tip_is_a_sphere_of_its_volume(shape):
    mass = 0.4
    geometry = drawn(shape, beam__tip_mass=mass)
    radius = (3.0 * mass / geometry.scenario.beam.density / (4.0 * np.pi)) ** (1 / 3)
    assert geometry.mass_radius == pytest.approx(radius, rel=1e-12)
    cap = offsets_of(geometry)[geometry.places.size * SIDES : -1] - (1.0, 0.0, 0.0)
    np.testing.assert_allclose(np.linalg.norm(cap, axis=1), radius, rtol=1e-6)
    assert cap[:, 0].max() == pytest.approx(radius)
    # the sphere rests on the slope, whose drawn surface lies its radius below the line of contact
    assert geometry.touch_radius == pytest.approx(radius)
    assert drawn(shape, beam__tip_mass=mass, contact__point=0.5).touch_radius < radius / 2.0
