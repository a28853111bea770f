"""Elastic obstacles: where the beam touches them, and the forces of their springs and of Coulomb's friction.

In a plane a point of one body touches a side of the other:

`NodeOnSide`  a node of the beam, or a place in its section, on a straight side
`PointOnBeam`  a point fixed in space, a peg or a corner, at a place of the beam that slides along it
`ClosedContact` one that is closed, with its spring and its friction

Points are complex numbers here, x + i y (m), and so are vectors.  In absolute coordinates gap and slip are
components of a difference of places: nothing of the beam's shape enters.
"""

from __future__ import annotations

import cmath
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from oblique_impact.contact.stops import ElasticStop
from oblique_impact.fem_beam.exact.elastic_sections import Array
from oblique_impact.fem_beam.exact.exact_beam import NODE, Complex, ExactBeam, Stage, divided_difference

#: of half an element, the last step of the iterations for a place: a few units of rounding
_PLACED = 2e-15
#: of the length, a slide over which a difference of stiffnesses is mostly rounding
_HARDLY_SLID = 1e-9


class Place(NamedTuple):
    """A contact at an instant."""

    gap: float  # m
    slip: float  # m, along the side from its origin; of a point on the beam minus its place
    gap_rate: float  # m/s
    slip_rate: float  # m/s, of the material
    x: float  # m along the beam
    normal: complex  # direction of a normal force on the beam
    tangent: complex
    point: complex  # m, where the beam touches


# values at both ends of a step
Pair = tuple[float, float]


class Rows(NamedTuple):
    """A contact over a step from q0 to q1.

    Rows (3 n,) times q1 - q0 are the change of the gap and the displacement of the material along the tangent (m).
    """

    gaps: Pair  # m, at both ends
    slips: Pair  # m
    normal: Array
    tangential: Array


@dataclass(frozen=True)
class Touching(ABC):
    """Base of both kinds of contact."""

    beam: ExactBeam
    obstacle: int  # the slope is 0, the others count from 1
    law: ElasticStop
    extent: tuple[float, ...]  # m, ends of the slip

    def is_beyond(self, place: Place) -> bool:
        """Whether a place is beyond the ends."""
        return bool(self.extent) and not self.extent[0] <= place.slip <= self.extent[1]

    def inside(self, place: Place) -> float:
        """Return a length (m) that is positive between the ends, and falls through zero at each."""
        first, last = self.extent
        return (place.slip - first) * (last - place.slip) / (last - first)

    def force(self, place: Place) -> float:
        """Return the normal force (N) at an instant, of the spring at the depth and its damping, never pulling."""
        # at a release, the gap is zero but for rounding
        stiffness, _ = self.law.over(place.slip)
        elastic = stiffness * max(0.0, -place.gap) * max(0.0, 1.0 - self.law.damping * place.gap_rate)
        return max(0.0, elastic - self.law.linear_damping * place.gap_rate)

    @abstractmethod
    def place(self, stage: Stage) -> Place:
        """Return the contact at a state."""

    @abstractmethod
    def rows(self, q0: Array, q1: Array) -> Rows:
        """Return the contact over a step."""


