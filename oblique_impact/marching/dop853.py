"""One step of the explicit Runge-Kutta method of order 8(5,3) with dense output of order 7.

Dormand and Prince's method as given by Hairer, Norsett, Wanner, Solving Ordinary Differential
Equations I, Sec. II.5 and II.10; the coefficients are those of `scipy.integrate.DOP853` (`dop853_table`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from oblique_impact.contact.forces import is_free, nearest
from oblique_impact.contact.state import GUARDS, Contacts
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array, Workspace, copy
from oblique_impact.marching.buffers import Scratch, guard_count
from oblique_impact.marching.dop853_table import E3 as _E3
from oblique_impact.marching.dop853_table import E5 as _E5
from oblique_impact.marching.dop853_table import A as _A
from oblique_impact.marching.dop853_table import C as _C
from oblique_impact.marching.dop853_table import D as _D
from oblique_impact.marching.equations import (
    FRICTION_LOSS,
    OF_A_CONTACT,
    QUADRATURES,
    STOP_LOSS,
    derivative,
)

ORDER = 8
STAGES = 12
DENSE_STAGES = STAGES + 4  # the derivative at the end of the step, three stages more
DENSE_TERMS = 7


class Stages(NamedTuple):
    """Buffers of the method."""

    K: Array  # (16, ny) derivatives
    F: Array  # (7, ny) coefficients of the dense output

    @classmethod
    def new(cls, ny: int) -> Stages:
        """Allocate them for state vectors of `ny` entries."""
        return cls(np.zeros((DENSE_STAGES, ny)), np.zeros((DENSE_TERMS, ny)))


@jitable
def take_stages(
    system: Any,
    contacts: Contacts,
    t: float,
    y: Array,
    h: float,
    first: int,
    last: int,
    K: Array,
    w: Workspace,
    at: Array,
) -> tuple[int, float]:
    """Evaluate the stages first..last of a step of length h from (t, y) into the rows of K.

    K[0] must hold the derivative at (t, y).  Stages 1 to 12 are the step: `at` then holds the new state and
    K[12] its derivative.  Stages 13 to 15 are those of the dense output.  Returns the status and, in free flight,
    the largest gap rate met (m/s).
    """
    speed, free = 0.0, is_free(contacts)
    for i in range(first, last + 1):
        copy(y, at)
        for j in range(i):
            weight = h * _A[i, j]
            if weight != 0.0:
                for m in range(y.shape[0]):
                    at[m] += weight * K[j, m]
        status = derivative(system, contacts, t + _C[i] * h, at, w, K[i])
        if status != 0:
            return status, speed
        if free:
            speed = max(speed, nearest(contacts)[1])
    return 0, speed


@jitable
def error_norm(h: float, y: Array, stages: Stages, s: Scratch, tolerance: float) -> float:
    """Error of the end of a step, s.y_new: of q and q' relative to the tolerance (of the scales, and relative).

    Or, if it is larger, of a loss of energy, relative to that of the energy: damping takes most of what an impact
    leaves in the fastest modes within a step or two.
    """
    sum5, sum3, worst, size, K, scales, y_new = 0.0, 0.0, 0.0, s.scales.shape[0], stages.K, s.scales, s.y_new
    for m in range(size):
        scale = tolerance * (scales[m] + max(abs(y[m]), abs(y_new[m])))
        e5, e3 = _errors(K, m, scale)
        sum5 += e5 * e5
        sum3 += e3 * e3
    energy = s.tolerances.energy
    for m in range(size, size + QUADRATURES):
        worst = max(worst, _error_of_loss(K, y_new, m, 1, energy, tolerance))
    contacts = guard_count(s.guards) // GUARDS
    for which in (FRICTION_LOSS, STOP_LOSS):
        worst = max(worst, _error_of_loss(K, y_new, size + QUADRATURES + which, contacts, energy, tolerance))
    return float(abs(h) * max(worst, _combined(sum5, sum3, size)))


@jitable
def _error_of_loss(K: Array, y_new: Array, first: int, contacts: int, energy: float, tolerance: float) -> float:
    """Error of a loss of energy, or of the sum of one over contacts, from the entry `first` of y_new on."""
    total, e5, e3 = 0.0, 0.0, 0.0
    for i in range(contacts):
        m = first + OF_A_CONTACT * i
        own5, own3 = _errors(K, m, 1.0)
        total, e5, e3 = total + y_new[m], e5 + own5, e3 + own3
    scale = tolerance * (energy + abs(total))
    return _combined((e5 / scale) ** 2, (e3 / scale) ** 2, 1) if scale > 0.0 else 0.0


@jitable
def _errors(K: Array, m: int, scale: float) -> tuple[float, float]:
    """Errors of order 5 and 3 of an entry on its scale, per length of the step."""
    e5, e3 = 0.0, 0.0
    for i in range(STAGES + 1):
        e5 += _E5[i] * K[i, m]
        e3 += _E3[i] * K[i, m]
    return e5 / scale, e3 / scale


@jitable
def _combined(sum5: float, sum3: float, size: int) -> float:
    """Error of order 8 from the squares of those of order 5 and 3, as Hairer, Norsett and Wanner combine them."""
    return float(sum5 / np.sqrt((sum5 + 0.01 * sum3) * size)) if sum5 + sum3 > 0.0 else 0.0


@jitable
def interpolant(y: Array, y_new: Array, h: float, stages: Stages) -> None:
    """Dense-output coefficients of an accepted step from all 16 stages."""
    K, F = stages.K, stages.F
    for m in range(y.shape[0]):
        delta = y_new[m] - y[m]
        F[0, m] = delta
        F[1, m] = h * K[0, m] - delta
        F[2, m] = 2.0 * delta - h * (K[STAGES, m] + K[0, m])
        for r in range(4):
            total = 0.0
            for i in range(DENSE_STAGES):
                total += _D[r, i] * K[i, m]
            F[3 + r, m] = h * total


@jitable
def interpolate(F: Array, y: Array, x: float, result: Array) -> None:
    """Value of the dense output at the fraction x of the step into `result`."""
    for m in range(y.shape[0]):
        value = 0.0
        for r in range(DENSE_TERMS - 1, -1, -1):
            value += F[r, m]
            value *= x if r % 2 == 0 else 1.0 - x
        result[m] = y[m] + value
