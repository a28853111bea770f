"""The drawn beam against the history: positions, results on the surface, magnification about the chord."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista as pv

from oblique_impact import InputError
from oblique_impact.history.sample_times import jumps
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
    surface = geometry.surface(places(history)[1])
    mesh = pv.PolyData(surface.points, geometry.faces)
    assert mesh.is_manifold
    assert mesh.n_open_edges == 0
    # the tube together with the sphere at its tip: half of one in the tube's radius, or the mass there
    length, end = geometry.places[-1], geometry.mass_radius or geometry.radii[-1]
    x = np.linspace(0.0, length + end, 4001)
    tube = np.where(x <= length, np.interp(x, geometry.places, geometry.radii), 0.0)
    expected = np.pi * np.trapezoid(np.maximum(tube**2, end**2 - (x - length) ** 2), x)
    # polygons of 24 sides: sin(2 pi/24)/(2 pi/24) of the circle's area; the magnified beam is a little longer
    assert mesh.volume == pytest.approx(expected * np.sin(np.pi / 12) / (np.pi / 12), rel=0.02)


def test_rings_are_circles_across_the_axis(history):
    geometry = BeamGeometry(history, 1.0)
    k = places(history)[1]
    points, axis = geometry.surface(k).points, geometry.centreline(k)
    rings = points[: geometry.places.size * SIDES].reshape(-1, SIDES, 3)
    np.testing.assert_allclose(rings.mean(axis=1), axis, atol=1e-12)
    distance = np.linalg.norm(rings - axis[:, None], axis=2)
    np.testing.assert_allclose(distance, np.broadcast_to(geometry.radii[:, None], distance.shape), rtol=1e-12)
    along = np.gradient(axis, geometry.places, axis=0)
    assert np.abs(np.einsum("rsi,ri->rs", rings - axis[:, None], along)).max() < 2e-3 * geometry.radii.max()


def test_normals_are_those_of_the_faces(history):
    geometry = BeamGeometry(history, 1.0)
    surface = geometry.surface(places(history)[1])
    mesh = pv.PolyData(surface.points, geometry.faces)
    found = mesh.compute_normals(
        split_vertices=False, consistent_normals=False, auto_orient_normals=False
    ).point_data["Normals"]
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1.0, rtol=1e-12)
    # the rim at the root has the face of the root beside it
    inside = np.arange(SIDES, surface.points.shape[0] - 1)
    if geometry.mass_radius > 0.0:  # and the end of the beam the mass
        inside = inside[np.abs(inside // SIDES - geometry.places.size) > 1]
    assert np.einsum("ij,ij->i", found, surface.normals)[inside].min() > 0.98


def test_between_samples_everything_is_interpolated(run):
    history = run("paper")
    geometry = BeamGeometry(history, 1.0)
    k = 1000
    assert geometry.index(geometry.times[k]) == k
    middle = geometry.index(0.5 * (geometry.times[k] + geometry.times[k + 1]))
    assert middle == pytest.approx(k + 0.5)
    mean = 0.5 * (geometry.surface(k).points + geometry.surface(k + 1).points)
    np.testing.assert_allclose(geometry.surface(middle).points, mean, atol=1e-6)
    jump = int(np.flatnonzero(jumps(geometry.times))[0])
    assert geometry.index(geometry.times[jump]) == jump + 1  # the right-hand value
    assert geometry.index(-1.0) == 0
    assert geometry.index(9.0) == geometry.times.size - 1


def test_slope_is_the_derivative_of_the_deflection(history):
    geometry = BeamGeometry(history)
    k = places(history)[1]
    slope = geometry.along(k)["section_rotation"]
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


@pytest.mark.parametrize("factor", [0.0, -1.0, np.inf, np.nan])
def test_a_senseless_factor_is_one_line(run, factor):
    with pytest.raises(InputError, match="--deformation"):
        BeamGeometry(run("paper"), factor)


def test_a_history_without_a_beam_is_one_line(run):
    from dataclasses import replace

    history = run("paper")
    for name in ("ux_dot", "lambda_n", "bending_stress"):
        with pytest.raises(InputError, match=name):
            BeamGeometry(replace(history, data=history.data.drop_vars(name)))
