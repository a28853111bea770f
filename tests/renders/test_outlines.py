"""Outlines in pictures, pages and exports."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista as pv

from oblique_impact import Scenario, simulate
from oblique_impact.renders import Style, export, render
from oblique_impact.renders.geometry import BeamGeometry
from oblique_impact.renders.surroundings import depth_of, drawn_obstacles

OPEN = [[0.3, -0.1], [0.6, -0.1], [0.6, -0.2], [0.9, -0.15]]
BLOCK = [[0.3, -0.05], [0.7, -0.05], [0.7, -0.2], [0.3, -0.2], [0.3, -0.05]]


def history_of(points, surface="section"):
    return simulate(
        Scenario.from_dict(
            {
                "end_time": 0.05,
                "initial": {"angle": 0.0},
                "slope": {"enabled": False},
                "contact": {"where": "anywhere", "grid": 1, "surface": surface, "friction": "frictionless"},
                "obstacles": [{"kind": "polyline", "points": points}],
            }
        )
    )


def test_an_open_outline_is_drawn_as_it_is_with_a_solid_below():
    (found,) = drawn_obstacles(BeamGeometry(history_of(OPEN)))
    assert found.surface == pytest.approx(np.array(OPEN))
    assert len(found.pieces) == 3
    assert found.outline[len(OPEN) :, 1] == pytest.approx(2 * [-0.2 - 0.06])


def test_a_closed_one_is_the_solid_itself():
    (found,) = drawn_obstacles(BeamGeometry(history_of(BLOCK)))
    assert found.outline == pytest.approx(np.array(BLOCK[:-1]))
    assert found.surface == pytest.approx(np.array(BLOCK))


def test_contact_on_the_axis_draws_it_half_the_depth_of_the_beam_inside():
    geometry = BeamGeometry(history_of(BLOCK, surface="axis"))
    (found,) = drawn_obstacles(geometry)
    d = geometry.slope_depth
    inner = [[0.3 + d, -0.05 - d], [0.7 - d, -0.05 - d], [0.7 - d, -0.2 + d], [0.3 + d, -0.2 + d]]
    assert found.outline == pytest.approx(np.array(inner))


@pytest.mark.parametrize("points", [OPEN, BLOCK])
def test_pictures_and_pages_have_it(points, tmp_path):
    history = history_of(points)
    render(history, tmp_path / "still.png", Style(size=(320, 180), charts=False, inset=False), time=0.04)
    assert (tmp_path / "still.png").stat().st_size > 2000
    render(history, tmp_path / "page.html")
    assert (tmp_path / "page.html").stat().st_size > 20_000


@pytest.mark.parametrize("points", [OPEN, BLOCK])
def test_exports_have_the_whole_solid(points, tmp_path):
    """Its volume is that of the drawn outline, with a hollow too."""
    history = history_of(points)
    export(history, tmp_path / "run.pvd", every=1000)
    (file,) = tmp_path.rglob("slope_000000.vtp")
    geometry = BeamGeometry(history)
    (found,) = drawn_obstacles(geometry)
    x, y = found.outline.T
    area = 0.5 * abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    assert pv.read(file).volume == pytest.approx(2.0 * depth_of(geometry) * area, rel=1e-5)
