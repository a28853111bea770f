"""Outlines in a scenario: sides and corners of them, files of points, what is refused."""

from __future__ import annotations

import math

import fastjsonschema
import numpy as np
import pytest

from oblique_impact import Scenario, scenario_schema, start_scenario
from oblique_impact.scenario.polylines import Outline
from tests.refusals import refused_in_one_line

BLOCK = [[0.4, -0.1], [0.4, -0.05], [0.8, -0.05], [0.8, -0.1], [0.4, -0.1]]
STEP = [[0.2, -0.05], [0.6, -0.05], [0.6, -0.1], [1.4, -0.1]]


def scenario_of(points, **keys):
    """A level beam of 1 m over an outline."""
    obstacle = {"kind": "polyline", "points": points}
    return Scenario.from_dict(
        {
            "slope": {"enabled": False},
            "initial": {"angle": 0.0},
            "contact": {"where": "anywhere", "normal": "spring", "grid": 4},
            "obstacles": [obstacle | keys],
        }
    )


def test_a_step_is_sides_and_corners():
    found = scenario_of(STEP)
    assert [side.angle for side in found.sides] == pytest.approx([0.0, -math.pi / 2, 0.0])
    assert [side.extent for side in found.sides] == [pytest.approx((0.0, x)) for x in (0.4, 0.05, 0.8)]
    # a corner where it begins, at its edge and where it ends, none in its hollow
    corners = [(point.x, point.y) for point in found.obstacle_points]
    assert corners == [pytest.approx(c) for c in ((0.2, -0.05), (0.6, -0.05), (1.4, -0.1))]
    assert all(point.corner and point.obstacle == 1 for point in found.obstacle_points)
    # in the hollow both sides go on into the solid
    assert found.sides[1].lengthened((0.0, 0.0)).extent[1] > 0.05
    assert found.sides[2].lengthened((0.0, 0.0)).extent[0] < 0.0
    assert scenario_of(STEP, bedding=1e5).obstacle_points == []


def test_it_is_placed_and_turned():
    found = scenario_of([[0.0, 0.0], [0.5, 0.0], [1.0, 0.0]], origin=[0.1, -0.2], angle=-0.3)
    (side,) = found.sides  # it goes straight on at the second point
    assert (side.origin, side.angle, side.extent) == ((0.1, -0.2), pytest.approx(-0.3), pytest.approx((0.0, 1.0)))


def test_distances_have_the_sign_of_the_solid():
    block = Outline([tuple(point) for point in BLOCK])
    places = [0.6, 0.6 - 0.06j, 0.6 - 0.2j, 1.1 + 0.35j, 0.5 - 0.075j]
    assert block.distance(places) == pytest.approx([0.05, -0.01, 0.1, 0.5, -0.025])
    acute = Outline([(0.0, 0.0), (1.0, 0.1), (0.0, 0.2)])  # its tip is nearest to places before it
    assert acute.distance([1.5 + 0.1j, 1.1 + 0.2j]) == pytest.approx([-0.5, -math.hypot(0.1, 0.1)])
    bump = Outline([(0.0, 0.2), (1.0, 0.1), (0.0, 0.0)])
    assert bump.distance([1.5 + 0.1j, 0.5 + 0.1j])[0] == pytest.approx(0.5)
    around = Outline(
        [(math.cos(a), -math.sin(a)) for a in np.linspace(0.0, 2.0 * math.pi, 41)[:-1]] + [(1.0, 0.0)]
    )
    rng = np.random.default_rng(5)
    z = rng.uniform(-2.0, 2.0, 200) + 1j * rng.uniform(-2.0, 2.0, 200)
    assert np.max(np.abs(around.distance(z) - (np.abs(z) - 1.0))) < 1.0 - math.cos(math.pi / 40) + 1e-12