@dataclass(frozen=True)
class NodeOnSide(Touching):
    """A point of the beam on a straight side, whose free side is on its left."""

    node: int
    angle: float  # rad, of the side
    offsets: tuple[float, float]  # m: height of the side above the root's axis, place of its origin along it
    fibre: float = 0.0  # e (m), place of the point in the section, across the beam
    outer: int = 1  # of the ends, the one that the beam points to

    @cached_property
    def tangent(self) -> complex:
        """Unit vector along the side; i times it points away from it."""
        return cmath.exp(1j * self.angle)

    def place(self, stage: Stage) -> Place:
        """Return the contact at a state."""
        (x, y, phi), (vx, vy, spin) = self._own(stage.q), self._own(stage.v)
        lever = 1j * self.fibre * cmath.exp(1j * phi)
        point, velocity = x + 1j * y + lever, vx + 1j * vy + 1j * spin * lever
        back, (height, along) = self.tangent.conjugate(), self.offsets
        moved, rate = back * point, back * velocity
        x = float(self.beam.x[self.node])
        kinematics = moved.imag - height, moved.real - along, rate.imag, rate.real
        return Place(*kinematics, x, 1j * self.tangent, self.tangent, point)

    def rows(self, q0: Array, q1: Array) -> Rows:
        """Return the contact over a step: the row of the rotation has a divided difference."""
        phi0, phi1 = self._own(q0)[2], self._own(q1)[2]
        turning = complex(self.tangent.conjugate() * 1j * self.fibre * divided_difference(phi0, phi1)[0])
        normal, tangential = np.zeros((2, self.beam.size))
        at = slice(NODE * self.node, NODE * (self.node + 1))
        normal[at] = -self.tangent.imag, self.tangent.real, turning.imag
        tangential[at] = self.tangent.real, self.tangent.imag, turning.real
        (gap0, slip0), (gap1, slip1) = self._gap_and_slip(q0), self._gap_and_slip(q1)
        return Rows((gap0, gap1), (slip0, slip1), normal, tangential)

    def _gap_and_slip(self, q: Array) -> tuple[float, float]:
        x, y, phi = self._own(q)
        moved = self.tangent.conjugate() * (x + 1j * y + 1j * self.fibre * cmath.exp(1j * phi))
        height, along = self.offsets
        return moved.imag - height, moved.real - along

    def _own(self, q: Array) -> list[float]:
        """Return the node's unknowns, or their rates."""
        found: list[float] = q[NODE * self.node : NODE * (self.node + 1)].tolist()
        return found


class _Found(NamedTuple):
    """The place of the beam whose section looks at a point."""

    first: int  # node of its element
    shapes: tuple[float, float, float]  # of the three nodes
    x: float  # m along the beam
    past: float  # m, how far x is past an end, from which the beam goes on straight and without strain
    turn: complex  # exp(i phi)
    strain: complex  # exp(-i phi) r', 1 without strain
    curvature: float  # 1/m
    height: float  # m, of the place above the point, to the left of the tangent


