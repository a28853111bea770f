"""The location of an event: where inside a step a guard falls through zero.

The same for every scheme that locates.  What a guard is at a fraction of the step the scheme says by a `Trial`:
on its dense output, or by repeating the step with another length.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from oblique_impact.kernels.jit import compiled_protocol, jitable

_GOLDEN = 0.381966011250105  # (3 - sqrt 5)/2
_NARROW = 1e-7  # of a step: how closely a least value is looked for


@compiled_protocol
class Trial(Protocol):
    """One step, of which parts can be tried."""

    def guard_at(self, x: float, guard: int) -> float:
        """Return a guard, raised until it is armed, at the fraction x of the step; -1 where it is undefined."""


@jitable
def cubic_dip(ga: float, gb: float, sa: float, sb: float) -> tuple[float, float]:
    """Least value of the cubic with these end values and slopes on [0, 1], and where; -1 if at an end."""
    best, place = min(ga, gb), -1.0
    c2 = 3.0 * (gb - ga) - 2.0 * sa - sb
    c3 = sa + sb - 2.0 * (gb - ga)
    discriminant = c2 * c2 - 3.0 * c3 * sa
    if discriminant < 0.0:
        return best, place
    root = np.sqrt(discriminant)
    for sign in (-1.0, 1.0):
        denominator = c2 + sign * root
        if denominator == 0.0:
            continue
        x = -sa / denominator
        if 0.0 < x < 1.0:
            value = ga + x * (sa + x * (c2 + x * c3))
            if value < best:
                best, place = value, x
    return best, place


@jitable
def find_trough(trial: Trial, guard: int, a: float, b: float, x: float) -> tuple[float, float]:
    """Fraction in (a, b) where a guard, positive at both ends, is not positive, and its value; -1 if nowhere.

    The search for the least value (golden section) starts from x, where it is expected.
    """
    probe, least = x, np.inf
    # two values after the first leave at most 0.62 of the bracket, which is narrow after 34 such pairs
    for _ in range(80):
        value = trial.guard_at(probe, guard)
        if value <= 0.0:
            return probe, value
        lower = probe < x
        if value < least:
            if lower:
                b = x
            elif probe > x:
                a = x
            x, least = probe, value
        elif lower:
            a = probe
        else:
            b = probe
        if b - a < _NARROW:
            break
        probe = x + _GOLDEN * (b - x) if b - x > x - a else x - _GOLDEN * (x - a)
    return -1.0, 0.0


@jitable
def find_rise(trial: Trial, guard: int, a: float, b: float, height: float) -> float:
    """Fraction in (a, b) where a guard that is about zero at a has risen above a height; a if it never does."""
    x = b
    for _ in range(40):  # to 1e-12 of the bracket, shorter flights than any tolerance resolves
        x = a + 0.5 * (x - a)
        if trial.guard_at(x, guard) > height:
            return x
    return a


@jitable
def find_fall(
    trial: Trial, guard: int, a: float, fa: float, b: float, fb: float, close: float, low: float
) -> float:
    """Fraction in (a, b] where a guard falls from fa > 0 to fb <= 0 (Illinois method); a if fa is not positive.

    Either the bracket is as narrow as `close`, or the guard there is between `low` and 0.
    """
    if fa <= 0.0:
        return a
    wa, wb = fa, fb  # halved where an end stays
    # some ten steps are usual; where sixty are not enough the bracket is halved, and fifty more leave 1e-15 of it
    for step in range(110):
        if b - a <= close or fb >= low:
            break
        x = (a * wb - b * wa) / (wb - wa)
        if step >= 60 or not (a < x < b):
            x = 0.5 * (a + b)
        fx = trial.guard_at(x, guard)
        if fx > 0.0:
            a, wa, wb = x, fx, 0.5 * wb
        else:
            b, fb, wb, wa = x, fx, fx, 0.5 * wa
    return b
