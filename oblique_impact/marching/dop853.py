"""One step of the explicit Runge-Kutta method of order 8(5,3) with dense output of order 7.

Dormand and Prince's method as given by Hairer, Norsett, Wanner, Solving Ordinary Differential
Equations I, Sec. II.5 and II.10; the coefficients are those published with SciPy.
"""

from __future__ import annotations

from importlib import import_module
from importlib.abc import Loader
from importlib.machinery import ModuleSpec
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any, cast

import numpy as np
import scipy

from oblique_impact.contact.state import FREE, NO_CONTACT, Instant, Phase
from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array, copy
from oblique_impact.marching.equations import FRICTION_LOSS, QUADRATURES, derivative
from oblique_impact.marching.scheme import Scratch

ORDER = 8
STAGES = 12
DENSE_STAGES = 16
DENSE_TERMS = 7


def _coefficients() -> ModuleType:
    """Load SciPy's coefficients from their file: all of `scipy.integrate` takes longer than a short run."""
    name = "scipy.integrate._ivp.dop853_coefficients"
    file = Path(scipy.__file__).parent.joinpath(*name.split(".")[1:]).with_suffix(".py")
    if not file.is_file():  # a later SciPy may keep them elsewhere
        return import_module(name)
    spec = cast(ModuleSpec, spec_from_file_location(name, file))
    module = module_from_spec(spec)
    cast(Loader, spec.loader).exec_module(module)
    return module


_SCIPY = _coefficients()
_A, _C = np.asarray(_SCIPY.A), np.asarray(_SCIPY.C)
_E3, _E5, _D = np.asarray(_SCIPY.E3), np.asarray(_SCIPY.E5), np.asarray(_SCIPY.D)


@jitable
def take_stages(
    system: Any, phase: Phase, t: float, y: Array, h: float, first: int, last: int, s: Scratch, at: Array
) -> tuple[int, Instant, float]:
    """Evaluate the stages first..last of a step of length h from (t, y) into the rows of s.K.

    K[0] must hold the derivative at (t, y).  Stages 1 to 12 are the step: `at` then holds the new state and
    K[12] its derivative.  Stages 13 to 15 are those of the dense output.  Returns the status and the contact of
    the last stage and, in free flight, the largest gap rate met (m/s).
    """
    speed, c, K, work = 0.0, NO_CONTACT, s.K, s.work
    for i in range(first, last + 1):
        copy(y, at)
        for j in range(i):
            weight = h * _A[i, j]
            if weight != 0.0:
                for m in range(y.shape[0]):
                    at[m] += weight * K[j, m]
        status, c = derivative(system, phase, t + _C[i] * h, at, work, K[i])
        if status != 0:
            return status, c, speed
        if phase.state == FREE:
            speed = max(speed, abs(c.gap_rate))
    return 0, c, speed


@jitable
def error_norm(h: float, y: Array, s: Scratch, tolerance: float) -> float:
    """Error of the end of a step, s.y_new: of q and q' relative to the tolerance (of the scales, and relative).

    Or, if it is larger, of a loss of energy, relative to that of the energy: damping takes most of what an impact
    leaves in the fastest modes within a step or two.
    """
    sum5, sum3, worst, size, K, scales, y_new = 0.0, 0.0, 0.0, s.scales.shape[0], s.K, s.scales, s.y_new
    for m in range(size):
        scale = tolerance * (scales[m] + max(abs(y[m]), abs(y_new[m])))
        e5, e3 = _errors(K, m, scale)
        sum5 += e5 * e5
        sum3 += e3 * e3
    for m in range(size + FRICTION_LOSS, size + QUADRATURES):
        scale = tolerance * (s.tolerances.energy + abs(y_new[m]))
        if scale > 0.0:
            e5, e3 = _errors(K, m, scale)
            worst = max(worst, _combined(e5 * e5, e3 * e3, 1))
    return float(abs(h) * max(worst, _combined(sum5, sum3, size)))


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
def interpolant(y: Array, y_new: Array, h: float, K: Array, F: Array) -> None:
    """Dense-output coefficients (7, len(y)) of an accepted step with all 16 stages into F."""
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
