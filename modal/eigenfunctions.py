"""Eigenfunctions of the uniform Euler-Bernoulli beam, evaluated stably for any order.

    clamped-free   cos b cosh b = -1   phi = cosh z - cos z - s (sinh z - sin z)
    hinged-free    tan b = tanh b      phi = sin z + (sin b / sinh b) sinh z            z = b x / L

(Blevins, Formulas for Natural Frequency and Mode Shape, 1979.)  They are scaled to
int phi^2 dx = L, which gives both families |phi(L)| = 2, and signed so that phi(L) = +2.  The
hyperbolic parts are written with decaying exponentials only: the textbook differences of cosh and
sinh lose all digits near order 12.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Family = Literal["clamped-free", "hinged-free"]

_NEWTON_STEPS = 8


def clamped_free_roots(count: int) -> Array:
    """First `count` roots b of cos b cosh b = -1, shape (count,)."""
    b = (np.arange(1, count + 1) - 0.5) * np.pi
    b[:1] = 1.875
    for _ in range(_NEWTON_STEPS):
        sech = 2.0 * np.exp(-b) / (1.0 + np.exp(-2.0 * b))
        b = b - (np.cos(b) + sech) / (-np.sin(b) - sech * np.tanh(b))
    return np.asarray(b)


def hinged_free_roots(count: int) -> Array:
    """First `count` positive roots b of tan b = tanh b, shape (count,); the rigid root 0 is left out."""
    b = (np.arange(1, count + 1) + 0.25) * np.pi
    for _ in range(_NEWTON_STEPS):
        # sin b - cos b tanh b = 0 has no poles
        tanh = np.tanh(b)
        b = b - (np.sin(b) - np.cos(b) * tanh) / (np.cos(b) + np.sin(b) * tanh - np.cos(b) * (1 - tanh**2))
    return np.asarray(b)


@dataclass(frozen=True)
class Eigenfunctions:
    """The first `count` eigenfunctions of a family on a beam of `length` (m)."""

    family: Family
    count: int
    length: float

    @property
    def roots(self) -> Array:
        """Dimensionless wave numbers b, shape (count,)."""
        find = clamped_free_roots if self.family == "clamped-free" else hinged_free_roots
        return find(self.count)

    def derivative(self, x: Array, order: int) -> Array:
        """Return derivatives of the given order (0 to 3) at points x (m); shape (points, count), 1/m^order."""
        b = self.roots
        z = np.multiply.outer(np.asarray(x, dtype=float) / self.length, b)
        shape = _clamped_free(z, b, order) if self.family == "clamped-free" else _hinged_free(z, b, order)
        return np.asarray(shape * (b / self.length) ** order)


def _clamped_free(z: Array, b: Array, order: int) -> Array:
    """d^order phi / dz^order; cosh z - s sinh z = exp(-z) + (1 - s) sinh z with 1 - s in closed form."""
    decay = np.exp(-b)
    denominator = 1.0 - decay**2 + 2.0 * decay * np.sin(b)  # 2 exp(-b) (sinh b + sin b)
    s = (1.0 + decay**2 + 2.0 * decay * np.cos(b)) / denominator
    numerator = np.sin(b) - np.cos(b) - decay
    even = 1 if order % 2 == 0 else -1
    growing = numerator / denominator * np.exp(z - b) * (1.0 - even * np.exp(-2.0 * z))
    hyperbolic = even * np.exp(-z) + growing
    trigonometric = -_cosine_derivative(z, order) + s * _cosine_derivative(z - 0.5 * np.pi, order)
    sign = np.where(np.arange(b.size) % 2 == 0, 1.0, -1.0)
    return np.asarray(sign * (hyperbolic + trigonometric))


def _hinged_free(z: Array, b: Array, order: int) -> Array:
    """d^order phi / dz^order with sinh z / sinh b as decaying exponentials."""
    even = 1 if order % 2 == 0 else -1
    hyperbolic = np.exp(z - b) * (1.0 - even * np.exp(-2.0 * z)) / (1.0 - np.exp(-2.0 * b))
    sine = np.sin(b)
    shape = _cosine_derivative(z - 0.5 * np.pi, order) / sine + hyperbolic
    # phi / sin b has the end value 2 and, by phi(L)^2 L / 4 = int phi^2 dx, the norm L
    return np.asarray(shape)


def _cosine_derivative(z: Array, order: int) -> Array:
    """d^order cos(z) / dz^order."""
    return np.asarray(np.cos(z + 0.5 * np.pi * order))