@dataclass(frozen=True)
class PointOnBeam(Touching):
    """A point c fixed in space, at the place x of the beam whose section looks at it.

    With the tangent t = exp(i phi) of the section and its normal n = i t,

        t . (r(x) - c) = 0,     gap = s n . (r(x) - c) - distance

    which is continuous where elements meet; the tangent of the axis is not.  s = 1 where the point is on the right
    of the beam, else -1.  With r' = exp(i phi) (1 + epsilon + i gamma) and the height h = n . (r - c)

        dgap = s [n . dr - gamma/F (t . dr + h dphi)],     F = 1 + epsilon + h phi'

    where dr and dphi are those at a fixed x: the force is normal to the axis and its line passes through c.
    """

    centre: complex  # c, m
    radius: float  # m, of a peg
    half_depth: float  # m, the lever of friction on the beam's face
    side: float  # s

    def place(self, stage: Stage) -> Place:
        """Return the contact at a state; the slip rate is that of the material."""
        at = self._find(stage.q)
        normal, tangential = self._local(at)
        v, gap = stage.v[NODE * at.first :][: 3 * NODE], self._gap(at)
        across = self._normal(at)
        point = self.centre + (gap + self.radius) * across
        return Place(gap, -at.x, float(normal @ v), float(tangential @ v), at.x, across, at.turn, point)

    def rows(self, q0: Array, q1: Array) -> Rows:
        """Return the contact over a step: the gradient of the gap at its middle, corrected along the step.

        This is Gonzalez's discrete gradient (2000): times q1 - q0 it is the change of the gap exactly.
        """
        start, end, middle = self._find(q0), self._find(q1), self._find(0.5 * (q0 + q1))
        normal, tangential = np.zeros((2, self.beam.size))
        at = slice(NODE * middle.first, NODE * (middle.first + 3))
        normal[at], tangential[at] = self._local(middle)
        gap0, gap1 = self._gap(start), self._gap(end)
        # all nodes whose elements the place has been in
        numbers = [found.first for found in (start, end, middle)]
        near = slice(NODE * min(numbers), NODE * (max(numbers) + 3))
        change = (q1 - q0)[near]
        along = change / self.beam.scale[near] ** 2
        square = float(change @ along)
        if square > 0.0:
            normal[near] += (gap1 - gap0 - normal[near] @ change) / square * along
        return Rows((gap0, gap1), (-start.x, -end.x), normal, tangential)

    def _gap(self, at: _Found) -> float:
        return self.side * at.height - self.radius - self.half_depth

    def _slant(self, at: _Found) -> float:
        """Return gamma/F."""
        return at.strain.imag / (at.strain.real + at.height * at.curvature)

    def _normal(self, at: _Found) -> complex:
        """Vector that the gap grows along."""
        return self.side * at.turn * (1j - self._slant(at))

    def _local(self, at: _Found) -> tuple[Array, Array]:
        """Return derivatives (9,) of the gap and of the material's place, along t, by the element's unknowns."""
        normal, slant = self._normal(at), self._slant(at)
        turning = self.side * (at.past - slant * at.height)
        gap = np.outer(at.shapes, (normal.real, normal.imag, turning)).ravel()
        slip = np.outer(at.shapes, (at.turn.real, at.turn.imag, self.side * self.half_depth)).ravel()
        return gap, slip

    def _find(self, q: Array) -> _Found:
        """Return the place where t . (r - c) rises through zero, the nearest to the point if there are more."""
        x, y, phi = q.reshape(-1, NODE).T
        r, last = x + 1j * y - self.centre, x.size - 1
        ahead = np.cos(phi) * r.real + np.sin(phi) * r.imag
        (rising,) = np.nonzero((ahead[:-1] <= 0.0) & (ahead[1:] > 0.0))
        if rising.size == 0:
            return self._past(last if ahead[last] <= 0.0 else 0, r, ahead, phi)
        k = int(rising[np.argmin(np.abs(r[rising]))])
        first = k - k % 2
        (a, b, c), (p, o, u) = r[first : first + 3].tolist(), phi[first : first + 3].tolist()
        # z goes from -1 to 1 in the element; quadratic in it, r = b + z (r1 + z r2)
        r1, r2, p1, p2 = 0.5 * (c - a), 0.5 * (a + c) - b, 0.5 * (u - p), 0.5 * (p + u) - o
        low, high = (-1.0, 0.0) if k == first else (0.0, 1.0)
        z, before, placed = low + float(ahead[k] / (ahead[k] - ahead[k + 1])), 2.0, False
        while True:
            turn = cmath.exp(1j * (o + z * (p1 + z * p2)))
            across = (b + z * (r1 + z * r2)) * turn.conjugate()
            tangent = (r1 + 2.0 * z * r2) * turn.conjugate()
            bent = p1 + 2.0 * z * p2
            if across.real > 0.0:
                high = z
            else:
                low = z
            if placed:
                break
            growth = tangent.real + across.imag * bent
            step = -across.real / growth if growth > 0.0 else np.inf
            # where a step has not halved the last one, or leads out of the part that holds the place, this is
            # halved: so one of both is rounding in the end, mostly after four steps
            if not (abs(step) <= 0.5 * before and low <= z + step <= high):
                step = 0.5 * (low + high) - z
            z, before, placed = z + step, abs(step), abs(step) <= _PLACED
        half = 0.5 * float(self.beam.x[first + 2] - self.beam.x[first])
        shapes = 0.5 * z * (z - 1.0), 1.0 - z * z, 0.5 * z * (z + 1.0)
        place = float(self.beam.x[first + 1]) + z * half
        return _Found(first, shapes, place, 0.0, turn, tangent / half, bent / half, across.imag)

    def _past(self, node: int, r: Complex, ahead: Array, phi: Array) -> _Found:
        """Return the place past an end of the beam."""
        turn, past = cmath.exp(1j * float(phi[node])), -float(ahead[node])
        height = float((turn.conjugate() * r[node]).imag)
        first, shapes = (node - 2, (0.0, 0.0, 1.0)) if node else (0, (1.0, 0.0, 0.0))
        return _Found(first, shapes, float(self.beam.x[node]) + past, past, turn, 1.0 + 0j, 0.0, height)


