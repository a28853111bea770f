"""The problems that programs are compared on, as they are posed to each, and what a run of one gives."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, sin
from pathlib import Path
from typing import NamedTuple

from oblique_impact import Scenario

FOLDER = Path(__file__).parent

#: scenario of each problem: rigid obstacles, no friction, internal damping, without which there is no limit
SCENARIOS = {"slope": str(FOLDER / "slope.toml"), "slap": "slap", "circles": str(FOLDER / "circles.toml")}


class Side(NamedTuple):
    """A plane through (x, y) (m) at an angle (rad), its solid below."""

    x: float
    y: float
    angle: float

    @property
    def normal(self) -> tuple[float, float]:
        """Unit vector out of the solid."""
        return -sin(self.angle), cos(self.angle)


class Circle(NamedTuple):
    """A circle about (x, y) with its radius, m."""

    x: float
    y: float
    radius: float


class Question(NamedTuple):
    """What is asked of programs: for each its name, its settings, and a run that returns what it finds."""

    title: str
    runs: list[tuple[str, str, Callable[[], str]]]


class Found(NamedTuple):
    """What a program finds."""

    impulse: float  # N s, of all normal forces
    depth: float  # m, deepest penetration
    processor: float  # s, of marching


def obstacles_of(scenario: Scenario) -> list[Side | Circle]:
    """Return what the beam may touch."""
    slope, found = scenario.slope, []
    if slope.enabled:
        found.append(Side(*slope.origin, slope.angle))
    for obstacle in scenario.obstacles:
        side = obstacle.kind == "side"
        found.append((Side if side else Circle)(*obstacle.origin, obstacle.angle if side else obstacle.radius))
    return found
