"""Forces at places of the beam's axis, which change with time.

A force acts on the material point of the axis at its place: its generalized forces are the rows of this point
times its components, and its power is the force times the velocity of the point.  It has a direction fixed in
space, or it is across the axis of the bent beam there and turns with it, a follower force: with the slope phi
of the axis in the floating frame it has the direction (-phi, 1 - phi^2/2).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.beam.time_course import TimeCourse, value_at
from oblique_impact.kernels.jit import by_reference, jitable
from oblique_impact.kernels.workspace import Array, record_of

if TYPE_CHECKING:
    from oblique_impact.scenario.scenario import Scenario

Complex = NDArray[np.complex128]

#: a force on the beam
FORCE = np.dtype(
    [
        ("x", float),  # m along the beam
        ("amplitude", float),  # N
        ("frequency", float),  # Hz, at t = 0
        ("sweep_rate", float),  # Hz/s
        ("first", np.int64),  # of its rows in the table of all forces, and behind the last one
        ("last", np.int64),
        ("follows", np.int64),  # 1: across the bent beam
        ("angle", float),  # rad, of one that does not
    ],
    align=True,
)


class PointForces(NamedTuple):
    """Forces on the beam as kernels read them."""

    each: Any  # (k,) records of `FORCE`
    table: Array  # (rows, 2) times (s) and forces (N) of all tables, one behind the other
    kept: float  # 1, or 0 where terms of second order in the slope are left out

    @property
    def places(self) -> Array:
        """Places (m) along the beam, (k,)."""
        return np.array([force.x for force in self.each])

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times (s) at which forces are not smooth: the rows of tables."""
        return tuple(self.table[:, 0].tolist())

    def in_frame(self, i: int, times: Array, theta: Array, slopes: Array) -> Complex:
        """Return the force i (N) as x + i y of the frame at times (s) with its angles and slopes, (samples,)."""
        states = zip(times.tolist(), theta.tolist(), slopes.tolist(), strict=True)
        return np.array([complex(*force_in_frame(self, i, *state)) for state in states])


#: kernels have forces, so that they are compiled once for beams with and without
NO_FORCES = PointForces(np.zeros(0, FORCE).view(np.recarray), np.zeros((0, 2)), 1.0)


def forces_of(scenario: Scenario, kept: float = 1.0) -> PointForces | None:
    """Return the forces of a scenario; None if there are none."""
    records, rows = [], list[tuple[float, float]]()
    for item in scenario.acting_forces:
        values = {
            "x": item.place,
            "amplitude": item.force,
            "frequency": item.frequency,
            "sweep_rate": item.sweep_rate,
            "first": len(rows),
            "last": len(rows) + len(item.table),
            "follows": item.is_across,
            "angle": 0.0 if item.is_across else float(item.direction),
        }
        records.append(record_of(FORCE, values))
        rows += item.table
    if not records:
        return None
    return PointForces(np.array(records).view(np.recarray), np.array(rows, dtype=float).reshape(-1, 2), kept)


@jitable
def force_value(forces: PointForces, i: int, t: float) -> float:
    """Force i (N) at an instant (s), along its direction."""
    force = forces.each[i]
    rows = forces.table[force.first : force.last]
    return value_at(by_reference(TimeCourse(force.amplitude, force.frequency, force.sweep_rate, rows)), t)


@jitable
def force_in_frame(forces: PointForces, i: int, t: float, theta: float, slope: float) -> tuple[float, float]:
    """Components (N) of force i along and across a frame at `theta` (rad), on a section of this slope in it."""
    force, value = forces.each[i], force_value(forces, i, t)
    if force.follows:
        return -value * slope, value * (1.0 - 0.5 * forces.kept * slope * slope)
    turn = force.angle - theta
    return value * math.cos(turn), value * math.sin(turn)
