"""Axial flexibility behind the tangential rows of contacts: Jenkins's element.

A beam in a floating frame or in its transverse deflections does not stretch.  The static flexibility of its axis
between the root and a place x, f(x) = int_0^x ds/(E A), stands without mass behind Coulomb's slider there.  Forces
lambda_j along the axis move the material at x_i by

    sum_j F_ij lambda_j,    F_ij = f(min(x_i, x_j))

and friction sees the rate of Z_tau and of this.  While a contact sticks it is a spring of the stiffness E A/x
(Jenkins, J. Appl. Mech. 29, 1962).
"""

from __future__ import annotations

from collections.abc import Callable
from math import copysign
from typing import NamedTuple

import numpy as np

from oblique_impact.kernels.jit import jitable
from oblique_impact.kernels.workspace import Array


class AxialFlexibility(NamedTuple):
    """The axial flexibility of a beam, and how the tangents of n contacts point."""

    along: Array  # (2, k) places (m, ascending) and flexibility there (m/N), linear in between
    places: Array  # (n,) m along the beam, of points of the beam; NaN: an obstacle's point, at minus its slip
    senses: Array  # (n,) 1 of a tangent that points away from the root, -1 of one that points to it

    @property
    def compliant(self) -> bool:
        """Whether the axis is compliant."""
        return bool(self.along[1, -1] > 0.0)

    def of(self, contact: int) -> Callable[[float], float]:
        """Return the flexibility (m/N) behind the friction of a contact as a function of its slip (m).

        Its sign is the sense of the tangent.
        """
        return lambda slip: flexibility_at(self, contact, slip)

    @classmethod
    def none(cls, contacts: int) -> AxialFlexibility:
        """Return the axial flexibility of a beam that does not stretch: 0."""
        return cls(np.array([[0.0, 1.0], [0.0, 0.0]]), np.zeros(contacts), np.ones(contacts))


@jitable
def flexibility_at(axial: AxialFlexibility, i: int, slip: float) -> float:
    """Flexibility f(x) (m/N) where contact i is at its slip (m), with the sense of its tangent as its sign."""
    places, values = axial.along[0], axial.along[1]
    x = -slip if np.isnan(axial.places[i]) else axial.places[i]
    k = 1
    while k < places.shape[0] - 1 and places[k] < x:
        k += 1
    part = (min(max(x, 0.0), places[-1]) - places[k - 1]) / (places[k] - places[k - 1])
    return float(axial.senses[i] * (values[k - 1] + part * (values[k] - values[k - 1])))


@jitable
def shared_flexibility(a: float, b: float) -> float:
    """Displacement (m/N) along the tangent of one contact by a force along that of another, each with its f(x)."""
    return copysign(min(abs(a), abs(b)), a * b)
