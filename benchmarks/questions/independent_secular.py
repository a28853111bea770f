"""Frequencies of a clamped strip from its solution in closed form, piece by piece, in NumPy and SciPy alone.

Nothing of the program is used.  Over a piece the deflection is a sum of cos, sin, cosh and sinh; what sits at its
end, a mass, a support that yields or not, is a jump of shear and moment there.  The determinant of what is asked
at the tip vanishes at a frequency, a complex one with a dashpot in the clamp.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, newton


@dataclass(frozen=True)
class Piece:
    """A piece of a strip of unit length, bending stiffness and mass, and what sits at its end."""

    length: float
    mass: float = 0.0
    spring: float = 0.0  # against deflection
    turn: float = 0.0  # against rotation


def _over(z: complex, x: float) -> np.ndarray:
    """Return deflection, slope, moment and shear at x for each of them at 0 (Krylov's functions)."""
    c, s, ch, sh = np.cos(z * x), np.sin(z * x), np.cosh(z * x), np.sinh(z * x)
    a, b, d, e = 0.5 * (ch + c), 0.5 * (sh + s) / z, 0.5 * (ch - c) / z**2, 0.5 * (sh - s) / z**3
    w = z**4
    return np.array([[a, b, d, e], [w * e, a, b, d], [w * d, w * e, a, b], [w * b, w * d, w * e, a]])


def determinant(z: complex, pieces: Sequence[Piece], clamp: complex = np.inf) -> complex:
    """Return the determinant of moment and shear at the tip, at z^2, on a clamp (moment per turn)."""
    turns = np.array([0.0, 0.0, 1.0, 0.0]) if np.isinf(clamp) else np.array([0.0, 1.0, clamp, 0.0])
    states = np.stack([turns, [0.0, 0.0, 0.0, 1.0]], axis=1)
    for piece in pieces:
        states = _over(z, piece.length) @ states
        states[3] += (z**4 * piece.mass - piece.spring) * states[0]
        states[2] += piece.turn * states[1]
    return complex(np.linalg.det(states[2:]))


def roots(pieces: Sequence[Piece], count: int, clamp: float = np.inf) -> np.ndarray:
    """Return the lowest frequencies z^2, in units of sqrt(EI/m)/L^2, without damping."""

    def real(z: float) -> float:
        return determinant(z, pieces, clamp).real

    found, z, step = list[float](), 0.05, 0.01
    while len(found) < count:
        if real(z) * real(z + step) < 0.0:
            found.append(brentq(real, z, z + step, xtol=1e-14))
        z += step
    return np.array(found) ** 2


def decay(clamp: float, dashpot: float) -> tuple[float, float]:
    """Return frequency and damping ratio of the first vibration on a clamp with a dashpot, all in those units."""
    z = complex(roots([Piece(1.0)], 1, clamp)[0]) ** 0.5
    for part in np.geomspace(1e-3, 1.0, 80):

        def at(z: complex, part: float = part) -> complex:
            return determinant(z, [Piece(1.0)], clamp + 1j * z * z * part * dashpot)

        z = complex(newton(at, z, tol=1e-13, maxiter=200))
    rate = 1j * z * z
    return abs(rate), -rate.real / abs(rate)
