"""Friction laws, one class per set-valued law.

Between its kinks every law here is a straight line, lambda_tau = (intercept + slope v) lambda_n over an
interval of slip velocity v: a :class:`Branch`.  The marching source knows branches only, one at a time or all of
them (:func:`branch_table`), so a new law is a new class here and nothing else.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import inf, isfinite
from typing import NamedTuple

import numpy as np

from oblique_impact.errors import InputError
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array

_MAX_BRANCHES = 10_000
_FAR = 10.0  # m/s beyond the last kink: the speed at which its last branch is checked


class Branch(NamedTuple):
    """lambda_tau = (intercept + slope v) lambda_n for lower < v < upper (m/s)."""

    intercept: float
    slope: float
    lower: float
    upper: float


class FrictionLaw(ABC):
    """A set-valued friction law."""

    #: static coefficient of a law with a stick state, None for a law that always slips
    static: float | None = None

    def check(self, end_time: float) -> None:
        """Raise InputError if the branches do not fit together; called before a run of a user-defined law.

        They have to follow each other without gaps, must not push along the slip, and must begin inside of the
        static cone of a law that has one.
        """
        for direction in (1, -1):
            start = self.branch(0.0, direction)
            if self.static is not None and abs(start.intercept) > self.static * (1.0 + 1e-12):
                words = f"static = {self.static:g}, should be at least the {abs(start.intercept):g} of slow slip"
                raise InputError(f"{type(self).__name__}: {words}")
            for branch in self.outwards(direction):
                inner, outer = (branch.lower, branch.upper)[::direction]
                near = inner if isfinite(inner) else 0.0
                for v in (near, outer if isfinite(outer) else near + direction * _FAR):
                    if v * (branch.intercept + branch.slope * v) > 1e-9 * abs(v * branch.intercept):
                        raise InputError(f"{type(self).__name__}: pushes along the slip at {v:g} m/s")

    def outwards(self, direction: int) -> Iterator[Branch]:
        """Yield the branches from zero slip on in a direction; raises InputError if they do not fit together."""
        branch = self.branch(0.0, direction)
        for _ in range(_MAX_BRANCHES):
            inner, outer = (branch.lower, branch.upper)[::direction]
            if not branch.lower < branch.upper:
                raise InputError(f"{type(self).__name__}: the branch at {inner:g} m/s is empty")
            yield branch
            if not isfinite(outer):
                return
            branch = self.branch(outer, direction)
            if (branch.lower, branch.upper)[::direction][0] != outer:
                raise InputError(f"{type(self).__name__}: no branch begins at {outer:g} m/s, where another ends")
        raise InputError(f"{type(self).__name__}: has more than {_MAX_BRANCHES} branches")

    @property
    def rubs(self) -> bool:
        """Whether there is any force in slip."""
        return bool(np.any(branch_table(self)[:, 1:]))

    @abstractmethod
    def branch(self, slip_rate: float, direction: int) -> Branch:
        """Return the branch at `slip_rate` (m/s); on a kink the one on the side of `direction` (+1, -1)."""


def branch_table(law: FrictionLaw) -> Array:
    """Return upper end (m/s), intercept and slope of all branches of a law, (k, 3), in ascending order."""
    branches = [*reversed([*law.outwards(-1)]), *law.outwards(1)]
    return np.array([[branch.upper, branch.intercept, branch.slope] for branch in branches])


@jitable
def coefficient_at(table: Array, slip_rate: float) -> float:
    """Coefficient |lambda_tau| / lambda_n at a slip velocity (m/s), by the branches of a law."""
    row = 0
    while slip_rate > table[row, 0]:
        row += 1
    return float(abs(table[row, 1] + table[row, 2] * slip_rate))


@dataclass(frozen=True)
class Frictionless(FrictionLaw):
    """No tangential force."""

    def branch(self, slip_rate: float, direction: int) -> Branch:  # noqa: D102
        return Branch(0.0, 0.0, -inf, inf)


@dataclass(frozen=True)
class Coulomb(FrictionLaw):
    """Coulomb's law with a stick state: the tangential law of the hybrid model.

    |lambda_tau| <= static lambda_n while sticking, lambda_tau = -kinetic sign(v) lambda_n while sliding.
    """

    static: float = 0.3
    kinetic: float = 0.3

    def branch(self, slip_rate: float, direction: int) -> Branch:  # noqa: D102
        sign = direction if slip_rate == 0.0 else (1 if slip_rate > 0.0 else -1)
        if sign > 0:
            return Branch(-self.kinetic, 0.0, 0.0, inf)
        return Branch(self.kinetic, 0.0, -inf, 0.0)


@dataclass(frozen=True)
class ModifiedCoulomb(FrictionLaw):
    """Coulomb's law smoothed around zero slip, without a stick state (paper, Sec. 7).

    lambda_tau = -kinetic c_d(|v|) sign(v) lambda_n with c_d = 0 up to v0, linear up to v1, 1 beyond.
    """

    kinetic: float = 0.3
    v0: float = 1e-3
    v1: float = 1e-2

    def branch(self, slip_rate: float, direction: int) -> Branch:  # noqa: D102
        kinks = [-self.v1, -self.v0, 0.0, self.v0, self.v1]
        place = (bisect_right if direction > 0 else bisect_left)(kinks, slip_rate)
        edges = [-inf, *kinks, inf]
        intercept, slope = self._line(place)
        return Branch(intercept, slope, edges[place], edges[place + 1])

    def _line(self, place: int) -> tuple[float, float]:
        if place in (0, 5):
            return (self.kinetic if place == 0 else -self.kinetic), 0.0
        if place in (2, 3):
            return 0.0, 0.0
        slope = -self.kinetic / (self.v1 - self.v0)
        return (-slope if place == 4 else slope) * self.v0, slope


@dataclass(frozen=True)
class FrictionCurve(FrictionLaw):
    """Friction coefficient over slip speed, linear between points: lambda_tau = -mu(|v|) sign(v) lambda_n.

    Attributes
    ----------
    points : tuple of (float, float)
        Speeds (m/s), from 0 upwards, and coefficients; beyond the last point the coefficient stays.
    static : float, optional
        Static coefficient of a law with a stick state.

    Raises
    ------
    InputError
        If the speeds do not begin at 0 and ascend, or a coefficient is negative.
    """

    points: tuple[tuple[float, float], ...]
    static: float | None = None

    def __post_init__(self) -> None:
        speeds = [v for v, _ in self.points]
        if not speeds or speeds[0] != 0.0 or any(b <= a for a, b in pairwise(speeds)):
            raise InputError("points: the speeds should begin at 0 m/s and ascend")
        if not all(isfinite(v) and 0.0 <= mu < inf for v, mu in self.points):
            raise InputError("points: speeds and coefficients should be finite, coefficients not negative")

    def branch(self, slip_rate: float, direction: int) -> Branch:  # noqa: D102
        side = direction if slip_rate == 0.0 else (1 if slip_rate > 0.0 else -1)
        outwards = side * direction > 0
        speeds = [v for v, _ in self.points]
        place = (bisect_right if outwards else bisect_left)(speeds, abs(slip_rate)) - 1
        place = max(place, 0)
        v0, mu0 = self.points[place]
        v1, mu1 = self.points[place + 1] if place + 1 < len(self.points) else (inf, mu0)
        steepness = (mu1 - mu0) / (v1 - v0)
        # lambda_tau = -s (mu0 + steepness (s v - v0)) lambda_n on the side s of zero slip
        edges = (v0, v1) if side > 0 else (-v1, -v0)
        return Branch(-side * (mu0 - steepness * v0), -steepness, *edges)


def friction_law(
    model: str, mu_static: float, mu_kinetic: float, regularization: tuple[float, float] = (1e-3, 1e-2)
) -> FrictionLaw:
    """Build the law of a scenario's `contact.friction`.

    `regularization` holds the velocities v0, v1 (m/s) of the modified Coulomb law.  Raises KeyError for an
    unknown name (the scenario has been validated before).
    """
    laws: dict[str, FrictionLaw] = {
        "frictionless": Frictionless(),
        "hybrid": Coulomb(static=mu_static, kinetic=mu_kinetic),
        "modified-coulomb": ModifiedCoulomb(mu_kinetic, *regularization),
    }
    return laws[model]
