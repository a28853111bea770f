"""Several obstacles in a scenario: their keys in files, sides and points of them, changes by name."""

from __future__ import annotations

import math
import tomllib

import fastjsonschema
import pytest

from oblique_impact import Scenario, scenario_schema, start_scenario
from oblique_impact.scenario.sections import ObstacleSection
from tests.refusals import refused_in_one_line

TEXT = """
[slope]
extent = [0.0, 2.0]
[contact]
where = "anywhere"
normal = "spring"
stiffness = 2e6
grid = 2
[[obstacles]]
kind = "point"
origin = ["500 mm", 0.0]
radius = "5 mm"
[[obstacles]]
origin = [0.0, 2.0]
angle = 3.141592653589793
extent = [-1.0, 0.5]
stiffness = 3e6
"""


@pytest.fixture(scope="module")
def scenario():
    return Scenario.from_toml(TEXT)


def test_sides_and_points_count_from_the_slope_on(scenario):
    slope, wall = scenario.sides
    assert (slope.obstacle, slope.extent, slope.stiffness) == (0, (0.0, 2.0), 2e6)
    assert (wall.obstacle, wall.angle, wall.stiffness) == (2, math.pi, 3e6)
    first, last, peg, right, left = scenario.obstacle_points
    assert first == (0, 0.3, 0.0, 0.0, 2e6, True)
    assert last[1:3] == pytest.approx((0.3 + 2.0 * math.cos(math.pi / 10), 2.0 * math.sin(math.pi / 10)))
    assert peg == (1, 0.5, 0.0, 0.005, 2e6, False)
    assert [(p.obstacle, p.corner) for p in (right, left)] == [(2, True), (2, True)]
    assert (right.x, right.y, left.x, left.y) == pytest.approx((1.0, 2.0, -0.5, 2.0))
    assert scenario.beam_points == (0.5, 1.0)
    # the solid of a side at pi lies above it, and it runs to the left
    place = wall.gap_and_place(1.0, math.pi / 4)
    assert place == pytest.approx((2.0 - math.sqrt(0.5), -math.sqrt(0.5)))


def test_files_keep_them(scenario, tmp_path):
    resolved = scenario.to_toml()
    assert Scenario.from_toml(resolved) == scenario
    assert resolved.count("[[obstacles]]") == 2
    assert resolved.count("# radius of the peg (a point); 0 is a corner (number in m, >= 0)\nradius = ") == 2
    made = start_scenario(tmp_path / "mine.toml", scenario)
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    assert made == scenario
    assert "\nradius = 0.005\n" in text
    assert "\n#radius = 0.0\n" in text
    valid = fastjsonschema.compile(scenario_schema())
    for file in (TEXT, resolved, text):
        valid(tomllib.loads(file))
    with pytest.raises(fastjsonschema.JsonSchemaException):
        valid(tomllib.loads(TEXT.replace('"point"', '"peg"')))


def test_they_are_changed_as_a_whole_and_item_by_item(scenario):
    peg = ObstacleSection(kind="point", origin=(0.5, 0.0), stiffness=2e6)
    one = Scenario.from_toml(TEXT, ['obstacles=[{kind="point", origin=[0.5, 0.0]}]'])
    assert one.obstacles == (peg,)
    assert scenario.replace(obstacles=(peg,)).obstacles == (peg,)
    changed = Scenario.from_toml(TEXT, ["obstacles.1.radius=1 mm"])
    assert changed == scenario.replace(obstacles__1__radius=1e-3)
    assert (changed.obstacles[0].radius, changed.obstacles[1]) == (1e-3, scenario.obstacles[1])


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ("obstacles.4.radius=1", "4 is none of the 2 items, which count from 1"),
        ("obstacles.0.radius=1", "0 is none of the 2 items"),
        ("obstacles.1=1", "expected a key of an item, as in obstacles.1.key, or the whole list"),
        ("obstacles={kind='side'}", "should be a list of obstacles; in a file each is a table [[obstacles]]"),
        ("obstacles=[3]", "obstacles.1 = 3: should be"),
        ("obstacles.2.angle=7", "obstacles.2.angle = 7"),
    ],
)
def test_wrong_changes_are_one_line(change, line):
    with refused_in_one_line(line):
        Scenario.from_toml(TEXT, [change])
