"""A shaken base: root and obstacles move together, without turning, by a given acceleration.

Seen from the base, which is the frame of all coordinates, obstacles stand still and gravity changes with time:
each mass m carries besides its weight the inertia force -m a(t).

`Shaking`          the acceleration as kernels read it
`shaking_of`       that of a scenario
`weight_in_frame`  weight with the inertia force, in the floating frame
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from oblique_impact.beam.time_course import TimeCourse, value_at
from oblique_impact.kernels.jit import inlined, jitable

if TYPE_CHECKING:
    from oblique_impact.scenario.scenario import Scenario


class Shaking(NamedTuple):
    """Acceleration of the base in a fixed direction."""

    cosine: float  # of the direction
    sine: float
    acceleration: TimeCourse  # m/s^2

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times (s) at which the acceleration is not smooth."""
        return self.acceleration.breakpoints


#: of a base that stands still: kernels have a shaking, so that they are compiled once for both
STILL = Shaking(1.0, 0.0, TimeCourse.of(0.0, 0.0, 0.0, ()))


def shaking_of(scenario: Scenario) -> Shaking | None:
    """Return the shaking of a scenario; None if its base stands still."""
    base = scenario.base
    if not base.is_shaken:
        return None
    course = TimeCourse.of(base.acceleration, base.frequency, base.sweep_rate, base.table)
    return Shaking(math.cos(base.direction), math.sin(base.direction), course)


@inlined
def stands_still(shaking: Shaking) -> bool:
    """Whether the base is not shaken at all."""
    return shaking.acceleration.amplitude == 0.0 and shaking.acceleration.table.shape[0] == 0


@jitable
def base_acceleration(shaking: Shaking, t: float) -> float:
    """Acceleration (m/s^2) at t (s)."""
    return value_at(shaking.acceleration, t)


@inlined
def direction_in_frame(shaking: Shaking, c: Any, s: Any) -> tuple[Any, Any]:
    """Components along x and y of the frame, whose angle has the cosine c and the sine s, of the direction."""
    return shaking.cosine * c + shaking.sine * s, shaking.sine * c - shaking.cosine * s


@jitable
def weight_in_frame(shaking: Shaking, gravity: float, t: float, theta: float) -> tuple[float, float, float]:
    """Factors g, c and s of the weight of a unit mass, -g s along x and -g c along y of a frame at `theta` (rad).

    On a shaken base the inertia force is part of it; g is 1 then.
    """
    c, s = np.cos(theta), np.sin(theta)
    if stands_still(shaking):
        return gravity, c, s
    along, across = direction_in_frame(shaking, c, s)
    a = base_acceleration(shaking, t)
    return 1.0, gravity * c + a * across, gravity * s + a * along