@pytest.mark.parametrize(
    "text", ["x,y\n0.2,-0.05\n0.6,-0.05\n\n0.6,-0.1\n1.4,-0.1\n", "0.2,-5e-2\n 0.6, -0.05\n0.6,-0.1\n1.4,-0.1"]
)
def test_points_are_read_from_a_file_beside_the_scenario(tmp_path, monkeypatch, text):
    (tmp_path / "lay.csv").write_text(text, encoding="utf-8")
    (tmp_path / "case.toml").write_text(
        '[slope]\nenabled = false\n[initial]\nangle = 0.0\n[contact]\nwhere = "anywhere"\n'
        '[[obstacles]]\nkind = "polyline"\npoints = "lay.csv"\n',
        encoding="utf-8",
    )
    found = Scenario.load(str(tmp_path / "case.toml"))
    assert found.obstacles[0].points == tuple(map(tuple, STEP))
    assert Scenario.from_toml(found.to_toml()) == found
    assert start_scenario(tmp_path / "mine.toml", found) == found
    with refused_in_one_line('obstacles.1.points = "lay.csv": cannot be read'):
        Scenario.load(str(tmp_path / "case.toml"), ["obstacles.1.points=lay.csv"])
    monkeypatch.chdir(tmp_path)
    assert Scenario.load("case.toml", ["obstacles.1.points=lay.csv"]) == found
    valid = fastjsonschema.compile(scenario_schema())
    valid({"obstacles": [{"kind": "polyline", "points": "lay.csv"}]})
    valid({"obstacles": [{"kind": "polyline", "points": STEP}]})
    (tmp_path / "lay.csv").write_text("x,y\n0.2,-0.05\n0.6,high\n", encoding="utf-8")
    with refused_in_one_line('line 3 is "0.6,high", should be two numbers x,y in m'):
        Scenario.load("case.toml")


@pytest.mark.parametrize(
    ("points", "line"),
    [
        ([], "should be at least two points [x, y] with kind"),
        ([[0.2, -0.1]], "2 to 1000 points [x, y] in m, not 1"),
        ([[0.2, -0.1], [0.3, -0.1], [0.3, -0.1]], "points 2 and 3 are both [0.3, -0.1]"),
        ([[0.2, -0.1], [0.8, -0.1], [0.8, -0.3], [0.4, 0.1]], "pieces 1 and 3 meet"),
        ([[0.2, -0.1], [0.8, -0.1], [0.4, -0.1]], "pieces 1 and 2 meet"),
        ([[0.2, -0.1], [0.8, -0.1], [0.2, -0.1]], "at least three different points"),
        (BLOCK[::-1], "reverse its points"),
        ("lay.csv", "a file of them is read with a scenario file or by --set"),
        ([[0.2, "1 kg"], [0.8, -0.1]], "in m, not in kg"),
        # what the beam starts inside of, or crosses
        ([[x, y + 0.08] for x, y in BLOCK], "at 0.5 m starts 0.02 m inside of obstacle 1"),
        ([[0.6, -0.1], [0.6, 0.1], [0.65, 0.1], [0.65, -0.1], [0.6, -0.1]], "crosses obstacle 1 at 0.6 m"),
        ([[0.6, -0.1], [0.6, 0.1]], "at 0.75 m starts 0.15 m inside of obstacle 1"),
        ([[0.0, -0.1], [0.6, -0.1], [0.65, 0.1], [0.7, -0.1]], "crosses obstacle 1 at 0.625 m"),
        ([[0.4, -0.1], [0.6, 0.0], [0.8, -0.1]], "lies on the beam's axis at t = 0"),
    ],
)
def test_what_is_no_outline_is_refused(points, line):
    with refused_in_one_line(line):
        scenario_of(points)


def test_at_rest_a_beam_is_not_bent_out_of_an_outline():
    rest = {"initial": {"angle": 0.0, "state": "equilibrium"}, "root": {"kind": "driven"}}
    with refused_in_one_line("inside of obstacle 1"):
        scenario_of([[x, y + 0.08] for x, y in BLOCK]).replace(**rest)
    scenario_of(BLOCK).replace(**rest)


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        ({"extent": [0.0, 1.0]}, 'extent = [0.0, 1.0]: has no effect: only with kind = "side"'),
        ({"radius": 0.1}, 'radius = 0.1: has no effect: only with kind = "point"'),
        ({"kind": "side", "origin": [0.5, -0.1]}, 'has no effect: only with kind = "polyline"'),
    ],
)
def test_keys_without_effect_are_refused(keys, line):
    with refused_in_one_line(line):
        scenario_of(STEP, **keys)


def test_it_may_touch_and_hold_the_beam():
    level = [[0.2, -0.1], [0.2, 0.0], [1.2, 0.0], [1.2, -0.1], [0.2, -0.1]]
    found = scenario_of(level, bedding=1e6)  # which has no corner that would lie on the axis
    assert found.outlines[1].distance(0.5) == pytest.approx(0.0)
    # the root of a beam may be on it
    scenario_of([[0.0, 0.1], [0.0, -0.05], [1.0, -0.1]])