@dataclass(frozen=True)
class ClosedContact:
    """A closed contact within a step: spring and friction, the latter none where the point sticks.

    Friction is (intercept + slope v) times the normal force at the mean slip velocity v of the material.
    The spring is k(s) at the slip s, which changes where the beam slides over the end of a bedding.  With means of
    both ends of a step its force k d at the mean depth d, and Dk/Ds d^2/2 against the slide, do work that is the
    change of the energy k d^2/2 exactly (a discrete gradient).
    """

    touching: Touching
    intercept: float = 0.0
    slope: float = 0.0  # s/m
    sticks: bool = False

    def friction(self, slip_rate: float) -> float:
        """Return lambda_tau/lambda_n at a slip velocity (m/s)."""
        return self.intercept + self.slope * slip_rate

    def normal_force(self, gaps: Pair, slips: Pair, length: float) -> tuple[float, float]:
        """Mean normal force (N) of a step between gaps and slips (m), and its derivative by the last gap (N/m)."""
        (gap0, gap1), k, law = gaps, self._stiffness(slips), self.touching.law
        depth, rate = -0.5 * (gap0 + gap1), (gap0 - gap1) / length
        factor, slope = 1.0 + law.damping * rate, -law.damping / length
        if factor <= 0.0:
            factor, slope = 0.0, 0.0
        force = k * depth * factor + law.linear_damping * rate
        if force <= 0.0:
            return 0.0, 0.0
        return force, -0.5 * k * factor + k * depth * slope - law.linear_damping / length

    def end_push(self, gaps: Pair, slips: Pair) -> float:
        """Mean force (N) of a step along the slide, of a bedding under a place that lies over an end of it."""
        (k0, slope0), (k1, slope1) = (self.touching.law.over(slip) for slip in slips)
        slope, slid = 0.5 * (slope0 + slope1), slips[1] - slips[0]
        if slope0 != slope1 and abs(slid) > _HARDLY_SLID * self.touching.beam.x[-1]:
            slope = (k1 - k0) / slid
        return -0.25 * slope * (gaps[0] ** 2 + gaps[1] ** 2)

    def gained(self, q0: Array, q1: Array, reaction: float, length: float) -> tuple[float, float, float, float]:
        """Impulses (N s), and losses by friction and the stop's damping (J), of a step from q0 to q1 (3 n,).

        `reaction` (N) is the force that keeps the point where it is if it sticks.
        """
        rows = self.touching.rows(q0, q1)
        gaps, slips = rows.gaps, rows.slips
        force, _ = self.normal_force(gaps, slips, length)
        slid = float(rows.tangential @ (q1 - q0))
        tangential = reaction if self.sticks else self.friction(slid / length) * force
        elastic = -0.5 * self._stiffness(slips) * (gaps[0] + gaps[1])
        stop = (force - elastic) * (gaps[0] - gaps[1])
        return force * length, tangential * length, -tangential * slid, stop

    def _stiffness(self, slips: Pair) -> float:
        """Mean stiffness (N/m) of a step between two slips (m)."""
        first, last = (self.touching.law.over(slip)[0] for slip in slips)
        return 0.5 * (first + last)
