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

from oblique_impact.beam.axis import panel_of
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array

if TYPE_CHECKING:
    from oblique_impact.scenario.scenario import Scenario


class Shaking(NamedTuple):
    """Acceleration of the base in a fixed direction: harmonic with a sweep, or that of a table."""

    cosine: float  # of the direction
    sine: float
    acceleration: float  # m/s^2, amplitude
    frequency: float  # Hz, at t = 0
    sweep_rate: float  # Hz/s
    table: Array  # (rows, 2) time (s) and acceleration (m/s^2); no rows: harmonic

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times (s) at which the acceleration is not smooth: the rows of a table."""
        return tuple(self.table[:, 0].tolist())


def shaking_of(scenario: Scenario) -> Shaking | None:
    """Return the shaking of a scenario; None if its base stands still, which costs kernels nothing."""
    base = scenario.base
    if not base.is_shaken:
        return None
    direction = math.cos(base.direction), math.sin(base.direction)
    table = np.array(base.table, dtype=float).reshape(-1, 2)
    return Shaking(*direction, base.acceleration, base.frequency, base.sweep_rate, table)


@jitable
def base_acceleration(shaking: Shaking, t: float) -> float:
    """Acceleration (m/s^2) at t (s); before the first and after the last row of a table it is theirs."""
    table = shaking.table
    if table.shape[0] == 0:
        phase = 2.0 * math.pi * (shaking.frequency + 0.5 * shaking.sweep_rate * t) * t
        return shaking.acceleration * math.sin(phase)
    if t <= table[0, 0]:
        return float(table[0, 1])
    if t >= table[-1, 0]:
        return float(table[-1, 1])
    k = panel_of(table[:, 0], t)
    part = (t - table[k, 0]) / (table[k + 1, 0] - table[k, 0])
    return float(table[k, 1] + part * (table[k + 1, 1] - table[k, 1]))


@inlined
def direction_in_frame(shaking: Shaking, c: Any, s: Any) -> tuple[Any, Any]:
    """Components along x and y of the frame, whose angle has the cosine c and the sine s, of the direction."""
    return shaking.cosine * c + shaking.sine * s, shaking.sine * c - shaking.cosine * s


@jitable
def weight_in_frame(shaking: Shaking | None, gravity: float, t: float, theta: float) -> tuple[float, float, float]:
    """Factors g, c and s of the weight of a unit mass, -g s along x and -g c along y of a frame at `theta` (rad).

    On a shaken base the inertia force is part of it; g is 1 then.  The compiler drops one of the two branches.
    """
    c, s = np.cos(theta), np.sin(theta)
    if shaking is None:
        return gravity, c, s
    along, across = direction_in_frame(shaking, c, s)
    a = base_acceleration(shaking, t)
    return 1.0, gravity * c + a * across, gravity * s + a * along
