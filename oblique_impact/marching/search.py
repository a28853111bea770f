"""The first fall of a guard through zero inside a step, on its dense output.

The step is walked in parts.  A part's guards and their slopes are taken at its ends and its middle; the
cubic through the ends must give the middle, or the part is halved.  Where it does, the cubics of the
two halves show every fall and every dip below zero, and a root finder closes in on the first.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from oblique_impact.contact.forces import add_stretch, guards_into, slides_stretching
from oblique_impact.contact.state import GUARDS, NORMAL, Candidate, Contacts, Tolerances
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array
from oblique_impact.marching.buffers import (
    ARMED,
    AT,
    NO_GUARD,
    SLOPES,
    THRESHOLD,
    VALUES,
    Scratch,
    guard_count,
    raised,
)
from oblique_impact.marching.dop853 import DENSE_STAGES, Stages, interpolate
from oblique_impact.marching.equations import derivative
from oblique_impact.marching.location import cubic_dip, find_fall, find_rise, find_trough

UNDEFINED = -2
#: of the time scale, how far before and after an instant forces are solved for their rates: those of the fastest
#: of 128 modes of a beam, 5e6 over that scale, are then known to 4e-4, and rounding counts 1e8 times
NEARBY = 1e-8

#: parts of a step: halves at first; the narrowest is below what the dense output resolves
_WIDEST, _NARROWEST = 0.5, 2.0**-10
_SLOPE_STEP = 1e-5  # of a part: one-sided differences with it are good to about that, and to 1e-11 of the value
_FOLLOWS = 0.1  # of the guard's range, the error of a cubic that follows it
_HALVES_ERROR = 0.25  # of the error in the middle, a bound on that of the halves' cubics (1/16 to 4th order)
_CLOSE = 1e-13  # of a step: some hundred units of rounding of its fraction
_START, _MIDDLE, _END = 0, 1, 2


class DenseStep(NamedTuple):
    """A step of length h (s) from (t, y) with its dense output; a `Trial`."""

    system: Any
    contacts: Contacts
    t: float
    h: float
    y: Array
    scratch: Scratch
    stages: Stages

    def guard_at(self, x: float, guard: int) -> float:
        """One guard, raised until it is armed, at the fraction x of the step; -1 if it is undefined there."""
        g = self.scratch.guards
        return raised(g[AT, guard], guard, g) if _guards_at(self, x) else -1.0


@jitable
def _guards_at(step: DenseStep, x: float) -> bool:
    """Guards and normal forces at the fraction x of the step; False if they are undefined there."""
    s, stages, t = step.scratch, step.stages, step.t + x * step.h
    rates = stages.K[DENSE_STAGES - 1]
    interpolate(stages.F, step.y, x, s.at)
    status = derivative(step.system, step.contacts, t, s.at, s.work, rates)
    spare = stages.K[DENSE_STAGES - 2]
    return status == 0 and take_guards(step.system, step.contacts, t, s.at, rates, s, spare)


@jitable
def take_guards(system: Any, contacts: Contacts, t: float, y: Array, dy: Array, s: Scratch, spare: Array) -> bool:
    """Guards at a state y with its derivative dy and solved contacts; False if there is no solution nearby.

    While a contact slides on a rigid stop with axial flexibility, the velocity that friction sees has the rate of
    its force, a difference along the motion.  `s.at`, which may be y, and `spare` (ny,) are overwritten.
    """
    at = s.guards[AT]
    guards_into(contacts, at)
    if not slides_stretching(contacts):
        return True
    before, after = nearby(t, s.tolerances)
    for m in range(y.shape[0]):
        s.at[m] = y[m] + (before - t) * dy[m]
    failed = derivative(system, contacts, before, s.at, s.work, spare)
    add_stretch(contacts, -1.0 / (after - before), at)
    for m in range(y.shape[0]):
        s.at[m] += (after - before) * dy[m]
    status = derivative(system, contacts, after, s.at, s.work, spare)
    add_stretch(contacts, 1.0 / (after - before), at)
    return failed == 0 and status == 0


@inlined
def nearby(t: float, tolerances: Tolerances) -> tuple[float, float]:
    """Return times (s) before and after t between which rates of forces are taken."""
    h = NEARBY * tolerances.time
    return t - h, t + h


@jitable
def _take(step: DenseStep, x: float, shift: float, row: int) -> bool:
    """Guards, normal forces and their slopes (per step) at the fraction x into a row; False if undefined."""
    g = step.scratch.guards
    for part in range(2):
        if not _guards_at(step, x + part * shift):
            return False
        for k in range(g.shape[1]):
            if part == 0:
                g[VALUES + row, k] = g[AT, k]
            else:
                g[SLOPES + row, k] = (g[AT, k] - g[VALUES + row, k]) / shift
    return True


@jitable
def _move(g: Array, source: int, target: int) -> None:
    for k in range(g.shape[1]):
        g[VALUES + target, k] = g[VALUES + source, k]
        g[SLOPES + target, k] = g[SLOPES + source, k]


@jitable
def _dip(g: Array, half: int, guard: int, width: float) -> tuple[float, float]:
    """Least value of a guard (raised until armed) in a half of the part, and where in it; -1 if at an end."""
    offset = 0.0 if g[ARMED, guard] != 0.0 else g[THRESHOLD, guard]
    ga, gb = g[VALUES + half, guard] + offset, g[VALUES + half + 1, guard] + offset
    return cubic_dip(ga, gb, 0.5 * width * g[SLOPES + half, guard], 0.5 * width * g[SLOPES + half + 1, guard])


@jitable
def _highest(g: Array, column: int, half: int, width: float) -> float:
    """Largest value of a column, the normal force (N) or a guard, in a half of the part.

    A force that jumps as contact begins, against a damped flexibility, has a slope there that means nothing.
    """
    values = g[VALUES + half, column], g[VALUES + half + 1, column]
    low, high = min(values[0], values[1]), max(values[0], values[1])
    if _defect(g, column, width) > _FOLLOWS * (high - low):
        return float(high)
    slopes = 0.5 * width * g[SLOPES + half, column], 0.5 * width * g[SLOPES + half + 1, column]
    return float(-cubic_dip(-values[0], -values[1], -slopes[0], -slopes[1])[0])


@jitable
def _defect(g: Array, guard: int, width: float) -> float:
    """Error of the cubic through the ends of a part in its middle: of the value, or a quarter of the slope's."""
    ga, gm, gb = g[VALUES + _START, guard], g[VALUES + _MIDDLE, guard], g[VALUES + _END, guard]
    sa, sm, sb = (
        width * g[SLOPES + _START, guard],
        width * g[SLOPES + _MIDDLE, guard],
        width * g[SLOPES + _END, guard],
    )
    of_value = abs(gm - 0.5 * (ga + gb) - 0.125 * (sa - sb))
    of_slope = abs(sm - 1.5 * (gb - ga) + 0.25 * (sa + sb))
    return float(max(of_value, 0.25 * of_slope))


