"""The drawn shape of a beam: sections stand as they are, ends are closed, a mass at the tip is seen."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista as pv

from oblique_impact import Scenario, simulate
from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.outlines import SIDES

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
    points, angle = geometry.surface(0).points, geometry.scenario.initial.angle
    c, s = np.cos(angle), np.sin(angle)
    return points @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def mesh(geometry: BeamGeometry) -> pv.PolyData:
    return pv.PolyData(geometry.surface(0).points, geometry.faces)


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
    solid = mesh(geometry).triangulate()
    volume = geometry.sections.mass / geometry.sections.density
    assert solid.volume == pytest.approx(volume, rel=1e-3)
    directions = geometry.surface(0).normals
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    if shape == "rectangle":  # a convex one: all normals of its sides point away from the axis
        sides = slice(0, geometry.places.size * SIDES)
        away = geometry.surface(0).points[sides] - np.repeat(geometry.centreline(0), SIDES, axis=0)
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
    surface = geometry.surface(last)
    stress = surface.arrays["bending_stress"][: geometry.places.size * SIDES].reshape(-1, SIDES)
    moment = geometry.along(last)["bending_moment"]
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


def test_a_small_mass_is_not_hidden_in_the_beam():
    geometry = drawn("tube", beam__tip_mass=1e-4)
    assert geometry.mass_radius == geometry.radii[-1]
    assert drawn("tube").mass_radius == 0.0
