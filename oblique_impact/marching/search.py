"""The first fall of a guard through zero inside a step, on its dense output.

The step is walked in parts.  A part's guards and their slopes are taken at its ends and its middle; the
cubic through the ends must foretell the middle, or the part is halved.  Where it does, the cubics of the
two halves show every fall and every dip below zero, and a root finder closes in on the first.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from oblique_impact.contact.forces import guards_of
from oblique_impact.contact.state import GUARDS, NORMAL, Instant, Phase
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.dop853 import DENSE_STAGES, interpolate
from oblique_impact.marching.equations import derivative
from oblique_impact.marching.location import cubic_dip, find_fall, find_rise, find_trough
from oblique_impact.marching.scheme import NO_GUARD, Scratch, raised

UNDEFINED = -2

_WIDEST, _NARROWEST = 0.5, 2.0**-10  # parts of a step
_SLOPE_STEP = 1e-5  # of a part
_FORETOLD = 0.1  # of the guard's range, the error of a cubic that follows it
_HALVES_ERROR = 0.25  # of the error in the middle, a bound on that of the halves' cubics (1/16 to 4th order)
_CLOSE = 1e-13  # of a step
_START, _MIDDLE, _END = 0, 1, 2


class DenseStep(NamedTuple):
    """A step of length h (s) from (t, y) with its dense output; a `Trial`."""

    system: Any
    phase: Phase
    t: float
    h: float
    y: Array
    scratch: Scratch

    def guard_at(self, x: float, guard: int) -> float:
        """One guard, raised until it is armed, at the fraction x of the step; -1 if it is undefined there."""
        defined, c = _contact_at(self, x)
        return raised(guards_of(self.phase, c)[guard], guard, self.scratch) if defined else -1.0


@jitable
def _contact_at(step: DenseStep, x: float) -> tuple[bool, Instant]:
    """Solution of the contact problem at the fraction x of the step; False if there is none."""
    s = step.scratch
    interpolate(s.F, step.y, x, s.at)
    status, c = derivative(step.system, step.phase, step.t + x * step.h, s.at, s.work, s.K[DENSE_STAGES - 1])
    return status == 0, c


@jitable
def _take(step: DenseStep, x: float, shift: float, row: int) -> bool:
    """Guards, the normal force and their slopes (per step) at the fraction x into a row; False if undefined."""
    s = step.scratch
    for part in range(2):
        defined, c = _contact_at(step, x + part * shift)
        if not defined:
            return False
        guards = guards_of(step.phase, c)
        for k in range(GUARDS + 1):
            value = guards[k] if k < GUARDS else c.normal_force
            if part == 0:
                s.values[row, k] = value
            else:
                s.slopes[row, k] = (value - s.values[row, k]) / shift
    return True


@jitable
def _move(s: Scratch, source: int, target: int) -> None:
    for k in range(GUARDS + 1):
        s.values[target, k] = s.values[source, k]
        s.slopes[target, k] = s.slopes[source, k]


@jitable
def _dip(s: Scratch, half: int, guard: int, width: float) -> tuple[float, float]:
    """Least value of a guard (raised until armed) in a half of the part, and where in it; -1 if at an end."""
    offset = 0.0 if s.armed[guard] else s.thresholds[guard]
    ga, gb = s.values[half, guard] + offset, s.values[half + 1, guard] + offset
    return cubic_dip(ga, gb, 0.5 * width * s.slopes[half, guard], 0.5 * width * s.slopes[half + 1, guard])


@jitable
def _highest(s: Scratch, column: int, half: int, width: float) -> float:
    """Largest value of a column, the normal force (N) or a guard, in a half of the part.

    A force that jumps as contact begins, against a damped flexibility, has a slope there that means nothing.
    """
    values = s.values[half, column], s.values[half + 1, column]
    low, high = min(values[0], values[1]), max(values[0], values[1])
    if _defect(s, column, width) > _FORETOLD * (high - low):
        return float(high)
    slopes = 0.5 * width * s.slopes[half, column], 0.5 * width * s.slopes[half + 1, column]
    return float(-cubic_dip(-values[0], -values[1], -slopes[0], -slopes[1])[0])


@jitable
def _defect(s: Scratch, guard: int, width: float) -> float:
    """Error of the cubic through the ends of a part in its middle: of the value, or a quarter of the slope's."""
    ga, gm, gb = s.values[_START, guard], s.values[_MIDDLE, guard], s.values[_END, guard]
    sa, sm, sb = (
        width * s.slopes[_START, guard],
        width * s.slopes[_MIDDLE, guard],
        width * s.slopes[_END, guard],
    )
    of_value = abs(gm - 0.5 * (ga + gb) - 0.125 * (sa - sb))
    of_slope = abs(sm - 1.5 * (gb - ga) + 0.25 * (sa + sb))
    return float(max(of_value, 0.25 * of_slope))


@jitable
def _uncertainty(s: Scratch, guard: int, width: float) -> float:
    """Bound on the error of the halves' cubics, that of one-sided differences for slopes included."""
    bend = width * abs(s.slopes[_START, guard] - s.slopes[_END, guard])
    return float(_HALVES_ERROR * _defect(s, guard, width) + _SLOPE_STEP * bend)