@jitable
def _uncertainty(g: Array, guard: int, width: float) -> float:
    """Bound on the error of the halves' cubics, that of one-sided differences for slopes included."""
    bend = width * abs(g[SLOPES + _START, guard] - g[SLOPES + _END, guard])
    return float(_HALVES_ERROR * _defect(g, guard, width) + _SLOPE_STEP * bend)


@jitable
def _resolved(g: Array, guard: int, width: float) -> bool:
    """Whether the halves' cubics can be trusted to show where a guard falls."""
    defect = _defect(g, guard, width)
    if defect <= g[THRESHOLD, guard]:
        return True
    low = min(g[VALUES + _START, guard], g[VALUES + _MIDDLE, guard], g[VALUES + _END, guard])
    high = max(g[VALUES + _START, guard], g[VALUES + _MIDDLE, guard], g[VALUES + _END, guard])
    swing = 0.25 * width * max(abs(g[SLOPES + _START, guard]), abs(g[SLOPES + _END, guard]))
    if defect > _FOLLOWS * (high - low) and low < 2.0 * (high - low + defect + swing):
        return False
    for half in range(2):
        least, place = _dip(g, half, guard, width)
        if place >= 0.0 and abs(least) < _uncertainty(g, guard, width):
            return False
    return True


@jitable
def _fall(step: DenseStep, guard: int, half: int, start: float, width: float) -> float:
    """Fraction of the step where a guard falls in a half of the part that begins at `start`; 2 if nowhere."""
    g, a = step.scratch.guards, start + 0.5 * width * half
    b = a + 0.5 * width
    offset = 0.0 if g[ARMED, guard] != 0.0 else g[THRESHOLD, guard]
    fa, fb = g[VALUES + half, guard] + offset, g[VALUES + half + 1, guard] + offset
    if fb > 0.0:
        least, place = _dip(g, half, guard, width)
        margin = _uncertainty(g, guard, width) if g[ARMED, guard] != 0.0 else 0.0
        if place < 0.0 or least >= margin:
            return 2.0
        b, fb = find_trough(step, guard, a, b, a + 0.5 * width * place)
        if b < 0.0:
            return 2.0
    if g[ARMED, guard] == 0.0:
        # a flight shorter than the bracket: its end is a root only where the guard has risen before
        risen = find_rise(step, guard, a, b, 2.0 * g[THRESHOLD, guard])
        if risen > a:
            g[ARMED, guard] = 1.0
            a, fa = risen, g[THRESHOLD, guard]
            fb = min(fb - offset, 0.0)
    return find_fall(step, guard, a, fa, b, fb, _CLOSE, 0.0)


