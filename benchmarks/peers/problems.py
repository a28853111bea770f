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


#: impulses (N s) of all normal forces at the scenarios' ends, and how far refinement still moves them: 64 and 128
#: elements, steps of 5e-6 to 1.25e-6 s, and 40 modes in the event scheme
LIMITS = {"slope": (1.8194, 0.0001), "slap": (2.7104, 0.0006), "circles": (3.1339, 0.0002)}


class Cheapest(NamedTuple):
    """The cheapest settings that find an impulse to an error, and still do with the next finer mesh or chain.

    Of `slap` with 24 elements and a place on each node that is chance: 28 and 32 elements miss it.
    """

    problem: str
    error: float  # of the impulse, relative
    elements: int  # ours
    places: int  # of contact along the beam
    step: float  # s, in contact
    links: int  # of MuJoCo's chain
    link_step: float  # s
    aim: float  # of its CPU time over ours, at least


CHEAPEST = (
    Cheapest("slap", 1e-3, 20, 40, 2e-5, 20, 2e-5, 5.0),
    Cheapest("slap", 1e-3, 24, 24, 2e-5, 20, 2e-5, 5.0),
    Cheapest("slope", 2e-3, 12, 12, 2e-5, 20, 2e-5, 7.0),
    Cheapest("circles", 2e-3, 12, 12, 2e-5, 40, 1e-5, 50.0),
)


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
