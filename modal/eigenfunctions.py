"""Eigenfunctions of the uniform Euler-Bernoulli beam, evaluated stably for any order.

    clamped-free   cos b cosh b = -1   phi = cosh z - cos z - s (sinh z - sin z)
    hinged-free    tan b = tanh b      phi = sin z + (sin b / sinh b) sinh z            z = b x / L
    hub-free       the root turns with a hub of radius r and inertia J_h = h m L^3 about its axis,

        c^2 (sin b cosh b + cos b sinh b) + 2 c sin b sinh b + (sin b cosh b - cos b sinh b)
            + k (1 + cos b cosh b) = 0,    c = b r/L, k = h b^3 - s/b
        phi = r phi_x,    E I (phi_xx - r phi_xxx) = (k_r - omega^2 J_h) phi_x    at x = 0

                   and on a spring of k_r = s E I/L to the ground, without which it has a rigid mode besides

(Blevins, Formulas for Natural Frequency and Mode Shape, 1979.)  The first two are the limits of the third for
h or s = infinity and, with r = 0, for h = s = 0.  They are scaled to int phi^2 dx + (J_h/m) phi'(0)^2 = L, which
gives clamped-free and hinged-free ones |phi(L)| = 2, and signed so that phi(L) > 0.  The hyperbolic parts are
written with decaying exponentials only: the textbook differences of cosh and sinh lose all digits near order 12.
On a soft spring the first one is nearly rigid, and its small curvature is taken from power series.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import factorial
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Family = Literal["clamped-free", "hinged-free", "hub-free"]

_NEWTON_STEPS = 8
_BISECTIONS = 64  # of intervals of about pi: down to neighbouring numbers
_LOW = 1.0  # wave numbers below which power series keep digits that differences lose
_TERMS = 6  # of a series in z^4/4!, z <= _LOW: to 1e-18


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


def hub_free_roots(count: int, hub: float, radius: float = 0.0, spring: float = 0.0) -> Array:
    """First `count` positive roots b, shape (count,), for a hub of inertia `hub` m L^3 and radius `radius` L.

    With a `spring` of this times E I/L between hub and ground.  Clamping the root is one constraint, so each root
    lies between two neighbours of the clamped beam (Rayleigh), or, the first on a spring, below all of them.
    """
    clamped = clamped_free_roots(count + 1)
    edges, first = (np.append(0.0, clamped), 1.0) if spring > 0.0 else (clamped, -1.0)
    low, high = edges[:count], edges[1 : count + 1]
    above = np.where(np.arange(count) % 2 == 0, first, -first)  # sign of the equation's left side above each root
    for _ in range(_BISECTIONS):
        b = 0.5 * (low + high)
        c, cosine, sine, tanh, sech = radius * b, np.cos(b), np.sin(b), np.tanh(b), 1.0 / np.cosh(b)
        difference = np.where(b < _LOW, _sine_less_tanh(b) * sech, sine - cosine * tanh)
        value = c**2 * (sine + cosine * tanh) + 2.0 * c * sine * tanh + difference
        value += (hub * b**3 - spring / b) * (cosine + sech)
        is_above = value * above > 0.0
        low, high = np.where(is_above, low, b), np.where(is_above, b, high)
    return np.asarray(high)


def _sine_less_tanh(b: Array) -> Array:
    """Return sin b cosh b - cos b sinh b of b up to `_LOW`, whose fourth derivative is -4 times itself."""
    term = 2.0 / 3.0 * np.minimum(b, _LOW) ** 3
    total = term
    for k in range(3, 4 * _TERMS, 4):
        term = -4.0 * term * np.minimum(b, _LOW) ** 4 / ((k + 1) * (k + 2) * (k + 3) * (k + 4))
        total = total + term
    return np.asarray(total)


@dataclass(frozen=True)
class Eigenfunctions:
    """The first `count` eigenfunctions of a family on a beam of `length` (m).

    The hub-free family takes the inertia of the hub over m L^3, `hub`, its radius over L, `radius`, and the
    stiffness of a spring to the ground over E I/L, `spring`.
    """

    family: Family
    count: int
    length: float
    hub: float = 0.0
    radius: float = 0.0
    spring: float = 0.0

    @cached_property
    def roots(self) -> Array:
        """Dimensionless wave numbers b, shape (count,)."""
        if self.family == "hub-free":
            return hub_free_roots(self.count, self.hub, self.radius, self.spring)
        find = clamped_free_roots if self.family == "clamped-free" else hinged_free_roots
        return find(self.count)

    def derivative(self, x: Array, order: int) -> Array:
        """Return derivatives of the given order (0 to 3) at points x (m); shape (points, count), 1/m^order."""
        b = self.roots
        z = np.multiply.outer(np.asarray(x, dtype=float) / self.length, b)
        if self.family == "hub-free":
            shape = _hub_free(z, b, order, self.hub, self.radius, self.spring)
        else:
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


def _hub_free(z: Array, b: Array, order: int, hub: float, radius: float, spring: float) -> Array:
    """d^order phi / dz^order of phi = p cos z + q sin z + r exp(-z) + s exp(z - b), r = q + s exp(-b) - slope.

    The tip gives s, the root the others, all up to a factor, which makes the slope of the root 1/(1 + |k|): so the
    coefficients stay of order one from k = 0, free, to k = infinity, clamped.
    """
    c, k, decay, cosine, sine = radius * b, hub * b**3 - spring / b, np.exp(-b), np.cos(b), np.sin(b)
    slope = 1.0 / (1.0 + np.abs(k))
    held = 0.5 * k * slope
    q = (1.0 + c) * slope - held - decay * held * (cosine - sine)
    q = q / (1.0 + c + decay * (c * (cosine - sine) + cosine + sine))
    p = c * q + held
    s = 0.5 * (p * (cosine - sine) + q * (cosine + sine))
    tip = p * cosine + q * (sine + decay) + s * (1.0 + decay**2) - slope * decay
    third = slope - 2.0 * q
    cos_z, sin_z = np.cos(z), np.sin(z)
    even, odd = ((cos_z, sin_z), (-sin_z, cos_z), (-cos_z, -sin_z), (sin_z, -cos_z))[order]
    falling = np.exp(-z) if order % 2 == 0 else -np.exp(-z)
    # r is not added up: a heavy hub's slope is far smaller than the rounding of q and s, and counts by its inertia
    shape = p * even + q * (odd + falling) + s * (np.exp(z - b) + decay * falling) - slope * falling
    if b[0] < _LOW:  # the first one on a soft spring
        root = np.array([c[0] * slope[0], slope[0], -k[0] * slope[0], 0.0])  # phi and derivatives, but for c third
        at_end = np.stack([_rigid(b[:1], order) for order in range(4)])[:, 0]
        of_third = np.array([0.0, 0.0, c[0], 1.0])
        third[0] = -(at_end[3] @ root) / (at_end[3] @ of_third)
        root += third[0] * of_third
        tip[0], shape[..., 0] = at_end[0] @ root, _rigid(z[..., 0], order) @ root
    # as the fourth derivative of phi is phi, int phi^2 has a closed form in the values at the ends (Rayleigh)
    root_share = (3.0 * hub * b**3 + spring / b) * slope**2 - 2.0 * c * slope * third
    norm = np.sqrt(0.25 * (tip**2 + root_share / b))
    return np.asarray(shape * np.sign(tip) / norm)


def _rigid(z: Array, order: int) -> Array:
    """Return d^order/dz^order of the functions whose k-th derivative alone is 1 at 0, k = 0 to 3: (..., 4).

    They are their own fourth derivatives, (cosh z + cos z)/2 and its integrals, by power series for z up to 1.
    """
    total = np.zeros((*z.shape, 4))
    for k in range(4):
        for power in range((k - order) % 4, 4 * _TERMS, 4):
            total[..., k] += z**power / factorial(power)
    return total


def _cosine_derivative(z: Array, order: int) -> Array:
    """d^order cos(z) / dz^order."""
    return np.asarray(np.cos(z + 0.5 * np.pi * order))