@jitable
def _fall_rate(g: Array, guard: int, half: int, x: float, width: float) -> float:
    """Slope of a guard (per step) at the fraction x of a half of a part, by the cubic."""
    ga, gb = g[VALUES + half, guard], g[VALUES + half + 1, guard]
    sa, sb = 0.5 * width * g[SLOPES + half, guard], 0.5 * width * g[SLOPES + half + 1, guard]
    c2 = 3.0 * (gb - ga) - 2.0 * sa - sb
    c3 = sa + sb - 2.0 * (gb - ga)
    return float((sa + x * (2.0 * c2 + 3.0 * x * c3)) / (0.5 * width))


@inlined
def _keep_largest(c: Candidate, force: float, depth: float) -> None:
    """Keep the largest force (N) and depth (m) of a contact."""
    c.peak_force = max(c.peak_force, force)
    c.peak_depth = max(c.peak_depth, depth)


@jitable
def first_fall(step: DenseStep) -> tuple[int, float, float]:
    """First guard that falls through zero in a step, the fraction where, and its rate (1/s).

    Contacts keep their largest normal force (N) and the largest of their normal guard, which is the depth (m) in a
    compliant stop.  The guard is NO_GUARD if none falls, UNDEFINED if the contact problem loses its solution
    first.
    """
    g, start, width = step.scratch.guards, 0.0, _WIDEST
    count = guard_count(g)
    contacts = g.shape[1] - count
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
        for k in range(count):
            resolved = resolved and _resolved(g, k, width)
        if not resolved and width > _NARROWEST:
            width *= 0.5
            at_end = defined
            if defined:
                _move(g, _MIDDLE, _END)
            continue
        if not defined:
            return UNDEFINED, 1.0, 0.0
        for half in range(2):
            first, place = NO_GUARD, 2.0
            for k in range(count):
                x = _fall(step, k, half, start, width)
                if x < place:
                    first, place = k, x
            if first >= 0:
                part = (place - start) / (0.5 * width) - half
                for i in range(contacts):
                    force, deep = g[VALUES + half, count + i], g[VALUES + half, GUARDS * i + NORMAL]
                    _keep_largest(step.contacts.each[i], force, deep)
                return first, place, _fall_rate(g, first, half, part, width) / step.h
            for i in range(contacts):
                force = _highest(g, count + i, half, width)
                deep = _highest(g, GUARDS * i + NORMAL, half, width)
                _keep_largest(step.contacts.each[i], force, deep)
            for k in range(count):
                if g[VALUES + half + 1, k] > g[THRESHOLD, k]:
                    g[ARMED, k] = 1.0
        _move(g, _END, _START)
        start += width
        width, at_end = min(2.0 * width, _WIDEST, 1.0 - start), False
    return NO_GUARD, 1.0, 0.0
