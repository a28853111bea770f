"""What a scenario gives over time, as the acceleration of a base and forces: harmonic, a sweep, or a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from oblique_impact.beam.axis import panel_of
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array


class TimeCourse(NamedTuple):
    """A value over time: constant, harmonic with a sweep, or that of a table."""

    amplitude: float  # the value of a constant one
    frequency: float  # Hz, at t = 0
    sweep_rate: float  # Hz/s
    table: Array  # (rows, 2) time (s) and value; no rows: constant or harmonic

    @classmethod
    def of(
        cls, amplitude: float, frequency: float, sweep_rate: float, table: Sequence[tuple[float, float]]
    ) -> TimeCourse:
        """Take the keys of a section."""
        return cls(amplitude, frequency, sweep_rate, np.array(table, dtype=float).reshape(-1, 2))

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times (s) at which the value is not smooth: the rows of a table."""
        return tuple(self.table[:, 0].tolist())


@jitable
def value_at(course: TimeCourse, t: float) -> float:
    """Value at t (s); before the first and after the last row of a table it is theirs."""
    table = course.table
    if table.shape[0] == 0:
        if course.frequency == 0.0 and course.sweep_rate == 0.0:
            return course.amplitude
        phase = 2.0 * math.pi * (course.frequency + 0.5 * course.sweep_rate * t) * t
        return course.amplitude * math.sin(phase)
    if t <= table[0, 0]:
        return float(table[0, 1])
    if t >= table[-1, 0]:
        return float(table[-1, 1])
    k = panel_of(table[:, 0], t)
    part = (t - table[k, 0]) / (table[k + 1, 0] - table[k, 0])
    return float(table[k, 1] + part * (table[k + 1, 1] - table[k, 1]))
