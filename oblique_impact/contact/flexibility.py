"""Flexibility behind contact rows: what the coordinates leave out of the beam, without mass.

Forces s (n,) at n places, all across the beam or all along it, move the material there by z = G s.

Across it G is what the modes above the last one deflect, between places without inertia.

Along it G_ij = f(min(x_i, x_j)) with the static flexibility f(x) = int_0^x ds/(E A) of the axis between root and
place, because a beam in a floating frame or in its transverse deflections does not stretch.  Friction sees the
rate of Z_tau and of z; a contact that sticks is a spring of stiffness E A/x (Jenkins, J. Appl. Mech. 29, 1962).

With the viscosity eta over the stiffness the contact forces f are s + eta s' (one place:
`oblique_impact.contact.state.Residual`), which over a time step from s0 to s1, with the mean force f, is

    a s1 + (1 - a) s0 = f,    a = max(1/2 + eta/h, 1)

the mid-point rule where the step resolves the relaxation, and else s1 = f.  Of the work f.(z1 - z0) of a step
s.G s/2 is held, eta/h (s1 - s0).(z1 - z0) is the damping's and the rest the scheme's.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from oblique_impact.contact.state import Contacts
from oblique_impact.kernels.jit import inlined, jitable
from oblique_impact.kernels.workspace import Array

_NOTHING = 1e-30  # N: what has relaxed to less is zero, so that no step computes with subnormal numbers
_SLIP = 1


class Flexibility(NamedTuple):
    """Flexibility between n places, all across the beam or all along it, and their displacements in a run."""

    toward: Array  # (n, 2) derivatives of gap and slip by the displacement z
    # across the beam
    matrix: Array  # (n, n) G (m/N); (0, 0): along it
    viscosity: float  # eta (s)
    angles: Array  # (n,) rad, of sides
    facing: Array  # (n,) side of an obstacle point on which the beam is, see `oblique_impact.beam.axis.Peg`; or 0
    # along the beam
    table: Array  # (2, k) places (m, ascending) and f there (m/N), linear in between
    places: Array  # (n,) m along the beam, of points of the beam; NaN: an obstacle's point, at minus its slip
    reach: Array  # (n,) f (m/N) where the places are
    # state
    pressed: Array  # (n,) N, s at the start of a step
    after: Array  # (n,) N, at its end
    displaced: Array  # (n,) m, z at the start of a step
    moved: Array  # (n,) m, z1 - z0

    @classmethod
    def across(cls, matrix: Array, viscosity: float, angles: Array, facing: Array) -> Flexibility:
        """Return the flexibility of n places across the beam, at rest."""
        n, none = len(angles), np.zeros(0)
        rest = (np.zeros(n) for _ in range(4))
        numbers = np.ascontiguousarray(matrix), viscosity, angles.copy(), facing
        return cls(np.zeros((n, 2)), *numbers, np.zeros((2, 0)), none, none, *rest)

    @classmethod
    def along(cls, table: Array, places: Array, senses: Array) -> Flexibility:
        """Return the flexibility of n places along the beam, at rest.

        `senses` (n,) are 1 where the tangent points away from the root, -1 where it points towards it.
        """
        n, none = len(places), np.zeros(0)
        rest = (np.zeros(n) for _ in range(5))
        toward = np.stack([np.zeros(n), senses], axis=1)
        return cls(toward, np.zeros((0, 0)), 0.0, none, none, table, places, *rest)

    @classmethod
    def none(cls) -> Flexibility:
        """Return the flexibility of no place."""
        return cls.across(np.zeros((0, 0)), 0.0, np.zeros(0), np.zeros(0))

    def at_rest(self) -> Flexibility:
        """Return a copy for a run."""
        own = ("toward", "reach", "pressed", "after", "displaced", "moved")
        return self._replace(**{name: getattr(self, name).copy() for name in own})

    def behind(self, contact: int) -> Callable[[float], tuple[float, float]]:
        """Return the axial flexibility (m/N) of a contact and the sense of its tangent over its slip."""
        return lambda slip: (reach_at(self, contact, slip), float(self.toward[contact, _SLIP]))


@jitable
def reach_at(y: Flexibility, i: int, slip: float) -> float:
    """Axial flexibility f(x) (m/N) where contact i is at its slip (m)."""
    places, values = y.table[0], y.table[1]
    x = -slip if np.isnan(y.places[i]) else y.places[i]
    k = 1
    while k < places.shape[0] - 1 and places[k] < x:
        k += 1
    part = (min(max(x, 0.0), places[-1]) - places[k - 1]) / (places[k] - places[k - 1])
    return float(values[k - 1] + part * (values[k] - values[k - 1]))


@inlined
def weight_of_end(y: Flexibility, h: float) -> float:
    """Return a, the weight of the end of a step of length h (s)."""
    return max(0.5 + y.viscosity / h, 1.0)


@inlined
def _between(y: Flexibility, i: int, j: int) -> float:
    """Return G_ij (m/N)."""
    if y.matrix.shape[0] > 0:
        return float(y.matrix[i, j])
    return float(min(y.reach[i], y.reach[j]))


@inlined
def yielding_between(y: Flexibility, h: float, i: int, a: int, j: int, b: int) -> float:
    """Return the gap (a = 0) or slip (1) at place i by a unit impulse (m/N s) on gap or slip of j over a step."""
    return float(y.toward[i, a] * y.toward[j, b] * _between(y, i, j) / (weight_of_end(y, h) * h))


@jitable
def take_places(y: Flexibility, theta: float, contacts: Contacts) -> None:
    """Take the directions across the beam at the angle theta of the frame, or the places along it.

    Obstacle points turn with the frame, and slide along the beam by their slips.
    """
    for i in range(y.pressed.shape[0]):
        if y.matrix.shape[0] == 0:
            y.reach[i] = reach_at(y, i, contacts.each[i].slip)
        elif y.facing[i] != 0.0:
            y.toward[i, 0], y.toward[i, 1] = y.facing[i], 0.0
        else:
            y.toward[i, 0], y.toward[i, 1] = np.cos(theta - y.angles[i]), -np.sin(theta - y.angles[i])


@jitable
def push_places(y: Flexibility, h: float, impulses: Array, closed: NDArray[np.int64], m: int) -> None:
    """Take the displacements over a step with the impulses (2 m,), N s, of the m `closed` places."""
    a, n = weight_of_end(y, h), y.pressed.shape[0]
    for i in range(n):
        y.after[i], y.moved[i] = (a - 1.0) / a * y.pressed[i], 0.0
    for k in range(m if n > 0 else 0):
        i = closed[k]
        force = y.toward[i, 0] * impulses[2 * k] + y.toward[i, 1] * impulses[2 * k + 1]
        y.after[i] += force / (a * h)
    for j in range(n):
        change = y.after[j] - y.pressed[j]
        if change != 0.0:
            for i in range(n):
                y.moved[i] += _between(y, j, i) * change


@jitable
def end_step(y: Flexibility, h: float) -> tuple[float, float]:
    """Begin the next step; returns the energies (J) that damping and scheme took in the last one."""
    n, change, given, held = y.pressed.shape[0], 0.0, 0.0, 0.0
    for i in range(n):
        change += (y.after[i] - y.pressed[i]) * y.moved[i]
        given += y.after[i] * y.moved[i]
        held -= 0.5 * y.pressed[i] * y.displaced[i]
        y.pressed[i], y.displaced[i] = y.after[i] if abs(y.after[i]) > _NOTHING else 0.0, 0.0
    for j in range(n):
        if y.pressed[j] != 0.0:
            for i in range(n):
                y.displaced[i] += _between(y, j, i) * y.pressed[j]
    for i in range(n):
        held += 0.5 * y.pressed[i] * y.displaced[i]
    damping = y.viscosity / h * change
    return damping, given + (weight_of_end(y, h) - 1.0) * change - damping - held