@jitable
def _resolved(s: Scratch, guard: int, width: float) -> bool:
    """Whether the halves' cubics can be trusted to show where a guard falls."""
    defect = _defect(s, guard, width)
    if defect <= s.thresholds[guard]:
        return True
    low = min(s.values[_START, guard], s.values[_MIDDLE, guard], s.values[_END, guard])
    high = max(s.values[_START, guard], s.values[_MIDDLE, guard], s.values[_END, guard])
    swing = 0.25 * width * max(abs(s.slopes[_START, guard]), abs(s.slopes[_END, guard]))
    if defect > _FORETOLD * (high - low) and low < 2.0 * (high - low + defect + swing):
        return False
    for half in range(2):
        least, place = _dip(s, half, guard, width)
        if place >= 0.0 and abs(least) < _uncertainty(s, guard, width):
            return False
    return True


@jitable
def _fall(step: DenseStep, guard: int, half: int, start: float, width: float) -> float:
    """Fraction of the step where a guard falls in a half of the part that begins at `start`; 2 if nowhere."""
    s, a = step.scratch, start + 0.5 * width * half
    b = a + 0.5 * width
    offset = 0.0 if s.armed[guard] else s.thresholds[guard]
    fa, fb = s.values[half, guard] + offset, s.values[half + 1, guard] + offset
    if fb > 0.0:
        least, place = _dip(s, half, guard, width)
        margin = _uncertainty(s, guard, width) if s.armed[guard] else 0.0
        if place < 0.0 or least >= margin:
            return 2.0
        b, fb = find_trough(step, guard, a, b, a + 0.5 * width * place)
        if b < 0.0:
            return 2.0
    if not s.armed[guard]:
        # a flight shorter than the bracket: its end is a root only where the guard has risen before
        risen = find_rise(step, guard, a, b, 2.0 * s.thresholds[guard])
        if risen > a:
            s.armed[guard] = True
            a, fa = risen, s.thresholds[guard]
            fb = min(fb - offset, 0.0)
    return find_fall(step, guard, a, fa, b, fb, _CLOSE, 0.0)


@jitable
def _fall_rate(s: Scratch, guard: int, half: int, x: float, width: float) -> float:
    """Slope of a guard (per step) at the fraction x of a half of a part, by the cubic."""
    ga, gb = s.values[half, guard], s.values[half + 1, guard]
    sa, sb = 0.5 * width * s.slopes[half, guard], 0.5 * width * s.slopes[half + 1, guard]
    c2 = 3.0 * (gb - ga) - 2.0 * sa - sb
    c3 = sa + sb - 2.0 * (gb - ga)
    return float((sa + x * (2.0 * c2 + 3.0 * x * c3)) / (0.5 * width))


@jitable
def first_fall(step: DenseStep) -> tuple[int, float, float, float, float]:
    """First guard that falls through zero in a step, the fraction where, its rate (1/s), and two largest values.

    These are of the normal force (N) and of the normal guard, which is the depth (m) in a stop that gives way.

    The guard is NO_GUARD if none falls, UNDEFINED if the contact problem loses its solution first.
    """
    s, start, width, peak, depth = step.scratch, 0.0, _WIDEST, 0.0, 0.0
    at_start, at_end = False, False  # rows that are taken already
    while start < 1.0:
        resolved = True
        for row in (_START, _END, _MIDDLE):
            if (row == _START and at_start) or (row == _END and at_end) or not resolved:
                continue
            shift = (-_SLOPE_STEP if row == _END else _SLOPE_STEP) * width
            resolved = _take(step, start + 0.5 * width * row, shift, row)
            at_start, at_end = at_start or resolved, resolved and row != _START
        defined = resolved
        for k in range(GUARDS):
            resolved = resolved and _resolved(s, k, width)
        if not resolved and width > _NARROWEST:
            width *= 0.5
            at_end = defined
            if defined:
                _move(s, _MIDDLE, _END)
            continue
        if not defined:
            return UNDEFINED, 1.0, 0.0, peak, depth
        for half in range(2):
            first, place = NO_GUARD, 2.0
            for k in range(GUARDS):
                x = _fall(step, k, half, start, width)
                if x < place:
                    first, place = k, x
            if first >= 0:
                part = (place - start) / (0.5 * width) - half
                peak, depth = max(peak, s.values[half, GUARDS]), max(depth, s.values[half, NORMAL])
                return first, place, _fall_rate(s, first, half, part, width) / step.h, peak, depth
            peak = max(peak, _highest(s, GUARDS, half, width))
            depth = max(depth, _highest(s, NORMAL, half, width))
            for k in range(GUARDS):
                s.armed[k] = s.armed[k] or s.values[half + 1, k] > s.thresholds[k]
        _move(s, _END, _START)
        start += width
        width, at_end = min(2.0 * width, _WIDEST, 1.0 - start), False
    return NO_GUARD, 1.0, 0.0, peak, depth
